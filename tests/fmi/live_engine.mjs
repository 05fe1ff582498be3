// Runs every model of the gallery in the engine as a page does, and prints what it found as JSON: live_engine.mjs FOLDER [REPEATS].
// Times in ms: `begun` from the text to its first step, `first` to the first picture, `all` from the text to the picture of the whole run, `processor` the same of the
// processor; the least of REPEATS.
import { readFileSync } from "node:fs";
import { join } from "node:path";

const [folder, repeats] = [process.argv[2], Number(process.argv[3] || 1)];
const models = new Function(`${readFileSync(join(folder, "models.js"), "utf8")}; return MODELS;`)();
const module = new WebAssembly.Module(readFileSync(join(folder, "foldwing.wasm")));
if (WebAssembly.Module.imports(module).length) throw Error("the module imports something");
const engine = new WebAssembly.Instance(module, {}).exports;
const FRAMES = 150, FIRST_MS = 1; // as in worker.js

const read = () => new TextDecoder().decode(new Uint8Array(engine.memory.buffer, engine.foldwing_answer(), engine.foldwing_answer_bytes()));
function begin(text) {
  const bytes = new TextEncoder().encode(text), place = engine.foldwing_text(bytes.length);
  new Uint8Array(engine.memory.buffer, place, bytes.length).set(bytes);
  return engine.foldwing_begin(FRAMES);
}
function picture() {
  engine.foldwing_pack();
  const about = JSON.parse(read());
  return { about, numbers: new Float32Array(engine.memory.buffer, engine.foldwing_numbers(), engine.foldwing_numbers_count()).slice() };
}

const found = {};
for (const { name, text } of models) {
  const times = [];
  for (let i = 0; i < repeats; i++) {
    const start = performance.now(), used = process.cpuUsage();
    if (begin(text) !== 0) throw Error(`${name}: ${read()}`);
    const begun = performance.now() - start;
    let state = 0, first = null;
    while (state === 0) {
      state = engine.foldwing_advance(1);
      if (first === null && (state !== 0 || performance.now() - start > begun + FIRST_MS)) { picture(); first = performance.now() - start; }
    }
    const last = picture(), all = performance.now() - start;
    const { user, system } = process.cpuUsage(used);
    engine.foldwing_summary();
    times.push({ begun, first, all, processor: (user + system) / 1000 });
    if (i + 1 < repeats && all * repeats < 20_000) continue;
    found[name] = {
      state, summary: JSON.parse(read()), frames: last.about.begins.length, numbers: last.numbers.length,
      ...Object.fromEntries(["begun", "first", "all", "processor"].map(key => [key, Math.min(...times.map(one => one[key]))])),
    };
    break;
  }
}
const refused = begin(models[0].text.replace("length_m", "lenght_m"));
console.log(JSON.stringify({ models: found, refused, refusal: JSON.parse(read()) }));
