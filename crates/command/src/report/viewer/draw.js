
// ---- drawing: faces from the back to the front, then lines and dots ------------------------------------------------

const canvas = document.getElementById("view");
const pen = canvas.getContext("2d");
const styleOf = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
let inks = {};
function readInks() {
  for (const name of ["grid", "edge", "surface", "text", "faint", "accent"]) inks[name] = styleOf(`--${name}`);
}

function facesOfBodies() {
  const faces = [];
  about.bodies.forEach((body, b) => {
    const sections = body.rims.map((_, i) => section(present, 0, b, i));
    const rims = sections.map((s, i) => body.rims[i].map(point => pointOf(s, point)));
    const strains = sections.map((s, i) => body.rims[i].map(point => strainAt(s, point)));
    const around = body.rims[0].length;
    for (let i = 0; i + 1 < rims.length; i++) for (let j = 0; j < around; j++) {
      const k = (j + 1) % around;
      const strain = (strains[i][j] + strains[i][k] + strains[i + 1][k] + strains[i + 1][j]) / 4;
      faces.push({ points: [rims[i][j], rims[i][k], rims[i + 1][k], rims[i + 1][j]], colour: colour(STRAIN_MAP, strain, extents.strain), lit: true });
    }
    for (const end of [0, rims.length - 1]) faces.push({ points: rims[end], colour: [150, 160, 170], lit: true });
  });
  return faces;
}

function facesOfSurfaces() {
  const faces = [];
  about.surfaces.forEach((columns, s) => {
    const corner = (column, edge) => vector(present, layout.surfaces[s] + 6 * column + 3 * edge);
    for (let c = 0; c + 1 < columns; c++) {
      faces.push({ points: [corner(c, 0), corner(c + 1, 0), corner(c + 1, 1), corner(c, 1)], fill: inks.surface, alpha: 0.35, line: inks.edge, behind: 0.03 * extents.size });
    }
  });
  return faces;
}

function facesOfWake(frame) {
  const faces = [];
  for (const { nodes, rings } of wakeOf(frame)) rings.forEach((row, r) => row.forEach((circulation, c) => {
    faces.push({
      points: [nodes[r][c], nodes[r][c + 1], nodes[r + 1][c + 1], nodes[r + 1][c]],
      fill: css(colour(WAKE_MAP, circulation, extents.circulation)), alpha: 0.6,
    });
  }));
  return faces;
}

function paintFace({ points, colour: tint, fill, alpha = 1, line, lit, places }) {
  if (lit) {
    const normal = unit(cross(plus(points[1], points[0], -1), plus(points[points.length - 2], points[0], -1)));
    const light = 0.72 + 0.28 * Math.abs(dot(normal, unit(plus(camera.axes[2], camera.axes[1], 0.6))));
    fill = css(tint.map(c => c * light));
  }
  pen.beginPath();
  places.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.closePath();
  pen.globalAlpha = alpha;
  pen.fillStyle = fill;
  pen.fill();
  pen.strokeStyle = line || fill; // closes the seams between neighbours
  pen.lineWidth = line ? 0.6 * pixelRatio() : 0.7;
  pen.stroke();
  pen.globalAlpha = 1;
}

function paintLine(points, ink, width, dash = []) {
  pen.beginPath();
  let down = false;
  for (const place of points.map(project)) {
    if (!place) { down = false; continue; }
    if (down) pen.lineTo(place[0], place[1]); else pen.moveTo(place[0], place[1]);
    down = true;
  }
  pen.strokeStyle = ink;
  pen.lineWidth = width * pixelRatio();
  pen.setLineDash(dash.map(length => length * pixelRatio()));
  pen.stroke();
  pen.setLineDash([]);
}

function paintDot(point, radius, fill) {
  const place = project(point);
  if (!place) return;
  pen.beginPath();
  pen.arc(place[0], place[1], radius * pixelRatio(), 0, 2 * Math.PI);
  pen.fillStyle = fill;
  pen.fill();
  pen.strokeStyle = inks.text;
  pen.lineWidth = 1.2 * pixelRatio();
  pen.stroke();
}

function paintText(point, text, ink) {
  const place = project(point);
  if (!place) return;
  pen.font = `${13 * pixelRatio()}px system-ui, "DejaVu Sans", sans-serif`;
  pen.fillStyle = ink;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(text, place[0], place[1]);
}

// A grid below the wing, with a round spacing, and the axes of the root frame.
function paintGround() {
  const spacing = 10 ** Math.round(Math.log10(extents.size / 6));
  const [from, to] = [0, 1].map(end => [0, 1].map(i => {
    const reach = (end ? extents.most[i] : extents.least[i]) + (end ? 0.25 : -0.25) * extents.size;
    return (end ? Math.ceil : Math.floor)(reach / spacing) * spacing;
  }));
  const floor = extents.least[2] - 0.08 * extents.size;
  for (let x = from[0]; x <= to[0] + spacing / 2; x += spacing) paintLine([[x, from[1], floor], [x, to[1], floor]], inks.grid, 1);
  for (let y = from[1]; y <= to[1] + spacing / 2; y += spacing) paintLine([[from[0], y, floor], [to[0], y, floor]], inks.grid, 1);
}

function paintAxes() {
  const length = 0.14 * extents.size;
  ["x", "y", "z"].forEach((name, i) => {
    const end = [0, 1, 2].map(j => (i === j ? length : 0));
    paintLine([[0, 0, 0], end], inks.faint, 1.6);
    paintText(end.map(c => 1.18 * c), name, inks.faint);
  });
}

// Paths of the outer ends of all bodies.
function paintTraces(position) {
  about.bodies.forEach((body, b) => {
    const points = [];
    for (let frame = 0; frame <= position; frame++) points.push(section(numbers, about.begins[frame], b, body.rims.length - 1).at);
    points.push(section(present, 0, b, body.rims.length - 1).at);
    paintLine(points, inks.accent, 1.1, [4, 3]);
  });
}

let restarts = true; // whether the camera takes the wing as its target anew

const pixelRatio = () => window.devicePixelRatio || 1;

function paint(position, { wake, trace }) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map(length => Math.max(1, Math.round(length * pixelRatio())));
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  goTo(position);
  if (follows()) follow(restarts);
  restarts = false;
  pen.clearRect(0, 0, width, height);
  paintGround();
  const faces = [...facesOfBodies(), ...facesOfSurfaces(), ...(wake ? facesOfWake(Math.floor(position)) : [])];
  for (const face of faces) {
    face.places = face.points.map(project);
    // what lies in a body's own plane is drawn before the body
    face.depth = (face.behind || 0) + face.places.reduce((sum, place) => sum + (place ? place[2] : Infinity), 0) / face.points.length;
  }
  const seen = faces.filter(face => Number.isFinite(face.depth)).sort((a, b) => b.depth - a.depth);
  for (const face of seen) paintFace(face);
  paintAxes();
  if (trace) paintTraces(position);
  about.bodies.forEach((body, b) => { if (body.joint) paintDot(section(present, 0, b, 0).at, 4, inks.accent); });
  about.gauges.forEach((_, i) => {
    paintDot(vector(present, layout.gauges + 3 * i), 5, css(colour(STRAIN_MAP, present[layout.strains + i], extents.strain)));
  });
}
