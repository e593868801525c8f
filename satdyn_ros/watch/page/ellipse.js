'use strict';
// The osculating ellipse of a position r with the velocity v about a centre of mu, in any units.
class Ellipse {
  constructor(r, v, mu) {
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const distance = Math.hypot(...r);
    const radial = r.map((x) => x / distance);
    const radialSpeed = dot(radial, v);
    const across = v.map((x, k) => x - radialSpeed * radial[k]);
    const transverseSpeed = Math.hypot(...across);
    const momentum = distance * transverseSpeed;
    Object.assign(this, { mu, radial, transverse: across.map((x) => x / transverseSpeed), parameter: momentum ** 2 / mu });
    // e cos f and e sin f of the true anomaly f at r.
    [this.cosine, this.sine] = [this.parameter / distance - 1, (radialSpeed * momentum) / mu];
  }

  // The distance of the apocentre.
  get furthest() { return this.parameter / (1 - Math.hypot(this.cosine, this.sine)); }

  // How long after r, before it if negative, is the point that is ahead by an angle: by Kepler's
  // equation, whose eccentric anomaly is E = f - 2 atan(b sin f / (1 + b cos f)), b = e / (1 + sqrt(1 - e^2)).
  // NaN: it does not come back.
  after(angle) {
    const e = Math.hypot(this.cosine, this.sine);
    const root = Math.sqrt(1 - e * e);
    const b = e / (1 + root);
    const here = Math.atan2(this.sine, this.cosine);
    const [now, then] = [here, here + angle].map((f) => {
      const eccentric = f - 2 * Math.atan2(b * Math.sin(f), 1 + b * Math.cos(f));
      return eccentric - e * Math.sin(eccentric);
    });
    return (then - now) * Math.sqrt((this.parameter / (root * root)) ** 3 / this.mu);
  }

  // The point that is ahead of r by an angle.
  ahead(angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const distance = this.parameter / (1 + this.cosine * c - this.sine * s);
    return this.radial.map((x, k) => distance * (c * x + s * this.transverse[k]));
  }
}
