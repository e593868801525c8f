'use strict';
// The scene: a satellite from its description and rows (see scene.py), seen in one of three frames.

const ARROWS = {
  nadir: '--nadir', rate: '--rate', momentum: '--momentum', torque: '--torque', applied: '--applied',
  x: '--x', y: '--y', z: '--z', along: '--quiet', normal: '--quiet', sun: '--sun', field: '--field',
  dipole: '--dipole',
};
const PATHS = { axis: '--axis-path', polhode: '--polhode', herpolhode: '--herpolhode' };
const AXIS_LENGTH = 1.0;
const SPHERE_RADIUS = 1.35;
const CONE_LENGTH = 0.8;
const PLUME_LENGTH = 0.45;
const PATH_POINTS = 400; // without a graphics processor these cost more than anything else in the scene
const PATH_TURN = 14 * Math.PI; // the length of a path, as the angle that the body turned
const SLOWEST_DRAW = 90; // [ms]
const LONGEST_REST = 1000; // [ms]; the first draw, which compiles, takes seconds on a busy machine
const FASTEST_WHEEL = 7; // [rad/s] on the screen; a faster one cannot be followed

class Scene {
  // box: an element that the scene fills.  Error: the browser has no WebGL.
  constructor(box) {
    this.box = box;
    this.over = [];
    this.overSizes = new ResizeObserver(() => { this._measureCover(); this.redraw(); });
    this.isSoftware = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: 'high-performance' });
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute('aria-hidden', 'true');
    box.append(this.canvas);
    const overlay = document.createElement('div');
    overlay.className = 'labels';
    overlay.setAttribute('aria-hidden', 'true');
    box.append(overlay);
    this.labels = new Labels(overlay);
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(36, 1, 0.1, 1500);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enablePan: false, minDistance: 2, maxDistance: 14, enableDamping: false });
    this.controls.addEventListener('change', () => this.redraw());
    this.shown = { axis: true, polhode: false, herpolhode: false, arrows: true, surroundings: true };
    this.frames = []; // when the last ones were drawn [ms]
    this.sharpness = this.share = 1;
    this._build();
    this._paint();
    this.view = 'space';
    this._resetCamera();
    new ResizeObserver(() => this._resize()).observe(box);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', () => { this._paint(); this.redraw(); });
  }

  // earth: an Earth, or null: of a planet that is not known by its coasts.
  describe(description, earth = null) {
    this.clear();
    Object.assign(this, { description, earth });
    this.inBody.remove(this.solid, ...this.plates, ...this.wheels, ...this.cones, ...this.plumes);
    const { edges, centre, q_bp, has_box: hasBox, plates } = description.body;
    this.solid = hasBox ? bodySolid(edges) : new THREE.Group();
    this.solid.position.set(...centre);
    this.solid.quaternion.set(...q_bp);
    this.plates = plates.map(plate);
    this.wheels = description.rotors.map((rotor, k) => this._wheel(rotor, k));
    this.cones = description.cones.map((seen) => this._cone(seen));
    this.plumes = description.nozzles.map((nozzle) => plume(nozzle, PLUME_LENGTH));
    this.inBody.add(this.solid, ...this.plates, ...this.wheels, ...this.cones, ...this.plumes);
    this.arrows.x.point(AXIS_LENGTH, 0, 0);
    this.arrows.y.point(0, AXIS_LENGTH, 0);
    this.arrows.z.point(0, 0, AXIS_LENGTH);
    if (this.planet) this.world.remove(this.planet.group);
    this.planet = description.planet ? new Planet(description.planet, earth) : null;
    if (this.planet) this.world.add(this.planet.group);
    if (this.view === 'space' && description.has_lvlh) this.setView('orbit');
    this._paint();
    this.longest = { rate: 0, torque: 0, dipole: 0 };
  }

  // Labels keep off these elements, which lie over the scene and whose size may change.
  keepOff(elements) {
    this.over = elements;
    this.overSizes.disconnect();
    elements.forEach((element) => this.overSizes.observe(element));
    this._measureCover();
  }

  // Show nothing until the next row: a body where it is not would be a lie.
  clear() {
    this.row = null;
    this.labels.clear();
    this.redraw();
  }

  get framesPerSecond() {
    const recent = this.frames.filter((at) => at > performance.now() - 2000);
    return recent.length < 2 ? 0 : (1000 * (recent.length - 1)) / (recent[recent.length - 1] - recent[0]);
  }

  setView(name) {
    this.view = name;
    this._resetCamera();
    this._placeAnew();
  }

  toggle(name, on) {
    this.shown[name] = on;
    this._placeAnew();
  }

  // Arrows of rate and torque are scaled by the largest values so far.
  measure(rows) {
    for (let i = 0; i < rows.length; i += 1) this._measureRow(rows._row(i));
  }

  // Show a row, and behind it the paths through the rows before it.
  show(row, rows, playedFactor = 1) {
    this.row = row;
    this.rows = rows;
    this.playedFactor = playedFactor;
    this._measureRow(row);
    this._placeAnew();
  }

  redraw() {
    if (this.asked) return;
    this.asked = true;
    const draw = () => requestAnimationFrame((now) => { this.asked = false; this._draw(now); });
    const early = (this.restUntil ?? 0) - performance.now();
    if (early > 0) setTimeout(draw, early); else draw();
  }

  // -- building ------------------------------------------------------------------------------------

  _build() {
    this.world.add(new THREE.HemisphereLight(0xffffff, 0x8fa6c8, 1.5));
    this.sunlight = new THREE.DirectionalLight(0xffffff, 2.4);
    this.world.add(this.sunlight);
    [this.inertial, this.inLvlh, this.inBody] = [0, 1, 2].map(() => new THREE.Group());
    this.world.add(this.inertial, this.inLvlh, this.inBody);
    this.stars = starField();
    this.sphere = sphereLines(SPHERE_RADIUS);
    this.inertial.add(this.stars);
    this.arrows = {};
    for (const name of Object.keys(ARROWS)) {
      const isFrame = name === 'along' || name === 'normal';
      this.arrows[name] = arrow(isFrame ? 0.007 : name.length === 1 ? 0.015 : 0.02);
      (name.length === 1 ? this.inBody : this.world).add(this.arrows[name]);
    }
    this.paths = {};
    for (const name of Object.keys(PATHS)) {
      this.paths[name] = new Path(PATH_POINTS, 2.2);
      this.world.add(this.paths[name].line);
    }
    this.solid = new THREE.Group();
    [this.plates, this.wheels, this.cones, this.plumes] = [[], [], [], []];
  }

  // That of the box: wings are wider.
  get _wheelSize() { return Math.max(...this.description.body.edges); }

  // How far from its centre the body ends along an axis.
  _surface(axis) {
    const { edges, q_bp } = this.description.body;
    const inBox = Rotation.rotate(Rotation.conjugate(q_bp), axis);
    return Math.min(...inBox.map((c, i) => edges[i] / 2 / Math.max(Math.abs(c), 1e-6)));
  }

  // A point on an axis through the centre of the body, some way outside it.
  _outside(axis, way) {
    const { centre } = this.description.body;
    return new THREE.Vector3(...axis).multiplyScalar(this._surface(axis) + way).add(new THREE.Vector3(...centre));
  }

  _cone(seen) {
    const made = cone(seen, CONE_LENGTH);
    made.position.copy(this._outside(seen.axis, 0));
    return made;
  }

  // A wheel is outside the body on its axis; further out where there is another one.
  _wheel({ axis, mode, momentum }, k) {
    const size = this._wheelSize;
    const made = wheel(0.2 * size);
    const along = new THREE.Vector3(...axis);
    const before = this.description.rotors.slice(0, k)
      .filter((other) => along.dot(new THREE.Vector3(...other.axis)) > 0.95).length;
    made.position.copy(this._outside(axis, (0.1 + 0.16 * before) * size));
    made.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along);
    made.angle = 0;
    made.nominal = mode === 'constant_momentum' ? 2 * Math.sign(momentum) : 0;
    return made;
  }

  _paint() {
    const style = getComputedStyle(this.box);
    const colourOf = (name) => style.getPropertyValue(name).trim();
    const background = colourOf('--sky');
    this.renderer.setClearColor(background);
    Object.entries(ARROWS).forEach(([name, colour]) => this.arrows[name].paint(colourOf(colour)));
    Object.entries(PATHS).forEach(([name, colour]) => this.paths[name].paint(colourOf(colour), background));
    this.solid.paint?.(colourOf('--solid'), colourOf('--solid-edge'));
    this.plates.forEach((made) => made.paint(colourOf('--plate'), colourOf('--plate-edge')));
    this.wheels.forEach((made) => made.paint(colourOf('--wheel'), colourOf('--wheel-mark')));
    this.cones.forEach((made) => made.paint(colourOf('--cone')));
    this.plumes.forEach((made) => made.paint(colourOf('--plume')));
    this.sphere.material.color.set(colourOf('--quiet'));
    this.stars.material.color.set(colourOf('--star'));
    this.stars.visible = colourOf('--star') !== background;
    this.planet?.paint(colourOf);
  }

  // -- showing a row -----------------------------------------------------------------------------

  _measureRow({ omega_bi_b: omega, gravity_gradient: torque, dipole_b: dipole }) {
    this.longest.rate = Math.max(this.longest.rate, Math.hypot(...omega));
    if (torque) this.longest.torque = Math.max(this.longest.torque, Math.hypot(...torque));
    if (dipole) this.longest.dipole = Math.max(this.longest.dipole, Math.hypot(...dipole));
  }

  // With the next frame: rows may come more often than the scene is drawn.
  _placeAnew() {
    this.isPlaced = false;
    this.redraw();
  }

  _place() {
    this.isPlaced = true;
    const { row } = this;
    const { q_ib, q_il } = row;
    // The frame that is fixed on the screen, with LVLH's and the body's z downwards.
    const q_if = this.view === 'body' ? q_ib : this.view === 'orbit' && q_il ? q_il : [0, 0, 0, 1];
    const down = this.view === 'space' || !q_il ? Scene.Z_UP : Scene.Z_DOWN;
    const q_vi = Rotation.multiply(down, Rotation.conjugate(q_if));
    const q_vb = Rotation.multiply(q_vi, q_ib);
    const q_vl = q_il && Rotation.multiply(q_vi, q_il);
    this.inertial.quaternion.set(...q_vi);
    this.inBody.quaternion.set(...q_vb);
    if (q_vl) this.inLvlh.quaternion.set(...q_vl);
    const nadir_v = q_vl ? Rotation.rotate(q_vl, [0, 0, 1]) : Rotation.rotate(q_vi, [0, 0, -1]);
    const q_ve = this.earth && Rotation.multiply(q_vi, this.earth.attitude(row.t_s[0]));
    const sun_v = this._sun(q_vb, q_ve);
    this.sunlight.position.set(...(sun_v ?? Scene.LAMP));
    this.sunlight.intensity = this._isInUmbra ? 0.4 : 2.4;
    if (this.planet) this.planet.show(q_ve ?? q_vi, nadir_v, row.radius_m[0], sun_v);
    this._placeArrows(q_vb, q_vl, nadir_v, sun_v);
    this._placeWheels();
    this._placePlumes();
    this._placePaths(q_vi, q_vb, q_vl);
  }

  get _isInUmbra() { return this.row.sunlight?.[0] === 0; }

  // The direction of the Sun: as published, or by the time; null: not known.
  _sun(q_vb, q_ve) {
    const published = this.row.sun_direction;
    if (published) return Rotation.rotate(q_vb, published);
    return q_ve && Rotation.rotate(q_ve, this.earth.sun(this.row.t_s[0]));
  }

  _placeArrows(q_vb, q_vl, nadir_v, sun_v) {
    const { row, longest } = this;
    const none = [0, 0, 0];
    const along = (v, length) => v.map((x) => x * length);
    // Long enough to be seen outside the body; larger values are longer.
    const inView = (v_b, largest) => {
      const size = Math.hypot(...v_b);
      return size > 1e-6 * largest ? Rotation.rotate(q_vb, along(v_b, 0.95 / size + 0.4 / largest)) : none;
    };
    const isOn = this.shown.arrows;
    const point = (name, v) => this.arrows[name].point(...v);
    point('nadir', along(nadir_v, 1.75));
    point('along', q_vl ? Rotation.rotate(q_vl, [1.5, 0, 0]) : none);
    point('normal', q_vl ? Rotation.rotate(q_vl, [0, -1.5, 0]) : none);
    point('rate', isOn ? inView(row.omega_bi_b, longest.rate) : none);
    const H = row.momentum_b;
    point('momentum', isOn && H ? along(inView(H, Math.hypot(...H)), 1.1) : none);
    point('torque', isOn && row.gravity_gradient ? inView(row.gravity_gradient, longest.torque) : none);
    const applied = row.applied_b;
    const field = this.shown.surroundings && row.magnetic_field;
    const dipole = this.shown.surroundings && row.dipole_b;
    point('sun', this.shown.surroundings && sun_v ? along(sun_v, 1.75) : none);
    point('field', field ? along(Rotation.rotate(q_vb, field), 1.5 / Math.hypot(...field)) : none);
    point('dipole', dipole ? inView(dipole, longest.dipole) : none);
    point('applied', isOn && applied && applied.every(Number.isFinite) ? inView(applied, Math.hypot(...applied)) : none);
  }

  _placeWheels() {
    const now = performance.now() / 1000;
    const passed = Math.min(now - (this.wheelsAt ?? now), 0.1);
    this.wheelsAt = now;
    this.wheels.forEach((made, k) => {
      const speed = this.row.rotor_speed?.[k];
      const wanted = Number.isFinite(speed) ? speed * this.playedFactor : made.nominal * Math.min(this.playedFactor, 1);
      const shown = Math.max(-FASTEST_WHEEL, Math.min(FASTEST_WHEEL, wanted));
      made.angle += shown * passed;
      const isTrue = Math.abs(wanted) < FASTEST_WHEEL && Number.isFinite(this.row.rotor_angle?.[k]);
      made.turn(isTrue ? this.row.rotor_angle[k] : made.angle, Math.abs(wanted) >= FASTEST_WHEEL);
    });
  }

  _placePlumes() {
    this.plumes.forEach((made, k) => {
      const { thrust } = this.description.nozzles[k];
      made.show(thrust ? (this.row.thruster?.[k] ?? 0) / thrust : 0);
    });
  }

  _placePaths(q_vi, q_vb, q_vl) {
    const isAny = Object.keys(PATHS).some((name) => this.shown[name]);
    this.sphere.visible = isAny;
    (q_vl && this.view === 'orbit' ? this.inLvlh : this.view === 'body' ? this.inBody : this.inertial).add(this.sphere);
    const { rows, description: { axis } } = this;
    const last = rows ? rows.indexAt(this.row.t_s[0]) : 0;
    const first = rows ? rows.indexBefore(last, PATH_TURN) : 0;
    const stride = Math.max(1, Math.ceil((last - first + 2) / PATH_POINTS));
    const count = Math.floor((last - first) / stride) + 2;
    const inOrbit = this.view !== 'space' && q_vl;
    const draw = (name, parent, directionAt) => {
      parent.add(this.paths[name].line);
      if (!this.shown[name] || !rows) return this.paths[name].draw(0);
      return this.paths[name].draw(count, (k, array, offset) => {
        const i = Math.min(first + k * stride, last);
        const get = k === count - 1 ? (column) => this.row[column] : (column) => rows.get(column, i);
        const direction = directionAt(get);
        const size = Math.hypot(...direction) || 1;
        for (const c of [0, 1, 2]) array[offset + c] = (SPHERE_RADIUS * direction[c]) / size;
      });
    };
    const axisIn = (get) => {
      const axis_i = Rotation.rotate(get('q_ib'), axis);
      return inOrbit ? Rotation.rotate(Rotation.conjugate(get('q_il')), axis_i) : axis_i;
    };
    draw('axis', inOrbit ? this.inLvlh : this.inertial, axisIn);
    draw('polhode', this.inBody, (get) => get('omega_bi_b'));
    draw('herpolhode', this.inertial, (get) => Rotation.rotate(get('q_ib'), get('omega_bi_b')));
  }

  // -- drawing -------------------------------------------------------------------------------------

  _labelTexts() {
    const { row, description } = this;
    const sized = (name, vector, scale, unit) => (vector ? `${name} ${quantity(scale * Math.hypot(...vector))} ${unit}` : name);
    const texts = {
      nadir: description.has_lvlh ? 'nadir' : 'to the centre', rate: 'ω', momentum: 'H', torque: 'gravity gradient',
      applied: 'applied torque', x: 'x', y: 'y', z: 'z', along: 'along track', normal: 'orbit normal',
      sun: this._isInUmbra ? 'Sun, behind the Earth' : 'Sun', field: sized('B', row.magnetic_field, 1e6, 'µT'),
      dipole: sized('m', row.dipole_b, 1, 'A m²'),
    };
    Object.entries(texts).forEach(([name, text]) => this.labels.set(name, text, ARROWS[name]));
    description.rotors.forEach(({ name, momentum }, k) => {
      const speed = row.rotor_speed?.[k];
      const says = Number.isFinite(speed)
        ? `${quantity(speed)} rad/s, ${quantity(speed * 30 / Math.PI)} rpm` : `${quantity(momentum)} N m s`;
      this.labels.set(`rotor ${k}`, `${name} ${says}`, '--wheel-text');
    });
    description.cones.forEach(({ name }, k) => this.labels.set(`cone ${k}`, name, '--cone'));
    description.nozzles.forEach(({ name }, k) => {
      const used = row.propellant?.[k];
      this.labels.set(`nozzle ${k}`, Number.isFinite(used) ? `${name} ${quantity(1000 * used)} g used` : name, '--plume');
    });
  }

  _draw(now) {
    if (!this.width) return;
    const begin = performance.now();
    this._render();
    if (!this.row) return;
    if (this.isSoftware) this._rest(begin);
    this._labelTexts();
    const points = new Map();
    const at = new THREE.Vector3();
    const project = (key, isShown, room, isOutside = false) => {
      const isHidden = isShown && this._isBehindBody(at);
      if (isShown) at.project(this.camera);
      this.labels.dim(key, isHidden);
      const [x, y] = this._pixels(at);
      const position = isOutside ? this._sideOf(x, y) : undefined;
      points.set(key, isShown && at.z < 1 ? { x, y, room, position } : null);
    };
    const pixels = this.height / (2 * Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.position.length());
    for (const [name, made] of Object.entries(this.arrows)) {
      at.copy(made.tip).applyQuaternion(made.parent.quaternion);
      project(name, made.visible, 7, name === 'sun' || name === 'field');
    }
    this.wheels.forEach((made, k) => {
      at.copy(made.position).applyQuaternion(this.inBody.quaternion);
      project(`rotor ${k}`, true, 0.24 * this._wheelSize * pixels);
    });
    this.cones.forEach((made, k) => {
      at.copy(made.position).add(made.end).applyQuaternion(this.inBody.quaternion);
      project(`cone ${k}`, true, 7);
    });
    this.plumes.forEach((made, k) => {
      at.copy(made.position).add(made.end).applyQuaternion(this.inBody.quaternion);
      project(`nozzle ${k}`, true, 7);
    });
    this.labels.place(points, this._corners(), this.covered, this.width, this.height);
    this.frames.push(now);
    if (this.frames.length > 600) this.frames.splice(0, 300);
    if (!this.isSoftware) this._keepPace(now);
  }

  _render() {
    if (this.row && this.description && !this.isPlaced) this._place();
    this.world.visible = Boolean(this.row);
    this.renderer.render(this.world, this.camera);
  }

  // Where a projected point is [px].
  _pixels({ x, y }) { return [((x + 1) / 2) * this.width, ((1 - y) / 2) * this.height]; }

  // The side of a point that is furthest from the middle, where its arrow does not lie.
  _sideOf(x, y) {
    const [right, down] = [x - this.width / 2, y - this.height / 2];
    return Math.abs(right) > Math.abs(down) ? Number(right < 0) : 2 + Number(down > 0);
  }

  // The corners of the body [px].
  _corners() {
    const [a, b, c] = this.description.body.edges.map((edge) => edge / 2);
    this.solid.updateWorldMatrix(true, false);
    const signs = [-1, 1];
    return signs.flatMap((i) => signs.flatMap((j) => signs.map((k) => this._pixels(
      new THREE.Vector3(i * a, j * b, k * c).applyMatrix4(this.solid.matrixWorld).project(this.camera),
    ))));
  }

  // Whether the body is between the camera and a point: does the line of sight cross the box?
  _isBehindBody(point) {
    const { edges } = this.description.body;
    this.solid.updateWorldMatrix(true, false);
    const toBox = this.solid.matrixWorld.clone().invert();
    const [from, to] = [this.camera.position, point].map((v) => v.clone().applyMatrix4(toBox).toArray());
    let [enter, leave] = [0, 1];
    edges.forEach((edge, k) => {
      const ends = [-edge / 2, edge / 2].map((side) => (side - from[k]) / (to[k] - from[k] || 1e-12));
      enter = Math.max(enter, Math.min(...ends));
      leave = Math.min(leave, Math.max(...ends));
    });
    return enter < leave;
  }

  // Without a graphics processor every pixel stays sharp: the scene is drawn less often, for two
  // thirds of the time the processor is free, and in a smaller picture where that is too seldom.
  _rest(begin) {
    const context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4)); // waits for the picture
    const end = performance.now();
    this.restUntil = end + Math.min(2 * (end - begin), LONGEST_REST);
    this.slow = end - begin > SLOWEST_DRAW ? (this.slow ?? 0) + 1 : 0;
    if (this.slow < 10 || this.share < 0.6) return;
    this.slow = 0;
    this.share *= 0.8;
    this.box.classList.add('smaller');
    this.box.style.inset = `${50 * (1 - this.share)}%`; // the observer of its size does the rest
  }

  // A slow graphics processor draws fewer pixels, not fewer frames.
  _keepPace(now) {
    const recent = this.frames.slice(-30);
    if (recent.length < 30 || now - (this.paceSet ?? 0) < 2500) return;
    const each = (recent[29] - recent[0]) / 29;
    if (each < 30 || each > 300 || this.sharpness <= 0.4) return;
    this.paceSet = now;
    this.sharpness *= 0.8;
    this._resize();
  }

  _resize() {
    const { width, height } = this.box.getBoundingClientRect();
    if (!width || !height) return;
    [this.width, this.height] = [width, height];
    this._measureCover();
    this.renderer.setPixelRatio(this.isSoftware ? 1 : Math.min(devicePixelRatio, 2) * this.sharpness);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    // A narrow picture is seen from further away, so that it shows as much.
    this.camera.fov = width < height ? 44 : 36;
    this.camera.updateProjectionMatrix();
    // At once, because a resized canvas is empty; the labels follow with the next frame.
    this._render();
    this.redraw();
  }

  // Measured here, not with every frame, because measuring is slow.
  _measureCover() {
    const { left, top } = this.box.getBoundingClientRect();
    this.covered = this.over.map((element) => element.getBoundingClientRect()).map((room) => (
      { left: room.left - left, top: room.top - top, right: room.right - left, bottom: room.bottom - top }));
  }

  _resetCamera() {
    const distance = this.box.clientWidth < this.box.clientHeight ? 6.6 : 5.6;
    const height = this.view === 'orbit' ? 0.16 : 0.3;
    this.camera.position.set(0.42, height, 0.9).normalize().multiplyScalar(distance);
    this.controls.target.set(0, this.view === 'orbit' ? -0.15 : 0, 0);
    this.controls.update();
    this.redraw();
  }
}

// WebGL looks along -Z with Y up: z of LVLH and body goes down, Z of inertial axes goes up.
Scene.Z_DOWN = [Math.SQRT1_2, 0, 0, Math.SQRT1_2];
Scene.Z_UP = [-Math.SQRT1_2, 0, 0, Math.SQRT1_2];
Scene.LAMP = [3, 4, 5]; // where the light comes from if not from the Sun

// Whether there is no graphics processor.
function drawsInSoftware() {
  const context = document.createElement('canvas').getContext('webgl2');
  const info = context?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

function starField() {
  let seed = 7;
  const random = () => { seed = (seed * 16807) % 2147483647; return seed / 2147483647; };
  const points = [];
  for (let k = 0; k < 700; k += 1) {
    const [z, a] = [2 * random() - 1, 2 * Math.PI * random()];
    points.push(700 * Math.sqrt(1 - z * z) * Math.cos(a), 700 * Math.sqrt(1 - z * z) * Math.sin(a), 700 * z);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
  const stars = new THREE.Points(geometry, new THREE.PointsMaterial({
    size: 1.5, sizeAttenuation: false, depthTest: false, depthWrite: false,
  }));
  stars.renderOrder = -4;
  return stars;
}
