// Overlays: arcs and lengths of coordinates, lines of x, y and z, trails, and a ghost with another value of a parameter

/** Lines of x, y and z of each mass, one after the other from the origin. */
const dashes = [];
const placeLines = () => {
  const on = wanted("places"), found = on ? motions() : [];
  found.forEach(({ p }, i) => {
    dashes[i] ??= add("path", "place");
    dashes[i].setAttribute("d", line(...[NONE, [p[0], 0, 0], [p[0], p[1], 0], p].map(flat)));
  });
  for (const dash of dashes) dash.style.display = on ? "" : "none";
};

// Coordinates: a turn from its zero line to where it is, a slide from its zero

const coordinates = data.coordinates.map(([slides, k, letters, at, axis, tips]) => {
  const group = add("g", "live-angle", picture);
  into = group;
  const zero = add("path", "zero"), arc = add("path", "mark"), tip = add("path", "mark head"), name = label(letters);
  into = picture;
  group.querySelector("text").setAttribute("class", "mark-text");
  let arm = -1; // the place on the body that the zero line is seen at
  return rows => {
    const on = wanted("angles");
    group.style.display = on ? "" : "none";
    if (!on) return;
    const from = row(rows, at), z = [...row(rows, axis)], q = state.q[k], [x, y] = flat(from);
    if (slides) {
      const [a, b] = unit(lean(z)), long = q * scale * Math.hypot(...lean(z)), off = [-24 * b, 24 * a];
      const ends = [0, long].map(s => [x + off[0] + s * a, y + off[1] + s * b]);
      zero.setAttribute("d", line([x, y], ends[0]) + line([x + long * a, y + long * b], ends[1]));
      arc.setAttribute("d", line(...ends));
      headed(tip, ends[1], times(Math.sign(long), [a, b]), Math.abs(long) > 8);
      name([(ends[0][0] + ends[1][0]) / 2 + 0.6 * off[0], (ends[0][1] + ends[1][1]) / 2 + 0.6 * off[1] + 5]);
      return;
    }
    const level = i => { const way = minus([...row(rows, tips[i])], from), p = dot(way, z); return way.map((w, c) => w - p * z[c]); };
    const sizes = tips.map((_, i) => Math.hypot(...level(i)));
    if (arm < 0 && Math.max(...sizes) > 1e-6) arm = sizes.indexOf(Math.max(...sizes));
    const least = z.map(Math.abs).indexOf(Math.min(...z.map(Math.abs)));
    const far = arm < 0 ? across(z, NONE.map((_, i) => +(i === least))) : level(arm), size = Math.hypot(...far) || 1;
    const angle = q - 2 * Math.PI * Math.trunc(q / (2 * Math.PI)), u = turned(times(1 / size, far), z, -angle), v = across(z, u);
    const [a, b] = [lean(u), lean(v)], r = Math.max(26, Math.min(44, 0.55 * size * scale));
    const spot = (t, reach = r) => [x + reach * (Math.cos(t) * a[0] + Math.sin(t) * b[0]), y + reach * (Math.cos(t) * a[1] + Math.sin(t) * b[1])];
    zero.setAttribute("d", line([x, y], spot(0, r + 14)));
    arc.setAttribute("d", line(...Array.from({ length: 33 }, (_, i) => spot(angle * i / 32))));
    headed(tip, spot(angle), unit(minus(spot(angle), spot(angle * 0.9))), Math.abs(angle) * r > 9);
    name(spot(angle / 2, r + 16).map((one, i) => one + 5 * i));
  };
});
const headed = (tip, [x, y], [a, b], on) => {
  tip.setAttribute("d", on ? `${line([x, y], [x - 8 * a - 3.2 * b, y - 8 * b + 3.2 * a], [x - 8 * a + 3.2 * b, y - 8 * b - 3.2 * a])}Z` : "");
};

// Names of bodies, at the middle of what is drawn of each

const called = data.bodies.map((body, k) => {
  const marks = data.marks.filter(([, , of]) => data.bodies[of] === body);
  const mark = ["ring", "disc", "link", "particle", "com", "slide"].map(kind => marks.find(one => one[0] === kind)).find(Boolean);
  const name = label("", true), text = picture.lastChild;
  text.textContent = data.called[k].replaceAll("_", " ");
  text.setAttribute("class", "live-name");
  return rows => {
    const places = mark && wanted("names") ? mark[1].slice(...{ ring: [1, 2], disc: [1, 2], link: [0, 2] }[mark[0]] ?? [0, 1]).map(k => flat(row(rows, k))) : [];
    name(places.length ? [0, 1].map(i => places.reduce((sum, at) => sum + at[i], 0) / places.length + 18 * i) : null);
  };
});

// Trails

const TRAIL = 240; // pictures that a trail is long
let trail = [];
const traces = data.arrows.masses.map(body => {
  const path = add("path", `trail ${colour(data.bodies.indexOf(body))}`);
  picture.insertBefore(path, picture.children[1]);
  return path;
});
const trails = () => {
  const on = wanted("trails");
  if (!on || !history.length) trail = [];
  if (on) trail.push(motions().map(one => one.p));
  if (trail.length > TRAIL) trail.shift();
  traces.forEach((path, i) => path.setAttribute("d", trail.length > 1 ? line(...trail.map(at => flat(at[i]))) : ""));
};

// Ghost: the same start with another value of one parameter

const SOLID = ["link", "particle", "com", "wheel", "ball", "spring", "slide", "rod", "disc", "ring", "plate"];
const which = one("[data-do=ghost]"), howMuch = one("[data-do=ghost-value]");
let ghost = null, shade = null;
const behind = add("g", "live-ghost", picture);
picture.insertBefore(behind, picture.children[1]);
const shades = data.marks.filter(([kind]) => SOLID.includes(kind)).map(([kind, rows, body, letters]) => {
  into = behind;
  const move = kinds[kind](body, letters);
  into = picture;
  return { rows, move };
});
/** Returns the state with the ghost's value, loops closed; null where they do not close. */
const otherwise = at => {
  const [next, there] = moved(at, "params", ghost.k, ghost.value, 1);
  return there ? fitted(obeyed({ ...next, W: 0, stride: LONGEST })) : null;
};
const drawGhost = () => {
  const on = ghost && (wanted("ghost") || ghost.mine);
  behind.style.display = on && shade ? "" : "none";
  if (!on) return;
  if (!history.length || !shade) shade = otherwise(state);
  if (!shade) { behind.style.display = "none"; return; }
  const rows = call("drawn_points", shade);
  for (const mark of shades) mark.move(mark.rows.map(k => row(rows, k)));
};
const haunt = seconds => {
  if (ghost && shade) shade = advanced({ ...shade, tau: state.tau }, seconds, performance.now() + LONG);
};
/** Sets a ghost: parameter k and its value; null for none. */
compute.ghost = (k, value, mine = true) => {
  ghost = k === null ? null : { k, value, mine };
  shade = null;
  if (which) {
    which.value = ghost ? String(k) : "";
    howMuch.disabled = !ghost;
    howMuch.value = ghost ? String(Number(value.toPrecision(5))) : "";
  }
  rebase();
  draw();
};
which?.addEventListener("change", () => {
  if (which.value === "") compute.ghost(null);
  else compute.ghost(Number(which.value), state.params[which.value] / 2 || 1);
});
howMuch?.addEventListener("input", () => {
  if (ghost && Number.isFinite(howMuch.valueAsNumber)) { ghost = { ...ghost, value: howMuch.valueAsNumber }; shade = null; rebase(); draw(); }
});

const overlays = rows => {
  if (wanted("ghost") && !ghost && data.start.params.length) compute.ghost(0, state.params[0] / 2 || 1, false);
  vectors();
  cones();
  placeLines();
  for (const move of coordinates) move(rows);
  for (const move of called) move(rows);
  trails();
  drawGhost();
};
