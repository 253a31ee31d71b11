// Numbers

const printed = text => text.replace(/-/g, "\u2212").replace(".", data.words.point);
const shown = x => {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x) < 1e-12 ? 0 : Math.abs(x);
  if (size === 0) return "0";
  const text = size < 1e-3 || size >= 1e5 ? x.toExponential(2) : x.toFixed(size < 10 ? 4 : size < 1000 ? 3 : 1);
  return printed(text);
};
const tell = (element, x, text = shown(x)) => {
  if (element.textContent !== text) element.textContent = text;
  element.dataset.value = String(x);
};
/** What tells the numbers of one block of the page: those of a kind in it, and what each is worth by its data. */
const telling = (within, kind, value) => {
  const found = [...within.querySelectorAll(`[data-out=${kind}]`)];
  return known => { for (const element of found) tell(element, value(known, element.dataset)); };
};
const coefficient = (known, k) => {
  const [name, entry] = data.terms[k];
  return (known[name] ??= call(name))[entry];
};
const termOf = (known, k) => {
  const [, , , sign, ...factors] = data.terms[k];
  return factors.reduce((x, [kind, i]) => x * state[kind][i], sign * coefficient(known, k));
};
const exertedBy = (known, name) => {
  known.at ??= { ...state, tau: call("inverse_dynamics") };
  return known[`exerted ${name}`] ??= name === "inverse_dynamics" ? known.at.tau : call(name, known.at);
};
const tableOf = table => {
  const bars = [...table.querySelectorAll("[data-bar]")].map(bar => [bar, Number(bar.dataset.bar)]);
  let most = 0;
  const told = [
    telling(table, "tau", (known, { k }) => {
      const tau = (known.total ??= call(data.total))[k];
      return Math.abs(tau) < 1e-10 * most ? 0 : tau;  // of terms that cancel
    }),
    telling(table, "coefficient", (known, { k }) => coefficient(known, k)),
    telling(table, "term", (known, { k }) => termOf(known, k)),
    telling(table, "exerted", (known, { function: name, k }) => exertedBy(known, name)[k]),
  ];
  return known => {
    const worth = bars.map(([, k]) => termOf(known, k));
    most = Math.max(0, ...worth.map(x => Math.abs(x) || 0));
    for (const tell of told) tell(known);
    bars.forEach(([bar], i) => {
      const share = most > 0 ? worth[i] / most : 0;
      bar.classList.toggle("minus", share < 0);
      bar.style.transform = `scaleX(${share})`;
    });
  };
};

const sliders = all("input[data-group]").map(input => ({
  input, group: input.dataset.group, k: Number(input.dataset.k), range: input.type === "range",
}));
/** Returns where a slider stands: one that goes once round takes up a turn. */
const onRange = (x, low, high) => Math.abs(high - low - 2 * Math.PI) < 1e-9 ? x - 2 * Math.PI * Math.floor((x - low) / (2 * Math.PI)) : x;
const rowsOf = box => {
  const inside = sliders.filter(one => box.contains(one.input));
  const told = ["q", "qd", "qdd"].map(group => telling(box, group, (_, { k }) => state[group][k]));
  return (known, except) => {
    for (const tell of told) tell(known);
    for (const { input, group, k, range } of inside) {
      if (input === except) continue;
      const x = group === "t" ? state.t : state[group][k];
      if (!Number.isFinite(x)) {
        if (!range) input.value = "";
      } else input.value = range ? onRange(x, Number(input.min), Number(input.max)) : String(Math.abs(x) < 1e-12 ? 0 : Number(x.toPrecision(5)));
    }
  };
};

// Blocks of the panel: all at once where it stands; while it moves one a picture in turn, of those in the window

const blocks = [...all(".live-rows").map(box => [box, rowsOf(box)]), ...all(".live-panel table").map(box => [box, tableOf(box)])];
const near = new Set();
const nearby = new IntersectionObserver(found => {
  for (const { target, isIntersecting } of found) near[isIntersecting ? "add" : "delete"](target);
}, { rootMargin: "10%" });
for (const [box] of blocks) nearby.observe(box);
let turn = 0;
const panel = except => {
  const known = {};
  if (!running) {
    for (const [, tell] of blocks) tell(known, except);
    return;
  }
  const next = [...blocks.keys()].map(k => (turn + k) % blocks.length).find(k => near.has(blocks[k][0]));
  if (next === undefined) return;
  turn = next + 1;
  blocks[next][1](known, except);
};
