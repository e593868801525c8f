'use strict';
// All satellites: a list of them beside a globe; a click on one shows it.

const LARGEST_SPREAD = 600; // [s]; in more the Earth turns by what can be seen

class Fleet {
  // tellChosen(name) shows a satellite.
  constructor(box, list, tellChosen) {
    Object.assign(this, { list, tellChosen, entries: new Map(), utc: 0 });
    box.classList.add('stage');
    this.picture = Stage.made('div', 'scene');
    this.notice = Stage.made('p', 'notice');
    this.notice.setAttribute('role', 'status');
    box.append(this.picture, this.notice);
  }

  // earth: as of earth() in earth_map.py; it comes before the first satellites.
  describe(earth) {
    if (this.globe) return;
    try {
      this.globe = new Globe(this.picture, earth, (name) => this.choose(name), (name) => this.point(name));
    } catch (error) {
      this.picture.classList.add('missing');
    }
  }

  // satellites: as of Globe.frame in globe.py.
  show(satellites) {
    this._list(satellites);
    const drawn = satellites.filter(({ r_i: position }) => position);
    const times = drawn.map(({ utc_s: utc }) => utc);
    // Math.max of nothing is no time.
    this.utc = times.length ? Math.max(...times) : 0;
    this.globe?.show(drawn, this.utc);
    this.notice.textContent = this._says(satellites, this.utc - Math.min(...times));
  }

  choose(name) {
    this.point(null);
    this.tellChosen(name);
  }

  // Make one stand out in the list and on the globe; null: none.
  point(name) {
    this.entries.forEach(({ button }, other) => button.classList.toggle('pointed', other === name));
    this.globe?.point(name);
  }

  _says(satellites, spread) {
    if (!this.globe) return 'This browser has no WebGL, which the globe needs.';
    if (!satellites.length) return 'No satellite is there; satdyn node starts one.';
    const { seconds, name } = timeUnit(spread);
    if (spread > LARGEST_SPREAD) return `The clocks of the satellites are up to ${quantity(spread / seconds)} ${name} apart; the Earth is that of the latest.`;
    return '';
  }

  _list(satellites) {
    const names = satellites.map(({ name }) => name);
    if (names.join() !== [...this.entries.keys()].join()) {
      this.entries = new Map(names.map((name) => [name, this.entries.get(name) ?? this._entry(name)]));
      this.list.replaceChildren(...[...this.entries.values()].map(({ button }) => button));
    }
    satellites.forEach((satellite) => {
      const { state, more } = this.entries.get(satellite.name);
      showState(state, satellite);
      more.textContent = satellite.note || this._altitude(satellite);
    });
  }

  _altitude({ r_i: position }) {
    return position && this.globe ? `altitude ${((Math.hypot(...position) - this.globe.radius) / 1000).toFixed(0)} km` : '';
  }

  _entry(name) {
    const [button, state, more] = [Stage.made('button'), Stage.made('span'), Stage.made('small')];
    button.type = 'button';
    button.append(Stage.made('b', '', name), state, more);
    button.addEventListener('click', () => this.choose(name));
    onPointed(button, (isPointed) => this.point(isPointed ? name : null));
    return { button, state, more };
  }
}

// Say in an element whether a satellite runs.
function showState(element, { is_there: isThere, is_paused: isPaused }) {
  element.textContent = !isThere ? 'not there' : isPaused ? 'paused' : 'running';
  element.className = `pill ${!isThere ? 'bad' : isPaused ? '' : 'good'}`;
}

// Call take(whether it is pointed at) when the mouse or the keyboard comes to an element or leaves it.
function onPointed(element, take) {
  ['pointerenter', 'focus'].forEach((kind) => element.addEventListener(kind, () => take(true)));
  ['pointerleave', 'blur'].forEach((kind) => element.addEventListener(kind, () => take(false)));
}
