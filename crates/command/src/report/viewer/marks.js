
// ---- joints, latches, gauges, masses, links of rigid bodies, paths, arrows -------------------------------------------

const marks = new THREE.Group(), symbols = [];
const LATCH_INKS = { closed: "#2e9e5b", open: "#8b98a5" };

// Numbers of sides of round symbols. `roundSides` gives the least with which a circle lies within UNSEEN_PIXELS of its outline at the present zoom.
const ROUND = [8, 12, 16, 24, 32];
function roundSides(radius) {
  const pixels = radius * pixelsPerMetre() * Math.min(window.devicePixelRatio || 1, 2);
  return ROUND.find(sides => pixels * (1 - Math.cos(Math.PI / sides)) <= UNSEEN_PIXELS) || ROUND[ROUND.length - 1];
}
// Geometries of symbols: radii in m, and how a geometry is made with numbers of sides for these radii.
const ball = radius => ({ radii: [radius], make: sides => new THREE.SphereGeometry(radius, sides, sides >> 1) });
const rod = (radius, length) => ({ radii: [radius], make: sides => new THREE.CylinderGeometry(radius, radius, length, sides) });
const hoop = (radius, thick) => ({ radii: [thick, radius + thick], make: (across, around) => new THREE.TorusGeometry(radius, thick, across, around) });
const bar = (radius, length) => ({ radii: [], make: () => new THREE.CylinderGeometry(radius, radius, length, 4) });

// Sets the geometry of a symbol for the present zoom; geometries are kept.
function fitRound({ mesh, form, made }) {
  const sides = form.radii.map(roundSides), key = sides.join();
  if (!made.has(key)) made.set(key, form.make(...sides));
  mesh.geometry = made.get(key);
}

function markMesh(form, colour, describe) {
  const mesh = new THREE.Mesh(undefined, unshaded(new THREE.MeshLambertMaterial({ color: colour })));
  mesh.castShadow = true;
  mesh.frustumCulled = false;
  symbols.push({ mesh, form, made: new Map() });
  if (describe) mesh.userData.describe = describe;
  marks.add(mesh);
  return mesh;
}

// Sizes of the symbols at the inner end of a body: from its section, within limits of visibility.
function sizeAt(body) {
  const rim = about.bodies[body].rims[0], [wide, high] = [0, 1].map(i => Math.max(...rim.map(p => Math.abs(p[i]))));
  const within = (value, least, most) => Math.max(least * WIDTH, Math.min(most * WIDTH, value));
  return { half: within(1.25 * wide, 0.012, 0.05), radius: within(1.5 * high, 0.005, 0.014) };
}

const hingeMarks = about.hinges.map(hinge => {
  const { half, radius } = sizeAt(hinge.body);
  const describe = () => ({ title: `joint ${hinge.name}`, key: `joint:${hinge.name}`, rows: () => hingeRows(hinge), place: () => main.section(hinge.body, 0).at });
  const shape = hinge.kind === "revolute" ? rod(radius, 2 * half) : hinge.kind === "prismatic" ? bar(1.4 * radius, 2 * half) : ball(1.6 * radius);
  const mesh = markMesh(shape, "#5b6773", describe);
  mesh.userData.body = hinge.body;
  const rings = hinge.latch ? [-0.55, 0.55].map(place => [place * half, markMesh(hoop(1.35 * radius, 0.5 * radius), LATCH_INKS.open, describe)]) : [];
  return { hinge, mesh, rings };
});
function hingeRows(hinge) {
  const { present, layout } = main, rows = [], reaction = layout.reactions + 6 * hinge.body;
  if (hinge.freedom !== null) {
    const turns = about.units[hinge.freedom] === "°";
    rows.push([about.coordinates[hinge.freedom], `${compact(present[layout.angles + hinge.freedom], turns ? 3 : 5)}${about.units[hinge.freedom]}`]);
    if (hinge.latch) rows.push(["latch", present[layout.latched + hinge.freedom] ? "closed" : "open"]);
  }
  rows.push(["reaction force", `${three(vector(present, reaction))} N`], ["reaction moment", `${three(vector(present, reaction + 3))} N·m`]);
  return rows;
}

const gaugeMarks = about.gauges.map((gauge, i) => markMesh(ball(0.008 * WIDTH), "#ffffff", () => ({
  title: `gauge ${gauge.name}`,
  key: `gauge:${gauge.name}`,
  rows: () => [
    ["strain", `${microstrain(main.present[main.layout.strains + i])} µm/m`],
    ["place", `${figures(gauge.place)} m from the inner end of ${about.bodies[gauge.body].name}`],
    ["at", `${vector(main.present, main.layout.gauges + 3 * i).map(c => compact(c, digitsFor(extents.size, 6))).join(", ")} m`],
  ],
  place: () => vector(main.present, main.layout.gauges + 3 * i),
})));
const microstrain = strain => compact(strain * 1e6, digitsFor(largest(FIELDS.strain) * 1e6, 4));

const massMarks = about.masses.map(mass => {
  // as a ball of steel, within limits of visibility
  const radius = Math.max(0.006 * WIDTH, Math.min(0.03 * WIDTH, Math.cbrt(mass.kg / (7800 * 4.19))));
  return markMesh(ball(radius), "#9a7b4f", () => ({
    title: `mass ${mass.name}`,
    key: `mass:${mass.name}`,
    rows: () => [["mass", `${figures(mass.kg)} kg`], ["at", `${massPlace(main, mass).map(c => compact(c, digitsFor(extents.size, 5))).join(", ")} m`]],
    place: () => massPlace(main, mass),
  }));
});

// Lines that represent rigid bodies, and lines from axes to parts with an offset.
const links = lines(new THREE.LineBasicMaterial());
function linkPoints() {
  const points = [];
  for (const mass of about.masses) points.push(sectionAt(main, mass.body, mass.place).at, massPlace(main, mass));
  about.bodies.forEach((body, b) => {
    if (!body.rigid) return;
    const hub = main.section(b, 0).at;
    about.gauges.forEach((gauge, i) => { if (gauge.body === b) points.push(hub, vector(main.present, main.layout.gauges + 3 * i)); });
    // lines to the bodies that a rigid body carries
    about.surfaces.forEach((surface, i) => {
      if (surface.body === b) points.push(hub, mix(vector(main.present, main.layout.surfaces[i]), vector(main.present, main.layout.surfaces[i] + 3), 0.5));
    });
  });
  return points;
}

const traces = lines(new THREE.LineDashedMaterial({ dashSize: 0.012 * WIDTH, gapSize: 0.009 * WIDTH, transparent: true, opacity: 0.8 }));
function tracePoints() {
  const points = [];
  about.bodies.forEach((body, b) => {
    let last = null;
    const add = point => { if (last) points.push(last, point); last = point; };
    const end = body.rims.length - 1, until = modal ? main.last : main.position, stride = Math.max(1, Math.ceil(until / 400));
    // of long runs, the last five seconds of frames
    for (let frame = live ? Math.max(0, Math.floor(until) - 150) : 0; frame <= until; frame += stride) add(main.section(b, end, frame).at);
    if (!modal) add(main.section(b, end).at);
  });
  return points;
}

// ---- arrows ----------------------------------------------------------------------------------------------------------

// Start points and vectors of each set; the largest of the run has a fifth of the machine's length.
const stationVectors = offset => () => about.stations.map((_, i) => {
  const place = main.layout.stations + PER_STATION * i;
  return [vector(main.present, place), vector(main.present, place + offset)];
});
const ARROWS = {
  loads: { title: "loads", unit: "N", ink: "#c2410c", of: stationVectors(3), count: about.stations.length },
  "air forces": { title: "air forces", unit: "N", ink: "#7c3aed", of: stationVectors(9), count: about.winds ? about.stations.length : 0 },
  reactions: {
    title: "reactions", unit: "N", ink: "#b91c5c", count: about.bodies.length,
    of: () => about.bodies.map((_, b) => [main.section(b, 0).at, vector(main.present, main.layout.reactions + 6 * b)]),
  },
  gravity: {
    title: "gravity", unit: "m/s²", ink: "#2fae62", count: 1, shown: true,
    of: () => { const points = about.bodies.map((body, b) => main.section(b, body.rims.length >> 1).at);
      return [[points.reduce((sum, p) => plus(sum, p), [0, 0, 0]).map(c => c / points.length), vector(main.present, main.layout.gravity)]]; },
  },
  wind: {
    title: "wind", unit: "m/s", ink: "#19a3e6", count: about.winds, shown: true, upstream: true,
    of: () => about.bodies.slice(0, about.winds).map((body, b) => [main.section(b, body.rims.length >> 1).at, vector(main.present, main.layout.winds + 3 * b)]),
  },
};
const arrowSets = [];
function buildArrows() {
  const sets = Object.entries(ARROWS).filter(([name, { count }]) => count && (!modal || ["gravity", "wind"].includes(name)));
  const largest = sets.map(() => 0);
  for (let frame = 0; frame < main.count; frame++) {
    main.goTo(frame);
    sets.forEach(([, set], i) => { for (const [, value] of set.of()) largest[i] = Math.max(largest[i], Math.hypot(...value)); });
  }
  for (const [i, [name, set]] of sets.entries()) {
    let most = largest[i];
    if (most < 1e-9 && !live) continue;
    most = Math.max(most, 1e-9);
    const material = unshaded(new THREE.MeshLambertMaterial({ color: set.ink }));
    const shaft = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0), material, set.count);
    const head = new THREE.InstancedMesh(new THREE.ConeGeometry(1, 1, 14).translate(0, 0.5, 0), material, set.count);
    shaft.frustumCulled = head.frustumCulled = false;
    scene.add(shaft, head);
    arrowSets.push({ name, ...set, most, shaft, head });
  }
  main.goTo(0);
}
const UP = new THREE.Vector3(0, 1, 0);
function updateArrows() {
  for (const set of arrowSets) {
    const shown = get(`arrow-${set.name}`).checked;
    set.shaft.visible = set.head.visible = shown;
    if (!shown) continue;
    set.of().forEach(([at, value], i) => {
      const size = Math.hypot(...value), length = 0.2 * WIDTH * size / set.most;
      const way = new THREE.Vector3(...unit(value)), thick = size / set.most > 1e-6 ? 1 : 0;
      const turned = new THREE.Quaternion().setFromUnitVectors(UP, way);
      const tip = Math.min(0.05 * WIDTH, 0.6 * length), begin = set.upstream ? plus(at, unit(value), -length - 0.04 * WIDTH) : at;
      const place = new THREE.Vector3(...begin), radius = 0.0035 * WIDTH * thick;
      set.shaft.setMatrixAt(i, new THREE.Matrix4().compose(place, turned, new THREE.Vector3(radius, (length - tip) * thick, radius)));
      place.addScaledVector(way, length - tip);
      set.head.setMatrixAt(i, new THREE.Matrix4().compose(place, turned, new THREE.Vector3(3.2 * radius, tip * thick, 3.2 * radius)));
    });
    set.shaft.instanceMatrix.needsUpdate = set.head.instanceMatrix.needsUpdate = true;
  }
}

function updateMarks() {
  symbols.forEach(fitRound);
  const pose = (mesh, at, way) => { mesh.position.set(...at); if (way) mesh.quaternion.setFromUnitVectors(UP, new THREE.Vector3(...unit(way))); };
  for (const { hinge, mesh, rings } of hingeMarks) {
    const s = main.section(hinge.body, 0), x = cross(s.y, s.z);
    const axis = [0, 1, 2].map(i => hinge.axis[0] * x[i] + hinge.axis[1] * s.y[i] + hinge.axis[2] * s.z[i]);
    mesh.visible = get("joints").checked;
    pose(mesh, s.at, hinge.freedom === null ? null : axis);
    const closed = hinge.freedom !== null && main.present[main.layout.latched + hinge.freedom] > 0.5;
    for (const [off, ring] of rings) {
      ring.visible = mesh.visible;
      ring.material.color.set(closed ? LATCH_INKS.closed : LATCH_INKS.open);
      ring.position.set(...plus(s.at, unit(axis), off));
      ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...unit(axis)));
    }
  }
  const rgb = [0, 0, 0];
  gaugeMarks.forEach((mesh, i) => {
    mesh.visible = get("gauges").checked;
    mesh.position.set(...vector(main.present, main.layout.gauges + 3 * i));
    tint(DIVERGING, share(main.present[main.layout.strains + i], largest(FIELDS.strain)), rgb, 0);
    mesh.material.color.setRGB(...rgb);
  });
  massMarks.forEach((mesh, i) => mesh.position.set(...massPlace(main, about.masses[i])));
  setPoints(links, linkPoints());
  links.material.color.set(inks.edge);
  traces.visible = get("trace").checked;
  if (traces.visible) {
    setPoints(traces, tracePoints());
    traces.computeLineDistances();
    traces.material.color.set(inks.accent);
  }
}
