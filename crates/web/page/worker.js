// ---- the engine's thread: texts come in, pictures go out; a text that is typed over is given up ----------------------------

// A run that lasts shows its beginning after so long (ms), and more of it whenever its time has grown by the factor.
const FIRST_MS = 4, LATER = 4;
// Between slices of so long (ms) it is seen whether there is another text.
const SLICE_MS = 4;
// Frames of a picture after the first.
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

// Lets a message in.
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
  let state = 0, next = began + FIRST_MS;
  while (state === 0) {
    const until = performance.now() + SLICE_MS;
    do state = engine.foldwing_advance(1); while (state === 0 && performance.now() < until);
    if (state === 0 && performance.now() > next) {
      send(task, began, false);
      next = began + LATER * (performance.now() - began);
    }
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
      // the module is beyond use after a fault: the next text has a new one
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
