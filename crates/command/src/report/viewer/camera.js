
// ---- camera: turns about a target; the root frame's z points up ------------------------------------------------------

const VIEWS = { oblique: [-1.05, 0.42], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };
const camera = { azimuth: 0, elevation: 0, target: [0, 0, 0], distance: 1, eye: [0, 0, 0], axes: [] };

// The camera stands in the direction (azimuth from x towards y, elevation) from its target.
function look(name) {
  [camera.azimuth, camera.elevation] = VIEWS[name];
  camera.target = [...extents.middle];
  camera.distance = 1.6 * (follows() ? extents.wing : extents.size);
  aim();
}

function aim() {
  camera.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, camera.elevation));
  const [ca, sa, ce, se] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth), Math.cos(camera.elevation), Math.sin(camera.elevation)];
  const outward = [ca * ce, sa * ce, se];
  const right = [-sa, ca, 0];
  camera.axes = [right, cross(outward, right), outward];
  camera.eye = plus(camera.target, outward, camera.distance);
}

// A wing that flies far is followed; moving the target by hand goes on from there.
const follows = () => document.getElementById("follow").checked;
let followed = [0, 0, 0];
function follow(restart) {
  const now = centroid();
  if (restart) camera.target = now;
  else camera.target = plus(camera.target, plus(now, followed, -1));
  followed = now;
  aim();
}

// Place on the canvas in pixels, and the distance from the eye; null behind it.
function project(point) {
  const away = plus(point, camera.eye, -1);
  const depth = -dot(away, camera.axes[2]);
  if (depth < 0.02 * camera.distance) return null;
  const scale = 1.75 * Math.min(canvas.width, canvas.height) / depth;
  return [canvas.width / 2 + scale * dot(away, camera.axes[0]), canvas.height / 2 - scale * dot(away, camera.axes[1]), depth];
}

function turn(dx, dy) {
  camera.azimuth -= dx;
  camera.elevation += dy;
  aim();
}

// Moves the target by pixels of the page.
function move(dx, dy) {
  const step = camera.distance / (1.75 * Math.min(canvas.clientWidth, canvas.clientHeight));
  camera.target = plus(plus(camera.target, camera.axes[0], -dx * step), camera.axes[1], dy * step);
  aim();
}

function zoom(factor) {
  camera.distance = Math.max(0.02 * extents.size, Math.min(60 * extents.size, camera.distance * factor));
  aim();
}

// Mouse: drag turns, with Shift or another button it moves; wheel zooms. Touch: one finger turns, two move and zoom.
function listenToPointers(changed) {
  const held = new Map();
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  const release = event => held.delete(event.pointerId);
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointermove", event => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (held.size > 1) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const gap = place => Math.hypot(place[0] - other[0], place[1] - other[1]) || 1;
      zoom(gap(before) / gap(now));
      move(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) move(dx, dy);
    else turn(dx / 180, dy / 180);
    held.set(event.pointerId, now);
    changed();
  });
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(0.0012 * event.deltaY));
    changed();
  }, { passive: false });
}
