
// ---- a live simulation: socket, commands, frames, time bar -----------------------------------------------------------------

const link = live && {
  socket: null, running: false, looking: false, dragging: false, watched: new Set(), pull: null, ended: false, plotted: 0, scaled: 0, waiting: new Map(), factor: null,
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
  if (message.values) setControls(message.values);
  if (message.kind === "refused") say(message.message);
  if (message.kind === "connected") about.events = message.events;
  if (message.kind === "rolled_back") {
    main.forgetAfter(message.time);
    link.looking = false;
    main.goTo(main.last);
    say("");
  }
  if (message.kind === "connected" || message.kind === "rolled_back") listEvents();
}

// A message has a header in JSON, samples of the plots and a frame, in the format of `Session::next_frame`.
function takeFrame(data) {
  const length = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const numbers = new Float32Array(data, 4 + length), samples = header.samples * (header.names.length + 1);
  if (samples) main.addSamples(header.names, numbers.subarray(0, samples));
  const time = header.time;
  if (time > main.timeOf(main.last) + 1e-7) main.append(header.rows, numbers.subarray(samples));
  else if (main.timeOf(main.last) <= time + 1e-7) replaceLast(header.rows, numbers.subarray(samples));
  main.forgetBefore(header.oldest);
  // the page contains the first frame of the simulation; a page that connects later discards it
  if (link.fresh && time > main.timeOf(0) + 1e-6) main.forget(main.last);
  link.fresh = false;
  if (header.events.length) { about.events.push(...header.events); listEvents(); }
  if (header.failure) say(`the simulation failed: ${header.failure}`);
  Object.assign(link, { running: header.running, pull: header.pull, factor: header.factor, lost: header.lost, speed: header.speed });
  get("time").max = main.last;
  if (!link.looking && !link.dragging) main.goTo(main.last);
  growScales();
  showPace();
  showRunning();
  changed();
}
// A frame of the same time, for example after a value was changed during a pause.
function replaceLast(rows, frame) {
  main.end = about.begins.pop();
  about.rows.pop();
  main.append(rows, frame);
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

const spring = live && { line: lines(new THREE.LineBasicMaterial({ depthTest: false })), held: null, dots: [] };
const stationPlace = i => vector(main.present, main.layout.stations + PER_STATION * i);

function buildPull() {
  spring.line.renderOrder = 8;
  spring.line.frustumCulled = false;
  scene.add(spring.line);
  about.stations.forEach((station, i) => {
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.006 * WIDTH, 12, 8), new THREE.MeshLambertMaterial({ color: "#c2410c" }));
    dot.userData = { station: i, body: station.body, describe: () => ({
      title: station.name,
      rows: () => [["at", `${three(stationPlace(i))} m`], ["force", `${three(vector(main.present, main.layout.stations + PER_STATION * i + 3))} N`]],
      place: () => stationPlace(i),
    }) };
    spring.dots.push(dot);
    marks.add(dot);
    pickables.push(dot);
  });
}
function updatePull() {
  spring.dots.forEach((dot, i) => dot.position.set(...stationPlace(i)));
  const { pull } = link;
  spring.line.visible = Boolean(pull);
  get("pulling").textContent = pull ? `${about.stations[pull.station].name}: ${figures(Math.hypot(...pull.force), 4)} N (${three(pull.force)})` : "";
  if (!pull) return;
  setPoints(spring.line, [stationPlace(pull.station), pull.target]);
  spring.line.material.color.set(inks.accent);
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
  const { body, station } = hit.object.userData, at = hit.point.toArray();
  const away = i => Math.hypot(...plus(stationPlace(i), at, -1));
  const own = station === undefined ? about.stations.map((_, i) => i).filter(i => about.stations[i].body === body) : [station];
  if (!own.length) {
    const others = [...new Set(about.stations.map(one => about.bodies[one.body].name))];
    say(`${about.bodies[body].name} has no load station to pull on${others.length ? `; bodies with load stations: ${others.join(", ")}` : ""}`);
    return null;
  }
  const nearest = own.reduce((best, i) => (away(i) < away(best) ? i : best));
  const begin = stationPlace(nearest), from = onPlane(x, y, begin);
  // the spring is unstretched at the start, so that a click has no effect
  return spring.held = { station: nearest, place: (px, py) => plus(plus(begin, onPlane(px, py, begin)), from, -1) };
}
function pullTo(x, y) {
  if (!spring.held) return;
  const target_m = spring.held.place(x, y), stiffness_n_m = Number(get("stiffness").value);
  if (stiffness_n_m > 0) sendSoon("pull", { do: "pull", station: spring.held.station, target_m, stiffness_n_m });
}
function releasePull() {
  if (!spring || !spring.held) return;
  spring.held = null;
  link.waiting.delete("pull");
  send({ do: "release" });
}
