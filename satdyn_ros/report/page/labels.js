'use strict';
// Labels over the scene: text that faces the viewer and is never drawn over other text.

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
      this.box.append(element);
      label = { element, text: '', place: 0 };
      this.labels.set(key, label);
    }
    if (label.text !== text) {
      label.text = text;
      label.element.textContent = text;
      label.width = label.element.offsetWidth;
      label.height = label.element.offsetHeight;
    }
    label.element.style.color = `var(${colour})`;
  }

  // Fade a label whose point is hidden.
  dim(key, isHidden) {
    this.labels.get(key).element.style.opacity = isHidden ? 0.5 : 1;
  }

  clear() {
    this.labels.forEach(({ element }) => element.remove());
    this.labels.clear();
  }

  // Put each label beside its point [px], or hide it: points is a map of keys to null or {x, y,
  // room}, which is kept free around it.
  place(points, width, height) {
    const taken = [];
    for (const [key, label] of this.labels) {
      const point = points.get(key);
      const free = point && this._freePlace(label, point, taken, width, height);
      label.element.style.visibility = free ? 'visible' : 'hidden';
      if (!free) continue;
      taken.push(free);
      label.element.style.transform = `translate(${free.left.toFixed(1)}px, ${free.top.toFixed(1)}px)`;
    }
  }

  _freePlace(label, { x, y, room: away }, taken, width, height) {
    const count = Labels.PLACES.length;
    for (let k = 0; k < count; k += 1) {
      // Its previous place comes first, so that labels do not jump.
      const place = (label.place + k) % count;
      const [right, down] = Labels.PLACES[place];
      const left = x + right * (label.width / 2 + away) - label.width / 2;
      const top = y + down * (label.height / 2 + away) - label.height / 2;
      const room = { left, top, right: left + label.width, bottom: top + label.height };
      const inside = room.left >= 4 && room.top >= 4 && room.right <= width - 4 && room.bottom <= height - 4;
      const free = taken.every((other) => room.left > other.right + 4 || room.right < other.left - 4
        || room.top > other.bottom + 1 || room.bottom < other.top - 1);
      if (inside && free) {
        label.place = place;
        return room;
      }
    }
    return null;
  }
}

// Beside, above, below, at the corners, then further away: in half widths and heights.
Labels.PLACES = [
  [1, 0], [-1, 0], [0, -1], [0, 1], [1, -1], [-1, -1], [1, 1], [-1, 1],
  [0, -2.2], [0, 2.2], [1, -2.2], [-1, -2.2], [1, 2.2], [-1, 2.2],
];
