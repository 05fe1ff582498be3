
// ---- aerodynamic loads on the surfaces: lift per span, pressure on the panels --------------------------------------------

// Leading or trailing edge of a column of a surface at the present time or at a frame.
function edgeAt(run, index, column, edge, frame) {
  const place = run.layout.surfaces[index] + 6 * column + 3 * edge;
  return frame === undefined ? vector(run.present, place) : vector(run.numbers, run.about.begins[frame] + place);
}

// Chord × span of a surface at a column: the direction of the aerodynamic force if the circulation about the span is positive.
function pushedSide(run, index, column, frame) {
  const { columns } = run.about.surfaces[index], [a, b] = [Math.max(0, column - 1), Math.min(columns - 1, column + 1)];
  const chord = plus(edgeAt(run, index, column, 1, frame), edgeAt(run, index, column, 0, frame), -1);
  return unit(cross(chord, plus(edgeAt(run, index, b, 0, frame), edgeAt(run, index, a, 0, frame), -1)));
}

// Upper side of every surface as a sign of `pushedSide`. At the start of a chain of bodies with surfaces, up is against gravity at the start, else
// along z, y or x of the root, of a rotor downwind; bodies further out, which continue the span, have the side of the one that carries them, however they are folded.
const sidesOf = new Map();
function sides(run) {
  if (sidesOf.has(run)) return sidesOf.get(run);
  const { surfaces, bodies, rotor, winds } = run.about, found = [];
  const carrierOf = body => bodies[body].carrier?.[0];
  surfaces.forEach((surface, i) => {
    let body = carrierOf(surface.body), inner = -1;
    while (body !== undefined && inner < 0) { inner = surfaces.findIndex((other, j) => j < i && other.body === body); body = carrierOf(body); }
    if (inner >= 0) { found.push(found[inner]); return; }
    const begin = run.about.begins[0], wind = winds ? vector(run.numbers, begin + run.layout.winds + 3 * surface.body) : [0, 0, 0];
    const gravity = vector(run.numbers, begin + run.layout.gravity).map(c => -c);
    const normal = Array.from({ length: surface.columns }, (_, c) => pushedSide(run, i, c, 0)).reduce((a, b) => plus(a, b)).map(c => c / surface.columns);
    // the first of these directions that is not parallel to the surface
    const ups = [...(rotor ? [wind] : []), gravity, [0, 0, 1], [0, 1, 0], [1, 0, 0]].map(up => dot(normal, unit(up)));
    found.push((ups.find(part => Math.abs(part) > 0.3) ?? 1) < 0 ? -1 : 1);
  });
  sidesOf.set(run, found);
  return found;
}

// Span in m of a column: half of the adjacent strips.
function spanOf({ columns, places }, column) {
  return 0.5 * (places[Math.min(columns - 1, column + 1)] - places[Math.max(0, column - 1)]);
}

// Columns of other surfaces where a surface ends, as lists of surface and column: bodies that start at the end of another continue its span.
const continuedOf = new Map();
function continued(run, index, column) {
  if (!continuedOf.has(run)) {
    const { surfaces, bodies } = run.about, found = surfaces.map(() => new Map());
    const note = (i, c, other) => found[i].set(c, [...(found[i].get(c) || []), other]);
    surfaces.forEach((outer, o) => surfaces.forEach((inner, i) => {
      const carrier = bodies[outer.body].carrier, end = inner.places[inner.columns - 1], slack = 1e-6 * end;
      if (!carrier || carrier[0] !== inner.body || Math.abs(carrier[1] - end) > slack || outer.places[0] > slack) return;
      note(i, inner.columns - 1, [o, 0]);
      note(o, 0, [i, inner.columns - 1]);
    }));
    continuedOf.set(run, found);
  }
  return continuedOf.get(run)[index].get(column) || [];
}

// Lift per span in N/m at a column: aerodynamic force per length of the span, normal to the span and to the relative wind of the section. An
// edge that two surfaces share has the forces of both, divided by the span of both.
function liftAt(run, index, column, frame) {
  let [force, span] = [liftOf(run, index, column, frame), spanOf(run.about.surfaces[index], column)];
  for (const [other, its] of continued(run, index, column)) {
    force += liftOf(run, other, its, frame);
    span += spanOf(run.about.surfaces[other], its);
  }
  return force / span;
}
function liftOf(run, index, column, frame) {
  const surface = run.about.surfaces[index], begin = frame === undefined ? 0 : run.about.begins[frame];
  const list = frame === undefined ? run.present : run.numbers;
  const force = vector(list, begin + run.layout.edgeForces[index] + 3 * column);
  const up = pushedSide(run, index, column, frame).map(c => c * sides(run)[index]);
  let way = up;
  if (run.about.winds) {
    const met = plus(vector(list, begin + run.layout.winds + 3 * surface.body), velocityAt(run, surface.body, surface.places[column], frame), -1);
    const along = dot(met, met);
    if (along > 1e-12) way = unit(plus(up, met, -dot(up, met) / along));
  }
  return dot(force, way);
}

// Pressure below minus pressure above in Pa on a panel: its normal force at the end of the aerodynamic step divided by its area.
function pressureAt(run, index, strip, row, frame) {
  const surface = run.about.surfaces[index], strips = surface.columns - 1;
  const place = run.layout.panelForces[index] + row * strips + strip;
  const force = frame === undefined ? run.present[place] : run.numbers[run.about.begins[frame] + place];
  const corner = (column, k) => mix(edgeAt(run, index, column, 0, frame), edgeAt(run, index, column, 1, frame), k / surface.panels);
  const [a, b, c, d] = [corner(strip, row), corner(strip + 1, row), corner(strip + 1, row + 1), corner(strip, row + 1)];
  const area = 0.5 * Math.hypot(...cross(plus(c, a, -1), plus(d, b, -1)));
  return sides(run)[index] * force / area;
}

// Fields of the surfaces; `of` gives the value at a corner of a panel: surface, strip, row, column of the corner.
const SURFACE_FIELDS = {
  ...(!modal && about.edgeForces && about.surfaces.length && {
    lift: { title: "lift per span (N/m)", map: LIFT_MAP, of: (run, i, strip, row, column) => liftAt(run, i, column) },
  }),
  ...(!modal && about.panelForces && {
    pressure: { title: "pressure jump (Pa)", map: LIFT_MAP, of: (run, i, strip, row) => pressureAt(run, i, strip, row) },
  }),
  ...(about.strips > 0 && {
    circulation: { title: "circulation (m²/s)", map: WAKE_MAP, of: (run, i, strip) => run.present[run.layout.strips + firstStripOf(run, i) + strip] },
  }),
  none: { title: "nothing" },
};
let surfaceField = Object.values(SURFACE_FIELDS)[0];
const firstStripOf = (run, index) => run.about.surfaces.slice(0, index).reduce((sum, surface) => sum + surface.columns - 1, 0);

// Largest magnitudes over the run, computed on first use; for a live simulation those so far.
const largestOnSurfaces = new Map();
function largestOnSurface(wanted) {
  if (wanted === SURFACE_FIELDS.circulation) return largestCirculation || 1;
  if (largestOnSurfaces.has(wanted)) return largestOnSurfaces.get(wanted) || 1;
  let most = 0;
  const { position } = main;
  for (let frame = 0; frame < main.count; frame++) {
    main.goTo(frame);
    about.surfaces.forEach((surface, i) => {
      for (let strip = 0; strip < surface.columns - (wanted === SURFACE_FIELDS.pressure ? 1 : 0); strip++) for (let row = 0; row < (wanted === SURFACE_FIELDS.pressure ? surface.panels : 1); row++) {
        const value = Math.abs(wanted.of(main, i, strip, row, strip));
        if (value > most) most = value;
      }
    });
  }
  main.goTo(position);
  largestOnSurfaces.set(wanted, most);
  return most || 1;
}
const surfaceRange = () => (ranges.surface !== null ? ranges.surface : largestOnSurface(surfaceField));
