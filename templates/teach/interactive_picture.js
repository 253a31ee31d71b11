// Picture

const NS = "http://www.w3.org/2000/svg";
let into = picture; // the group that elements are added to
const add = (tag, look, parent = into) => {
  const element = document.createElementNS(NS, tag);
  element.setAttribute("class", look);
  parent.append(element);
  return element;
};
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const across = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const turned = (v, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle), w = across(axis, v), p = dot(axis, v) * (1 - c);
  return v.map((x, i) => x * c + w[i] * s + axis[i] * p);
};
let axes = data.view, scale = 1, middle = [0, 0];
const lean = v => [dot(axes[0], v), -dot(axes[1], v)];
const flat = v => lean(v).map((x, i) => (x - middle[i]) * scale);
const unit = ([x, y]) => { const r = Math.hypot(x, y); return r > 1e-9 ? [x / r, y / r] : [0, 0]; };
const row = (rows, k) => rows.subarray(3 * k, 3 * k + 3);
const line = (...points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");
const put = (element, [x, y], angle = 0) =>
  element.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)}) rotate(${angle.toFixed(2)})`);
const colour = body => `body${((body % 6) + 6) % 6}`;

const arrow = (look, width) => {
  const shaft = add("path", look), head = add("path", `${look} head`);
  shaft.setAttribute("stroke-width", width);
  return (from, way, length) => {
    const [x, y] = way, tip = [from[0] + x * length, from[1] + y * length];
    const back = [tip[0] - 9 * x, tip[1] - 9 * y];
    shaft.setAttribute("d", length ? line(from, back) : "");
    head.setAttribute("d", length ? `${line(tip, [back[0] - 3.5 * y, back[1] + 3.5 * x], [back[0] + 3.5 * y, back[1] - 3.5 * x])}Z` : "");
  };
};
const HALF = [240, 180]; // of the picture, px
let named = []; // middles and half the widths of the names that this drawing has so far
/** Returns what puts a name near a point, inside the picture and clear of names that are already there; where it finds no
 * room, one that `may` be left out is hidden. */
const label = (letters, may = false) => {
  const text = add("text", "");
  text.innerHTML = letters;
  let wide = 0; // measured once: asking makes the browser lay out the page
  return point => {
    const [x, y] = point ?? [Infinity, 0], on = Math.abs(x) < 270 && Math.abs(y) < 210; // else what it names is not in the picture
    text.style.display = on ? "" : "none";
    if (!on) return;
    wide ||= text.getComputedTextLength();
    const half = (wide || 20) / 2 + 2;
    const inside = Math.max(half - 236, Math.min(236 - half, x)), level = off => Math.max(-160, Math.min(170, y + off));
    const free = off => !named.some(([a, b, other]) => Math.abs(a - inside) < other + half && Math.abs(b - level(off)) < 20);
    const off = [0, 22, -22, 44, -44].find(free);
    if (off === undefined && may) { text.style.display = "none"; return; }
    named.push([inside, level(off ?? 0), half]);
    put(text, [inside, level(off ?? 0)]);
  };
};

/** What draws a spring, or a damper, from one place of the picture to another. */
const spring = () => {
  const wire = add("path", "rope");
  wire.setAttribute("stroke-width", 1.6);
  return (from, to) => {
    const way = [to[0] - from[0], to[1] - from[1]], [x, y] = unit(way);
    const turns = Array.from({ length: 11 }, (_, i) => {
      const part = 0.15 + 0.07 * i, side = i === 0 || i === 10 ? 0 : i % 2 ? 6 : -6;
      return [from[0] + part * way[0] - side * y, from[1] + part * way[1] + side * x];
    });
    wire.setAttribute("d", line(from, ...turns, to));
  };
};
const damper = () => {
  const wire = add("path", "rope"), pot = add("path", "rope");
  for (const element of [wire, pot]) element.setAttribute("stroke-width", 1.6);
  pot.setAttribute("d", "M14 -6H-10V6H14M2 -5V5");
  return (from, to) => {
    const [x, y] = unit([to[0] - from[0], to[1] - from[1]]), mid = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
    wire.setAttribute("d", line(from, [mid[0] - 10 * x, mid[1] - 10 * y]) + line([mid[0] + 2 * x, mid[1] + 2 * y], to));
    put(pot, mid, Math.atan2(y, x) * 180 / Math.PI);
  };
};
/** What draws one of a slide: from the joint's zero, or a wall behind it, to the slider, beside the axis. */
const beside = (draw, side, zeroed = false) => {
  const wall = add("path", "hatch");
  return ([fixed, moved, way]) => {
    const [x, y] = unit(lean(way)), zero = flat(fixed), end = flat(moved);
    const back = zeroed ? 0 : Math.min(0, (end[0] - zero[0]) * x + (end[1] - zero[1]) * y) - 60;
    const from = [zero[0] + back * x - side * y, zero[1] + back * y + side * x];
    wall.setAttribute("d", line([from[0] - 8 * y, from[1] + 8 * x], [from[0] + 8 * y, from[1] - 8 * x]));
    draw(from, [end[0] - 18 * x - side * y, end[1] - 18 * y + side * x]);
  };
};
/** What draws one of a turn: a curve around the joint. */
const around = (radius, angle, width) => {
  const curve = add("path", "rope"), count = 48;
  curve.setAttribute("stroke-width", width);
  const spots = Array.from({ length: count + 1 }, (_, k) => [Math.cos(angle * k / count) * radius(k), -Math.sin(angle * k / count) * radius(k)]);
  curve.setAttribute("d", line(...spots));
  return ([, moved]) => put(curve, flat(moved));
};

/** The line through points, nothing where one of them has no value. */
const outlined = (points, end = "") => points.flat().every(Number.isFinite) ? line(...points) + end : "";
const spanned = (at, a, b, x, y) => flat([0, 1, 2].map(i => at[i] + x * (a[i] - at[i]) + y * (b[i] - at[i])));
/** What draws a circle in space, a line where it is seen edge-on, and a mark from its rim inwards that shows it turn. */
const disc = (body, look, inner, marked) => {
  const rim = add("path", `${look}link ${colour(body)}`), mark = add("path", marked);
  if (!look) rim.setAttribute("style", "fill:none");
  for (const element of [rim, mark]) element.setAttribute("stroke-width", element === rim ? 3 : 1.6);
  return ([at, a, b]) => {
    const turns = Array.from({ length: 49 }, (_, k) => spanned(at, a, b, Math.cos(k * Math.PI / 24), Math.sin(k * Math.PI / 24)));
    rim.setAttribute("d", outlined(turns, "Z"));
    mark.setAttribute("d", outlined([spanned(at, a, b, inner, 0), spanned(at, a, b, 1, 0)]));
  };
};

/** Each kind of mark: makes its elements and returns what moves them to the rows of the points that they need. */
const kinds = {
  support: () => {
    const base = add("path", "support"), hatch = add("path", "hatch");
    base.setAttribute("d", "M0 0L-13 18H13Z");
    hatch.setAttribute("d", "M-20 18H20M-16 26L-8 18M-6 26L2 18M4 26L12 18M14 26L22 18");
    return ([at]) => [base, hatch].forEach(element => put(element, flat(at)));
  },
  rail: (body, letters, off = 12) => {
    const rail = add("path", "rail"), hatch = add("path", "hatch");
    rail.setAttribute("d", `M-600 ${off}H600`);
    hatch.setAttribute("d", Array.from({ length: 76 }, (_, i) => `M${16 * i - 600} ${off + 8}l8 -8`).join(""));
    return ([at, way]) => {
      const [x, y] = unit(lean(way)), from = flat(at), along = Math.round(-(from[0] * x + from[1] * y) / 16) * 16;
      [rail, hatch].forEach(element => put(element, [from[0] + along * x, from[1] + along * y], Math.atan2(y, x) * 180 / Math.PI));
    };
  },
  link: body => {
    const halo = add("path", "halo"), link = add("path", `link ${colour(body)}`);
    halo.setAttribute("stroke-width", 9);
    link.setAttribute("stroke-width", 6);
    return ([a, b]) => [halo, link].forEach(element => element.setAttribute("d", line(flat(a), flat(b))));
  },
  turn: () => {
    const barrel = add("path", "joint"), ring = add("circle", "joint");
    for (const element of [barrel, ring]) element.setAttribute("stroke-width", 1.6);
    ring.setAttribute("r", 6);
    return ([at, way]) => {
      const [x, y] = lean(way), seen = Math.min(1, Math.hypot(x, y) / (Math.hypot(...way) || 1));
      const half = 11 * seen;
      barrel.setAttribute("d", seen > 0.05 ? `M${-half} -7H${half}V7H${-half}Z` : "");
      put(barrel, flat(at), Math.atan2(y, x) * 180 / Math.PI);
      put(ring, flat(at));
      ring.style.display = seen > 0.9 ? "none" : "";
    };
  },
  slide: () => {
    const guide = add("path", "rope"), box = add("path", "joint");
    guide.setAttribute("stroke-dasharray", "5 4");
    box.setAttribute("stroke-width", 1.6);
    box.setAttribute("d", "M-18 -11H18V11H-18Z");
    return ([at, way, fixed]) => {
      const [x, y] = lean(way);
      guide.setAttribute("d", line(flat(fixed), flat(at)));
      put(box, flat(at), Math.atan2(y, x) * 180 / Math.PI);
    };
  },
  weld: () => {
    const square = add("path", "weld");
    square.setAttribute("d", "M-4 -4H4V4H-4Z");
    return ([at]) => put(square, flat(at));
  },
  plane: () => {
    const square = add("path", "stand"), hatch = add("path", "hatch");
    return ([at, spot, first, second]) => {
      const ways = [first, second], size = ways.map(way => dot(way, way) || 1);
      const off = [0, 1, 2].map(i => spot[i] - at[i]), [u, v] = ways.map((way, i) => dot(off, way) / size[i]);
      const place = (a, b) => flat([0, 1, 2].map(i => at[i] + a * first[i] + b * second[i]));
      square.setAttribute("d", line(place(u - 1, v - 1), place(u + 1, v - 1), place(u + 1, v + 1), place(u - 1, v + 1)) + "Z");
      const strokes = [];
      for (let k = Math.ceil(4 * (u - 1)); k <= 4 * (u + 1); k++) strokes.push(line(place(k / 4, v - 1), place(k / 4, v + 1)));
      hatch.setAttribute("d", strokes.join(""));
    };
  },
  floor: body => {
    const edge = kinds.rail(body, "", 0), face = kinds.plane(), parts = [...into.children];
    return ([at, spot, first, second, normal]) => {
      const level = Math.hypot(...lean(normal)) > 0.999;
      parts.forEach((part, k) => { part.style.display = level === k < 2 ? "" : "none"; });
      if (level) edge([at, across(normal, axes[2])]);
      else face([at, spot, first, second]);
    };
  },
  rod: body => {
    const rod = add("path", `link ${colour(body)}`);
    rod.setAttribute("stroke-width", 6);
    return ([, a, b]) => rod.setAttribute("d", outlined([flat(a), flat(b)]));
  },
  disc: body => disc(body, "plate ", -1, "stem"),
  ring: body => disc(body, "", 0.88, `link ${colour(body)}`),
  plate: body => {
    const sheet = add("path", `plate link ${colour(body)}`);
    sheet.setAttribute("stroke-width", 2);
    return ([at, a, b]) => sheet.setAttribute("d", outlined([[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([x, y]) => spanned(at, a, b, x, y)), "Z"));
  },
  ball: body => {
    const outline = add("circle", `link ${colour(body)}`);
    outline.setAttribute("stroke-width", 2);
    outline.setAttribute("style", "fill:none");
    return ([at, rim]) => {
      outline.setAttribute("r", (scale * Math.hypot(...[0, 1, 2].map(i => rim[i] - at[i]))).toFixed(2));
      put(outline, flat(at));
    };
  },
  wheel: body => {
    const rim = add("path", `link ${colour(body)}`), spokes = add("path", "rope");
    for (const element of [rim, spokes]) element.setAttribute("stroke-width", 2);
    rim.setAttribute("style", "fill:none");
    return ([at, first, second]) => {
      const [o, a, b] = [at, first, second].map(flat), u = [a[0] - o[0], a[1] - o[1]], v = [b[0] - o[0], b[1] - o[1]];
      const around = angle => [0, 1].map(i => o[i] + Math.cos(angle) * u[i] + Math.sin(angle) * v[i]);
      rim.setAttribute("d", line(...Array.from({ length: 49 }, (_, k) => around(k * Math.PI / 24))) + "Z");
      spokes.setAttribute("d", line(around(0), around(Math.PI)) + line(around(Math.PI / 2), around(1.5 * Math.PI)));
    };
  },
  particle: body => {
    const ball = add("circle", `particle ${colour(body)}`);
    ball.setAttribute("r", 11);
    return ([at]) => put(ball, flat(at));
  },
  com: () => {
    const ring = add("circle", "com"), quarters = add("path", "com quarters");
    ring.setAttribute("r", 9);
    quarters.setAttribute("d", "M0 0V-9A9 9 0 0 1 9 0ZM0 0V9A9 9 0 0 1 -9 0Z");
    return ([at]) => [ring, quarters].forEach(element => put(element, flat(at)));
  },
  point: (body, letters) => {
    const spot = add("circle", "quarters"), name = label(letters);
    spot.setAttribute("r", 3);
    return ([at, start]) => {
      const [x, y] = flat(at), from = flat(start), [a, b] = unit([x - from[0], y - from[1]]);
      put(spot, [x, y]);
      name(a || b ? [x + 26 * a, y + 22 * b + 5] : [x + 24, y - 14]);
    };
  },
  spring: () => {
    const draw = spring();
    return ([a, b]) => draw(flat(a), flat(b));
  },
  damper: () => {
    const draw = damper();
    return ([a, b]) => draw(flat(a), flat(b));
  },
  spring_slide: () => beside(spring(), 9),
  damper_slide: () => beside(damper(), -9),
  spring_zero: () => beside(spring(), 9, true),
  damper_zero: () => beside(damper(), -9, true),
  spring_turn: () => around(k => 18 + 0.2 * k, 4 * Math.PI, 1.4),
  damper_turn: () => around(() => 21, 1.3 * Math.PI, 3.2),
  load: (body, letters) => {
    const draw = arrow("force", 2), name = label(letters);
    return ([at, force]) => {
      const from = flat(at), way = unit(lean(force));
      draw(from, way, way[0] || way[1] ? 45 : 0);
      name(way[0] || way[1] ? [from[0] + 58 * way[0], from[1] + 58 * way[1] + 5] : null);
    };
  },
  frame: () => {
    const group = add("g", "live-frame"), lines = ["x", "y", "z"].map(a => add("path", `triad-${a}`, group));
    lines.forEach(element => element.setAttribute("stroke-width", 2));
    group.style.display = "none";
    return ([at, ...ways]) => {
      const from = flat(at);
      lines.forEach((element, i) => {
        const [x, y] = lean(ways[i]);
        element.setAttribute("d", line(from, [from[0] + 34 * x, from[1] + 34 * y]));
      });
    };
  },
};

add("rect", "sheet");
for (const [name, value] of Object.entries({ x: -240, y: -180, width: 480, height: 360 })) picture.lastChild.setAttribute(name, value);
const marks = data.marks.map(([kind, rows, body, letters, joint]) => {
  const group = into = add("g", "mark", picture);
  into.dataset.mark = kind;
  if (body >= 0) into.dataset.body = data.bodies[body];
  if (joint) into.dataset.joint = joint;
  const move = kinds[kind](body, letters);
  into = picture;
  return { kind, group, rows, move };
});
const fall = arrow("gravity", 1.6), fallen = label('<tspan class="i">g</tspan>');

const box = (rows, places, low, high) => {
  for (const k of places) {
    lean(row(rows, k)).forEach((x, i) => {
      if (!Number.isFinite(x)) return;
      low[i] = Math.min(low[i], x);
      high[i] = Math.max(high[i], x);
    });
  }
};
/** Middles and one place of the rim of what is round: it reaches as far to the other side. */
const round = data.marks.filter(([kind]) => ["disc", "ring", "wheel", "ball"].includes(kind)).map(([, rows]) => rows);
const boxRound = (rows, low, high) => {
  for (const [at, rim] of round) {
    const from = row(rows, at), r = Math.hypot(...[0, 1, 2].map(i => row(rows, rim)[i] - from[i]));
    if (Number.isFinite(r)) lean(from).forEach((x, i) => { low[i] = Math.min(low[i], x - r); high[i] = Math.max(high[i], x + r); });
  }
};
/** Rows of points that bodies carry along. */
const carriedAlong = [...new Set(data.marks.flatMap(([kind, rows, body]) => body < 0 ? [] : ["turn", "slide"].includes(kind) ? [rows[0]] : rows))]
  .filter(k => data.points.includes(k));
let low = [0, 0], high = [0, 0], begun = [0, 0];
/** Chooses the scale by where turns and loops lead, and by the next part of the way of slides, which the picture follows. */
const fit = () => {
  low = [Infinity, Infinity];
  high = [-Infinity, -Infinity];
  for (const at of reached()) {
    const rows = call("drawn_points", { ...at, qd: new Float64Array(n) });
    box(rows, data.points, low, high);
    boxRound(rows, low, high);
  }
  const most = Math.max(high[0] - low[0], high[1] - low[1]);
  begun = [0, 1].map(i => Math.max(high[i] - low[i], most / 2));
};
/** Moves the picture along with what would leave it; it grows to half as much again, beyond which bodies may leave it. */
const follow = rows => {
  const from = [Infinity, Infinity], to = [-Infinity, -Infinity];
  box(rows, carriedAlong, from, to);
  boxRound(rows, from, to);
  for (const i of [0, 1]) {
    const more = Math.min(to[i] - from[i], 1.5 * begun[i]) - (high[i] - low[i]);
    if (more > 0) [low[i], high[i]] = [low[i] - more / 2, high[i] + more / 2];
    const after = Math.max(0, to[i] - high[i]), before = Math.max(0, low[i] - from[i]);
    const off = after && before ? 0 : after - before; // what parts with the others leaves them in the picture
    if (Number.isFinite(off)) [low[i], high[i]] = [low[i] + off, high[i] + off];
  }
};
const draw = () => {
  const rows = call("drawn_points");
  follow(rows);
  scale = Math.min(420 / (high[0] - low[0] || 1), 300 / (high[1] - low[1] || 1));
  middle = [0, 1].map(i => (low[i] + high[i]) / 2);
  named = [];
  const way = unit(lean(row(rows, data.gravity)));
  fall([-215, -150], way, way[0] || way[1] ? 36 : 0);
  fallen(way[0] || way[1] ? [-198, -138] : null);
  for (const mark of marks) mark.move(mark.rows.map(k => row(rows, k)));
  overlays(rows);
  tellPage("state", state);
};
