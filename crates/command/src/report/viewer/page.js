
// ---- controls -------------------------------------------------------------------------------------------------------

const get = id => document.getElementById(id);
const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const state = { position: 0, playing: false, last: 0, view: "oblique" };
const duration = timeOf(frameCount - 1) - timeOf(0);
// A number with a true minus sign, and none before a zero.
const compact = (value, digits) => value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
// So many digits that the largest value has as many as asked for.
const digitsFor = (largest, wanted) => Math.max(0, Math.min(6, wanted - 1 - Math.floor(Math.log10(largest))));
const microstrain = strain => compact(strain * 1e6, digitsFor(extents.strain * 1e6, 2));

// Position (frames) at a time, and time at a position; times ascend.
function timeAt(position) {
  const before = Math.min(Math.floor(position), frameCount - 1), after = Math.min(before + 1, frameCount - 1);
  return timeOf(before) + (position - before) * (timeOf(after) - timeOf(before));
}
function positionAt(time) {
  let low = 0, high = frameCount - 1;
  if (time <= timeOf(low)) return low;
  if (time >= timeOf(high)) return high;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (timeOf(middle) <= time) low = middle; else high = middle;
  }
  return low + (time - timeOf(low)) / (timeOf(high) - timeOf(low));
}

// Rows of the table: heading, or name with a text of the present numbers.
const rows = [];
function addRow(heading, name, text, swatch) {
  const row = get("values").tBodies[0].insertRow();
  const head = document.createElement("th");
  row.append(head);
  if (heading) { head.colSpan = 2; head.scope = "colgroup"; head.textContent = name; return; }
  head.scope = "row";
  let mark = null;
  if (swatch) { mark = document.createElement("span"); mark.className = "swatch"; head.append(mark); }
  head.append(name);
  rows.push({ cell: row.insertCell(), text, swatch, mark });
}
function buildTable() {
  if (about.joints.length) addRow(true, about.units.every(unit => unit === "°") ? "fold angles" : "joints");
  about.joints.forEach((name, i) => addRow(false, name, () => {
    const latched = about.latches[i].some(time => time <= timeAt(state.position) + 1e-12);
    const turns = about.units[i] === "°";
    return `${compact(present[layout.angles + i], turns ? 2 : 4)}${about.units[i]}${latched ? " latched" : ""}`;
  }));
  if (about.gauges.length) addRow(true, "strains");
  about.gauges.forEach(({ name }, i) => addRow(false, name, () => `${microstrain(present[layout.strains + i])} µm/m`,
    () => css(colour(STRAIN_MAP, present[layout.strains + i], extents.strain))));
  addRow(true, "energies");
  about.energies.forEach((name, i) => addRow(false, name, () => `${compact(present[layout.energies + i], digitsFor(extents.energy, 4))} J`));
}

function addScale(title, map, most, text) {
  const box = document.createElement("div");
  box.className = "scale";
  const bar = document.createElement("i");
  bar.style.background = `linear-gradient(to right, ${map.map(c => css(c)).join(", ")})`;
  const ends = document.createElement("div");
  for (const value of [-most, 0, most]) {
    const label = document.createElement("span");
    label.textContent = text(value);
    ends.append(label);
  }
  box.append(title, bar, ends);
  get("scales").append(box);
  return box;
}

// History of one scalar: a strip that also sets the time.
const quantities = [
  ...about.joints.map((name, i) => [`${about.coordinates[i]} of ${name} (${about.units[i].trim()})`, layout.angles + i]),
  ...about.gauges.map(({ name }, i) => [`strain of ${name}`, layout.strains + i]),
  ...about.energies.map((name, i) => [`${name} energy (J)`, layout.energies + i]),
];
const strip = get("history");
const stripPen = strip.getContext("2d");
function paintStrip() {
  const ratio = pixelRatio();
  const [width, height] = [strip.clientWidth, strip.clientHeight].map(length => Math.max(1, Math.round(length * ratio)));
  if (strip.width !== width || strip.height !== height) { strip.width = width; strip.height = height; }
  stripPen.clearRect(0, 0, width, height);
  const place = quantities[get("quantity").selectedIndex][1];
  const values = Array.from({ length: frameCount }, (_, frame) => valueAt(frame, place));
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const x = frame => (duration > 0 ? (timeOf(frame) - timeOf(0)) / duration : 0) * (width - 2) + 1;
  const y = value => height - 4 - (most > least ? (value - least) / (most - least) : 0.5) * (height - 8);
  stripPen.beginPath();
  values.forEach((value, frame) => (frame ? stripPen.lineTo(x(frame), y(value)) : stripPen.moveTo(x(frame), y(value))));
  stripPen.strokeStyle = inks.accent;
  stripPen.lineWidth = 1.5 * ratio;
  stripPen.stroke();
  const now = (duration > 0 ? (timeAt(state.position) - timeOf(0)) / duration : 0) * (width - 2) + 1;
  stripPen.fillStyle = inks.text;
  stripPen.fillRect(now - 0.75 * ratio, 0, 1.5 * ratio, height);
}
strip.addEventListener("pointerdown", event => {
  strip.setPointerCapture(event.pointerId);
  seekStrip(event);
});
strip.addEventListener("pointermove", event => { if (event.buttons) seekStrip(event); });
function seekStrip(event) {
  const box = strip.getBoundingClientRect();
  seek(positionAt(timeOf(0) + duration * (event.clientX - box.left) / box.width));
}

function show() {
  paint(state.position, { wake: get("wake").checked, trace: get("trace").checked });
  paintStrip();
  for (const { cell, text, swatch, mark } of rows) {
    cell.textContent = text();
    if (mark) mark.style.background = swatch();
  }
  const clock = `t = ${timeAt(state.position).toFixed(4)} s`;
  get("clock").textContent = clock;
  get("time").value = Math.round(state.position);
  get("time").setAttribute("aria-valuetext", clock);
}

// At most one picture per frame of the browser.
let waiting = false;
function changed() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; show(); });
}

function seek(position) {
  state.position = Math.max(0, Math.min(frameCount - 1, position));
  changed();
}

function play(on) {
  if (on && state.position >= frameCount - 1) state.position = 0;
  state.playing = on && frameCount > 1;
  get("play").setAttribute("aria-pressed", String(state.playing));
  get("play").textContent = state.playing ? "❚❚ pause" : "▶ play";
  state.last = 0;
  if (state.playing) requestAnimationFrame(tick);
}

function tick(now) {
  if (!state.playing) return;
  if (state.last) {
    let time = timeAt(state.position) + SPEEDS[get("speed").selectedIndex] * (now - state.last) / 1000;
    if (time >= timeOf(frameCount - 1)) {
      if (get("repeat").checked) time = timeOf(0); else play(false);
    }
    state.position = positionAt(time);
    show();
  }
  state.last = now;
  if (state.playing) requestAnimationFrame(tick);
}

function setView(name) {
  restarts = true;
  look(name);
  changed();
}

function stepBy(frames) {
  play(false);
  seek((frames > 0 ? Math.floor(state.position) : Math.ceil(state.position)) + frames);
}

function setSpeed(steps) {
  const list = get("speed");
  list.selectedIndex = Math.max(0, Math.min(SPEEDS.length - 1, list.selectedIndex + steps));
}

function toggleTheme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  readInks();
  changed();
}

function reset() {
  play(false);
  state.position = 0;
  setView("oblique");
}

function toggle(id) {
  get(id).checked = !get(id).checked;
  changed();
}

const KEYS = {
  " ": () => play(!state.playing), ArrowLeft: () => stepBy(-1), ArrowRight: () => stepBy(1),
  ArrowUp: () => setSpeed(1), ArrowDown: () => setSpeed(-1), Home: () => seek(0), End: () => seek(frameCount - 1),
  1: () => setView("x"), 2: () => setView("y"), 3: () => setView("z"), 4: () => setView("oblique"),
  r: reset, t: toggleTheme, w: () => toggle("wake"), f: () => { get("follow").checked = !follows(); setView("oblique"); }, "+": () => { zoom(0.85); changed(); }, "-": () => { zoom(1 / 0.85); changed(); },
};
const TURNS = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] };
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName;
  // lists and the slider have their own use for arrows, buttons and boxes for the space bar
  if (tag === "SELECT" || (tag === "INPUT" && event.target.type === "range" && event.key !== " " && event.key.length > 1)) return;
  if ((tag === "BUTTON" || tag === "INPUT") && event.key === " " && event.target.type !== "range") return;
  const turning = event.shiftKey && TURNS[event.key];
  const action = turning ? () => { turn(...turning); changed(); } : KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

function listen() {
  get("play").addEventListener("click", () => play(!state.playing));
  get("back").addEventListener("click", () => stepBy(-1));
  get("forth").addEventListener("click", () => stepBy(1));
  get("reset").addEventListener("click", reset);
  get("theme").addEventListener("click", toggleTheme);
  get("time").addEventListener("input", event => { play(false); seek(Number(event.target.value)); });
  for (const id of ["wake", "trace", "quantity"]) get(id).addEventListener("change", changed);
  get("follow").addEventListener("change", () => setView("oblique"));
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => setView(button.dataset.view));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readInks(); changed(); });
  new ResizeObserver(changed).observe(canvas);
  listenToPointers(changed);
}

function begin() {
  get("name").textContent = about.name;
  get("about").textContent = about.description;
  get("time").max = frameCount - 1;
  for (const speed of SPEEDS) get("speed").add(new Option(`${speed} ×`));
  // the whole run within about eight seconds
  const wanted = duration / 8;
  get("speed").selectedIndex = SPEEDS.reduce((best, speed, i) =>
    Math.abs(Math.log(speed / wanted)) < Math.abs(Math.log(SPEEDS[best] / wanted)) ? i : best, 0);
  for (const [name] of quantities) get("quantity").add(new Option(name));
  buildTable();
  addScale("strain (µm/m)", STRAIN_MAP, extents.strain, microstrain);
  const hasWake = about.wakes.length > 0;
  get("wake-label").hidden = !hasWake;
  if (hasWake) {
    const digits = digitsFor(extents.circulation, 2);
    addScale("circulation of the wake (m²/s)", WAKE_MAP, extents.circulation, value => compact(value, digits));
  }
  get("follow").checked = extents.size > 4 * extents.wing;
  readInks();
  listen();
  look("oblique");
  show();
}
begin();
