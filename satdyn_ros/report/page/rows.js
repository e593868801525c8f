'use strict';
// Quaternions (x, y, z, w) as in rotation.py, and the rows of a table as described in scene.py.

const Rotation = {
  multiply([a, b, c, d], [x, y, z, w]) {
    return [
      d * x + a * w + b * z - c * y, d * y + b * w + c * x - a * z,
      d * z + c * w + a * y - b * x, d * w - a * x - b * y - c * z,
    ];
  },

  conjugate: ([x, y, z, w]) => [-x, -y, -z, w],

  rotate([x, y, z, w], [a, b, c]) {
    const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
    return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
  },

  angleBetween(q, p) {
    const dot = Math.abs(q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3]);
    return 2 * Math.acos(Math.min(dot, 1));
  },

  // The shortest way, linear in the components: rows are near each other.
  between(q, p, part) {
    const dot = q[0] * p[0] + q[1] * p[1] + q[2] * p[2] + q[3] * p[3];
    const sum = q.map((x, k) => (1 - part) * x + (dot < 0 ? -part : part) * p[k]);
    const norm = Math.hypot(...sum);
    return sum.map((x) => x / norm);
  },

  // The 3-2-1 angles [rad] of a frame by its quaternion, as rotation.roll_pitch_yaw.
  rollPitchYaw([x, y, z, w]) {
    const [halfSum, halfDifference] = [Math.atan2(x + z, w - y), Math.atan2(z - x, w + y)];
    const wrap = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
    const pitch = Math.PI / 2 - 2 * Math.atan2(Math.hypot(w - y, x + z), Math.hypot(w + y, z - x));
    return [wrap(halfSum - halfDifference), pitch, wrap(halfSum + halfDifference)];
  },
};

class Rows {
  // capacity: the number of rows kept, the latest ones.
  constructor(capacity = Infinity) {
    this.capacity = capacity;
    this.length = 0;
    this.room = 0;
    this.columns = {};
    this.turned = new Float64Array(0); // the angle the body has turned since row 0 [rad], see _way
  }

  append({ rows, columns }) {
    this._makeRoom(rows);
    for (const [name, { width }] of Object.entries(columns)) {
      if (this.columns[name]?.width !== width) {
        const Kind = name === 't_s' ? Float64Array : Float32Array;
        this.columns[name] = { width, values: new Kind(this.room * width).fill(NaN) };
      }
    }
    for (const [name, { width, values }] of Object.entries(this.columns)) {
      const given = columns[name];
      const begin = this.length * width;
      if (given) values.set(Rows.decoded(given), begin);
      else values.fill(NaN, begin, begin + rows * width);
    }
    const first = this.length;
    this.length += rows;
    for (let i = first; i < this.length; i += 1) this.turned[i] = i ? this.turned[i - 1] + this._way(i) : 0;
  }

  static decoded({ float64, float32 }) {
    const text = atob(float64 ?? float32);
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
    return float64 === undefined ? new Float32Array(bytes.buffer) : new Float64Array(bytes.buffer);
  }

  has(name) { return name in this.columns; }

  time(i) { return this.columns.t_s.values[i]; }

  get(name, i) {
    const column = this.columns[name];
    if (!column) return undefined;
    return Array.from(column.values.subarray(i * column.width, (i + 1) * column.width));
  }

  // The last row not after a time.
  indexAt(time) { return Rows.last(this.length, (i) => this.time(i) <= time); }

  // The row from which the body turns by an angle up to row i, without a restart elsewhere.
  indexBefore(i, angle) { return Rows.last(i + 1, (k) => !k || this.turned[i] - this.turned[k - 1] > angle); }

  // The last of count indices for which a condition holds that holds for all before it.
  static last(count, isTrue) {
    let [low, high] = [0, count - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (isTrue(middle)) low = middle; else high = middle - 1;
    }
    return low;
  }

  // All columns at a time: interpolated between two rows, unless a restart moved the body there.
  at(time) {
    const i = this.indexAt(time);
    const here = this._row(i);
    if (i + 1 >= this.length || time <= this.time(i)) return here;
    const next = this._row(i + 1);
    if (this._isElsewhere(i + 1)) return here;
    const part = (time - this.time(i)) / (this.time(i + 1) - this.time(i));
    const row = {};
    for (const name of Object.keys(here)) {
      if (name.startsWith('q_')) row[name] = Rotation.between(here[name], next[name], part);
      else if (name === 'rotor_angle') row[name] = here[name];
      else if (name === 'geodetic') row[name] = Earth.between(here[name], next[name], part);
      else row[name] = here[name].map((x, k) => (1 - part) * x + part * next[name][k]);
    }
    row.t_s = [time];
    return row;
  }

  clear() {
    this.length = 0;
    this.columns = {};
  }

  _row(i) {
    return Object.fromEntries(Object.keys(this.columns).map((name) => [name, this.get(name, i)]));
  }

  // Whether a restart moved the body at a row: it could not have turned that far.
  _isElsewhere(i) {
    return Rotation.angleBetween(this.get('q_ib', i - 1), this.get('q_ib', i)) > 1.5 * this._turn(i) + 0.02;
  }

  // The angle turned on the way to a row; none to a row where a restart moved the body.
  _way(i) { return this._isElsewhere(i) ? 1e4 : this._turn(i); }

  // The angle that the body turns from the previous row [rad].
  _turn(i) {
    const rate = this.columns.omega_bi_b.values;
    const speed = (k) => Math.hypot(rate[3 * k], rate[3 * k + 1], rate[3 * k + 2]);
    return Math.max(speed(i), speed(i - 1)) * (this.time(i) - this.time(i - 1));
  }

  _makeRoom(rows) {
    const needed = this.length + rows;
    if (needed > this.capacity * 1.25) {
      const dropped = this.length - Math.max(0, this.capacity - rows);
      const before = this.turned[dropped];
      this.length -= dropped;
      for (const { width, values } of Object.values(this.columns)) {
        values.copyWithin(0, dropped * width, (dropped + this.length) * width);
      }
      this.turned.copyWithin(0, dropped, dropped + this.length);
      for (let i = 0; i < this.length; i += 1) this.turned[i] -= before;
    }
    if (this.length + rows <= this.room) return;
    this.room = Math.ceil(1.5 * (this.length + rows));
    const wider = (values, width) => {
      const larger = new values.constructor(this.room * width).fill(NaN);
      larger.set(values.subarray(0, this.length * width));
      return larger;
    };
    for (const column of Object.values(this.columns)) column.values = wider(column.values, column.width);
    this.turned = wider(this.turned, 1);
  }
}
