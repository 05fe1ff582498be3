
// ---- camera: orbits a target; z of the root frame points up ------------------------------------------------------

// Azimuth of the eye from x towards y, elevation.
const VIEWS = {
  iso: [-1.05, 0.42], front: [-Math.PI / 2, 0], side: [0, 0], top: [-Math.PI / 2, Math.PI / 2],
};
const HALF_VIEW = Math.tan(15 * Math.PI / 180); // of the shorter side, perspective
const camera = { azimuth: 0, elevation: 0, target: [0, 0, 0], distance: 1, axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], flat: false, preset: null };
const lenses = { deep: new THREE.PerspectiveCamera(30, 1, 0.01, 100), flat: new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 100) };
const lens = () => (camera.flat ? lenses.flat : lenses.deep);

function look(name) {
  [camera.azimuth, camera.elevation] = VIEWS[name];
  camera.preset = name;
  // if an item is followed, its present extent fills the view, not its path
  frameAll(get("follow").value === "machine" ? machinePoints() : extents.points);
}

function aim() {
  camera.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, camera.elevation));
  const [ca, sa, ce, se] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth), Math.cos(camera.elevation), Math.sin(camera.elevation)];
  const outward = [ca * ce, sa * ce, se], right = [-sa, ca, 0];
  camera.axes = [right, cross(outward, right), outward];
  const basis = new THREE.Matrix4().makeBasis(...camera.axes.map(axis => new THREE.Vector3(...axis)));
  const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight) || 1;
  const half = camera.distance * HALF_VIEW, wide = half * Math.max(aspect, 1), high = half * Math.max(1 / aspect, 1);
  const far = camera.distance + 4 * extents.size + wakeReach, eye = lens();
  const back = camera.flat ? camera.distance + 2 * extents.size + wakeReach : camera.distance;
  eye.position.set(...plus(camera.target, outward, back));
  eye.quaternion.setFromRotationMatrix(basis);
  if (camera.flat) Object.assign(eye, { left: -wide, right: wide, top: high, bottom: -high, near: 0, far: back + far });
  else Object.assign(eye, { fov: 2 * Math.atan(HALF_VIEW * Math.max(1 / aspect, 1)) * 180 / Math.PI, aspect, near: Math.max(1e-3 * camera.distance, 1e-6), far });
  eye.updateProjectionMatrix();
  eye.updateMatrixWorld();
}
let wakeReach = 0;

// Sets target and distance so that all points just fit into the view, in the present direction.
function frameAll(points) {
  aim();
  const [right, up, outward] = camera.axes;
  const seen = points.map(point => [dot(point, right), dot(point, up), dot(point, outward)]);
  const ends = [0, 1, 2].map(i => [Math.min(...seen.map(p => p[i])), Math.max(...seen.map(p => p[i]))]);
  const middle = ends.map(([a, b]) => (a + b) / 2);
  const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight) || 1;
  const half = [HALF_VIEW * Math.max(aspect, 1) * 0.86, HALF_VIEW * Math.max(1 / aspect, 1) * 0.8];
  let distance = 0.02 * extents.size;
  for (const p of seen) for (let i = 0; i < 2; i++) {
    distance = Math.max(distance, Math.abs(p[i] - middle[i]) / half[i] + (camera.flat ? 0 : p[2] - middle[2]));
  }
  camera.target = [0, 1, 2].map(i => right[i] * middle[0] + up[i] * middle[1] + outward[i] * middle[2]);
  camera.distance = distance;
  followed = followPoint();
  aim();
}

// Points of the machine at the current time; in a live simulation those of all machines that are drawn.
function machinePoints() {
  return (live ? runs.filter(run => run.shown || run === main) : [main]).flatMap(pointsOf);
}
function pointsOf(run) {
  const points = [];
  run.about.bodies.forEach((body, b) => body.rims.forEach((rim, i) => rim.forEach(p => points.push(pointOf(run.section(b, i), p)))));
  run.about.surfaces.forEach((surface, i) => {
    for (let c = 0; c < 2 * surface.columns; c++) points.push(vector(run.present, run.layout.surfaces[i] + 3 * c));
  });
  for (const mass of run.about.masses) points.push(massPlace(run, mass));
  return points;
}

// The same with the near wake if it is shown: with the far wake, which has a length of hundreds of spans in steady flow, the machine would be a speck.
function presentPoints() {
  const points = machinePoints();
  const ends = [0, 1, 2].map(i => [Math.min(...points.map(p => p[i])), Math.max(...points.map(p => p[i]))]);
  const near = p => p.every((c, i) => c > ends[i][0] - extents.wing && c < ends[i][1] + extents.wing);
  if (get("wake").checked) for (const wake of main.wakes(Math.floor(main.position))) {
    for (let i = 0; i < (wake.rows + 1) * wake.columns; i++) {
      const point = vector(main.numbers, wake.nodes + 3 * i);
      if (near(point)) points.push(point);
    }
  }
  return points;
}

// Mean position of all sections at the present time.
function middle() {
  let sum = [0, 0, 0], count = 0;
  about.bodies.forEach((body, b) => body.rims.forEach((_, i) => { sum = plus(sum, main.section(b, i).at); count++; }));
  return sum.map(c => c / count);
}
// A machine is in flight if its first bodies move by more than half of its size.
const fliesAway = () => about.bodies.some((body, b) =>
  !body.carrier && Math.hypot(...plus(main.section(b, 0, main.last).at, main.section(b, 0, 0).at, -1)) > 0.5 * extents.wing);

// The camera follows the machine, a tip or the selected item; the target can be moved relative to it.
let followed = null;
function followPoint() {
  const name = get("follow").value;
  if (name === "nothing") return null;
  if (name === "picked") return picked ? picked.place() : null;
  if (name === "machine") return middle();
  const body = about.bodies.findIndex(other => other.name === name);
  return body < 0 ? null : main.section(body, about.bodies[body].rims.length - 1).at;
}
function follow() {
  const now = followPoint();
  if (now && followed) camera.target = plus(camera.target, plus(now, followed, -1));
  followed = now;
}

// Pixels of the page per metre at the target.
const pixelsPerMetre = () => Math.min(canvas.clientWidth, canvas.clientHeight) / (2 * HALF_VIEW * camera.distance);

function turn(dx, dy) {
  camera.preset = null;
  camera.azimuth -= dx;
  camera.elevation += dy;
  aim();
}
// Moves the target by pixels of the page.
function move(dx, dy) {
  const step = 1 / pixelsPerMetre();
  camera.preset = null;
  camera.target = plus(plus(camera.target, camera.axes[0], -dx * step), camera.axes[1], dy * step);
  aim();
}
function zoom(factor) {
  camera.preset = null;
  camera.distance = Math.max(0.005 * extents.wing, Math.min(60 * extents.size, camera.distance * factor));
  aim();
}

// Mouse: a drag rotates the view, with Shift or another button it moves it; the wheel zooms. Touch: one finger rotates, two move and zoom. A
// click or tap without a drag selects.
function listenToPointers(changed, hover, pick) {
  const held = new Map();
  let moved = 0, pulls = false;
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    if (!held.size) moved = 0;
    if (held.size) releasePull();
    pulls = Boolean(live) && !held.size && event.button === 0 && !event.shiftKey && startPull(event.clientX, event.clientY) !== null;
    held.set(event.pointerId, [event.clientX, event.clientY]);
  }, listening);
  canvas.addEventListener("pointerup", event => {
    if (pulls) { pulls = false; releasePull(); }
    if (held.delete(event.pointerId) && moved < 4 && event.button === 0) pick(event.clientX, event.clientY);
  }, listening);
  canvas.addEventListener("pointercancel", event => { held.delete(event.pointerId); if (live) releasePull(); }, listening);
  canvas.addEventListener("pointerleave", () => hover(null), listening);
  canvas.addEventListener("pointermove", event => {
    const before = held.get(event.pointerId);
    if (!before) { if (event.pointerType === "mouse" && !event.buttons) hover(event.clientX, event.clientY); return; }
    const now = [event.clientX, event.clientY], [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    if (held.size > 1) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const gap = place => Math.hypot(place[0] - other[0], place[1] - other[1]) || 1;
      zoom(gap(before) / gap(now));
      move(dx / 2, dy / 2);
    } else if (pulls) { if (moved >= 4) pullTo(...now); }
    else if (event.shiftKey || event.buttons & 6) move(dx, dy);
    else turn(dx / 180, dy / 180);
    held.set(event.pointerId, now);
    changed();
  }, listening);
  canvas.addEventListener("contextmenu", event => event.preventDefault(), listening);
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(0.0012 * event.deltaY));
    changed();
  }, { passive: false, ...listening });
}
