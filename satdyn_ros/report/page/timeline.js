'use strict';
// The time of a recorded run: play, speed, slider and the marks of events; UTC where epoch [s] is set.

const SPEEDS = [0.1, 1, 10, 30, 100, 300, 1000, 3000, 10000, 100000];

class Timeline {
  // show(time, factor) is called whenever the time changes; box holds the controls.
  constructor(box, show) {
    this.show = show;
    this.isPlaying = false;
    box.classList.add('timeline');
    box.innerHTML = `
      <button type="button" class="play" aria-label="play"></button>
      <div class="track"><div class="marks" aria-hidden="true"></div>
        <input type="range" min="0" max="1000000" value="0" step="1" aria-label="time"></div>
      <output class="clock"></output><output class="utc"></output>
      <label class="speed"><span class="unseen">speed</span><select aria-label="speed"></select></label>`;
    [this.button, this.marks, this.slider, this.clock, this.utc, this.speed] =
      ['.play', '.marks', 'input', '.clock', '.utc', 'select'].map((name) => box.querySelector(name));
    SPEEDS.forEach((factor) => this.speed.add(new Option(`× ${factor}`, factor)));
    this.button.addEventListener('click', () => this.play(!this.isPlaying));
    this.slider.addEventListener('input', () => this.seek(this.begin + (this.slider.value / 1e6) * this.span));
    this.speed.addEventListener('change', () => this._start());
    addEventListener('keydown', (event) => this._key(event));
    this._look();
  }

  // Take a run: its begin and end [s], and its marks as in charts.js.
  take(begin, end, { events, driven, limited }) {
    Object.assign(this, { begin, end, span: Math.max(end - begin, 1e-9) });
    const part = (time) => `${(100 * (time - begin)) / this.span}%`;
    const stretch = (kind) => ([from, to]) => Timeline._mark(kind, part(from), `${(100 * (to - from)) / this.span}%`);
    this.marks.replaceChildren(
      ...driven.map(stretch('driven')),
      ...limited.map(stretch('limited')),
      ...events.map(({ t_s: time, kind }) => Timeline._mark(kind, part(time))),
    );
    // By default a run plays in about half a minute.
    const wanted = Math.log(Math.max(this.span / 30, 0.1));
    this.speed.value = SPEEDS.reduce((a, b) => (Math.abs(Math.log(b) - wanted) < Math.abs(Math.log(a) - wanted) ? b : a));
    this.seek(Math.max(begin, Math.min(this.time ?? begin, end)));
  }

  seek(time) {
    this.time = Math.max(this.begin, Math.min(time, this.end));
    this._start();
    this._say();
  }

  play(on) {
    if (on && this.time >= this.end) this.time = this.begin;
    this.isPlaying = on;
    this._look();
    this._start();
    if (on) requestAnimationFrame((now) => this._frame(now));
  }

  _frame(now) {
    if (!this.isPlaying) return;
    this.time = Math.min(this.from.time + ((now - this.from.wall) / 1000) * this.factor, this.end);
    if (this.time >= this.end) this.play(false);
    this._say();
    if (this.isPlaying) requestAnimationFrame((later) => this._frame(later));
  }

  get factor() { return Number(this.speed.value); }

  _start() { this.from = { wall: performance.now(), time: this.time }; }

  _say() {
    this.show(this.time, this.isPlaying ? this.factor : 0);
    // Painting slider and clock at every frame would cost more than the scene.
    if (this.isPlaying && performance.now() - (this.saidAt ?? 0) < 100) return;
    this.saidAt = performance.now();
    this.slider.value = Math.round(((this.time - this.begin) / this.span) * 1e6);
    const text = timeText(this.time, this.span);
    this.clock.textContent = text;
    if (this.epoch !== undefined) this.utc.textContent = utcText(this.epoch + this.time);
    this.slider.setAttribute('aria-valuetext', text);
  }

  _look() {
    this.button.textContent = this.isPlaying ? '❚❚' : '▶';
    this.button.setAttribute('aria-label', this.isPlaying ? 'pause' : 'play');
  }

  // Space plays, the arrow keys step: a thousandth of the run, with shift a twentieth.
  _key(event) {
    const isTyping = event.target.closest?.('input:not([type=range]):not([type=checkbox]), select, textarea');
    if (isTyping || event.ctrlKey || event.altKey || event.metaKey) return;
    const steps = { ArrowLeft: -1, ArrowRight: 1 };
    if (event.key === ' ' && !event.target.closest?.('button, summary, input[type=checkbox]')) this.play(!this.isPlaying);
    else if (event.key in steps) this.seek(this.time + (steps[event.key] * this.span) / (event.shiftKey ? 20 : 1000));
    else if (event.key === 'Home') this.seek(this.begin);
    else if (event.key === 'End') this.seek(this.end);
    else return;
    event.preventDefault();
  }

  static _mark(kind, left, width = '') {
    const mark = document.createElement('i');
    mark.className = kind;
    Object.assign(mark.style, { left, width });
    return mark;
  }
}
