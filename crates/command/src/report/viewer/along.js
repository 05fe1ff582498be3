
// ---- loads along the bodies: diagrams of shear, bending, torsion and lift over the distance from the root ------------------

// The diagrams: series by place among the numbers of a load, or the lift of surfaces.
const DIAGRAMS = [
  { title: "shear (N)", series: [["Vz", 2], ["Vy", 1]] },
  { title: "bending (N·m)", series: [["My", 4], ["Mz", 5]] },
  { title: "torsion (N·m)", series: [["Mx", 3]] },
  { title: "lift (N/m)", series: [["lift", null]] },
];
const along = { chain: [], charts: [], extremes: new Map() };

// Bodies from the root to a free end, each with the distance of its inner end from that of the first body and the position of the next one.
function chainTo(last) {
  const chain = [];
  for (let body = last, until = Infinity; body !== undefined;) {
    chain.unshift({ body, until });
    const carrier = about.bodies[body].carrier;
    [body, until] = carrier || [undefined, 0];
  }
  let from = 0;
  for (const link of chain) {
    const { places } = about.bodies[link.body];
    link.from = from;
    from += Math.min(link.until, places[places.length - 1]);
  }
  return chain;
}

// Whether a diagram has values on a chain of bodies.
const shownOn = (chain, { series: [[, part]] }) => chain.some(({ body }) => (part === null
  ? about.edgeForces && about.surfaces.some(surface => surface.body === body) : about.bodies[body].loaded));

// Distances and values of a series at the present time or at a frame; gaps separate bodies.
function valuesAlong(run, part, frame) {
  const found = [[], []], gap = 1e-9 * (along.length || 1);
  const add = (x, value) => { found[0].push(x); found[1].push(value); };
  for (const { body, from, until } of along.chain) {
    const begun = found[0].length;
    if (part === null) {
      run.about.surfaces.forEach((surface, i) => {
        if (surface.body === body) surface.places.forEach((place, column) => { if (place <= until) add(from + place, liftAt(run, i, column, frame)); });
      });
    } else if (run.about.bodies[body].loaded) {
      run.about.bodies[body].places.forEach((place, i) => { if (place <= until * (1 + 1e-9)) add(from + place, run.load(body, i, frame)[part]); });
    }
    if (found[0].length > begun) add(found[0][found[0].length - 1] + gap, null);
  }
  return found;
}

// Smallest and largest values of a series over the run.
function extremesOf(part) {
  const key = `${get("along-end").value} ${part}`;
  if (along.extremes.has(key)) return along.extremes.get(key);
  const [least, most] = [[], []];
  for (let frame = 0; frame < main.count; frame++) valuesAlong(main, part, frame)[1].forEach((value, i) => {
    if (value === null) { least[i] = most[i] = null; return; }
    if (!(value >= least[i])) least[i] = value;
    if (!(value <= most[i])) most[i] = value;
  });
  along.extremes.set(key, [least, most]);
  return [least, most];
}

// Runs whose bodies have the same sections.
const likeMain = run => run === main || (run.shown && JSON.stringify(run.about.bodies.map(body => [body.places, Boolean(body.loaded)]))
  === JSON.stringify(about.bodies.map(body => [body.places, Boolean(body.loaded)]))
  && JSON.stringify(run.about.surfaces.map(surface => surface.places)) === JSON.stringify(about.surfaces.map(surface => surface.places)));

function alongData({ series }) {
  const others = runs.filter(likeMain), extremes = !live && get("along-most").checked;
  const first = valuesAlong(main, series[0][1]);
  return [first[0], ...series.flatMap(([, part]) => [
    ...others.map(run => valuesAlong(run, part)[1]), ...(extremes ? extremesOf(part) : []),
  ])];
}

class Diagram {
  constructor(about, last) {
    this.about = about;
    this.box = document.createElement("div");
    this.box.className = "diagram";
    get("along-charts").append(this.box);
    const { series, title } = about, others = runs.filter(likeMain), extremes = !live && get("along-most").checked;
    const lines = [], bands = [];
    series.forEach(([label], n) => {
      const ink = seriesInk(n);
      for (const run of others) lines.push({ label: run === main ? label : `${label} (${run.label})`, stroke: ink, width: 1.6, dash: run === main ? undefined : [7, 4], points: { show: false } });
      if (!extremes) return;
      lines.push(...["least", "largest"].map(end => ({ label: `${end} ${label}`, stroke: `${ink}70`, width: 0.8, points: { show: false }, class: "extreme" })));
      bands.push({ series: [lines.length, lines.length - 1], fill: `${ink}1c` });
    });
    for (const line of lines) line.value = (plot, value) => (value === null || value === undefined ? "–" : figures(value));
    const axis = { stroke: inks.faint, grid: { stroke: inks.grid, width: 1 }, ticks: { stroke: inks.grid, width: 1 }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 18 };
    this.plot = new uPlot({
      width: Math.max(120, get("along-charts").clientWidth), height: last ? 176 : 150, padding: [10, 10, 0, 0],
      scales: { x: { time: false, range: () => [0, along.length] }, y: { range: (plot, low, high) => (low === null ? [-1, 1] : uPlot.rangeNum(Math.min(0, low), Math.max(0, high), 0.08, true)) } },
      axes: [{ ...axis, ...(last ? { label: "distance along the bodies (m)", size: 34 } : { size: 30 }), values: ticked }, { ...axis, label: title, values: ticked, size: (plot, ticks) => 22 + 7 * Math.max(5, ...(ticks || []).map(tick => tick.length)) }],
      series: [{ label: "s", value: (plot, value) => (value === null || value === undefined ? "–" : `${figures(value)} m`) }, ...lines], bands,
      legend: { live: true, markers: { width: 2 } }, cursor: { drag: { x: false, y: false }, sync: { key: "foldwing along", setSeries: false }, points: { size: 6 } },
      hooks: { draw: [plot => drawJoints(plot)] },
    }, alongData(about), this.box);
    this.plot.over.addEventListener("click", event => pickAlong(this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x")));
  }
  // The legend shows the values at the pointer, otherwise at the selected section, otherwise at the root.
  refresh() {
    this.plot.setData(alongData(this.about));
    const { left } = this.plot.cursor;
    if (!(left >= 0)) this.plot.setLegend({ idx: indexAt(this.plot.data[0], pickedAlong() ?? 0) }, false);
  }
  resize() {
    const width = this.box.clientWidth;
    if (width > 0 && Math.abs(width - this.plot.width) > 1) this.plot.setSize({ width, height: this.plot.height });
    this.refresh();
  }
}

// Lines at the inner ends of the bodies and at the selected section.
function drawJoints(plot) {
  const { ctx, bbox } = plot, line = (x, ink, dash) => {
    const left = Math.round(plot.valToPos(x, "x", true)) + 0.5;
    Object.assign(ctx, { strokeStyle: ink, lineWidth: 1 });
    ctx.setLineDash(dash);
    ctx.beginPath();
    ctx.moveTo(left, bbox.top);
    ctx.lineTo(left, bbox.top + bbox.height);
    ctx.stroke();
  };
  ctx.save();
  for (const { from } of along.chain.slice(1)) line(from, inks.faint, [3, 3]);
  const at = pickedAlong();
  if (at !== null) line(at, inks.accent, []);
  ctx.restore();
}

// Distance of the selected section along the chain.
function pickedAlong() {
  const link = picked?.on && along.chain.find(({ body }) => body === picked.on.body);
  return link ? link.from + picked.on.place : null;
}

// Selects the section at a distance along the chain, as a click on the machine does.
function pickAlong(x) {
  const link = [...along.chain].reverse().find(({ from }) => x >= from) || along.chain[0];
  choose(sectionPicked(link.body, x - link.from));
}

function buildAlong() {
  const ends = about.bodies.map((_, b) => b).filter(b => !about.bodies.some(body => body.carrier?.[0] === b));
  const useful = ends.filter(b => DIAGRAMS.some(diagram => shownOn(chainTo(b), diagram)));
  get("along").hidden = !useful.length;
  if (!useful.length) return;
  get("along-end").replaceChildren(...useful.map(b => new Option(about.bodies[b].name, b)));
  get("along-end").parentElement.hidden = useful.length < 2;
  get("along-most").parentElement.hidden = Boolean(live);
  for (const id of ["along-end", "along-most"]) get(id).addEventListener("change", () => { buildAlongCharts(); noteAddress(); });
  get("along").addEventListener("toggle", () => { buildAlongCharts(); noteAddress(); });
  const sizes = new ResizeObserver(() => along.charts.forEach(chart => chart.resize()));
  sizes.observe(get("along-charts"));
  again?.signal.addEventListener("abort", () => sizes.disconnect());
}

// The diagrams exist only while the panel is open.
function buildAlongCharts() {
  for (const { plot, box } of along.charts) { plot.destroy(); box.remove(); }
  along.charts = [];
  if (get("along").hidden || !get("along").open) return;
  along.chain = chainTo(Number(get("along-end").value));
  const { body, from } = along.chain[along.chain.length - 1], { places } = about.bodies[body];
  along.length = from + places[places.length - 1];
  along.charts = DIAGRAMS.filter(diagram => shownOn(along.chain, diagram)).map((diagram, i, all) => new Diagram(diagram, i === all.length - 1));
  showAlong();
  const bare = along.chain.filter(({ body: one }) => !about.bodies[one].loaded).map(({ body: one }) => about.bodies[one].name);
  get("along-note").textContent = `Force and moment of the outer part on the inner one, in the axes of the section.${
    bare.length ? ` Rigid and modal bodies have none: ${bare.join(", ")}.` : ""}`;
}
function showAlong() {
  if (get("along").open) for (const chart of along.charts) chart.refresh();
}
