'use strict';
// Charts over one time axis, synchronised with the scene: lines, or bands where lines would be a slab.

const DEGREES = 180 / Math.PI;
const TIME_STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400];
const TIME_INCREMENTS = [
  ...[-6, -5, -4, -3, -2, -1].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power)),
  ...TIME_STEPS, ...[1, 2, 3, 4, 5, 6, 7].flatMap((power) => [2, 5, 10].map((k) => 8640 * k * 10 ** power)),
];
const ANGLE_INCREMENTS = [-4, -3, -2, -1, 0].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power)).concat([10, 15, 30, 45, 90, 180]);
const READ_EACH = 200; // [ms]
const ROUNDING = 1e-6; // of float32, with room
const DASHES = [[], [7, 3], [2, 2], [9, 3, 2, 3]];
const XYZ = ['--x', '--y', '--z', '--text'];

// The two ways to say how a body is turned to LVLH.
const ANGLES = { attitude: 'roll, pitch, yaw', nadir: 'axis to nadir' };

// The charts of a description, each with its lines by name; values(rows, i) in SI units.  angles: of
// ANGLES.
function panelsOf(description, angles) {
  const { has_lvlh: hasLvlh, least_axis: axis, rotors, integrals, panels: shown } = description;
  const toLvlh = (rows, i) => Rotation.multiply(Rotation.conjugate(rows.get('q_il', i)), rows.get('q_ib', i));
  const nadir = (rows, i) => nadirAngles(toLvlh(rows, i), axis);
  const attitude = (rows, i) => Rotation.rollPitchYaw(hasLvlh ? toLvlh(rows, i) : rows.get('q_ib', i));
  const ways = {
    attitude: {
      title: `attitude to ${hasLvlh ? 'LVLH' : 'inertial axes'}`, wraps: 360, isCircular: true,
      lines: ['roll', 'pitch', 'yaw', ...(axis ? ['nadir'] : [])],
      values: axis ? (rows, i) => [...attitude(rows, i), nadir(rows, i)[0]] : attitude,
    },
    nadir: {
      title: 'axis of least inertia', wraps: 180, lines: ['to nadir', 'along track', 'to orbit normal'], values: nadir,
    },
  };
  const way = axis ? angles : 'attitude';
  const panels = [
    { name: way, ...ways[way], colours: XYZ, unit: 'deg', scale: DEGREES, ways: axis ? ANGLES : null },
    {
      name: 'rate', title: 'body rate', lines: ['x', 'y', 'z', '|ω|'], colours: XYZ,
      unit: 'deg/s', scale: DEGREES, isScaled: true, values: (rows, i) => {
        const omega = rows.get('omega_bi_b', i);
        return [...omega, Math.hypot(...omega)];
      },
    },
    ...shown.map(({ name, title, unit, lines }) => ({
      name, title, unit, lines, colours: ['--x', '--y', '--z'], scale: 1, isScaled: unit !== '1',
      values: (rows, i) => rows.get(name, i),
    })),
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

// The angle of an axis of the body, its nearer end, to nadir and its parts; see nadir_angles in curves.py.
function nadirAngles(q_lb, axis) {
  const [x, y, z] = Rotation.rotate(q_lb, axis);
  const end = z < 0 ? -1 : 1;
  const lean = (part) => Math.asin(Math.max(-1, Math.min(1, part)));
  return [Math.atan2(Math.hypot(x, y), end * z), lean(end * x), lean(-end * y)];
}

// A chart of each sensor's errors, by the sensors' names as in html.playable.
function sensorPanels(sensors) {
  return Object.entries(sensors).map(([name, { table, sigma, unit, per_si: scale, largest }]) => {
    const errors = new Errors(table, sigma);
    return {
      name, title: `${name.replaceAll('_', ' ')} error, 3 σ`, unit, scale, isScaled: scale === 1,
      lines: ['x', 'y', 'z'].slice(-sigma.length), colours: ['--x', '--y', '--z'].slice(-sigma.length), errors,
      values: (rows, i) => errors.at(i), largest: (largest ?? 0) * scale,
    };
  });
}

// The errors of a sensor at times of its own.
class Errors {
  constructor({ rows, columns }, sigma) {
    for (const [name, column] of Object.entries(columns)) this[name] = Rows.decoded(column);
    Object.assign(this, { length: rows, sigma, axes: sigma.length });
  }

  at(i) { return Array.from(this.error.subarray(this.axes * i, this.axes * (i + 1))); }

  // The last sample not after a time; none before the first.
  before(time) {
    const i = Rows.last(this.length, (k) => this.t_s[k] <= time);
    return this.t_s[i] <= time ? this.at(i) : [];
  }

  // The edges of the noise about axis k.
  edges(k) {
    return [-3, 3].map((sign) => Array.from({ length: this.length }, (_, i) => this.systematic[this.axes * i + k] + sign * this.sigma[k]));
  }
}

class Charts {
  // seek(time): called where a chart is clicked.  marks: {events: [{t_s, kind}], driven: [[a, b]], limited: [[a, b]]}.
  // zoomed(from, to), where set: called when another part of the time is chosen.
  constructor(box, seek) {
    Object.assign(this, { box, seek, marks: { events: [], driven: [], limited: [] }, charts: [], angles: 'attitude' });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.charts.forEach(({ plot }) => plot.redraw(false));
    });
  }

  // Make the charts of a description; bands: {rows: a Set, least, most, mean}, numbers of each curve
  // by its name; sensors: as in html.playable.
  describe(description, bands = null, sensors = {}) {
    this.clear();
    this.described = [description, bands, sensors];
    this.bands = bands;
    this.charts = [...panelsOf(description, this.angles), ...sensorPanels(sensors)].map((panel) => ({ panel, ...this._header(panel) }));
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
    this.rows = rows;
    this.times = rows.has('t_s') ? Array.from(rows.columns.t_s.values.subarray(0, rows.length)) : [];
    this.seen = [0, rows.length];
    for (const chart of this.charts) {
      this._read(chart, chart.panel.errors ?? rows);
      const data = this._data(chart);
      if (chart.plot) chart.plot.setData(data);
      else this._plot(chart, data);
    }
  }

  // Move the cursor to a time, and show the values there.
  point(time, row, isMoving = false) {
    this.pointed = [time, row];
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
      key.innerHTML = '<svg width="18" height="8" aria-hidden="true"><line x1="0" x2="16" y1="4" y2="4"/></svg><span></span> <output></output>';
      key.querySelector('line').setAttribute('stroke-dasharray', dashOf(panel, k).join(' '));
      key.querySelector('span').textContent = name;
      keys.append(key);
      return key.querySelector('output');
    });
    if (panel.ways) caption.querySelector('.keys').before(this._choice(panel));
    const box = document.createElement('div');
    figure.append(caption, box);
    this.box.append(figure);
    return { figure, box, values, unit: caption.querySelector('i') };
  }

  // A choice between the ways to say how the body is turned.
  _choice({ name, ways }) {
    const choice = document.createElement('select');
    choice.setAttribute('aria-label', 'angles');
    for (const [way, text] of Object.entries(ways)) choice.add(new Option(text, way));
    choice.value = name;
    choice.addEventListener('change', () => {
      const { min, max } = this.charts[0].plot?.scales.x ?? {};
      this.angles = choice.value;
      this.describe(...this.described);
      if (!this.rows?.length) return;
      this.draw(this.rows);
      this.charts[0].plot.setScale('x', { min, max });
      this.point(...this.pointed);
    });
    return choice;
  }

  // Read the curves of a chart, in its unit, and the bounds of the rows that no line can follow.
  _read(chart, rows) {
    const { panel } = chart;
    const count = panel.lines.length;
    const curves = panel.lines.map(() => new Array(rows.length));
    let largest = panel.largest ?? 0;
    for (let i = 0; i < rows.length; i += 1) {
      const values = panel.values(rows, i) ?? [];
      for (let k = 0; k < count; k += 1) {
        const value = values[k];
        curves[k][i] = Number.isFinite(value) && !(panel.isLog && value <= 0) ? value * panel.scale : null;
        if (curves[k][i] !== null) largest = Math.max(largest, Math.abs(curves[k][i]));
      }
    }
    const edges = panel.errors ? this._sigmas(panel) : [];
    for (const edge of edges) for (const value of edge) largest = Math.max(largest, Math.abs(value));
    const bounds = ['least', 'most', 'mean'].map((name) => this.bands?.[name][panel.name]);
    const far = bounds[0] ? this.bands.rows : new Set();
    for (const i of far) {
      for (let k = i * count; k < (i + 1) * count; k += 1) largest = Math.max(largest, Math.abs(bounds[0][k] * panel.scale), Math.abs(bounds[1][k] * panel.scale));
    }
    chart.says = panel.isScaled ? prefixed(largest, panel.unit) : { scale: 1, unit: panel.unit };
    chart.says.digits = digitsOf(largest * chart.says.scale);
    chart.unit.textContent = `[${chart.says.unit}]`;
    const scaled = (lines) => lines.map((line) => line.map((y) => (y === null ? null : y * chart.says.scale)));
    [chart.curves, chart.edges] = [scaled(curves), scaled(edges)];
    chart.noise = ROUNDING * largest * chart.says.scale;
    const scale = panel.scale * chart.says.scale;
    chart.far = panel.lines.map((_, k) => ({ rows: far, of: (i) => bounds.map((bound) => bound[i * count + k] * scale) }));
  }

  // What a chart draws: its lines, the edges of its bands, least and most, and its means.
  _data(chart) {
    const { panel } = chart;
    if (panel.errors) return this._within(this.times, [Array.from(panel.errors.t_s), ...chart.curves, ...chart.edges]);
    const pixels = chart.box.clientWidth;
    const drawn = chart.curves.map((curve, k) => envelopeOf(curve, ...this.seen, pixels, chart.far[k], chart.noise, panel.isCircular ? panel.wraps : 0));
    if (panel.wraps) drawn.forEach(({ line, mean }) => [line, mean].forEach((curve) => openWraps(curve, panel.wraps)));
    return [
      this.times, ...drawn.map(({ line }) => line), ...drawn.flatMap(({ least, most }) => [least, most]), ...drawn.map(({ mean }) => mean),
    ];
  }

  // Bands where the rows that are seen need them.
  _refine({ min, max }) {
    const { rows } = this;
    const seen = [rows.indexAt(min), Math.min(rows.indexAt(max) + 2, rows.length)];
    if (seen.every((i, k) => i === this.seen[k])) return;
    this.seen = seen;
    requestAnimationFrame(() => {
      this.following = true;
      for (const chart of this.charts) {
        chart.plot?.batch(() => {
          chart.plot.setData(this._data(chart), false);
          chart.plot.setScale('x', { min, max });
        });
      }
      this.following = false;
    });
  }

  // Curves with times of their own, over the time axis of all.
  _within(times, curves) {
    const ends = [times[0], times[times.length - 1]];
    return curves.map((curve, k) => (k ? [null, ...curve, null] : [ends[0], ...curve, ends[1]]));
  }

  _sigmas(panel) {
    return panel.lines.flatMap((_, k) => panel.errors.edges(k).map((edge) => edge.map((y) => y * panel.scale)));
  }

  _plot(chart, data) {
    const { panel } = chart;
    const style = getComputedStyle(this.box);
    const colour = (name) => () => style.getPropertyValue(name).trim();
    const of = (k) => colour(panel.colours[k % panel.colours.length]);
    const lines = panel.lines.map((_, k) => ({
      stroke: of(k), width: panel.errors ? 0.8 : 1.6, dash: dashOf(panel, k), points: { show: false }, spanGaps: false,
    }));
    const edges = new Array(2 * lines.length).fill(null).map(() => ({ points: { show: false }, stroke: null }));
    const means = panel.errors ? [] : lines;
    const axis = { stroke: colour('--text-quiet'), grid: { stroke: colour('--grid'), width: 1 }, ticks: { show: false }, font: '11px system-ui, sans-serif' };
    chart.plot = new uPlot({
      ...this._size(chart),
      series: [{}, ...lines, ...edges, ...means.map((line) => ({ ...line }))],
      bands: edges.filter((_, k) => k % 2).map((_, k) => ({
        series: [lines.length + 2 + 2 * k, lines.length + 1 + 2 * k],
        fill: () => `color-mix(in srgb, ${of(k)()} ${panel.errors ? 35 : 22}%, transparent)`,
      })),
      scales: { x: { time: false }, y: this._scaleOf(chart) },
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
    }, data, chart.box);
    chart.chosen = document.createElement('div');
    chart.chosen.className = 'now';
    chart.plot.over.append(chart.chosen);
    this._listen(chart.plot);
    chart.sized = new ResizeObserver(() => chart.plot.setSize(this._size(chart)));
    chart.sized.observe(chart.figure);
  }

  // Sensors of a kind are drawn to one scale.
  _scaleOf({ panel, says }) {
    if (panel.isLog) return { distr: 3 };
    const most = 1.06 * (panel.largest ?? 0) * says.scale;
    return { range: most ? [-most, most] : paddedRange };
  }

  _size({ figure, box, isLast }) {
    const caption = figure.firstElementChild.offsetHeight;
    const height = figure.clientHeight - caption;
    return { width: Math.max(box.clientWidth, 100), height: Math.max(height, isLast ? 96 : 70) };
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
    this._refine(x);
    this.zoomed?.(x.min, x.max);
  }

  _drawMarks(plot, colour) {
    const { ctx: context, bbox: { left, top, width, height } } = plot;
    const at = (time) => Math.max(left, Math.min(left + width, plot.valToPos(time, 'x', true)));
    context.save();
    context.fillStyle = colour('--driven')();
    for (const [begin, end] of this.marks.driven) context.fillRect(at(begin), top, Math.max(at(end) - at(begin), 1), height);
    context.fillStyle = colour('--bad')();
    for (const [begin, end] of this.marks.limited) {
      if (end < plot.scales.x.min || begin > plot.scales.x.max) continue;
      context.fillRect(at(begin), top, Math.max(at(end) - at(begin), 2 * devicePixelRatio), 4 * devicePixelRatio);
    }
    for (const { t_s: time, kind } of this.marks.events) {
      if (time < plot.scales.x.min || time > plot.scales.x.max) continue;
      context.fillStyle = colour(kind === 'restart' ? '--restart' : '--text-quiet')();
      context.fillRect(Math.round(at(time)) - devicePixelRatio / 2, top, devicePixelRatio, height);
    }
    context.restore();
  }
}

// In noise dashes could not be distinguished.
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
