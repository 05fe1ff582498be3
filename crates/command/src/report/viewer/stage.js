
// ---- the stage: renderer, light and soft shadow, ground with its scale, axes -----------------------------------------

if (modal) fillCycle();
const extents = live ? extentsOfAll() : extentsOf(main);
const canvas = get("view");
const styleOf = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const WIDTH = Math.max(extents.wing, 1e-6);

// Checked before the library starts, which writes to the console if WebGL is missing.
const hasWebGL = Boolean(again?.renderer) || (() => {
  const probe = document.createElement("canvas").getContext("webgl2");
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return probe !== null;
})();

const scene = new THREE.Scene();
const sun = new THREE.DirectionalLight(0xffffff, 1.5);
const renderer = again?.renderer || (hasWebGL ? makeRenderer() : null);

function makeRenderer() {
  THREE.ColorManagement.enabled = false; // displayed colours equal those of the scales
  const made = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
  made.outputColorSpace = THREE.LinearSRGBColorSpace;
  made.shadowMap.enabled = true;
  made.shadowMap.type = THREE.PCFShadowMap;
  return made;
}

const ground = new THREE.Group();
const floorZ = extents.least[2] - 0.06 * extents.size;
const gridLines = lines(new THREE.LineBasicMaterial({ transparent: true, opacity: 0.9 }));
const shade = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), shaded(new THREE.ShadowMaterial({ depthWrite: false })));
let grounds = null; // ends of the grid along x and y
const gridLabels = [];

// A material for surfaces on which no shadow falls. Without a GPU the lookup in the shadow map takes its time also where its result is not used.
function unshaded(material) {
  material.onBeforeCompile = withoutShadows;
  return material;
}
// A material on which shadows fall, with the five samples of the library turned by one sine and cosine instead of five of each.
function shaded(material) {
  material.onBeforeCompile = withQuickShadows;
  return material;
}
// Points of the library's spiral, r = √((i + 1/2)/5) at the angle of i golden angles.
const SPIRAL = Array.from({ length: 5 }, (_, i) => [Math.cos, Math.sin].map(part => (Math.sqrt((i + 0.5) / 5) * part(2.399963229728653 * i)).toFixed(9)));
const QUICK_SHADOW = `
#if defined( USE_SHADOWMAP ) && defined( SHADOWMAP_TYPE_PCF )
  float quickShadow( sampler2DShadow map, vec2 size, float intensity, float bias, float radius, vec4 coord ) {
    vec3 at = coord.xyz / coord.w + vec3( 0.0, 0.0, bias );
    if ( any( lessThan( at.xy, vec2( 0.0 ) ) ) || any( greaterThan( at, vec3( 1.0 ) ) ) ) return 1.0;
    float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
    vec2 turn = vec2( cos( phi ), sin( phi ) );
    mat2 turned = mat2( turn.x, turn.y, - turn.y, turn.x );
    float lit = ${SPIRAL.map(([x, y]) => `texture( map, vec3( at.xy + turned * vec2( ${x}, ${y} ) * radius / size, at.z ) )`).join(" + ")};
    return mix( 1.0, 0.2 * lit, intensity );
  }
  #define getShadow quickShadow
#endif
`;
function withQuickShadows(shader) {
  const own = "#include <shadowmap_pars_fragment>";
  shader.fragmentShader = shader.fragmentShader.replace(own, own + QUICK_SHADOW);
}
function withoutShadows(shader) {
  for (const part of ["vertexShader", "fragmentShader"]) shader[part] = `#undef USE_SHADOWMAP\n${shader[part]}`;
}

// Line segments; `setPoints` sets their points.
function lines(material) {
  const found = new THREE.LineSegments(new THREE.BufferGeometry(), material);
  found.frustumCulled = false;
  return found;
}
function setPoints(object, points) {
  const flat = new Float32Array(points.flat());
  const old = object.geometry.getAttribute("position");
  if (old && old.array.length >= flat.length) { old.array.set(flat); old.needsUpdate = true; } else {
    object.geometry.dispose();
    object.geometry.setAttribute("position", new THREE.BufferAttribute(flat, 3));
  }
  object.geometry.setDrawRange(0, points.length);
}

// Textures of labels, which the next run in the page reuses.
const textPictures = again?.textPictures || new Map();
function textPicture(text, pixels) {
  const key = `${pixels} ${text}`;
  if (textPictures.has(key)) return textPictures.get(key);
  const drawn = document.createElement("canvas"), pen = drawn.getContext("2d");
  const font = `${3 * pixels}px system-ui, "DejaVu Sans", sans-serif`;
  pen.font = font;
  drawn.width = Math.ceil(pen.measureText(text).width) + 8;
  drawn.height = Math.ceil(3.9 * pixels);
  pen.font = font;
  pen.fillStyle = "#fff";
  pen.textBaseline = "middle";
  pen.fillText(text, 4, drawn.height / 2);
  const map = new THREE.CanvasTexture(drawn);
  Object.assign(map, { generateMipmaps: false, minFilter: THREE.LinearFilter });
  textPictures.set(key, map);
  return map;
}

// A label that faces the camera, with a height in pixels of the page.
function sign(text, pixels = 13) {
  const map = textPicture(text, pixels);
  const material = new THREE.SpriteMaterial({ map, transparent: true, depthTest: true, depthWrite: false });
  const found = new THREE.Sprite(material);
  found.userData = { aspect: map.image.width / map.image.height, pixels: 1.3 * pixels };
  return found;
}
const signs = [];

// A grid below the machine with a round spacing, numbered in metres.
function buildGround() {
  const raw = extents.size / 7, power = 10 ** Math.floor(Math.log10(raw));
  const spacing = power * [1, 2, 5, 10].find(step => step * power >= raw * 0.999);
  const [from, to] = [0, 1].map(end => [0, 1].map(i => {
    const reach = (end ? extents.most[i] : extents.least[i]) + (end ? 0.04 : -0.04) * extents.size;
    return (end ? Math.ceil : Math.floor)(reach / spacing - 1e-9) * spacing;
  }));
  const points = [], digits = Math.max(0, -Math.floor(Math.log10(spacing) + 1e-9));
  const label = (value, at, last) => {
    const made = sign(compact(value, digits) + (last ? " m" : ""), 11);
    made.position.set(...at);
    gridLabels.push(made);
    ground.add(made);
  };
  for (let x = from[0]; x <= to[0] + spacing / 2; x += spacing) {
    points.push([x, from[1], floorZ], [x, to[1], floorZ]);
    label(x, [x, from[1] - 0.3 * spacing, floorZ], x > to[0] - spacing / 2);
  }
  for (let y = from[1]; y <= to[1] + spacing / 2; y += spacing) {
    points.push([from[0], y, floorZ], [to[0], y, floorZ]);
    label(y, [to[0] + 0.3 * spacing, y, floorZ], y > to[1] - spacing / 2);
  }
  setPoints(gridLines, points);
  signs.push(...gridLabels);
  grounds = [0, 1].map(i => [from[i], to[i]]);
  shade.position.set((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, floorZ - 1e-4 * extents.size);
  shade.scale.set(to[0] - from[0], to[1] - from[1], 1);
  shade.receiveShadow = true;
  ground.add(gridLines, shade);
  scene.add(ground);
}

// The axes of the root frame.
const axes = new THREE.Group();
const axisLines = lines(new THREE.LineBasicMaterial({ vertexColors: true }));
const AXIS_INKS = [[0.84, 0.24, 0.18], [0.16, 0.6, 0.24], [0.16, 0.4, 0.85]];
function buildAxes() {
  const length = 0.14 * WIDTH, points = [], colours = [];
  ["x", "y", "z"].forEach((name, i) => {
    const end = [0, 1, 2].map(j => (i === j ? length : 0));
    points.push([0, 0, 0], end);
    colours.push(...AXIS_INKS[i], ...AXIS_INKS[i]);
    const label = sign(name, 14);
    label.material.color.setRGB(...AXIS_INKS[i]);
    label.position.set(...end.map(c => 1.15 * c));
    label.userData.own = true;
    label.material.depthTest = false;
    signs.push(label);
    axes.add(label);
  });
  setPoints(axisLines, points);
  axisLines.geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colours), 3));
  axes.add(axisLines);
  scene.add(axes);
}

function buildLights() {
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  sun.shadow.radius = 3;
  sun.shadow.bias = -4e-4;
  scene.add(sun, sun.target, new THREE.HemisphereLight(0xffffff, 0xb8c0c8, 1.75));
}

// The light moves with the machine, so that the resolution of its shadow is constant.
function aimSun(middle, radius) {
  const [x, y, z] = middle;
  sun.target.position.set(x, y, z);
  sun.position.set(x + 0.5 * radius, y - 0.9 * radius, z + 2.2 * radius);
  const eye = sun.shadow.camera, depth = Math.max(z - floorZ, 0) + 2 * radius;
  Object.assign(eye, { left: -1.3 * radius, right: 1.3 * radius, top: 1.3 * radius, bottom: -1.3 * radius, near: 0.05 * radius, far: 2.6 * radius + depth });
  sun.shadow.normalBias = 0.004 * radius;
  eye.updateProjectionMatrix();
}

// Computes shadows only where they can fall: elsewhere the pixels would be transparent, and each of them costs a lookup in the shadow map.
function clipShade(radius) {
  const points = machinePoints(), way = plus(sun.target.position.toArray(), sun.position.toArray(), -1), margin = 0.05 * radius;
  const fallen = points.map(p => plus(p, way, (floorZ - p[2]) / way[2]));
  const ends = [0, 1].map(i => {
    const own = fallen.map(p => p[i]);
    return [Math.max(grounds[i][0], Math.min(...own) - margin), Math.min(grounds[i][1], Math.max(...own) + margin)];
  });
  shade.visible = ends.every(([low, high]) => low < high);
  shade.position.set((ends[0][0] + ends[0][1]) / 2, (ends[1][0] + ends[1][1]) / 2, shade.position.z);
  shade.scale.set(ends[0][1] - ends[0][0], ends[1][1] - ends[1][0], 1);
}

// Colours of the page's theme.
let inks = {};
function readInks() {
  for (const name of ["panel", "grid", "edge", "surface", "text", "faint", "accent", "body"]) inks[name] = styleOf(name);
  paintInks();
}
function paintInks() {
  scene.background = new THREE.Color(inks.panel);
  gridLines.material.color.set(inks.grid);
  shade.material.opacity = document.documentElement.dataset.dark === "true" ? 0.5 : 0.22;
  for (const label of signs) if (!label.userData.own) label.material.color.set(inks.faint);
}
