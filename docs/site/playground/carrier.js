// Who answers the page: Python in a worker of this browser. Nothing leaves it. What was answered beforehand is shown at
// once; what takes too long ends with its worker, and another one begins.

const LONGEST = 60000; // ms that an answer may take
const LARGEST = 100e6; // bytes of a file that is loaded on request

const manifest = fetch("manifest.json").then(found => found.json());
const before = manifest.then(async ({ parts }) => {
  const stream = (await fetch(parts.before)).body.pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
});

let worker = null, number = 0, large = null; // files of NumPy and SciPy, where they were asked for
const waiting = new Map();

/** Start Python; return the versions of NumPy and SciPy in it. */
function started() {
  document.documentElement.dataset.python = "";
  worker = new Worker("worker.js", { type: "module" });
  worker.postMessage({ files: large });
  return new Promise((done, failed) => {
    worker.onmessage = ({ data }) => {
      if (data.ready) { document.documentElement.dataset.python = "ready"; done(data.ready); }
      if (data.fault) failed(new Error(data.fault));
      waiting.get(data.id)?.(data.answer);
      waiting.delete(data.id);
    };
    worker.onerror = event => {
      const why = `the page could not start Python: ${event.message ?? "no module workers"}`;
      stopped(why);
      failed(new Error(why));
    };
  });
}

function stopped(why) {
  worker?.terminate();
  worker = null;
  for (const told of waiting.values()) told({ refused: [`no answer: ${why}`] });
  waiting.clear();
}

/** Return the answer to a question about a text: what `symdyn.playground.answer` returns. */
export async function ask(what, text, how = {}) {
  const asked = ["begin", "example"].includes(what) ? "" : text, question = JSON.stringify([what, asked, how]);
  const known = (await before)[question];
  if (!worker) started().catch(() => {}); // what is asked says it, too
  if (known && !(large && asked)) return { ...known, by: "before" };
  const id = ++number;
  const late = setTimeout(() => stopped(`it takes longer than ${LONGEST / 1000} s`), LONGEST);
  const answer = await new Promise(done => { waiting.set(id, done); worker.postMessage({ id, question }); });
  clearTimeout(late);
  return { ...answer, by: large ? "large" : "small" };
}

/** NumPy and SciPy on request, as Pyodide's lock names them: `load` tells how many bytes there are, and fails with why. */
export const numerical = {
  host: manifest.then(found => new URL(found.numerical.from).host),
  async load(told) {
    const { from, sha256 } = (await manifest).numerical, files = [];
    for (const name in sha256) files.push({ name, bytes: await checked(from + name, sha256[name], told) });
    told();
    stopped("Python begins again");
    large = files;
    try {
      return await started();
    } catch (fault) {
      stopped(fault.message);
      large = null;
      throw Object.assign(fault, { is: "unstarted", what: fault.message });
    }
  },
};

let way = "force-cache"; // what was loaded once is there, unless it was no good

/** Return a file once it is known to be the one that was published. */
async function checked(url, sha256, told) {
  const name = url.split("/").at(-1), fails = is => { way = "reload"; return Object.assign(new Error(is), { is, what: name }); };
  const parts = [];
  let size = 0;
  try {
    const answer = await fetch(url, { cache: way, credentials: "omit", referrerPolicy: "no-referrer" });
    if (!answer.ok) throw new Error(answer.status);
    for (const reader = answer.body.getReader(); ;) {
      const { done, value } = await reader.read();
      if (done) break;
      if ((size += value.length) > LARGEST) { await reader.cancel(); break; }
      parts.push(value);
      told(name, size, Number(answer.headers.get("Content-Length")));
    }
  } catch {
    throw fails("unreached");
  }
  const bytes = new Blob(parts);
  if (size > LARGEST || await hash(bytes) !== sha256) throw fails("another");
  return bytes;
}

async function hash(bytes) {
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", await bytes.arrayBuffer()));
  return Array.from(digest, one => one.toString(16).padStart(2, "0")).join("");
}

/** Answer no longer what is being answered. */
export const stop = async () => stopped("it was stopped");

/** There is no file of this machine that the page may write. */
export const save = async () => ({ refused: [] });

/** There is no file that is followed. */
export function follow() {}

if ("serviceWorker" in navigator) navigator.serviceWorker.register("offline.js").catch(() => {});
