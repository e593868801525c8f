'use strict';
// The objects of the scene: body, plates, wheels, cones, arrows and paths, each around its own origin.

const PLATE_THICKNESS = 0.01;

function arrow(radius) {
  const group = new THREE.Group();
  group.visible = false; // until it points somewhere
  const material = new THREE.MeshLambertMaterial();
  const shaft = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 16).translate(0, 0.5, 0), material);
  const head = new THREE.Mesh(new THREE.ConeGeometry(3.2 * radius, 9 * radius, 20).translate(0, -4.5 * radius, 0), material);
  group.add(shaft, head);
  group.tip = new THREE.Vector3();
  const up = new THREE.Vector3(0, 1, 0);
  // Point along a vector of the parent's axes; one too short to see is hidden.
  group.point = (x, y, z) => {
    group.tip.set(x, y, z);
    const length = group.tip.length();
    group.visible = length > 12 * radius;
    if (!group.visible) return;
    group.quaternion.setFromUnitVectors(up, group.tip.clone().divideScalar(length));
    shaft.scale.y = length - 8 * radius;
    head.position.y = length;
  };
  group.paint = (colour) => {
    material.color.set(colour);
    material.emissive.set(colour).multiplyScalar(0.45);
  };
  return group;
}

// A solid box of edges (3), the longest 1; the pattern shows how it turns.
function bodySolid(edges) {
  const group = new THREE.Group();
  const geometry = new THREE.BoxGeometry(...edges);
  const materials = [[1, 2], [1, 2], [0, 2], [0, 2], [0, 1], [0, 1]].map(([across, up]) => (
    new THREE.MeshLambertMaterial({ map: panelTexture(edges[across], edges[up]) })));
  const lines = new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial());
  group.add(new THREE.Mesh(geometry, materials), lines);
  group.paint = (solid, edge) => {
    materials.forEach((material) => material.color.set(solid));
    lines.material.color.set(edge);
  };
  return group;
}

// A square plate with a normal, about which it is turned anyhow.
function plate({ normal, position, edge }) {
  const group = new THREE.Group();
  const geometry = new THREE.BoxGeometry(edge, edge, PLATE_THICKNESS);
  const material = new THREE.MeshLambertMaterial({ map: panelTexture(edge, edge) });
  const lines = new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial());
  group.add(new THREE.Mesh(geometry, material), lines);
  group.position.set(...position);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal));
  group.paint = (colour, edgeColour) => {
    material.color.set(colour);
    lines.material.color.set(edgeColour);
  };
  return group;
}

// What a sensor sees, or must not see: a cone about an axis from the origin of its group on.
function cone({ axis, half_angle: angle }, length) {
  const group = new THREE.Group();
  const [high, wide] = [length * Math.cos(angle), length * Math.sin(angle)];
  const geometry = new THREE.ConeGeometry(wide, high, 48, 1, true).translate(0, -high / 2, 0);
  const [faint, seen] = [0.14, 0.7].map((opacity) => ({ transparent: true, opacity, depthWrite: false }));
  const side = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ ...faint, side: THREE.DoubleSide }));
  const onRim = (k) => [wide * Math.sin((k * Math.PI) / 24), -high, wide * Math.cos((k * Math.PI) / 24)];
  const rim = Array.from({ length: 48 }, (_, k) => [...onRim(k), ...onRim(k + 1)]).flat();
  const line = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(seen));
  line.geometry.setAttribute('position', new THREE.Float32BufferAttribute(rim, 3));
  group.add(side, line);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, -1, 0), new THREE.Vector3(...axis));
  group.end = new THREE.Vector3(...axis).multiplyScalar(Math.max(high, 0.3 * length));
  group.paint = (colour) => [side, line].forEach(({ material }) => material.color.set(colour));
  return group;
}

// The plume of a thruster, from the origin of its group on, against its force; show(share) of the thrust.
function plume({ direction, position }, length) {
  const group = new THREE.Group();
  const material = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.55, depthWrite: false });
  const cone = new THREE.Mesh(new THREE.ConeGeometry(0.3 * length, length, 24, 1, true).translate(0, -length / 2, 0), material);
  material.side = THREE.DoubleSide;
  group.add(cone);
  group.position.set(...position);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...direction));
  group.end = new THREE.Vector3(0, -length, 0).applyQuaternion(group.quaternion);
  group.show = (share) => {
    group.visible = share > 0;
    // A short pulse is seen too.
    group.scale.setScalar(0.35 + 0.65 * Math.min(share, 1));
  };
  group.show(0);
  group.paint = (colour) => material.color.set(colour);
  return group;
}

function panelTexture(width, height) {
  const canvas = document.createElement('canvas');
  const pixels = (edge) => Math.max(16, Math.round(256 * edge));
  [canvas.width, canvas.height] = [pixels(width), pixels(height)];
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, canvas.width, canvas.height);
  const cells = (size) => Math.max(1, Math.round(size / 36));
  const [columns, rows] = [cells(canvas.width), cells(canvas.height)];
  const [wide, high] = [canvas.width / columns, canvas.height / rows];
  for (let i = 0; i < columns; i += 1) {
    for (let j = 0; j < rows; j += 1) {
      context.fillStyle = (i + j) % 2 ? '#e6e9ee' : '#d9dde4';
      context.fillRect(i * wide + 1.5, j * high + 1.5, wide - 3, high - 3);
    }
  }
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

// A wheel about the y axis of its group; turn(angle) turns it.
function wheel(radius) {
  const group = new THREE.Group();
  const turning = new THREE.Group();
  const material = new THREE.MeshLambertMaterial();
  const blur = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0, side: THREE.DoubleSide, depthWrite: false });
  const flat = (geometry) => geometry.rotateX(Math.PI / 2);
  turning.add(new THREE.Mesh(flat(new THREE.TorusGeometry(radius, 0.13 * radius, 12, 48)), material));
  for (let k = 0; k < 3; k += 1) {
    const spoke = new THREE.CylinderGeometry(0.05 * radius, 0.05 * radius, 2 * radius, 8).rotateZ(Math.PI / 2);
    turning.add(new THREE.Mesh(spoke.rotateY((k * Math.PI) / 3), material));
  }
  const hub = new THREE.Mesh(new THREE.CylinderGeometry(0.2 * radius, 0.2 * radius, 0.3 * radius, 20), material);
  // One bright mark: the eye follows it.
  const mark = new THREE.Mesh(new THREE.SphereGeometry(0.2 * radius, 16, 12).translate(radius, 0, 0), new THREE.MeshBasicMaterial());
  const disc = new THREE.Mesh(flat(new THREE.RingGeometry(0.2 * radius, radius, 48)), blur);
  turning.add(hub, mark);
  group.add(turning, disc);
  group.turn = (angle, isBlurred) => {
    turning.rotation.y = angle;
    blur.opacity = isBlurred ? 0.28 : 0;
  };
  group.paint = (colour, bright) => {
    material.color.set(colour);
    mark.material.color.set(bright);
    blur.color.set(colour);
  };
  return group;
}

// A path of a limited number of points that fades towards its start.
class Path {
  constructor(points, width) {
    this.geometry = new THREE.LineGeometry();
    this.geometry.setPositions(new Float32Array(3 * points));
    this.geometry.setColors(new Float32Array(3 * points));
    this.material = new THREE.LineMaterial({ linewidth: width, vertexColors: true });
    this.line = new THREE.Line2(this.geometry, this.material);
    this.line.frustumCulled = false;
    this.line.visible = false;
    this.points = points;
    this.segments = this.geometry.attributes.instanceStart.data;
    this.shades = this.geometry.attributes.instanceColorStart.data;
  }

  // Draw through count points, each written by pointAt(k, array, offset), the last the latest.
  draw(count, pointAt) {
    this.line.visible = count > 1;
    if (count < 2) return;
    const ends = this.segments.array;
    for (let k = 0; k < count; k += 1) {
      if (k < count - 1) pointAt(k, ends, 6 * k);
      else pointAt(k, ends, 6 * k - 3);
      if (k > 0 && k < count - 1) ends.copyWithin(6 * k - 3, 6 * k, 6 * k + 3);
    }
    if (count !== this.geometry.instanceCount + 1) this._shade(count);
    this.geometry.instanceCount = count - 1;
    this.segments.needsUpdate = true;
  }

  paint(colour, background) {
    this.colours = [new THREE.Color(background), new THREE.Color(colour)];
    this._shade(this.geometry.instanceCount + 1);
  }

  _shade(count) {
    const shade = new THREE.Color();
    for (let k = 0; k < count - 1; k += 1) {
      for (const end of [0, 1]) {
        shade.lerpColors(...this.colours, 0.3 + 0.7 * ((k + end) / (count - 1)) ** 1.5);
        shade.toArray(this.shades.array, 6 * k + 3 * end);
      }
    }
    this.shades.needsUpdate = true;
  }
}

// Circles of a unit sphere, for paths to lie on.
function sphereLines(radius) {
  const points = [];
  const circle = (pointOf) => {
    for (let k = 0; k < 96; k += 1) {
      points.push(...pointOf((k * Math.PI) / 48), ...pointOf(((k + 1) * Math.PI) / 48));
    }
  };
  for (let k = 0; k < 6; k += 1) {
    const [c, s] = [Math.cos((k * Math.PI) / 6), Math.sin((k * Math.PI) / 6)];
    circle((a) => [radius * Math.sin(a) * c, radius * Math.sin(a) * s, radius * Math.cos(a)]);
  }
  for (let k = -2; k <= 2; k += 1) {
    const [c, s] = [Math.cos((k * Math.PI) / 6), Math.sin((k * Math.PI) / 6)];
    circle((a) => [radius * c * Math.cos(a), radius * c * Math.sin(a), radius * s]);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.16 }));
}
