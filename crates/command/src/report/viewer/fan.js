
// ---- the runs of a sweep: the axes of their bodies as lines, and bands of their values in the plots ---------------------------

const fan = (element => element && { ...JSON.parse(element.textContent), numbers: numbersOf(element.nextElementSibling.textContent) })(document.querySelector("script.fan"));
const fanPoints = fan ? fan.points.reduce((a, b) => a + b, 0) : 0;
const fanTimes = fan ? Array.from(fan.numbers.subarray(0, fan.times)) : [];

// Position of a run on the scale, from 0 to 1: by the value of the first quantity that varies, if it is a number, otherwise by the order of the runs.
const fanShares = (() => {
  if (!fan) return [];
  const key = fan.keys.findIndex((_, k) => new Set(fan.labels.map(values => values[k])).size > 1), values = fan.labels.map(label => Number(label[Math.max(0, key)]));
  if (key < 0 || !values.every(Number.isFinite)) return fan.labels.map((_, i) => i / Math.max(1, fan.labels.length - 1));
  const [least, most] = [Math.min(...values), Math.max(...values)];
  fan.scale = { name: fan.keys[key], least, most };
  return values.map(value => (most > least ? (value - least) / (most - least) : 0.5));
})();

// All lines are one object: one draw call for any number of runs.
const fanLines = fan ? lines(new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.55, depthWrite: false })) : null;
function buildFan() {
  if (!fan) return;
  const segments = fan.points.reduce((sum, count) => sum + Math.max(0, count - 1), 0) * fan.labels.length;
  const colours = new Float32Array(6 * segments), rgb = [0, 0, 0];
  let next = 0;
  for (const part of fanShares) {
    tint(RISING, part, rgb, 0);
    for (const count of fan.points) for (let i = 0; i < 2 * Math.max(0, count - 1); i++, next += 3) colours.set(rgb, next);
  }
  fanLines.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6 * segments), 3));
  fanLines.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  scene.add(fanLines);
  addScale("fan-scale");
  const { name, least, most } = fan.scale || { name: "run", least: 1, most: fan.labels.length };
  setScale(get("fan-scale"), `${name}, ${fan.labels.length} of ${fan.count} runs`, RISING, [least, (least + most) / 2, most], value => figures(value, 3));
}

// Offset of a point of a run in the numbers at a time.
const fanPlace = (run, time, point) => fan.times + 3 * ((run * fan.times + time) * fanPoints + point);

function updateFan() {
  if (!fan) return;
  fanLines.visible = get("fan").checked;
  if (!fanLines.visible) return;
  const time = main.timeAt(main.position), before = Math.min(indexAt(fanTimes, time), fan.times - 1), after = Math.min(before + 1, fan.times - 1);
  const span = fanTimes[after] - fanTimes[before], part = span > 0 ? Math.max(0, Math.min(1, (time - fanTimes[before]) / span)) : 0;
  const { array } = fanLines.geometry.getAttribute("position"), { numbers } = fan;
  let next = 0;
  const put = (run, point) => {
    const [a, b] = [fanPlace(run, before, point), fanPlace(run, after, point)];
    for (let c = 0; c < 3; c++) array[next++] = numbers[a + c] + part * (numbers[b + c] - numbers[a + c]);
  };
  for (let run = 0; run < fan.labels.length; run++) {
    let first = 0;
    for (const count of fan.points) {
      for (let i = 0; i + 1 < count; i++) { put(run, first + i); put(run, first + i + 1); }
      first += count;
    }
  }
  fanLines.geometry.getAttribute("position").needsUpdate = true;
}

// Curves of the bands of a signal, from the smallest to the largest: values at the times of the sweep.
function bandsOf(name) {
  const signal = fan && get("fan").checked ? fan.signals.indexOf(name) : -1;
  if (signal < 0) return [];
  const from = fan.times + 3 * fanPoints * fan.times * fan.labels.length + signal * fan.times * fan.fractions.length, { factor } = signals.get(name);
  return fan.fractions.map((fraction, k) => ({
    fraction, name, time: fanTimes, values: fanTimes.map((_, i) => factor * fan.numbers[from + i * fan.fractions.length + k]),
    label: `${name} (${k === 0 ? "smallest" : fraction === 1 ? "largest" : `${100 * fraction} %`} of ${fan.like} runs)`,
  }));
}
