
// ---- a live simulation: socket, commands, frames, time bar -----------------------------------------------------------------

const link = live && {
  socket: null, running: false, looking: false, dragging: false, watched: new Set(), pull: null, pulls: [], ended: false, plotted: 0, scaled: 0, waiting: new Map(), factor: null,
};

// Sends a command to the simulation.
function send(order) {
  if (link.socket && link.socket.readyState === WebSocket.OPEN) link.socket.send(JSON.stringify(order));
}
// The same for continuous input: only the last command per frame is sent.
function sendSoon(key, order) {
  if (!link.waiting.size) requestAnimationFrame(() => { const all = [...link.waiting.values()]; link.waiting.clear(); all.forEach(send); });
  link.waiting.set(key, order);
}

function connect() {
  link.socket = new WebSocket(`ws://${location.host}${location.pathname}socket`);
  link.socket.binaryType = "arraybuffer";
  link.socket.addEventListener("message", event => (typeof event.data === "string" ? receive(JSON.parse(event.data)) : takeFrame(event.data)));
  link.socket.addEventListener("close", () => {
    Object.assign(link, { ended: true, running: false });
    releasePull();
    showPace();
    showRunning();
    for (const control of document.querySelectorAll("#live input, #live button, #play, #back, #forth, #reset, #speed")) control.disabled = true;
  });
  link.socket.addEventListener("open", () => { link.fresh = true; link.watched.clear(); watchCharts(); });
}

function receive(message) {
  if (message.values) setControls([message.values, ...message.others]);
  if (message.kind === "refused") say(message.message);
  if (message.kind === "connected") about.events = message.events;
  if (message.kind === "rolled_back") {
    for (const run of runs) run.forgetAfter(message.time);
    link.looking = false;
    main.goTo(main.last);
    say("");
  }
  if (message.kind === "connected" || message.kind === "rolled_back") listEvents();
}

// A message has a header in JSON, then for each machine the samples of its plots and its frame, in the format of `Session::next_frame`.
function takeFrame(data) {
  const length = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const numbers = new Float32Array(data, 4 + length), { time } = header, parts = [header, ...header.others];
  let next = 0;
  runs.forEach((run, i) => {
    const part = parts[i], samples = part.samples * (part.names.length + 1);
    if (samples) run.addSamples(part.names, numbers.subarray(next, next + samples));
    next += samples;
    takeState(run, header, part.rows, numbers.subarray(next, next + part.numbers));
    next += part.numbers;
  });
  link.fresh = false;
  if (header.events.length) { about.events.push(...header.events); listEvents(); }
  if (header.failure) say(`the simulation failed: ${header.failure}`);
  const pulls = parts.map(({ pull }) => pull);
  Object.assign(link, { running: header.running, pull: pulls[0], pulls, factor: header.factor, lost: header.lost, speed: header.speed });
  get("time").max = main.last;
  if (!link.looking && !link.dragging) main.goTo(main.last);
  growScales();
  showPace();
  showRunning();
  changed();
}
function takeState(run, { time, oldest }, rows, frame) {
  if (time > run.timeOf(run.last) + 1e-7) run.append(rows, frame);
  else if (run.timeOf(run.last) <= time + 1e-7) replaceLast(run, rows, frame);
  run.forgetBefore(oldest);
  // the page contains the first frame of the simulation; a page that connects later discards it
  if (link.fresh && time > run.timeOf(0) + 1e-6) run.forget(run.last);
}
// A frame of the same time, for example after a value was changed during a pause.
function replaceLast(run, rows, frame) {
  run.end = run.about.begins.pop();
  run.about.rows.pop();
  run.append(rows, frame);
}

function showRunning() {
  state.playing = link.running;
  get("play").setAttribute("aria-pressed", String(link.running));
  get("play").textContent = link.running ? "❚❚ pause" : "▶ run";
}
function showPace() {
  const { factor, lost, speed, ended, running } = link, slow = running && factor !== null && factor < 0.95 * speed;
  get("pace").classList.toggle("slow", slow);
  get("pace").textContent = ended ? "The simulation has ended; the run so far remains on this page."
    : !running ? `paused${lost > 0 ? `; ${figures(lost, 3)} s lost so far` : ""}`
    : factor === null ? "running"
    : `${compact(factor, 2)} × real time${slow ? `: this computer is too slow for ${speed} ×` : ""}${lost > 0 ? `; ${figures(lost, 3)} s lost so far` : ""}`;
}

// Scales and arrows grow with the largest values so far.
function growScales() {
  for (const wanted of new Set([field, FIELDS.strain])) {
    if (!wanted.value || !largestOf.has(wanted)) continue;
    let most = largestOf.get(wanted);
    about.bodies.forEach((body, b) => body.rims.forEach((rim, i) => {
      const s = main.section(b, i);
      for (const point of wanted === FIELDS.strain ? rim : [rim[0]]) most = Math.max(most, Math.abs(wanted.value(main, b, i, s, point)));
    }));
    largestOf.set(wanted, most);
  }
  for (let i = 0; i < about.strips; i++) largestCirculation = Math.max(largestCirculation, Math.abs(main.present[main.layout.strips + i]));
  for (const set of arrowSets) for (const [, value] of set.of()) set.most = Math.max(set.most, Math.hypot(...value));
  const now = performance.now();
  if (now - link.scaled < 300) return;
  link.scaled = now;
  setScales();
  if (about.events.length) listEvents();
  for (const set of arrowSets) if (set.text) set.text.textContent = arrowText(set);
}

// Plots are updated fifteen times per second.
function refreshCharts() {
  const now = performance.now();
  if (now - link.plotted < 66 && link.running) return;
  link.plotted = now;
  for (const chart of charts) chart.refresh();
}
// Requests the outputs of new plots from the simulation.
function watchCharts() {
  if (!live || !link.socket) return;
  const names = [...new Set(charts.flatMap(chart => chart.names))].filter(name => !link.watched.has(name));
  if (!names.length || link.socket.readyState !== WebSocket.OPEN) return;
  names.forEach(name => link.watched.add(name));
  send({ do: "watch", names });
}
// Range of time of the plots unless they are zoomed.
function plotWindow() {
  const span = Number(get("window").value), begin = main.times.length ? main.times[0] : main.timeOf(0);
  const end = link.looking || link.dragging ? main.timeAt(main.position) + span / 2 : main.timeOf(main.last);
  return end - span < begin ? [begin, begin + span] : [end - span, end];
}

// The time bar: dragging shows earlier frames, releasing rolls back.
function lookAt(position) {
  main.goTo(Math.max(0, Math.min(main.last, position)));
  changed();
}
function rollBack(position) {
  link.dragging = false;
  const time = main.timeOf(Math.round(position));
  if (Math.round(position) < main.last) send({ do: "rollback", time_s: time }); else { link.looking = false; lookAt(main.last); }
}
function listenLive() {
  const bar = get("time");
  bar.addEventListener("input", () => { if (!link.dragging) send({ do: "pause" }); link.dragging = link.looking = true; lookAt(Number(bar.value)); });
  bar.addEventListener("change", () => rollBack(Number(bar.value)));
  get("speed").addEventListener("change", () => send({ do: "speed", value: SPEEDS[get("speed").selectedIndex] }));
  get("window").addEventListener("change", changed);
  addEventListener("pagehide", () => link.socket.close());
}

// ---- pulling: a spring between a load station and the pointer ---------------------------------------------------------

const spring = live && { lines: runs.map(() => lines(new THREE.LineBasicMaterial({ depthTest: false }))), held: null, dots: [] };
const stationPlace = (i, run = main) => vector(run.present, run.layout.stations + PER_STATION * i);

function buildPull() {
  for (const line of spring.lines) {
    line.renderOrder = 8;
    line.frustumCulled = false;
    scene.add(line);
  }
  for (const run of runs) run.about.stations.forEach((station, i) => {
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.006 * WIDTH, 12, 8), new THREE.MeshLambertMaterial({ color: run === main ? "#c2410c" : runInk(run) }));
    dot.userData = { run, station: i, body: station.body, describe: () => ({
      title: run === main ? station.name : `${station.name} (${run.label})`,
      rows: () => [["at", `${three(stationPlace(i, run))} m`], ["force", `${three(vector(run.present, run.layout.stations + PER_STATION * i + 3))} N`]],
      place: () => stationPlace(i, run),
    }) };
    spring.dots.push(dot);
    marks.add(dot);
    pickables.push(dot);
  });
}
function updatePull() {
  for (const dot of spring.dots) {
    const { run, station } = dot.userData;
    dot.visible = run.shown;
    dot.position.set(...stationPlace(station, run));
  }
  const texts = [];
  runs.forEach((run, k) => {
    const pull = link.pulls[k], line = spring.lines[k];
    line.visible = Boolean(pull) && run.shown;
    if (!pull) return;
    const place = run === main ? run.about.stations[pull.station].name : run.label;
    texts.push(`${place}: ${figures(Math.hypot(...pull.force), 4)} N (${three(pull.force)})`);
    setPoints(line, [stationPlace(pull.station, run), pull.target]);
    line.material.color.set(run === main ? inks.accent : runInk(run));
  });
  get("pulling").textContent = texts.join("; ");
}

// Point under the pointer on the plane through a position that is normal to the view.
function onPlane(x, y, place) {
  const box = canvas.getBoundingClientRect(), outward = camera.axes[2];
  ray.setFromCamera(new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), lens());
  const [from, way] = [ray.ray.origin.toArray(), ray.ray.direction.toArray()];
  return plus(from, way, dot(plus(place, from, -1), outward) / (dot(way, outward) || -1));
}

// Starts to pull if the pointer is on the machine.
function startPull(x, y) {
  if (!live || !ray || link.ended) return null;
  const box = canvas.getBoundingClientRect();
  ray.setFromCamera(new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), lens());
  const hits = ray.intersectObjects(pickables.filter(mesh => mesh.visible), false);
  const hit = hits.find(one => one.object.userData.station !== undefined && one.distance - hits[0].distance < 0.03 * WIDTH) || hits[0];
  if (!hit || hit.object.userData.body === undefined) return null;
  const { body, station } = hit.object.userData, run = hit.object.userData.run || main, { stations, bodies } = run.about, at = hit.point.toArray();
  const away = i => Math.hypot(...plus(stationPlace(i, run), at, -1));
  const own = station === undefined ? stations.map((_, i) => i).filter(i => stations[i].body === body) : [station];
  if (!own.length) {
    const others = [...new Set(stations.map(one => bodies[one.body].name))];
    say(`${bodies[body].name} has no load station to pull on${others.length ? `; bodies with load stations: ${others.join(", ")}` : ""}`);
    return null;
  }
  const nearest = own.reduce((best, i) => (away(i) < away(best) ? i : best)), begin = stationPlace(nearest, run), from = onPlane(x, y, begin);
  // if the controls act on all machines, stations with the same name on the others are pulled in the same way
  const held = runs.map((other, k) => ({ run: other, machine: k, station: other === run ? nearest : actsOn() !== null ? -1 : other.about.stations.findIndex(({ name }) => name === stations[nearest].name) }))
    .filter(one => one.station >= 0).map(one => ({ ...one, begin: stationPlace(one.station, one.run) }));
  // the spring is unstretched at the start, so that a click has no effect
  return spring.held = { run, station: nearest, held, moved: (px, py) => plus(onPlane(px, py, begin), from, -1) };
}
function pullTo(x, y) {
  if (!spring.held) return;
  const moved = spring.held.moved(x, y), stiffness_n_m = Number(get("stiffness").value);
  if (!(stiffness_n_m > 0)) return;
  for (const { machine, station, begin } of spring.held.held) {
    sendSoon(`pull ${machine}`, { do: "pull", machine, station, target_m: plus(begin, moved), stiffness_n_m });
  }
}
function releasePull() {
  if (!spring || !spring.held) return;
  spring.held = null;
  runs.forEach((_, machine) => link.waiting.delete(`pull ${machine}`));
  send({ do: "release" });
}
