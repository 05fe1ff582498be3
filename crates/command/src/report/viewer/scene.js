"use strict";

// ---- the recording: numbers of every frame, and what they mean -----------------------------------------------------

const about = JSON.parse(document.getElementById("description").textContent);
const numbers = (() => {
  const text = atob(document.getElementById("data").textContent.trim());
  const bytes = Uint8Array.from(text, letter => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer); // little-endian whatever the machine is
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
})();
const frameCount = about.begins.length;

// Where things stand in the part of a frame that has the same length in all frames.
const layout = (() => {
  let next = 0;
  const take = count => { const begin = next; next += count; return begin; };
  const found = {
    time: take(1), angles: take(about.joints.length), strains: take(about.gauges.length),
    energies: take(about.energies.length), gauges: take(3 * about.gauges.length),
  };
  found.bodies = about.bodies.map(body => take(12 * body.rims.length));
  found.surfaces = about.surfaces.map(columns => take(6 * columns));
  found.length = next;
  return found;
})();

const valueAt = (frame, place) => numbers[about.begins[frame] + place];
const timeOf = frame => valueAt(frame, layout.time);

// The fixed part between two frames; lengths of axes are put right again by `section`.
const present = new Float32Array(layout.length);
function goTo(position) {
  const before = Math.min(Math.floor(position), frameCount - 1);
  const after = Math.min(before + 1, frameCount - 1);
  const share = position - before;
  const [a, b] = [about.begins[before], about.begins[after]];
  for (let i = 0; i < layout.length; i++) present[i] = numbers[a + i] + share * (numbers[b + i] - numbers[a + i]);
}

const vector = (list, place) => [list[place], list[place + 1], list[place + 2]];
const plus = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const length = Math.hypot(...a) || 1; return a.map(c => c / length); };

// Section of a body in a list of numbers: position, axes y and z, strain measures (stretch, bending about y and z).
function section(list, begin, body, index) {
  const place = begin + layout.bodies[body] + 12 * index;
  return {
    at: vector(list, place), y: unit(vector(list, place + 3)), z: unit(vector(list, place + 6)),
    measures: vector(list, place + 9),
  };
}
const pointOf = (s, [y, z]) => plus(plus(s.at, s.y, y), s.z, z);
const strainAt = (s, [y, z]) => s.measures[0] + z * s.measures[1] - y * s.measures[2];

// Mean place of the sections between frames.
function centroid() {
  let sum = [0, 0, 0], count = 0;
  about.bodies.forEach((body, b) => body.rims.forEach((_, i) => { sum = plus(sum, section(present, 0, b, i).at); count++; }));
  return sum.map(c => c / count);
}

// Wake of a frame: per surface rows of nodes, and the circulation of the rings between them.
function wakeOf(frame) {
  let place = about.begins[frame] + layout.length;
  return about.wakes.map((columns, surface) => {
    const rows = about.rows[frame][surface];
    const nodes = Array.from({ length: rows + 1 }, (_, row) =>
      Array.from({ length: columns }, (_, column) => vector(numbers, place + 3 * (row * columns + column))));
    place += 3 * (rows + 1) * columns;
    const rings = Array.from({ length: rows }, (_, row) =>
      Array.from(numbers.subarray(place + row * (columns - 1), place + (row + 1) * (columns - 1))));
    place += rows * (columns - 1);
    return { nodes, rings };
  });
}

// ---- extents over the run -------------------------------------------------------------------------------------------

const extents = (() => {
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
  const include = point => point.forEach((c, i) => { least[i] = Math.min(least[i], c); most[i] = Math.max(most[i], c); });
  let wing = 0, energy = 0, bodyStrain = 0, gaugeStrain = 0, circulation = 0;
  for (let frame = 0; frame < frameCount; frame++) {
    const begin = about.begins[frame];
    about.bodies.forEach((body, b) => body.rims.forEach((rim, i) => {
      const s = section(numbers, begin, b, i);
      include(s.at);
      for (const point of rim) bodyStrain = Math.max(bodyStrain, Math.abs(strainAt(s, point)));
    }));
    about.surfaces.forEach((columns, i) => {
      for (let c = 0; c < 2 * columns; c++) include(vector(numbers, begin + layout.surfaces[i] + 3 * c));
    });
    about.energies.forEach((_, i) => { energy = Math.max(energy, Math.abs(valueAt(frame, layout.energies + i))); });
    if (frame === 0) wing = Math.hypot(...most.map((c, i) => c - least[i]));
    about.gauges.forEach((_, i) => { gaugeStrain = Math.max(gaugeStrain, Math.abs(valueAt(frame, layout.strains + i))); });
    for (const wake of wakeOf(frame)) for (const row of wake.rings) for (const g of row) {
      circulation = Math.max(circulation, Math.abs(g));
    }
  }
  const middle = least.map((c, i) => (c + most[i]) / 2);
  const size = Math.max(Math.hypot(...most.map((c, i) => c - least[i])), 1e-6);
  return {
    least, most, middle, size, wing: Math.max(wing, 1e-6), energy: energy || 1,
    strain: Math.max(gaugeStrain, bodyStrain, 1e-9), circulation: circulation || 1,
  };
})();

// ---- colours: diverging maps that people with colour-blindness read --------------------------------------------------

const STRAIN_MAP = [[5, 48, 97], [67, 147, 195], [240, 240, 240], [244, 135, 75], [127, 30, 8]];
const WAKE_MAP = [[45, 0, 75], [128, 115, 172], [225, 225, 230], [224, 160, 40], [127, 59, 8]];
function colour(map, value, most) {
  const place = 2 + 2 * Math.max(-1, Math.min(1, value / most));
  const before = Math.min(Math.floor(place), 3), share = place - before;
  return map[before].map((c, i) => c + share * (map[before + 1][i] - c));
}
const css = ([r, g, b], alpha = 1) => `rgb(${Math.round(r)} ${Math.round(g)} ${Math.round(b)} / ${alpha})`;
