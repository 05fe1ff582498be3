
// ---- modes: the frames of a cycle about a state ----------------------------------------------------------------------

const PHASES = 48, PER_CHANGE = 20;
const DECAYED = 20, MOST_CYCLES = 12, MOST_TURNS = 12;
// Selected state, mode and amplitude, and whether the amplitude decays or grows at the rate of the mode.
const chosen = { state: 0, mode: 0, amplitude: 1, decay: false };
if (modal) {
  chosen.state = Math.max(0, modal.states.findIndex(state => state.words.startsWith("flutter")));
  chosen.mode = modal.states[chosen.state].modes.findIndex(mode => mode !== null);
}
const stateOfModes = () => modal.states[chosen.state];
const modeShown = () => stateOfModes().modes[chosen.mode];
const oscillates = mode => Math.abs(mode.eigenvalue[1]) > 1e-9 * Math.hypot(...mode.eigenvalue);

// A vector rotated by a rotation vector.
function turned(v, rotation) {
  const angle = Math.hypot(...rotation);
  if (angle === 0) return v;
  const axis = rotation.map(c => c / angle), [c, s] = [Math.cos(angle), Math.sin(angle)], along = dot(axis, v) * (1 - c);
  const across = cross(axis, v);
  return v.map((x, i) => c * x + s * across[i] + along * axis[i]);
}

// Orthogonal axes of a section, and a point in these axes.
function axesOf(s) {
  const x = unit(cross(s.y, s.z));
  return [x, s.y, cross(x, s.y)];
}
const within = (s, point) => axesOf(s).map(axis => dot(axis, plus(point, s.at, -1)));
const outside = (s, [a, b, c]) => { const [x, y, z] = axesOf(s); return plus(plus(plus(s.at, x, a), y, b), z, c); };

// Changes of the sections of a mode at a frame of its state: displacement, rotation vector, strain measures.
function changesAt(mode, frame, factor) {
  const sections = about.bodies.reduce((sum, body) => sum + body.rims.length, 0);
  let place = mode.begin + PER_CHANGE * sections * frame;
  const [re, im] = factor, half = PER_CHANGE / 2;
  return about.bodies.map(body => body.rims.map(() => {
    const all = Array.from({ length: half }, (_, i) => re * modal.numbers[place + i] - im * modal.numbers[place + half + i]);
    place += PER_CHANGE;
    return { d: all.slice(0, 3), w: all.slice(3, 6), measures: all.slice(6) };
  }));
}

// Interpolated change at a position on a body.
function changeAt(changes, body, place) {
  const places = about.bodies[body].places, list = changes[body];
  if (places.length === 1) return list[0];
  let i = 0;
  while (i + 2 < places.length && places[i + 1] <= place) i++;
  const part = Math.max(0, Math.min(1, (place - places[i]) / (places[i + 1] - places[i])));
  const [a, b] = [list[i], list[i + 1]];
  return { d: mix(a.d, b.d, part), w: mix(a.w, b.w, part), measures: mix(a.measures, b.measures, part) };
}

// Writes the frame `index` of the cycle: the state `frame` displaced by a mode. Rotations are finite; the axis of a body follows from
// its rotated parts, so that it keeps its length at any amplitude.
function displace(index, frame, mode, factor) {
  const changes = changesAt(mode, frame - stateOfModes().frame, factor), { layout, numbers } = main, begin = about.begins[index];
  const write = (place, list) => list.forEach((value, i) => { numbers[begin + place + i] = value; });
  about.bodies.forEach((body, b) => {
    const list = changes[b];
    let at, last;
    list.forEach((change, i) => {
      const s = still.section(b, i, frame);
      if (i) {
        const arm = plus(s.at, last.at, -1), mean = mix(list[i - 1].w, change.w, 0.5);
        const strained = plus(plus(change.d, list[i - 1].d, -1), cross(mean, arm), -1);
        at = plus(at, turned(plus(arm, strained), mean));
      } else if (body.carrier) {
        const [carrier, place] = body.carrier, own = changeAt(changes, carrier, place);
        const arm = plus(s.at, sectionAt(still, carrier, place, frame).at, -1);
        const slide = plus(plus(change.d, own.d, -1), cross(own.w, arm), -1);
        at = plus(sectionAt(main, carrier, place, index).at, turned(plus(arm, slide), own.w));
      } else at = plus(s.at, change.d);
      last = s;
      write(layout.bodies[b] + PER_SECTION * i, [...at, ...turned(s.y, change.w), ...turned(s.z, change.w), 0, 0, 0, ...change.measures]);
    });
  });
  const carried = (body, place, point) =>
    outside(sectionAt(main, body, place, index), within(sectionAt(still, body, place, frame), point));
  const before = place => vector(still.numbers, still.about.begins[frame] + place);
  about.surfaces.forEach((surface, i) => surface.places.forEach((along, c) => [0, 3].forEach(end => {
    const place = layout.surfaces[i] + 6 * c + end;
    write(place, carried(surface.body, along, before(place)));
  })));
  about.gauges.forEach((gauge, i) => {
    write(layout.gauges + 3 * i, carried(gauge.body, gauge.place, before(layout.gauges + 3 * i)));
    numbers[begin + layout.strains + i] = strainAt(changeAt(changes, gauge.body, gauge.place).measures, gauge.point);
  });
}

// Duration of a cycle in s; 1 s for a mode that does not oscillate, which moves between its extremes.
function cycleOf(mode) {
  const rate = Math.abs(mode.exponent[1]);
  return oscillates(mode) && rate > 0 ? 2 * Math.PI / rate : 1;
}

// Amplitude relative to that at the start: constant, or at the rate of the mode; growth ends at the amplitude where decay starts.
function growthAt(mode, time, end) {
  if (!chosen.decay) return 1;
  const rate = mode.eigenvalue[0];
  return Math.exp(rate < 0 ? rate * time : rate * (time - end));
}

// Frames: cycles of the mode, or revolutions of the shaft.
function fillCycle() {
  const state = stateOfModes(), mode = modeShown();
  const turning = state.period !== null;
  const per = turning ? state.frames : PHASES, unitTime = turning ? state.period : cycleOf(mode);
  const rate = Math.abs(mode.eigenvalue[0]);
  let units = turning ? Math.max(1, Math.min(MOST_TURNS, Math.ceil(2 * cycleOf(mode) / state.period))) : 1;
  if (chosen.decay && rate > 0) units = Math.max(units, Math.min(MOST_CYCLES, Math.ceil(Math.log(DECAYED) / rate / unitTime)));
  // decay without oscillation
  const real = !oscillates(mode), span = real && chosen.decay && rate > 0 && !turning ? Math.log(DECAYED) / rate : units * unitTime;
  const count = per * units + 1, { length } = main.layout;
  if (main.numbers === still.numbers || main.numbers.length !== count * length) main.numbers = new Float32Array(count * length);
  about.begins = Array.from({ length: count }, (_, k) => k * length);
  about.rows = about.begins.map(() => []);
  for (let k = 0; k < count; k++) {
    const frame = state.frame + (turning ? k % state.frames : 0), from = still.about.begins[frame];
    main.numbers.set(still.numbers.subarray(from, from + length), k * length);
    const time = span * k / (count - 1);
    // a mode that does not oscillate moves between its extremes, unless it decays or grows
    const phase = real && !turning ? (chosen.decay ? 0 : 2 * Math.PI * k / per) : mode.exponent[1] * time;
    const size = chosen.amplitude * growthAt(mode, time, span);
    main.numbers[k * length + main.layout.time] = time;
    displace(k, frame, mode, [size * Math.cos(phase), size * Math.sin(phase)]);
  }
  amplitudes = amplitudesOf(state, mode);
  largestOf.clear();
}

// Amplitudes of the displacement of all sections in m, largest over the frames of the state.
let amplitudes = [];
function amplitudesOf(state, mode) {
  const most = about.bodies.map(body => body.rims.map(() => 0));
  for (let frame = 0; frame < state.frames; frame++) {
    const [re, im] = [changesAt(mode, frame, [1, 0]), changesAt(mode, frame, [0, -1])];
    most.forEach((list, b) => list.forEach((value, i) => {
      const [x, y] = [re[b][i].d, im[b][i].d], sum = dot(x, x) + dot(y, y);
      const size = Math.sqrt(0.5 * (sum + Math.hypot(dot(x, x) - dot(y, y), 2 * dot(x, y))));
      list[i] = Math.max(value, chosen.amplitude * size);
    }));
  }
  return most;
}

// Frame of the state, which rotates with the shaft.
const stillPosition = () => {
  const { frame, frames, period } = stateOfModes();
  return period === null ? frame : frame + main.position % frames;
};

// The phase of the cycle, or the azimuth of the shaft, as text.
function phaseText() {
  const state = stateOfModes(), mode = modeShown(), time = main.timeAt(main.position);
  if (state.period !== null) return `azimuth ${compact((main.position / state.frames) % 1 * 360, 0)}°, t = ${figures(time, 3)} s`;
  const real = !oscillates(mode);
  if (real) return chosen.decay ? `t = ${figures(time, 3)} s` : `phase ${compact(main.position / PHASES % 1 * 360, 0)}°`;
  return `phase ${compact(main.position / PHASES % 1 * 360, 0)}°, t = ${figures(time, 3)} s`;
}
