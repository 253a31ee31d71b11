// An editor of TOML: a text field over its own text in colours. Undo, selection, dictation and small keyboards are the
// browser's own; lines are numbered, mistakes underlined, keys and words completed.

const TOKEN = /(#.*)|("(?:[^"\\]|\\.)*"?|'[^']*'?)|(^\s*\[\[?[^\]#]*\]?\]?)|((?:^|(?<=[{,]))\s*[\w.-]+(?=\s*=))|([+-]?\b\d[\d_.eE+-]*|\b(?:true|false)\b)/g;
const KINDS = ["", "comment", "text", "table", "key", "number"];
const NAMES = { parent: "bodies", child: "bodies", body: "bodies", joint: "joints", mimic: "joints" };
const MOST = 60; // completions that are offered at once

function made(tag, className = "", text = "") {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text) element.textContent = text;
  return element;
}

/** Return the coloured pieces of a line, those between two columns marked as wrong. */
function pieces(line, marks) {
  const kinds = new Array(line.length).fill(0);
  for (const found of line.matchAll(TOKEN)) kinds.fill(found.findIndex((one, k) => k && one !== undefined), found.index, found.index + found[0].length);
  const wrong = new Array(line.length + 1).fill(false);
  for (const { column, length } of marks) wrong.fill(true, column - 1, Math.min(line.length + 1, column - 1 + length));
  const shown = [], end = wrong[line.length] ? line.length + 1 : line.length;
  for (let from = 0, to = 0; from < end; from = to) {
    while (to < end && kinds[to] === kinds[from] && wrong[to] === wrong[from]) to++;
    const name = `${KINDS[kinds[from] ?? 0]}${wrong[from] ? " wrong" : ""}`.trim();
    const text = line.slice(from, to) || " ";
    shown.push(name ? made("span", name, text) : document.createTextNode(text));
  }
  return shown;
}

/** Return what may be written at a place of a text: where the word begins, and the choices. */
function choices(text, at, words) {
  const line = text.slice(text.lastIndexOf("\n", at - 1) + 1, at), before = text.slice(0, at - line.length);
  const header = [...before.matchAll(/^\s*\[+\s*([^\]#\n]*?)\s*\]+/gm)].at(-1)?.[1] ?? "";
  const parts = header.split(".").map(part => part.trim().replace(/^["']|["']$/g, ""));
  const named = !["", "dh", "loop"].includes(parts[0]) && parts.length > 1;
  const table = (named ? [parts[0], ...parts.slice(2)] : parts).join(".");
  const offered = (word, rows) => ({ from: at - word.length, word, rows });
  const sign = /^\s*=/.test(text.slice(at)) ? "" : " = ";
  const keys = known => Object.entries(known ?? {}).map(([label, [says]]) => ({ label, says, put: label + sign }));
  let found = line.match(/^\s*\[+([\w.-]*)$/);
  if (found) {
    const tables = Object.keys(words[""] ?? {}).filter(key => words[key]);
    return offered(found[1], tables.map(label => ({ label, says: words[""][label][0], put: label })));
  }
  found = line.match(/([\w-]+)\s*=\s*\[?\s*\{(?:[^}]*,)?\s*([\w-]*)$/);
  if (found) return offered(found[2], keys(words[`${table}.${found[1]}`]));
  found = line.match(/^\s*([\w-]*)$/);
  if (found) return offered(found[1], header === "" ? keys(words[""]) : header === "parameters" ? [] : keys(words[table]));
  found = line.match(/([\w-]+)\s*=\s*("?)([\w-]*)$/);
  if (!found) return null;
  const [, key, quote, word] = found, section = NAMES[key];
  const known = section
    ? [...(section === "bodies" ? ["ground"] : []), ...[...text.matchAll(new RegExp(`^\\s*\\[${section}\\.([\\w-]+)`, "gm"))].map(one => one[1])]
    : words[table]?.[key]?.[1] ?? [];
  const close = text[at] === '"' ? "" : '"';
  return offered(quote + word, [...new Set(known)].map(label => ({ label, says: "", put: `"${label}${close}` })));
}

/** Make an editor in an element; `changed` is told the text when a hand changes it. */
export function editor(root, label, changed) {
  const numbers = made("div", "numbers"), paper = made("div", "paper"), shown = made("div", "shown"), list = made("ul", "choices");
  const field = made("textarea");
  Object.assign(field, { spellcheck: false, wrap: "off", id: "text", autocapitalize: "off" });
  field.setAttribute("autocorrect", "off");
  field.setAttribute("aria-label", label);
  field.setAttribute("aria-autocomplete", "list");
  field.setAttribute("aria-controls", "choices");
  Object.assign(list, { id: "choices", hidden: true });
  list.setAttribute("role", "listbox");
  list.setAttribute("aria-label", label);
  for (const one of [numbers, shown]) one.setAttribute("aria-hidden", "true");
  paper.append(shown, field, list);
  root.append(numbers, paper);
  let lines = [], marked = [], words = {}, offered = null, chosen = 0;

  function draw() {
    const now = field.value.split("\n"), by = new Map();
    for (const one of marked) by.set(one.line, [...(by.get(one.line) ?? []), one]);
    now.forEach((line, k) => {
      const key = `${line}\n${JSON.stringify(by.get(k + 1) ?? [])}`;
      if (lines[k] === key) return;
      lines[k] = key;
      const row = shown.children[k] ?? shown.appendChild(made("div"));
      row.replaceChildren(...pieces(line, by.get(k + 1) ?? []));
      const number = numbers.children[k] ?? numbers.appendChild(made("div", "", String(k + 1)));
      number.classList.toggle("wrong", by.has(k + 1));
    });
    while (shown.children.length > now.length) {
      shown.lastChild.remove();
      numbers.lastChild.remove();
    }
    lines.length = now.length;
  }

  function close() {
    offered = null;
    list.hidden = true;
    field.removeAttribute("aria-activedescendant");
  }

  function offer(asked) {
    const at = field.selectionStart, found = at === field.selectionEnd ? choices(field.value, at, words) : null;
    const bare = found?.word.replace(/^"/, "").toLowerCase() ?? "";
    const rows = found?.rows.filter(row => row.label.toLowerCase().startsWith(bare) && row.label !== bare).slice(0, MOST) ?? [];
    if (!rows.length || (!asked && !bare)) return close();
    offered = { ...found, rows };
    chosen = 0;
    list.replaceChildren(...rows.map((row, k) => {
      const item = made("li");
      item.id = `choice-${k}`;
      item.setAttribute("role", "option");
      item.append(made("b", "", row.label), made("span", "", row.says));
      item.addEventListener("pointerdown", event => { event.preventDefault(); take(k); });
      return item;
    }));
    const before = field.value.slice(0, found.from), line = before.split("\n").length - 1;
    const size = shown.children[line].getBoundingClientRect().height, wide = parseFloat(getComputedStyle(root).getPropertyValue("--ch")) || 8;
    list.style.setProperty("top", `${(line + 1) * size + 8}px`);
    list.style.setProperty("left", `${(found.from - before.lastIndexOf("\n") - 1) * wide}px`);
    list.hidden = false;
    reveal();
    mark();
  }

  const reveal = () => list.scrollIntoView({ block: "nearest", inline: "nearest" });
  new ResizeObserver(() => { if (!list.hidden) reveal(); }).observe(root); // mistakes that are listed below take room

  function mark() {
    [...list.children].forEach((item, k) => item.setAttribute("aria-selected", String(k === chosen)));
    list.children[chosen].scrollIntoView({ block: "nearest" });
    field.setAttribute("aria-activedescendant", `choice-${chosen}`);
  }

  function take(k) {
    const { from, word, rows } = offered;
    field.focus();
    field.setSelectionRange(from, from + word.length);
    close();
    if (!document.execCommand("insertText", false, rows[k].put)) field.setRangeText(rows[k].put, from, from + word.length, "end"); // the first can be undone
    draw();
    changed(field.value);
    if (rows[k].put.endsWith(" = ")) offer(true);
  }

  field.addEventListener("input", event => { draw(); changed(field.value); if (event.inputType?.startsWith("insert")) offer(false); else close(); });
  field.addEventListener("blur", close);
  field.addEventListener("pointerdown", close);
  field.addEventListener("keydown", event => {
    if (event.key === " " && event.ctrlKey) { event.preventDefault(); offer(true); return; }
    if (!offered) return;
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      chosen = (chosen + (event.key === "ArrowDown" ? 1 : offered.rows.length - 1)) % offered.rows.length;
      mark();
    } else if (event.key === "Enter" || event.key === "Tab") take(chosen);
    else if (event.key === "Escape") close();
    else { if (event.key.startsWith("Arrow") || event.key === "Home" || event.key === "End") close(); return; }
    event.preventDefault();
  });

  const probe = made("span", "probe", "0".repeat(100));
  root.append(probe);
  const measure = () => root.style.setProperty("--ch", `${probe.getBoundingClientRect().width / 100}px`);
  document.fonts?.ready.then(measure);
  measure();

  return {
    get text() { return field.value; },
    set text(text) { if (text !== field.value) { field.value = text; marked = []; close(); } draw(); },
    set words(known) { words = known; },
    set label(text) { for (const one of [field, list]) one.setAttribute("aria-label", text); },
    /** Underline places: lines and columns from 1. */
    mark(places) { marked = places; draw(); },
    /** Put the caret to a place and show it. */
    show({ line, column, length }) {
      const from = field.value.split("\n").slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0) + column - 1;
      field.focus({ preventScroll: true });
      field.setSelectionRange(from, from + length);
      const row = shown.children[line - 1];
      (row?.querySelector(".wrong") ?? row)?.scrollIntoView({ block: "center", inline: "nearest" });
    },
  };
}
