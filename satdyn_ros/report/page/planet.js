'use strict';
// The planet: correct in direction and apparent size, drawn behind everything else.

class Planet {
  // radius [m]; earth: an Earth, or null: without coasts and night.
  constructor(radius, earth) {
    this.radius = radius;
    this.uniforms = {
      deep: { value: new THREE.Color() }, shallow: { value: new THREE.Color() }, air: { value: new THREE.Color() },
      line: { value: new THREE.Color() }, centre: { value: new THREE.Vector3() }, size: { value: 1 },
      night: { value: new THREE.Color() }, sun: { value: new THREE.Vector3() }, isLit: { value: 0 },
    };
    // A cap of rays around the direction to the centre, as wide as the air: they hit the ball, the
    // air above it, or nothing.  Rays that could hit nothing are not drawn at all.
    this.ball = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 48, 12, true), this._material(Planet.BALL));
    this.ball.renderOrder = -3;
    this.graticule = new THREE.LineSegments(graticule(), this._material(Planet.GRATICULE));
    this.graticule.renderOrder = -2;
    this.group = new THREE.Group();
    this.group.add(this.ball, this.graticule);
    if (earth) this.graticule.add(this._coasts(earth));
    this.group.traverse((part) => { part.frustumCulled = false; });
  }

  // Turn with the axes of its graticule, at the body's distance [m] from the planet; sun_v: the
  // direction of the Sun, null: lit from everywhere.
  show(q_vg, down_v, distance, sun_v) {
    this.place(q_vg, down_v.map((c) => Planet.DISTANCE * c), Planet.DISTANCE * Math.min(this.radius / distance, 0.9999), sun_v);
  }

  // The same as a ball of some size about a centre, in the units of the picture.
  place(q_vg, centre_v, radius, sun_v) {
    const { centre, size } = this.uniforms;
    centre.value.set(...centre_v);
    size.value = radius;
    this.graticule.position.copy(centre.value);
    this.graticule.quaternion.set(...q_vg);
    this.graticule.scale.setScalar(size.value);
    this.uniforms.isLit.value = sun_v ? 1 : 0;
    if (sun_v) this.uniforms.sun.value.set(...sun_v);
  }

  paint(colourOf) {
    for (const name of ['deep', 'shallow', 'line', 'air', 'night']) this.uniforms[name].value.set(colourOf(`--planet-${name}`));
    this.coastLine?.value.set(colourOf('--planet-coast'));
  }

  _coasts(earth) {
    const points = earth.coast.flatMap((line) => line.slice(1).flatMap((to, k) => [...Earth.direction(line[k]), ...Earth.direction(to)]));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
    geometry.setAttribute('weight', new THREE.Float32BufferAttribute(new Array(points.length / 3).fill(1), 1));
    this.coastLine = { value: new THREE.Color() };
    const coasts = new THREE.LineSegments(geometry, this._material(Planet.GRATICULE, { line: this.coastLine }));
    coasts.renderOrder = -2;
    return coasts;
  }

  _material({ vertex, fragment }, own = {}) {
    return new THREE.ShaderMaterial({
      vertexShader: vertex, fragmentShader: fragment, uniforms: { ...this.uniforms, ...own },
      // Blended, but drawn first, with the opaque objects.
      depthTest: false, depthWrite: false, blending: THREE.CustomBlending, side: THREE.DoubleSide,
    });
  }
}

Planet.DISTANCE = 400; // far beyond the camera's range

Planet.BALL = {
  vertex: `
    uniform vec3 centre;
    uniform float size;
    varying vec3 ray;
    void main() {
      vec3 down = centre - cameraPosition;
      float sine = 1.036 * size / length(down);
      // A little wider, because the sides of the cap are straight; all around from within the air.
      float widest = sine < 0.98 ? 1.01 * asin(sine) : 3.1416;
      vec3 along = normalize(down);
      vec3 across = normalize(cross(along, abs(along.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
      float angle = widest * uv.y;
      float turn = 6.2831853 * uv.x;
      ray = cos(angle) * along + sin(angle) * (cos(turn) * across + sin(turn) * cross(along, across));
      vec4 seen = projectionMatrix * vec4(mat3(viewMatrix) * ray, 1.0);
      gl_Position = vec4(seen.xy, 0.0, seen.w);
    }`,
  fragment: `
    uniform vec3 deep, shallow, air, centre, night, sun;
    uniform float size, isLit;
    varying vec3 ray;
    // The part of daylight on a vertical: dusk is as wide as the Sun is low.
    float daylight(vec3 vertical) { return 1.0 - isLit * (1.0 - smoothstep(-0.12, 0.06, dot(vertical, sun))); }
    void main() {
      vec3 along = normalize(ray);
      vec3 from = cameraPosition - centre;
      float ahead = -dot(from, along);
      vec3 nearest = from + ahead * along;
      float above = length(nearest) / size - 1.0;
      if (ahead < 0.0 || above > 0.035) discard;
      if (above > 0.0) {
        gl_FragColor = vec4(air, 0.8 * exp(-above / 0.006) * mix(0.25, 1.0, daylight(nearest / length(nearest))));
      } else {
        // The cosine between the ray and the vertical where it hits.
        float up = sqrt(max(1.0 - (above + 1.0) * (above + 1.0), 0.0));
        float haze = 1.0 - up;
        haze *= haze * haze;
        vec3 day = mix(mix(shallow, deep, min(up / 0.7, 1.0)), air, 0.8 * haze * haze);
        gl_FragColor = vec4(mix(night, day, daylight(nearest / size - up * along)), 1.0);
      }
      #include <colorspace_fragment>
    }`,
};

Planet.GRATICULE = {
  vertex: `
    attribute float weight;
    varying float strength;
    void main() {
      vec4 seen = modelViewMatrix * vec4(position, 1.0);
      float up = dot(normalize(normalMatrix * position), -normalize(seen.xyz));
      strength = up < 0.0 ? -1.0 : weight * min(5.0 * up, 1.0);
      gl_Position = projectionMatrix * seen;
    }`,
  fragment: `
    uniform vec3 line;
    varying float strength;
    void main() {
      if (strength < 0.02) discard;
      gl_FragColor = vec4(line, strength);
      #include <colorspace_fragment>
    }`,
};

// Circles of latitude and longitude every 10 deg on the unit sphere, z to the pole.
function graticule() {
  const [points, weights] = [[], []];
  const degree = Math.PI / 180;
  const put = (latitude, longitude, weight) => {
    const across = Math.cos(latitude * degree);
    points.push(across * Math.cos(longitude * degree), across * Math.sin(longitude * degree), Math.sin(latitude * degree));
    weights.push(weight);
  };
  for (let longitude = 0; longitude < 360; longitude += 10) {
    const weight = longitude % 90 ? 0.35 : 0.8;
    for (let at = -80; at < 80; at += 4) {
      put(at, longitude, weight);
      put(at + 4, longitude, weight);
    }
  }
  for (let latitude = -80; latitude <= 80; latitude += 10) {
    const weight = latitude ? 0.35 : 0.8;
    for (let at = 0; at < 360; at += 4) {
      put(latitude, at, weight);
      put(latitude, at + 4, weight);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
  geometry.setAttribute('weight', new THREE.Float32BufferAttribute(weights, 1));
  return geometry;
}
