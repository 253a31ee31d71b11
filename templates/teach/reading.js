// A page that is read: the figure follows the step, terms and vectors point at each other, numbers stand under terms.
"use strict";
(() => {
const figure = document.querySelector(`.live-figure[data-live="${READING.name}"]`);
const live = symdyn[READING.name];
const every = (selector, within = document) => [...within.querySelectorAll(selector)];

// Formulas: each piece between places where a line may end is a term

const terms = [];
const wrapped = (flow, first, number, about) => {
  const term = document.createElement("span"), inside = document.createElement("span");
  term.className = "t";
  const pieces = [];
  for (let node = first; node && node.nodeName !== "WBR"; node = node.nextSibling) pieces.push(node);
  flow.insertBefore(term, first);
  term.append(inside);
  inside.append(...pieces);
  const last = inside.lastChild;
  if (last.nodeType === Node.TEXT_NODE && !last.data.trim()) term.after(last); // the space before the end of a line
  const shown = document.createElement("span");
  shown.className = "n";
  term.append(shown);
  const one = { term, shown, flow, number: number === "-" ? -1 : Number(number), about: about === "-" ? "" : about };
  terms.push(one);
  return term;
};
for (const flow of every(".flow[data-n], .flow[data-at]")) {
  const starts = [flow.firstChild, ...every(":scope > wbr", flow).map(end => end.nextSibling)].filter(Boolean);
  const [numbers, about] = [flow.dataset.n, flow.dataset.at].map(list => list?.split("|") ?? []);
  starts.forEach((first, k) => wrapped(flow, first, numbers[k] ?? "-", about[k] ?? "-"));
}
const byFlow = Map.groupBy ? Map.groupBy(terms, one => one.flow) : terms.reduce((found, one) => found.set(one.flow, [...found.get(one.flow) ?? [], one]), new Map());

// Numbers: as many decimals in all terms of a formula, so that they add up as they are read

const written = (x, decimals, signed) => {
  const text = Math.abs(x).toFixed(decimals), zero = Number(text) === 0;
  return ((x < 0 && !zero ? "\u2212" : signed ? "+" : "") + text).replace(".", READING.point);
};
const number = flow => {
  const shown = byFlow.get(flow), numbered = shown.filter(one => one.number >= 0);
  const size = Math.max(...numbered.map(one => Math.abs(values[one.number])));
  const decimals = size >= 1000 ? 1 : size >= 10 ? 2 : size >= 0.1 || !(size > 0) ? 3 : Math.min(8, 3 - Math.floor(Math.log10(size)));
  let behind = false;
  for (const { shown: at, term, number: k } of numbered) {
    const x = values[k], signed = /^[+\u2212]/.test(term.textContent.trim());
    const text = Number.isFinite(x) ? written(x, decimals, signed && behind) : "–";
    behind = true;
    if (at.textContent !== text) at.textContent = text;
  }
};
let values = live.named(), near = new Set(), waiting = 0;
const renew = () => {
  waiting = 0;
  if (!document.body.classList.contains("numbers")) return;
  values = live.named();
  for (const flow of near) number(flow);
};
const SOON = 100; // ms from one set of numbers to the next while it moves
const due = () => { waiting ||= setTimeout(renew, SOON); };
const nearby = new IntersectionObserver(seen => {
  for (const { target, isIntersecting } of seen) near[isIntersecting ? "add" : "delete"](target);
  due();
}, { rootMargin: "25% 0px" });
for (const [flow, shown] of byFlow) {
  if (!shown.some(one => one.number >= 0)) continue;
  number(flow);
  nearby.observe(flow);
}
figure.addEventListener("symdyn:state", due);

// Formulas that are wider than the page scroll by keys too

const reachable = () => {
  for (const flow of every(".flow, .text p")) {
    if (flow.querySelector('[tabindex="0"]')) continue;
    if (flow.scrollWidth > flow.clientWidth) flow.tabIndex = 0;
    else flow.removeAttribute("tabindex");
  }
};
for (const event of ["resize", "toggle", "submit"]) addEventListener(event, () => setTimeout(reachable), true);

// Contents: folded where the window is narrow; the section that is read is marked

const contents = document.querySelector("nav details"), here = contents.querySelector(".here");
const entries = new Map(every("a", contents).map(link => [link.hash.slice(1), link]));
const marked = section => {
  for (const link of entries.values()) link.removeAttribute("aria-current");
  const link = entries.get(section.id);
  link?.setAttribute("aria-current", "true");
  here.textContent = link ? `${[...entries.keys()].indexOf(section.id) + 1} ${link.textContent}` : "";
};
document.body.classList.add("moves"); // the figure that moves stands for the one that does not
contents.open = matchMedia("(min-width: 64rem)").matches;
contents.addEventListener("click", event => { // a section that is folded as a whole is opened on the way to it
  const whole = document.querySelector(`${event.target.closest("a")?.hash || "nothing"} > .whole`);
  if (whole) whole.open = true;
});

// The step that is read: the first that begins in the upper part of what is seen of the text, else the last above it

const all = every(".step");
let now = null;
const read = step => {
  if (!step || step === now) return;
  now?.classList.remove("now");
  now = step;
  now.classList.add("now");
  marked(now.closest("section"));
  if (pointed && document.activeElement !== pointed.term) point(null); // a focus that scrolls the page keeps its term
  let shown = step;
  while (shown && !shown.dataset.show) shown = all[all.indexOf(shown) - 1];
  if (shown) live.show(shown.dataset.show.split(" "));
};
const wide = matchMedia("(min-width: 64rem)"), picture = figure.querySelector("svg.symdyn");
const UPPER = 0.4;
let scrolled = 0;
const look = () => {
  scrolled = 0;
  const steps = all.filter(step => !step.hidden && !step.closest("details:not([open])")); // not yet there, or folded
  if (!steps.length) return;
  const top = wide.matches ? 0 : picture.getBoundingClientRect().bottom, at = top + UPPER * (innerHeight - top);
  const begins = k => steps[k].getBoundingClientRect().top;
  let low = 0, high = steps.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (begins(middle) <= at) low = middle;
    else high = middle;
  }
  while (low > 0 && begins(low - 1) >= top) low -= 1;
  read(steps[low]);
};
const followed = () => { scrolled ||= requestAnimationFrame(look); };
addEventListener("scroll", followed, { passive: true });
addEventListener("resize", followed);
document.addEventListener("toggle", () => { reachable(); followed(); }, true);

// Terms and vectors

const kindOf = about => about.split(/[:/]/)[0];
const bodyOf = about => about.includes(":") ? about.slice(about.indexOf(":") + 1) : "";
let pointed = null;
const point = one => {
  if (one === pointed) return;
  for (const other of every(".t.hot")) other.classList.remove("hot");
  pointed = one;
  if (!one) { live.focus(null); return; }
  one.term.classList.add("hot");
  const [what, of] = one.about.split("/");
  live.focus({ kind: kindOf(what), body: bodyOf(what), ...(of ? { of: of.split(",").map(Number) } : {}) });
};
for (const [flow, shown] of byFlow) {
  const pointing = shown.filter(one => one.about);
  pointing.forEach((one, k) => {
    const { term } = one;
    term.classList.add("points");
    term.tabIndex = k ? -1 : 0;
    term.setAttribute("role", "group");
    term.setAttribute("aria-roledescription", READING.term);
    term.addEventListener("pointerenter", () => point(one));
    term.addEventListener("pointerleave", event => { if (event.pointerType !== "touch" && document.activeElement !== term) point(null); });
    term.addEventListener("focus", () => point(one));
    term.addEventListener("blur", () => point(null));
    term.addEventListener("click", () => { term.focus({ preventScroll: true }); point(one); });
    term.addEventListener("keydown", event => {
      if (event.key === "Escape") { term.blur(); return; }
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const next = step && pointing[k + step];
      if (!next) return;
      event.preventDefault();
      term.tabIndex = -1;
      next.term.tabIndex = 0;
      next.term.focus();
    });
  });
}
const answering = vector => {
  const kind = vector.slice(0, vector.indexOf(":")), owner = vector.slice(vector.indexOf(":") + 1);
  for (const { term, about } of terms) {
    if (!about || !now?.contains(term)) continue;
    const what = about.split("/")[0], body = bodyOf(what);
    term.classList.toggle("hot", kindOf(what) === kind && (!body || body === owner));
  }
};
figure.addEventListener("pointerover", event => {
  const vector = event.target.closest?.("[data-vector]");
  if (vector) answering(vector.dataset.vector);
});
figure.addEventListener("pointerout", event => {
  if (event.target.closest?.("[data-vector]") && !pointed) for (const { term } of terms) term.classList.remove("hot");
});

// Sliders at sentences: they move a parameter or a rate of the figure, from where it begins, and let it play; and a line of a
// chart that is at the parameter's value, whose axis goes as far as the slider

for (const slider of every("[data-try]")) {
  const [group, k] = slider.dataset.try.split(" "), output = slider.closest("p").querySelector("output");
  const level = every(".level", slider.closest("article")).at(-1), axis = level?.ownerSVGElement.querySelector(".stem");
  const tell = () => {
    output.textContent = written(live.state()[group][k], 3, false);
    const way = axis ? (begin - slider.valueAsNumber) / Number(slider.max) * axis.getBBox().height : 0;
    level?.setAttribute("transform", `translate(0 ${way})`);
  };
  slider.value = live.state()[group][k];
  const begin = slider.valueAsNumber;
  tell();
  slider.addEventListener("input", () => { live.set(Number(k), slider.valueAsNumber, group); tell(); });
  figure.addEventListener("symdyn:state", () => { if (document.activeElement !== slider) slider.value = live.state()[group][k]; tell(); });
}

// Whether numbers are shown

const box = figure.querySelector("[data-do=numbers]");
const choose = () => {
  document.body.classList.toggle("numbers", box.checked);
  due();
};
if (box) {
  box.addEventListener("change", choose);
  choose();
}
look();
reachable();
})();
