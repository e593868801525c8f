'use strict';
// A curve that goes up and down more often than the chart has pixels, as a band with a mean; the
// same as in envelope.py.

const STEP_PIXELS = 6;
const NEIGHBOURS = 9;
const FEWEST_ROWS = 4;
const LEAST_RESULTANT = 0.5;

// Return {line, least, most, mean} of a curve of numbers and nulls, each null where the others are
// drawn.  The rows from first to before end are seen, over so many pixels.  far: {rows, of}: in a
// Set of rows, of(i) is [least, most, mean], of values that no row has.  noise: what goes up and
// down by less goes nowhere.  turn: what leads back to the same angle, 0: it is none.
function envelopeOf(curve, first, end, pixels, far, noise, turn) {
  const count = Math.max(1, Math.floor(Math.min(pixels / STEP_PIXELS, (end - first) / FEWEST_ROWS)));
  const beginOf = (k) => first + Math.floor((k * (end - first)) / count);
  const steps = Array.from({ length: count }, (_, k) => stepOf(curve, beginOf(k), beginOf(k + 1), far, noise, turn));
  const half = (NEIGHBOURS - 1) / 2;
  const isBand = steps.map(({ isFar }, k) => {
    const voters = steps.slice(Math.max(0, k - half), k + half + 1);
    return isFar || voters.filter(({ isToAndFro }) => isToAndFro).length > voters.length / 2;
  });
  const none = () => new Array(curve.length).fill(null);
  const drawn = { line: curve.slice(), least: none(), most: none(), mean: none() };
  steps.forEach((step, k) => {
    if (!isBand[k] || step.most < step.least) return; // a gap has no band
    for (let i = step.begin; i < step.end; i += 1) {
      drawn.line[i] = null;
      [drawn.least[i], drawn.most[i]] = [step.least, step.most];
      drawn.mean[i] = meanAt(i, step, steps[i < step.middle ? k - 1 : k + 1] ?? step, turn);
    }
  });
  return drawn;
}

function stepOf(curve, begin, end, far, noise, turn) {
  let [least, most, way, isFar] = [Infinity, -Infinity, 0, false];
  const sum = [0, 0, 0];
  for (let i = begin; i < end; i += 1) {
    let [low, high, mean] = [curve[i], curve[i], curve[i]];
    if (far.rows.has(i)) [[low, high, mean], isFar] = [far.of(i), true];
    if (low !== null) [least, most] = [Math.min(least, low), Math.max(most, high)];
    if (i > 0 && curve[i] !== null && curve[i - 1] !== null) way += Math.abs(curve[i] - curve[i - 1]);
    if (!Number.isFinite(mean) || mean === null) continue;
    const angle = (2 * Math.PI * mean) / turn;
    sum[0] += turn ? Math.cos(angle) : mean;
    sum[1] += turn ? Math.sin(angle) : 0;
    sum[2] += 1;
  }
  const average = sum[2] ? [sum[0] / sum[2], sum[1] / sum[2]] : [NaN, NaN];
  return { begin, end, middle: (begin + end - 1) / 2, least, most, average, isFar, isToAndFro: most - least > noise && way >= 2 * (most - least) };
}

// The mean goes from the middle of one step to that of the next; null: it goes all ways.
function meanAt(i, step, other, turn) {
  const part = other === step ? 0 : (i - step.middle) / (other.middle - step.middle);
  const [x, y] = step.average.map((a, k) => a + part * (other.average[k] - a));
  if (!Number.isFinite(x)) return null;
  if (!turn) return x;
  return Math.hypot(x, y) > LEAST_RESULTANT ? (turn * Math.atan2(y, x)) / (2 * Math.PI) : null;
}
