// ---- completion of the model file from its schema: keys of the table, values, tables --------------------------------------

// Units by the end of a key, longest first.
const UNITS = Object.entries({
  N_m_s_rad: "N·m·s/rad", N_m_rpm2: "N·m/rpm²", rpm_N_m: "rpm, N·m", N_m_rad: "N·m/rad", kg_m2: "kg·m²", kg_m3: "kg/m³", mass_kg_m: "kg/m", kg_m: "kg·m", N_m2: "N·m²",
  N_s_m: "N·s/m", m_s2: "m/s²", deg_s: "deg/s", stiffness_N_m: "N/m", N_m: "N·m", m_s: "m/s", "1_rad": "1/rad", "1_m": "1/m", "1_s": "1/s", s_deg: "s, deg", s_m: "s, m",
  deg: "deg", kg: "kg", Pa: "Pa", SI: "SI", N: "N", m: "m", s: "s",
}).sort(([a], [b]) => b.length - a.length);
const unitOf = key => (UNITS.find(([end]) => `_${key}`.endsWith(`_${end}`)) || ["", ""])[1];

const resolved = node => (node?.$ref ? { ...SCHEMA.$defs[node.$ref.split("/").pop()], ...node, $ref: undefined } : node);
const variantsOf = node => node?.oneOf || node?.anyOf || [];

// Nesting of the text up to a position: the header of the table, the headers and keys of all tables, whether the position is in a string,
// a comment or an array.
function outlineOf(text, end) {
  const tables = new Map([["", new Map()]]);
  let path = [], at = 0, inside = null, table = tables.get("");
  const skip = pattern => { pattern.lastIndex = at; const found = pattern.exec(text); if (found) at = pattern.lastIndex; return found; };
  const TOKEN = /"""[^]*?(?:"""|$)|'''[^]*?(?:'''|$)|"(?:\\.|[^"\\\n])*"?|'[^'\n]*'?|#[^\n]*|[[\]{}]|\n|[^"'#[\]{}\n]+/gy;
  let depth = 0, fresh = true;
  while (at < text.length) {
    if (fresh && depth === 0) {
      const header = skip(/[ \t]*\[\[?[ \t]*((?:[\w-]+|"[^"\n]*")(?:[ \t]*\.[ \t]*(?:[\w-]+|"[^"\n]*"))*)[ \t]*\]\]?/y);
      if (header) {
        const named = header[1].split(".").map(part => part.trim().replace(/"/g, ""));
        if (at <= end) path = named;
        if (!tables.has(named.join("."))) tables.set(named.join("."), new Map());
        table = tables.get(named.join("."));
      }
      const key = header ? null : skip(/[ \t]*([\w-]+)[ \t]*=[ \t]*(?=([^\n]*))/y);
      if (key) table.set(key[1], key[2]);
    }
    const from = at, token = skip(TOKEN)?.[0];
    if (!token) break;
    fresh = token === "\n";
    if (token === "[" || token === "{") depth += 1;
    if (token === "]" || token === "}") depth = Math.max(0, depth - 1);
    // the position is within the token, or at the end of a comment
    if (from < end && (at > end || (at === end && token[0] === "#"))) inside = token[0] === "#" ? "comment" : /^["']/.test(token) ? "string" : inside;
    if (at >= end && outlineOf.depth === undefined) outlineOf.depth = depth - (at > end && "[{".includes(token) ? 1 : 0);
  }
  const depthAtEnd = outlineOf.depth ?? depth;
  outlineOf.depth = undefined;
  return { path, tables, inside, depth: depthAtEnd };
}

// Schema of a table; of several forms the one that its key `shape` selects.
function tableOf(path, tables) {
  let node = SCHEMA;
  for (let i = 0; i < path.length; i++) {
    const found = propertiesOf(node, tables.get(path.slice(0, i).join(".")))[path[i]];
    node = resolved(found || (node.additionalProperties instanceof Object ? node.additionalProperties : null));
    if (!node) return null;
  }
  return node;
}
function propertiesOf(node, stated) {
  if (!node) return {};
  if (node.properties) return node.properties;
  const forms = variantsOf(node).map(resolved).filter(form => form?.properties);
  const chosen = forms.filter(form => {
    const { shape } = form.properties;
    return shape?.const && stated?.get("shape")?.startsWith(`"${shape.const}"`);
  });
  const found = {};
  for (const form of chosen.length ? chosen : forms) for (const [key, own] of Object.entries(form.properties)) {
    // the words of all forms, as those of `shape`, each with the sentence of its form
    const word = own.const === undefined ? own : { const: own.const, description: form.description };
    found[key] = !found[key] ? (own.const === undefined ? own : { oneOf: [word] }) : own.const === undefined ? found[key] : { oneOf: [...found[key].oneOf, word] };
  }
  return found;
}
// A table, in contrast to a number, a text or a function along a body.
function isTable(node) {
  const own = resolved(node);
  return Boolean(own && (own.type === "object" || (variantsOf(own).length && variantsOf(own).every(form => resolved(form)?.type === "object"))));
}

// Sentence, unit, default and range of a key, shown next to the list.
function infoOf(key, node) {
  const own = resolved(node), box = document.createElement("div");
  const parts = [
    own.description, unitOf(key) && `Unit: ${unitOf(key)}.`, own["x-allowed"] && `Allowed: ${own["x-allowed"]}.`,
    own.default !== undefined && own.default !== null && !(own.default instanceof Object && !Array.isArray(own.default)) && `Default: ${JSON.stringify(own.default)}.`,
  ].filter(Boolean);
  box.append(...parts.map((text, i) => { const line = document.createElement("p"); line.textContent = i ? text : text.replaceAll("`", ""); return line; }));
  return box;
}
function kindOf(node) {
  const own = resolved(node), words = valuesOf(own);
  if (words.length) return words.length > 3 ? `${words.length} words` : words.map(({ label }) => label).join(" | ");
  if (own.type === "array") return own.minItems && own.minItems === own.maxItems ? `array of ${own.minItems}` : "array";
  if (own.anyOf) return "number or function";
  return { string: "text", number: "number", integer: "integer", boolean: "true | false" }[own.type] || "";
}
// Words that are allowed as the value of a key.
function valuesOf(own) {
  const quoted = form => ({ label: JSON.stringify(form.const), info: form.description });
  if (own.const !== undefined) return [quoted(own)];
  if (own.enum) return own.enum.map(word => ({ label: JSON.stringify(word) }));
  if (own.type === "boolean") return [{ label: "true" }, { label: "false" }];
  const found = variantsOf(own).map(resolved).flatMap(form => (form.const !== undefined ? [quoted(form)] : form.enum ? form.enum.map(word => ({ label: JSON.stringify(word) })) : []));
  return found;
}

// Names of the model that a key may refer to.
const BODIES = ["body", "rigid_body", "modal_body"];
const REFERENCES = {
  section: ["section"], outer_section: ["section"], body: BODIES, child: BODIES, parent: BODIES, hub: BODIES, bodies: BODIES, joint: ["joint"], material: ["material"],
  surface: ["surface"], polars: ["polar"], mass: ["mass"],
};
function namesFor(key, tables) {
  const kinds = REFERENCES[key] || [];
  const found = [...tables.keys()].map(name => name.split(".")).filter(([kind, name]) => name && kinds.includes(kind)).map(([, name]) => name);
  return [...(key === "parent" ? ["root"] : []), ...new Set(found)].map(name => ({ label: JSON.stringify(name), detail: name === "root" ? "" : "of this model" }));
}

// Headers of tables: those of the schema, and the tables within those that the model has.
function headersOf(tables) {
  const found = new Map();
  const add = (path, node, named) => {
    for (const [key, own] of Object.entries(propertiesOf(node, tables.get(path.join("."))))) if (isTable(own)) {
      const inner = resolved(own), at = [...path, key];
      if (inner.properties || variantsOf(inner).length) {
        if (!tables.has(at.join("."))) found.set(at.join("."), inner.description);
        add(at, inner, named);
      } else {
        found.set(`${at.join(".")}.`, inner.description);
        for (const name of named(at)) add([...at, name], resolved(inner.additionalProperties), named);
      }
    }
  };
  const named = at => [...new Set([...tables.keys()].map(one => one.split(".")).filter(one => one.length > at.length && at.every((part, i) => part === one[i])).map(one => one[at.length]))];
  add([], SCHEMA, named);
  return found;
}

// Source of the completion at the position of a CodeMirror context.
function completionAt(context) {
  const { state, pos, explicit } = context, text = state.doc.toString(), line = state.doc.lineAt(pos), before = text.slice(line.from, pos);
  const { path, tables, inside, depth } = outlineOf(text, pos);
  if (inside === "comment") return null;
  const header = /^\s*\[\[?([\w.-]*)$/.exec(before);
  if (header && depth <= 1) {
    const close = text[pos] === "]" ? "" : "]";
    return {
      from: pos - header[1].length, validFor: /^[\w.-]*$/,
      options: [...headersOf(tables)].map(([label, info]) => ({
        label, type: "namespace", detail: label.endsWith(".") ? "name follows" : "", info, apply: label.endsWith(".") ? label : label + close,
      })),
    };
  }
  const table = tableOf(path, tables), stated = tables.get(path.join(".")), properties = propertiesOf(table, stated);
  const value = /^\s*([\w-]+)\s*=\s*\[?(?:[^[\]]*,)?\s*("?[\w.-]*)$/.exec(before);
  if (value && properties[value[1]]) {
    if (inside === "string" && !value[2].startsWith('"')) return null;
    const own = resolved(properties[value[1]]), start = own.default;
    const words = [...valuesOf(own.type === "array" ? resolved(own.items) || {} : own), ...namesFor(value[1], tables)];
    if (!words.length && explicit && value[2] === "" && start !== undefined && start !== null && !(start instanceof Object && !Array.isArray(start))) words.push({ label: JSON.stringify(start), detail: "default" });
    // a quote behind the word is part of it
    const to = text[pos] === '"' && value[2].startsWith('"') ? pos + 1 : pos;
    return words.length ? { from: pos - value[2].length, to, filter: to === pos, options: words.map(word => ({ type: "constant", ...word })) } : null;
  }
  const key = /^\s*([\w-]*)$/.exec(before);
  if (!key || depth || inside || (!key[1] && !explicit)) return null;
  const rest = text.slice(pos, line.to), follows = /^[\w-]*\s*=/.test(rest);
  const options = Object.entries(properties).filter(([name, own]) => !isTable(own) && (follows || !stated?.has(name) || name === key[1])).map(([name, own]) => ({
    label: name, type: "property", detail: [unitOf(name), kindOf(own)].filter(Boolean).join(", "), info: () => infoOf(name, own), apply: follows ? name : `${name} = `,
    boost: table?.required?.includes(name) ? 2 : 0,
  }));
  return options.length ? { from: pos - key[1].length, options, validFor: /^[\w-]*$/ } : null;
}
