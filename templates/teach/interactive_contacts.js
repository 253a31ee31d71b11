// Contacts: a run with its events, made beforehand, and cones of friction with the forces inside them

const table = data.played?.rows ?? [], ended = table.at(-1)?.[0] ?? 0;
const ofRun = new WeakSet(); // the states that are places of the run
const atFirst = begin();
const untouched = () => ["q", "qd", "params"].every(key => state[key].every((x, k) => x === atFirst[key][k]));
/** Returns from when on the run is played; null where the state has been changed by hand, or there is none. */
const playedFrom = () => {
  if (!table.length) return null;
  if (ofRun.has(state)) return state.t < ended ? state.t : 0;
  return untouched() ? 0 : null;
};
/** Returns the row before a time, the one behind it, and how far it is between them. */
const rowsAt = t => {
  const k = Math.max(1, table.findIndex(row => row[0] >= t)), [a, b] = [table[k - 1], table[k]];
  return [a, b, (t - a[0]) / (b[0] - a[0])];
};
const replayed = t => {
  const [a, b, share] = rowsAt(t), now = a.map((x, i) => x + share * (b[i] - x));
  const part = (from, count) => Float64Array.from(now.slice(from, from + count));
  const at = regular({ ...state, t, q: part(1, nq), qd: part(1 + nq, n), qdd: part(1 + nq + n, n) });
  const found = { ...at, turn: turnsOf(at), W: energy(at) - first - now[1 + nq + 2 * n] };
  ofRun.add(found);
  return found;
};
const CONE = 90, WIDEST = 110; // px: how high a cone is, and half its width at most
const touches = (data.played?.frictions ?? []).map((frictions, i) => {
  into = add("g", "live-cone", picture);
  const edge = add("path", "link body0"), push = arrow("force", 2.6), group = into;
  edge.setAttribute("stroke-width", 1.4);
  edge.setAttribute("style", "fill:none");
  into = picture;
  return { frictions, edge, push, group, from: 2 + nq + 2 * n + 10 * i };
});
const strongest = Math.max(1e-300, ...table.flatMap(row => touches.map(({ from }) => Math.hypot(...row.slice(from + 3, from + 6)))));
const cones = () => {
  const on = wanted("cone") && ofRun.has(state), [a, b, share] = on ? rowsAt(state.t) : [];
  for (const { frictions, edge, push, group, from } of touches) {
    const near = on ? (share < 0.5 ? a : b) : [], mode = near[from + 9];
    group.style.display = mode ? "" : "none";
    if (!mode) continue;
    const spot = [0, 1, 2].map(i => a[from + i] + share * (b[from + i] - a[from + i]));
    const force = near.slice(from + 3, from + 6), n = near.slice(from + 6, from + 9);
    const mu = frictions[Math.abs(mode) > 1 ? 1 : 0], high = Math.min(CONE, WIDEST / (mu || 1)), at = flat(spot);
    const tip = sign => lean(n.map((x, i) => x + sign * mu * across(n, axes[2])[i])).map((x, i) => at[i] + high * x);
    edge.setAttribute("d", mu ? line(tip(-1), at, tip(1)) : "");
    push(at, unit(lean(force)), 0.9 * high * Math.hypot(...lean(force)) / strongest * Math.hypot(1, mu));
  }
};
/** Moves what nobody has changed to the first place of the run at which something is pressed; returns whether it did. */
const press = () => {
  if (running || !untouched()) return false;
  const found = table.find(row => touches.some(({ from }) => row[from + 9]));
  if (found) state = replayed(found[0]);
  return Boolean(found);
};
