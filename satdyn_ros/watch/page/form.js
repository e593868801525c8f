'use strict';
// The form of new initial conditions: the node's keys with the values in force, in the units of the
// trade; what each is in SI is its title.

class StartForm {
  // ask(values) resolves to the node's answer {success, text}.
  constructor(ask, done) {
    const find = (id) => document.getElementById(id);
    [this.dialog, this.fields, this.refusal, this.send] = ['start', 'fields', 'refusal', 'send'].map(find);
    this.angles = ['roll', 'pitch', 'yaw'].map(find);
    Object.assign(this, { ask, done });
    this.angles.forEach((input) => input.addEventListener('input', () => this._fromAngles()));
    find('cancel').addEventListener('click', () => this.dialog.close());
    this.dialog.querySelector('form').addEventListener('submit', (event) => { event.preventDefault(); this._submit(); });
  }

  // values: the initial conditions in force, by the keys of the scenario.
  open(values) {
    this.values = values;
    this.refusal.textContent = '';
    // The angles stand above; whoever wants the quaternion finds it at the end.
    const names = Object.keys(values).sort((a, b) => a.endsWith('.attitude') - b.endsWith('.attitude'));
    this.inputs = new Map(names.map((name) => [name, this._field(name)]));
    // By their names the values that the texts stand for: a text has fewer digits.
    this.exact = new Map();
    names.forEach((name) => this._set(name, values[name]));
    this.fields.replaceChildren(...[...this.inputs.values()].map((input) => input.parentElement));
    this._showAngles();
    this.inputs.get('initial.attitude')?.addEventListener('input', () => this._showAngles());
    this.dialog.showModal();
  }

  _field(name) {
    const label = document.createElement('label');
    label.append(`${name}${StartForm.UNITS[name.split('.').pop()] ?? ''}`);
    const input = document.createElement(name === 'initial.frame' ? 'select' : 'input');
    if (input.tagName === 'SELECT') ['inertial', 'lvlh'].forEach((frame) => input.add(new Option(frame, frame)));
    else Object.assign(input, { type: 'text', spellcheck: false, autocomplete: 'off' });
    input.name = name;
    input.addEventListener('input', () => this._showSi(name));
    label.append(input);
    return input;
  }

  _set(name, value) {
    const text = StartForm.text(name, value);
    this.inputs.get(name).value = text;
    this.exact.set(name, { text, value });
    this._showSi(name);
  }

  _showSi(name) {
    const unit = StartForm.SI[name.split('.').pop()];
    const value = unit && [this._value(name)].flat();
    const isNumber = value?.length && value.every(Number.isFinite);
    this.inputs.get(name).title = isNumber ? `${value.map((x) => Number(x.toPrecision(6))).join(', ')} ${unit}` : '';
  }

  _value(name) {
    const { text, value } = this.exact.get(name);
    const now = this.inputs.get(name).value;
    return now.trim() === text ? value : StartForm.value(name, now, this.values[name]);
  }

  // Numbers are sent as numbers; anything else is sent as typed, and the node says what is allowed.
  async _submit() {
    const given = [...this.inputs.keys()].map((name) => [name, this._value(name)]);
    const changed = given.filter(([name, value]) => String(value) !== String(this.values[name]));
    // Nothing changed: restart with the same values.
    const values = Object.fromEntries(changed.length ? changed : given.filter(([name]) => name === 'initial.attitude'));
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
    if (angles.every(Number.isFinite)) this._set('initial.attitude', StartForm.quaternion(...angles));
  }

  _showAngles() {
    const q = this._value('initial.attitude');
    const isOne = Array.isArray(q) && q.length === 4 && q.every(Number.isFinite);
    if (!isOne || this.angles.includes(document.activeElement)) return;
    Rotation.rollPitchYaw(q).forEach((angle, k) => { this.angles[k].value = String(Number(((angle * 180) / Math.PI).toFixed(4))); });
  }

  static quaternion(roll, pitch, yaw) {
    const about = (axis, angle) => [...[0, 1, 2].map((k) => (k === axis ? Math.sin(angle / 2) : 0)), Math.cos(angle / 2)];
    return Rotation.multiply(about(2, yaw), Rotation.multiply(about(1, pitch), about(0, roll)));
  }

  static scale(name) {
    if (name === 'initial.angular_velocity') return 180 / Math.PI;
    return name.endsWith('.speed') ? 30 / Math.PI : 1;
  }

  static text(name, value) {
    const digits = name === 'initial.attitude' ? (x) => String(Number(x.toFixed(6))) : (x) => String(Number((x * StartForm.scale(name)).toPrecision(9)));
    return Array.isArray(value) ? value.map(digits).join(', ') : typeof value === 'number' ? digits(value) : String(value);
  }

  static value(name, text, before) {
    const numbers = text.split(/[\s,;]+/).filter(Boolean).map(Number);
    if (!numbers.length || !numbers.every(Number.isFinite)) return text;
    const values = numbers.map((x) => x / StartForm.scale(name));
    return Array.isArray(before) || values.length > 1 ? values : values[0];
  }
}

StartForm.UNITS = { attitude: ' (x, y, z, w)', angular_velocity: ' [deg/s]', momentum: ' [N m s]', speed: ' [rpm]' };
StartForm.SI = { angular_velocity: 'rad/s', momentum: 'N m s', speed: 'rad/s' };
