// Colours that people with any colour vision tell apart: Okabe & Ito (2008) for things, viridis (van der Walt & Smith,
// 2015) for fields. Nothing is told by colour alone: variants have a dash, charts a name, arrows a shape.

const kLight = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#b87d00', '#3a8fc4', '#4d4d4d'];
const kDark = ['#56b4e9', '#e8743b', '#2bc49a', '#dd9cc0', '#e69f00', '#8ab6d6', '#c8c8c8'];

export const kDashes = [[], [9, 4], [2.5, 3], [10, 3, 2, 3]];
export const kDashNames = ['solid', 'dashed', 'dotted', 'dash-dot'];

export function seriesColour(index, theme) {
  const palette = theme === 'dark' ? kDark : kLight;
  return palette[index % palette.length];
}

export const runDash = (index) => kDashes[index % kDashes.length];
export const runDashName = (index) => kDashNames[index % kDashNames.length];

// Nine points of viridis; between them linear, which is off by less than 1 % of the range.
const kViridis = ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'];

function channels(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

/** Viridis as red, green, blue in 0..255 at x in 0..1. */
export function viridis(x) {
  const place = Math.min(1, Math.max(0, x)) * (kViridis.length - 1);
  const i = Math.min(kViridis.length - 2, Math.floor(place));
  const a = channels(kViridis[i]);
  const b = channels(kViridis[i + 1]);
  return a.map((value, c) => Math.round(value + (b[c] - value) * (place - i)));
}

/** Steps of the map as CSS colours, for the legend: many, or the bands. */
export function viridisSteps(count) {
  return Array.from({ length: count }, (_, i) => `rgb(${viridis(count > 1 ? i / (count - 1) : 0).join(',')})`);
}
