"use strict";
// Which terms of a wrong answer differ, by value: see symdyn.teach.student.parts.
const Terms = (() => {
  const {apart} = QUESTIONS, CLOSE = 1e-7, ALIKE = 1e-5, FACTOR = 1.5;
  // What many rows share stands once: columns of terms, steps that are the same at all points, rules of mistakes
  for (const one of Object.values(QUESTIONS.terms).flat()) {
    for (const kind of ["rows", "beside"]) one[kind] = one[kind].map(k => QUESTIONS.columns[k]);
    for (const handle of one.handles) handle[0] = handle[1].map((_, k) => handle[0][k] || handle[0][0]);
  }
  for (const [key, groups] of Object.entries(QUESTIONS.mistakes)) QUESTIONS.mistakes[key] = groups.flatMap(([rule, of, other, rows]) => rows.map(row => [rule, of, other, ...row]));

  const sum = list => list.reduce((a, b) => a + b, 0), dot = (a, b) => sum(a.map((x, k) => x * b[k])), largest = list => Math.max(...list.map(Math.abs));
  const moved = (point, by, times) => ({...point, ...Object.fromEntries(Object.entries(by).map(([name, x]) => [name, point[name] + times * x]))});

  // The slopes of what is worth three values in equal steps; null where one is zero, or they differ
  function linear(rows) {
    const size = largest(rows.flat()), slopes = rows.map(([a, b]) => b - a);
    const straight = rows.every(([, b, c], k) => Math.abs(c - b - slopes[k]) <= CLOSE * size);
    return Number.isFinite(size) && straight && slopes.every(x => Math.abs(x) > CLOSE * size) ? slopes : null;
  }

  // What differs in a wrong answer: rules, kinds and terms, the cheapest first; null where that cannot be told
  function told(key, of, rule) {
    const every = QUESTIONS.terms[key], multipliers = QUESTIONS.motions.multipliers, used = symbols(of, apart.points[0]);
    const tied = multipliers.some(name => used.has(name));
    const ways = every.filter(one => one.multipliers || !tied).map(one => [one, explained(one, of)]).filter(([one, found]) => found && (tied || !one.multipliers || (found.sure && found.rules.includes("untied"))));
    if (!ways.length) return null;
    const [one, found] = ways.reduce((a, b) => a[1].cost <= b[1].cost ? a : b), rows = all(one);
    const beside = rule && (found.rules.includes("absolute") || (rule === "index" && apart.swapped.some(rules => rules.join() === found.rules.join()))) ? [rule] : [];
    if (rule && !found.sure && !found.rules.includes(rule) && !beside.length) return null;
    const of_ = found.columns.flatMap(k => (rows[k][5] || [k]).map(n => rows[n])).filter(row => row[1]), loose = !tied && found.sure && ways.some(([one]) => one.multipliers), rules = [...new Set([...(found.sure ? [] : beside), ...found.rules, ...(loose ? ["untied"] : [])])];
    if (rule && rules.every(one => apart.vague.includes(one)) && !(rule === "cross" && rules.join() === "termsign") && found.columns.some(k => (apart.suits[rows[k][0]] || []).includes(rule))) rules.unshift(rule);
    const changes = (found.changes || []).map(([change, k]) => [change, ...(rows[k] ? [(rows[k][5] || [k]).map(n => rows[n][1]).join("<mo>,</mo>"), rows[k][0]] : [""])]).filter(([change, term, kind]) => term || change !== "missing" || !apart.angles.includes(kind));
    return {rules, kinds: [...new Set(of_.map(([kind]) => kind))], changes, sure: found.sure};
  }
  // What an answer is times where it is the scene's, by point, with a price
  function scales(one, of) {
    const {handles} = one, {points} = apart, mine = points.map(of), scaled = handles.length ? [] : [[0, mine.map(() => 1)]], [dear, untied] = apart.prices;
    for (const [steps, slope, name] of handles) {
      const slopes = linear(mine.map((x, k) => [x, ...[1, 2].map(n => of(moved(points[k], steps[k], n)))]));
      if (!slopes || (name && mine.every((x, k) => Math.abs(x - points[k][name] * slopes[k]) <= CLOSE * Math.abs(x)))) continue;
      const by = slope.map((b, k) => b / slopes[k]), cost = by.every(x => Math.abs(Math.abs(x) - 1) < CLOSE) ? 0 : dear;
      scaled.push([cost + untied * one.multipliers, by]);
    }
    return [...scaled, ...one.common.map(by => [dear, by])];
  }
  function explained(one, of) {
    const {handles} = one, mine = apart.points.map(of), scaled = scales(one, of).map(([cost, by]) => [cost, mine.map((x, k) => x * by[k])]), found = [];
    for (const deep of [false, true]) if (!found.length) for (const [more, values] of scaled) {  // two terms at once only where no single one tells
      const told = search(one, values, deep);
      if (told) found.push({...told, cost: told.cost + more});
    }
    if (!found.length && !handles.length) for (const [times, rule] of apart.times) {
      const other = search(one, mine.map(x => times * x), false);
      if (other) found.push({...other, cost: other.cost + 1, rules: [rule, ...other.rules]});
    }
    return found.length ? cheapest(found) : null;
  }

  // How many terms, as they are written, an answer is right without: one, or all of no term's values; or 0
  function surplus(key, of, terms) {
    const used = symbols(of, apart.points[0]), tied = QUESTIONS.motions.multipliers.some(name => used.has(name)), found = [];
    for (const one of QUESTIONS.terms[key].filter(one => one.multipliers === tied)) for (const [, by] of scales(one, of)) {
      const own = terms.map(term => apart.points.map((p, k) => term(p) * by[k])), half = by.length / 2, total = list => by.map((_, k) => sum(list.map(row => row[k])));
      const change = row => one.free ? row.slice(half).map((x, k) => x - row[k]) : row, left = change(total(own).map((x, k) => x - one.right[k])), most = largest(left);
      const same = row => most > CLOSE * largest(own.flat()) && change(row).every((x, k) => Math.abs(left[k] - x) <= ALIKE * most);
      const lone = own.filter(row => one.rows.every(([, form, values]) => !form || share(row, values, largest(row)) === null));
      if (own.some(same)) return 1;
      if (same(total(lone))) found.push(lone.length);
    }
    return found.length ? Math.min(...found) : 0;
  }

  // How the terms of an answer differ, one by one, where no rule tells: of the ways to write it that with the fewest
  function listed(key, of, terms) {
    const used = symbols(of, apart.points[0]), tied = QUESTIONS.motions.multipliers.some(name => used.has(name));
    const ways = QUESTIONS.terms[key].filter(one => one.multipliers === tied && !(one.tied && one.handles.length)).flatMap(one => [...new Map(scales(one, of).map(([, by]) => [by.map(x => x.toPrecision(6)).join(), by])).values()].map(by => unlike(one, terms.map(term => apart.points.map((p, k) => term(p) * by[k])))));
    return ways.filter(list => list.length).reduce((a, b) => a && a.length <= b.length ? a : b, null) || [];
  }
  function unlike({rows, free}, mine) {
    if (!mine.flat().every(Number.isFinite)) return [];
    const half = apart.points.length / 2, fine = rows.filter(row => row[1]), worth = fine.map(() => 0);
    const over = new Set(mine.filter(row => !free || row.slice(half).some((x, k) => x !== row[k])));
    const pairs = () => over.size > 8 ? [] : [...over].flatMap((a, k, list) => list.slice(k + 1).map(b => [a, b]));
    for (const list of [() => [...over].map(row => [row]), pairs]) for (const some of list()) if (some.every(row => over.has(row))) {  // two make one: a sum of angles
      const row = some[0].map((_, n) => sum(some.map(row => row[n]))), c = fine.map(one => share(row, one[2], largest(row))), k = c.findIndex(x => x !== null);
      if (k >= 0) { worth[k] += c[k]; some.forEach(row => over.delete(row)); }
    }
    if (over.size > 8) return [];  // another formula
    const changes = fine.flatMap(([kind, form], k) => {
      const ways = Math.abs(worth[k]) < CLOSE ? [...over].flatMap(row => times(fine[k], row).map(one => [one[2], row])) : [];
      const [change, row] = ways.find(one => one[0] !== "moved") || ways[0] || [changed(worth[k] - 1)];  // another symbol may be that of another term
      over.delete(row);
      return Math.abs(worth[k] - 1) < ALIKE ? [] : [[change, form, kind]];
    });
    return [...changes, ...[...over].map(() => ["extra", "", ""])];
  }

  // The terms, then those together that are alike; these know which they are
  const all = one => one.all = one.all || [...one.rows, ...one.alike.map(list => [list.every(k => one.rows[k][0] === one.rows[list[0]][0]) ? one.rows[list[0]][0] : "inertia", one.rows[list[0]][1], one.right.map((_, n) => sum(list.map(k => one.rows[k][2][n]))), one.rows[list[0]][3], [], list])];
  function search(one, mine, deep) {
    const {right, free, tied, beside} = one, columns = all(one), lone = one.rows.length;
    const e = mine.map((x, k) => x - right[k]), size = Math.max(largest(mine), ...columns.map(one => largest(one[2])));
    if (!Number.isFinite(size) || largest(e) <= CLOSE * size) return null;
    const half = e.length / 2, change = row => free ? row.slice(half).map((x, k) => x - row[k]) : row;
    const rows = columns.map(one => change(one[2])), left = change(e), fine = one.rows.flatMap((row, k) => row[1] ? [k] : []);
    // sin² q for cos² q: all but turned, by a constant that is free
    const other = (k, c) => Math.abs(c + 2) < ALIKE && columns[k][0].startsWith("spring") && apart.atoms.some(one => one[0]) && e.some((x, n) => Math.abs(x + 2 * columns[k][2][n]) > CLOSE * size);
    const singles = rows.flatMap((row, k) => { const c = share(left, row, size); return c === null || !states(columns[k], c).length ? [] : [[price(c) + 0.2 * (k >= lone), c, k]]; });
    const alone = singles.filter(one => one[2] < lone);
    if (singles.length) return single(columns, alone.length ? alone : singles, tied, other);
    const some = fine.length ? fine : [...one.rows.keys()], alike = one.alike.map((_, k) => lone + k);
    const others = [...some, ...alike].flatMap(k => replaced(columns[k], e).map(([cost, rules, change]) => ({cost: 2 + cost + 0.3 * (k >= lone), rules, columns: [k], changes: [[change, k]]})));
    for (const j of some.length > apart.paired ? [] : some) for (const k of some) if (j < k) {  // the same in both
      const both = columns[j][2].map((x, n) => x + columns[k][2][n]);
      others.push(...replaced([columns[k][0], columns[k][1], both, columns[k][3]], e).map(([cost, rules, change]) => ({cost: 2.5 + cost, rules, columns: [j, k], changes: [[change, j], [change, k]]})));
    }
    const groups = columns.map((row, k) => row[5] || [k]), mixed = groups.map(list => new Set(list.map(n => columns[n][0])).size > 1);
    const made = groups.map((list, k) => one.made[k] && one.made[k].length ? one.made[k] : list), against = (j, k, [c, d]) => c * d < 0 && made[j].some(n => made[k].includes(n));
    const overlap = (j, k) => groups[j].some(n => groups[k].includes(n)) || ((mixed[j] || mixed[k]) && !(columns[j][1] && columns[k][1]));
    for (let j = 0; j < columns.length; j++) for (let k = j + 1; k < columns.length; k++) {
      const both = shares(left, rows[j], rows[k], size);
      if (!both || overlap(j, k) || against(j, k, both)) continue;
      const at = [j, k], told = at.map((n, i) => states(columns[n], both[i])), cost = 0.25 + sum(at.map((n, i) => price(both[i]) + 0.1 * !columns[n][1] + 0.2 * (n >= lone)));
      if (told.every(rules => rules.length)) others.push({cost, rules: told.flat(), columns: at, changes: at.map((n, i) => [changed(both[i]), n]), sure: both.every(c => price(c) < FACTOR)});
    }
    const known = [...fine.map(k => columns[k]), ...(deep ? [] : beside)];
    if (!free) others.push(...extra(known, beside, e, size));
    if (!others.length && !tied && deep && fine.length <= apart.paired) for (const j of fine) for (const c of apart.both) {
      const rest = e.map((x, k) => x - c * columns[j][2][k]), rules = states(columns[j], c);
      for (const k of fine) if (k !== j) for (const [cost, told, change] of replaced(columns[k], rest)) others.push({cost: 3.5 + cost, rules: [...rules, ...told], columns: [j, k], changes: [[changed(c), j], [change, k]]});
      if (!free) for (const one of extra(known, beside, rest, size)) others.push({cost: 1.5 + one.cost, rules: [...rules, ...one.rules], columns: [j], changes: [[changed(c), j], ...one.changes]});
    }
    return others.length ? cheapest(others) : null;
  }
  // What is too much: a term of another equation, or a term of this one with another symbol in it
  function extra(known, beside, e, size) {
    const told = beside.map(one => share(e, one[2], size)).filter(c => c !== null).map(c => ({cost: 2 + (price(c - 1) - 1) / 4, rules: ["extra"], columns: [], changes: [["extra", -1]]}));
    return told.length ? told : known.flatMap(one => times(one, e).map(([cost]) => ({cost: 2.6 + cost, rules: ["extra"], columns: [], changes: [["extra", -1]]})));
  }
  const cheapest = list => list.reduce((a, b) => a.cost <= b.cost ? a : b);
  // What one column tells that accounts for a difference: a term, and what one rule makes
  function single(columns, singles, tied, other) {
    const cost = Math.min(...singles.map(one => one[0])), first = singles.filter(one => !tied || one[0] === cost);
    const sorted = whole => first.filter(one => !columns[one[2]][1] === whole).sort((a, b) => a[0] - b[0]);
    const terms = sorted(false), whole = sorted(true);
    const fine = terms.length > 1 && terms[0][0] === terms[1][0] ? [] : terms.slice(0, 1);  // none is known to be the one
    const told = [...fine, ...whole.slice(0, 1)].flatMap(([, c, k]) => other(k, c) ? ["trig"] : states(columns[k], c)), rules = told.length ? told : ["termfactor"];
    const special = rules.filter(rule => !["term", "termgravity"].includes(rule));
    return {cost, rules: special.length ? special : rules, columns: fine.map(one => one[2]), changes: (fine.length ? fine : whole.slice(0, 1)).map(([, c, k]) => [other(k, c) ? "function" : changed(c), k]), sure: true};
  }
  function states([kind, form, , , also], c) {
    const [lost, turned, factor] = apart.states[kind].map((rule, k) => rule || (form ? apart.plain[k] : ""));
    const scaled = factor + (/π/.test(form) && apart.round.some(x => Math.abs(1 + c - x) < CLOSE * x) ? " power" : "");
    if (!turned && c < -1 - ALIKE) return [];
    const vague = ["spring", "friction", "force"].includes(turned) ? [turned, "termsign"] : [turned];  // they say no sign
    return (Math.abs(c + 1) < ALIKE ? [lost, ...also.map(kind => apart.states[kind][0])] : Math.abs(c + 2) < ALIKE ? vague : c < -1 ? [turned, scaled] : [scaled]).join(" ").split(" ").filter(Boolean);
  }
  // How a term is changed, by the words of a shell's differences
  const changed = c => Math.abs(c + 1) < ALIKE ? "missing" : c < -1 ? "sign" : "factor";
  const price = c => Math.abs(c + 1) < ALIKE ? 1 : Math.abs(c + 2) < ALIKE ? 1.1 : FACTOR;
  function share(e, row, size) {
    const square = dot(row, row), c = dot(e, row) / square;
    return square > (CLOSE * size) ** 2 && e.every((x, k) => Math.abs(x - c * row[k]) <= CLOSE * size) ? c : null;
  }
  function shares(e, one, two, size) {
    const aa = dot(one, one), ab = dot(one, two), bb = dot(two, two), det = aa * bb - ab * ab;
    if (det <= 1e-9 * aa * bb) return null;
    const ea = dot(e, one), eb = dot(e, two), c = (ea * bb - eb * ab) / det, d = (eb * aa - ea * ab) / det;
    return e.every((x, k) => Math.abs(x - c * one[k] - d * two[k]) <= CLOSE * size) ? [c, d] : null;
  }
  // What stands for something else in a term, t n a/b in place of t, or t n a b, or t n/(a b), with a price
  const replaced = (column, e) => times(column, column[2].map((x, k) => x + e[k]));
  function times([kind, form, t, squared], mine) {
    if (t.some((x, k) => x === 0 || Math.abs(mine[k]) <= 1e-9 * Math.abs(x))) return [];
    const ratio = mine.map((y, k) => y / t[k]), found = [];
    for (const [a, b, both] of pairs(ratio[0] / ratio[1])) {
      const [top, bottom] = [a[3], b[3]], n = ratio[0] * over(top[0], bottom[0], both);
      if (!Number.isFinite(n) || !ratio.every((r, k) => Math.abs(r * over(top[k], bottom[k], both) - n) <= 1e-7 * Math.abs(n))) continue;
      const beside = [...(n < 0 ? [apart.states[kind][1] || "termsign"] : []), ...(Math.abs(Math.abs(n) - 1) > 1e-6 ? ["termfactor"] : [])];
      if (beside.length === 2) continue;  // a chance
      const cost = 0.1 * !!(a[1] && b[1]) + 0.2 * beside.length + 0.15 * !!both, rules = exchanged(a, b, both, squared);
      const tied = !form && rules.join() === "index";  // the ratio of a condition, of several terms
      const [f, g] = [a[0], b[0]], change = both || !(a[1] && b[1]) ? "power" : !f && !g ? "moved" : f === g ? "angle" : "function";
      found.push([cost, tied ? ["termfactor", ...beside.slice(0, +(n < 0))] : [...rules, ...beside], tied ? "factor" : change]);
    }
    return found;
  }
  const over = (a, b, both) => both ? (a * b) ** -both : b / a;
  let sorted = null;
  // Those pairs whose values at the first two points are so far apart, of thousands that are looked at in every term
  function pairs(distance) {
    sorted = sorted || every().map(([a, b, both], k) => [over(a[3][1], b[3][1], both) / over(a[3][0], b[3][0], both), k, [a, b, both]]).filter(([x]) => Number.isFinite(x)).sort((one, other) => one[0] - other[0]);
    const near = 2e-7 * Math.abs(distance);
    let low = 0, high = sorted.length;
    while (low < high) sorted[(low + high) >> 1][0] < distance - near ? low = ((low + high) >> 1) + 1 : high = (low + high) >> 1;
    while (high < sorted.length && sorted[high][0] <= distance + near) high++;
    return sorted.slice(low, high).sort((one, other) => one[1] - other[1]).map(one => one[2]);
  }
  function every() {
    const found = [], unlike = (a, b) => a[0] !== b[0] || a[1] !== b[1], list = apart.atoms;
    for (const a of list) for (const b of list) if (unlike(a, b)) found.push([a, b, 0]);
    list.forEach((a, j) => list.slice(j + 1).forEach(b => { if (j && unlike(a, b)) found.push([a, b, 1], [a, b, -1]); }));
    return found;
  }
  function exchanged([f, a, unit], [g, b, below], both, squared) {
    const units = [unit, below].some(x => !["1", "rad", "rad^2"].includes(x)), alone = f || g;
    if (both || !(a && b)) return alone && !both ? [squared.includes(alone) || alone.endsWith("^2") ? "power" : "trig"] : units ? ["power", "dimension"] : ["power"];
    if (f && f === g) return ["absolute"];
    if (f || g) return [(f && g) || !units ? "trig" : "dimension"];
    return unit !== below ? ["index", "dimension"] : [apart.ratios.includes([a, b].sort().join(" ")) ? "ratio" : "index"];
  }
  // The symbols that a formula asks for
  function symbols(of, point) {
    const names = new Set();
    of(new Proxy(point, {get: (values, name) => { names.add(name); return values[name]; }}));
    return names;
  }
  return {told, listed, surplus, used: symbols};
})();
