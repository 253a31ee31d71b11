// Who answers the page: Python in a worker of this browser. Nothing leaves it. What was answered beforehand is shown at
// once; what takes too long ends with its worker, and another one begins.

const LONGEST = 60000; // ms that an answer may take

const manifest = fetch("manifest.json").then(found => found.json());
const before = manifest.then(async ({ parts }) => {
  const stream = (await fetch(parts.before)).body.pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
});

let worker = null, number = 0;
const waiting = new Map();

function started() {
  document.documentElement.dataset.python = "";
  worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }) => {
    if (data.ready) document.documentElement.dataset.python = "ready";
    waiting.get(data.id)?.(data.answer);
    waiting.delete(data.id);
  };
  worker.onerror = event => stopped(`the page could not start Python: ${event.message ?? "no module workers"}`);
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
  if (!worker) started();
  if (known) return known;
  const id = ++number;
  const late = setTimeout(() => stopped(`it takes longer than ${LONGEST / 1000} s`), LONGEST);
  const answer = await new Promise(done => { waiting.set(id, done); worker.postMessage({ id, question }); });
  clearTimeout(late);
  return answer;
}

/** Answer no longer what is being answered. */
export const stop = async () => stopped("it was stopped");

/** There is no file of this machine that the page may write. */
export const save = async () => ({ refused: [] });

/** There is no file that is followed. */
export function follow() {}

if ("serviceWorker" in navigator) navigator.serviceWorker.register("offline.js").catch(() => {});
