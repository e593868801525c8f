'use strict';
// A running node: its rows as they come, its diagnostics, and the controls of its services.

const ALL = 'all'; // the choice in place of a satellite
const KEPT_ROWS = 9000;
const CHARTS_EACH = 400; // [ms], or two thirds of the time; the scene follows every frame
const CLOCK_EACH = 200; // [ms]; without a graphics processor painting it costs as much as the scene

const element = (id) => document.getElementById(id);
const stage = new Stage(element('stage'));
const charts = new Charts(element('charts'), () => {});
const rows = new Rows(KEPT_ROWS);
const fleet = new Fleet(element('globe'), element('satellites'), choose);
const live = { node: '', start: 0, values: {}, status: {}, heard: [] };

function say(text, isGood = true) {
  element('answer').textContent = text;
  element('answer').className = isGood ? '' : 'bad';
}

function choose(node) { ask({ do: 'choose', node }); }

async function ask(request) {
  const answer = await connection.ask(request);
  say(answer.text, answer.success);
}

// -- what the server sends -------------------------------------------------------------------------

// Another satellite, or another run: nothing that is on the page is its own.
function forget() {
  rows.clear();
  live.heard.length = 0;
  live.description = '';
  live.isFast = false;
  stage.clear();
  charts.clear();
  element('clock').textContent = '';
}

function takeScene({ node, start, description, values }) {
  if (node !== live.node || start !== live.start) forget();
  Object.assign(live, { node, start, values });
  const text = JSON.stringify(description);
  if (text === live.description) return;
  live.description = text;
  stage.describe(description);
  charts.describe(description);
  if (rows.length) show();
}

function takeHistory({ start, table }) {
  if (start !== live.start || !live.description) return;
  rows.clear();
  rows.append(table);
  stage.scene?.measure(rows);
  show();
  tick();
  drawCharts();
}

function takeRows({ start, table }) {
  if (start !== live.start || !live.description) return;
  const before = rows.length ? rows.time(rows.length - 1) : -Infinity;
  const time = new Float64Array(Uint8Array.from(atob(table.columns.t_s.float64), (c) => c.charCodeAt(0)).buffer)[0];
  if (time <= before) return;
  rows.append(table);
  live.heard.push([performance.now() / 1000, time]);
  if (live.heard.length > 30) live.heard.shift();
  // With the next frame: a slow machine draws less often than rows come.
  live.asked ??= requestAnimationFrame(() => {
    live.asked = undefined;
    if (rows.length) show();
  });
}

function show() {
  const last = rows.length - 1;
  const row = rows.at(rows.time(last));
  const [[begin, from] = [], [end, to] = []] = [live.heard[0], live.heard[live.heard.length - 1]];
  stage.show(row, rows, end > begin ? (to - from) / (end - begin) : 1);
  live.clock ??= setTimeout(tick, CLOCK_EACH);
  if (performance.now() > (live.chartsFrom ?? 0)) drawCharts();
  // Between two frames no more than a quarter turn, or the eye is deceived.
  const turn = last > 0 ? rows.turned[last] - rows.turned[last - 1] : 0;
  live.isFast = turn > Math.PI / 2 && turn < 1e3;
}

function tick() {
  live.clock = undefined;
  if (!rows.length) return;
  const time = rows.time(rows.length - 1);
  const { earth } = stage.ground;
  element('clock').textContent = [timeText(time, time), ...(earth ? [utcText(earth.utc(time))] : [])].join(' · ');
}

function drawCharts() {
  if (!rows.length) return;
  const begin = performance.now();
  charts.draw(rows);
  const last = rows.time(rows.length - 1);
  charts.point(last, rows.at(last));
  const end = performance.now();
  live.chartsFrom = end + Math.max(CHARTS_EACH, 2 * (end - begin));
}

function takeStatus(status) {
  live.status = status;
  if (status.node !== live.node) {
    forget();
    live.node = status.node;
  }
  const isAll = status.node === ALL;
  element('one').hidden = document.querySelector('article').hidden = element('state').hidden = isAll;
  element('all').hidden = !isAll;
  element('node').textContent = document.title = status.node || 'satdyn watch';
  showNodes(status);
  showState(element('state'), status);
  element('recording').hidden = !status.bag;
  element('recording').textContent = `● recording ${status.bag?.split('/').pop()}`;
  element('pause').textContent = status.is_paused ? 'Resume' : 'Pause';
  element('record').textContent = status.bag ? 'Stop recording' : 'Record';
  const canAsk = status.is_there && !status.has_namesakes;
  for (const name of ['pause', 'reset', 'record', 'begin']) element(name).disabled = !canAsk;
  element('step').disabled = !(canAsk && status.is_paused);
  const fast = live.isFast ? ['the body turns more than a quarter turn between two frames: the scene cannot show how'] : [];
  stage.say([...status.missing, ...fast].join('. '));
  showDiagnostics(status.diagnostics);
}

// Of several satellites a choice takes the place of the name; it is left alone while it is the same.
function showNodes({ node, nodes }) {
  const names = [...new Set([...nodes, node])].filter(Boolean);
  const choice = element('nodes');
  if (names.join() !== [...choice.options].map(({ value }) => value).join()) {
    choice.replaceChildren(...names.map((name) => new Option(name, name)));
  }
  choice.value = node;
  choice.hidden = names.length < 2;
  element('node').hidden = !choice.hidden;
}

function showDiagnostics(diagnostics) {
  const made = Stage.made;
  const listOf = (values) => {
    const list = made('dl');
    values.forEach(([name, value]) => list.append(made('dt', '', name), made('dd', '', value)));
    return list;
  };
  // How late ticks came is for whoever looks for it.
  const isLateness = ([name]) => /lateness|^ticks late/.test(name);
  element('diagnostics').replaceChildren(...Object.entries(diagnostics).map(([part, { level, text, values }]) => {
    const section = made('section');
    const head = made('h3', '', part);
    head.append(made('span', `pill ${['good', '', 'bad'][level] ?? 'bad'}`, text));
    section.append(head, listOf(values.filter((value) => !isLateness(value))));
    const lateness = values.filter(isLateness);
    if (lateness.length) {
      live.folded.lastElementChild.replaceWith(listOf(lateness));
      section.append(live.folded);
    }
    return section;
  }));
}

function takeEarth(earth) { fleet.describe(earth); }

function takeGlobe({ satellites }) {
  if (live.node !== ALL) return;
  fleet.show(satellites);
  element('clock').textContent = fleet.utc ? utcText(fleet.utc) : '';
}

// -- what the user does ----------------------------------------------------------------------------

const connection = new Connection(
  { scene: takeScene, history: takeHistory, rows: takeRows, status: takeStatus, earth: takeEarth, globe: takeGlobe },
  (isOpen) => {
    if (isOpen) return;
    element('state').hidden = false;
    element('state').textContent = 'satdyn watch has ended';
    element('state').className = 'pill bad';
  },
);
const form = new StartForm((values) => connection.ask({ do: 'request', values }), say);

element('pause').addEventListener('click', () => ask({ do: live.status.is_paused ? 'resume' : 'pause' }));
element('step').addEventListener('click', () => ask({ do: 'step' }));
element('reset').addEventListener('click', () => ask({ do: 'reset' }));
element('record').addEventListener('click', () => ask({ do: live.status.bag ? 'stop' : 'record' }));
element('begin').addEventListener('click', () => form.open(live.values));
element('nodes').addEventListener('change', ({ target }) => choose(target.value));
addEventListener('keydown', (event) => {
  if (event.target.closest?.('input, select, button, dialog, summary')) return;
  if (event.key === ' ') element('pause').click();
  else if (event.key === 'ArrowRight' && !element('step').disabled) element('step').click();
  else return;
  event.preventDefault();
});

live.folded = Stage.made('details');
live.folded.append(Stage.made('summary', '', 'lateness of the ticks'), Stage.made('dl'));

window.satdyn = { rows, stage, charts, fleet, live, get framesPerSecond() { return stage.scene?.framesPerSecond; } };
