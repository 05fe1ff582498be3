// ---- the page that simulates a model while its text is edited: editor, worker with the engine, viewer --------------------------------

// Parts of the page that the viewer fills; they are renewed for each run.
const PLOTS = "main > aside", FILLED = ["#views", "#display", "#runs", "#scales", PLOTS, "footer"];
const whole = selector => document.querySelector(selector);
const pristine = FILLED.map(selector => whole(selector).cloneNode(true));

// `latest` is the number of the last text sent to the engine; `shown` the last picture, with the times in ms from the key stroke.
const page = { viewer: null, plotted: null, ender: null, kept: null, latest: 0, given: new Map(), shown: null, refused: null, model: "", waiting: null };

// Shows a run instead of the previous one: its beginning in the scene of that one where the model has the same structure.
function showRun(message) {
  const { id, about, numbers, summary, done, ms } = message;
  const parsed = JSON.parse(about);
  const continued = !done && !page.fresh && Boolean(page.viewer?.continueWith(parsed, numbers));
  if (!continued) startRun(message, parsed);
  whole("main").classList.remove("behind");
  const now = performance.now(), begun = page.given.get(id);
  if (page.first?.id !== id) page.first = { id, ms: now - begun };
  page.shown = { id, done, continued, engine: ms, first: page.first.ms, all: now - begun, summary };
  setMarks(summary.marks);
  tellRun(summary, done, ms);
}
function startRun({ numbers, done }, about) {
  const before = page.viewer;
  const kept = before?.keptNow();
  before?.endRun();
  page.ender?.abort();
  if (done) page.plotted?.endPlots();
  if (before) FILLED.forEach((selector, i) => {
    if (done || selector !== PLOTS) whole(selector).replaceWith(pristine[i].cloneNode(true));
  });
  page.ender = new AbortController();
  const first = !before || page.fresh;
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  page.viewer = startViewer({
    about, numbers, done, renderer: before?.renderer, textPictures: before?.textPictures, signal: page.ender.signal,
    dark: kept?.dark, kept: page.fresh ? undefined : kept, play: done && first && !still,
  });
  before?.dispose();
  if (done) { page.fresh = false; page.plotted = page.viewer; }
}

const LATCH = ({ joint, time_s }) => `${joint} latches at ${time_s.toFixed(5)} s`;
function tellRun(summary, done, ms) {
  const { failure, latches, share, steps, time_s } = summary;
  const ends = latches.filter(latch => latch.time_s !== null).map(LATCH);
  const text = failure ? `Stopped at ${time_s.toFixed(4)} s: ${failure}`
    : done ? [`${+time_s.toPrecision(6)} s in ${Math.round(ms)} ms, ${steps} steps`, ...ends].join(" · ")
    : `running: ${Math.floor(100 * share)} %`;
  whole("#engine-state").textContent = text;
}

// Marks of errors and warnings: in the lines, and as a list whose entries select the location.
function setMarks(marks, message) {
  if (!marks.length && !message && !whole("#engine-marks").children.length) return;
  const length = editor.state.doc.length;
  const inside = at => Math.min(at, length);
  const place = mark => ({ from: inside(mark.from), to: Math.max(inside(mark.from), inside(mark.to)), severity: mark.severity, message: mark.message });
  editor.dispatch(CodeMirror.setDiagnostics(editor.state, marks.map(place).sort((a, b) => a.from - b.from)));
  const rows = marks.map(mark => {
    const row = document.createElement("li"), button = document.createElement("button");
    Object.assign(button, { type: "button", className: mark.severity, textContent: `line ${mark.line}, column ${mark.column}: ${mark.message}` });
    button.addEventListener("click", () => {
      editor.dispatch({ selection: { anchor: inside(mark.from), head: inside(mark.to) }, scrollIntoView: true });
      editor.focus();
    });
    row.append(button);
    return row;
  });
  if (message) rows.unshift(Object.assign(document.createElement("li"), { className: "error", textContent: message }));
  whole("#engine-marks").replaceChildren(...rows);
}

function refuse({ id, marks, message, ms }) {
  whole("main").classList.toggle("behind", page.viewer !== null);
  page.refused = { id, marks, message, ms, all: performance.now() - page.given.get(id) };
  setMarks(marks, message);
  const count = marks.filter(mark => mark.severity === "error").length;
  const last = page.viewer ? "; the picture shows the last valid model" : "";
  whole("#engine-state").textContent = `${count ? `${count} error${count > 1 ? "s" : ""}` : "no run"}${last}`;
}

// If pictures arrive faster than they are drawn, only the last one is shown.
function receive(message) {
  if (message.kind === "ready" || message.id !== page.latest) return;
  page.refused = null;
  if (message.kind === "refused") { page.waiting = null; refuse(message); return; }
  const idle = page.waiting === null;
  page.waiting = message;
  if (idle) queueMicrotask(() => { const next = page.waiting; page.waiting = null; if (next && next.id === page.latest) showRun(next); });
}

// Sends the text of the editor to the engine.
function give() {
  const id = ++page.latest;
  page.given.clear();
  page.given.set(id, performance.now());
  worker.postMessage({ id, text: editor.state.doc.toString() });
}

// Model of the address: `#name`, or `?name` where another page leads here.
const named = () => location.hash.slice(1) || location.search.slice(1);
// Loads a model of the gallery into the editor, the first one if the name is unknown.
function open(name) {
  const model = MODELS.find(one => one.name === name) || MODELS[0];
  whole("#model").value = page.model = model.name;
  page.fresh = true;
  editor.dispatch({ changes: { from: 0, to: editor.state.doc.length, insert: model.text }, selection: { anchor: 0 }, scrollIntoView: true });
}

function inkOf(name) { return `var(--${name})`; }
const styles = CodeMirror.EditorView.theme({
  "&": { color: inkOf("text"), backgroundColor: inkOf("panel") },
  ".cm-content": { caretColor: inkOf("text") },
  ".cm-cursor": { borderLeftColor: inkOf("text") },
  "&.cm-focused .cm-selectionBackground, .cm-selectionBackground, .cm-content ::selection": { backgroundColor: "color-mix(in srgb, var(--accent) 26%, transparent) !important" },
  ".cm-gutters": { color: inkOf("faint"), backgroundColor: inkOf("panel"), borderRightColor: inkOf("line") },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--accent) 7%, transparent)" },
  ".cm-tooltip-autocomplete > ul > li[aria-selected]": { color: inkOf("text"), backgroundColor: "color-mix(in srgb, var(--accent) 26%, var(--panel))" },
  ".cm-completionDetail": { color: inkOf("faint"), fontStyle: "normal" },
  ".cm-completionInfo p": { margin: "0 0 .2rem" },
  ".cm-tooltip": { maxWidth: "32rem", color: inkOf("text"), backgroundColor: inkOf("panel"), borderColor: inkOf("line") },
});
const { tags } = CodeMirror;
const inksOfText = CodeMirror.HighlightStyle.define([
  { tag: tags.comment, color: inkOf("faint") },
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: inkOf("text") },
  { tag: [tags.string, tags.number, tags.bool, tags.atom], color: inkOf("accent") },
  { tag: [tags.heading, tags.bracket, tags.squareBracket, tags.keyword], fontWeight: "600" },
]);

// The editor panel, before the stage.
whole("main").insertAdjacentHTML("afterbegin", `<section id="editor" aria-label="Model file">
  <div class="bar"><select id="model" aria-label="Model"></select><button type="button" id="again" title="Restore the original text">undo all</button>
  <button type="button" id="save-text" title="Save the model file">save</button></div>
  <div id="model-text"></div><ul id="engine-marks" aria-label="Errors and warnings"></ul><p id="engine-state" role="status">loading the engine</p></section>`);
for (const { name } of MODELS) whole("#model").add(new Option(name.replaceAll("_", " "), name));

const editor = new CodeMirror.EditorView({
  parent: whole("#model-text"),
  state: CodeMirror.EditorState.create({
    doc: "",
    extensions: [
      CodeMirror.lineNumbers(), CodeMirror.highlightActiveLine(), CodeMirror.history(), CodeMirror.drawSelection(), CodeMirror.bracketMatching(),
      CodeMirror.lintGutter(), CodeMirror.StreamLanguage.define(CodeMirror.toml), CodeMirror.syntaxHighlighting(inksOfText), styles,
      CodeMirror.autocompletion({ override: [completionAt], icons: false }),
      CodeMirror.keymap.of([...CodeMirror.completionKeymap, ...CodeMirror.defaultKeymap, ...CodeMirror.historyKeymap, ...CodeMirror.lintKeymap]),
      CodeMirror.EditorView.contentAttributes.of({ "aria-label": "Text of the model" }),
      CodeMirror.EditorView.updateListener.of(update => { if (update.docChanged) give(); }),
    ],
  }),
});

// The worker is created from a text, since browsers do not load workers for pages that were opened from the disk.
const worker = new Worker(URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" })));
worker.addEventListener("message", event => receive(event.data));
worker.addEventListener("error", event => { whole("#engine-state").textContent = `The engine cannot run in this browser: ${event.message}`; });

// The engine is a script beside the page, `const ENGINE = "…"`: base64 of the compressed module.
const arrived = address => new Promise((done, failed) => {
  document.head.append(Object.assign(document.createElement("script"), { src: address, onload: done, onerror: () => failed(Error(`${address} is missing`)) }));
});
async function loadEngine() {
  await arrived("engine.js");
  const packed = Uint8Array.from(atob(ENGINE), letter => letter.charCodeAt(0));
  const bytes = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  worker.postMessage({ engine: bytes }, [bytes]);
}

whole("#model").addEventListener("change", event => { location.hash = event.target.value; });
addEventListener("hashchange", () => open(named()));
whole("#again").addEventListener("click", () => open(page.model));
whole("#save-text").addEventListener("click", () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([editor.state.doc.toString()], { type: "text/plain" }));
  link.download = `${page.model}.toml`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
});
open(named());
loadEngine().catch(error => { whole("#engine-state").textContent = `The engine cannot run in this browser: ${error.message}`; });

// In a frame of the documentation: the height of the content, where it is in one column. 0 where it has the height of the frame.
if (window.parent !== window) {
  document.documentElement.classList.add("framed");
  const narrow = matchMedia("(max-width: 860px)");
  const tellHeight = () => window.parent.postMessage({ foldwingHeight: narrow.matches ? document.body.offsetHeight : 0 }, "*");
  new ResizeObserver(tellHeight).observe(document.body);
  narrow.addEventListener("change", tellHeight);
}
