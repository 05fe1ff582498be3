
// ---- lifting surfaces with their lattice, and the wake ---------------------------------------------------------------

// Quadrilaterals with corners of their own, so that each has its colour, or one at each corner.
function quads(count, material) {
  const geometry = new THREE.BufferGeometry(), faces = [];
  for (const name of ["position", "normal", "color"]) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(12 * count), 3));
  for (let q = 0; q < count; q++) faces.push(4 * q, 4 * q + 1, 4 * q + 2, 4 * q, 4 * q + 2, 4 * q + 3);
  geometry.setIndex(faces);
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  return mesh;
}
function setQuad(geometry, q, corners, rgb) {
  const [position, normal, colour] = ["position", "normal", "color"].map(name => geometry.getAttribute(name).array);
  const across = unit(cross(plus(corners[2], corners[0], -1), plus(corners[3], corners[1], -1)));
  corners.forEach((corner, k) => {
    const own = Array.isArray(rgb[0]) ? rgb[k] : rgb;
    for (let c = 0; c < 3; c++) {
      position[12 * q + 3 * k + c] = corner[c];
      normal[12 * q + 3 * k + c] = across[c];
      colour[12 * q + 3 * k + c] = own[c];
    }
  });
}
function sendQuads(geometry, count) {
  for (const name of ["position", "normal", "color"]) geometry.getAttribute(name).needsUpdate = true;
  geometry.setDrawRange(0, 6 * count);
  geometry.boundingSphere = null;
}

// Whether aerofoils are drawn around the surfaces; a spar that the model describes would be hidden, so that it is then off at the start.
const aerofoilsAtStart = !modal && about.aerofoils.some(Boolean) && !about.aerofoils.some(one => one?.hidesSpar);
const solid = () => get("aerofoils").checked;

// Slope at the leading edge relative to that of the first interval: the normal there points forward.
const NOSE = 6;

// Points of an aerofoil over a chord: positions along it, heights at every edge of the strips. Without heights: the chord line.
function aerofoilOf(run, index) {
  const own = run.about.aerofoils[index];
  if (!own) return null;
  // slope of the heights at a position, for smooth normals; steep at the nose
  const slopes = heights => heights.map((_, k) => {
    const [i, j] = [Math.max(0, k - 1), Math.min(heights.length - 1, k + 1)];
    return (k ? 1 : NOSE) * (heights[j] - heights[i]) / (own.stations[j] - own.stations[i]);
  });
  return { ...own, sides: [own.upper, own.lower].map(side => side.map(heights => ({ heights, slopes: slopes(heights) }))) };
}

// Selections of the positions along the chord for a strip, from all to few, each with the largest distance of its outline from that with all
// positions, as a fraction of the chord: positions where the outline is straightest are omitted first. Panels need all positions, since these
// are their edges.
function levelsOf({ stations, sides }, strip, panels) {
  const edges = sides.flatMap(side => [side[strip].heights, side[strip + 1].heights]);
  const gap = (a, b) => {
    let most = 0;
    for (const heights of edges) for (let k = a + 1; k < b; k++) {
      most = Math.max(most, Math.abs(heights[k] - heights[a] - (heights[b] - heights[a]) * (stations[k] - stations[a]) / (stations[b] - stations[a])));
    }
    return most;
  };
  const found = [{ level: stations.map((_, k) => k), error: 0 }];
  while (panels <= 1 && found[found.length - 1].level.length > 3) {
    const { level, error } = found[found.length - 1];
    const gaps = level.map((_, j) => (j && j < level.length - 1 ? gap(level[j - 1], level[j + 1]) : Infinity)), least = Math.min(...gaps), out = gaps.indexOf(least);
    found.push({ level: level.filter((_, j) => j !== out), error: Math.max(error, least) });
  }
  return found;
}
// Largest distance in pixels between the outline of an aerofoil and the drawn outline.
const UNSEEN_PIXELS = 0.2;

class SurfaceShape {
  constructor(run, index) {
    this.run = run;
    this.index = index;
    this.surface = run.about.surfaces[index];
    this.firstStrip = firstStripOf(run, index);
    this.aerofoil = aerofoilOf(run, index);
    this.levels = this.aerofoil && Array.from({ length: this.surface.columns - 1 }, (_, strip) => levelsOf(this.aerofoil, strip, this.surface.panels));
    // panels are painted one by one where their pressures are known
    this.rows = run === main && about.panelForces ? Math.max(1, this.surface.panels) : 1;
    const ghost = { color: runInk(run), transparent: true, opacity: 0.3, depthWrite: false, side: THREE.DoubleSide };
    const own = { vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    // per strip the quadrilaterals of both sides, then the ends, each of which is one per interval along the chord
    const around = this.aerofoil ? this.aerofoil.stations.length - 1 : 0, strips = this.surface.columns - 1;
    this.mesh = quads(Math.max(strips * this.rows, 2 * around * (strips + 1)), unshaded(new THREE.MeshLambertMaterial(run === main ? own : ghost)));
    this.mesh.castShadow = run === main;
    this.mesh.userData = { run, body: this.surface.body, describe: hit => this.describe(hit) };
    this.lattice = lines(new THREE.LineBasicMaterial({ transparent: true, opacity: run === main ? 0.55 : 0.25 }));
  }

  get isSolid() { return solid() && this.aerofoil !== null; }
  corner(column, edge) { return vector(this.run.present, this.run.layout.surfaces[this.index] + 6 * column + 3 * edge); }
  circulation(strip) { return this.run.present[this.run.layout.strips + this.firstStrip + strip]; }

  // Colour of the corner of a panel.
  rgbOf(strip, row, column, most, plain) {
    const value = surfaceField.of(this.run, this.index, strip, row, column), rgb = [0, 0, 0];
    if (!Number.isFinite(value)) return plain;
    tint(surfaceField.map, share(value, most), rgb, 0);
    return rgb;
  }

  update() {
    const { run } = this, plain = new THREE.Color(inks.surface).toArray();
    const painted = run === main && surfaceField.of, most = painted ? surfaceRange() : 1;
    // the lift belongs to the edges of the strips, between which it is interpolated; all other fields belong to strips or panels
    const colours = painted ? (strip, row, column) => this.rgbOf(strip, row, column, most, plain) : () => plain;
    if (this.isSolid) this.updateSolid(colours); else this.updateSheet(colours);
    if (run === main) {
      const glass = get("glass").checked, { material } = this.mesh;
      // of a closed surface only the outside is visible, if it is transparent also the inside
      const side = this.isSolid && !glass ? THREE.FrontSide : THREE.DoubleSide;
      if (material.side !== side) Object.assign(material, { side, needsUpdate: true });
      if (material.transparent !== glass) {
        Object.assign(material, { transparent: glass, opacity: glass ? 0.35 : 1, depthWrite: !glass, needsUpdate: true });
      }
    }
    this.lattice.material.color.set(run === main ? inks.edge : runInk(run));
  }

  updateSheet(colours) {
    const { surface, rows, mesh } = this, fades = surfaceField === SURFACE_FIELDS.lift;
    let ends = null;
    for (let c = 0; c + 1 < surface.columns; c++) {
      if (fades) ends = [ends ? ends[1] : colours(c, 0, c), colours(c, 0, c + 1)];
      const [a, b, d, e] = [this.corner(c, 0), this.corner(c + 1, 0), this.corner(c + 1, 1), this.corner(c, 1)];
      for (let row = 0; row < rows; row++) {
        const [front, back] = [row / rows, (row + 1) / rows];
        const rgb = fades ? [ends[0], ends[1], ends[1], ends[0]] : colours(c, row, c);
        setQuad(mesh.geometry, c * rows + row, [mix(a, e, front), mix(b, d, front), mix(b, d, back), mix(a, e, back)], rgb);
      }
    }
    sendQuads(mesh.geometry, (surface.columns - 1) * rows);
    const points = [], whole = get("lattice").checked, chordwise = whole ? Math.max(1, surface.panels) : 1;
    for (let c = 0; c < surface.columns; c++) {
      if (whole || c === 0 || c === surface.columns - 1) points.push(this.corner(c, 0), this.corner(c, 1));
      if (c) for (let k = 0; k <= chordwise; k++) {
        points.push(mix(this.corner(c - 1, 0), this.corner(c - 1, 1), k / chordwise), mix(this.corner(c, 0), this.corner(c, 1), k / chordwise));
      }
    }
    setPoints(this.lattice, points);
  }

  // The fewest positions along the chord with which a strip looks the same as with all of them at the current distance of the camera.
  levelOf(strip) {
    const chord = Math.max(...[strip, strip + 1].map(c => Math.hypot(...plus(this.corner(c, 1), this.corner(c, 0), -1))));
    const pixels = chord * pixelsPerMetre() * Math.min(window.devicePixelRatio || 1, 2);
    return this.levels[strip].findLast(({ error }) => error * pixels <= UNSEEN_PIXELS).level;
  }

  // Points and normals of the aerofoil at an edge of the strips, per side, as flat lists: shapes change in every picture.
  edgeOf(column, into) {
    const { surface, aerofoil: { stations, sides } } = this, [before, after] = [Math.max(0, column - 1), Math.min(surface.columns - 1, column + 1)];
    const nose = this.corner(column, 0), chord = plus(this.corner(column, 1), nose, -1), length = Math.hypot(...chord) || 1e-30;
    const span = plus(plus(this.corner(after, 0), this.corner(before, 0), -1), plus(this.corner(after, 1), this.corner(before, 1), -1));
    const across = unit(cross(chord, span));
    for (let side = 0; side < 2; side++) {
      const { heights, slopes } = sides[side][column], { points, normals } = into[side], out = side ? -1 : 1;
      for (let k = 0; k < stations.length; k++) {
        const size = out / Math.hypot(1, slopes[k]);
        for (let i = 0; i < 3; i++) {
          points[3 * k + i] = nose[i] + stations[k] * chord[i] + heights[k] * length * across[i];
          normals[3 * k + i] = size * (across[i] - slopes[k] * chord[i] / length);
        }
      }
    }
    return into;
  }

  updateSolid(colours) {
    const { surface, rows, mesh: { geometry }, aerofoil: { stations } } = this, fades = surfaceField === SURFACE_FIELDS.lift;
    const count = stations.length, strips = surface.columns - 1;
    this.edges ??= Array.from({ length: surface.columns }, () => [0, 1].map(() => ({ points: new Float32Array(3 * count), normals: new Float32Array(3 * count) })));
    const edges = this.edges.map((edge, c) => this.edgeOf(c, edge));
    const [position, normal, colour] = ["position", "normal", "color"].map(name => geometry.getAttribute(name).array);
    const rowOf = k => Math.min(rows - 1, Math.floor(0.5 * (stations[k] + stations[k + 1]) * rows));
    // one colour per edge of the strips, or per panel
    const tones = fades ? edges.map((_, c) => colours(Math.min(c, strips - 1), 0, c)) : Array.from({ length: strips }, (_, c) => Array.from({ length: rows }, (_, row) => colours(c, row, c)));
    let next = 0;
    const corner = ({ points, normals }, k, rgb, flat) => {
      for (let i = 0; i < 3; i++) {
        position[next + i] = points[3 * k + i];
        normal[next + i] = flat ? flat[i] : normals[3 * k + i];
        colour[next + i] = rgb[i];
      }
      next += 3;
    };
    this.begins = []; // of the quadrilaterals of the strips
    for (let c = 0; c < strips; c++) {
      const level = this.levelOf(c);
      this.begins.push(next / 12);
      for (let side = 0; side < 2; side++) for (let n = 0; n + 1 < level.length; n++) {
        // counter-clockwise from outside, since the renderer reverses the normals of faces whose back is visible
        const [i, j] = side ? [c, c + 1] : [c + 1, c], [a, b] = [edges[i][side], edges[j][side]], [k, l] = [level[n], level[n + 1]];
        const [one, other] = fades ? [tones[i], tones[j]] : [tones[c][rowOf(k)], tones[c][rowOf(k)]];
        corner(a, k, one);
        corner(b, k, other);
        corner(b, l, other);
        corner(a, l, one);
      }
    }
    this.begins.push(next / 12);
    // flat ends
    for (const [c, strip, way] of [[0, 0, -1], [strips, strips - 1, 1]]) for (let k = 0; k + 1 < count; k++) {
      const [upper, lower] = edges[c], rgb = fades ? tones[c] : tones[strip][rowOf(k)];
      const [nose, tail] = [0, count - 1].map(at => vector(upper.points, 3 * at)), [above, below] = [upper, lower].map(({ points }) => vector(points, 3 * (count >> 1)));
      const flat = unit(cross(plus(above, below, -1), plus(tail, nose, -1))).map(x => -way * x);
      const order = way > 0 ? [[upper, k], [upper, k + 1], [lower, k + 1], [lower, k]] : [[lower, k], [lower, k + 1], [upper, k + 1], [upper, k]];
      for (const [side, at] of order) corner(side, at, rgb, flat);
    }
    sendQuads(geometry, next / 12);
    // the lattice on both sides: edges of the strips along the chord, edges of the panels along the span
    const whole = get("lattice").checked, panels = whole ? Math.max(1, surface.panels) : 1;
    const onPanel = stations.map(x => Math.abs(x * panels - Math.round(x * panels)) < 1e-4);
    const points = [];
    edges.forEach((edge, c) => edge.forEach(({ points: own }, side) => {
      let last = null;
      for (let k = 0; k < count; k++) {
        const at = vector(own, 3 * k);
        if (k && (whole || c === 0 || c === strips)) points.push(last, at);
        if (c && onPanel[k]) points.push(vector(edges[c - 1][side].points, 3 * k), at);
        last = at;
      }
    }));
    setPoints(this.lattice, points);
  }

  // Strip of a face of the mesh.
  stripOf(face) {
    const { surface, rows, begins } = this, quad = Math.floor(face / 2), strips = surface.columns - 1;
    if (!this.isSolid) return Math.floor(quad / rows);
    const ends = quad - begins[strips], strip = begins.findLastIndex(begin => begin <= quad);
    return ends < 0 ? strip : ends < this.aerofoil.stations.length - 1 ? 0 : strips - 1;
  }

  describe(hit) {
    const strip = this.stripOf(hit.faceIndex), at = [hit.point.x, hit.point.y, hit.point.z];
    const { run, surface, index } = this, body = run.about.bodies[surface.body].name;
    const [inner, outer] = [0, 1].map(i => mix(this.corner(strip + i, 0), this.corner(strip + i, 1), 0.5)), way = plus(outer, inner, -1);
    const along = Math.max(0, Math.min(1, dot(plus(at, inner, -1), way) / Math.max(dot(way, way), 1e-30)));
    const edge = e => mix(this.corner(strip, e), this.corner(strip + 1, e), along), chord = plus(edge(1), edge(0), -1);
    const across = Math.max(0, Math.min(1, dot(plus(at, edge(0), -1), chord) / Math.max(dot(chord, chord), 1e-30)));
    const place = () => mix(edge(0), edge(1), across);
    const rows = () => {
      const found = [
        ["strip", `${strip + 1} of ${surface.columns - 1}, at ${compact(100 * across, 0)} % of the chord`],
        ["point at", `${place().map(c => compact(c, digitsFor(extents.size, 5))).join(", ")} m`],
        ["chord there", `${figures(Math.hypot(...plus(edge(1), edge(0), -1)))} m`],
      ];
      if (run.about.strips) found.push(["circulation", `${figures(this.circulation(strip))} m²/s`]);
      if (!modal && run.about.edgeForces) found.push(["lift per span", `${figures(mix([liftAt(run, index, strip)], [liftAt(run, index, strip + 1)], along)[0])} N/m`]);
      if (!modal && run.about.panelForces) {
        const row = Math.min(surface.panels - 1, Math.floor(across * surface.panels));
        found.push(["pressure jump", `${figures(pressureAt(run, index, strip, row))} Pa`]);
      }
      return found;
    };
    return { title: `surface of ${body}`, rows, place };
  }
}

// Largest number of rings of the wake in a frame.
const ringsOf = ({ rows, wakes }) => Math.max(0, ...rows.map(counts => counts.reduce((sum, count, i) => sum + count * (wakes[i] - 1), 0)));
const mostRings = ringsOf(about);
const wakeQuads = count => quads(count, new THREE.MeshBasicMaterial({
  vertexColors: true, transparent: true, opacity: 0.62, depthWrite: false, side: THREE.DoubleSide, forceSinglePass: true }));
let wakeMesh = mostRings || ((live || again) && about.wakes.length) ? wakeQuads(mostRings || 64) : null;
// The wake of a live simulation grows, and may be longer in the next run of a page with an editor.
function makeWakeRoom(rings) {
  if (12 * rings <= wakeMesh.geometry.getAttribute("position").array.length) return;
  scene.remove(wakeMesh);
  wakeMesh.geometry.dispose();
  wakeMesh = wakeQuads(2 * rings);
  scene.add(wakeMesh);
}
function updateWake() {
  if (!wakeMesh) return;
  if (live) makeWakeRoom(main.wakes(Math.floor(main.position)).reduce((sum, { rows, columns }) => sum + rows * (columns - 1), 0));
  wakeMesh.visible = get("wake").checked && main.shown;
  wakeReach = 0;
  if (!wakeMesh.visible) return;
  const rgb = [0, 0, 0];
  let count = 0;
  for (const { nodes, rings, rows, columns } of main.wakes(Math.floor(main.position))) {
    const node = (row, column) => vector(main.numbers, nodes + 3 * (row * columns + column));
    for (let r = 0; r < rows; r++) for (let c = 0; c + 1 < columns; c++) {
      tint(WAKE_MAP, share(main.numbers[rings + r * (columns - 1) + c], circulationRange()), rgb, 0);
      setQuad(wakeMesh.geometry, count++, [node(r, c), node(r, c + 1), node(r + 1, c + 1), node(r + 1, c)], rgb);
    }
    wakeReach = Math.max(wakeReach, Math.hypot(...plus(node(rows, 0), node(0, 0), -1)));
  }
  sendQuads(wakeMesh.geometry, count);
}
