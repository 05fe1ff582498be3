
// ---- plots: recorded signals over time, synchronous with the stage ---------------------------------------------------

const SERIES_INKS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#c0568f", "#a07800", "#2a9fd6", "#7a5195", "#6b6b6b"],
  dark: ["#56b4e9", "#f0883e", "#2fc49a", "#e79cc3", "#e0c04a", "#8fd0ff", "#b79adf", "#a8a8a8"],
};
const seriesInk = n => SERIES_INKS[document.documentElement.dataset.dark === "true" ? "dark" : "light"][n % 8];
const SHOWN_UNITS = { rad: ["°", 180 / Math.PI], "rad/s": ["°/s", 180 / Math.PI], "rad/s2": ["°/s²", 180 / Math.PI], "N.m": ["N·m", 1],
  "N.m.s": ["N·m·s", 1], "N.s": ["N·s", 1], "m/s2": ["m/s²", 1], "m2/s": ["m²/s", 1], 1: ["–", 1], "": ["–", 1] };

// Displayed unit of a signal and its factor.
function shownUnit(name, given) {
  if (given === "1" && /(^|\.)strain/.test(name)) return ["µm/m", 1e6];
  return SHOWN_UNITS[given] || [given.replaceAll(".", "·"), 1];
}
const signals = new Map(); // by name: unit, factor
for (const run of runs) for (const [name, given] of run.about.signals) {
  if (!signals.has(name)) { const [unit, factor] = shownUnit(name, given); signals.set(name, { unit, factor }); }
}
function adoptTables() {
  for (const table of tables) for (const name of table.names) if (!signals.has(name)) {
    const [unit, factor] = shownUnit(name, "");
    signals.set(name, { unit, factor });
  }
}
adoptTables();

// All curves of a signal: this run solid, other runs dashed, tables as dots.
function sourcesOf(name) {
  const { factor } = signals.get(name), scaled = values => values.map(value => (value === null ? null : factor * value));
  const found = [];
  for (const run of runs) {
    const column = run.about.signals.findIndex(([other]) => other === name);
    if (column >= 0 && run.shown) found.push({ run, label: run === main ? name : `${name} (${run.label})`, time: run.signal(0), values: scaled(run.signal(column + 1)) });
  }
  for (const table of tables) if (table.names.includes(name) && table.shown) {
    found.push({ table, label: `${name} (${table.label})`, time: table.time, values: scaled(table.column(name)) });
  }
  return found;
}

// Tick labels of an axis.
const ticked = (plot, ticks) => ticks.map(tick => {
  const text = String(+tick.toPrecision(10));
  return (text.length > 8 ? tick.toExponential(1) : text).replace(/-/g, "−");
});

// Ends of an axis: a constant signal lies in the middle of a band of its size.
const rangeOf = (plot, low, high) => {
  if (low === null || high === null) return [-1, 1];
  const band = 0.1 * Math.abs(low) || 1;
  return high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high)) ? uPlot.rangeNum(low, high, 0.1, true) : [low - band, high + band];
};

const charts = [];
let zoomed = null; // range of time of the plots, `null` for all

class Chart {
  constructor(names) {
    this.names = names;
    this.box = get("chart-form").content.firstElementChild.cloneNode(true);
    get("charts").append(this.box);
    const input = this.box.querySelector("input");
    input.addEventListener("change", () => { if (signals.has(input.value)) { this.add(input.value); input.value = ""; } });
    this.box.querySelector(".close").addEventListener("click", () => this.remove());
    this.build();
  }

  // A plot has axes for at most two units; a third unit starts a new plot.
  add(name) {
    const units = new Set([...this.names, name].map(other => signals.get(other).unit));
    if (units.size > 2) { charts.push(new Chart([name])); return; }
    if (!this.names.includes(name)) this.names.push(name);
    this.build();
  }
  remove() {
    this.plot?.destroy();
    this.box.remove();
    charts.splice(charts.indexOf(this), 1);
  }

  build() {
    this.plot?.destroy();
    const chips = this.box.querySelector(".chips");
    chips.replaceChildren(...this.names.map(name => {
      const chip = document.createElement("button");
      chip.type = "button";
      chip.textContent = `${name} ×`;
      chip.setAttribute("aria-label", `Remove ${name} from the plot`);
      chip.addEventListener("click", () => { this.names = this.names.filter(other => other !== name); if (this.names.length) this.build(); else this.remove(); });
      return chip;
    }));
    const found = this.names.flatMap((name, n) => sourcesOf(name).map(source => ({ ...source, name, ink: seriesInk(n) })));
    const bands = this.names.flatMap((name, n) => bandsOf(name).map(band => ({ ...band, ink: seriesInk(n) })));
    const units = [...new Set(this.names.map(name => signals.get(name).unit))];
    this.found = found;
    const data = live ? this.recent() : found.length ? uPlot.join([...found, ...bands].map(source => [source.time, source.values])) : [[]];
    const text = inks.text, faint = inks.faint;
    const axis = { stroke: faint, grid: { stroke: inks.grid, width: 1 }, ticks: { stroke: inks.grid, width: 1 }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 18 };
    const series = source => ({
      label: source.label, scale: signals.get(source.name).unit, stroke: source.ink, spanGaps: true,
      width: source.table ? 0 : 1.6, dash: source.run && source.run !== main ? [7, 4] : undefined,
      paths: source.table ? () => null : undefined,
      points: source.table ? { show: true, size: 4, stroke: source.ink, fill: source.ink } : { show: !live && source.values.length < 3 },
      value: (plot, value, index, at) => (at === null ? "–" : `${figures(nearest(plot.data[index], at))} ${signals.get(source.name).unit}`),
    });
    const box = this.box.querySelector(".plot");
    this.plot = new uPlot({
      width: Math.max(120, box.clientWidth), height: 176, padding: [10, units.length > 1 ? 0 : 10, 0, 0],
      scales: { x: { time: false, ...(zoomed ? { min: zoomed[0], max: zoomed[1] } : {}) }, ...Object.fromEntries(units.map(unit => [unit, { auto: true, range: rangeOf }])) },
      axes: [{ ...axis, label: "time (s)", size: 34, values: ticked }, ...units.map((unit, i) => ({
        ...axis, scale: unit, side: i ? 1 : 3, size: (plot, ticks) => 22 + 7 * Math.max(5, ...(ticks || []).map(tick => tick.length)), label: unit === "–" ? "value (–)" : `${quantity(this.names.filter(name => signals.get(name).unit === unit))} (${unit})`,
        grid: { ...axis.grid, show: i === 0 }, values: ticked,
      }))],
      series: [{ label: "t", value: (plot, value) => (value === null ? "–" : `${compact(plot.cursor.left >= 0 ? value : main.timeAt(main.position), 4)} s`) }, ...found.map(series), ...bands.map(bandSeries)],
      bands: bandFills(found.length, bands),
      legend: { live: true, markers: { width: 2 } },
      cursor: { drag: { x: true, y: false, dist: 5 }, sync: { key: "foldwing", setSeries: false }, points: { size: 6 } },
      hooks: {
        draw: [plot => drawEvents(plot, text)],
        setScale: [(plot, key) => { if (key === "x" && !this.building) spread(this, plot.scales.x.min, plot.scales.x.max); }],
      },
    }, data, box);
    const line = document.createElement("div");
    line.className = "now";
    this.plot.over.append(line);
    this.line = line;
    let down = 0;
    this.plot.over.addEventListener("mousedown", event => { down = event.clientX; });
    this.plot.over.addEventListener("mouseup", event => { if (Math.abs(event.clientX - down) < 5) {
      if (live) { send({ do: "pause" }); link.looking = true; } else play(false);
      seek(main.positionAt(this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x")));
    } });
    this.keep();
    watchCharts();
  }

  // Samples of the curves of `found` in a live simulation, within the time window and a margin. All machines have the same times.
  recent(found = this.found) {
    const [low, high] = zoomed || plotWindow(), { times } = main;
    const from = Math.max(0, indexAt(times, low) - 1), to = Math.min(times.length, indexAt(times, high) + 2);
    return [times.slice(from, to), ...found.map(({ run, name }) => {
      const { factor } = signals.get(name), values = (run.samples.get(name) || []).slice(from, to);
      return Array.from({ length: to - from }, (_, i) => (values[i] === null || values[i] === undefined ? null : factor * values[i]));
    })];
  }
  refresh() {
    const [min, max] = zoomed || plotWindow();
    this.building = true;
    this.plot.batch(() => { this.plot.setData(this.recent(), false); this.plot.setScale("x", { min, max }); });
    this.building = false;
    this.keep();
  }

  resize() {
    const width = this.box.querySelector(".plot").clientWidth;
    if (width > 0 && Math.abs(width - this.plot.width) > 1) this.plot.setSize({ width, height: this.plot.height });
    this.keep();
  }

  // The line and the legend show the present time.
  keep() {
    const time = main.timeAt(main.position), { plot, line } = this, left = plot.valToPos(time, "x");
    line.style.display = left >= -1 && left <= plot.over.clientWidth + 1 ? "" : "none";
    line.style.transform = `translateX(${left}px)`;
    if (!plot.cursor.left || plot.cursor.left < 0) plot.setLegend({ idx: indexAt(plot.data[0], time) }, false);
  }
}

// Curves of a sweep: the median dashed, the others as edges of areas, without an entry in the legend.
const bandSeries = ({ label, name, ink, fraction }) => ({
  label, scale: signals.get(name).unit, stroke: fraction === 0.5 ? ink : `${ink}60`, width: fraction === 0.5 ? 1 : 0.6, dash: fraction === 0.5 ? [2, 3] : undefined,
  spanGaps: true, points: { show: false }, class: "extreme",
});
// Areas between the curves at the same distance from the median.
function bandFills(found, bands) {
  const per = fan ? fan.fractions.length : 1, fills = [];
  for (let first = 0; first < bands.length; first += per) for (let k = 0; k < per >> 1; k++) {
    fills.push({ series: [found + first + per - k, found + first + k + 1], fill: `${bands[first].ink}${k ? "30" : "18"}` });
  }
  return fills;
}

// Common ending of the names on an axis: `fold.angle` and `tip_fold.angle` are angles.
function quantity(names) {
  const ends = new Set(names.map(name => name.split(".").slice(1).join(".") || name));
  if (ends.size === 1) return [...ends][0].replaceAll(".", " ").replaceAll("_", " ");
  const begins = new Set(names.map(name => name.split(".")[0]));
  return begins.size === 1 ? [...begins][0].replaceAll("_", " ") : "value";
}

function indexAt(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) { const middle = (low + high + 1) >> 1; if (times[middle] <= time + 1e-9) low = middle; else high = middle - 1; }
  return low;
}
// If a row belongs to another run or table: the last value before it.
function nearest(values, at) {
  for (let i = at; i >= 0; i--) if (values[i] !== null && values[i] !== undefined) return values[i];
  return NaN;
}

function drawEvents(plot, ink) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const event of eventsSeen()) {
    const x = Math.round(plot.valToPos(event.t, "x", true)) + 0.5;
    ctx.strokeStyle = EVENT_INKS[event.kind] || ink;
    ctx.globalAlpha = 0.75;
    ctx.setLineDash([3, 3]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
}
const EVENT_INKS = { latch: "#2e9e5b", open: "#8b98a5", release: "#d97706", hold: "#b45309", gust: "#0284c7" };
const eventsSeen = () => about.events.filter(event => event.t >= main.timeOf(0) - 1e-9 && event.t <= main.timeOf(main.last) + 1e-9);

// All plots have the same range of time.
let spreading = false;
function spread(from, low, high) {
  if (spreading || low === null || high === null) return;
  spreading = true;
  const whole = [main.timeOf(0), main.timeOf(main.last)], slack = 1e-6 * main.duration;
  // in a live run a double click resets the range to the moving window
  if (live) [whole[0], whole[1]] = [Math.max(main.times[0] || 0, whole[0]), Math.min(whole[1], main.times[main.times.length - 1] || 0)];
  zoomed = low <= whole[0] + slack && high >= whole[1] - slack ? null : [low, high];
  for (const chart of charts) if (chart !== from && chart.plot) chart.plot.setScale("x", { min: low, max: high });
  spreading = false;
  for (const chart of charts) if (chart.plot) chart.keep();
}

// Initial plots: angles, strains, loads at the root or energies, as far as they are recorded.
function buildPlots() {
  const names = [...signals.keys()], list = get("signal-names");
  list.replaceChildren(...names.map(name => new Option(signals.get(name).unit, name)));
  const take = (pattern, most) => names.filter(name => pattern.test(name)).slice(0, most);
  const wanted = [
    take(/^[^.]+\.(angle|position)$/, 6), take(/^gauge\..*strain/, 6), take(/^tip.*\.position\.z$/, 4),
    names.includes("energy.kinetic") ? ["energy.kinetic", "energy.elastic", "energy.total"].filter(name => names.includes(name)) : [],
  ].filter(group => group.length);
  if (!wanted.length && names.length) wanted.push(names.slice(0, 3));
  // columns of tables without a computed counterpart have separate plots
  const computed = new Set(runs.flatMap(run => run.about.signals.map(([name]) => name)));
  const measured = names.filter(name => !computed.has(name)).slice(0, 4);
  if (measured.length) wanted.push(measured);
  const kept = (again?.kept?.charts || []).map(group => group.filter(name => signals.has(name))).filter(group => group.length);
  for (const group of kept.length ? kept : wanted) charts.push(new Chart(group));
  get("add-chart").addEventListener("change", event => {
    if (signals.has(event.target.value)) { charts.push(new Chart([event.target.value])); event.target.value = ""; }
  });
  new ResizeObserver(() => charts.forEach(chart => chart.resize())).observe(get("charts"));
}
