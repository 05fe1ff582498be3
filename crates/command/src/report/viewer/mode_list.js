
// ---- the list of modes, the state and the amplitude -------------------------------------------------------------------

const CYCLES = [0.05, 0.1, 0.2, 0.5, 1, 2];
const modePlots = [];

const frequencyOf = mode => (oscillates(mode) ? Math.hypot(...mode.eigenvalue) / (2 * Math.PI) : null);
const dampingOf = mode => (oscillates(mode) ? -mode.eigenvalue[0] / Math.hypot(...mode.eigenvalue) : null);

// Texts of the row of a mode: number, frequency, damping ratio or rate, motion.
function modeTexts(mode) {
  const size = Math.hypot(...mode.eigenvalue), damping = dampingOf(mode);
  if (size === 0) return ["0", "–", mode.words];
  if (damping === null) return ["–", `${figures(mode.eigenvalue[0], 4)} 1/s`, `${mode.words}; does not oscillate`];
  return [figures(frequencyOf(mode), 5), Math.abs(damping) < 5e-7 ? "0" : compact(damping, 5), mode.words];
}

function listModes() {
  get("mode-list").tBodies[0].replaceChildren(...stateOfModes().modes.map((mode, i) => {
    const row = document.createElement("tr"), head = document.createElement("th"), box = document.createElement("input"), label = document.createElement("label");
    Object.assign(box, { type: "radio", name: "mode", value: String(i), disabled: !mode });
    box.addEventListener("change", () => setMode(i));
    label.append(box, ` ${mode ? mode.number : i + 1}`);
    head.scope = "row";
    head.append(label);
    row.append(head);
    if (!mode) row.className = "absent";
    const texts = mode ? modeTexts(mode) : ["–", "–", stateOfModes().words ? "" : "not found in this state"];
    for (const text of texts) row.insertCell().textContent = text;
    if (mode?.grows) {
      row.cells[2].classList.add("grows");
      row.cells[2].append(" grows");
    }
    if (mode) row.addEventListener("click", () => setMode(i));
    return row;
  }));
}

// Marks the selected mode in the list; the list is not rebuilt, so that the keyboard focus remains.
function markMode() {
  [...get("mode-list").tBodies[0].rows].forEach((row, i) => {
    row.classList.toggle("chosen", i === chosen.mode);
    row.querySelector("input").checked = i === chosen.mode;
  });
}

// Updates page and cycle to the selected state, mode and amplitude.
function refill(follow) {
  const share = main.last ? main.position / main.last : 0;
  fillCycle();
  main.goTo(Math.min(main.last, share * main.last));
  get("time").max = main.last;
  const mode = modeShown(), state = stateOfModes();
  if (follow) listSpeeds(mode, state);
  get("amplitude-value").textContent = `largest displacement ${figures(chosen.amplitude * mode.largest, 3)} m (${compact(100 * chosen.amplitude * mode.largest / modal.size, 1)} % of the size), rotation ${compact(chosen.amplitude * mode.turn * 180 / Math.PI, 1)}°`;
  if (modal.quantity) {
    const text = `${+state.value.toPrecision(6)} ${modal.quantity[1]}${state.words ? `: ${state.words}` : ""}`;
    get("state-value").textContent = text;
    get("state").value = chosen.state;
    get("state").setAttribute("aria-valuetext", text);
  }
  modePlots.forEach(plot => plot.keep());
  setScales();
  changed();
}

// Speeds as cycles per second, or as multiples of real time over a revolution.
function listSpeeds(mode, state) {
  const turning = state.period !== null, cycle = cycleOf(mode), rate = Math.abs(mode.eigenvalue[0]);
  const decays = chosen.decay && !oscillates(mode) && rate > 0 && !turning;
  const unitTime = turning ? Math.min(state.period, cycle) : decays ? 0.5 * Math.log(DECAYED) / rate : cycle;
  const list = get("speed"), at = list.selectedIndex < 0 ? 3 : list.selectedIndex;
  SPEEDS = CYCLES.map(count => count * unitTime);
  list.replaceChildren(...SPEEDS.map((speed, i) => {
    const factor = `${figures(speed, 2)} × real time`;
    return new Option(turning || decays ? factor : oscillates(mode) ? `${CYCLES[i]} cycles/s, ${factor}` : `${CYCLES[i]} cycles/s`);
  }));
  list.selectedIndex = at;
}

function setMode(index) {
  if (!stateOfModes().modes[index]) return;
  chosen.mode = index;
  markMode();
  refill(true);
}
// Selects another mode among those that the state has.
function chooseMode(step) {
  const { modes } = stateOfModes();
  let index = chosen.mode + step;
  while (modes[index] === null) index += step;
  if (modes[index]) setMode(index);
}

function setState(index) {
  chosen.state = Math.max(0, Math.min(modal.states.length - 1, index));
  const { modes } = stateOfModes();
  if (!modes[chosen.mode]) chosen.mode = modes.findIndex(mode => mode !== null);
  listModes();
  markMode();
  refill(true);
}
const chooseState = step => { if (modal.states.length > 1) setState(chosen.state + step); };

function toggleDecay() {
  get("decay").checked = !get("decay").checked;
  setDecay();
}
function setDecay() {
  chosen.decay = get("decay").checked;
  main.goTo(0);
  refill(true);
}

// Frequency and damping of all modes over the states; a click selects the state.
class ModePlot {
  constructor(title, valueOf) {
    this.box = document.createElement("div");
    this.title = title;
    this.valueOf = valueOf;
    get("mode-plots").append(this.box);
    this.build();
  }

  build() {
    this.plot?.destroy();
    const count = Math.max(...modal.states.map(state => state.modes.length));
    const times = modal.states.map(state => state.value);
    const lines = Array.from({ length: count }, (_, m) => modal.states.map(state => (state.modes[m] ? this.valueOf(state.modes[m]) : null)));
    const font = "12px system-ui, sans-serif", axis = { stroke: inks.faint, grid: { stroke: inks.grid, width: 1 }, ticks: { stroke: inks.grid, width: 1 }, font, labelFont: font, labelSize: 18, values: ticked };
    this.plot = new uPlot({
      width: Math.max(120, this.box.clientWidth), height: 170, padding: [10, 18, 0, 0],
      scales: { x: { time: false } },
      axes: [{ ...axis, label: `${modal.quantity[0]} (${modal.quantity[1]})`, size: 34 }, { ...axis, label: this.title, size: 58 }],
      series: [{}, ...lines.map((_, m) => ({ label: `mode ${m + 1}`, stroke: seriesInk(m), width: 1.6, spanGaps: true, points: { show: false } }))],
      legend: { show: false }, cursor: { drag: { x: false, y: false }, points: { size: 6 } },
      hooks: { draw: [plot => drawZero(plot)] },
    }, [times, ...lines], this.box);
    this.line = document.createElement("div");
    this.line.className = "now";
    this.plot.over.append(this.line);
    this.plot.over.addEventListener("click", event => {
      const value = this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x");
      setState(modal.states.reduce((best, state, i) => (Math.abs(state.value - value) < Math.abs(modal.states[best].value - value) ? i : best), 0));
    });
    this.keep();
  }

  keep() { this.line.style.transform = `translateX(${this.plot.valToPos(stateOfModes().value, "x")}px)`; }
  resize() {
    const width = this.box.clientWidth;
    if (width > 0 && Math.abs(width - this.plot.width) > 1) this.plot.setSize({ width, height: this.plot.height });
    this.keep();
  }
}
// The line at zero damping.
function drawZero(plot) {
  const { ctx, bbox } = plot, y = Math.round(plot.valToPos(0, "y", true)) + 0.5;
  if (y < bbox.top || y > bbox.top + bbox.height) return;
  ctx.save();
  ctx.strokeStyle = inks.text;
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}
function buildModePlots() { modePlots.forEach(plot => plot.build()); }

// The panel for modes, instead of plots over time.
function buildModes() {
  get("modes").hidden = false;
  for (const id of ["plots", "save-table"]) get(id).hidden = true;
  get("open").parentElement.hidden = true;
  for (const id of ["speed", "time"]) get(id).title = "";
  get("time").setAttribute("aria-label", "Phase");
  document.querySelector("aside").setAttribute("aria-label", "Modes and values");
  get("keys").textContent = "Space plays · ↑ ↓ mode · Page ↑ ↓ state · ← → step · D decay · 1–4 views · O ortho · A frame all · Shift + arrows turn · + − zoom · R reset · F follow · P PNG · T light or dark";
  get("modes-title").textContent = `${modal.title}. Amplitude 1: the largest displacement is ${compact(100 * modal.share, 0)} % of the size of the model, or less where rotations would be large.`;
  get("state-label").hidden = !modal.quantity;
  if (modal.quantity) {
    get("state-name").textContent = modal.quantity[0];
    get("state").max = modal.states.length - 1;
    get("state").addEventListener("input", event => setState(Number(event.target.value)));
    modePlots.push(new ModePlot("frequency (Hz)", frequencyOf), new ModePlot("damping ratio", dampingOf));
    new ResizeObserver(() => modePlots.forEach(plot => plot.resize())).observe(get("mode-plots"));
  }
  get("amplitude").addEventListener("input", event => { chosen.amplitude = Number(event.target.value); refill(false); });
  get("decay").addEventListener("change", setDecay);
  setState(chosen.state);
}
