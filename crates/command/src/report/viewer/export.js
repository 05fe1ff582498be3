
// ---- export: picture, film, table ------------------------------------------------------------------------------------

function save(blob, extension) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${about.name}${extension}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A copy of the stage with time and scales, on a separate canvas.
function compose(into) {
  const ratio = canvas.width / canvas.clientWidth, pen = into.getContext("2d");
  if (into.width !== canvas.width || into.height !== canvas.height) Object.assign(into, { width: canvas.width, height: canvas.height });
  render(); // in the same task as the copy, otherwise the buffer may be empty
  pen.drawImage(canvas, 0, 0);
  pen.scale(ratio, ratio);
  pen.fillStyle = inks.text;
  pen.font = "600 15px system-ui, \"DejaVu Sans\", sans-serif";
  pen.textBaseline = "top";
  pen.fillText(`${about.name}   ${get("clock").textContent}`, 14, 12);
  let left = 14;
  for (const box of get("scales").querySelectorAll(".scale:not([hidden])")) {
    const bottom = canvas.clientHeight - 14, width = 200, fade = pen.createLinearGradient(left, 0, left + width, 0);
    for (let i = 0; i <= 16; i++) fade.addColorStop(i / 16, cssOf(box.map, i / 16));
    pen.fillStyle = inks.text;
    pen.font = "13px system-ui, \"DejaVu Sans\", sans-serif";
    pen.textBaseline = "alphabetic";
    pen.textAlign = "left";
    pen.fillText(box.querySelector("b").textContent, left, bottom - 30);
    const ends = [...box.querySelectorAll("span")].map(end => end.textContent);
    ends.forEach((text, i) => { pen.textAlign = ["left", "center", "right"][i]; pen.fillText(text, left + width * i / 2, bottom); });
    pen.textAlign = "left";
    pen.fillStyle = fade;
    pen.fillRect(left, bottom - 25, width, 10);
    left += width + 30;
  }
  pen.setTransform(1, 0, 0, 1, 0, 0);
  return into;
}

function pictureBlob() {
  return new Promise(done => compose(document.createElement("canvas")).toBlob(done, "image/png"));
}

const filmType = window.MediaRecorder && ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find(type => MediaRecorder.isTypeSupported(type));
let filming = null;

// Plays the run once from its first frame and records the stage.
function filmBlob() {
  return new Promise((done, fail) => {
    const into = document.createElement("canvas"), pieces = [];
    let ended = 0;
    compose(into);
    const recorder = new MediaRecorder(into.captureStream(30), { mimeType: filmType, videoBitsPerSecond: 8e6 });
    recorder.ondataavailable = event => pieces.push(event.data);
    recorder.onerror = event => fail(event.error);
    recorder.onstop = () => { filming = null; done(new Blob(pieces, { type: "video/webm" })); };
    const repeat = get("repeat").checked;
    get("repeat").checked = false;
    seek(0);
    filming = () => {
      compose(into);
      if (state.playing || ended) return;
      get("repeat").checked = repeat;
      ended = performance.now();
      hold();
    };
    // keep the last picture for a moment, and until the recorder has delivered data
    const hold = () => {
      compose(into);
      const held = performance.now() - ended;
      if (held > 20000 || (held > 300 && pieces.some(piece => piece.size))) recorder.stop(); else requestAnimationFrame(hold);
    };
    recorder.onstart = () => play(true);
    recorder.start(100);
  });
}

// Signals of all plots within their present range of time, in the units of the CSV files.
function tableText() {
  const names = [...new Set(charts.flatMap(chart => chart.names))];
  const found = names.flatMap(name => sourcesOf(name).map(source => ({ ...source, name })));
  if (!found.length) return "time\n";
  const quoted = text => (/[",\n]/.test(text) ? `"${text.replaceAll("\"", "\"\"")}"` : text);
  const joined = uPlot.join(found.map(source => [source.time, source.values])), times = joined[0];
  const lines = [["time", ...found.map(source => quoted(source.label))].join(",")];
  times.forEach((time, row) => {
    if (zoomed && (time < zoomed[0] || time > zoomed[1])) return;
    const cells = found.map((source, i) => { const value = joined[i + 1][row]; return value === null || value === undefined ? "" : shortest(value / signals.get(source.name).factor); });
    lines.push([shortest(time), ...cells].join(","));
  });
  return `${lines.join("\n")}\n`;
}
// Digits of a single-precision number.
const shortest = value => String(Number(value.toPrecision(8)));

// Adds a table that the reader opens or drops on the page.
async function openTable(file) {
  const lines = (await file.text()).split(/\r?\n/).filter(line => line.trim() && !line.startsWith("#"));
  const header = (lines.shift() || "").split(",").map(name => name.trim().replace(/^"|"$/g, "")), at = header.indexOf("time");
  const rows = lines.map(line => line.split(",").map(cell => (cell.trim() === "" ? NaN : Number(cell))));
  const fits = (row, line) => row.length === header.length && Number.isFinite(row[at]) &&
    line.split(",").every((cell, i) => cell.trim() === "" || Number.isFinite(row[i]));
  const bad = rows.findIndex((row, i) => !fits(row, lines[i]));
  if (at < 0 || header.length < 2 || bad >= 0 || !rows.length) {
    say(at < 0 ? `${file.name}: there is no column “time” (s)` : bad >= 0 ? `${file.name}: row ${bad + 1} below the header has another number of columns or text that is no number` : `${file.name}: no rows or columns to draw`);
    return;
  }
  rows.sort((a, b) => a[at] - b[at]);
  const names = header.filter((_, i) => i !== at);
  addTable(file.name, names, rows.length, rows.flatMap(row => [row[at], ...row.filter((_, i) => i !== at)]), rows.length);
  adoptTables();
  get("signal-names").replaceChildren(...[...signals.keys()].map(name => new Option(signals.get(name).unit, name)));
  const fresh = names.filter(name => !charts.some(chart => chart.names.includes(name)) && !about.signals.some(([other]) => other === name));
  charts.forEach(chart => chart.build());
  if (fresh.length) charts.push(new Chart(fresh.slice(0, 4)));
  listRuns();
  say(`${file.name}: ${rows.length} rows, ${names.length} columns, drawn as dots`);
}
