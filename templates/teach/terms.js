"use strict";
// Which terms of a wrong answer differ, by value: see symdyn.teach.student.parts.
const Terms = (() => {
  const {lost, turned, suits} = QUESTIONS.suits;
  const MOST_WRONG = 3, DIFFERS = 1e-6;

  // The coefficients with which some columns are an answer; null where they are not, or all are right
  function fitted(mine, columns) {
    const size = Math.max(...mine.map(Math.abs), ...columns.flat().map(Math.abs));
    if (!Number.isFinite(size) || mine.length < columns.length) return null;
    const basis = [], R = columns.map(() => []);
    let left = mine;
    const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0), less = (a, b, f) => a.map((x, k) => x - f * b[k]);
    const along = [];
    for (const [j, column] of columns.entries()) {
      let rest = column;
      for (let twice = 0; twice < 2; twice++) basis.forEach((one, k) => { const f = dot(one, rest); R[j][k] = (R[j][k] || 0) + f; rest = less(rest, one, f); });
      const length = Math.sqrt(dot(rest, rest));
      if (length < 1e-9 * Math.sqrt(dot(column, column))) return null;
      R[j][j] = length;
      basis.push(rest.map(x => x / length));
      along[j] = dot(basis[j], left);
      left = less(left, basis[j], along[j]);
    }
    if (Math.max(...left.map(Math.abs)) > 1e-7 * size) return null;
    const found = [];
    for (let j = columns.length - 1; j >= 0; j--) {
      found[j] = (along[j] - found.reduce((sum, x, k) => k > j ? sum + x * R[k][j] : sum, 0)) / R[j][j];
    }
    const wrong = found.filter(x => Math.abs(x - 1) > DIFFERS).length;
    return wrong > 0 && wrong <= Math.min(MOST_WRONG, Math.max(1, found.length - 1)) ? found : null;
  }

  // The rules that wrong terms tell, their kinds and the terms themselves; null where none can be told apart
  function apart(key, of, points, rule) {
    const {rows, slopes} = QUESTIONS.terms[key], mine = points.map(of);
    const scaled = [mine, ...(slopes.length ? [mine.map(x => -x)] : [])];
    for (const [name, right] of slopes) {
      const slope = points.map((p, k) => of({...p, [name]: p[name] + 1}) - mine[k]);
      if (slope.every(x => Math.abs(x) > 1e-12)) scaled.push(mine.map((x, k) => x * right[k] / slope[k]));
    }
    const count = found => found.filter(x => Math.abs(x - 1) > DIFFERS).length;
    const fits = scaled.map(values => fitted(values, rows.map(row => row[2]))).filter(Boolean).sort((a, b) => count(a) - count(b));
    if (!fits.length) return null;
    const wrong = rows.map((row, k) => [fits[0][k], ...row]).filter(([c]) => Math.abs(c - 1) > DIFFERS);
    const told = wrong.map(([c, kind]) => Math.abs(c) < DIFFERS ? lost[kind] || "term" : Math.abs(c + 1) < DIFFERS ? turned[kind] || "termsign" : "termfactor");
    const suited = rule && wrong.some(([, kind]) => suits[kind].includes(rule));
    if (suited && told.length === 1 && told[0].startsWith("term")) told.pop();  // the rule says more than that a term differs
    if (suited) told.push(rule);
    return {rules: [...new Set(told)], kinds: [...new Set(wrong.map(([, kind]) => kind))], terms: wrong.map(([, , math]) => math)};
  }
  return {apart};
})();
