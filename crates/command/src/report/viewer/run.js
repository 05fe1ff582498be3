
// ---- runs: numbers of every frame, and their meaning ----------------------------------------------------------------

const get = id => document.getElementById(id);

// Decodes little-endian single-precision numbers on any computer.
function numbersOf(text) {
  const bytes = Uint8Array.from(atob(text.trim()), letter => letter.charCodeAt(0));
  if (new Uint8Array(new Uint16Array([1]).buffer)[0] === 1) return new Float32Array(bytes.buffer);
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
}

const PER_SECTION = 16, PER_STATION = 12, PER_LOAD = 6;

// Offsets in the part of a frame that has the same length in all frames.
function layoutOf(about) {
  let next = 0;
  const take = count => { const begin = next; next += count; return begin; };
  const found = {
    time: take(1), angles: take(about.joints.length), latched: take(about.joints.length), strains: take(about.gauges.length),
    energies: take(about.energies.length), gauges: take(3 * about.gauges.length),
  };
  found.bodies = about.bodies.map(body => take(PER_SECTION * body.rims.length));
  found.surfaces = about.surfaces.map(surface => take(6 * surface.columns));
  found.stations = take(PER_STATION * about.stations.length);
  found.reactions = take(6 * about.bodies.length);
  found.gravity = take(3);
  found.winds = take(3 * about.winds);
  found.strips = take(about.strips);
  found.loads = about.bodies.map(body => (body.loaded ? take(PER_LOAD * body.rims.length) : null));
  found.edgeForces = about.edgeForces ? about.surfaces.map(surface => take(3 * surface.columns)) : null;
  found.panelForces = about.panelForces ? about.surfaces.map(surface => take(surface.panels * (surface.columns - 1))) : null;
  found.length = next;
  return found;
}

class Run {
  constructor(about, numbers, label, index) {
    this.about = about;
    this.numbers = numbers;
    this.layout = layoutOf(this.about);
    this.label = label;
    this.index = index;
    this.shown = true;
    this.position = 0;
    this.present = new Float32Array(this.layout.length);
    this.columns = new Map();
    this.goTo(0);
  }

  get count() { return this.about.begins.length; }
  valueAt(frame, place) { return this.numbers[this.about.begins[frame] + place]; }
  timeOf(frame) { return this.valueAt(frame, this.layout.time); }
  get last() { return this.count - 1; }
  get duration() { return this.timeOf(this.last) - this.timeOf(0); }

  // Time at a position (frames), and position at a time; times ascend.
  timeAt(position) {
    const before = Math.min(Math.floor(position), this.last), after = Math.min(before + 1, this.last);
    return this.timeOf(before) + (position - before) * (this.timeOf(after) - this.timeOf(before));
  }
  positionAt(time) {
    let low = 0, high = this.last;
    if (time <= this.timeOf(low)) return low;
    if (time >= this.timeOf(high)) return high;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.timeOf(middle) <= time) low = middle; else high = middle;
    }
    return low + (time - this.timeOf(low)) / (this.timeOf(high) - this.timeOf(low));
  }

  // Interpolates the fixed part between two frames; `section` normalises the axes.
  goTo(position) {
    this.position = position;
    const before = Math.min(Math.floor(position), this.last), after = Math.min(before + 1, this.last);
    const share = position - before, { numbers, present } = this;
    const [a, b] = [this.about.begins[before], this.about.begins[after]];
    for (let i = 0; i < present.length; i++) present[i] = numbers[a + i] + share * (numbers[b + i] - numbers[a + i]);
    for (let i = 0; i < this.about.joints.length; i++) present[this.layout.latched + i] = numbers[a + this.layout.latched + i];
  }

  // Section of a body at the present time or at a frame: position, axes y and z, velocity of the axis, measures (γ, k₁, k₂, k₃).
  section(body, index, frame) {
    const list = frame === undefined ? this.present : this.numbers;
    const place = (frame === undefined ? 0 : this.about.begins[frame]) + this.layout.bodies[body] + PER_SECTION * index;
    return {
      at: vector(list, place), y: unit(vector(list, place + 3)), z: unit(vector(list, place + 6)), v: vector(list, place + 9),
      measures: [list[place + 12], list[place + 13], list[place + 14], list[place + 15]],
    };
  }

  // Internal force (axial, shear y, shear z) and moment (torsion, bending y, bending z) of a section of a beam, in its frame, now or at a
  // frame; `null` for other bodies.
  load(body, index, frame) {
    if (this.layout.loads[body] === null) return null;
    const list = frame === undefined ? this.present : this.numbers;
    const place = (frame === undefined ? 0 : this.about.begins[frame]) + this.layout.loads[body] + PER_LOAD * index;
    return Array.from(list.subarray(place, place + PER_LOAD));
  }

  // Wake of a frame: places of the first node and the first circulation in `numbers`, rows and columns, per surface.
  wakes(frame) {
    let place = this.about.begins[frame] + this.layout.length;
    return this.about.wakes.map((columns, surface) => {
      const rows = this.about.rows[frame][surface], nodes = place, rings = place + 3 * (rows + 1) * columns;
      place = rings + rows * (columns - 1);
      return { nodes, rings, rows, columns };
    });
  }

  // Values of one recorded signal; column 0 is the time.
  signal(column) {
    if (!this.columns.has(column)) {
      const width = this.about.signals.length + 1;
      this.columns.set(column, Array.from({ length: this.about.signalRows }, (_, row) => this.numbers[row * width + column]));
    }
    return this.columns.get(column);
  }
}

const vector = (list, place) => [list[place], list[place + 1], list[place + 2]];
const plus = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const length = Math.hypot(...a) || 1; return a.map(c => c / length); };
const mix = (a, b, share) => a.map((c, i) => c + share * (b[i] - c));
const pointOf = (s, [y, z]) => plus(plus(s.at, s.y, y), s.z, z);

// A run in progress: frames arrive from a socket, and the oldest are removed. Rows of signals have separate times.
const MOST_NUMBERS = 8_000_000, MOST_FRAMES = 1800, MOST_SAMPLES = 40_000;
class LiveRun extends Run {
  constructor(about, numbers, label, index) {
    super({ ...about, begins: [...about.begins], rows: [...about.rows], events: [...about.events] }, numbers, label, index);
    this.numbers = new Float32Array(Math.min(MOST_NUMBERS, Math.max(400_000, 4 * numbers.length)));
    this.numbers.set(numbers);
    this.end = numbers.length;
    this.times = [];
    this.samples = new Map(); // by name: values at `times`, null if not requested
  }

  // Values of one signal; column 0 is the time.
  signal(column) {
    if (column === 0) return this.times;
    return this.samples.get(this.about.signals[column - 1][0]) || Array(this.times.length).fill(null);
  }

  append(rows, frame) {
    if (this.end + frame.length > this.numbers.length) this.makeRoom(frame.length);
    this.numbers.set(frame, this.end);
    this.about.begins.push(this.end);
    this.about.rows.push(rows);
    this.end += frame.length;
    if (this.count > MOST_FRAMES) this.forget(this.count - MOST_FRAMES);
  }
  makeRoom(length) {
    if (2 * this.numbers.length <= MOST_NUMBERS) {
      const larger = new Float32Array(2 * this.numbers.length);
      larger.set(this.numbers);
      this.numbers = larger;
      return;
    }
    const { begins } = this.about, gone = Math.max(1, this.count >> 2);
    this.forget(gone);
    const from = begins[0];
    this.numbers.copyWithin(0, from, this.end);
    begins.forEach((begin, i) => { begins[i] = begin - from; });
    this.end -= from;
    if (this.end + length > this.numbers.length) {
      const larger = new Float32Array(this.end + 2 * length);
      larger.set(this.numbers.subarray(0, this.end));
      this.numbers = larger;
    }
  }
  // Removes the oldest frames.
  forget(frames) {
    this.about.begins.splice(0, frames);
    this.about.rows.splice(0, frames);
    this.position = Math.max(0, this.position - frames);
  }
  forgetBefore(time) {
    let gone = 0;
    while (gone < this.last && this.timeOf(gone) < time - 1e-6 * Math.max(1, Math.abs(time))) gone++;
    if (gone) this.forget(gone);
  }
  // Removes everything after a time.
  forgetAfter(time) {
    const slack = 1e-6 * Math.max(1, Math.abs(time)), { begins, rows, events } = this.about;
    while (this.count > 1 && this.timeOf(this.last) > time + slack) { this.end = begins.pop(); rows.pop(); }
    while (this.times.length && this.times[this.times.length - 1] > time + slack) {
      this.times.pop();
      for (const values of this.samples.values()) values.pop();
    }
    this.about.events = events.filter(event => event.t <= time + slack || event.kind === "gust");
    this.position = Math.min(this.position, this.last);
  }

  addSamples(names, numbers) {
    const width = names.length + 1, count = numbers.length / width, before = this.times.length;
    for (let row = 0; row < count; row++) this.times.push(numbers[row * width]);
    names.forEach((name, i) => {
      if (!this.samples.has(name)) this.samples.set(name, Array(before).fill(null));
      const values = this.samples.get(name);
      for (let row = 0; row < count; row++) values.push(numbers[row * width + i + 1]);
    });
    for (const values of this.samples.values()) while (values.length < this.times.length) values.push(null);
    if (this.times.length > MOST_SAMPLES) {
      const gone = this.times.length - MOST_SAMPLES + (MOST_SAMPLES >> 3);
      this.times.splice(0, gone);
      for (const values of this.samples.values()) values.splice(0, gone);
    }
  }
}

const besides = JSON.parse(get("beside").textContent);
// A page of a live simulation has a run that continues.
const live = (element => element && JSON.parse(element.textContent))(document.querySelector("script.live"));
const RunKind = live ? LiveRun : Run;
// A page with an editor starts the viewer for one run after another and passes the objects that are kept as `again`, which is `null` in other pages.
const sources = again ? [again] : [...document.querySelectorAll("script.run")].map(element =>
  ({ about: JSON.parse(element.textContent), numbers: numbersOf(element.nextElementSibling.textContent) }));
const runs = sources.map(({ about, numbers }, i) => new RunKind(about, numbers, i ? besides.runs[i - 1] : "this run", i));
// Listeners on objects that outlive a run are removed with it.
const listening = again ? { signal: again.signal } : {};

// A page of mode shapes has no run: its frames are states, from which `modes.js` computes the frames of the selected mode.
const modal = (element => element && { ...JSON.parse(element.textContent), numbers: numbersOf(element.nextElementSibling.textContent) })(document.querySelector("script.modes"));
const still = modal ? runs[0] : null;
if (modal) runs[0] = new Run({ ...still.about, begins: [0], rows: [[]] }, still.numbers, still.label, 0);
if (modal) {
  runs[0].label = "mode";
  // the state is drawn as a ghost
  runs.push(Object.assign(still, { label: "state", index: 1, ink: "#8b98a5" }));
}
if (live) live.machines.forEach((name, machine) => { runs[machine].label = name; });
const main = runs[0], about = main.about;

// Tables over time: measurements, or runs as CSV.
const tables = [];
function addTable(label, names, rows, numbers, recorded) {
  const width = names.length + 1;
  const column = c => Array.from({ length: rows }, (_, row) => { const value = numbers[row * width + c]; return Number.isNaN(value) ? null : value; });
  tables.push({ label, names, rows, recorded, time: column(0), column: name => column(names.indexOf(name) + 1), shown: true });
}
[...document.querySelectorAll("script.table")].forEach((element, i) => {
  const { label, names, rows, recorded } = besides.tables[i];
  addTable(label, names, rows, numbersOf(element.textContent), recorded);
});

// Extents over a run: of the machine at the start and of its whole motion.
function extentsOf(run) {
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity], points = [];
  const { about, layout, numbers } = run;
  let wing = 0;
  const stride = Math.max(1, Math.floor(run.count / 60));
  const include = (point, kept) => {
    point.forEach((c, i) => { least[i] = Math.min(least[i], c); most[i] = Math.max(most[i], c); });
    if (kept) points.push(point);
  };
  for (let frame = 0; frame < run.count; frame++) {
    const kept = frame % stride === 0 || frame === run.last;
    about.bodies.forEach((body, b) => body.rims.forEach((rim, i) => {
      const s = run.section(b, i, frame);
      if (kept) for (const point of rim) include(pointOf(s, point), true); else include(s.at, false);
    }));
    about.surfaces.forEach((surface, i) => {
      for (let c = 0; c < 2 * surface.columns; c++) include(vector(numbers, about.begins[frame] + layout.surfaces[i] + 3 * c), kept);
    });
    for (const mass of about.masses) include(massPlace(run, mass, frame), kept);
    if (frame === 0) wing = Math.hypot(...most.map((c, i) => c - least[i]));
  }
  if (live) {
    // the motion is unknown: use the length of the unfolded machine in all directions
    const reach = Math.max(live.reach_m - wing, 0.15 * wing);
    least.forEach((c, i) => { least[i] = c - reach; });
    most.forEach((c, i) => { most[i] = c + reach; });
    for (let corner = 0; corner < 8; corner++) points.push([0, 1, 2].map(i => (corner >> i & 1 ? most[i] - reach / 4 : least[i] + reach / 4)));
  }
  const size = Math.max(Math.hypot(...most.map((c, i) => c - least[i])), 1e-6);
  return { least, most, points, size, wing: Math.max(wing, 1e-6) };
}

// Extents of all machines of a live simulation; symbols are scaled to the first.
function extentsOfAll() {
  const all = runs.map(extentsOf), end = (name, choose) => [0, 1, 2].map(i => choose(...all.map(one => one[name][i])));
  const least = end("least", Math.min), most = end("most", Math.max), size = Math.max(Math.hypot(...most.map((c, i) => c - least[i])), 1e-6);
  return { least, most, points: all.flatMap(({ points }) => points), size, wing: all[0].wing };
}

// Position of a mass at the present time or at a frame.
function massPlace(run, mass, frame) {
  const s = sectionAt(run, mass.body, mass.place, frame);
  return [0, 1, 2].map(i => s.at[i] + mass.offset[0] * cross(s.y, s.z)[i] + mass.offset[1] * s.y[i] + mass.offset[2] * s.z[i]);
}

// Interval of a position on a body between recorded sections, and the share of the way through it.
function intervalOf(run, body, place) {
  const places = run.about.bodies[body].places;
  let i = 0;
  while (i + 2 < places.length && places[i + 1] < place) i++;
  return [i, places.length === 1 ? 0 : Math.max(0, Math.min(1, (place - places[i]) / (places[i + 1] - places[i])))];
}

// Section at any position on a body, interpolated between the recorded ones.
function sectionAt(run, body, place, frame) {
  const [i, share] = intervalOf(run, body, place);
  if (run.about.bodies[body].places.length === 1) return { ...run.section(body, 0, frame), index: 0, share: 0 };
  return between(run, body, i, share, frame);
}

// Velocity of the axis there.
function velocityAt(run, body, place, frame) {
  const [i, share] = intervalOf(run, body, place), list = frame === undefined ? run.present : run.numbers;
  const at = (frame === undefined ? 0 : run.about.begins[frame]) + run.layout.bodies[body] + PER_SECTION * i + 9;
  return share === 0 ? vector(list, at) : mix(vector(list, at), vector(list, at + PER_SECTION), share);
}
function between(run, body, index, share, frame) {
  const [a, b] = [run.section(body, index, frame), run.section(body, index + 1, frame)];
  return {
    at: mix(a.at, b.at, share), y: unit(mix(a.y, b.y, share)), z: unit(mix(a.z, b.z, share)), v: mix(a.v, b.v, share),
    measures: mix(a.measures, b.measures, share), index, share,
  };
}
