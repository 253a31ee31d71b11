// Python in a worker: the page never waits for it. What it loads is checked by the manifest.

import { loadPyodide } from "./pyodide/pyodide.mjs";

const published = fetch("manifest.json").then(found => found.json()); // awaited nowhere here: what is asked meanwhile is lost

async function part(name) {
  const manifest = await published, file = manifest.parts[name], bytes = await (await fetch(file)).arrayBuffer();
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  const hash = Array.from(digest, one => one.toString(16).padStart(2, "0")).join("");
  if (hash !== manifest.sha256[file]) throw new Error(`${file} is not what was published`);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Put the files of a tar below /packages. */
function unpacked(tar) {
  const letters = new TextDecoder(), field = (at, n) => letters.decode(tar.subarray(at, at + n)).replace(/\0.*$/s, "");
  for (let at = 0; at + 512 <= tar.length && tar[at];) {
    const prefix = field(at + 345, 155), size = parseInt(field(at + 124, 12), 8);
    const path = `/packages/${prefix ? `${prefix}/` : ""}${field(at, 100)}`;
    python.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    python.FS.writeFile(path, tar.slice(at + 512, at + 512 + size), { canOwn: true });
    at += 512 + 512 * Math.ceil(size / 512);
  }
}

const BEGIN = `
import sys
sys.dont_write_bytecode = True
sys.path.insert(0, "/packages")
`;

const SMALL = "sys.path.append('/packages/standin'); None"; // in place of NumPy, where nobody has asked for it

const LARGE = `
import json, numpy, scipy, scipy.integrate, scipy.linalg
json.dumps({"numpy": numpy.__version__, "scipy": scipy.__version__})
`;

const READY = `
import importlib, json, sys
importlib.invalidate_caches()
from symdyn.playground.answers import answer

def answered(question):
    what, text, how = json.loads(question)
    return json.dumps(answer(what, text, how))

for name in ("js", "pyodide_js", "_pyodide_core"):  # nothing of Python reaches the page any more
    sys.modules[name] = None
`;

const AT_ONCE = ["scene", "equations"]; // what the files that travel first are enough for

let python, answered, rest, begin;
const first = [part("flint"), part("first")];
const given = new Promise(done => { begin = done; });

/** Install NumPy and SciPy by Pyodide's own hand from files that were checked; return their versions. */
async function installed(files) {
  const over = fetch;
  self.fetch = (url, ...how) => {
    const file = files.find(({ name }) => String(url).endsWith(`/${name}`));
    return file ? Promise.resolve(new Response(file.bytes)) : over(url, ...how);
  };
  for (const one of ["rest", "library"].map(part)) unpacked(await one);
  const faults = [];
  await python.loadPackage(["numpy", "scipy"], { messageCallback() {}, errorCallback: line => faults.push(line) });
  self.fetch = over;
  if (faults.length) throw new Error(faults.join("\n"));
  return JSON.parse(python.runPython(LARGE));
}

async function started() {
  python = await loadPyodide({ indexURL: new URL("./pyodide/", import.meta.url).href });
  python.runPython(BEGIN);
  for (const one of first) unpacked(await one);
  const files = await given, versions = files ? await installed(files) : python.runPython(SMALL) ?? {};
  python.runPython(READY);
  answered = python.globals.get("answered");
  rest = files ? null : part("rest").then(unpacked);
  return versions;
}

const ready = started();
let last = Promise.resolve();
onmessage = ({ data: { id, question, files } }) => {
  if (!question) return begin(files);
  last = last.then(async () => {
    let answer;
    try {
      await ready;
      let text = AT_ONCE.includes(JSON.parse(question)[0]) ? answered(question) : null;
      if (text === null || text.startsWith('{"failed"')) {
        await rest;
        text = answered(question);
      }
      answer = JSON.parse(text);
    } catch (fault) {
      answer = { failed: `the page could not start Python: ${String(fault).slice(-300)}` };
    }
    postMessage({ id, answer });
  });
};
ready.then(versions => postMessage({ ready: versions }), fault => postMessage({ fault: String(fault.message).trim().split("\n").at(-1).slice(-300) }));
