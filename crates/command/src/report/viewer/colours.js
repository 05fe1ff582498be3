
// ---- fields and their colour maps, which are readable with colour blindness -------------------------------------------

const DIVERGING = [[5, 48, 97], [67, 147, 195], [240, 240, 240], [244, 135, 75], [127, 30, 8]];
const WAKE_MAP = [[94, 60, 153], [178, 171, 210], [236, 236, 240], [253, 190, 110], [222, 104, 20]];
const RISING = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
// For lift and pressure; different from the maps of strain and circulation.
const LIFT_MAP = [[0, 92, 82], [98, 182, 170], [240, 240, 240], [222, 184, 110], [140, 82, 12]];
const RUN_INKS = ["#0b62a4", "#d55e00", "#8a4fb0", "#008060", "#a07800"];

const runInk = run => run.ink || RUN_INKS[run.index % RUN_INKS.length];

// A number with a true minus sign, and none before a zero.
const compact = (value, digits) => value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
// Number of decimals with which the largest value has the required number of digits.
const digitsFor = (largest, wanted) => Math.max(0, Math.min(9, wanted - 1 - Math.floor(Math.log10(largest || 1))));
const figures = (value, wanted = 4) => {
  if (!Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6)) return value.toExponential(wanted - 1).replace(/-/g, "−");
  return compact(value, digitsFor(Math.abs(value), wanted));
};

// Elastic moments and force of a section: stiffness times measures.
function elasticLoad(run, body, index, measures) {
  const k = run.about.bodies[body].stiffness[Math.min(index, run.about.bodies[body].stiffness.length - 1)];
  return [0, 1, 2, 3].map(i => k[4 * i] * measures[0] + k[4 * i + 1] * measures[1] + k[4 * i + 2] * measures[2] + k[4 * i + 3] * measures[3]);
}
const strainAt = (measures, [y, z]) => measures[0] + z * measures[2] - y * measures[3];

// Internal loads of a section, in the order of the numbers.
const LOADS = [
  { key: "axial", title: "axial force N (N)" }, { key: "shear_y", title: "shear force Vy (N)" }, { key: "shear_z", title: "shear force Vz (N)" },
  { key: "torsion", title: "torsion Mx (N·m)" }, { key: "bending_y", title: "bending moment My (N·m)" }, { key: "bending_z", title: "bending moment Mz (N·m)" },
];

// Fields of the bodies: value at a section and a point of it. For a mode, strain measures are those of the mode without the state.
const FIELDS = {
  ...(modal && { amplitude: { title: "displacement amplitude (m)", rising: true, value: (run, b, i) => amplitudes[b][i] } }),
  strain: { title: "longitudinal strain (µm/m)", factor: 1e6, value: (run, b, i, s, point) => strainAt(s.measures, point) },
  twist: { title: "twist κx (1/m)", value: (run, b, i, s) => s.measures[1] },
  curvature_y: { title: "curvature κy (1/m)", value: (run, b, i, s) => s.measures[2] },
  curvature_z: { title: "curvature κz (1/m)", value: (run, b, i, s) => s.measures[3] },
  ...(!modal && {
    moment_x: { title: "elastic torsion Mx (N·m)", value: (run, b, i, s) => elasticLoad(run, b, i, s.measures)[1] },
    moment_y: { title: "elastic moment My (N·m)", value: (run, b, i, s) => elasticLoad(run, b, i, s.measures)[2] },
    moment_z: { title: "elastic moment Mz (N·m)", value: (run, b, i, s) => elasticLoad(run, b, i, s.measures)[3] },
    ...(about.bodies.some(body => body.loaded) && Object.fromEntries(LOADS.map(({ key, title }, k) =>
      [key, { title, value: (run, b, i) => (run.load(b, i) || [])[k] ?? 0, at: (run, b, i, frame) => (run.load(b, i, frame) || [])[k] ?? 0 }]))),
    speed: { title: "speed of the axis (m/s)", rising: true, value: (run, b, i, s) => Math.hypot(...s.v) },
  }),
  none: { title: "no field" },
};
let field = modal ? FIELDS.amplitude : FIELDS.strain;

// Largest magnitudes over the run, computed on first use.
const largestOf = new Map();
function largest(wanted) {
  if (!wanted.value) return 1;
  if (!largestOf.has(wanted)) {
    let most = 0;
    for (let frame = 0; frame < main.count; frame++) about.bodies.forEach((body, b) => body.rims.forEach((rim, i) => {
      const s = main.section(b, i, frame);
      for (const point of wanted === FIELDS.strain ? rim : [rim[0]]) most = Math.max(most, Math.abs(wanted.at ? wanted.at(main, b, i, frame) : wanted.value(main, b, i, s, point)));
    }));
    if (wanted === FIELDS.strain) about.gauges.forEach((_, g) => {
      for (let frame = 0; frame < main.count; frame++) most = Math.max(most, Math.abs(main.valueAt(frame, main.layout.strains + g)));
    });
    // strains below 0.1 µm/m are round-off and remain pale
    largestOf.set(wanted, Math.max(most, wanted === FIELDS.strain ? 1e-7 : 1e-9));
  }
  return largestOf.get(wanted);
}
let largestCirculation = (() => {
  let most = 0;
  for (let frame = 0; frame < main.count; frame++) {
    for (let i = 0; i < about.strips; i++) most = Math.max(most, Math.abs(main.valueAt(frame, main.layout.strips + i)));
    for (const { rings, rows, columns } of main.wakes(frame)) {
      for (let i = 0; i < rows * (columns - 1); i++) most = Math.max(most, Math.abs(main.numbers[rings + i]));
    }
  }
  return most;
})();

// Ends of the scales: the value entered, otherwise the largest of the run.
const ranges = { body: null, surface: null };
const bodyRange = () => ranges.body === null ? largest(field) : ranges.body / (field.factor || 1);
const circulationRange = () => (ranges.surface !== null && surfaceField === SURFACE_FIELDS.circulation ? ranges.surface : largestCirculation || 1);
// Whether a field has values above round-off; modal bodies have no strain.
const NOTHING = new Map([[FIELDS.strain, 1e-7]]);
const painted = wanted => Boolean(wanted.value) && largest(wanted) > (NOTHING.get(wanted) || 1e-9);

// Colour of a value from 0 to 255 per channel, written into a list.
function tint(map, share, into, place) {
  const along = 4 * Math.max(0, Math.min(1, share)), before = Math.min(Math.floor(along), 3), rest = along - before;
  const [a, b] = [map[before], map[before + 1]];
  for (let i = 0; i < 3; i++) into[place + i] = (a[i] + rest * (b[i] - a[i])) / 255;
}
const share = (value, most) => 0.5 + 0.5 * value / most;
function tintBody(value, into, place) {
  const most = bodyRange();
  if (field.rising) tint(RISING, value / most, into, place); else tint(DIVERGING, share(value, most), into, place);
}
const css = rgb => `rgb(${rgb.map(c => Math.round(255 * c)).join(" ")})`;
const cssOf = (map, at) => { const rgb = [0, 0, 0]; tint(map, at, rgb, 0); return css(rgb); };
