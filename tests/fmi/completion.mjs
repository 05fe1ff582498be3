// Completions of the model file by `crates/web/page/completion.js`, without a browser: texts on standard input as a JSON array, `|` at the
// cursor; labels, units and replaced text on standard output.
import { readFileSync } from "node:fs";

const root = new URL("../../", import.meta.url);
globalThis.SCHEMA = JSON.parse(readFileSync(new URL("examples/models/foldwing.schema.json", root), "utf8"));
globalThis.document = { createElement: () => ({ lines: [], textContent: "", append(...lines) { this.lines.push(...lines); } }) };
(0, eval)(`${readFileSync(new URL("crates/web/page/completion.js", root), "utf8")}\nglobalThis.complete = completionAt; globalThis.unit = unitOf;`);

const found = JSON.parse(readFileSync(0, "utf8")).map(marked => {
  const pos = marked.indexOf("|"), text = marked.slice(0, pos) + marked.slice(pos + 1);
  const lineAt = at => {
    const from = text.lastIndexOf("\n", at - 1) + 1, end = text.indexOf("\n", at);
    return { from, to: end < 0 ? text.length : end };
  };
  const result = complete({ state: { doc: { toString: () => text, lineAt } }, pos, explicit: true });
  if (!result) return null;
  const info = ({ info }) => (typeof info === "function" ? info().lines.map(line => line.textContent) : info ?? null);
  return {
    from: text.slice(result.from, pos), to: text.slice(pos, result.to ?? pos),
    options: Object.fromEntries(result.options.map(option => [option.label, { detail: option.detail ?? "", info: info(option), apply: option.apply ?? option.label }])),
  };
});
const units = {};
for (const table of [SCHEMA, ...Object.values(SCHEMA.$defs)]) for (const form of [table, ...(table.oneOf ?? [])]) for (const key of Object.keys(form.properties ?? {})) units[key] = unit(key);
process.stdout.write(JSON.stringify({ found, units }));
