// Dragging: what is grabbed follows the pointer, as near as coordinates, limits and loops let it

{
const free = sliders.filter(one => one.range && ["q", "turn"].includes(one.group)).map(({ input, group, k }) => {
  const low = Number(input.min), high = Number(input.max);
  return { input, group, k, low, high, round: Math.abs(high - low - 2 * Math.PI) < 1e-9 };
});
/** Returns the state with a coordinate taken to x, or to the end of its range; loops may hold it back. */
const taken = (at, { group, k, low, high, round }, x) => moved(at, group, k, round ? x : Math.max(low, Math.min(high, x)), high - low)[0];
/** Returns where a material point is seen, m; it is given by rows of the points that are drawn, with weights. */
const seenAt = (grabbed, at) => {
  const rows = call("drawn_points", at);
  return lean([0, 1, 2].map(i => grabbed.reduce((sum, [k, weight]) => sum + weight * rows[3 * k + i], 0)));
};
/** Returns the material point of a mark that is seen at a place. */
const grabbedBy = ({ kind, rows }, place) => {
  if (kind !== "link" && kind !== "wheel") return [[rows[0], 1]];
  const [o, ...ends] = rows.map(k => seenAt([[k, 1]], state)), [x, y] = minus(place, o), [a, b] = ends.map(end => minus(end, o));
  if (kind === "link") {
    const part = Math.max(0.2, Math.min(1, (x * a[0] + y * a[1]) / (a[0] * a[0] + a[1] * a[1]) || 0));
    return [[rows[0], 1 - part], [rows[1], part]];
  }
  const det = a[0] * b[1] - a[1] * b[0], [u, v] = [(x * b[1] - y * b[0]) / det, (a[0] * y - a[1] * x) / det];
  return Math.hypot(u, v) <= 1.5 ? [[rows[0], 1 - u - v], [rows[1], u], [rows[2], v]] : [[rows[1], 1]];
};
const ROUNDS = 4, FURTHEST = 0.1, DAMPING = 1e-4; // steps of least squares; of a range a step; of the largest slope
/** Moves all coordinates a little, so that a material point comes to a place: the least motion that does. */
const pull = (grabbed, place) => {
  for (let round = 0; round < ROUNDS; round++) {
    const here = seenAt(grabbed, state), [x, y] = minus(place, here);
    if (Math.hypot(x, y) * scale < 0.5) break;
    const slopes = free.map(one => {
      const h = 1e-5 * (one.high - one.low), [near] = moved(state, one.group, one.k, state[one.group][one.k] + h, one.high - one.low);
      return minus(seenAt(grabbed, near), here).map(moving => moving * 1e5); // by the whole range
    });
    const [a, b, c] = slopes.reduce(([a, b, c], [u, v]) => [a + u * u, b + u * v, c + v * v], [0, 0, 0]);
    const damping = DAMPING * (a + c) + 1e-12, det = (a + damping) * (c + damping) - b * b;
    const along = [((c + damping) * x - b * y) / det, ((a + damping) * y - b * x) / det];
    const steps = slopes.map(([u, v]) => u * along[0] + v * along[1]), shorter = Math.min(1, FURTHEST / (largest(steps) || 1));
    free.forEach((one, i) => { state = taken(state, one, state[one.group][one.k] + shorter * steps[i] * (one.high - one.low)); });
  }
};
const placed = () => {
  state = fitted(obeyed({ ...state, turn: turnsOf(state) }));
  rebase();
  show();
};
const placeOf = ({ clientX, clientY }) => {
  const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(picture.getScreenCTM().inverse());
  return [x / scale + middle[0], y / scale + middle[1]];
};
let held = null, wanted = null;
picture.addEventListener("pointerdown", event => {
  const group = event.target.closest?.("[data-mark][data-body]");
  if (!group || !free.length || event.button) return;
  const mark = marks.find(one => one.group === group);
  event.preventDefault();
  run(false);
  held = grabbedBy(mark, placeOf(event));
  picture.setPointerCapture(event.pointerId);
  picture.classList.add("held");
});
picture.addEventListener("pointermove", event => {
  if (!held) return;
  if (!wanted) requestAnimationFrame(() => {
    if (held) pull(held, wanted);
    wanted = null;
    placed();
  });
  wanted = placeOf(event);
});
for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
  picture.addEventListener(end, () => {
    held = null;
    picture.classList.remove("held");
  });
}

// Keys: left and right move the chosen coordinate, up and down choose another

let chosen = 0;
const MOVES = { ArrowLeft: -0.01, ArrowRight: 0.01, PageDown: -0.1, PageUp: 0.1 };
const told = one("[data-out=chosen]");
picture.addEventListener("keydown", event => {
  if (!free.length || event.altKey || event.ctrlKey || event.metaKey) return;
  const move = MOVES[event.key], other = { ArrowUp: -1, ArrowDown: 1 }[event.key];
  if (event.key === " " && !play.disabled) run(!running);
  else if (move) {
    const one = free[chosen];
    run(false);
    state = taken(state, one, state[one.group][one.k] + move * (one.high - one.low));
    placed();
  } else if (other) chosen = (chosen + other + free.length) % free.length;
  else return;
  event.preventDefault();
  if (event.key === " ") return;
  const { input, group, k } = free[chosen], unit = input.closest(".live-slider").querySelector(".live-unit").textContent;
  told.textContent = `${input.getAttribute("aria-label")}: ${shown(state[group][k])} ${unit}`;
});
}
