'use strict';
// A bag to watch: the part chosen in a chart is requested at its recorded resolution.

const player = new Player();
const element = (id) => document.getElementById(id);
let taking = false;
let shown = { begin: 0, end: 0 };

function take(run) {
  taking = true;
  element('title').textContent = document.title = run.title;
  element('summary').textContent = `${run.summary}. ${run.note}`;
  player.take(run);
  const { rows } = player;
  shown = { begin: rows.time(0), end: rows.time(rows.length - 1) };
  taking = false;
}

async function choose(begin, end) {
  const answer = await connection.ask({ begin, end });
  if (!answer.success) return player.stage.say(answer.text);
  element('whole').hidden = begin === null;
  return take(answer.run);
}

let asked = 0;
player.charts.zoomed = (begin, end) => {
  const isWider = end - begin > 0.98 * (shown.end - shown.begin);
  clearTimeout(asked);
  if (!taking && !isWider) asked = setTimeout(() => choose(begin, end), 150);
};
element('whole').addEventListener('click', () => choose(null, null));
element('charts').addEventListener('dblclick', () => choose(null, null));

let isFirst = true;
const connection = new Connection({
  run: ({ run }) => { if (isFirst) take(run); isFirst = false; },
}, (isOpen) => { if (!isFirst) player.stage.say(isOpen ? '' : 'satdyn watch has ended; this page continues when it is back.'); });

window.satdyn = player;
