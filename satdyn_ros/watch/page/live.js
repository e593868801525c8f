'use strict';
// A running node: its rows as they come, its diagnostics, and the controls of its services.

const KEPT_ROWS = 9000;
const CHARTS_EACH = 400; // [ms]; the scene follows every frame

const element = (id) => document.getElementById(id);
const stage = new Stage(element('stage'));
const charts = new Charts(element('charts'), () => {});
const rows = new Rows(KEPT_ROWS);
const live = { start: 0, values: {}, status: {}, heard: [] };

function say(text, isGood = true) {
  element('answer').textContent = text;
  element('answer').className = isGood ? '' : 'bad';
}

async function ask(request) {
  const answer = await connection.ask(request);
  say(answer.text, answer.success);
}

// -- what the server tells -------------------------------------------------------------------------

function takeScene({ start, description, values }) {
  if (start !== live.start) rows.clear();
  Object.assign(live, { start, values });
  const text = JSON.stringify(description);
  if (text === live.description) return;
  live.description = text;
  stage.describe(description);
  charts.describe(description);
}

function takeHistory({ table }) {
  rows.clear();
  rows.append(table);
  stage.scene?.measure(rows);
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
  show();
}

function show() {
  const last = rows.length - 1;
  const row = rows.at(rows.time(last));
  const [[begin, from], [end, to]] = [live.heard[0], live.heard[live.heard.length - 1]];
  stage.show(row, rows, end > begin ? (to - from) / (end - begin) : 1);
  element('clock').textContent = timeText(row.t_s[0], row.t_s[0]);
  if (performance.now() - (live.drawn ?? 0) > CHARTS_EACH) drawCharts();
  // Between two frames no more than a quarter turn, or the eye is deceived.
  const turn = last > 0 ? rows.turned[last] - rows.turned[last - 1] : 0;
  live.isFast = turn > Math.PI / 2 && turn < 1e3;
}

function drawCharts() {
  if (!rows.length) return;
  live.drawn = performance.now();
  charts.draw(rows);
  const last = rows.time(rows.length - 1);
  charts.point(last, rows.at(last));
}

function takeStatus(status) {
  live.status = status;
  element('node').textContent = document.title = status.node ?? 'satdyn watch';
  const state = !status.is_there ? 'not there' : status.is_paused ? 'paused' : 'running';
  element('state').textContent = state;
  element('state').className = `pill ${status.is_there ? status.is_paused ? '' : 'good' : 'bad'}`;
  element('recording').hidden = !status.bag;
  element('recording').textContent = `● recording ${status.bag?.split('/').pop()}`;
  element('pause').textContent = status.is_paused ? 'Resume' : 'Pause';
  element('record').textContent = status.bag ? 'Stop recording' : 'Record';
  for (const name of ['pause', 'reset', 'record', 'begin']) element(name).disabled = !status.is_there;
  element('step').disabled = !(status.is_there && status.is_paused);
  const fast = live.isFast ? ['the body turns more than a quarter turn between two frames: the scene cannot show how'] : [];
  stage.say([...status.missing, ...fast].join('. '));
  showDiagnostics(status.diagnostics);
}

function showDiagnostics(diagnostics) {
  const made = Stage.made;
  element('diagnostics').replaceChildren(...Object.entries(diagnostics).map(([part, { level, text, values }]) => {
    const section = made('section');
    const head = made('h3', '', part);
    head.append(made('span', `pill ${['good', '', 'bad'][level] ?? 'bad'}`, text));
    const list = made('dl');
    values.forEach(([name, value]) => list.append(made('dt', '', name), made('dd', '', value)));
    section.append(head, list);
    return section;
  }));
}

// -- what the user does ----------------------------------------------------------------------------

const connection = new Connection(
  { scene: takeScene, history: takeHistory, rows: takeRows, status: takeStatus },
  (isOpen) => {
    if (isOpen) return;
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
addEventListener('keydown', (event) => {
  if (event.target.closest?.('input, select, button, dialog, summary')) return;
  if (event.key === ' ') element('pause').click();
  else if (event.key === 'ArrowRight' && !element('step').disabled) element('step').click();
  else return;
  event.preventDefault();
});

window.satdyn = { rows, stage, charts, live, get framesPerSecond() { return stage.scene?.framesPerSecond; } };
