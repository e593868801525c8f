'use strict';
// The scene with its controls: the view, the paths, and a notice of what cannot be shown.

const VIEWS = { orbit: 'Orbit', body: 'Body', space: 'Space' };
const SWITCHES = {
  axis: ['axis path', 'path of the axis', '--axis-path'],
  polhode: ['polhode', 'path of the rate in the body', '--polhode'],
  herpolhode: ['herpolhode', 'path of the rate in space', '--herpolhode'],
  arrows: ['ω, H, torque', 'arrows of rate, momentum and torque', '--rate'],
  surroundings: ['Sun, B', 'arrows to the Sun and along the magnetic field', '--sun'],
};

class Stage {
  constructor(box) {
    this.box = box;
    box.classList.add('stage');
    this.sceneBox = Stage.made('div', 'scene');
    this.sceneBox.setAttribute('role', 'img');
    this.notice = Stage.made('p', 'notice');
    this.notice.setAttribute('role', 'status');
    box.append(this.sceneBox, this.notice);
    this.ground = new Ground();
    box.after(this.ground.box);
    try {
      this.scene = new Scene(this.sceneBox);
    } catch (error) {
      this.sceneBox.classList.add('missing');
      this.say('This browser has no WebGL, which the 3-D view needs. The charts show the same run.');
      return;
    }
    this._addViews();
    this._addSwitches();
  }

  describe(description) {
    const earth = description.earth && new Earth(description.earth);
    this.ground.describe(earth);
    if (!this.scene) return;
    this.scene.keepOff(earth ? [this.ground.box, this.switches] : []);
    this.scene.describe(description, earth);
    const hasSurroundings = earth || description.panels.some(({ name }) => name === 'sun_direction' || name === 'magnetic_field');
    if (hasSurroundings) this.switches.append(this.surroundingsSwitch);
    else this.surroundingsSwitch.remove();
    this.views.orbit.disabled = !description.has_lvlh;
    this.views.orbit.title = description.has_lvlh ? '' : 'there is no orbit';
    const names = description.rotors.map(({ name }) => name).join(', ');
    this.sceneBox.setAttribute('aria-label', `the satellite in 3-D${names ? `, with ${names}` : ''}`);
    this._press(this.scene.view);
  }

  // Show nothing until the next row.
  clear() {
    this.ground.clear();
    this.scene?.clear();
  }

  show(row, rows, factor) {
    this.ground.show(row, rows);
    this.scene?.show(row, rows, factor);
  }

  say(text) {
    this.notice.textContent = text;
    this.notice.hidden = !text;
  }

  _press(view) {
    for (const [name, button] of Object.entries(this.views)) button.setAttribute('aria-pressed', name === view);
  }

  _addViews() {
    const group = Stage.made('div', 'views');
    group.setAttribute('role', 'group');
    group.setAttribute('aria-label', 'view');
    this.views = {};
    for (const [name, text] of Object.entries(VIEWS)) {
      const button = Stage.made('button', '', text);
      button.type = 'button';
      button.dataset.view = name;
      button.addEventListener('click', () => { this.scene.setView(name); this._press(name); });
      this.views[name] = button;
      group.append(button);
    }
    this.box.append(group);
  }

  _addSwitches() {
    const group = this.switches = Stage.made('fieldset', 'switches');
    group.append(Stage.made('legend', 'unseen', 'show'));
    for (const [name, [text, meaning, colour]] of Object.entries(SWITCHES)) {
      const label = Stage.made('label');
      label.title = meaning;
      label.style.setProperty('--colour', `var(${colour})`);
      const input = Stage.made('input');
      Object.assign(input, { type: 'checkbox', checked: this.scene.shown[name], name });
      input.addEventListener('change', () => this.scene.toggle(name, input.checked));
      label.append(input, Stage.made('span', '', text));
      if (name === 'surroundings') this.surroundingsSwitch = label; // only where there is what it shows
      else group.append(label);
    }
    this.box.append(group);
  }

  static made(tag, kind = '', text = '') {
    const element = document.createElement(tag);
    if (kind) element.className = kind;
    if (text) element.textContent = text;
    return element;
  }
}
