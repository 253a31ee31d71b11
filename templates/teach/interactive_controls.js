// Controls

const show = except => {
  draw();
  energies();
  panel(except);
};
let before = null;
const play = one("[data-do=play]"), speed = one("[data-do=speed]"), drives = one("[data-do=drives]"), lost = one("[data-out=lost]");
/** Begins a motion with the drives that are chosen: that of the run where the state is of it, or is the first one. */
const driven = () => {
  const t = drives.value === "held" ? null : playedFrom();
  state = { ...state, tau: drives.value === "held" ? call("inverse_dynamics") : new Float64Array(n) };
  rebase();
  if (t !== null) state = replayed(t);
};
const run = on => {
  running = on;
  before = null;
  play.textContent = on ? data.words.pause : data.words.play;
  if (!on) {
    show();
    return;
  }
  lost.textContent = "";
  driven();
  requestAnimationFrame(tick);
};
const LONG = 3; // ms that a picture's share of the motion takes at most; beyond that it falls behind the clock
/** Moves on by some seconds; returns whether the motion is still one. */
const moveOn = seconds => {
  if (ofRun.has(state)) {
    state = replayed(Math.min(ended, state.t + seconds));
    show();
    if (state.t >= ended && running) run(false);
    return running;
  }
  const next = advanced(state, seconds, performance.now() + LONG);
  if (!next) {
    reset();
    lost.textContent = data.words.lost;
    return false;
  }
  haunt(next.t - state.t);
  state = { ...next, qdd: call("forward_dynamics", next), turn: turnsOf(next) };
  show();
  return true;
};
const tick = stamp => {
  if (!running) return;
  const length = before === null ? 0 : Math.min(0.05, (stamp - before) / 1000) * Number(speed.value);
  before = stamp;
  if (moveOn(length)) requestAnimationFrame(tick);
};
const STEP = 0.04; // s, at full speed
const step = () => {
  if (running) run(false);
  else {
    if (!ofRun.has(state)) driven();
    moveOn(STEP * Number(speed.value));
  }
};
const reset = () => {
  run(false);
  lost.textContent = "";
  state = begin();
  fit();
  rebase();
  show();
};

for (const { input, group, k } of sliders) {
  input.addEventListener("input", () => {
    const x = input.valueAsNumber;
    if (!Number.isFinite(x)) return;
    const range = one(`input[type=range][data-group=${group}][data-k="${k}"]`);
    const [next, there] = moved(state, group, k, x, range.max - range.min);
    state = fitted(obeyed(next));
    const said = there ? "" : data.words.open;
    if (lost.textContent !== said) lost.textContent = said;
    if (group === "params") fit();
    rebase();
    show(there ? input : null);
  });
  input.addEventListener("change", () => { if (!Number.isFinite(input.valueAsNumber)) panel(); });
}
play.addEventListener("click", () => run(!running));
one("[data-do=step]").addEventListener("click", step);
one("[data-do=reset]").addEventListener("click", reset);
drives.addEventListener("change", () => { if (running) run(true); });
one("[data-do=turn]")?.addEventListener("input", event => {
  const rows = call("drawn_points"), g = row(rows, data.gravity), r = Math.hypot(...g);
  const vertical = r > 0 ? [...g].map(x => -x / r) : data.view[1];
  axes = data.view.map(v => turned(v, vertical, event.target.valueAsNumber * Math.PI / 180));
  fit();
  draw();
});

/** Sets entry k of a group, "params" or "qd", as its slider in the panel does, without a stop of the motion. */
compute.set = (k, value, group = "params") => {
  const [next, there] = moved(state, group, k, value, 1);
  state = fitted(obeyed(next));
  lost.textContent = there ? "" : data.words.open;
  rebase();
  if (running) return;
  if (play.disabled) show();
  else run(true);
};

// A link that keeps the state: its address holds all numbers, with all digits

const KEPT = ["q", "qd", "qdd", "params", "t"], link = one("[data-do=link]");
const address = () => `#${root.id}?${KEPT.map(key => `${key}=${[state[key]].flatMap(x => [...(x.length === undefined ? [x] : x)]).join()}`).join("&")}`;
/** Takes the state that the page's address holds; returns whether it holds one of this mechanism. */
const followed = () => {
  const [name, text] = location.hash.slice(1).split("?");
  if (name !== root.id || !text) return false;
  const given = Object.fromEntries(text.split("&").map(part => [part.split("=")[0], (part.split("=")[1] ?? "").split(",").map(Number)]));
  const fits = KEPT.every(key => given[key]?.every(Number.isFinite) && given[key].length === (key === "t" ? 1 : state[key].length));
  if (!fits) return false;
  const at = { ...state, t: given.t[0] };
  for (const key of KEPT.slice(0, 4)) at[key] = Float64Array.from(given[key]);
  const next = closed(regular({ ...at, turn: turnsOf(regular(at)) }));
  if (!next) return false;
  state = fitted(obeyed(next));
  fit();
  rebase();
  show();
  return true;
};
link.addEventListener("click", () => {
  location.replace(address()); // no new entry to go back through
  navigator.clipboard?.writeText(location.href).catch(() => {});
});
reset();
followed();
addEventListener("hashchange", followed);