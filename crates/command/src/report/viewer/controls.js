
// ---- sliders and switches of a live simulation ------------------------------------------------------------------------

const controls = []; // { control, set(value) } in the order of `live.controls`

// Groups that are closed at the start: they have many rows and are rarely used.
const FOLDED = /^(load|gravity|root|body|solver)\b/;
const groupOf = name => (/^(load|body|failure|section)\./.test(name) ? name.split(".").slice(0, 2).join(".") : name.split(".")[0]);

function buildLive() {
  get("live").hidden = false;
  const groups = new Map();
  for (const control of live.controls) {
    const name = groupOf(control.name);
    if (control.kind === "switch") { controls.push(switchOf(control)); continue; }
    if (!groups.has(name)) groups.set(name, groupBox(name));
    controls.push(sliderOf(control, name, groups.get(name)));
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
  get("keys").textContent = "Space runs · → step · ← back · drag the machine to pull · drag elsewhere to turn · drag the bar to go back in time · 1–4 views · O ortho · A frame all · + − zoom · R start · F follow · P PNG · T light or dark";
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
function switchOf(control) {
  const button = document.createElement("button");
  Object.assign(button, { type: "button", textContent: control.name, title: control.description });
  button.dataset.name = control.name;
  button.classList.toggle("failure", control.name.startsWith("failure."));
  const set = value => button.setAttribute("aria-pressed", String(value > 0.5));
  button.addEventListener("click", () => send({ do: "set", name: control.name, value: button.getAttribute("aria-pressed") !== "true" }));
  get("switches").append(button);
  return { control, set };
}

function sliderOf(control, group, box) {
  const row = document.createElement("label"), name = document.createElement("span"), range = document.createElement("input"), field = document.createElement("input"), unit = document.createElement("span");
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
  const send = value => sendSoon(control.name, { do: "set", name: control.name, value: whole(value) / control.factor });
  range.addEventListener("input", () => { field.value = shortNumber(whole(Number(range.value))); send(Number(range.value)); });
  // restored when it is clicked again
  range.addEventListener("dblclick", () => send(control.start));
  field.addEventListener("change", () => { if (field.value.trim() !== "") send(Number(field.value)); });
  const set = value => {
    const shown = control.factor * value;
    if (control.start === undefined) control.start = shown;
    if (document.activeElement !== range || !range.matches(":active")) range.value = shown;
    if (document.activeElement !== field) field.value = Math.abs(value) >= 1e30 ? "" : shortNumber(shown);
    field.placeholder = Math.abs(value) >= 1e30 ? "none" : "";
  };
  row.append(name, range, field, unit);
  box.append(row);
  return { control, set };
}
// short enough for the field, and valid as its input
const shortNumber = value => (Math.abs(value) >= 1e6 ? String(+value.toPrecision(5)).length > 7 ? value.toExponential().replace(/(\.\d{0,4})\d*/, "$1").replace("e+", "e") : String(+value.toPrecision(5)) : String(Number(value.toPrecision(5))));
function allowedText({ allowed: [least, most], unit, slider }) {
  const of = value => `${shortNumber(value)} ${unit}`.trim();
  const bounds = least !== null && most !== null ? `allowed from ${of(least)} to ${of(most)}` : least !== null ? `at least ${of(least)}` : most !== null ? `at most ${of(most)}` : "";
  return ` (slider from ${of(slider[0])} to ${of(slider[1])}${bounds ? `, ${bounds}` : ""})`;
}
function setControls(values) {
  controls.forEach((one, i) => one.set(values[i]));
}
