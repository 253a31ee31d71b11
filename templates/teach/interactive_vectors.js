// Vectors: what the figure shows beside the mechanism. symdyn.NAME.show(["velocities", "body:arm", …]) chooses.

const MASS = { p: 0, v: 3, a: 6, L: 9, dL: 12 }; // entries of a row of mass_motions; its mass is the last
let moving = [null, null]; // the state and how its masses move: asked for by many in one picture
const motions = at => {
  if (at) return motionsOf(at);
  if (moving[0] !== state) moving = [state, motionsOf(state)];
  return moving[1];
};
const motionsOf = at => {
  const found = call("mass_motions", at);
  return data.arrows.masses.map((body, k) => {
    const part = first => [...found.subarray(16 * k + first, 16 * k + first + 3)];
    return { body, m: found[16 * k + 15], ...Object.fromEntries(Object.entries(MASS).map(([name, first]) => [name, part(first)])) };
  });
};
const times = (x, v) => v.map(one => x * one);
const minus = (a, b) => a.map((x, i) => x - b[i]);
/** Returns the state with only some of its velocities, and accelerations zero but for what those demand. */
const alone = kept => fitted({ ...state, qd: state.qd.map((x, k) => kept.includes(k) ? x : 0), qdd: new Float64Array(n) });
let lone = [null, []];
const lonely = k => {
  if (lone[0] !== state) lone = [state, []];
  return lone[1][k] ??= motions(alone([k]));
};
/** Returns b(u) of the kept velocities, less that of each of the subtracted ones, mass by mass. */
const bias = (kept, subtracted) => {
  const whole = kept.length === 1 ? lonely(kept[0]) : motions(alone(kept));
  for (const k of subtracted) {
    lonely(k).forEach((one, i) => {
      whole[i] = { ...whole[i], a: minus(whole[i].a, one.a), dL: minus(whole[i].dL, one.dL) };
    });
  }
  return whole;
};
const opposed = found => found.map(one => [one.body, one.body, one.p, times(-one.m, one.a), times(-1, one.dL)]);
const listed = (name, owners, at = state) => {
  if (!has(name)) return [];
  const found = call(name, at), part = first => [...found.subarray(first, first + 3)];
  return owners.map(([owner, body], k) => [owner, body, part(9 * k), part(9 * k + 3), part(9 * k + 6)]);
};
const summed = (lists, found) => lists.map((row, i) => [...row.slice(0, 3), row[3].map((x, k) => x + found[i][3][k]), row[4].map((x, k) => x + found[i][4][k])]);
/** Each kind: its units, along and about, and rows of owner, body, place, vector along, vector about; of what is asked
 * for by velocities, one (its square) or two (their product), else of all. */
const NONE = [0, 0, 0];
const arrows = {
  velocities: { units: ["m/s"], find: () => motions().map(one => [one.body, one.body, one.p, one.v, NONE]) },
  accelerations: { units: ["m/s²"], find: () => motions().map(one => [one.body, one.body, one.p, one.a, NONE]) },
  momenta: { units: ["kg m/s", "kg m²/s"], find: () => motions().map(one => [one.body, one.body, one.p, times(one.m, one.v), one.L]) },
  weights: { units: ["N"], find: () => {
    const g = row(call("drawn_points"), data.gravity);
    return motions().map(one => [one.body, one.body, one.p, times(one.m, [...g]), NONE]);
  } },
  inertia: { units: ["N", "N m"], find: () => opposed(motions()) },
  coriolis: { units: ["N", "N m"], find: of => {
    const kept = of ?? data.rows;
    return kept.length > 1 ? opposed(bias(kept, kept)) : opposed(motions()).map(one => [...one.slice(0, 3), NONE, NONE]);
  } },
  centrifugal: { units: ["N", "N m"], find: of => {
    const lists = (of ?? data.rows).map(k => opposed(bias([k], [])));
    return lists.slice(1).reduce(summed, lists[0]);
  } },
  forces: { units: ["N", "N m"], find: () => listed("actions", data.arrows.actions, running ? state : { ...state, tau: call("inverse_dynamics") }) },
  reactions: { units: ["N", "N m"], find: () => listed("carried_forces", data.arrows.joints) },
};

const LEAST = 0.3; // of their lengths, below which arrows are not made shorter to stay inside the frame
const REACH = 80, CURL = 24; // px of the longest arrow, and of the largest bend
/** What draws one vector: an arrow along it, and a bend about it. */
const drawnVector = (kind, owner, body) => {
  into = add("g", `vector ${kind}`, picture);
  Object.assign(into.dataset, { vector: `${kind}:${owner}`, body });
  const group = into, along = arrow("", 2.4), curve = add("path", ""), tip = add("path", "head"), sign = add("text", "");
  sign.textContent = data.signs[kind];
  into = picture;
  return (at, way, length, about, size) => {
    const [x, y] = lean(way), seen = Math.hypot(x, y), long = length * seen / (Math.hypot(...way) || 1);
    const from = flat(at), [a, b] = seen ? [x / seen, y / seen] : [0, -1], reach = long > 3 ? long : size;
    along(from, seen ? [a, b] : NONE, long > 3 ? long : 0);
    const spot = [from[0] + (reach + 9) * a - 7 * b, from[1] + (reach + 9) * b + 7 * a + 4], on = long > 3 || size > 3;
    put(sign, spot);
    if (on) named.push([...spot, 6]);
    bend(curve, tip, flat(at), about, size);
    group.style.display = on ? "" : "none";
  };
};
/** A circle about an axis, three quarters of a turn in its sense, as it is seen. */
const bend = (curve, tip, [x, y], about, size) => {
  const r = Math.hypot(...about);
  if (!(size > 3 && r > 0)) { curve.setAttribute("d", ""); tip.setAttribute("d", ""); return; }
  const z = times(1 / r, about), least = z.map(Math.abs).indexOf(Math.min(...z.map(Math.abs)));
  const e = across(z, NONE.map((_, i) => +(i === least))), u = times(1 / Math.hypot(...e), e), v = across(z, u);
  const [a, b] = [lean(u), lean(v)];
  const spot = angle => [0, 1].map(i => [x, y][i] + size * (Math.cos(angle) * a[i] + Math.sin(angle) * b[i]));
  curve.setAttribute("d", line(...Array.from({ length: 25 }, (_, k) => spot(k * Math.PI / 16))));
  const end = spot(1.5 * Math.PI), [c, d] = unit(minus(end, spot(1.4 * Math.PI)));
  tip.setAttribute("d", `${line([end[0] + 7 * c, end[1] + 7 * d], [end[0] - 4 * d, end[1] + 4 * c], [end[0] + 4 * d, end[1] - 4 * c])}Z`);
};

let words = ["energies"], focus = null, most = {}, faded = null;
const pens = new Map();
/** Draws the chosen kinds, or the one that stands out; arrows of one unit share a scale, which never grows as they move. */
const vectors = () => {
  const kinds = Object.keys(arrows).filter(kind => focus ? focus.kind === kind : wanted(kind));
  const found = kinds.map(kind => [kind, arrows[kind].find(focus?.kind === kind ? focus.of : undefined)]);
  for (const [kind, rows] of found) {
    arrows[kind].units.forEach((unit, i) => {
      for (const one of rows) most[unit] = Math.max(most[unit] ?? 0, Math.hypot(...one[3 + i]) || 0);
    });
  }
  for (const [kind, rows] of found) { // none ends beyond the frame, but for what is short for that
    const unit = arrows[kind].units[0];
    for (const [, , at, along] of rows) {
      const from = flat(at), way = lean(along).map(x => most[unit] > 1e-9 ? REACH * x / most[unit] : 0);
      const room = Math.min(1, ...way.map((x, i) => x ? Math.max(0, HALF[i] - 16 - Math.sign(x) * from[i]) / Math.abs(x) : 1));
      most[unit] /= Math.max(room, LEAST);
    }
  }
  const length = (unit, v, reach) => most[unit] > 1e-9 ? reach * Math.hypot(...v) / most[unit] : 0;
  const used = new Set();
  for (const [kind, rows] of found) {
    const [first, second] = arrows[kind].units;
    rows.forEach(([owner, body, at, along, about], i) => {
      const key = `${kind} ${i}`;
      used.add(key);
      if (!pens.has(key)) pens.set(key, drawnVector(kind, owner, body));
      pens.get(key)(at, along, length(first, along, REACH), about, second ? length(second, about, CURL) : 0);
    });
  }
  for (const [key, pen] of pens) if (!used.has(key)) pen(NONE, NONE, 0, NONE, 0);
  if (focus === faded) return;
  faded = focus;
  for (const group of picture.querySelectorAll(".vector")) {
    group.classList.toggle("faint", focus !== null && !pointedAt(group.dataset.vector));
  }
};
const pointedAt = vector => {
  const [kind, owner] = [vector.slice(0, vector.indexOf(":")), vector.slice(vector.indexOf(":") + 1)];
  return kind === focus.kind && (!focus.body || owner === focus.body);
};

/** Words that the reader has ticked, beside those of the step. */
const ticks = all("[data-word]");
const wanted = word => words.includes(word) || own.includes(word);
let own = [];
const tellPage = (name, detail) => root.dispatchEvent(new CustomEvent(`symdyn:${name}`, { detail }));
/** Shows these words, and nothing of what was shown but what the reader has ticked; unknown words change nothing. */
compute.show = chosen => {
  words = [...chosen];
  const pressed = words.includes("cone") && press();
  rearrange();
  if (pressed) show();
};
const rearrange = () => {
  most = {};
  for (const group of all(".live-frame")) group.style.display = wanted("frames") ? "" : "none";
  for (const group of picture.querySelectorAll("[data-mark]")) {
    const names = [`body:${group.dataset.body}`, `joint:${group.dataset.joint}`];
    group.classList.toggle("pointed", names.some(name => words.includes(name)));
  }
  for (const [name, panel] of Object.entries(panels)) panel.hidden = !wanted(name) || (name === "phase" && !data.pairs.length);
  one("[data-note=energies]").hidden = panels.energies.hidden;
  draw();
  plotted(true);
  tellPage("shown", { words });
};
for (const tick of ticks) {
  tick.addEventListener("change", () => {
    own = ticks.filter(one => one.checked).map(one => one.dataset.word);
    rearrange();
  });
}
/** Lets one vector stand out: { kind, body, of }, `of` the velocities, from 0, of a Coriolis or centrifugal part; null for none. */
compute.focus = what => { focus = what; most = {}; draw(); };
/** Returns the state: q, qd, qdd, tau, params, t. */
compute.state = () => state;
/** Moves the state by some seconds, picture by picture; returns the drift of its energy, J, NaN where it gets lost. */
compute.advance = seconds => {
  for (let end = state.t + seconds, next; end - state.t > 1e-9; state = next) {
    next = advanced(state, Math.min(1 / 60, end - state.t));
    if (!next) return NaN;
  }
  show();
  return energy() - first - state.W;
};
/** Returns the numbers under the terms of a lesson. */
compute.named = () => has("named_values") ? call("named_values") : [];
/** Returns the vectors of a kind: owner, body, place, m, what is along and what is about; `of` as for focus. */
compute.arrows = (kind, of) => arrows[kind].find(of);
