'use strict';
// The Earth of a description: how it is turned and where the Sun is, from UTC alone to 0.01 deg
// between 1950 and 2050, and its coast lines.

class Earth {
  constructor({ epoch_s: epoch, period_s: period, coast }) {
    Object.assign(this, { epoch, period });
    // Lines of points [longitude, latitude] in degrees.
    this.coast = coast.lines.map((line) => Array.from({ length: line.length / 2 }, (_, k) => (
      [coast.unit_deg * line[2 * k], coast.unit_deg * line[2 * k + 1]])));
  }

  utc(time) { return this.epoch + time; }

  // The attitude of Earth-fixed axes to inertial ones (GCRS): the Earth rotation angle about a pole
  // that precession moves, without nutation (9 arcsec); UT1 is taken as UTC.
  attitude(time) {
    const days = this._days(time);
    const centuries = days / 36525;
    const arcsec = Math.PI / 648000;
    const [x, y] = [2004.19 * arcsec * centuries, -22.4 * arcsec * centuries * centuries];
    const angle = 2 * Math.PI * ((0.779057273264 + 0.00273781191135448 * days + days) % 1);
    const pole = [-y / 2, x / 2, 0, Math.sqrt(1 - (x * x + y * y) / 4)];
    return Rotation.multiply(pole, [0, 0, Math.sin(angle / 2), Math.cos(angle / 2)]);
  }

  // The unit vector to the Sun in Earth-fixed axes: Astronomical Almanac, "Low precision formulas for
  // the Sun's coordinates", turned by the mean sidereal time of 1982.
  sun(time) {
    const days = this._days(time);
    const degree = Math.PI / 180;
    const anomaly = (357.528 + 0.9856003 * days) * degree;
    const longitude = (280.46 + 0.9856474 * days + 1.915 * Math.sin(anomaly) + 0.02 * Math.sin(2 * anomaly)) * degree;
    const obliquity = (23.439 - 4e-7 * days) * degree;
    const [x, y] = [Math.cos(longitude), Math.cos(obliquity) * Math.sin(longitude)];
    const sidereal = (280.46061837 + 360.98564736629 * days) * degree;
    const [c, s] = [Math.cos(sidereal), Math.sin(sidereal)];
    return [c * x + s * y, c * y - s * x, Math.sin(obliquity) * Math.sin(longitude)];
  }

  // Days since J2000, 1 January 2000, 12:00.
  _days(time) { return (this.utc(time) - 946728000) / 86400; }

  // The unit vector of a point, in degrees.
  static direction([longitude, latitude]) {
    const [across, turn] = [Math.cos((latitude * Math.PI) / 180), (longitude * Math.PI) / 180];
    return [across * Math.cos(turn), across * Math.sin(turn), Math.sin((latitude * Math.PI) / 180)];
  }

  // Longitude and latitude of a direction, in degrees.
  static degrees([x, y, z]) { return [Math.atan2(y, x), Math.atan2(z, Math.hypot(x, y))].map((angle) => (angle * 180) / Math.PI); }

  // A point [latitude, longitude, height] on the way from one to another.
  static between([latitude, longitude, height], [later, to, higher], part) {
    const between = (from, way) => from + part * way;
    return [
      between(latitude, later - latitude), Earth.turn(0, between(longitude, Earth.turn(longitude, to))), between(height, higher - height),
    ];
  }

  // The nearest way from one longitude to another, in degrees.
  static turn(from, to) { return ((((to - from + 180) % 360) + 360) % 360) - 180; }
}
