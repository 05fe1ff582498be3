
// ---- the state of the page in the fragment of its address, so that a link restores it ---------------------------------------

// Pages of live simulations and pages with an editor use their addresses otherwise; modes start at the beginning of their cycle.
const addressed = !live && !again && !modal;
const VIEW_DIGITS = 5;
const short = (value, digits) => String(Number(value.toPrecision(digits)));

// Names and values, in their order.
function addressNow() {
  const { azimuth, elevation, distance, target, flat } = camera, found = [["t", short(main.timeAt(main.position), 7)]];
  found.push(["field", get("field").value]);
  if (about.surfaces.length) found.push(["surfaces", get("surface-field").value]);
  if (picked?.key) found.push(["at", picked.key]);
  if (get("follow").value !== "picked" || picked?.key) found.push(["follow", get("follow").value]);
  if (camera.preset) found.push(["view", camera.preset]);
  else found.push(["camera", [azimuth, elevation, distance, ...(followed ? plus(target, followed, -1) : target)].map(value => short(value, VIEW_DIGITS)).join(",")]);
  if (flat) found.push(["ortho", "1"]);
  if (get("along").open) found.push(["along", about.bodies[Number(get("along-end").value)].name]);
  return found;
}

// Written when nothing has changed for a moment: browsers limit the rate of changes of an address.
let addressTimer = null;
function noteAddress() {
  if (!addressed || state.playing || !addressNow.ready) return;
  clearTimeout(addressTimer);
  addressTimer = setTimeout(writeAddress, 250);
}
function writeAddress() {
  clearTimeout(addressTimer);
  if (state.playing) return;
  const text = addressNow().map(([name, value]) => `${name}=${encodeURIComponent(value)}`).join("&");
  if (location.hash.slice(1) !== text) history.replaceState(null, "", `#${text}`);
}

// Restores the state given by an address; parts that do not apply to this page are ignored and listed.
function readAddress() {
  const bad = [];
  const known = {
    t: text => { const time = Number(text); if (text === "" || !Number.isFinite(time)) return false; main.goTo(main.positionAt(time)); return true; },
    field: text => listed("field", text, () => { field = FIELDS[text]; ranges.body = null; }),
    surfaces: text => listed("surface-field", text, () => { surfaceField = SURFACE_FIELDS[text]; ranges.surface = null; }),
    at: text => { const found = thingAt(text); if (!found) return false; picked = found; get("follow").querySelector("[value=picked]").disabled = false; return true; },
    follow: text => listed("follow", text, () => { followed = followPoint(); }),
    ortho: text => { if (!["0", "1"].includes(text)) return false; if (camera.flat !== (text === "1")) toggleFlat(); return true; },
    view: text => { if (!Object.hasOwn(VIEWS, text)) return false; look(text); return true; },
    camera: text => {
      const values = text.split(",").map(Number);
      if (values.length !== 6 || !values.every(Number.isFinite) || !(values[2] > 0)) return false;
      [camera.azimuth, camera.elevation, camera.distance] = values;
      followed = followPoint();
      // relative to the point that is followed
      camera.target = plus(values.slice(3), followed || [0, 0, 0]);
      camera.preset = null;
      return true;
    },
    along: text => {
      const option = [...get("along-end").options].find(one => one.textContent === text);
      if (!option) return false;
      get("along-end").value = option.value;
      get("along").open = true;
      return true;
    },
  };
  const listed = (id, text, then) => {
    if (![...get(id).options].some(option => option.value === text && !option.disabled)) return false;
    get(id).value = text;
    then();
    return true;
  };
  const asked = new Map(location.hash.slice(1).split("&").filter(Boolean).map(part => {
    const [name, ...rest] = part.split("=");
    try { return [name, decodeURIComponent(rest.join("="))]; } catch { return [name, ""]; }
  }));
  // in the order of their dependence, independent of that in the address
  for (const [name, set] of Object.entries(known)) if (asked.has(name) && !set(asked.get(name))) bad.push(`${name}=${asked.get(name)}`);
  for (const name of asked.keys()) if (!Object.hasOwn(known, name)) bad.push(name);
  setScales();
  say(bad.length ? `parts of the address that do not apply to this page: ${bad.join(", ")}` : "");
}

// The selected item: a section (body and distance from its inner end in m), a gauge, a joint or a mass.
function thingAt(text) {
  const [kind, ...rest] = text.split(":"), name = rest.join(":");
  const marked = (list, meshes) => { const i = list.findIndex(one => one.name === name); return i < 0 ? null : meshes[i].userData.describe(); };
  if (kind === "gauge") return marked(about.gauges, gaugeMarks);
  if (kind === "joint") return marked(about.hinges, hingeMarks.map(({ mesh }) => mesh));
  if (kind === "mass") return marked(about.masses, massMarks);
  if (kind !== "body") return null;
  const cut = name.lastIndexOf(","), body = about.bodies.findIndex(one => one.name === name.slice(0, cut)), place = Number(name.slice(cut + 1));
  if (body < 0 || cut < 0 || name.slice(cut + 1) === "" || !Number.isFinite(place)) return null;
  const { places } = about.bodies[body];
  return place >= 0 && place <= places[places.length - 1] * (1 + 1e-6) ? sectionPicked(body, place) : null;
}

function startAddress() {
  if (!addressed) return;
  if (location.hash.length > 1) readAddress();
  addressNow.ready = true;
  addEventListener("hashchange", () => { play(false); readAddress(); changed(); }, listening);
}
