// Numbers and times as text.

/** Five significant figures; powers of ten where zeros would have to be counted. */
export function number(value, digits = 5) {
  if (value === null || value === undefined) return '–';
  if (!Number.isFinite(value)) return 'no number';
  const size = Math.abs(value);
  if (size === 0) return '0';
  const text = size >= 1e-3 && size < 1e5 ? value.toPrecision(digits) : value.toExponential(digits - 2);
  return text.replace('-', '−').replace(/e[+]?(−|-)?/, (_, minus) => (minus ? 'e−' : 'e'));
}

const kPrefixes = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];

/** The factor and the unit's name that suit values of this size: 2.4e8 Pa are told in MPa. */
export function prefixed(size, unit) {
  const [factor, prefix] = kPrefixes.find(([one]) => size >= one) ?? [1, ''];
  return { factor, unit: prefix + unit };
}

/** Decimals that tell frames apart: time steps of 1 ms are shown with three and one more. */
export function timeText(t, span) {
  return t.toFixed(span >= 100 ? 2 : span >= 1 ? 3 : span >= 0.01 ? 5 : 7);
}

/** The 1, 2 or 5 times a power of ten next below. */
export function niceBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
