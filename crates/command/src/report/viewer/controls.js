
// ---- sliders and switches of a live simulation ------------------------------------------------------------------------

const controls = []; // { control, machines: [index of its value per machine], set(value) }: those of all machines, once for each name
// Index of the machine on which the controls act, or `null` for all.
const actsOn = () => (get("acts-on").value === "" ? null : Number(get("acts-on").value));

// Controls of all machines; controls with the same name, kind and unit are one.
function controlsOfAll() {
  const found = new Map();
  [live.controls, ...live.others].forEach((list, machine) => list.forEach((control, index) => {
    const key = `${control.name} ${control.kind} ${control.unit}`;
    if (!found.has(key)) found.set(key, { control, machines: runs.map(() => null), values: [], starts: [] });
    found.get(key).machines[machine] = index;
  }));
  return [...found.values()];
}
function buildActsOn() {
  const list = get("acts-on");
  list.add(new Option(live.machines.length > 2 ? "all models" : "both models", ""));
  live.machines.forEach((name, machine) => list.add(new Option(name, String(machine))));
  get("acts-on-label").hidden = live.machines.length < 2;
  list.addEventListener("change", showControls);
}
// The machine whose value a control shows: the one on which the controls act, otherwise the first that has it.
const shownMachine = ({ machines }) => (actsOn() === null ? machines.findIndex(index => index !== null) : actsOn());
// Sets a value of one machine, or of all that have it.
function sendValue(one, value, now) {
  const machine = actsOn(), { name } = one.control, order = { do: "set", name, value, ...(machine === null ? {} : { machine }) };
  if (now) send(order); else sendSoon(name, order);
}

// Groups that are closed at the start: they have many rows and are rarely used.
const FOLDED = /^(load|gravity|root|body|solver)\b/;
const groupOf = name => (/^(load|body|failure|section)\./.test(name) ? name.split(".").slice(0, 2).join(".") : name.split(".")[0]);

function buildLive() {
  get("live").hidden = false;
  const groups = new Map();
  buildActsOn();
  for (const one of controlsOfAll()) {
    const name = groupOf(one.control.name);
    controls.push(one);
    if (one.control.kind === "switch") { switchOf(one); continue; }
    if (!groups.has(name)) groups.set(name, groupBox(name));
    sliderOf(one, name, groups.get(name));
  }
  get("switches").hidden = !get("switches").children.length;
  const filter = get("filter");
  filter.addEventListener("input", () => {
    const wanted = filter.value.trim().toLowerCase();
    for (const box of get("sliders").children) {
      let any = false;
      for (const row of box.querySelectorAll(".control")) { row.hidden = wanted && !row.dataset.name.includes(wanted); any = any || !row.hidden; }
      box.hidden = !any;
      box.open = any && (wanted ? true : !FOLDED.test(box.dataset.group));
    }
  });
  // the weight of the machine at a deflection of a tenth of the longest body
  const raw = live.weight_n / (0.1 * (live.reach_m || extents.wing)), power = 10 ** Math.floor(Math.log10(raw));
  get("stiffness").value = String(+(power * Math.round(raw / power)).toPrecision(1));
  for (const id of ["save-film", "save-table", "repeat", "open"]) (get(id).closest("label") || get(id)).hidden = id !== "save-table";
  get("reset").title = "Back to the start (R)";
  get("back").title = "Back by one frame (left arrow)";
  get("back").setAttribute("aria-label", "Back by one frame");
  get("forth").title = `One step of ${live.step_s} s (right arrow)`;
  get("forth").setAttribute("aria-label", "One step forward");
  get("keys").textContent = "Space runs · → step · ← back · drag the model to pull · drag elsewhere to turn · drag the bar to go back in time · 1–4 views · O ortho · A frame all · + − zoom · R start · F follow · P PNG · T light or dark";
}

function groupBox(name) {
  const box = document.createElement("details"), head = document.createElement("summary");
  head.textContent = name;
  box.dataset.group = name;
  box.open = !FOLDED.test(name);
  box.append(head);
  get("sliders").append(box);
  return box;
}

// A toggle button for a Boolean value.
function switchOf(one) {
  const { control } = one, button = document.createElement("button");
  Object.assign(button, { type: "button", textContent: control.name, title: control.description });
  button.dataset.name = control.name;
  button.classList.toggle("failure", control.name.startsWith("failure."));
  one.set = value => button.setAttribute("aria-pressed", String(value > 0.5));
  one.row = button;
  button.addEventListener("click", () => sendValue(one, button.getAttribute("aria-pressed") !== "true", true));
  get("switches").append(button);
}

function sliderOf(one, group, box) {
  const { control } = one, row = document.createElement("label"), name = document.createElement("span"), range = document.createElement("input"), field = document.createElement("input"), unit = document.createElement("span");
  row.className = "control";
  row.dataset.name = control.name.toLowerCase();
  row.title = `${control.name}: ${control.description}${allowedText(control)}`;
  // allow line breaks at the joints of names
  name.textContent = (control.name.slice(group.length + 1) || control.name).replaceAll("_", "_\u200b");
  const [low, high] = control.slider;
  Object.assign(range, { type: "range", min: low, max: high, step: "any" });
  Object.assign(field, { type: "number", step: "any" });
  range.setAttribute("aria-label", control.name);
  field.setAttribute("aria-label", `${control.name}, value`);
  unit.textContent = control.unit;
  unit.className = "unit";
  const whole = control.kind === "integer" ? Math.round : value => value;
  const sendShown = value => sendValue(one, whole(value) / control.factor);
  range.addEventListener("input", () => { field.value = shortNumber(whole(Number(range.value))); sendShown(Number(range.value)); });
  // restored when it is clicked again
  range.addEventListener("dblclick", () => sendShown(control.factor * one.starts[shownMachine(one)]));
  field.addEventListener("change", () => { if (field.value.trim() !== "") sendShown(Number(field.value)); });
  one.row = row;
  one.set = value => {
    const shown = control.factor * value;
    if (document.activeElement !== range || !range.matches(":active")) range.value = shown;
    if (document.activeElement !== field) field.value = Math.abs(value) >= 1e30 ? "" : shortNumber(shown);
    field.placeholder = Math.abs(value) >= 1e30 ? "none" : "";
  };
  row.append(name, range, field, unit);
  box.append(row);
}
// short enough for the field, and valid as its input
const shortNumber = value => (Math.abs(value) >= 1e6 ? String(+value.toPrecision(5)).length > 7 ? value.toExponential().replace(/(\.\d{0,4})\d*/, "$1").replace("e+", "e") : String(+value.toPrecision(5)) : String(Number(value.toPrecision(5))));
function allowedText({ allowed: [least, most], unit, slider }) {
  const of = value => `${shortNumber(value)} ${unit}`.trim();
  const bounds = least !== null && most !== null ? `allowed from ${of(least)} to ${of(most)}` : least !== null ? `at least ${of(least)}` : most !== null ? `at most ${of(most)}` : "";
  return ` (slider from ${of(slider[0])} to ${of(slider[1])}${bounds ? `, ${bounds}` : ""})`;
}
// Values of every machine, in the order of its controls.
function setControls(lists) {
  for (const one of controls) {
    one.values = one.machines.map((index, machine) => (index === null ? null : lists[machine][index]));
    one.starts = one.values.map((value, machine) => one.starts[machine] ?? value);
  }
  showControls();
}
// Controls that the chosen machine lacks are hidden; a note lists values that differ between the machines.
function showControls() {
  for (const one of controls) {
    const value = one.values[shownMachine(one)] ?? null, { control, row } = one;
    row.classList.toggle("absent", value === null);
    if (value !== null) one.set(value);
    const having = one.values.map((other, machine) => [machine, other]).filter(([, other]) => other !== null);
    const differs = having.some(([, other]) => other !== having[0][1]), missing = having.length < runs.length;
    row.classList.toggle("differs", differs);
    const text = other => (control.kind === "switch" ? (other > 0.5 ? "on" : "off") : `${shortNumber(control.factor * other)} ${control.unit}`.trim());
    const mark = differs ? having.map(([machine, other]) => `${live.machines[machine]}: ${text(other)}`).join(", ")
      : missing ? `only ${having.map(([machine]) => live.machines[machine]).join(", ")}` : "";
    if (mark === (one.mark ?? "")) continue;
    one.mark = mark;
    one.note ??= row.appendChild(Object.assign(document.createElement("small"), { className: "machines" }));
    one.note.textContent = mark;
  }
}
