// Plots: energies and coordinates over time, and the phase portrait, with axes in units

const STRIP = 10; // seconds of the motion that plots over time are wide
const WIDE = 360, HIGH = 150, LEFT = 46, RIGHT = 352, TOP = 10, BOTTOM = 122;
/** Returns round numbers from low to high, about `count` of them, and how many decimals they have. */
const ticked = (low, high, count) => {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(x => x * power >= rough * 0.999) * power, found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
};
/** A plot in an svg element: returns what draws axes for ranges, and paths in its coordinates. */
const chart = (svg, right = RIGHT) => {
  const part = (tag, look) => add(tag, look, svg);
  const grid = part("path", "grid"), names = part("g", ""), bottom = part("text", "end"), side = part("text", "start");
  bottom.setAttribute("x", right); bottom.setAttribute("y", HIGH - 4);
  side.setAttribute("x", 4); side.setAttribute("y", 9);
  let told = "", x, y;
  const axes = (xs, ys, below, beside) => {
    x = value => LEFT + (right - LEFT) * (value - xs[0]) / (xs[1] - xs[0]);
    y = value => BOTTOM - (BOTTOM - TOP - 6) * (value - ys[0]) / (ys[1] - ys[0]);
    const said = [...xs, ...ys].map(one => one.toPrecision(5)).join();
    if (said === told) return;
    told = said;
    const [across, dx] = ticked(...xs, 5), [up, dy] = ticked(...ys, 4);
    grid.setAttribute("d", across.map(v => `M${x(v).toFixed(1)} ${TOP + 6}V${BOTTOM}`).join("") + up.map(v => `M${LEFT} ${y(v).toFixed(1)}H${right}`).join(""));
    names.innerHTML = across.map(v => `<text x="${x(v).toFixed(1)}" y="${BOTTOM + 13}">${printed(v.toFixed(dx))}</text>`).join("")
      + up.map(v => `<text class="end" x="${LEFT - 4}" y="${(y(v) + 3.5).toFixed(1)}">${printed(Math.abs(v) >= 1e5 ? v.toExponential(0) : v.toFixed(dy))}</text>`).join("");
    bottom.textContent = below;
    side.textContent = beside;
  };
  return { axes, part, at: (a, b) => [x(a), y(b)], x: v => x(v), y: v => y(v), right };
};
const spread = (low, high) => {
  const most = Math.max(Math.abs(low), Math.abs(high), 1e-6), wide = Math.max(high - low, 0.02 * most);
  return [(low + high - 1.1 * wide) / 2, (low + high + 1.1 * wide) / 2];
};
const panels = Object.fromEntries(["energies", "plots", "phase"].map(name => [name, one(`[data-panel=${name}]`)]));
const drawing = name => panels[name].querySelector("svg");

// Energies

const SERIES = ["live-k", "live-p", "live-e"];
const ENERGY = chart(drawing("energies"), 306);
const curves = SERIES.map(look => ENERGY.part("path", `line ${look}`)), pillars = SERIES.map(look => ENERGY.part("path", `bar ${look}`));
const span = () => { const start = history.length ? history[0].t : state.t; return [start, start + STRIP]; };
const traced = (x, y, points) => points.map((at, i) => `${i ? "L" : "M"}${x(at.t).toFixed(1)} ${y(at).toFixed(1)}`).join("");
const plotEnergies = now => {
  const values = [0, ...now, ...history.flatMap(at => at.energies)];
  ENERGY.axes(span(), spread(Math.min(...values), Math.max(...values)), "t, s", data.words.joules);
  const zero = ENERGY.y(0).toFixed(1);
  SERIES.forEach((_, k) => {
    curves[k].setAttribute("d", history.length > 1 ? traced(ENERGY.x, at => ENERGY.y(at.energies[k]), history) : "");
    pillars[k].setAttribute("d", `M${316 + 14 * k} ${zero}V${ENERGY.y(now[k]).toFixed(1)}`);
  });
};

// Coordinates over time: those of one unit share a plot; the others wait for the choice

const TIMES = chart(drawing("plots")), lines = [];
const chosen = panels.plots.querySelector("select");
const plotTimes = () => {
  const kind = data.plotted[chosen.selectedIndex];
  const series = kind.rows.map(k => at => at[kind.group][k]);
  const points = history.length ? history : [{ t: state.t, q: state.q, qd: state.qd, params: state.params }];
  const values = [0, ...points.flatMap(at => series.map(of => of(at)))];
  TIMES.axes(span(), spread(Math.min(...values), Math.max(...values)), "t, s", kind.unit);
  series.forEach((of, i) => {
    lines[i] ??= TIMES.part("path", `line ${colour(i)}`);
    lines[i].setAttribute("d", traced(TIMES.x, at => TIMES.y(of(at)), points.length > 1 ? points : []));
  });
  lines.slice(series.length).forEach(line => line.setAttribute("d", ""));
};

// Phase portrait: a coordinate against its rate; pointing into it starts there

const PHASE = chart(drawing("phase")), flow = PHASE.part("path", "flow"), orbit = PHASE.part("path", "line live-k"), spot = PHASE.part("circle", "spot");
spot.setAttribute("r", 5);
const pairing = panels.phase.querySelector("select");
const pair = () => data.pairs[pairing ? pairing.selectedIndex : 0];
const limits = (group, k) => {
  const range = one(`input[type=range][data-group=${group}][data-k="${k}"]`);
  if (range) return [Number(range.min), Number(range.max)];
  const seen = [state, ...history].map(at => at[group][k]), most = 1.2 * Math.max(1, ...seen.map(Math.abs));
  return [-most, most];
};
let flowing = "";
/** Short strokes along the motion of one free coordinate: what the portrait looks like before it is started. */
const plotFlow = ([i, k], xs, ys) => {
  const told = [...xs, ...ys, ...state.params].join();
  if (told === flowing || n > 1 || data.loops || data.led.length || data.own.length || !has("forward_dynamics")) return;
  flowing = told;
  const strokes = [];
  for (let a = 0; a <= 20; a++) {
    for (let b = 0; b <= 10; b++) {
      const q = xs[0] + (xs[1] - xs[0]) * a / 20, u = ys[0] + (ys[1] - ys[0]) * b / 10;
      const at = { ...state, q: exchanged(state.q, i, q), qd: exchanged(state.qd, k, u) };
      const rate = call("forward_dynamics", at)[k];
      const [x, y] = unit([(PHASE.right - LEFT) * u / (xs[1] - xs[0]), -(BOTTOM - TOP - 6) * rate / (ys[1] - ys[0])]);
      const [px, py] = PHASE.at(q, u);
      strokes.push(line([px - 4 * x, py - 4 * y], [px + 4 * x, py + 4 * y]));
    }
  }
  flow.setAttribute("d", strokes.join(""));
};
const plotPhase = () => {
  if (!data.pairs.length) return;
  const [i, k, below, beside] = pair(), xs = limits("q", i), ys = limits("qd", k);
  PHASE.axes(xs, ys, below, beside);
  plotFlow(pair(), xs, ys);
  let before = null;
  orbit.setAttribute("d", history.map(at => {
    const x = onRange(at.q[i], ...xs), broken = before === null || Math.abs(x - before) > (xs[1] - xs[0]) / 2;
    before = x;
    const [px, py] = PHASE.at(x, at.qd[k]);
    return `${broken ? "M" : "L"}${px.toFixed(1)} ${py.toFixed(1)}`;
  }).join(""));
  put(spot, PHASE.at(onRange(state.q[i], ...xs), state.qd[k]));
};
/** Starts at a place of the portrait. */
const begunAt = (x, u) => {
  const [i, k] = pair(), xs = limits("q", i);
  const [next, there] = moved(state, "q", i, x, xs[1] - xs[0]);
  state = fitted(obeyed({ ...next, qd: exchanged(next.qd, k, u) }));
  lost.textContent = there ? "" : data.words.open;
  rebase();
  show();
};
drawing("phase").addEventListener("pointerdown", event => {
  if (!data.pairs.length) return;
  event.preventDefault();
  const svg = drawing("phase"), { x: px, y: py } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const [i, k] = pair(), xs = limits("q", i), ys = limits("qd", k), share = (value, a, b) => Math.max(0, Math.min(1, (value - a) / (b - a)));
  begunAt(xs[0] + (xs[1] - xs[0]) * share(px, LEFT, RIGHT), ys[0] + (ys[1] - ys[0]) * share(py, BOTTOM, TOP + 6));
  if (!play.disabled) run(true);
});
drawing("phase").addEventListener("keydown", event => {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (!way || !data.pairs.length) return;
  event.preventDefault();
  const [i, k] = pair(), xs = limits("q", i), ys = limits("qd", k);
  begunAt(state.q[i] + way[0] * (xs[1] - xs[0]) / 40, state.qd[k] + way[1] * (ys[1] - ys[0]) / 40);
});
for (const choice of [chosen, pairing]) choice?.addEventListener("change", () => plotted(true));

const single = Object.fromEntries(["t", "K", "P", "E", "drift"].map(name => [name, one(`[data-out=${name}]`)]));
const RAISED = Object.fromEntries([..."-0123456789"].map((x, i) => [x, "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"[i]]));
const OFTEN = 50; // ms from one drawing of a plot to its next while it moves; no two are drawn in one picture
const plotEnergiesNow = () => {
  const K = call("kinetic_energy"), P = call("potential_energy");
  plotEnergies([K, P, K + P]);
};
const PLOTS = { energies: plotEnergiesNow, plots: plotTimes, phase: plotPhase };
let plottedAt = 0, plotNext = 0, energetic = 0;
const plotted = (always = !running) => {
  const now = performance.now(), open = Object.keys(PLOTS).filter(name => !panels[name].hidden);
  if (!open.length || (!always && now - plottedAt < OFTEN / open.length)) return;
  plottedAt = now;
  for (const name of always ? open : [open[plotNext++ % open.length]]) PLOTS[name]();
};
const energies = () => {
  const K = call("kinetic_energy"), P = call("potential_energy");
  tell(single.t, state.t);
  tell(single.K, K);
  tell(single.P, P);
  tell(single.E, K + P);
  const drift = K + P - first - state.W;
  if (!history.length) energetic = 0;
  energetic = Math.max(energetic, K, Math.abs(K + P), Math.abs(state.W));
  tell(single.drift, drift, drift === 0 ? "0" : `10${[...String(Math.ceil(Math.log10(Math.abs(drift))))].map(x => RAISED[x]).join("")}`);
  if (Math.abs(drift) > 1e-9 * energetic && running && !lost.textContent) lost.textContent = data.words.leaks;
  if (history.length > 1 && state.t - history.at(-2).t < STRIP / 600) history.pop();
  history.push({ t: state.t, energies: [K, P, K + P], q: state.q, qd: state.qd, params: state.params });
  while (history[0].t < state.t - STRIP) history.shift();
  plotted();
};
