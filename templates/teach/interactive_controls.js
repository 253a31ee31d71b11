// Controls

const show = except => { draw(); tables(); energies(); follow(except); };
let running = false, before = null;
const play = one("[data-do=play]"), speed = one("[data-do=speed]"), drives = one("[data-do=drives]"), lost = one("[data-out=lost]");
const run = on => {
  running = on;
  before = null;
  play.textContent = on ? data.words.pause : data.words.play;
  if (!on) return;
  lost.textContent = "";
  state = { ...state, tau: drives.value === "held" ? call("inverse_dynamics") : new Float64Array(n) };
  rebase();
  requestAnimationFrame(tick);
};
const LONG = 3; // ms that a picture's share of the motion takes at most; beyond that it falls behind the clock
/** Moves on by some seconds; returns whether the motion is still one. */
const moveOn = seconds => {
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
    state = { ...state, tau: drives.value === "held" ? call("inverse_dynamics") : new Float64Array(n) };
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
  input.addEventListener("change", () => { if (!Number.isFinite(input.valueAsNumber)) follow(); });
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
reset();
