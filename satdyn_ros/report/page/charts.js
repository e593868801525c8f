'use strict';
// Charts over one time axis, synchronised with the scene: lines, or bands where a line would mislead.

const DEGREES = 180 / Math.PI;
const TIME_STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400];
const TIME_INCREMENTS = [
  ...[-6, -5, -4, -3, -2, -1].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power)),
  ...TIME_STEPS, ...[1, 2, 3, 4, 5, 6, 7].flatMap((power) => [2, 5, 10].map((k) => 8640 * k * 10 ** power)),
];
const ANGLE_INCREMENTS = [-4, -3, -2, -1, 0].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power)).concat([10, 15, 30, 45, 90, 180]);
const READ_EACH = 200; // [ms]
const DASHES = [[], [7, 3], [2, 2], [9, 3, 2, 3]];

// The charts of a description, each with its lines by name; values(rows, i) in SI units.
function panelsOf(description) {
  const { has_lvlh: hasLvlh, rotors, integrals } = description;
  const attitude = (rows, i) => Rotation.rollPitchYaw(hasLvlh
    ? Rotation.multiply(Rotation.conjugate(rows.get('q_il', i)), rows.get('q_ib', i)) : rows.get('q_ib', i));
  const panels = [
    {
      name: 'attitude', title: `attitude to ${hasLvlh ? 'LVLH' : 'inertial axes'}`, lines: ['roll', 'pitch', 'yaw'],
      colours: ['--x', '--y', '--z'], unit: 'deg', scale: DEGREES, values: attitude, wraps: 360,
    },
    {
      name: 'rate', title: 'body rate', lines: ['ω x', 'ω y', 'ω z'], colours: ['--x', '--y', '--z'],
      unit: 'deg/s', scale: DEGREES, isScaled: true, values: (rows, i) => rows.get('omega_bi_b', i),
    },
    {
      name: 'torque', title: 'gravity gradient', lines: ['x', 'y', 'z'], colours: ['--x', '--y', '--z'],
      unit: 'N m', scale: 1, isScaled: true, values: (rows, i) => rows.get('torque_b', i),
    },
  ];
  if (rotors.some(({ mode }) => mode !== 'constant_momentum')) {
    panels.push({
      name: 'rotor_speed', title: 'rotor speed', lines: rotors.map(({ name }) => name), unit: 'rad/s', scale: 1,
      colours: ['--line-1', '--line-2', '--line-3', '--line-4', '--line-5', '--line-6'],
      values: (rows, i) => rows.get('rotor_speed', i),
    });
  }
  if (integrals.length) {
    panels.push({
      name: 'drift', title: 'drift of first integrals', lines: integrals.map((name) => name.replaceAll('_', ' ')),
      colours: ['--line-1', '--line-2', '--line-3', '--line-4', '--line-5', '--line-6'],
      unit: 'relative', scale: 1, isLog: true, values: (rows, i) => rows.get('drift', i),
    });
  }
  return panels;
}

const SENSOR_LOOKS = {
  gyro: { title: 'gyro error, 3 σ about the bias', unit: 'rad/s', scale: 1, isScaled: true },
  star_tracker: { title: 'star tracker error, 3 σ', unit: 'arcsec', scale: DEGREES * 3600 },
};

// A chart of each sensor's errors, by the sensors' names as in html.playable.
function sensorPanels(sensors) {
  return Object.entries(sensors).map(([name, { table, sigma }]) => {
    const errors = new Errors(table, sigma);
    return {
      name, ...SENSOR_LOOKS[name], lines: ['x', 'y', 'z'], colours: ['--x', '--y', '--z'], errors,
      values: (rows, i) => errors.at(i),
    };
  });
}

// The errors of a sensor at times of its own.
class Errors {
  constructor({ rows, columns }, sigma) {
    for (const [name, column] of Object.entries(columns)) this[name] = Rows.decoded(column);
    Object.assign(this, { length: rows, sigma });
  }

  at(i) { return Array.from(this.error.subarray(3 * i, 3 * i + 3)); }

  // The last sample not after a time; none before the first.
  before(time) {
    const i = Rows.last(this.length, (k) => this.t_s[k] <= time);
    return this.t_s[i] <= time ? this.at(i) : [];
  }

  // The edges of the noise about axis k.
  edges(k) {
    return [-3, 3].map((sign) => Array.from({ length: this.length }, (_, i) => this.systematic[3 * i + k] + sign * this.sigma[k]));
  }
}

class Charts {
  // seek(time): called where a chart is clicked.  marks: {events: [{t_s, kind}], driven: [[a, b]]}.
  // zoomed(from, to), where set: called when another part of the time is chosen.
  constructor(box, seek) {
    Object.assign(this, { box, seek, marks: { events: [], driven: [] }, charts: [] });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.charts.forEach(({ plot }) => plot.redraw(false));
    });
  }

  // Make the charts of a description; bands: {rows: [i ...], least, most}, Rows of the same curves;
  // sensors: as in html.playable.
  describe(description, bands = null, sensors = {}) {
    this.clear();
    this.bands = bands;
    this.charts = [...panelsOf(description), ...sensorPanels(sensors)].map((panel) => ({ panel, ...this._header(panel) }));
    this.charts.forEach((chart, k) => { chart.isLast = k === this.charts.length - 1; });
  }

  // Remove all charts until the next description.
  clear() {
    this.charts.forEach(({ plot, sized }) => { sized?.disconnect(); plot?.destroy(); });
    this.box.replaceChildren();
    this.charts = [];
  }

  // Draw all rows.
  draw(rows) {
    const times = rows.has('t_s') ? Array.from(rows.columns.t_s.values.subarray(0, rows.length)) : [];
    for (const chart of this.charts) {
      const { errors } = chart.panel;
      const data = errors ? this._within(times, [Array.from(errors.t_s), ...this._curves(chart, errors)])
        : [times, ...this._curves(chart, rows)];
      if (chart.plot) chart.plot.setData(data);
      else this._plot(chart, data);
    }
  }

  // Move the cursor to a time, and show the values there.
  point(time, row, isMoving = false) {
    const single = { get: (name) => row[name] };
    // The line moves at every frame, the numbers change a few times a second.
    const reads = performance.now() - (this.readAt ?? 0) > READ_EACH || !isMoving;
    if (reads) this.readAt = performance.now();
    for (const { panel, plot, says, values, chosen } of this.charts) {
      if (!plot) continue;
      const left = plot.valToPos(time, 'x');
      const isInside = left >= 0 && left <= plot.over.clientWidth;
      chosen.style.transform = `translateX(${left}px)`;
      chosen.style.visibility = isInside ? 'visible' : 'hidden';
      if (!reads) continue;
      const now = panel.errors ? panel.errors.before(time) : panel.values(single, 0) ?? [];
      values.forEach((element, k) => {
        const value = now[k];
        element.textContent = Number.isFinite(value)
          ? panel.isLog ? (value ? value.toExponential(1).replaceAll('-', '−') : '0') : fixed(value * says.scale * panel.scale, says.digits) : '–';
      });
    }
  }

  _header(panel) {
    const figure = document.createElement('figure');
    figure.className = 'chart';
    const caption = document.createElement('figcaption');
    caption.innerHTML = '<b></b> <i></i><span class="keys"></span>';
    caption.querySelector('b').textContent = panel.title;
    const keys = caption.querySelector('.keys');
    const values = panel.lines.map((name, k) => {
      const key = document.createElement('span');
      key.className = 'key';
      key.style.setProperty('--colour', `var(${panel.colours[k % panel.colours.length]})`);
      key.innerHTML = '<svg width="22" height="8" aria-hidden="true"><line x1="1" x2="21" y1="4" y2="4"/></svg><span></span> <output></output>';
      key.querySelector('line').setAttribute('stroke-dasharray', dashOf(panel, k).join(' '));
      key.querySelector('span').textContent = name;
      keys.append(key);
      return key.querySelector('output');
    });
    const place = document.createElement('div');
    figure.append(caption, place);
    this.box.append(figure);
    return { figure, place, values, unit: caption.querySelector('i') };
  }

  // One array per line and, where there are bands, two more for its least and most.
  _curves(chart, rows) {
    const { panel } = chart;
    const count = panel.lines.length;
    const lines = panel.lines.map(() => new Array(rows.length));
    let largest = 0;
    for (let i = 0; i < rows.length; i += 1) {
      const values = panel.values(rows, i) ?? [];
      for (let k = 0; k < count; k += 1) {
        const value = values[k];
        const isNumber = Number.isFinite(value);
        lines[k][i] = isNumber ? (panel.isLog && value <= 0 ? null : value * panel.scale) : null;
        if (lines[k][i] !== null) largest = Math.max(largest, Math.abs(lines[k][i]));
      }
    }
    const isBanded = this.bands && panel.name in this.bands.least;
    const edges = panel.errors ? this._sigmas(panel) : isBanded ? this._edges(panel) : [];
    for (const edge of edges) for (const value of edge) if (value !== null) largest = Math.max(largest, Math.abs(value));
    chart.says = panel.isScaled ? prefixed(largest, panel.unit) : { scale: 1, unit: panel.unit };
    chart.says.digits = digitsOf(largest * chart.says.scale);
    chart.unit.textContent = `[${chart.says.unit}]`;
    if (isBanded) for (const line of lines) for (const i of this.bands.rows) line[i] = null;
    const all = [...lines, ...edges];
    if (chart.says.scale !== 1) for (const line of all) line.forEach((y, i) => { if (y !== null) line[i] = y * chart.says.scale; });
    if (panel.wraps) lines.forEach((line) => openWraps(line, panel.wraps));
    return all;
  }

  // Curves with times of their own, over the time axis of all.
  _within(times, curves) {
    const ends = [times[0], times[times.length - 1]];
    return curves.map((curve, k) => (k ? [null, ...curve, null] : [ends[0], ...curve, ends[1]]));
  }

  _sigmas(panel) {
    return panel.lines.flatMap((_, k) => panel.errors.edges(k).map((edge) => edge.map((y) => y * panel.scale)));
  }

  _edges(panel) {
    const count = panel.lines.length;
    return panel.lines.flatMap((_, k) => [this.bands.least, this.bands.most].map((bounds) => {
      const edge = new Array(this.bands.length).fill(null);
      for (const i of this.bands.rows) edge[i] = bounds[panel.name][i * count + k] * panel.scale;
      return edge;
    }));
  }

  _plot(chart, data) {
    const { panel } = chart;
    const style = getComputedStyle(this.box);
    const colour = (name) => () => style.getPropertyValue(name).trim();
    const of = (k) => colour(panel.colours[k % panel.colours.length]);
    const lines = panel.lines.map((_, k) => ({
      stroke: of(k), width: panel.errors ? 0.8 : 1.6, dash: dashOf(panel, k), points: { show: false }, spanGaps: false,
    }));
    const edges = new Array(data.length - 1 - lines.length).fill(null).map(() => ({ points: { show: false }, stroke: null }));
    const axis = { stroke: colour('--text-quiet'), grid: { stroke: colour('--grid'), width: 1 }, ticks: { show: false }, font: '11px system-ui, sans-serif' };
    chart.plot = new uPlot({
      ...this._size(chart),
      series: [{}, ...lines, ...edges],
      bands: edges.filter((_, k) => k % 2).map((_, k) => ({
        series: [lines.length + 2 + 2 * k, lines.length + 1 + 2 * k],
        fill: () => `color-mix(in srgb, ${of(k)()} 35%, transparent)`,
      })),
      scales: { x: { time: false }, y: panel.isLog ? { distr: 3 } : { range: paddedRange } },
      axes: [
        {
          ...axis, size: chart.isLast ? 34 : 6, incrs: TIME_INCREMENTS, space: 60, gap: 3,
          label: chart.isLast ? ' ' : undefined, labelSize: chart.isLast ? 2 : 0,
          values: chart.isLast ? (plot, splits) => timeTicks(plot, splits) : () => [],
        },
        {
          ...axis, size: 60, gap: 3, space: 22, incrs: panel.wraps ? ANGLE_INCREMENTS : undefined,
          splits: panel.isLog ? decades : undefined, values: panel.isLog ? powers : asSteps,
        },
      ],
      legend: { show: false },
      padding: [6, 10, 0, 0],
      cursor: { y: false, points: { show: false }, drag: { x: true, y: false } },
      hooks: {
        drawClear: [(plot) => this._drawMarks(plot, colour)],
        setScale: [(plot, key) => { if (key === 'x') this._follow(plot); }],
      },
    }, data, chart.place);
    chart.chosen = document.createElement('div');
    chart.chosen.className = 'now';
    chart.plot.over.append(chart.chosen);
    this._listen(chart.plot);
    chart.sized = new ResizeObserver(() => chart.plot.setSize(this._size(chart)));
    chart.sized.observe(chart.figure);
  }

  _size({ figure, place, isLast }) {
    const caption = figure.firstElementChild.offsetHeight;
    const height = figure.clientHeight - caption;
    return { width: Math.max(place.clientWidth, 100), height: Math.max(height, isLast ? 96 : 70) };
  }

  _listen(plot) {
    let begun = 0;
    plot.over.addEventListener('pointerdown', (event) => { begun = event.clientX; });
    plot.over.addEventListener('click', (event) => {
      if (Math.abs(event.clientX - begun) < 4) this.seek(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, 'x'));
    });
  }

  // All charts show the same time.
  _follow({ scales: { x } }) {
    if (this.following) return;
    this.following = true;
    for (const { plot } of this.charts) {
      if (plot && (plot.scales.x.min !== x.min || plot.scales.x.max !== x.max)) plot.setScale('x', { min: x.min, max: x.max });
    }
    this.following = false;
    this.zoomed?.(x.min, x.max);
  }

  _drawMarks(plot, colour) {
    const { ctx: context, bbox: { left, top, width, height } } = plot;
    const at = (time) => Math.max(left, Math.min(left + width, plot.valToPos(time, 'x', true)));
    context.save();
    context.fillStyle = colour('--driven')();
    for (const [begin, end] of this.marks.driven) context.fillRect(at(begin), top, Math.max(at(end) - at(begin), 1), height);
    for (const { t_s: time, kind } of this.marks.events) {
      if (time < plot.scales.x.min || time > plot.scales.x.max) continue;
      context.fillStyle = colour(kind === 'restart' ? '--restart' : '--text-quiet')();
      context.fillRect(Math.round(at(time)) - devicePixelRatio / 2, top, devicePixelRatio, height);
    }
    context.restore();
  }
}

// In noise dashes could not be told apart.
function dashOf(panel, k) { return panel.errors ? [] : DASHES[k % 4]; }

// A gap where an angle wraps: a line across the chart would show values that it never has.
function openWraps(line, period) {
  let before = null;
  for (let i = 0; i < line.length; i += 1) {
    const now = line[i];
    if (now !== null && before !== null && Math.abs(now - before) > period / 2) line[i] = null;
    before = now;
  }
}

function paddedRange(plot, least, most) {
  if (least === null || !(most > least)) {
    const middle = least ?? 0;
    const room = Math.max(Math.abs(middle) * 0.1, 1e-3);
    return [middle - room, middle + room];
  }
  const room = 0.06 * (most - least);
  return [least - room, most + room];
}

function timeTicks(plot, splits) {
  const span = plot.scales.x.max - plot.scales.x.min;
  const { seconds, name } = timeUnit(span);
  return splits.map((time, k) => {
    const text = String(Number((time / seconds).toPrecision(9))).replace('-', '−');
    return k === Math.max(0, splits.length - 2) ? `${text} ${name}` : text;
  });
}

// As many digits as their steps need.
function asSteps(plot, splits, axis, space, step) {
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const isLarge = splits.some((y) => Math.abs(y) >= 1e5);
  return splits.map((y) => (isLarge ? quantity(y) : String(Number(y.toFixed(digits))).replace('-', '−')));
}

function decades(plot, axis, least, most) {
  const [low, high] = [Math.ceil(Math.log10(least) - 1e-9), Math.floor(Math.log10(most) + 1e-9)];
  const every = Math.max(1, Math.ceil((high - low) / 4));
  const powersOfTen = [];
  for (let power = low; power <= high; power += every) powersOfTen.push(10 ** power);
  return powersOfTen;
}

function powers(plot, splits) {
  const upper = (text) => [...text].map((c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'[c] ?? '⁻').join('');
  return splits.map((y) => {
    const power = Math.log10(y);
    return Math.abs(power - Math.round(power)) < 1e-6 ? `10${upper(String(Math.round(power)))}` : '';
  });
}
