'use strict';
// The page's life: one index of time, which the 3-D view, the plots' cursor and the slider share.

const { t_s: times, plots, scene } = JSON.parse(document.getElementById('data').textContent);
const colours = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9'];
const dashes = ['solid', 'dash', 'dashdot', 'dot'];
const [sceneBox, plotsBox] = ['scene', 'plots'].map((id) => document.getElementById(id));
const [play, scrub, speed, clock] =
  ['play', 'scrub', 'speed', 'time'].map((id) => document.getElementById(id));
const last = times.length - 1;
const at = (rows, i) => rows[Math.min(i, rows.length - 1)];

function rotate([x, y, z, w], [a, b, c]) {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

// -- the 3-D view --------------------------------------------------------------------------------

// The corners count in binary (x, y, z); two triangles a face.
const faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
const triangles = faces.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]]);
const column = (rows, k) => rows.map((row) => row[k]);

function corners(i) {
  return scene.box.map((corner) => rotate(at(scene.q, i), corner));
}

function sceneTraces() {
  const box = corners(0);
  const mesh = {
    type: 'mesh3d', x: column(box, 0), y: column(box, 1), z: column(box, 2),
    i: column(triangles, 0), j: column(triangles, 1), k: column(triangles, 2),
    color: '#9aa7b1', opacity: 0.85, flatshading: true, hoverinfo: 'skip', name: 'body',
  };
  const arrows = scene.arrows.map(({ name, colour, tips }) => ({
    type: 'scatter3d', mode: 'lines+markers', name, hoverinfo: 'name',
    x: [0, tips[0][0]], y: [0, tips[0][1]], z: [0, tips[0][2]],
    line: { color: colour, width: 6 }, marker: { color: colour, size: [0, 5] },
  }));
  return [mesh, ...arrows];
}

function drawScene(i) {
  const box = corners(i);
  const tips = scene.arrows.map((arrow) => at(arrow.tips, i));
  const coordinate = (k) => [column(box, k), ...tips.map((tip) => [0, tip[k]])];
  Plotly.restyle(sceneBox, { x: coordinate(0), y: coordinate(1), z: coordinate(2) });
}

// -- the plots -----------------------------------------------------------------------------------

function plotTraces() {
  return plots.flatMap(({ lines }, row) => lines.map(({ name, y }, k) => ({
    type: 'scattergl', mode: 'lines', x: times, y, name,
    legendgroup: row, legendgrouptitle: k ? undefined : { text: plots[row].title },
    line: { color: colours[k % colours.length], dash: dashes[k % dashes.length], width: 1.5 },
    xaxis: 'x', yaxis: row ? `y${row + 1}` : 'y',
  })));
}

function cursor(i) {
  return [{ type: 'line', xref: 'x', yref: 'paper', x0: times[i], x1: times[i], y0: 0, y1: 1,
    line: { color: '#000', width: 1 } }];
}

function plotsLayout() {
  const layout = {
    grid: { rows: plots.length, columns: 1, subplots: plots.map((_, k) => [`xy${k ? k + 1 : ''}`]) },
    xaxis: { title: { text: 'time from tick 0 [s]' }, anchor: `y${plots.length}` },
    margin: { l: 78, r: 8, t: 8, b: 44 }, shapes: cursor(0), hovermode: 'x unified',
  };
  plots.forEach(({ title, log }, k) => {
    layout[`yaxis${k ? k + 1 : ''}`] = {
      title: { text: title.replace(' [', '<br>['), font: { size: 11 } },
      type: log ? 'log' : 'linear', exponentformat: 'power',
    };
  });
  return layout;
}

// -- time ----------------------------------------------------------------------------------------

let index = 0;
let playing = false;
let begun = { wall: 0, time: 0 };

function show(i) {
  index = i;
  scrub.value = i;
  clock.textContent = `${times[i].toFixed(2)} s`;
  drawScene(i);
  Plotly.relayout(plotsBox, { shapes: cursor(i) });
}

function begin() {
  begun = { wall: performance.now(), time: times[index] };
}

function indexAt(time) {
  let [low, high] = [0, last];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}

function frame(now) {
  if (!playing) return;
  const i = indexAt(begun.time + ((now - begun.wall) / 1000) * Number(speed.value));
  if (i !== index) show(i);
  if (i === last) setPlaying(false); else requestAnimationFrame(frame);
}

function setPlaying(on) {
  playing = on;
  play.textContent = on ? 'Pause' : 'Play';
  if (!on) return;
  if (index === last) show(0);
  begin();
  requestAnimationFrame(frame);
}

const span = times[last] - times[0];
[1, 10, 100, 1000, 10000].forEach((factor) => speed.add(new Option(`${factor} x`, factor)));
// As shipped, a bag plays in about half a minute.
speed.value = String(10 ** Math.max(0, Math.min(4, Math.round(Math.log10(Math.max(span / 30, 1))))));
scrub.max = last;
play.addEventListener('click', () => setPlaying(!playing));
scrub.addEventListener('input', () => { show(Number(scrub.value)); begin(); });
speed.addEventListener('change', begin);

const axis = (text) => ({ range: [-1.5, 1.5], title: { text }, showspikes: false });
const names = scene.frame === 'LVLH'
  ? ['x, along track', 'y, minus the orbit normal', 'z, to nadir'] : ['X', 'Y', 'Z'];
Plotly.newPlot(sceneBox, sceneTraces(), {
  scene: {
    xaxis: axis(names[0]), yaxis: axis(names[1]), zaxis: axis(names[2]), aspectmode: 'cube',
    dragmode: 'orbit',
    // LVLH has nadir on +z: seen with z down, as the satellite flies.
    camera: scene.frame === 'LVLH'
      ? { up: { x: 0, y: 0, z: -1 }, eye: { x: 1.3, y: 1.5, z: -0.7 } } : undefined,
  },
  margin: { l: 0, r: 0, t: 0, b: 0 }, legend: { orientation: 'h' }, uirevision: 'kept',
}, { responsive: true, displaylogo: false });
Plotly.newPlot(plotsBox, plotTraces(), plotsLayout(), { responsive: true, displaylogo: false }).then(() => show(0));
