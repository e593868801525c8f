'use strict';
// The report: one time for the scene, the charts and the timeline.

const run = JSON.parse(document.getElementById('run').textContent);
const rows = new Rows();
rows.append(run.table);

const stage = new Stage(document.getElementById('stage'));
const charts = new Charts(document.getElementById('charts'), (time) => timeline.seek(time), run.marks);
const timeline = new Timeline(document.getElementById('timeline'), (time, factor) => {
  const row = rows.at(time);
  stage.show(row, rows, factor);
  charts.point(time, row);
});

const bands = run.bands && {
  rows: run.bands.rows,
  length: rows.length,
  least: Object.fromEntries(Object.entries(run.bands.least.columns).map(([name, column]) => [name, Rows.decoded(column)])),
  most: Object.fromEntries(Object.entries(run.bands.most.columns).map(([name, column]) => [name, Rows.decoded(column)])),
};
stage.describe(run.description);
stage.scene?.measure(rows);
if (run.notice && stage.scene) stage.say(run.notice);
charts.describe(run.description, bands);
charts.draw(rows);
timeline.take(rows.time(0), rows.time(rows.length - 1), run.marks);

// For tests and benchmarks.
window.satdyn = { rows, stage, charts, timeline, get framesPerSecond() { return stage.scene?.framesPerSecond; } };
