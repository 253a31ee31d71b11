// The page: a text, and all that is shown of it. Whoever answers is the carrier's matter; of two questions about one
// thing the later counts. Nothing of a text becomes markup but what symdyn wrote, see markup.js.

import { ask, follow, numerical, save, stop } from "./carrier.js";
import { editor } from "./editor.js";
import { fill, later } from "./markup.js";
import { WORDS } from "./words.js";

const find = id => document.getElementById(id);
const REST = 150; // ms without typing after which the text is looked at
const PATIENCE = 1000; // ms after which an answer that nobody waits for any longer is stopped
const LATE = 400; // ms after which the page says that it works
const LONGEST_LINK = 20000, LONGEST_TEXT = 200000, LARGEST_FILE = 1000000; // characters, bytes
const FIRST = "two_link";

let language = remembered("language") ?? (navigator.language?.startsWith("sk") ? "sk" : "en");
let version = 0, since = 0, timer = 0, scene = null, targets = {}, files = {}, shownFile = "", pulled = {}, pulling = false;
let followed = null, written = "", fileName = "", made = null, numbers = { is: "small" }; // who made the lesson; what NumPy there is

const say = () => WORDS[language];
const open = id => find(id).open;
const saved = () => fileName || `${scene?.name ?? "scene"}.toml`; // what a file of the text is called

function remembered(key, value) {
  try {
    if (value === undefined) return localStorage.getItem(`symdyn.${key}`);
    localStorage.setItem(`symdyn.${key}`, value);
  } catch { /* a browser that keeps nothing */ }
  return null;
}

// What is shown

function listed(place, lines) {
  place.replaceChildren(...lines.map(line => Object.assign(document.createElement("li"), { textContent: line })));
}

function framed(place, page) {
  const frame = document.createElement("iframe");
  frame.setAttribute("sandbox", "allow-scripts allow-forms"); // answers are judged in the frame; its policy sends them nowhere
  frame.title = place.id;
  frame.src = "frame.html";
  frame.addEventListener("load", () => frame.contentWindow.postMessage({ page }, "*"), { once: true });
  place.replaceChildren(frame);
}

addEventListener("message", ({ source, data }) => {
  const frame = [...document.querySelectorAll("#motion iframe")].find(one => one.contentWindow === source); // lessons scroll
  const height = Number(data?.height);
  if (frame && height > 0) frame.style.setProperty("height", `${Math.min(Math.ceil(height) + 2, 200000)}px`);
});

const SHOWS = {
  scene(answer) {
    scene = answer;
    document.body.classList.remove("stale");
    writing.mark([]);
    listed(find("faults"), []);
    listed(find("notes"), answer.notes);
    document.title = `${answer.name} · symdyn`;
    find("name").textContent = saved();
  },
  equations: (answer, mine) => fill(find("equations"), answer.html, () => mine === version),
  coefficients: (answer, mine) => fill(find("coefficients"), answer.html, () => mine === version),
  picture(answer) {
    const image = new Image();
    image.alt = say().picture_of(scene?.name ?? "");
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(answer.svg)}`;
    image.decode().catch(() => {}).then(() => find("picture").replaceChildren(image));
    sliders(answer.sliders);
    listed(find("unpulled"), answer.unpulled);
  },
  motion: answer => framed(find("motion"), answer.page),
  lesson(answer) {
    framed(find("lesson"), answer.page);
    made = answer.by;
    by();
  },
  code(answer) {
    files = answer.files;
    const names = Object.keys(files);
    if (!names.includes(shownFile)) shownFile = names[0];
    find("files").replaceChildren(...names.map(name => {
      const tab = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      tab.setAttribute("role", "tab");
      tab.addEventListener("click", () => { shownFile = name; SHOWS.code(answer); });
      tab.setAttribute("aria-selected", String(name === shownFile));
      return tab;
    }));
    find("code").textContent = files[shownFile];
  },
};

const HOW = {
  picture: () => ({ pulled }),
  motion: () => ({ language }),
  lesson: () => (find("exercises").checked ? { language, exercises: true } : { language }),
  code: () => ({ target: find("target").value }),
};

/** Ask one thing and show it; return whether the scene is one. */
async function shows(what, mine) {
  since = performance.now();
  const answer = await ask(what, writing.text, HOW[what]?.() ?? {});
  if (mine !== version) return false;
  since = 0;
  if (answer.ended) return ended();
  if (answer.faults) return faulty(answer.faults);
  const isNeeded = answer.by === "small" && /numpy|scipy/i.test(answer.failed);
  const none = answer.refused ?? (answer.failed ? [isNeeded ? say().needs : answer.failed] : null);
  if (none) {
    refused(what, none);
    return what !== "scene";
  }
  await SHOWS[what](answer, mine);
  return true;
}

function refused(what, lines) {
  if (what === "scene") return state(lines.join(" "), true);
  const list = document.createElement("ul");
  list.className = "notes";
  listed(list, lines);
  if (what === "code") { files = {}; find("files").replaceChildren(); find("code").textContent = lines.join("\n"); }
  else Object.assign(find(what), { shown: null }).replaceChildren(list);
}

function faulty(faults) {
  const lines = writing.text.split("\n");
  const places = faults.map(one => inUnits(one, lines[one.line - 1] ?? ""));
  document.body.classList.toggle("stale", scene !== null);
  writing.mark(places);
  state(say().faulty(faults.length, scene !== null), true);
  listed(find("notes"), []);
  find("faults").replaceChildren(...faults.map((one, k) => {
    const item = document.createElement("li"), button = document.createElement("button");
    button.type = "button";
    button.append(Object.assign(document.createElement("b"), { textContent: say().line(one.line) }), ` ${one.text}`);
    button.addEventListener("click", () => writing.show(places[k]));
    item.append(button);
    return item;
  }));
  return false;
}

/** Return a place in UTF-16 units, as a browser counts, of one in characters. */
function inUnits({ line, column, length }, text) {
  const units = n => [...text].slice(0, n).join("").length;
  const from = units(column - 1);
  return { line, column: from + 1, length: Math.max(1, units(column - 1 + length) - from) };
}

function ended() {
  document.body.classList.add("stale");
  state(say().ended, true);
  return false;
}

function state(text, bad = false) {
  find("state").textContent = text;
  find("state").classList.toggle("bad", bad);
}

function tell(text, reload = false) {
  find("told").hidden = !text;
  find("told").firstElementChild.textContent = text ?? "";
  find("reload").hidden = !reload;
}

/** Show all of a text anew. */
async function refresh() {
  const mine = ++version, begun = performance.now();
  if (since && performance.now() - since > PATIENCE) stop();
  const late = setTimeout(() => state(document.documentElement.dataset.python === "" ? say().python : say().working), LATE);
  const isScene = await shows("scene", mine);
  clearTimeout(late);
  if (!isScene) return;
  const counts = say().counts(scene);
  state(`${counts} · ${say().working}`);
  for (const what of ["equations", "picture", ...["coefficients", "code", "motion", "lesson"].filter(one => open(`d-${one}`))]) {
    if (!(await shows(what, mine)) || mine !== version) return;
    if (what === "equations") state(`${counts} · ${Math.round(performance.now() - begun)} ms`);
  }
  document.body.dataset.shown = String(mine);
}

function changed() {
  clearTimeout(timer);
  version++;
  timer = setTimeout(refresh, REST);
}

const writing = editor(find("editor"), say().editor, () => { pulled = {}; changed(); });

/** Put a text into the editor, as a link, an example or a file says it, by whose name it is saved. */
function put(text, name, isFile = false) {
  fileName = isFile ? name : "";
  writing.text = text;
  find("editor").scrollTop = 0;
  pulled = {};
  find("name").textContent = name;
  clearTimeout(timer);
  return refresh();
}

// Coordinates that are pulled

function sliders(found) {
  const names = found.map(one => one.name).join();
  if (find("sliders").dataset.names !== names) {
    find("sliders").dataset.names = names;
    find("sliders").replaceChildren(...found.map(one => {
      const row = document.createElement("label"), name = document.createElement("span");
      const input = Object.assign(document.createElement("input"), { type: "range" }), output = document.createElement("output");
      name.textContent = one.name;
      input.addEventListener("input", () => pull(one.name, Number(input.value)));
      row.append(name, input, output);
      return row;
    }));
  }
  found.forEach((one, k) => {
    const [, input, output] = find("sliders").children[k].children;
    Object.assign(input, { min: one.low, max: one.high, step: (one.high - one.low) / 1000 || "any" });
    if (document.activeElement !== input || !pulling) input.value = one.value;
    output.textContent = `${Number(one.value.toPrecision(4))} ${one.unit === "1" ? "" : one.unit}`.replace("-", "−");
  });
}

async function pull(name, value) {
  delete pulled[name];
  pulled[name] = value; // the last one last
  if (pulling) return;
  pulling = true;
  for (let asked; asked !== JSON.stringify(pulled) && scene;) {
    asked = JSON.stringify(pulled);
    await shows("picture", version);
  }
  pulling = false;
}

find("back").addEventListener("click", () => { pulled = {}; shows("picture", version); });

// Links: the text, packed, behind the #; nothing of it leaves the browser

async function through(bytes, way, most = Infinity) {
  const reader = new Blob([bytes]).stream().pipeThrough(way).getReader(), parts = [];
  for (let size = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
    if ((size += value.length) > most) { await reader.cancel(); throw new RangeError(say().much); }
    parts.push(value);
  }
}

async function packed(text) {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  const letters = Array.from(bytes, one => String.fromCharCode(one)).join("");
  return btoa(letters).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

async function unpacked(link) {
  if (link.length > LONGEST_LINK) throw new RangeError(say().long);
  const bytes = Uint8Array.from(atob(link.replace(/-/g, "+").replace(/_/g, "/")), one => one.charCodeAt(0));
  const text = await through(bytes, new DecompressionStream("deflate-raw"), LONGEST_TEXT);
  return new TextDecoder("utf-8", { fatal: true }).decode(text);
}

async function linked() {
  if (!location.hash.startsWith("#s=")) return false;
  try {
    await put(await unpacked(location.hash.slice(3)), "scene.toml");
  } catch (fault) {
    tell(say().unreadable(fault instanceof RangeError ? fault.message : say().broken));
    return false;
  }
  return true;
}

find("share").addEventListener("click", async () => {
  const link = await packed(writing.text);
  if (link.length > LONGEST_LINK || new TextEncoder().encode(writing.text).length > LONGEST_TEXT) return tell(say().unlinked);
  history.replaceState(null, "", `#s=${link}`);
  try {
    await navigator.clipboard.writeText(location.href);
    tell(`${say().copied}. ${say().local}.`);
  } catch {
    tell(`${say().linked}. ${say().local}.`);
  }
});
addEventListener("hashchange", linked);

// Files

function downloaded(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = name.split("/").at(-1);
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

async function kept() {
  if (!followed?.own || followed.text === undefined) return downloaded(saved(), writing.text);
  const text = writing.text, answer = await save(text, written);
  if (answer.ended) return ended();
  if (answer.refused) return tell(answer.refused.join("\n"));
  written = text;
  tell(say().saved(answer.saved));
}

find("save").addEventListener("click", kept);
addEventListener("keydown", event => {
  if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); kept(); }
});
find("open").addEventListener("click", () => find("file").click());
find("file").addEventListener("change", async () => {
  const [file] = find("file").files;
  find("file").value = "";
  if (!file) return;
  if (file.size > LARGEST_FILE) return tell(say().huge);
  tell(null);
  followed = null;
  put(await file.text(), file.name, true);
});
find("examples").addEventListener("change", async () => {
  const name = find("examples").value, answer = await ask("example", "", { name });
  find("examples").value = "";
  if (answer.text === undefined) return;
  tell(null);
  followed = null;
  history.replaceState(null, "", location.pathname);
  put(answer.text, `${name}.toml`);
});
find("reload").addEventListener("click", () => { tell(null); written = followed.text; put(followed.text, followed.name, followed.own); });

/** Take what the file says that is followed: into the editor, unless a hand has changed that. */
function took(file) {
  if (!file) return;
  const before = followed;
  followed = { ...file, text: file.text ?? before?.text };
  if (file.text === undefined) return tell(`${file.name}: ${file.refused.join("\n")}`);
  if (before?.refused) tell(null);
  if (file.text === writing.text) { written = file.text; return; }
  if (before?.text !== undefined && writing.text !== written) return tell(say().changed(file.name), true);
  written = file.text;
  tell(null);
  put(file.text, file.name, file.own);
}

// Code

find("target").addEventListener("change", () => { remembered("target", find("target").value); shows("code", version); });
find("copy").addEventListener("click", () => navigator.clipboard?.writeText(find("code").textContent).then(() => {
  find("copy").textContent = say().taken;
  setTimeout(() => { find("copy").textContent = say().copy; }, 1500);
}));
find("download").addEventListener("click", () => { if (files[shownFile]) downloaded(shownFile, files[shownFile]); });

find("exercises").addEventListener("change", () => { if (scene) shows("lesson", version); });

// What is folded is not asked for

for (const one of document.querySelectorAll("details[data-keep]")) {
  const kept = remembered(one.id);
  if (kept) one.open = kept === "open";
  one.addEventListener("toggle", () => {
    remembered(one.id, one.open ? "open" : "closed");
    if (!one.dataset.asks) return;
    if (one.open && scene) shows(one.dataset.asks, version);
    if (!one.open && one.querySelector("iframe")) one.querySelector(".framed").replaceChildren();
  });
}

// NumPy and SciPy, on request where Python is in the page

function by(now = numbers) {
  numbers = now;
  const said = say()[now.is], made_by = say()[`by_${made}`];
  find("numerical").hidden = !numerical || !now.host;
  find("numerical").classList.toggle("bad", !!now.bad);
  find("numerical").firstElementChild.textContent = typeof said === "string" ? said : said(...(now.what ?? [now.host]));
  find("load").hidden = ["loading", "starting", "large"].includes(now.is);
  find("by").hidden = !made;
  find("by").textContent = typeof made_by === "function" ? made_by(...now.what) : made_by ?? "";
}

const million = bytes => (bytes / 1e6).toFixed(0);

find("load").addEventListener("click", async () => {
  const { host } = numbers;
  by({ is: "loading", host, what: ["NumPy", "0", ""] });
  try {
    const versions = await numerical.load((name, done, all) => by(done === undefined ? { is: "starting", host }
      : { is: "loading", host, what: [name, million(done), all ? million(all) : ""] }));
    by({ is: "large", host, what: [versions] });
  } catch (fault) {
    if (!fault.is) throw fault;
    by({ is: fault.is, host, what: [fault.what], bad: true });
  }
  refresh();
});

function speak() {
  document.documentElement.lang = language;
  find("language").value = language;
  for (const one of document.querySelectorAll("[data-t]")) {
    const text = say()[one.dataset.t];
    if (one.id !== "state" || !scene) one.textContent = text;
  }
  writing.label = say().editor;
  by();
}

find("language").addEventListener("change", () => {
  language = find("language").value;
  remembered("language", language);
  speak();
  refresh();
});

async function begin() {
  speak();
  numerical?.host.then(host => by({ ...numbers, host }));
  const known = await ask("begin", "");
  if (known.ended) return ended();
  writing.words = known.words;
  targets = known.targets;
  find("examples").append(...known.examples.map(name => new Option(name.replaceAll("_", " "), name)));
  find("target").append(...Object.entries(targets).map(([name, title]) => new Option(title, name)));
  find("target").value = targets[remembered("target")] ? remembered("target") : "numpy" in targets ? "numpy" : "c";
  const isLinked = await linked();
  let first = true;
  follow(file => {
    if (isLinked && first) { first = false; return; }
    first = false;
    if (file) took(file);
  }, ended);
  await later();
  if (isLinked) return;
  setTimeout(async () => {
    if (followed || writing.text) return;
    const { text } = await ask("example", "", { name: FIRST });
    if (!followed && !writing.text && text) put(text, `${FIRST}.toml`);
  }, 200);
}

begin();
