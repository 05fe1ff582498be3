// ---- worker with the engine: receives texts, sends pictures; the run of an outdated text is abandoned ----------------------------

// A run shows its beginning after this time (ms) of steps, and more of it whenever the elapsed time has grown by the factor.
const FIRST_MS = 1, LATER = 4;
// Duration (ms) of the later slices; between slices the worker checks for a new text.
const SLICE_MS = 4;
// Maximum number of frames of a picture after the first.
const FRAMES = 150;

let module = null, engine = null, wanted = null, busy = false;

function read() {
  return new TextDecoder().decode(new Uint8Array(engine.memory.buffer, engine.foldwing_answer(), engine.foldwing_answer_bytes()));
}
function begin(text) {
  const bytes = new TextEncoder().encode(text);
  const place = engine.foldwing_text(bytes.length);
  new Uint8Array(engine.memory.buffer, place, bytes.length).set(bytes);
  return engine.foldwing_begin(FRAMES) === 0;
}
const start = async () => { engine = (await WebAssembly.instantiate(module)).exports; };

// Yields to the event loop, so that messages are received.
const bell = new MessageChannel();
const turn = () => new Promise(done => { bell.port1.onmessage = done; bell.port2.postMessage(0); });

function send(task, began, done) {
  engine.foldwing_summary();
  const summary = JSON.parse(read());
  engine.foldwing_pack();
  const about = read();
  const numbers = new Float32Array(engine.memory.buffer, engine.foldwing_numbers(), engine.foldwing_numbers_count()).slice();
  postMessage({ kind: "picture", id: task.id, done, about, numbers, summary, ms: performance.now() - began }, [numbers.buffer]);
}

async function run(task) {
  const began = performance.now();
  if (!begin(task.text)) {
    postMessage({ kind: "refused", id: task.id, ...JSON.parse(read()), ms: performance.now() - began });
    return;
  }
  let state = 0, next = 0, slice = FIRST_MS;
  while (state === 0) {
    const until = performance.now() + slice;
    do state = engine.foldwing_advance(1); while (state === 0 && performance.now() < until);
    if (state === 0 && performance.now() > next) {
      send(task, began, false);
      next = began + LATER * (performance.now() - began);
    }
    slice = SLICE_MS;
    await turn();
    if (wanted) return;
  }
  send(task, began, true);
}

async function work() {
  busy = true;
  while (wanted) {
    const task = wanted;
    wanted = null;
    try {
      await run(task);
    } catch (error) {
      // the instance is unusable after a fault; the next text uses a new one
      postMessage({ kind: "refused", id: task.id, marks: [], message: `The engine stopped: ${error.message}. Please report this model.` });
      await start();
    }
  }
  busy = false;
}

onmessage = async ({ data }) => {
  if (data.engine) {
    module = await WebAssembly.compile(data.engine);
    await start();
    postMessage({ kind: "ready" });
  } else wanted = data;
  if (engine && wanted && !busy) work();
};
