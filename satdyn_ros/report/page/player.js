'use strict';
// A recorded run: one time for the scene, the charts and the timeline.

class Player {
  constructor() {
    const box = (id) => document.getElementById(id);
    this.stage = new Stage(box('stage'));
    this.charts = new Charts(box('charts'), (time) => this.timeline.seek(time));
    this.timeline = new Timeline(box('timeline'), (time, factor) => {
      const row = this.rows.at(time);
      this.stage.show(row, this.rows, factor);
      this.charts.point(time, row, this.timeline.isPlaying);
    });
  }

  // Play a run, as html.playable describes it.
  take({ description, table, bands, marks, notice, sensors }) {
    this.rows = new Rows();
    this.rows.append(table);
    const decoded = (bounds) => Object.fromEntries(
      Object.entries(bounds.columns).map(([name, column]) => [name, Rows.decoded(column)]),
    );
    this.stage.describe(description);
    this.stage.scene?.measure(this.rows);
    if (this.stage.scene) this.stage.say(notice);
    this.charts.marks = marks;
    this.charts.describe(description, bands && {
      rows: new Set(bands.rows), ...Object.fromEntries(['least', 'most', 'mean'].map((name) => [name, decoded(bands[name])])),
    }, sensors);
    this.charts.draw(this.rows);
    this.timeline.epoch = description.earth?.epoch_s;
    this.timeline.take(this.rows.time(0), this.rows.time(this.rows.length - 1), marks);
  }

  get framesPerSecond() { return this.stage.scene?.framesPerSecond; }
}
