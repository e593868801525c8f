'use strict';
// The ground track: a map with coast lines, day and night, and beside it time and position in numbers.

const TRACK_POINTS = 600;
const MAP_EACH = 100; // [ms]

class Ground {
  constructor() {
    this.box = document.createElement('section');
    Object.assign(this.box, { className: 'ground', hidden: true });
    this.box.setAttribute('aria-label', 'ground track');
    this.box.innerHTML = '<canvas role="img" aria-label="map of the Earth with the ground track"></canvas>'
      + '<p><time></time><output class="position"></output></p>';
    [this.canvas, this.time, this.position] = ['canvas', 'time', '.position'].map((name) => this.box.querySelector(name));
    this.context = this.canvas.getContext('2d');
    new ResizeObserver(() => this._resize()).observe(this.canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this._resize());
  }

  // earth: null hides the map.
  describe(earth) {
    this.earth = earth;
    this.box.hidden = !earth;
    this.clear();
    this._resize();
  }

  clear() {
    this.row = null;
    this.time.textContent = this.position.textContent = '';
  }

  show(row, rows) {
    Object.assign(this, { row, rows });
    if (!this.earth || this.asked) return;
    this.asked = setTimeout(() => { this.asked = 0; this._draw(); }, this.drawn ? MAP_EACH : 0);
  }

  _resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!this.earth || !width) return;
    const sharp = Math.min(devicePixelRatio, 2);
    [this.canvas.width, this.canvas.height] = [width * sharp, height * sharp];
    this.scale = this.canvas.width / 360;
    const style = getComputedStyle(this.box);
    this.colour = (name) => style.getPropertyValue(name).trim();
    this.land = this._land(sharp);
    this._draw();
  }

  // What does not move, as a picture: circles every 30 deg and coast lines.
  _land(sharp) {
    const picture = document.createElement('canvas');
    [picture.width, picture.height] = [this.canvas.width, this.canvas.height];
    const context = picture.getContext('2d');
    const lines = (all, colour, width) => {
      context.beginPath();
      for (const line of all) line.forEach((point, k) => context[k ? 'lineTo' : 'moveTo'](...this._at(point)));
      Object.assign(context, { strokeStyle: this.colour(colour), lineWidth: width * sharp, lineJoin: 'round' });
      context.stroke();
    };
    const meridians = [-150, -120, -90, -60, -30, 0, 30, 60, 90, 120, 150].map((x) => [[x, -90], [x, 90]]);
    const parallels = [-60, -30, 0, 30, 60].map((y) => [[-180, y], [180, y]]);
    lines([...meridians, ...parallels], '--map-grid', 1);
    lines(this.earth.coast, '--map-coast', 0.9);
    return picture;
  }

  _at([longitude, latitude]) { return [(longitude + 180) * this.scale, (90 - latitude) * this.scale]; }

  _draw() {
    if (!this.row || !this.land) return;
    const { context, canvas, earth, row } = this;
    const sharp = canvas.width / canvas.clientWidth;
    const [time] = row.t_s;
    const sun = Earth.degrees(earth.sun(time));
    context.fillStyle = this.colour('--map-sea');
    context.fillRect(0, 0, canvas.width, canvas.height);
    this._shadeNight(sun);
    context.drawImage(this.land, 0, 0);
    this._drawTrack(time, sharp);
    this._mark(sun, 3.5 * sharp, '--sun');
    this._mark([row.geodetic[1], row.geodetic[0]], 4 * sharp, '--map-body');
    this._say(time);
    this.drawn = true;
  }

  // Night is where the Sun is below the horizon of the sphere.
  _shadeNight([longitude, latitude]) {
    const { context, canvas } = this;
    const degree = Math.PI / 180;
    // At an equinox the edge is two meridians.
    const slope = Math.tan((Math.abs(latitude) < 0.05 ? 0.05 * (Math.sign(latitude) || 1) : latitude) * degree);
    context.beginPath();
    for (let x = -180; x <= 180; x += 2) {
      context.lineTo(...this._at([x, Math.atan(-Math.cos((x - longitude) * degree) / slope) / degree]));
    }
    const dark = latitude > 0 ? canvas.height : 0;
    context.lineTo(canvas.width, dark);
    context.lineTo(0, dark);
    context.fillStyle = this.colour('--map-night');
    context.fill();
  }

  // The track of the last revolution; what is in the umbra in another colour.
  _drawTrack(time, sharp) {
    const { context, rows, row, earth } = this;
    const last = rows.indexAt(time);
    const first = rows.indexAt(time - earth.period);
    const stride = Math.max(1, Math.ceil((last - first) / TRACK_POINTS));
    const points = [];
    for (let i = last - stride * Math.floor((last - first) / stride); i <= last; i += stride) {
      points.push([rows.get('geodetic', i), rows.get('sunlight', i)?.[0] === 0]);
    }
    points.push([row.geodetic, row.sunlight?.[0] === 0]);
    Object.assign(context, { lineWidth: 1.8 * sharp, lineCap: 'round' });
    for (const isDark of [false, true]) {
      context.beginPath();
      for (let k = 1; k < points.length; k += 1) {
        const [[[latitude, from]], [[later, to], isDarkThere]] = [points[k - 1], points[k]];
        if (isDarkThere !== isDark) continue;
        // Where it leaves the map on one side it comes in on the other.
        const turn = Earth.turn(from, to);
        this._line([from, latitude], [from + turn, later]);
        if (Math.abs(from + turn) > 180) this._line([to - turn, latitude], [to, later]);
      }
      context.strokeStyle = this.colour(isDark ? '--map-umbra' : '--map-track');
      context.stroke();
    }
  }

  _line(from, to) {
    this.context.moveTo(...this._at(from));
    this.context.lineTo(...this._at(to));
  }

  _mark(point, radius, colour) {
    const { context } = this;
    context.beginPath();
    context.arc(...this._at(point), radius, 0, 2 * Math.PI);
    Object.assign(context, { fillStyle: this.colour(colour), strokeStyle: this.colour('--map-edge'), lineWidth: radius / 3 });
    context.fill();
    context.stroke();
  }

  _say(time) {
    const [latitude, longitude, height] = this.row.geodetic;
    const degrees = (angle, positive, negative) => `${Math.abs(angle).toFixed(2)}° ${angle < 0 ? negative : positive}`;
    this.time.textContent = utcText(this.earth.utc(time));
    this.position.textContent = `${degrees(latitude, 'N', 'S')}  ${degrees(longitude, 'E', 'W')}  ${(height / 1000).toFixed(1)} km`;
  }
}
