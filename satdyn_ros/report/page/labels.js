'use strict';
// Labels over the scene: text that faces the viewer, beside the body and beside other text.

class Labels {
  constructor(box) {
    this.box = box;
    this.labels = new Map(); // in order of priority
  }

  // Name a point; colour is a custom property of the style sheet.
  set(key, text, colour) {
    let label = this.labels.get(key);
    if (!label) {
      const element = document.createElement('span');
      element.className = 'label';
      const leader = document.createElement('i');
      leader.className = 'leader';
      this.box.append(leader, element);
      label = { element, leader, text: '', position: 0 };
      this.labels.set(key, label);
    }
    if (label.text !== text) {
      label.text = text;
      label.element.textContent = text;
      label.width = label.element.offsetWidth;
      label.height = label.element.offsetHeight;
    }
    label.element.style.color = label.leader.style.color = `var(${colour})`;
  }

  // Fade a label whose point is hidden.
  dim(key, isHidden) {
    const { element, leader } = this.labels.get(key);
    element.style.opacity = leader.style.opacity = isHidden ? 0.5 : 1;
  }

  remove(key) {
    const { element, leader } = this.labels.get(key);
    element.remove();
    leader.remove();
    this.labels.delete(key);
  }

  clear() { [...this.labels.keys()].forEach((key) => this.remove(key)); }

  // Put each label beside its point [px], or hide it: points is a map of keys to null or {x, y, room,
  // position}: room is kept free around it, position, where given, is that of POSITIONS to begin with; corners
  // [px] are those of the body, if there is one, covered the rooms of what lies over the scene.
  place(points, corners, covered, width, height) {
    const outline = hull(corners);
    const taken = [...covered];
    for (const [key, label] of this.labels) {
      const point = points.get(key);
      const free = point && this._freePosition(label, point, taken, outline, width, height);
      label.element.style.visibility = free ? 'visible' : 'hidden';
      label.leader.style.visibility = 'hidden';
      if (!free) continue;
      taken.push(free);
      label.element.style.transform = `translate(${free.left.toFixed(1)}px, ${free.top.toFixed(1)}px)`;
      this._lead(label.leader, point, free);
    }
  }

  _freePosition(label, { x, y, room: away, position: first = label.position }, taken, outline, width, height) {
    const isFree = (room) => room.left >= 4 && room.top >= 4 && room.right <= width - 4 && room.bottom <= height - 4
      && taken.every((other) => room.left > other.right + 4 || room.right < other.left - 4
        || room.top > other.bottom + 1 || room.bottom < other.top - 1) && !touches(outline, room);
    const roomAt = (left, top) => ({ left, top, right: left + label.width, bottom: top + label.height });
    const count = Labels.POSITIONS.length;
    for (let k = 0; k < count; k += 1) {
      // Its previous position comes first, so that labels do not jump.
      const position = (first + k) % count;
      const [right, down] = Labels.POSITIONS[position];
      const room = roomAt(
        x + right * (label.width / 2 + away) - label.width / 2, y + down * (label.height / 2 + away) - label.height / 2,
      );
      if (isFree(room)) {
        label.position = position;
        return room;
      }
    }
    if (!outline.length) return null;
    // Before or behind the body: beside it, on the side that is nearest, with a line to the point.
    const centre = [0, 1].map((c) => outline.reduce((sum, corner) => sum + corner[c], 0) / outline.length);
    const outward = Math.atan2(y - centre[1], x - centre[0]);
    for (let distance = 20; distance < width; distance += 12) {
      for (const turn of [0, 0.35, -0.35, 0.7, -0.7]) {
        const [right, down] = [Math.cos(outward + turn), Math.sin(outward + turn)];
        const room = roomAt(
          x + right * (distance + label.width / 2) - label.width / 2, y + down * (distance + label.height / 2) - label.height / 2,
        );
        if (isFree(room)) return room;
      }
    }
    return null;
  }

  // A line from a point to a label that is not beside it.
  _lead(leader, { x, y, room }, { left, top, right, bottom }) {
    const [across, down] = [Math.max(left, Math.min(x, right)) - x, Math.max(top, Math.min(y, bottom)) - y];
    const length = Math.hypot(across, down);
    if (length < room + 16) return;
    leader.style.visibility = 'visible';
    leader.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) rotate(${Math.atan2(down, across)}rad) scaleX(${length - 3})`;
  }
}

// The corners of the convex outline of points [x, y], in turn (Andrew's monotone chain).
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (chain, [x, y]) => {
    const turnsBack = ([a, b], [c, d]) => (c - a) * (y - b) - (d - b) * (x - a) <= 0;
    while (chain.length > 1 && turnsBack(chain[chain.length - 2], chain[chain.length - 1])) chain.pop();
    chain.push([x, y]);
    return chain;
  };
  return [...sorted.reduce(half, []).slice(0, -1), ...sorted.reverse().reduce(half, []).slice(0, -1)];
}

// Whether a convex outline and a rectangle have points in common: no side of either parts them.
function touches(outline, { left, top, right, bottom }) {
  const within = (c, least, most) => outline.some((corner) => corner[c] > least) && outline.some((corner) => corner[c] < most);
  const corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
  return within(0, left, right) && within(1, top, bottom) && outline.every(([a, b], k) => {
    const [c, d] = outline[(k + 1) % outline.length];
    return corners.some(([x, y]) => (c - a) * (y - b) - (d - b) * (x - a) > 0);
  });
}

// Beside, above, below, at the corners, then further away: in half widths and heights.
Labels.POSITIONS = [
  [1, 0], [-1, 0], [0, -1], [0, 1], [1, -1], [-1, -1], [1, 1], [-1, 1],
  [0, -2.2], [0, 2.2], [1, -2.2], [-1, -2.2], [1, 2.2], [-1, 2.2],
];
