
// ---- a page that shows one run after another and keeps the settings of the reader ----------------------------------------------

const KEPT_LISTS = ["field", "surface-field", "speed", "follow"];
const keptBoxes = () => [...document.querySelectorAll("#display input[type=checkbox], #repeat")];

function keptNow() {
  const { azimuth, elevation, flat, target, distance } = camera;
  return {
    camera: { azimuth, elevation, flat, target, distance }, size: again.done || !again.kept ? extents.size : again.kept.size,
    boxes: Object.fromEntries(keptBoxes().map(box => [box.id, box.checked])),
    lists: Object.fromEntries(KEPT_LISTS.map(id => [id, get(id).value])),
    charts: again.done ? charts.map(chart => chart.names) : again.kept?.charts, dark: chosenDark,
    open: get("display").open, scrolled: document.querySelector("main > aside").scrollTop,
    // if the same run continues, it is shown at the time of the previous picture
    time: wantedTime(), playing: state.playing, slowed: state.slowed,
  };
}
const wantedTime = () => (state.wanted === undefined || (again.done && !state.partial) ? main.timeAt(main.position) : state.wanted);

// Shows the beginning of another run in the scene of this complete one, with its scales, if they differ in their values over time only: `false` where
// the model has another structure, which needs a scene of its own and three times as long.
const OF_THE_RUN = ["begins", "rows", "events", "recorded", "points", "signalRows"];
const structureOf = one => JSON.stringify({ ...one, ...Object.fromEntries(OF_THE_RUN.map(name => [name, null])) });
let structure = null;
function continueWith(next, numbers) {
  structure ??= structureOf(about);
  if (!renderer || !again.done || structureOf(next) !== structure) return false;
  Object.assign(state, { wanted: wantedTime(), partial: true });
  for (const name of OF_THE_RUN) about[name] = next[name];
  main.numbers = numbers;
  main.columns.clear();
  if (wakeMesh) makeWakeRoom(ringsOf(about));
  get("time").max = main.last;
  main.goTo(main.positionAt(Math.min(state.wanted, main.timeOf(main.last))));
  listEvents();
  show();
  return true;
}

function keep(kept) {
  for (const box of keptBoxes()) if (box.id in kept.boxes) box.checked = kept.boxes[box.id];
  for (const id of KEPT_LISTS) if ([...get(id).options].some(option => option.value === kept.lists[id])) get(id).value = kept.lists[id];
  field = FIELDS[get("field").value];
  surfaceField = SURFACE_FIELDS[get("surface-field").value];
  get("display").open = kept.open;
  if (again.done) document.querySelector("main > aside").scrollTop = kept.scrolled;
  const { azimuth, elevation, flat, target, distance } = kept.camera;
  Object.assign(camera, { azimuth, elevation, flat });
  get("flat").setAttribute("aria-pressed", String(flat));
  // the camera is kept for a machine of about the same size; the size is unknown until the run is complete
  if (again.done && Math.abs(Math.log(extents.size / kept.size)) > 0.2) frameAll(extents.points); else Object.assign(camera, { target, distance });
  followed = followPoint();
  Object.assign(state, { wanted: kept.time, slowed: kept.slowed });
  main.goTo(main.positionAt(Math.min(kept.time, main.timeOf(main.last))));
  setScales();
  show();
  // shaders of items that are not visible at first, as a shadow outside of the ground, would be freed with the previous run, and so would those
  // without shadows, with which slow computers play
  for (const cast of state.slowed ? [false, true] : [true]) {
    sun.castShadow = cast && get("shadow").checked && get("ground").checked;
    renderer?.compile(scene, lens());
  }
  if (kept.playing || again.play) play(true);
}
if (again.kept) keep(again.kept); else if (again.play) play(true);

// Ends this run in the page, and its plots when the next run has plots; `dispose` frees its graphics memory after the next run has been
// drawn.
function endRun() { state.playing = false; }
function endPlots() { for (const chart of charts) chart.plot?.destroy(); }
function dispose() {
  scene.traverse(object => {
    object.geometry?.dispose();
    for (const material of [object.material].flat()) material?.dispose();
    if (object.isInstancedMesh) object.dispose();
  });
  for (const { made } of symbols) for (const geometry of made.values()) geometry.dispose();
  sun.dispose();
}
return { renderer, textPictures, main, about, charts, keptNow, continueWith, endRun, endPlots, dispose };
