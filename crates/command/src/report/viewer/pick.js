
// ---- selection with the pointer -------------------------------------------------------------------------------------

let picked = null;
const pickables = [];
const ray = hasWebGL ? new THREE.Raycaster() : null;
const pickMark = new THREE.Mesh(new THREE.TorusGeometry(1, 0.22, 8, 28), new THREE.MeshBasicMaterial({ depthTest: false, transparent: true }));

// The nearest item at a position in the window, as { title, rows(), place() }.
function under(x, y) {
  if (!ray) return null;
  const box = canvas.getBoundingClientRect();
  ray.setFromCamera(new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), lens());
  const hits = ray.intersectObjects(pickables.filter(mesh => mesh.visible), false);
  // gauges and joints lie partly inside a body: they are selected up to their own size behind its surface
  const first = hits[0], mark = hits.find(hit => marks.children.includes(hit.object));
  const hit = mark && mark.distance - first.distance < 0.02 * WIDTH ? mark : first;
  return hit ? hit.object.userData.describe(hit) : null;
}

function fillRows(table, found) {
  table.replaceChildren(...found.rows().map(([name, text]) => {
    const row = document.createElement("tr"), head = document.createElement("th"), cell = document.createElement("td");
    head.scope = "row";
    head.textContent = name;
    cell.textContent = text;
    row.append(head, cell);
    return row;
  }));
}

const tip = get("tip");
let hovered = null;
function hover(x, y) {
  hovered = x === null ? null : { x, y };
  showHover();
}
function showHover() {
  const found = hovered && !state.playing ? under(hovered.x, hovered.y) : null;
  tip.hidden = !found;
  if (!found) return;
  tip.querySelector("b").textContent = found.title;
  fillRows(tip.querySelector("tbody"), found);
  const box = get("stage").getBoundingClientRect(), [width, height] = [tip.offsetWidth, tip.offsetHeight];
  const left = hovered.x - box.left + 16 + width < box.width ? hovered.x - box.left + 16 : hovered.x - box.left - 16 - width;
  tip.style.left = `${Math.max(4, left)}px`;
  tip.style.top = `${Math.max(4, Math.min(box.height - height - 4, hovered.y - box.top - height / 2))}px`;
}

// A click selects an item, whose values are then shown in the panel; a click on the background ends the selection.
function pick(x, y) {
  choose(under(x, y));
}
function choose(thing) {
  picked = thing;
  if (!picked && get("follow").value === "picked") get("follow").value = "nothing";
  get("follow").querySelector("[value=picked]").disabled = !picked;
  followed = followPoint();
  for (const { plot } of along.charts) plot.redraw();
  changed();
}

// The point of the axis of a body at a distance from its inner end.
function sectionPicked(body, place) {
  const { places } = about.bodies[body];
  if (places.length === 1) return bodyPlace(main, body, 0, 0, [0, 0]);
  let i = 0;
  while (i + 2 < places.length && places[i + 1] < place) i++;
  return bodyPlace(main, body, i, Math.max(0, Math.min(1, (place - places[i]) / (places[i + 1] - places[i]))), [0, 0]);
}
function showPicked() {
  get("picked").hidden = !picked;
  pickMark.visible = picked !== null;
  if (!picked) return;
  get("picked-name").textContent = picked.title;
  fillRows(get("picked-rows"), picked);
}
function placePickMark() {
  if (!picked) return;
  pickMark.position.set(...picked.place());
  pickMark.quaternion.copy(lens().quaternion);
  pickMark.scale.setScalar(8 / pixelsPerMetre());
  pickMark.material.color.set(inks.accent);
}
