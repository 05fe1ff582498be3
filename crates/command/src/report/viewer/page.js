
// ---- controls --------------------------------------------------------------------------------------------------------

let SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const state = { playing: false, last: 0, slow: 0, economy: 0 };
const shapes = []; // of bodies and surfaces, of all runs

// Rows of the table: a heading, or a name with the present value as text.
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
  const { present, layout } = main;
  if (about.joints.length) addRow(true, `${about.units.every(unit => unit === "°") ? "fold angles" : "joints"}${modal ? " of the state" : ""}`);
  about.joints.forEach((name, i) => addRow(false, name, () => {
    const turns = about.units[i] === "°";
    return `${compact(present[layout.angles + i], turns ? 2 : 4)}${about.units[i]}${present[layout.latched + i] ? " latched" : ""}`;
  }));
  if (about.gauges.length) addRow(true, modal ? "strains of the mode" : "strains");
  about.gauges.forEach(({ name }, i) => addRow(false, name, () => `${compact(1e6 * present[layout.strains + i], digitsFor(1e6 * largest(FIELDS.strain), 3))} µm/m`,
    () => cssOf(DIVERGING, share(present[layout.strains + i], largest(FIELDS.strain)))));
  if (modal) return;
  addRow(true, "energies");
  const energy = live ? 0 : Math.max(1e-9, ...about.energies.map((_, i) => Math.max(...Array.from({ length: main.count }, (_, f) => Math.abs(main.valueAt(f, layout.energies + i))))));
  about.energies.forEach((name, i) => addRow(false, name, () => `${live ? figures(present[layout.energies + i], 4) : compact(present[layout.energies + i], digitsFor(energy, 4))} J`));
}

// The colour scales.
function addScale(id) {
  const box = document.createElement("div");
  box.className = "scale";
  box.id = id;
  box.append(document.createElement("b"), document.createElement("i"), document.createElement("div"));
  for (let i = 0; i < 3; i++) box.lastChild.append(document.createElement("span"));
  get("scales").append(box);
  return box;
}
function setScale(box, title, map, ends, text) {
  box.map = map;
  box.firstChild.textContent = title;
  box.children[1].style.background = `linear-gradient(to right, ${[0, 0.25, 0.5, 0.75, 1].map(at => cssOf(map, at)).join(", ")})`;
  ends.forEach((value, i) => { box.lastChild.children[i].textContent = text(value); });
}
function setScales() {
  setNotes();
  const factor = field.factor || 1, most = bodyRange() * factor, body = get("body-scale");
  body.hidden = !painted(field) || about.bodies.every((one, b) => one.rigid || enclosed(main, b));
  const text = value => (Math.abs(most) < 1e-2 ? figures(value, 2) : compact(value, digitsFor(most, modal ? 2 : 3)));
  setScale(body, field.title, field.rising ? RISING : DIVERGING, field.rising ? [0, most / 2, most] : [-most, 0, most], text);
  const air = get("air-scale"), range = circulationRange(), ofWake = about.wakes.length && get("wake").checked;
  const circulates = surfaceField === SURFACE_FIELDS.circulation;
  air.hidden = !largestCirculation || !(circulates || ofWake);
  setScale(air, "circulation (m²/s)", WAKE_MAP, [-range, 0, range], value => compact(value, digitsFor(range, 2)));
  const surface = get("surface-scale");
  surface.hidden = circulates || !surfaceField.of;
  if (surface.hidden) return;
  const reach = surfaceRange();
  setScale(surface, surfaceField.title, surfaceField.map, [-reach, 0, reach], value => (Math.abs(reach) < 1e-2 ? figures(value, 2) : compact(value, digitsFor(reach, 3))));
}

// Notes on parts that are drawn with dimensions that the model does not have.
function addNotes() {
  const box = document.createElement("p");
  box.id = "notes";
  box.className = "scale";
  get("scales").append(box);
}
function setNotes() {
  const box = get("notes"), shown = about.notes.filter(note => solid() || !note.startsWith("Aerofoils"));
  box.textContent = shown.join(" ");
  box.hidden = !shown.length;
}

// A round length of at most a sixth of the stage.
function showRuler() {
  const per = pixelsPerMetre(), raw = canvas.clientWidth / 6 / per, power = 10 ** Math.floor(Math.log10(raw));
  const length = power * [5, 2, 1].find(step => step * power <= raw), ruler = get("ruler");
  ruler.firstElementChild.style.width = `${length * per}px`;
  const [size, name] = length >= 1 ? [length, "m"] : length >= 0.01 ? [length * 100, "cm"] : [length * 1000, "mm"];
  ruler.lastElementChild.textContent = `${+size.toPrecision(3)} ${name}`;
}

function render() {
  if (!renderer) return;
  follow();
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map(length => Math.max(1, length));
  // if pictures take long, fewer pixels without shadow are better than a motion that jumps
  const economy = state.playing && !filming ? state.economy : 0;
  const ratio = Math.min(window.devicePixelRatio || 1, 2) * (economy > 1 ? 0.6 : 1);
  if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
  }
  updateWake();
  aim();
  const middle = followed || extents.least.map((c, i) => (c + extents.most[i]) / 2);
  const radius = (followed ? 0.7 * extents.wing : 0.6 * extents.size) || 1;
  aimSun(middle, radius);
  clipShade(radius);
  for (const label of signs) {
    const away = camera.flat ? camera.distance : Math.max(1e-9, dot(plus(lens().position.toArray(), label.position.toArray(), -1), camera.axes[2]));
    const metres = label.userData.pixels * away / (camera.distance * pixelsPerMetre());
    label.scale.set(metres * label.userData.aspect, metres, 1);
  }
  for (const shape of shapes) {
    const { mesh, lattice, run } = shape;
    const seen = run.shown && !(shape instanceof BodyShape && enclosed(run, shape.index));
    mesh.visible = seen;
    if (lattice) lattice.visible = seen;
    if (seen) shape.update();
  }
  updateMarks();
  updateArrows();
  placePickMark();
  if (live) updatePull();
  updateFan();
  marks.visible = links.visible = main.shown;
  ground.visible = axes.visible = get("ground").checked;
  sun.castShadow = get("shadow").checked && ground.visible && economy === 0;
  renderer.render(scene, lens());
}

// Updates everything to the present position; at most once per frame of the browser.
function show() {
  const time = main.timeAt(main.position);
  for (const run of runs) if (run !== main) run.goTo(run === still ? stillPosition() : run.positionAt(time));
  const clock = modal ? phaseText() : `t = ${compact(time, 4)} s`;
  get("clock").textContent = clock;
  get("time").value = Math.round(main.position);
  get("time").setAttribute("aria-valuetext", clock);
  if (filming) filming(); else render();
  showRuler();
  for (const { cell, text, swatch, mark } of rows) {
    cell.textContent = text();
    if (mark) mark.style.background = swatch();
  }
  // the plots are those of the previous run until the present one is complete
  if (live) refreshCharts(); else if (!state.partial) for (const chart of charts) chart.keep();
  showAlong();
  noteAddress();
  showPicked();
  showHover();
}

let waiting = false;
function changed() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; if (!again?.signal.aborted) show(); });
}

function seek(position) {
  main.goTo(Math.max(0, Math.min(main.last, position)));
  changed();
}

function play(on) {
  if (live) { if (on) Object.assign(link, { looking: false, dragging: false }); send({ do: on ? "run" : "pause" }); return; }
  if (on && main.position >= main.last) main.goTo(0);
  state.playing = on && main.count > 1;
  get("play").setAttribute("aria-pressed", String(state.playing));
  get("play").textContent = state.playing ? "❚❚ pause" : "▶ play";
  Object.assign(state, { last: 0, slow: 0, economy: 0 });
  if (state.playing) requestAnimationFrame(tick); else changed();
}
function tick(now) {
  if (!state.playing) return;
  if (state.last) {
    let time = main.timeAt(main.position) + SPEEDS[get("speed").selectedIndex] * (now - state.last) / 1000;
    if (time >= main.timeOf(main.last)) {
      if (get("repeat").checked) time = main.timeOf(0); else { time = main.timeOf(main.last); play(false); }
    }
    main.goTo(main.positionAt(time));
    show();
    state.slow = now - state.last > 90 ? state.slow + 1 : 0;
    if (state.slow > 3) Object.assign(state, { economy: Math.min(2, state.economy + 1), slow: 0, slowed: true });
  }
  state.last = now;
  if (state.playing) requestAnimationFrame(tick);
}

function setView(name) { look(name); changed(); }
function stepBy(frames) {
  if (live) { if (frames > 0) { link.looking = false; send({ do: "step" }); } else rollBack(Math.max(0, Math.min(main.last, Math.ceil(main.position)) - 1)); return; }
  play(false);
  seek((frames > 0 ? Math.floor(main.position) : Math.ceil(main.position)) + frames);
}
function setSpeed(steps) {
  const list = get("speed");
  list.selectedIndex = Math.max(0, Math.min(SPEEDS.length - 1, list.selectedIndex + steps));
  if (live) send({ do: "speed", value: SPEEDS[list.selectedIndex] });
}
const systemDark = matchMedia("(prefers-color-scheme: dark)");
let chosenDark = again?.dark ?? null;
function setTheme() {
  document.documentElement.dataset.dark = String(chosenDark === null ? systemDark.matches : chosenDark);
  readInks();
  charts.forEach(chart => chart.build());
  buildAlongCharts();
  buildModePlots();
  changed();
}
function toggleTheme() {
  chosenDark = document.documentElement.dataset.dark !== "true";
  setTheme();
}
function reset() {
  if (live) { send({ do: "restart" }); return; }
  play(false);
  main.goTo(0);
  if (camera.flat) toggleFlat();
  setView("iso");
}
function toggle(id) {
  get(id).checked = !get(id).checked;
  changed();
}
function toggleFlat() {
  camera.flat = !camera.flat;
  get("flat").setAttribute("aria-pressed", String(camera.flat));
  changed();
}
function setFollow(name) {
  get("follow").value = name;
  followed = followPoint();
  if (followed) { const shift = plus(followed, camera.target, -1); camera.target = plus(camera.target, shift); }
  changed();
}
function frameNow() { camera.preset = null; frameAll(presentPoints()); changed(); }
const savePicture = async () => save(await pictureBlob(), ".png");
async function saveFilm() {
  say("recording the film: the run plays once");
  save(await filmBlob(), ".webm");
  say("");
}
function say(text) { get("said").textContent = text; }

const KEYS = {
  " ": () => play(!state.playing), ArrowLeft: () => stepBy(-1), ArrowRight: () => stepBy(1),
  ArrowUp: () => setSpeed(1), ArrowDown: () => setSpeed(-1), Home: () => seek(0), End: () => seek(main.last),
  1: () => setView("front"), 2: () => setView("side"), 3: () => setView("top"), 4: () => setView("iso"), a: frameNow, o: toggleFlat,
  r: reset, t: toggleTheme, w: () => toggle("wake"), f: () => setFollow(get("follow").value === "nothing" ? "machine" : "nothing"),
  ...(modal && { ArrowUp: () => chooseMode(-1), ArrowDown: () => chooseMode(1), PageUp: () => chooseState(1), PageDown: () => chooseState(-1), d: toggleDecay }),
  p: savePicture, "+": () => { zoom(0.85); changed(); }, "-": () => { zoom(1 / 0.85); changed(); },
};
const TURNS = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] };
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { tagName: tag, type } = event.target;
  // lists, text fields and sliders use keys themselves, buttons and boxes use the space bar
  if (event.target.isContentEditable || tag === "SELECT" || (tag === "INPUT" && !["range", "checkbox", "file"].includes(type))) return;
  if (tag === "INPUT" && type === "range" && event.key !== " " && event.key.length > 1) return;
  if (["BUTTON", "INPUT", "SUMMARY"].includes(tag) && event.key === " " && type !== "range") return;
  const turning = event.shiftKey && TURNS[event.key];
  const action = turning ? () => { turn(...turning); changed(); } : KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
}, listening);

function listen() {
  const click = (id, action) => get(id).addEventListener("click", action);
  click("play", () => play(!state.playing));
  click("back", () => stepBy(-1));
  click("forth", () => stepBy(1));
  click("reset", reset);
  click("theme", toggleTheme);
  click("flat", toggleFlat);
  click("frame", frameNow);
  click("save-picture", savePicture);
  click("save-film", saveFilm);
  click("save-table", () => save(new Blob([tableText()], { type: "text/csv" }), ".csv"));
  if (live) listenLive(); else get("time").addEventListener("input", event => { play(false); seek(Number(event.target.value)); });
  for (const id of ["wake", "trace", "joints", "gauges", "lattice", "aerofoils", "glass", "ground", "shadow"]) get(id).addEventListener("change", () => { setScales(); changed(); });
  get("surface-field").addEventListener("change", event => { surfaceField = SURFACE_FIELDS[event.target.value]; ranges.surface = null; get("surface-range").value = ""; setScales(); changed(); });
  get("follow").addEventListener("change", event => setFollow(event.target.value));
  get("field").addEventListener("change", event => { field = FIELDS[event.target.value]; ranges.body = null; get("range").value = ""; setScales(); changed(); });
  const number = (id, key) => get(id).addEventListener("input", event => {
    const value = Number(event.target.value);
    ranges[key] = value > 0 ? value : null;
    setScales();
    changed();
  });
  number("range", "body");
  number("surface-range", "surface");
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => setView(button.dataset.view));
  get("open").addEventListener("change", event => { if (event.target.files[0]) openTable(event.target.files[0]); event.target.value = ""; });
  document.addEventListener("dragover", event => event.preventDefault(), listening);
  document.addEventListener("drop", event => { event.preventDefault(); if (event.dataTransfer.files[0]) openTable(event.dataTransfer.files[0]); }, listening);
  systemDark.addEventListener("change", setTheme, listening);
  const sizes = new ResizeObserver(changed);
  sizes.observe(canvas);
  again?.signal.addEventListener("abort", () => sizes.disconnect());
  listenToPointers(changed, hover, pick);
}

// Check boxes that show and hide runs and tables.
function listRuns() {
  const all = [...runs, ...tables];
  get("runs").hidden = all.length < 2;
  get("runs").replaceChildren(...all.map(one => {
    const label = document.createElement("label"), box = document.createElement("input"), mark = document.createElement("span");
    Object.assign(box, { type: "checkbox", checked: one.shown });
    box.addEventListener("change", () => { one.shown = box.checked; charts.forEach(chart => chart.build()); changed(); });
    mark.className = "swatch";
    mark.style.background = one instanceof Run ? (one === main ? inks.body : runInk(one)) : "none";
    label.append(box, mark, one instanceof Run ? `${one.label}${one === main || modal ? "" : " – – –"}` : `${one.label} · · ·`);
    return label;
  }));
}

const arrowText = set => `${set.title}, longest ${figures(set.most > 1e-9 ? set.most : 0, 3)} ${set.unit}`;
function buildControls() {
  get("name").textContent = live ? live.machines.join(" and ") : about.name;
  get("about").textContent = about.description;
  get("time").max = main.last;
  if (!modal) for (const speed of SPEEDS) get("speed").add(new Option(`${speed} ×`));
  // the whole run within about eight seconds
  const wanted = live ? live.speed : main.duration / 8;
  get("speed").selectedIndex = SPEEDS.reduce((best, speed, i) =>
    Math.abs(Math.log(speed / wanted)) < Math.abs(Math.log(SPEEDS[best] / wanted)) ? i : best, 0);
  for (const [name, { title }] of Object.entries(FIELDS)) get("field").add(new Option(title, name));
  for (const name of ["nothing", "machine", ...about.tips, "picked"]) {
    get("follow").add(new Option({ nothing: "nothing", machine: "the model", picked: "the selected item" }[name] || `end of ${name}`, name));
  }
  get("follow").querySelector("[value=picked]").disabled = true;
  for (const set of arrowSets) {
    const label = document.createElement("label"), box = document.createElement("input"), mark = document.createElement("span");
    Object.assign(box, { type: "checkbox", id: `arrow-${set.name}`, checked: Boolean(set.shown) });
    box.addEventListener("change", changed);
    mark.className = "swatch";
    mark.style.background = set.ink;
    set.text = document.createElement("span");
    set.text.textContent = arrowText(set);
    label.append(box, mark, set.text);
    get("arrows").append(label);
  }
  const hasAir = about.surfaces.length > 0;
  for (const element of document.querySelectorAll(".airy")) element.hidden = !hasAir;
  for (const [name, { title }] of Object.entries(SURFACE_FIELDS)) get("surface-field").add(new Option(title, name));
  get("surface-field").value = Object.keys(SURFACE_FIELDS).find(name => SURFACE_FIELDS[name] === surfaceField);
  get("aerofoils-label").hidden = !about.aerofoils.some(Boolean);
  get("aerofoils").checked = aerofoilsAtStart;
  get("wake-label").hidden = !about.wakes.length;
  get("fan-label").hidden = !fan;
  get("fan").addEventListener("change", () => { charts.forEach(chart => chart.build()); get("fan-scale").hidden = !get("fan").checked; changed(); });
  if (!filmType) Object.assign(get("save-film"), { disabled: true, title: "This browser cannot record WebM" });
  const left = [];
  if (modal && modal.states.length < modal.found) left.push(`${modal.states.length} of ${modal.found} states are on this page`);
  if (!modal && !live && main.count < about.recorded) left.push(`${main.count} of ${about.recorded} points in time are drawn`);
  if (!live && about.signalRows < about.points) left.push(`plots have ${about.signalRows} of ${about.points} points`);
  if (fan && fan.like < fan.count) left.push(`${fan.count - fan.like} of ${fan.count} runs are left out: they failed or have another structure than this one`);
  if (fan && fan.labels.length < fan.like) left.push(`${fan.labels.length} of ${fan.like} runs are drawn; the bands include all`);
  for (const table of tables) if (table.rows < table.recorded) left.push(`${table.label} has ${table.rows} of ${table.recorded} rows`);
  get("thinned").hidden = !left.length;
  get("thinned").textContent = `${left.join("; ")}, at equal intervals${modal ? "" : ": short peaks may be missing"}.`;
  listEvents();
}

// Events above the time bar.
function listEvents() {
  get("events").replaceChildren(...eventsSeen().map(event => {
    const mark = document.createElement("button");
    Object.assign(mark, { type: "button", title: `${event.text}, ${compact(event.t, 4)} s` });
    mark.setAttribute("aria-label", `Go to ${event.t.toFixed(4)} s: ${event.text}`);
    mark.style.left = `${100 * (main.positionAt(event.t) / Math.max(1, main.last))}%`;
    mark.style.background = EVENT_INKS[event.kind];
    mark.addEventListener("click", () => { if (live) { rollBack(Math.floor(main.positionAt(event.t))); return; } play(false); seek(main.positionAt(event.t)); });
    return mark;
  }));
}

function buildScene() {
  buildLights();
  buildGround();
  buildAxes();
  for (const run of runs) {
    run.about.bodies.forEach((body, b) => { if (!body.rigid) shapes.push(new BodyShape(run, b)); });
    run.about.surfaces.forEach((_, i) => shapes.push(new SurfaceShape(run, i)));
  }
  for (const run of runs) if (run.about.solids.length) shapes.push(new SolidShape(run));
  for (const { mesh, lattice } of shapes) { scene.add(mesh); if (lattice) scene.add(lattice); }
  if (wakeMesh) scene.add(wakeMesh);
  for (const object of [links, traces, pickMark]) { object.frustumCulled = false; scene.add(object); }
  pickMark.renderOrder = 9;
  scene.add(marks);
  pickables.push(...shapes.map(({ mesh }) => mesh), ...marks.children);
  buildArrows();
  if (live) buildPull();
}

function begin() {
  document.documentElement.dataset.dark = String(chosenDark === null ? systemDark.matches : chosenDark);
  readInks();
  buildScene();
  paintInks();
  buildControls();
  addScale("body-scale");
  buildFan();
  addScale("surface-scale");
  addScale("air-scale");
  addNotes();
  // the beginning of a run is shown without plots and values; those of the previous run remain until it is complete
  if (!again || again.done) {
    buildTable();
    if (live) buildLive();
    if (modal) buildModes(); else { buildPlots(); buildAlong(); }
  }
  listRuns();
  listen();
  setScales();
  get("missing").hidden = renderer !== null;
  get("stage").classList.toggle("without", renderer === null);
  if (live ? about.hinges.some(hinge => hinge.kind === "spatial") : fliesAway()) setFollow("machine");
  if (!again?.kept) { look("iso"); startAddress(); show(); }
  if (live) { connect(); showRunning(); showPace(); }
  if (modal && !matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
}
begin();
