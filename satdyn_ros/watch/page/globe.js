'use strict';
// The Earth in the middle, and around it satellites, a dot each, on their orbits; on the ground the
// tracks of their last revolution.

const STEP = Math.PI / 90; // [rad], between two points of an orbit
const ORBIT_POINTS = 181;
const TRAIL_POINTS = 16; // the brighter end of the line, behind the dot
const GROUND = 1.002; // just above it
const MARGIN = 1.12; // around the widest orbit, for names

class Globe {
  // box: an element that the globe fills; then earth() of earth_map.py; choose(name) shows a satellite,
  // point(name) makes one stand out, null none.  Error: the browser has no WebGL.
  constructor(box, { radius_m: radius, mu, coast }, choose, point) {
    Object.assign(this, { box, radius, mu, tellChosen: choose, tellPointed: point });
    this.earth = new Earth({ epoch_s: 0, coast });
    this.satellites = new Map();
    this.renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: 'high-performance' });
    this.canvas = this.renderer.domElement;
    this.dots = Stage.made('div', 'dots');
    const overlay = Stage.made('div', 'labels');
    [this.canvas, overlay].forEach((part) => part.setAttribute('aria-hidden', 'true'));
    box.append(this.canvas, this.dots, overlay);
    this.labels = new Labels(overlay);
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(36, 1, 0.1, 1500);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enablePan: false, minDistance: 1.3, maxDistance: 100, enableDamping: false });
    this.controls.addEventListener('change', () => this.redraw());
    this.controls.addEventListener('start', () => { this.isTurned = true; });
    this._build();
    this._paint();
    new ResizeObserver(() => this._resize()).observe(box);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this._paint(); this.redraw(); });
  }

  // satellites: name, utc_s, r_i [m] and v_i [m/s] of each; utc: the time of the Earth [s].
  show(satellites, utc) {
    const names = new Set(satellites.map(({ name }) => name));
    [...this.satellites.keys()].filter((name) => !names.has(name)).forEach((name) => this._remove(name));
    satellites.forEach((satellite) => this._place(satellite));
    if (satellites.length) this._turn(utc);
    this.redraw();
  }

  // Make one stand out; null: none.
  point(name) {
    this.pointed = name;
    this.satellites.forEach((satellite, other) => this._colour(satellite, other));
    this.redraw();
  }

  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => { this.asked = false; this._draw(); });
  }

  // -- building --------------------------------------------------------------------------------------

  _build() {
    this.planet = new Planet(this.radius, this.earth);
    // The planet is drawn behind everything; this hides what is behind the planet.
    const shade = new THREE.Mesh(new THREE.SphereGeometry(0.999, 96, 64), new THREE.MeshBasicMaterial({ colorWrite: false }));
    shade.renderOrder = -1;
    this.inertial = new THREE.Group();
    this.inertial.quaternion.set(...Scene.Z_UP);
    this.ground = new THREE.Group();
    this.stars = starField();
    this.world.add(this.planet.group, shade, this.stars, this.inertial, this.ground);
  }

  _paint() {
    const style = getComputedStyle(this.box);
    this.colourOf = (name) => style.getPropertyValue(name).trim();
    this.renderer.setClearColor(this.colourOf('--sky'));
    this.stars.material.color.set(this.colourOf('--star'));
    this.stars.visible = this.colourOf('--star') !== this.colourOf('--sky');
    this.planet.paint(this.colourOf);
    this.satellites.forEach((satellite, name) => this._colour(satellite, name));
  }

  // -- satellites ------------------------------------------------------------------------------------

  _place({ name, utc_s: utc, r_i: position, v_i: velocity }) {
    if (!this.satellites.has(name)) this.satellites.set(name, this._made(name));
    const satellite = this.satellites.get(name);
    const ellipse = new Ellipse(position.map((x) => x / this.radius), velocity.map((x) => x / this.radius), this.mu / this.radius ** 3);
    const draw = (path, count) => path.draw(count, (k, array, offset) => array.set(ellipse.ahead((k - count + 1) * STEP), offset));
    draw(satellite.orbit, ORBIT_POINTS);
    draw(satellite.trail, TRAIL_POINTS);
    this._track(satellite.track, ellipse, utc);
    satellite.at.set(...ellipse.ahead(0)).applyQuaternion(this.inertial.quaternion);
    satellite.furthest = ellipse.furthest;
  }

  // The points below it in its last revolution, each when it was there.
  _track(track, ellipse, utc) {
    if (!Number.isFinite(ellipse.after(-2 * Math.PI))) return track.draw(0);
    return track.draw(ORBIT_POINTS, (k, array, offset) => {
      const angle = (k - ORBIT_POINTS + 1) * STEP;
      const q_ie = this.earth.attitude(utc + ellipse.after(angle));
      const below = Rotation.rotate(Rotation.conjugate(q_ie), ellipse.ahead(angle));
      const distance = Math.hypot(...below);
      array.set(below.map((x) => (GROUND * x) / distance), offset);
    });
  }

  _made(name) {
    const [orbit, trail, track] = [[ORBIT_POINTS, 1.3], [TRAIL_POINTS, 2.6], [ORBIT_POINTS, 1.6]].map((size) => new Path(...size));
    this.ground.add(track.line);
    [orbit, trail].forEach((path, k) => {
      path.material.depthWrite = false; // of lines on one orbit none hides another
      path.line.renderOrder = k;
      this.inertial.add(path.line);
    });
    const dot = Stage.made('button', 'dot');
    dot.type = 'button';
    dot.setAttribute('aria-label', name);
    dot.addEventListener('click', () => this.tellChosen(name));
    onPointed(dot, (isPointed) => this.tellPointed(isPointed ? name : null));
    this.dots.append(dot);
    this.labels.set(name, name.replace(/^\/|\/satdyn$/g, ''), '--text');
    const satellite = { orbit, trail, track, dot, at: new THREE.Vector3() };
    this._colour(satellite, name);
    return satellite;
  }

  _remove(name) {
    const { orbit, trail, track, dot } = this.satellites.get(name);
    [orbit, trail, track].forEach(({ line, geometry, material }) => {
      line.removeFromParent();
      geometry.dispose();
      material.dispose();
    });
    dot.remove();
    this.labels.remove(name);
    this.satellites.delete(name);
  }

  _colour({ orbit, trail, track, dot }, name) {
    const isPointed = name === this.pointed;
    const [line, bright] = [isPointed ? '--map-track' : '--quiet', '--map-track'].map(this.colourOf);
    orbit.paint(line, line);
    trail.paint(bright, line);
    track.paint(bright, this.colourOf(isPointed ? '--map-track' : '--planet-shallow'));
    orbit.line.renderOrder = isPointed ? 2 : 0;
    dot.classList.toggle('pointed', isPointed);
  }

  // -- drawing ---------------------------------------------------------------------------------------

  // Turn the Earth, and until the user does the camera, which sees most of the day's side.
  _turn(utc) {
    const q_ve = Rotation.multiply(Scene.Z_UP, this.earth.attitude(utc));
    const sun_v = Rotation.rotate(q_ve, this.earth.sun(utc));
    this.planet.place(q_ve, [0, 0, 0], 1, sun_v);
    this.ground.quaternion.set(...q_ve);
    const widest = Math.max(...[...this.satellites.values()].map(({ furthest }) => furthest));
    if (this.isTurned || widest === this.widest) return;
    this.widest = widest;
    const half = (this.camera.fov * Math.PI) / 360;
    const narrower = Math.min(half, Math.atan(this.camera.aspect * Math.tan(half)));
    const azimuth = Math.atan2(sun_v[0], sun_v[2]) + 0.8;
    this.camera.position.setFromSphericalCoords((MARGIN * widest) / Math.sin(narrower), 1.15, azimuth);
    this.controls.update();
  }

  _draw() {
    if (!this.width) return;
    this.renderer.render(this.world, this.camera);
    const points = new Map();
    const seen = new THREE.Vector3();
    this.satellites.forEach(({ at, dot }, name) => {
      const isHidden = this._isBehindEarth(at);
      seen.copy(at).project(this.camera);
      const [x, y] = [((seen.x + 1) / 2) * this.width, ((1 - seen.y) / 2) * this.height];
      dot.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      dot.style.opacity = isHidden ? 0.35 : 1;
      dot.hidden = seen.z > 1;
      this.labels.dim(name, isHidden);
      points.set(name, dot.hidden ? null : { x, y, room: 9 });
    });
    this.labels.place(points, [], [], this.width, this.height);
  }

  // Whether the line of sight to a point meets the Earth before it.
  _isBehindEarth(at) {
    const from = this.camera.position;
    const way = at.clone().sub(from);
    const part = Math.max(0, Math.min(1, -from.dot(way) / way.lengthSq()));
    return way.multiplyScalar(part).add(from).length() < 1;
  }

  _resize() {
    const { width, height } = this.box.getBoundingClientRect();
    if (!width || !height) return;
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.widest = 0; // it is seen from as far as the new picture needs
    this._draw();
  }
}
