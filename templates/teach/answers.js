"use strict";
// Typed answers, judged by value: as results, on the motions of the scene, and by the mistakes that give them.
const Answers = (() => {
  const {dotted, free, points, values, words, speeds, balances, mistakes, marks, pairs, alone: drives, drawn, twins, bound, rounded, enough, scaled, terms, motions, called} = QUESTIONS;
  const {Fault, has, members, label, parsed: formula, formula: formula_of} = Formulas;

  const TOLERANCE = 1e-9, ROUNDED = 1e-4;  // of the largest value: doubles lose some digits, wrong answers all of them
  // Whether a potential energy differs from the answer by what does not change with position
  function elsewhere(key, mine) {
    const right = values[key], size = Math.max(...right.slice(0, drawn).map(Math.abs), ...mine.slice(0, drawn).map(Math.abs), 1e-12);
    const changes = list => [...Array(twins).keys()].map(k => list[drawn + k] - list[k]), moved = changes(right), yours = changes(mine);
    return moved.every((x, k) => Math.abs(x - yours[k]) <= TOLERANCE * size);
  }

  const said = (right, word, place = "") => ({right, text: words[word].replace("{text}", place).replace("{factor}", place)});
  const whole = (word, place) => ({...said(false, word, place), whole: word});  // it says all that is wrong
  // Whether a word calls what is asked, whatever the scene's symbols are
  const calls = (key, word) => has(called, key) && (called[key].includes(word) || (called[key].includes("p") && word.startsWith("p")));
  function judge(key, source) {
    try {
      if (source.length > 5000) throw new Fault("fault.deep");
      const parts = members(source), named = parts.map(label), last = parts.length - 1, formulas = [];
      parts.forEach((part, k) => {
        if (k === 0 && last && part.length === 1 && part[0].kind === "word" && calls(key, part[0].text)) return;
        if (named[k] && parts.length > 1) return;
        if (named[k]) throw new Fault("fault.quantity", named[k]);
        try {
          formulas.push({decimals: decimals(part), of: formula(part)});
        } catch (fault) {
          const onTheWay = fault instanceof Fault && fault.key === "fault.name" && ((k === 0 && last && part.length === 1) || (parts.slice(k + 1).some(one => one.length > 1) && new RegExp(`^(?:${speeds})$`).test(fault.text.replaceAll("_", ""))));
          if (!onTheWay) throw fault;
        }
      });
      if (!formulas.length) throw new Fault("fault.quantity", named.find(Boolean));
      const cut = [...new Set(parts.filter((_, k) => !named[k]).flatMap(Formulas.starred))].join(", ");
      return {...boxed(key, formulas, named), stars: cut && words["answer.stars"].replace("{text}", () => cut)};
    } catch (fault) {
      if (!(fault instanceof Fault)) throw fault;
      return said(false, fault.key, fault.text);
    }
  }
  // What stands behind what is in front of the box, or behind the drive alone where that is right, or tells more than loads
  function boxed(key, formulas, named) {
    const told = settledBy(key, formulas, named), rule = told.rules ? told.rules[0] : told.rule;
    if (told.right || formulas.length > 1 || !has(drives, key)) return told;
    const alone = settledBy(key, [{of: p => p[drives[key]], decimals: []}, ...formulas], named);
    if (alone.right) return said(true, "answer.drive", drives[key]);
    const other = alone.rules ? alone.rules[0] : alone.rule, twice = rule === "termfactor" && other !== rule;  // a load that stands in front, too
    return other && (!rule || twice || LOADS.includes(rule)) ? alone : told;
  }
  const LOADS = ["friction", "force"];
  function settledBy(key, formulas, named) {
    const energy = motions && free.includes(key), names = energy ? motions.multipliers.filter(name => formulas.some(one => Terms.used(one.of, points[0]).has(name))) : [];
    if (!names.length) return alongEither(key, formulas, named);
    if (!formulas.every(one => conditions(one.of))) return forgot(["multiplier", "", ""]);
    const none = Object.fromEntries(names.map(name => [name, 0])), alone = formulas.map(one => ({of: p => one.of({...p, ...none}), decimals: []}));
    const told = judgedAs(key, alone, named);
    return told.right ? said(true, "answer.multiplied", names.join(", ")) : told;
  }
  // Whether an energy has every multiplier once, times a condition of positions that holds on the motions, no two the same
  function conditions(of) {
    const {multipliers, groups, names, keeps} = motions, on = groups[0].on.map(row => Object.fromEntries(row.map((x, k) => [names[k], x])));
    const at = (p, ...used) => of({...p, ...Object.fromEntries(multipliers.map((name, k) => [name, used[k] || 0]))});
    const each = multipliers.map((_, k) => (p, times = 1) => at(p, ...Array(k).fill(0), times) - at(p));
    const places = groups[0].off[0].length, size = Math.max(...points.slice(0, drawn).map(p => Math.max(...each.map(f => Math.abs(f(p))))));
    const small = x => Math.abs(x) <= 1e-7 * size, faster = p => ({...p, ...Object.fromEntries(Object.values(dotted).flat().map(name => [name, 2 * p[name] + 1]))});
    const fair = points.slice(0, drawn).every(p => small(at(p, ...multipliers.map(() => 1)) - at(p) - each.reduce((sum, f) => sum + f(p), 0)) && each.every(f => small(f(p, 2) - 2 * f(p)) && small(f(faster(p)) - f(p))));
    const holds = each.every(f => on.every(p => small(f(p))) || (keeps && on.slice(0, places).every((p, k) => small(f(p) - f(on[places + k])))));
    const slopes = each.map(f => Object.keys(dotted).map(q => (f({...on[0], [q]: on[0][q] + 1e-4}) - f({...on[0], [q]: on[0][q] - 1e-4})) / 2e-4));
    const left = [];  // what each has beside those before it
    for (const row of slopes) left.push(left.reduce((rest, other) => rest.map((x, k) => x - inner(rest, other) / inner(other, other) * other[k]), row));
    return fair && holds && left.every((row, k) => inner(row, row) > 1e-8 * inner(slopes[k], slopes[k]));
  }
  const inner = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  // With multipliers along the axes of the scene's rows, or of the ground
  function alongEither(key, formulas, named) {
    const told = judgedAs(key, formulas, named), names = Object.keys(QUESTIONS.ground);
    if (told.right || !names.some(name => formulas.some(one => Terms.used(one.of, points[0]).has(name)))) return told;
    const along = names.map(name => [name, Formulas.formula(QUESTIONS.ground[name])]);
    const turned = p => ({...p, ...Object.fromEntries(along.map(([name, of]) => [name, of(p)]))});
    const again = judgedAs(key, formulas.map(({of, ...one}) => ({...one, of: p => of(turned(p))})), named);
    return again.right ? again : told;
  }
  function judgedAs(key, formulas, named) {
    const drawnValues = formulas.map(one => points.map(one.of));
    const lettered = has(QUESTIONS.named, key) && QUESTIONS.seen[key].every(name => formulas.some(one => Terms.used(one.of, points[0]).has(name)));
    const moving = settled(key, formulas, named.some(name => name.startsWith("tau")), lettered);
    const told = drawnValues.every(mine => mine.every(Number.isFinite)) ? compared(key, drawnValues, lettered) : said(false, "answer.undefined");
    if (moving && (moving.row || moving.another)) return forgot([moving.row ? "row" : "other", "", ""]);
    if (moving && !moving.right && !told.right) return foreign(key, formulas, apart(key, formulas, told));
    if (!moving || moving.right === told.right || told.text === words["answer.shifted"]) return foreign(key, formulas, told);
    return moving.right ? said(true, moving.word) : motions.drives.length > 1 ? forgot(["other", "", ""]) : said(false, "answer.wrong");
  }

  // What is right without the terms of parameters that the result does not have
  function foreign(key, formulas, told) {
    if (told.right || told.rule || told.rules || told.whole || has(balances, key)) return told;
    const known = has(QUESTIONS.named, key) ? QUESTIONS.named[key] : [], rest = formulas.map(({of}) => {
      const zero = [...Terms.used(of, points[0])].filter(name => QUESTIONS.parameters.includes(name) && !known.includes(name)).map(name => [name, 0]);
      return zero.length ? points.map(p => of({...p, ...Object.fromEntries(zero)})) : null;
    });
    return rest.every(mine => mine && valued(key, mine).right) ? forgot(["extra", "", ""]) : told;
  }
  // Whether an answer is a constant of letters, of which nothing is known of what its writer forgot
  function settles(formulas) {
    const used = formulas.flatMap(({of}) => [...Terms.used(of, points[0])]);
    return used.length > 0 && used.every(name => QUESTIONS.parameters.includes(name));
  }
  // A wrong answer's words, led by the terms that differ where these can be told apart
  function apart(key, formulas, told) {
    if (QUESTIONS.free.includes(key) && settles(formulas)) return said(false, "answer.wrong");
    if (!has(terms, key)) return told;
    const rule = told.rule === "nothing" ? "" : told.rule;  // it gives way to every reason
    const [first, second] = formulas, {before} = motions.asked[key], front = before ? formula_of(before) : null;
    const whole = p => first.of(p) - (second ? second.of(p) : front ? front(p) : 0), found = Terms.told(key, whole, rule);
    const minus = ({terms = []}) => terms.map(one => p => -one(p)), typed = [...first.of.terms || [first.of], ...minus(second ? second.of : front || {})];
    const {kept, vague} = QUESTIONS.apart, over = kept.includes(told.rule) ? 0 : Terms.surplus(key, whole, typed);
    if (over === 1 && !(found && found.sure && found.rules.some(one => kept.includes(one)))) {
      const both = ["extra", ...(told.rule === "dimension" ? [told.rule] : [])].map(rule => words.mistakes[rule]).join(words.mistakes.and);
      return {...forgot(["extra", "", ""]), text: words["answer.mistake"].replace("{rule}", () => both), changes: [["extra", ""]], kinds: []};
    }
    const reason = found && told.whole === "answer.factor" && found.rules.some(one => !vague.includes(one));
    if ((told.whole && !reason) || QUESTIONS.apart.whole.includes(told.rule)) return found ? {...told, kinds: found.kinds, changes: found.changes} : told;
    if (!found) {
      const changes = told.rule === "nothing" ? [] : Terms.listed(key, whole, typed);
      const reason = told.rule ? "" : over ? "extra" : mixed(key, whole) ? "dimension" : otherLaw(key, whole) ? "law" : "";
      return {...(reason ? forgot([reason, "", ""]) : told), changes, kinds: changes.map(one => one[2]).filter(Boolean)};
    }
    if (QUESTIONS.apart.rates.includes(told.rule) && found.rules.join() === "relative") return {...told, kinds: found.kinds, changes: found.changes};
    if (told.rule === "slope" && found.rules[0] === "velocities") found.rules.unshift("slope");  // the shell says it, too
    const led = found.rules.includes("prescribed"), untold = found.rules.filter(rule => led || rule !== told.other || found.rules[0] !== told.rule);
    const text = untold.map((rule, k) => k || led || rule !== told.rule ? words.mistakes[rule] : told.reason).join(words.mistakes.and);
    return {...told, ...found, text: words["answer.mistake"].replace("{rule}", () => text)};
  }
  // Whether terms of an equation differ in units, see symdyn.teach.student.diagnosis
  function mixed(key, of) {
    if (!QUESTIONS.unit.includes(key) || !has(QUESTIONS.named, key) || !has(motions.asked[key], "equation")) return false;
    const used = Terms.used(of, points[0]), near = [-4, -3, -2, -1, 0, 1, 2, 3, 4];
    const ratio = of(points[scaled]) / of(points[0]), [kg, m, s] = QUESTIONS.scales;
    if (!QUESTIONS.named[key].every(name => used.has(name)) || !Number.isFinite(ratio) || ratio === 0) return false;
    return !near.some(a => near.some(b => near.some(c => Math.abs(kg ** a * m ** b * s ** c / ratio - 1) < 1e-9)));
  }
  // Whether all but friction is right, times any factor that is free of rates
  function otherLaw(key, of) {
    const [names, left] = has(balances, key) ? balances[key].law : [[], []], none = Object.fromEntries(names.map(name => [name, 0]));
    const mine = left.map((_, k) => of({...points[pairs[k]], ...none}));
    return names.length > 0 && [0, 2].every(k => mine[k] * left[k] !== 0 && close(mine[k] * left[k + 1], mine[k + 1] * left[k]));
  }
  function compared(key, formulas, lettered) {
    const told = has(balances, key) ? balanced(key, formulas, lettered) : formulas.map(mine => valued(key, mine, lettered));
    if (!has(balances, key) && motions && has(motions.asked[key] || {}, "equation") && told.some(one => !one.right)) return said(false, "answer.wrong");
    return told.find(one => !one.right) || told.find(one => one.text !== words["answer.right"]) || told[0];
  }

  // Decimals of two digits or more, which a point may name, with half a unit of their last digit
  function decimals(list) {
    return list.flatMap(token => {
      if (token.kind !== "number" || /e/i.test(token.text)) return [];
      const [whole, after = ""] = token.text.replace("{,}", ".").replace(",", ".").split("."), places = after.replace(/0+$/, "").length;
      const unit = 10 ** (places ? -places : /0*$/.exec(whole)[0].length);
      return unit === 1 || token.value < (places ? 10 : 100) * unit * (1 - 1e-12) ? [] : [[token.rounded = `#${token.at}`, token.value, unit / 2]];
    });
  }
  const off = (some, t) => Object.fromEntries(some.map(([name, value, half], j) => [name, value + half * t[j]]));
  const effects = (some, at, start = at({})) => some.map((_, j) => at(off(some, some.map((_, k) => +(k === j)))).map((x, k) => x - start[k]));
  // Whether decimals that are off take away what is left at every point, see symdyn.teach.student.motions
  function explained(some, left, few) {
    const t = some.map(() => 0), slopes = effects(some, left), rows = left({}).map((_, k) => slopes.map(row => row[k]));
    for (let round = 0, before = null; round < 12 && t.join() !== before; round++) {
      const rest = left(off(some, t)), asked = orthonormal(rows.map((row, k) => [...row, inner(row, t) - rest[k]]), few / 10);
      if (rest.every(x => Math.abs(x) <= few)) return true; else before = t.join();
      for (let n = 0; n < 20 * t.length; n++) {
        const j = n % t.length, square = asked.reduce((sum, row) => sum + row[j] ** 2, 0);
        if (square) t[j] = Math.min(1, Math.max(-1, t[j] + asked.reduce((sum, row) => sum + row[j] * (row.at(-1) - inner(t, row)), 0) / square));
      }
    }
    return false;
  }
  // Equations with their right side last, as few that say the same, in orthonormal rows
  function orthonormal(rows, few, kept = []) {
    const sizes = rows.map(row => Math.hypot(...row.slice(0, -1))), size = Math.max(...sizes);
    if (!(size > few) || kept.length === rows[0].length - 1) return kept;
    const unit = rows[sizes.indexOf(size)].map(x => x / size), along = rows.map(row => inner(row.slice(0, -1), unit));
    return orthonormal(rows.map((row, n) => row.map((x, k) => x - along[n] * unit[k])), few, [...kept, unit]);
  }

  // On the motions of the mechanism, see symdyn.teach.student.motions: null where none are drawn, else whether it is right
  function settled(key, formulas, alone, lettered) {
    if (!motions || !has(motions.asked, key)) return null;
    const unset = Object.fromEntries(motions.multipliers.map(name => [name, NaN]));  // they stand in equations alone
    const asked = motions.asked[key], point = row => Object.fromEntries(row.map((x, k) => [motions.names[k], x]));
    let another = false, row = false;
    const right = motions.groups.map((group, g) => {
      if (lettered && group.declared) return false;  // l for l² is not right where l is 1 m
      const on = group.on.map(point), driven = i => p => (motions.drives[i] ? p[motions.drives[i]] : 0), places = group.off[0].length;
      if (!has(asked, "equation")) return formulas.every(one => same(one, on.map(p => ({...p, ...unset})), asked.values[g].on, places, motions.free.some(begin => asked.left.startsWith(begin))));
      const front = asked.front[g];
      const before = (p, k, values) => alone ? driven(asked.equation)(p) : values[k];
      const sides = formulas.length > 1 ? formulas.slice(1).map(one => [formulas[0], one]) : [[null, formulas[0]]];
      const held = (broken, asked = sides) => asked.every(([left, other]) => {
        const whole = (p, k, values) => (left ? left.of(p) : before(p, k, values)) - other.of(p), some = formulas.flatMap(one => one.decimals);
        const at = own => on.map((p, k) => whole({...p, ...own}, k, front.on)), there = broken.map((p, k) => Math.abs(whole(p, k, front.off)));
        const few = effects(some, at).reduce((total, row) => total.map((x, k) => x + Math.abs(row[k])), there.map(() => 0));
        return there.every((x, k) => Number.isFinite(x) && x !== 0 && x >= 10 * few[k]) && explained(some, own => at(own).map((x, k) => x / there[k % places]), 1e-7);
      });
      const ties = ([left, other]) => {
        const value = p => left.of(p) - other.of(p), size = Math.max(...points.slice(0, drawn).map(p => Math.abs(value(p))));
        return [...on, ...group.off.flat().map(point)].every(p => Math.abs(value(p)) <= 1e-7 * size);
      };
      row = row || (motions.multipliers.length && formulas.length > 1 && sides.every(ties));
      another = another || group.off.some((off, i) => i !== asked.equation && [...(formulas.length > 1 ? [sides] : []), [[{of: driven(i)}, formulas.at(-1)]]].some(one => held(off.map(point), one)));
      return held(group.off[asked.equation].map(point));
    });
    const found = right.indexOf(true), word = motions.groups[Math.max(found, 0)].declared ? "answer.numbers" : formulas.some(one => one.decimals.length) ? "answer.digits" : "answer.motions";
    return {right: found >= 0, word, row, another: another && found < 0};
  }
  function same({of, decimals: some}, on, right, places, constant) {
    const mine = on.map(of), size = Math.max(...right.map(Math.abs)) || 1e-12, first = [...Array(places).keys()], off = mine.map((x, k) => x - right[k]);
    if (explained(some, own => on.map((p, k) => (of({...p, ...own}) - right[k]) / size), 1e-8)) return true;
    return constant && first.some(k => Math.abs(right[places + k] - right[k]) > 1e-6 * size)
      && first.every(k => Math.abs(off[places + k] - off[k]) <= 1e-8 * Math.max(size, ...mine.map(Math.abs)));
  }

  // A quantity
  function valued(key, mine, lettered) {
    const agrees = (factor, first, end, tolerance) => {
      const right = values[key].slice(first, end), size = Math.max(...right.map(Math.abs), 1e-4);
      return right.every((x, i) => Math.abs(mine[first + i] - factor * x) <= tolerance * size * Math.max(1, Math.abs(factor)));
    };
    const near = (factor, tolerance = TOLERANCE) => agrees(factor, 0, drawn, tolerance);
    if (near(1)) return said(true, "answer.right");
    if (free.includes(key) && elsewhere(key, mine)) return said(true, "answer.shifted");
    if (!lettered && points.length > bound && agrees(1, bound, points.length, TOLERANCE)) return said(true, "answer.numbers");  // m l for m l² is wrong where l is 1 m
    if (rounded.includes(key) && points.length > bound && agrees(1, bound, points.length, enough)) return said(true, "answer.right");
    const changes = free.includes(key), rule = mistaken(key, (changes ? marks.free : marks.plain).map(k => mine[k]), changes, lettered);
    if (rule || mine.every(x => x === 0)) return rule || forgot(["nothing", "", ""]);
    if (near(1, ROUNDED)) return whole("answer.rounded");
    if (near(-1)) return whole("answer.turned");
    const size = Math.max(...values[key].slice(0, drawn).map(Math.abs));
    if (size <= 1e-12 * Math.max(...mine.slice(0, drawn).map(Math.abs))) return forgot(["extra", "", ""]);  // it is zero
    const k = values[key].findIndex(x => Math.abs(x) > 0.1 * size);
    const factor = rounded.includes(key) ? 0 : mine[k] / values[key][k]; // of a number it would give away the result
    if (Math.abs(factor) > 1e-6 && near(factor)) return whole("answer.factor", String(Number(factor.toPrecision(6))).replace("-", "\u2212").replace(".", words.decimal));
    return united(key, mine) ? said(false, "answer.wrong") : forgot(["dimension", "", ""]);
  }
  const close = (a, b) => Math.abs(a - b) <= 1e-7 * Math.max(Math.abs(a), Math.abs(b), 1e-12);
  function forgot([rule, of, other]) {
    const both = words.mistakes[`${rule}.${other}`], where = of ? words.mistakes.where.replace("{of}", () => of) : "";
    const reason = both ? both + where : words.mistakes[rule] + where + (other ? words.mistakes.or + words.mistakes[other] : "");
    return {right: false, rule, other, reason, text: words["answer.mistake"].replace("{rule}", () => reason)};
  }
  // Which rule a wrong value forgets, by what such a mistake is worth at a few points
  function mistaken(key, at, changes, lettered) {
    const mine = changes ? [at[0] - at[1], at[2] - at[3]] : at;
    const rough = rounded.includes(key) && at.every(x => x === at[0]) ? one => one.length > 6 && [5, 6].every(k => Math.abs(at[0] - one[k]) <= enough * Math.abs(one[k])) : () => false;
    const row = (mistakes[key] || []).find(one => rough(one) || (lettered ? [3] : [3, 5]).some(k => one.length > k + 1 && close(mine[k - 3], one[k]) && close(mine[k - 2], one[k + 1])));
    return row && forgot(row);
  }
  // Whether lengths, masses and times in other units change a value as they change the result, where that can be told
  function united(key, mine) {
    const right = values[key];
    return !QUESTIONS.united.includes(key) || close(mine[scaled] * right[0], mine[0] * right[scaled]);
  }

  // An equation, in any order of terms and times any factor that is free of rates; solved for an acceleration or not
  function balanced(key, formulas, lettered) {
    const {zero, drive, alone, beside} = balances[key];
    const sides = formulas.length > 1 ? formulas.slice(1).map(mine => mine.map((x, i) => formulas[0][i] - x))
      : [formulas[0].map((x, i) => x - (drive ? points[i][drive] : 0))];
    if (formulas.length === 1) {
      const mine = formulas[0], right = values[key];
      const size = Math.max(...right.map(Math.abs), 1e-12);
      if (mine.every((x, i) => Math.abs(x - right[i]) <= TOLERANCE * size)) return [said(true, "answer.right")];
      if (beside) return [equation(key, mine.map((x, i) => x - right[i] + zero[i]), zero, lettered)];  // what stands there, not the drive alone
      if (proportional(mine, zero, 0)) return [said(true, "answer.right")];
      if (alone) sides.push(mine.map((x, i) => points[i][alone] - x));
    }
    return sides.map(mine => equation(key, mine, zero, lettered)).sort((a, b) => formulas.length === 1 ? b.right - a.right || !!b.rule - !!a.rule : 0).slice(0, formulas.length === 1 ? 1 : sides.length);
  }
  const PAIRS = [[0, 0], [1, 1], [2, 2]];
  const proportional = (mine, zero, first) => (first ? [[0, 2], [1, 3]].map(([a, b]) => [first + a, first + b]) : PAIRS.map(([a, b]) => [a, drawn + twins + b]))
    .every(([a, b]) => Math.abs(mine[a] * zero[b] - mine[b] * zero[a]) <= 1e-8 * Math.abs(mine[a] * zero[b]) && mine[a] * zero[b] !== 0);
  function equation(key, mine, zero, lettered) {  // what is wrong in letters is not excused by numbers
    if (mine.every(x => Math.abs(x) <= 1e-12)) return said(false, "answer.always");
    const {drive} = balances[key];
    if (proportional(mine, zero, 0)) return said(true, "answer.right");
    if (!lettered && points.length > bound && proportional(mine, zero, bound)) return said(true, "answer.numbers");
    const held = (one, k) => [k, k + 2].every(j => mine[pairs[j - 3]] * one[j] !== 0 && close(mine[pairs[j - 3]] * one[j + 1], mine[pairs[j - 2]] * one[j]));
    const row = (lettered ? [3] : [3, 7]).map(k => (mistakes[key] || []).find(one => one.length > k + 3 && held(one, k))).find(Boolean);
    const alone = drive && mine.every((x, i) => Math.abs(x) === Math.abs(points[i][drive]));
    return row ? forgot(row) : alone ? forgot(["nothing", "", ""]) : said(false, "answer.wrong");
  }
  return {judge};
})();
