// Motion: q, qd and the work W of all forces that no potential has, by the midpoint rule of Gragg, extrapolated to steps
// of no length as Bulirsch and Stoer do: row j takes 2 j strokes, and its error is a series in the square of a stroke.
// States of the scene's own, which are parameters else, stand behind W.

/** Returns the nearest state that loops and rows allow; null where there is none near by. */
const kept = at => {
  const next = closed(at, "shortest");
  return next && has("nearest") ? { ...next, qd: call("nearest", next) } : next;
};
const nq = data.start.q.length;
const packed = at => Float64Array.from([...at.q, ...at.qd, at.W, ...data.own.map(k => at.params[k])]);
const owned = (params, y) => data.own.reduce((now, k, i) => exchanged(now, k, y[nq + n + 1 + i]), params);
const unpacked = (at, y, t) => ({ ...at, q: y.subarray(0, nq), qd: y.subarray(nq, nq + n), W: y[nq + n], params: owned(at.params, y), t });
const rates = (like, y, t) => {
  const at = obeyed(unpacked(like, y, t));
  const qdd = call("forward_dynamics", at), way = has("coordinate_rates") ? call("coordinate_rates", at) : at.qd;
  const acting = has("applied_forces") ? call("applied_forces", at) : new Float64Array(n);
  const tau = exertion(at, qdd), power = at.qd.reduce((sum, u, i) => sum + u * (tau[i] + acting[i]), 0);
  const [taken, ...own] = has("own_rates") ? call("own_rates", at) : [0];
  return [...way, ...qdd, power + taken, ...own];
};
const TOLERANCE = 1e-12, SHORTEST = 1e-7, ROWS = 9;
const ahead = (y, h, slope) => y.map((x, i) => x + h * slope[i]);
/** Returns the state after h seconds and the row at which it was good enough; null where none is. */
const stepped = (at, h) => {
  const start = packed(at), slope = rates(at, start, at.t), table = [];
  for (let j = 1; j <= ROWS; j++) {
    const count = 2 * j, stroke = h / count;
    let last = start, now = ahead(start, stroke, slope);
    for (let k = 1; k < count; k++) [last, now] = [now, ahead(last, 2 * stroke, rates(at, now, at.t + k * stroke))];
    const row = [now];
    for (let k = 1; k < j; k++) {
      const share = 1 / ((j / (j - k)) ** 2 - 1), before = table[j - 2][k - 1], here = row[k - 1];
      row.push(here.map((x, i) => x + share * (x - before[i])));
    }
    table.push(row);
    const best = row[j - 1], other = row[j - 2];
    const off = other ? largest(best.map((x, i) => (x - other[i]) / (1 + Math.abs(x)))) / TOLERANCE : Infinity;
    if (Number.isNaN(off)) return null;
    if (off <= 1) {
      const next = kept(regular(obeyed(unpacked(at, best, at.t + h))));
      return next && [next, j];
    }
  }
  return null;
};
/** Returns the state some seconds later, or sooner where a moment of the clock comes first; null where it gets lost. */
const advanced = (at, seconds, until = Infinity) => {
  const end = at.t + seconds;
  while (end - at.t > 1e-12 && performance.now() < until) {
    const h = Math.min(at.stride, end - at.t), found = stepped(at, h);
    if (!found && h <= SHORTEST) return null;
    if (!found) at = { ...at, stride: Math.max(SHORTEST, h / 3) };
    else at = { ...found[0], stride: h < at.stride || found[1] > 7 ? at.stride : Math.min(LONGEST, 1.6 * h) };
  }
  return [...at.q, ...at.qd].every(Number.isFinite) ? at : null;
};

let first = 0, history = [];
const energy = (at = state) => call("kinetic_energy", at) + call("potential_energy", at);
const rebase = () => { state = { ...state, W: 0, stride: LONGEST }; first = energy(); history = []; };
