'use strict';
// The form of new initial conditions: the node's keys with the values in force.

class StartForm {
  // ask(values) resolves to the node's answer {success, text}.
  constructor(ask, done) {
    const find = (id) => document.getElementById(id);
    [this.dialog, this.fields, this.refusal, this.send] = ['start', 'fields', 'refusal', 'send'].map(find);
    this.angles = ['roll', 'pitch', 'yaw'].map(find);
    this.inputs = new Map();
    Object.assign(this, { ask, done });
    this.angles.forEach((input) => input.addEventListener('input', () => this._fromAngles()));
    find('cancel').addEventListener('click', () => this.dialog.close());
    this.dialog.querySelector('form').addEventListener('submit', (event) => { event.preventDefault(); this._submit(); });
  }

  // values: the initial conditions in force, by the keys of the scenario.
  open(values) {
    this.values = values;
    this.refusal.textContent = '';
    this.inputs = new Map(Object.keys(values).map((name) => [name, this._field(name, values[name])]));
    this.fields.replaceChildren(...[...this.inputs.values()].map((input) => input.parentElement));
    this._showAngles();
    this.inputs.get('initial.attitude')?.addEventListener('input', () => this._showAngles());
    this.dialog.showModal();
  }

  _field(name, value) {
    const label = document.createElement('label');
    label.append(`${name}${StartForm.UNITS[name.split('.').pop()] ?? ''}`);
    const input = document.createElement(name === 'initial.frame' ? 'select' : 'input');
    if (input.tagName === 'SELECT') ['inertial', 'lvlh'].forEach((frame) => input.add(new Option(frame, frame)));
    else Object.assign(input, { type: 'text', spellcheck: false, autocomplete: 'off' });
    input.name = name;
    input.value = StartForm.text(value);
    label.append(input);
    return input;
  }

  // Numbers are sent as numbers; anything else is sent as typed, and the node says what is allowed.
  async _submit() {
    const changed = [...this.inputs].filter(([name, input]) => input.value.trim() !== StartForm.text(this.values[name]));
    // Nothing changed: restart with the same values.
    const given = changed.length ? changed : [...this.inputs].filter(([name]) => name === 'initial.attitude');
    const values = Object.fromEntries(given.map(([name, input]) => [name, StartForm.value(input.value, this.values[name])]));
    this.send.disabled = true;
    const answer = await this.ask(values);
    this.send.disabled = false;
    this.refusal.textContent = answer.success ? '' : answer.text;
    if (!answer.success) return;
    this.dialog.close();
    this.done(`restarted with ${Object.keys(values).join(', ')}`);
  }

  _fromAngles() {
    const angles = this.angles.map(({ value }) => (Number(value) * Math.PI) / 180);
    if (angles.every(Number.isFinite)) this.inputs.get('initial.attitude').value = StartForm.text(StartForm.quaternion(...angles));
  }

  _showAngles() {
    const q = StartForm.value(this.inputs.get('initial.attitude').value, []);
    const isOne = Array.isArray(q) && q.length === 4 && q.every(Number.isFinite);
    if (!isOne || this.angles.includes(document.activeElement)) return;
    Rotation.rollPitchYaw(q).forEach((angle, k) => { this.angles[k].value = String(Number(((angle * 180) / Math.PI).toFixed(4))); });
  }

  static quaternion(roll, pitch, yaw) {
    const about = (axis, angle) => [...[0, 1, 2].map((k) => (k === axis ? Math.sin(angle / 2) : 0)), Math.cos(angle / 2)];
    return Rotation.multiply(about(2, yaw), Rotation.multiply(about(1, pitch), about(0, roll)));
  }

  static text(value) { return Array.isArray(value) ? value.join(', ') : String(value); }

  static value(text, before) {
    const numbers = text.split(/[\s,;]+/).filter(Boolean).map(Number);
    if (!numbers.length || !numbers.every(Number.isFinite)) return text;
    return Array.isArray(before) || numbers.length > 1 ? numbers : numbers[0];
  }
}

StartForm.UNITS = { attitude: ' (x, y, z, w)', angular_velocity: ' [rad/s]', momentum: ' [N m s]', speed: ' [rad/s]' };
