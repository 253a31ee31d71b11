// Numbers

const printed = text => text.replace(/-/g, "\u2212").replace(".", data.words.point);
const shown = x => {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x) < 1e-12 ? 0 : Math.abs(x);
  if (size === 0) return "0";
  const text = size < 1e-3 || size >= 1e5 ? x.toExponential(2) : x.toFixed(size < 10 ? 4 : size < 1000 ? 3 : 1);
  return printed(text);
};
const tell = (element, x, text = shown(x)) => { element.textContent = text; element.dataset.value = String(x); };
const outputs = kind => all(`[data-out=${kind}]`);
const places = Object.fromEntries(["tau", "coefficient", "term", "q", "qd", "qdd", "exerted"].map(x => [x, outputs(x)]));
const bars = new Map(all("[data-bar]").map(bar => [Number(bar.dataset.bar), bar]));

const tables = () => {
  const results = {};
  const terms = data.terms.map(([name, entry, , sign, ...factors]) => {
    results[name] ??= call(name);
    const coefficient = results[name][entry];
    return { coefficient, value: factors.reduce((x, [kind, k]) => x * state[kind][k], sign * coefficient) };
  });
  const tau = call(data.total);
  for (const element of places.tau) tell(element, tau[element.dataset.k]);
  for (const group of ["q", "qd", "qdd"]) {
    for (const element of places[group]) tell(element, state[group][element.dataset.k]);
  }
  if (places.exerted.length) {
    const at = { ...state, tau: call("inverse_dynamics") }, found = { inverse_dynamics: at.tau };
    if (has("multipliers")) found.multipliers = call("multipliers", at);
    for (const element of places.exerted) tell(element, found[element.dataset.function][element.dataset.k]);
  }
  for (const element of places.coefficient) tell(element, terms[element.dataset.k].coefficient);
  for (const element of places.term) tell(element, terms[element.dataset.k].value);
  const most = new Float64Array(n);
  data.terms.forEach(([, , row], k) => { most[row] = Math.max(most[row], Math.abs(terms[k].value) || 0); });
  for (const [k, bar] of bars) {
    const share = most[data.terms[k][2]] > 0 ? terms[k].value / most[data.terms[k][2]] : 0;
    bar.classList.toggle("minus", share < 0);
    bar.style.width = 50 * Math.abs(share) + "%";
    bar.style.left = 50 + 50 * Math.min(0, share) + "%";
  }
};

const sliders = all("input[data-group]").map(input => ({
  input, group: input.dataset.group, k: Number(input.dataset.k), range: input.type === "range",
}));
/** Returns where a slider stands: one that goes once round takes up a turn. */
const onRange = (x, low, high) => Math.abs(high - low - 2 * Math.PI) < 1e-9 ? x - 2 * Math.PI * Math.floor((x - low) / (2 * Math.PI)) : x;
const follow = except => {
  for (const { input, group, k, range } of sliders) {
    if (input === except) continue;
    const x = group === "t" ? state.t : state[group][k];
    if (!Number.isFinite(x)) {
      if (!range) input.value = "";
    } else input.value = range ? onRange(x, Number(input.min), Number(input.max)) : String(Math.abs(x) < 1e-12 ? 0 : Number(x.toPrecision(5)));
  }
};

