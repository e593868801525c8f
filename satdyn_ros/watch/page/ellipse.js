'use strict';
// The osculating ellipse of a place r with the velocity v about a centre of mu, in any units.
class Ellipse {
  constructor(r, v, mu) {
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const distance = Math.hypot(...r);
    const radial = r.map((x) => x / distance);
    const radialSpeed = dot(radial, v);
    const across = v.map((x, k) => x - radialSpeed * radial[k]);
    const transverseSpeed = Math.hypot(...across);
    const momentum = distance * transverseSpeed;
    Object.assign(this, { radial, transverse: across.map((x) => x / transverseSpeed), parameter: momentum ** 2 / mu });
    // e cos f and e sin f of the true anomaly f at r.
    [this.cosine, this.sine] = [this.parameter / distance - 1, (radialSpeed * momentum) / mu];
  }

  // The distance of the apocentre.
  get furthest() { return this.parameter / (1 - Math.hypot(this.cosine, this.sine)); }

  // The point that is ahead of r by an angle.
  ahead(angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const distance = this.parameter / (1 + this.cosine * c - this.sine * s);
    return this.radial.map((x, k) => distance * (c * x + s * this.transverse[k]));
  }
}
