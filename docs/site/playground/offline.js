// What was loaded once is there without a network. A new manifest takes the place of the old one, and of all its files.

const NAME = "symdyn-playground";

self.addEventListener("install", () => self.skipWaiting());
self.addEventListener("activate", event => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", event => {
  const url = new URL(event.request.url), own = new URL("./", self.location).href;
  if (event.request.method !== "GET" || !url.href.startsWith(own)) return;
  event.respondWith(/-[0-9a-f]{16}\.gz$/.test(url.pathname) ? kept(event.request) : fresh(event.request));
});

async function kept(request) {
  const cache = await caches.open(NAME);
  return (await cache.match(request)) ?? stored(cache, request);
}

async function fresh(request) {
  const cache = await caches.open(NAME);
  try {
    return await stored(cache, request);
  } catch (fault) {
    const old = await cache.match(request, { ignoreSearch: true });
    if (old) return old;
    throw fault;
  }
}

async function stored(cache, request) {
  const answer = await fetch(request);
  if (!answer.ok) return answer;
  await cache.put(request, answer.clone());
  if (request.url.endsWith("/manifest.json")) {
    const { parts } = await answer.clone().json(), names = new Set(Object.values(parts));
    for (const one of await cache.keys()) {
      const name = one.url.split("/").at(-1);
      if (name.endsWith(".gz") && !names.has(name)) await cache.delete(one);
    }
  }
  return answer;
}
