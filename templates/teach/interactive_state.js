// State: what the functions take, by the names of their arguments; "turn" holds roll, pitch and yaw of quaternions.

const n = data.start.qd.length;
const has = name => name in data.calls;
const call = (name, at = state) => compute[name](...data.calls[name].map(argument => at[argument]));
const exchanged = (x, k, value) => { const changed = x.slice(); changed[k] = value; return changed; };
const largest = x => x.reduce((most, one) => Math.max(most, Math.abs(one)), 0); // NaN where there is one

const clipped = x => Math.max(-1, Math.min(1, x));
const angles = ([w, x, y, z]) => [
  Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
  Math.asin(clipped(2 * (w * y - z * x))),
  Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
];
const quaternion = turn => {
  const [a, b, c] = turn.map(x => Math.cos(x / 2)), [d, e, f] = turn.map(x => Math.sin(x / 2));
  return [a * b * c + d * e * f, d * b * c - a * e * f, a * e * c + d * b * f, a * b * f - d * e * c];
};
const turnsOf = at => Float64Array.from(data.turns.flatMap(first => angles([...at.q.subarray(first, first + 4)])));

/** Returns the state with quaternions of unit length. */
const regular = at => {
  if (!data.balls.length) return at;
  const q = at.q.slice();
  for (const first of data.balls) {
    const size = Math.hypot(...q.subarray(first, first + 4));
    for (let i = first; i < first + 4; i++) q[i] /= size;
  }
  return { ...at, q };
};
/** Returns the state after a step along the velocities. */
const shifted = (at, step) => {
  const way = has("coordinate_rates") ? call("coordinate_rates", { ...at, qd: step }) : step;
  return regular({ ...at, q: at.q.map((x, i) => x + way[i]) });
};

// Loops: Newton's method from where the mechanism is, so that it stays on its branch

const CLOSED = 1e-13, NEAR = 1e-9, FAR = 0.3;
const missed = at => largest(call("constraint_residual", at));
/** Returns the state with its loops closed, what sliders move as it is; null where they do not close near by. */
const closed = (at, newton = "correction") => {
  if (!data.loops) return at;
  for (let k = 0; k < 12 && !(missed(at) < CLOSED); k++) {
    const step = call(newton, at);
    if (!(largest(step) < FAR)) return null;
    at = shifted(at, step);
  }
  return missed(at) < NEAR ? at : null;
};
/** Returns the state with velocities and accelerations that loops and rows allow, the independent ones as they are. */
const fitted = at => {
  if (!has("fitted_velocities")) return at;
  at = { ...at, qd: call("fitted_velocities", at) };
  return { ...at, qdd: call("fitted_accelerations", at) };
};
/** Returns what `change` of 0 to 1 leads to, loops closed on the way, and whether it leads there. */
const led = (at, change, count) => {
  let done = 0, size = 1 / count, now = at;
  while (done < 1 && size > 1 / (256 * count)) {
    const to = Math.min(1, done + size), next = closed(change(now, done, to));
    if (next) [now, done, size] = [next, to, Math.min(1 / count, 2 * size)];
    else size /= 2;
  }
  return [now, done >= 1];
};
/** Returns the state with coordinate k moved as near to x as the loops let it, and whether it is there. */
const steered = (at, k, x, span) => {
  const from = at.q[k], velocity = data.loops?.[k];
  const change = (now, done, to) => {
    const h = (to - done) * (x - from);
    if (!(velocity >= 0)) return { ...now, q: exchanged(now.q, k, now.q[k] + h) };
    return shifted(now, call("carried", { ...now, qd: exchanged(new Float64Array(n), velocity, h) }));
  };
  return led(at, change, data.loops ? Math.max(1, Math.min(1000, Math.ceil(100 * Math.abs(x - from) / span))) : 1);
};
/** Returns the state with a slider's value changed as far as the loops let it, and whether that is all the way. */
const moved = (at, group, k, x, span) => {
  if (group === "q") return steered(at, k, x, span);
  if (group === "t") return [obeyed({ ...at, t: x }), true];
  if (group === "turn") {
    const first = data.turns[Math.floor(k / 3)], turn = exchanged(at.turn, k, x), q = at.q.slice();
    q.set(quaternion([...turn.subarray(k - k % 3, k - k % 3 + 3)]), first);
    const next = closed({ ...at, q, turn });
    return next ? [next, true] : [at, false];
  }
  if (group !== "params" || !data.loops) return [{ ...at, [group]: exchanged(at[group], k, x) }, true];
  const from = at.params[k];
  return led(at, (now, _, to) => ({ ...now, params: exchanged(now.params, k, from + to * (x - from)) }), 1);
};
const NEXT = 0.25; // of the range of a slide
/** Returns states all over the ranges of the sliders; of slides that no loop holds in the next part of their way. */
const reached = () => {
  const ranges = all("input[type=range][data-group]").filter(input => ["t", "q", "turn"].includes(input.dataset.group));
  const spans = ranges.map(input => [input.dataset.group, Number(input.dataset.k), Number(input.min), Number(input.max)]);
  const found = [state];
  if (data.loops) {
    for (const [group, k, low, high] of spans) {
      for (const end of [low, high]) {
        let now = state, there = true;
        const from = now[group][k];
        for (let i = 1; i <= 24 && there; i++) {
          [now, there] = moved(now, group, k, from + i / 24 * (end - from), high - low);
          found.push(now);
        }
      }
    }
    return found;
  }
  const slides = new Set(data.coordinates.filter(([slides]) => slides).map(([, k]) => k));
  for (const span of spans) {
    const [group, k, low, high] = span;
    if (group === "q" && slides.has(k)) [span[2], span[3]] = [-1, 1].map(sign => state.q[k] + sign * NEXT / 2 * (high - low));
  }
  for (let k = 1; k <= 48; k++) {
    let now = state;
    spans.forEach(([group, i, low, high], place) => {
      [now] = moved(now, group, i, low + (high - low) * ((k * (0.618034 + 0.113 * place)) % 1), high - low);
    });
    found.push(now);
  }
  return found;
};

/** Returns the state with what is prescribed where its time has it. */
const obeyed = at => {
  if (!data.led.length) return at;
  const next = { ...at, q: at.q.slice(), qd: at.qd.slice(), qdd: at.qdd.slice() };
  const [x, v, a] = ["positions", "velocities", "accelerations"].map(part => call(`led_${part}`, at));
  data.led.forEach(([i, k], place) => { next.q[i] = x[place]; next.qd[k] = v[place]; next.qdd[k] = a[place]; });
  return next;
};
/** Returns what drives exert: as they are chosen, and whatever a prescribed motion takes. */
const exertion = (at, qdd) => {
  if (!data.led.length) return at.tau;
  const tau = at.tau.slice(), needed = call("inverse_dynamics", { ...at, qdd });
  for (const [, k] of data.led) tau[k] = needed[k];
  return tau;
};
const LONGEST = 0.2; // s that one step of the integration is long at most
/** Returns the state at the start; W is the work since, stride what the next step of the integration tries. */
const begin = () => {
  const at = {
    q: Float64Array.from(data.start.q),
    qd: Float64Array.from(data.start.qd),
    qdd: Float64Array.from(data.start.qdd),
    params: Float64Array.from(data.start.params),
    tau: new Float64Array(n),
    t: data.start.t,
    W: 0,
    stride: LONGEST,
  };
  return fitted(obeyed({ ...at, turn: turnsOf(at) }));
};
let state = begin(), running = false;
