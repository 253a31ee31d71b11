"use strict";
// Which terms of a wrong answer differ, by value: see symdyn.teach.student.parts.
const Terms = (() => {
  const {apart} = QUESTIONS, CLOSE = 1e-7, FACTOR = 1.5;
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
    const {rows, right, handles, free, tied} = QUESTIONS.terms[key], {points} = apart;
    const mine = points.map(of), scaled = handles.length ? [] : [mine];
    for (const [steps, slope] of handles) {
      const slopes = linear(mine.map((x, k) => [x, ...[1, 2].map(n => of(moved(points[k], steps[k], n)))]));
      if (slopes) scaled.push(mine.map((x, k) => x * slope[k] / slopes[k]));
    }
    const found = scaled.map(values => search(rows, right, free, tied, values)).filter(Boolean).reduce((a, b) => a && a.cost <= b.cost ? a : b, null);
    if (!found || (rule && !found.sure && !found.rules.includes(rule))) return null;
    const of_ = found.columns.map(k => rows[k]).filter(row => row[1]), rules = [...new Set(found.rules)];
    if (rule && rules.every(one => apart.vague.includes(one)) && of_.some(([kind]) => (apart.suits[kind] || []).includes(rule))) rules.unshift(rule);
    return {rules, kinds: [...new Set(of_.map(([kind]) => kind))], terms: of_.map(row => row[1])};
  }

  function search(columns, right, free, tied, mine) {
    const e = mine.map((x, k) => x - right[k]), size = Math.max(largest(mine), ...columns.map(one => largest(one[2])));
    if (!Number.isFinite(size) || largest(e) <= CLOSE * size) return null;
    const half = e.length / 2, change = row => free ? row.slice(half).map((x, k) => x - row[k]) : row;
    const rows = columns.map(one => change(one[2])), left = change(e), fine = columns.flatMap((one, k) => one[1] ? [k] : []);
    const singles = rows.flatMap((row, k) => { const c = share(left, row, size); return c === null || !states(columns[k], c).length ? [] : [[price(c), c, k]]; });
    if (singles.length) return single(columns, singles, tied);
    const some = fine.length ? fine : [...columns.keys()];
    const others = some.flatMap(k => replaced(columns[k], e).map(([cost, rules]) => ({cost: 2 + cost, rules, columns: [k]})));
    for (const j of fine) for (const k of fine) if (j < k) {  // the same in both
      const both = columns[j][2].map((x, n) => x + columns[k][2][n]);
      others.push(...replaced([columns[k][0], columns[k][1], both], e).map(([cost, rules]) => ({cost: 2.5 + cost, rules, columns: [j, k]})));
    }
    for (let j = 0; j < columns.length; j++) for (let k = j + 1; k < columns.length; k++) {
      const both = shares(left, rows[j], rows[k], size);
      if (!both) continue;
      const at = [j, k], told = at.map((n, i) => states(columns[n], both[i])), cost = 0.25 + sum(at.map((n, i) => price(both[i]) + 0.1 * !columns[n][1]));
      if (told.every(rules => rules.length)) others.push({cost, rules: told.flat(), columns: at, sure: both.every(c => price(c) < FACTOR)});
    }
    if (!others.length && !tied) for (const j of fine) for (const c of [-1, -2]) {
      const rest = e.map((x, k) => x - c * columns[j][2][k]);
      for (const k of fine) if (k !== j) for (const [cost, rules] of replaced(columns[k], rest)) others.push({cost: 3.5 + cost, rules: [...states(columns[j], c), ...rules], columns: [j, k]});
    }
    return others.length ? cheapest(others) : null;
  }
  const cheapest = list => list.reduce((a, b) => a.cost <= b.cost ? a : b);
  // What one column tells that accounts for a difference: a term, and what one rule makes
  function single(columns, singles, tied) {
    const cost = Math.min(...singles.map(one => one[0])), first = singles.filter(one => !tied || one[0] === cost);
    const sorted = whole => first.filter(one => !columns[one[2]][1] === whole).sort((a, b) => a[0] - b[0]);
    const terms = sorted(false), whole = sorted(true);
    const fine = terms.length > 1 && terms[0][0] === terms[1][0] ? [] : terms.slice(0, 1);  // none is known to be the one
    const told = [...fine, ...whole.slice(0, 1)].flatMap(([, c, k]) => states(columns[k], c)), rules = told.length ? told : ["termfactor"];
    const special = rules.filter(rule => rule !== "term");
    return {cost, rules: special.length ? special : rules, columns: fine.map(one => one[2]), sure: true};
  }
  function states([kind, form], c) {
    const [lost, turned, scaled] = apart.states[kind].map((rule, k) => rule || (form ? apart.plain[k] : ""));
    if (!turned && c < -1 - CLOSE) return [];
    return (Math.abs(c + 1) < CLOSE ? [lost] : Math.abs(c + 2) < CLOSE ? [turned] : c < -1 ? [turned, scaled] : [scaled]).filter(Boolean);
  }
  const price = c => Math.abs(c + 1) < CLOSE ? 1 : Math.abs(c + 2) < CLOSE ? 1.1 : FACTOR;
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
  // What stands for something else in a term, t n a/b in place of t, with a price
  function replaced([kind, , t], e) {
    if (t.some((x, k) => x === 0 || Math.abs(x + e[k]) <= 1e-9 * Math.abs(x))) return [];
    const ratio = t.map((x, k) => 1 + e[k] / x), found = [];
    for (const [f, a, unit, top] of apart.atoms) for (const [g, b, below, bottom] of apart.atoms) {
      if (f === g && a === b) continue;
      const n = ratio[0] * bottom[0] / top[0];
      if (!ratio.every((r, k) => Math.abs(r * bottom[k] - n * top[k]) <= 1e-7 * Math.abs(n * top[k]))) continue;
      const beside = [...(n < 0 ? [apart.states[kind][1] || "termsign"] : []), ...(Math.abs(Math.abs(n) - 1) > 1e-6 ? ["termfactor"] : [])];
      found.push([0.1 * !!(a && b) + 0.2 * beside.length, [exchanged(f, g, unit, below), ...beside]]);
    }
    return found;
  }
  function exchanged(f, g, unit, below) {
    if (f && f === g) return "absolute";
    if (f || g) return (f && g) || [unit, below].some(x => x === "1" || x === "rad") ? "trig" : "dimension";
    return unit === below ? "index" : "dimension";
  }
  return {told};
})();
