
// ---- bodies: closed surfaces around the recorded sections, coloured by a field ---------------------------------------

// Points around a section with their outward normals: corners of a rectangle appear twice, an ellipse is smooth.
function ringOf(rim) {
  if (rim.length === 4) return rim.flatMap((p, j) => {
    const q = rim[(j + 1) % 4], normal = unit([q[1] - p[1], p[0] - q[0], 0]);
    return [[...p, normal[0], normal[1]], [...q, normal[0], normal[1]]];
  });
  const [a, b] = [0, 1].map(i => Math.max(...rim.map(p => Math.abs(p[i]))));
  return Array.from({ length: 24 }, (_, j) => {
    const angle = j * Math.PI / 12, [c, s] = [Math.cos(angle), Math.sin(angle)], normal = unit([c * b, s * a, 0]);
    return [a * c, b * s, normal[0], normal[1]];
  });
}

class BodyShape {
  constructor(run, index) {
    this.run = run;
    this.index = index;
    const body = run.about.bodies[index];
    this.rings = body.rims.map(ringOf);
    const around = this.around = this.rings[0].length, sections = this.rings.length;
    const count = (sections + 2) * around;
    const faces = [], step = body.rims[0].length === 4 ? 2 : 1;
    for (let i = 0; i + 1 < sections; i++) for (let j = 0; j < around; j += step) {
      const k = (j + 1) % around, [a, b, c, d] = [i * around + j, i * around + k, (i + 1) * around + k, (i + 1) * around + j];
      faces.push(a, b, c, a, c, d);
    }
    for (const [end, begin] of [[0, sections * around], [1, (sections + 1) * around]]) for (let j = 1; j + 1 < around; j++) {
      faces.push(...(end ? [begin, begin + j, begin + j + 1] : [begin, begin + j + 1, begin + j]));
    }
    const geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal", "color"]) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setIndex(faces);
    const ghost = { color: runInk(run), transparent: true, opacity: 0.5 };
    const material = new THREE.MeshLambertMaterial(run === main ? { vertexColors: true } : ghost);
    if (run === main) shaded(material); else unshaded(material);
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = run === main;
    this.mesh.receiveShadow = run === main;
    this.mesh.userData = { run, body: index, describe: hit => this.describe(hit) };
  }

  update() {
    const { run, index, rings, around } = this, { geometry } = this.mesh;
    const [position, normal, colour] = ["position", "normal", "color"].map(name => geometry.getAttribute(name));
    const tinted = painted(field), last = rings.length - 1, plain = new THREE.Color(inks.body);
    let next = 0;
    const add = (s, i, ring, outward) => {
      for (const [y, z, ny, nz] of ring) {
        for (let c = 0; c < 3; c++) {
          position.array[next + c] = s.at[c] + y * s.y[c] + z * s.z[c];
          normal.array[next + c] = outward ? outward[c] : ny * s.y[c] + nz * s.z[c];
        }
        if (run === main) {
          if (tinted) tintBody(field.value(run, index, i, s, [y, z]), colour.array, next);
          else plain.toArray(colour.array, next);
        }
        next += 3;
      }
    };
    const sections = rings.map((_, i) => run.section(index, i));
    sections.forEach((s, i) => add(s, i, rings[i]));
    const along = s => cross(s.y, s.z);
    add(sections[0], 0, rings[0], along(sections[0]).map(c => -c));
    add(sections[last], last, rings[last], along(sections[last]));
    position.needsUpdate = normal.needsUpdate = colour.needsUpdate = true;
    geometry.boundingSphere = null;
  }

  // The position along the body, and the point of its section, of a hit.
  describe(hit) {
    const { run, index, around, rings } = this;
    const perInterval = rings[0].length === 8 ? 8 : 2 * around;
    const interval = Math.floor(hit.faceIndex / perInterval), at = [hit.point.x, hit.point.y, hit.point.z];
    let [i, part] = [interval, 0];
    if (interval >= rings.length - 1) {
      const outer = hit.faceIndex - perInterval * (rings.length - 1) >= around - 2;
      [i, part] = outer ? [rings.length - 2, 1] : [0, 0];
    } else {
      const [a, b] = [run.section(index, i), run.section(index, i + 1)], way = plus(b.at, a.at, -1);
      part = Math.max(0, Math.min(1, dot(plus(at, a.at, -1), way) / Math.max(dot(way, way), 1e-30)));
      // near an end, the end itself is selected
      if (i === rings.length - 2 && part > 0.6) part = 1;
      if (i === 0 && part < 0.4) part = 0;
    }
    const s = between(run, index, i, part), offset = plus(at, s.at, -1);
    return bodyPlace(run, index, i, part, [dot(offset, s.y), dot(offset, s.z)]);
  }
}

// Whether the surface of a body surrounds all of it, so that the body is not visible.
function enclosed(run, body) {
  if (!solid() || get("glass").checked) return false;
  const { places } = run.about.bodies[body], length = places[places.length - 1];
  return run.about.surfaces.some((surface, i) => surface.body === body && run.about.aerofoils[i]
    && surface.places[0] < 0.02 * length && surface.places[surface.columns - 1] > 0.98 * length);
}

// Nacelle and hub of a turbine: rings of points in the frames of their bodies, as one mesh.
class SolidShape {
  constructor(run) {
    this.run = run;
    this.parts = run.about.solids.map(({ part, body, rings, round }) => ({ part, body, triangles: trianglesOf(rings, round) }));
    const count = this.parts.reduce((sum, { triangles }) => sum + triangles.length, 0), geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal"]) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    const ghost = { color: runInk(run), transparent: true, opacity: 0.5 };
    this.mesh = new THREE.Mesh(geometry, run === main ? shaded(new THREE.MeshLambertMaterial()) : unshaded(new THREE.MeshLambertMaterial(ghost)));
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = this.mesh.receiveShadow = run === main;
    this.mesh.userData = { describe: hit => this.describe(hit) };
  }

  update() {
    const { run, parts, mesh: { geometry, material } } = this, [position, normal] = ["position", "normal"].map(name => geometry.getAttribute(name));
    if (run === main) material.color.set(inks.body);
    let next = 0;
    for (const { body, triangles } of parts) {
      const s = run.section(body, 0), x = cross(s.y, s.z);
      const turned = ([a, b, c]) => [0, 1, 2].map(i => a * x[i] + b * s.y[i] + c * s.z[i]);
      for (const { at, out } of triangles) {
        position.array.set(plus(s.at, turned(at)), next);
        normal.array.set(turned(out), next);
        next += 3;
      }
    }
    position.needsUpdate = normal.needsUpdate = true;
    geometry.boundingSphere = null;
  }

  describe(hit) {
    let left = 3 * hit.faceIndex;
    const { part, body } = this.parts.find(({ triangles }) => { left -= triangles.length; return left < 0; });
    const place = () => this.run.section(body, 0).at;
    const rows = () => [["origin at", `${place().map(c => compact(c, digitsFor(extents.size, 6))).join(", ")} m`]];
    return { title: `${part}: body ${this.run.about.bodies[body].name}`, rows, place };
  }
}

// Corners with normals of the triangles of a closed surface of rings, three by three.
function trianglesOf(rings, round) {
  const found = [], around = rings[0].length, middleOf = ring => ring.reduce((sum, p) => plus(sum, p)).map(c => c / around);
  const middles = rings.map(middleOf), middle = mix(middles[0], middles[rings.length - 1], 0.5);
  const add = (corners, outs) => {
    const flat = unit(cross(plus(corners[1], corners[0], -1), plus(corners[2], corners[0], -1)));
    // counter-clockwise from outside
    const outward = dot(flat, plus(corners[0], middle, -1)) < 0 ? [0, 2, 1] : [0, 1, 2], sign = outward[1] === 2 ? -1 : 1;
    for (const k of outward) found.push({ at: corners[k], out: outs ? outs[k] : flat.map(c => sign * c) });
  };
  const out = (i, k) => unit(plus(rings[i][k], middles[Math.max(0, i - 1)], -1));
  for (let i = 0; i + 1 < rings.length; i++) for (let k = 0; k < around; k++) {
    const l = (k + 1) % around, corners = [[i, k], [i, l], [i + 1, l], [i + 1, k]], at = corners.map(([r, c]) => rings[r][c]);
    const outs = round ? corners.map(([r, c]) => out(r, c)) : null;
    for (const [a, b, c] of [[0, 1, 2], [0, 2, 3]]) add([at[a], at[b], at[c]], outs && [outs[a], outs[b], outs[c]]);
  }
  for (const ring of [rings[0], rings[rings.length - 1]]) for (let k = 1; k + 1 < around; k++) add([ring[0], ring[k], ring[k + 1]], null);
  return found;
}

const three = vector => vector.map(value => figures(value, 4)).join(", ");

// Internal force and moment between two sections.
function insideRows(run, body, index, part) {
  const [force, moment] = [0, 3].map(from => mix(run.load(body, index).slice(from, from + 3), run.load(body, index + 1).slice(from, from + 3), part));
  return [["internal force", `${three(force)} N (N, Vy, Vz)`], ["internal moment", `${three(moment)} N·m (Mx, My, Mz)`]];
}

// Texts of a position on a body, computed again at every time.
function bodyPlace(run, body, index, part, point) {
  const about = run.about.bodies[body];
  const now = () => between(run, body, index, part);
  const rows = () => {
    const s = now(), load = elasticLoad(run, body, Math.round(index + part), s.measures);
    const found = [
      ["place", `${figures(about.places[index] + part * (about.places[index + 1] - about.places[index]))} m from the inner end`],
      ["axis at", `${s.at.map(c => compact(c, digitsFor(extents.size, 6))).join(", ")} m`],
      ...(modal ? [["displacement amplitude", `${figures(amplitudes[body][Math.round(index + part)])} m`]] : []),
      ["velocity", `${three(s.v)} m/s`],
      ["strain", `${compact(1e6 * strainAt(s.measures, point), digitsFor(1e6 * largest(FIELDS.strain), 4))} µm/m`],
      ["curvature", `${three(s.measures.slice(2))} 1/m (κy, κz)`],
      ["elastic moment", `${three(load.slice(1))} N·m (Mx, My, Mz)`],
      ...(about.loaded ? insideRows(run, body, index, part) : []),
    ];
    // a mode has no velocities and loads at an amplitude that is only drawn
    if (modal) return found.filter(([name]) => !["velocity", "elastic moment", "internal force", "internal moment"].includes(name));
    const loads = run.about.stations.map((station, i) => [i, station]).filter(([, station]) => station.body === body);
    if (loads.length) {
      const away = i => Math.hypot(...plus(vector(run.present, run.layout.stations + PER_STATION * i), s.at, -1));
      const [nearest, station] = loads.reduce((best, other) => (away(other[0]) < away(best[0]) ? other : best));
      const place = run.layout.stations + PER_STATION * nearest;
      found.push([station.name, `${three(vector(run.present, place + 3))} N`]);
      if (run.about.winds) found.push(["air there", `${three(vector(run.present, place + 9))} N`]);
    }
    return found;
  };
  const title = run === main ? about.name : `${about.name} (${run.label})`;
  const place = about.places.length > 1 ? about.places[index] + part * (about.places[index + 1] - about.places[index]) : 0;
  const key = run === main ? `body:${about.name},${Number(place.toPrecision(6))}` : null;
  return { title, rows, place: () => pointOf(now(), point), key, on: run === main ? { body, place } : null };
}
