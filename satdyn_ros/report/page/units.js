'use strict';
// Numbers for readers: three digits, and units of a suitable size.

// Three digits, with a true minus sign.
function quantity(value) {
  if (value === 0) return '0';
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
  return text.replaceAll('-', '−').replace('e+', 'e');
}

// The decimals that show a ten-thousandth of the largest value.
function digitsOf(largest) {
  return largest > 0 ? Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(largest)))) : 0;
}

function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '−');
}

// The unit of a span of time [s]: its seconds, its name, and steps of an axis.
function timeUnit(span) {
  const units = [[86400, 'd'], [3600, 'h'], [60, 'min']];
  const [seconds, name] = units.find(([length]) => span > 3 * length) ?? [1, 's'];
  return { seconds, name };
}

function timeText(time, span) {
  const { seconds, name } = timeUnit(span);
  const digits = Math.max(0, Math.min(6, Math.ceil(-Math.log10(Math.max(span / seconds, 1e-9) / 5000))));
  return `${(time / seconds).toFixed(digits).replace('-', '−')} ${name}`;
}

// The unit in which the largest value is easy to read, by its prefix: scale times the value.
function prefixed(largest, unit) {
  if (!(largest > 0)) return { scale: 1, unit };
  const power = Math.max(-4, Math.min(1, Math.floor(Math.log10(largest * 1.0001) / 3)));
  const prefix = { '-4': 'p', '-3': 'n', '-2': 'µ', '-1': 'm', 0: '', 1: 'k' }[power];
  return { scale: 10 ** (-3 * power), unit: prefix + unit };
}

// A Unix time [s] as a reader writes it.
function utcText(time) { return `${new Date(1000 * time).toISOString().slice(0, 19).replace('T', ' ')} UTC`; }
