'use strict';
// The planet: correct in direction and apparent size, drawn behind everything else.

class Planet {
  // radius [m]
  constructor(radius) {
    this.radius = radius;
    this.uniforms = {
      deep: { value: new THREE.Color() }, shallow: { value: new THREE.Color() }, air: { value: new THREE.Color() },
      line: { value: new THREE.Color() }, centre: { value: new THREE.Vector3() }, size: { value: 1 },
    };
    // One triangle fills the picture: its rays hit the ball, the air above it, or nothing.
    const picture = new THREE.BufferGeometry();
    picture.setAttribute('position', new THREE.Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    this.ball = new THREE.Mesh(picture, this._material(Planet.BALL));
    this.ball.renderOrder = -3;
    this.graticule = new THREE.LineSegments(graticule(), this._material(Planet.GRATICULE));
    this.graticule.renderOrder = -2;
    this.group = new THREE.Group();
    this.group.add(this.ball, this.graticule);
    for (const part of this.group.children) part.frustumCulled = false;
  }

  // Turn with the inertial axes, at the body's distance [m] from the planet.
  show(q_vi, down_v, distance) {
    const { centre, size } = this.uniforms;
    centre.value.set(...down_v).multiplyScalar(Planet.DISTANCE);
    size.value = Planet.DISTANCE * Math.min(this.radius / distance, 0.9999);
    this.graticule.position.copy(centre.value);
    this.graticule.quaternion.copy(q_vi);
    this.graticule.scale.setScalar(size.value);
  }

  paint(colourOf) {
    for (const name of ['deep', 'shallow', 'line', 'air']) this.uniforms[name].value.set(colourOf(`--planet-${name}`));
  }

  _material({ vertex, fragment }) {
    return new THREE.ShaderMaterial({
      vertexShader: vertex, fragmentShader: fragment, uniforms: this.uniforms,
      // Blended, but drawn first, with the opaque objects.
      depthTest: false, depthWrite: false, blending: THREE.CustomBlending,
    });
  }
}

Planet.DISTANCE = 400; // far beyond the camera's range

Planet.BALL = {
  vertex: `
    varying vec3 ray;
    void main() {
      vec4 far = inverse(projectionMatrix) * vec4(position.xy, 1.0, 1.0);
      ray = (inverse(viewMatrix) * vec4(far.xyz / far.w, 0.0)).xyz;
      gl_Position = vec4(position.xy, 1.0, 1.0);
    }`,
  fragment: `
    uniform vec3 deep, shallow, air, centre;
    uniform float size;
    varying vec3 ray;
    void main() {
      vec3 along = normalize(ray);
      vec3 from = cameraPosition - centre;
      float ahead = -dot(from, along);
      vec3 nearest = from + ahead * along;
      float above = length(nearest) / size - 1.0;
      if (ahead < 0.0 || above > 0.035) discard;
      if (above > 0.0) {
        gl_FragColor = vec4(air, 0.8 * exp(-above / 0.006));
      } else {
        // The cosine between the ray and the vertical where it hits.
        float up = sqrt(max(1.0 - (above + 1.0) * (above + 1.0), 0.0));
        float haze = 1.0 - up;
        haze *= haze * haze;
        gl_FragColor = vec4(mix(mix(shallow, deep, min(up / 0.7, 1.0)), air, 0.8 * haze * haze), 1.0);
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
  const [places, weights] = [[], []];
  const degree = Math.PI / 180;
  const put = (latitude, longitude, weight) => {
    const across = Math.cos(latitude * degree);
    places.push(across * Math.cos(longitude * degree), across * Math.sin(longitude * degree), Math.sin(latitude * degree));
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
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(places, 3));
  geometry.setAttribute('weight', new THREE.Float32BufferAttribute(weights, 1));
  return geometry;
}
