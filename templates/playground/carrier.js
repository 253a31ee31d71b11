// Who answers the page: here the server that served it, behind which there is Python. Another carrier offers the same.

const here = new URL("./", location.href).href;

async function sent(path, value) {
  const answer = await fetch(here + path, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(value),
  });
  if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
  return answer.json();
}

/** NumPy and SciPy are there. */
export const numerical = null;

/** Return the answer to a question about a text: what `symdyn.playground.answer` returns. */
export async function ask(what, text, how = {}) {
  try {
    return await sent("answer", { what, text, how });
  } catch {
    return { ended: true };
  }
}

/** Answer no longer what is being answered. */
export const stop = () => sent("stop", {}).catch(() => {});

/** Write the file that is followed, if it says `before`; return who wrote it, or why nobody did. */
export const save = (text, before) => sent("save", { text, before }).catch(() => ({ ended: true }));

/** Tell what the file that is followed says, now and when it changes, and when nobody answers any more. */
export function follow(told, ended) {
  const events = new EventSource(here + "events");
  events.addEventListener("file", event => told(JSON.parse(event.data)));
  events.addEventListener("error", ended);
}
