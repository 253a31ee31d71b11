"use strict";
// Typed answers: a small reader of plain text and LaTeX, values in doubles, no evaluation of text as code.
const Answers = (() => {
  const {symbols, dotted, short, quantities, free, points, values, words, spellings, speeds, balances, mistakes, marks, pairs} = QUESTIONS;
  const {drawn, twins, bound} = QUESTIONS;
  const FUNCTIONS = {sin: Math.sin, cos: Math.cos, tan: Math.tan, sqrt: Math.sqrt, exp: Math.exp, log: Math.log, ln: Math.log, tanh: Math.tanh, abs: Math.abs};
  const GREEK = {α: "alpha", β: "beta", γ: "gamma", δ: "delta", ε: "epsilon", ζ: "zeta", η: "eta", θ: "theta", ι: "iota", κ: "kappa", λ: "lambda", μ: "mu", ν: "nu", ξ: "xi", π: "pi", ρ: "rho", σ: "sigma", τ: "tau", υ: "upsilon", φ: "phi", χ: "chi", ψ: "psi", ω: "omega", ϑ: "theta", ϕ: "phi"};
  const SILENT = /^\\(?:left|right|quad|qquad|[Bb]igg?[lr]?|displaystyle|[,;:! ])(?![A-Za-z])/;
  const UPRIGHT = /^\\(?:mathrm|mathit|mathtt|text|operatorname)\{((?:[^{}]|\{[^{}]*\})*)\}/;
  const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹", LOWERED = "₀₁₂₃₄₅₆₇₈₉";
  const CLOSING = {"(": ")", "[": "]", "{": "}"};
  const has = (table, key) => Object.prototype.hasOwnProperty.call(table, key);

  class Fault extends Error {
    constructor(key, text, at) { super(key); this.key = key; this.text = text; this.at = at; }
  }

  // Plain letters: ẍ and q̇₁² become \ddot{x} and \dot{q}_{1}^{2}
  function plain(text) {
    let out = text.normalize("NFD").replace(/\s+/g, " ");
    out = out.replace(/[⁰¹²³⁴⁵⁶⁷⁸⁹]+/g, run => "^{" + [...run].map(c => RAISED.indexOf(c)).join("") + "}");
    out = out.replace(/[₀₁₂₃₄₅₆₇₈₉]+/g, run => "_{" + [...run].map(c => LOWERED.indexOf(c)).join("") + "}");
    out = out.replace(/[·×∙⋅]/g, "*").replace(/[−–]/g, "-").replace(/[½⅓⅔¼¾⅕⅖⅗⅘⅙⅚⅛⅜⅝⅞]/g, c => `(${c.normalize("NFKD").replace("⁄", "/")})`).replace(/[′’]/g, "'").replace(/″/g, "''");
    out = out.replace(/(\p{L})\u0308/gu, "\\ddot{$1}").replace(/(\p{L})\u0307\u0307/gu, "\\ddot{$1}").replace(/(\p{L})\u0307/gu, "\\dot{$1}");
    return out.replace(/[\u0370-\u03ff]/g, c => has(GREEK, c) ? "\\" + GREEK[c] + " " : c);
  }

  // Spellings of other programs and of blackboards, by the table that the shell reads too
  function spelled(text) {
    const by = name => {
      const dots = 2 * name.split("\\ddot").length + name.split("\\dot").length + name.split("'").length - 4;
      return name.replace(/\\d?dot(?![A-Za-z])|[\\{}_' ]/g, "") + "dot".repeat(dots);
    };
    const equated = (_, inside) => {
      let depth = 0;
      const at = [...inside].findIndex(c => { depth += "([{".includes(c) - ")]}".includes(c); return c === "," && depth === 0; });
      return at < 0 ? inside : inside.slice(0, at) + "=" + inside.slice(at + 1);
    };
    const ways = {equation: equated, "": () => "", lower: found => found.toLowerCase(), $1: (_, inner) => inner, slope: (_, inner) => `slope${by(inner)} `, rate: (_, inner) => `rate${inner} `};
    for (const [pattern, means] of spellings) text = text.replace(new RegExp(pattern, "gu"), (found, inner) => ways[means](found, inner));
    return text;
  }
  const WRAPPED = /\$+|\\[[\]()]|\\(?:begin|end)\{[^{}]*\}|\\\\|\\(?:label|tag)\{[^{}]*\}|\\(?:nonumber|notag)/g;

  // The members of a chain of "=" that does not stand in brackets
  function members(source) {
    let text = spelled(plain(source.replace(WRAPPED, " "))).replace(/[\s.;,]+$/, "");
    const parts = [""];
    let depth = 0;
    for (const c of text) {
      depth += "([{".includes(c) - ")]}".includes(c);
      if (depth === 0 && c === "=") parts.push("");
      else if (c !== "&") parts[parts.length - 1] += c;
    }
    return parts;
  }
  // Whether a member is the name of a result and nothing else
  function label(text) {
    const found = /^ *\\?([A-Za-z][A-Za-z0-9]*)((?:_(?:\{[^{}]*\}|[A-Za-z0-9]+))*) *(\^ *(?:2|\{ *2 *\}))? *$/.exec(text);
    if (!found) return "";
    const word = found[1] + bare(found[2]);
    if (has(symbols, word)) return "";
    const name = word + (found[3] ? "squared" : "");
    return has(quantities, name) ? quantities[name] : "";
  }

  const bare = index => index.replace(/\\(?:mathrm|mathit|text)(?![A-Za-z])/g, "").replace(/[\\{}_, ]/g, "");

  function tokens(text) {
    const found = [];
    let at = 0;
    const rest = () => text.slice(at);
    const index = () => {
      const m = /^_(\{(?:[^{}]|\{[^{}]*\})*\}|\\[A-Za-z]+|[A-Za-z0-9]+)/.exec(rest());
      if (!m) throw new Fault("fault.here", "_", at);
      at += m[0].length;
      return bare(m[1]);
    };
    const word = (name, start) => {
      while (text[at] === "_") name += index();
      let dots = 0;
      while (dots < 2 && text[at] === "'") { dots++; at++; }
      found.push({kind: "word", text: name, at: start, dots});
    };
    while (at < text.length) {
      const start = at;
      let m;
      if ((m = /^[ ~&]+/.exec(rest())) || (m = SILENT.exec(rest()))) { at += m[0].length; continue; }
      if ((m = /^(?:\d+(?:(?:\.|\{,\}|,(?=\d))\d+)?(?:[eE][+-]?\d{1,3}(?![A-Za-z0-9_]))?|\.\d+)/.exec(rest()))) {
        at += m[0].length;
        found.push({kind: "number", text: m[0], value: Number(m[0].replace("{,}", ".").replace(",", ".")), at: start});
      } else if ((m = UPRIGHT.exec(rest()))) {
        at += m[0].length;
        word(bare(m[1]), start);
      } else if ((m = /^\\?([A-Za-z][A-Za-z0-9]*)/.exec(rest()))) {
        let name = m[1];
        const command = m[0][0] === "\\";
        if (command) name = /^[A-Za-z]+/.exec(name)[0];
        at += name.length + (command ? 1 : 0);
        name = {tfrac: "frac", dfrac: "frac", varphi: "phi", vartheta: "theta", varepsilon: "epsilon"}[command ? name : ""] || name;
        if (command && (name === "cdot" || name === "times")) found.push({kind: "op", text: "*", at: start});
        else if (has(FUNCTIONS, name) && text[at] !== "_") found.push({kind: "function", text: name, at: start});
        else if (command && ["frac", "dot", "ddot"].includes(name)) found.push({kind: "command", text: name, at: start});
        else if (name === "pi" && !has(symbols, "pi")) found.push({kind: "number", text: "pi", value: Math.PI, at: start});
        else if (command && !Object.values(GREEK).includes(name.toLowerCase())) throw new Fault("fault.character", "\\" + name, start);
        else word(name, start);
      } else if (rest().startsWith("**")) { at += 2; found.push({kind: "op", text: "^", long: true, at: start}); }
      else if ("+-*/^".includes(text[at])) { at++; found.push({kind: "op", text: text[start], at: start}); }
      else if (has(CLOSING, text[at])) { at++; found.push({kind: "open", text: text[start], at: start}); }
      else if (")]}".includes(text[at])) { at++; found.push({kind: "close", text: text[start], at: start}); }
      else if (text[at] === ",") { at++; found.push({kind: "comma", text: ",", at: start}); }
      else if (text[at] === "_") found.push({kind: "sub", text: index(), at: start});
      else throw new Fault("fault.character", [...rest()][0], start);
      if (found.length > 2000) throw new Fault("fault.deep", "", start);
    }
    return found;
  }

  // Functions of time and their derivatives, in primes: q_2(t) is q_2, \frac{d}{dt} q_1 and Derivative(q1(t), t) are q_1'
  const TIMES = ["(t)", "{(t)}", "[t]"].map(text => [...text]);
  const CALLS = [[",t)", 1], [",t,t)", 2], [",(t,2))", 2], [",t,2)", 2]].map(([text, order]) => [[...text], order]);
  function timeless(found) {
    const moves = text => has(symbols, text) && Object.entries(dotted).some(([q, rates]) => [q, ...rates].includes(symbols[text]));
    const fits = (list, at, ...patterns) => (patterns.find(one => one.every((text, i) => list[at + i] && list[at + i].text === text)) || []).length;
    const list = [];
    for (let at = 0; at < found.length;) {
      const tail = list.filter(t => !["sub", "number"].includes(t.kind)).slice(-4).map(t => t.text);
      const before = list.length && (list[list.length - 1].kind === "word" ? moves(list[list.length - 1].text)
        : ["dot", "ddot"].includes(tail[0]) && tail[1] === "{" && tail[3] === "}");
      const size = before ? fits(found, at, ...TIMES) : 0;
      if (size) at += size; else list.push(found[at++]);
    }
    function word(at) {
      const token = list[at];
      if (!token) return null;
      if (token.kind === "open" && token.text !== "[") {
        const inside = word(at + 1);
        return inside && list[inside[1]] && list[inside[1]].kind === "close" ? [inside[0], inside[1] + 1] : null;
      }
      if (token.kind === "command" && token.text.endsWith("dot")) {
        const inside = word(at + 1);
        return inside && [{...inside[0], dots: inside[0].dots + (token.text === "dot" ? 1 : 2)}, inside[1]];
      }
      return token.kind === "word" && moves(token.text) ? [token, at + 1] : null;
    }
    const derived = (token, inner, order, end) => {
      if (!inner) throw new Fault("fault.time", "", token.at);
      return [{...inner[0], dots: inner[0].dots + order}, Math.max(end, inner[1])];
    };
    function order(at, ...heads) {
      const size = fits(list, at, ...heads);
      if (!size) return [0, at];
      const squared = fits(list, at + size, ["^", "{", "2", "}"], ["^", "2"]);
      return [squared ? 2 : 1, at + size + squared];
    }
    const differential = token => token && token.kind === "word" && token.text[0] === "d" && moves(token.text.slice(1)) ? {...token, text: token.text.slice(1)} : null;
    function fraction(at) {
      if (list[at].kind !== "command" || !fits(list, at, ["frac", "{"])) return null;
      let [above, end] = order(at + 2, ["d"]), inner = above ? word(end) : null;
      const whole = above ? null : differential(list[at + 2]);
      if (whole) { above = 1; inner = [whole, at + 3]; }
      if (inner) end = inner[1];
      if (!above || !fits(list, end, ["}", "{"])) return null;
      const [below, last] = order(end + 2, ["d", "t"], ["dt"]);
      return below === above && fits(list, last, ["}"]) ? derived(list[at], inner || word(last + 1), above, last + 1) : null;
    }
    function slash(at) {
      if (list[at].kind !== "word" || has(symbols, "dt") || !fits(list, at + 1, ["/", "dt"])) return null;
      if (list[at].text === "d") return derived(list[at], word(at + 3), 1, at + 3);
      const whole = differential(list[at]);
      return whole ? derived(list[at], [whole, at + 3], 1, at + 3) : null;
    }
    function call(at) {
      if (!["Derivative", "diff", "Diff", "D"].includes(list[at].text) || has(symbols, list[at].text) || !fits(list, at + 1, ["("])) return null;
      const inner = word(at + 2);
      const pattern = inner && CALLS.find(([one]) => fits(list, inner[1], one));
      return derived(list[at], pattern ? inner : null, pattern ? pattern[1] : 1, pattern ? inner[1] + pattern[0].length : at);
    }
    const kept = [];
    for (let at = 0; at < list.length;) {
      const taken = fraction(at) || slash(at) || call(at);
      if (taken) { kept.push(taken[0]); at = taken[1]; } else kept.push(list[at++]);
    }
    if (kept.some(t => t.kind === "comma")) throw new Fault("fault.character", ",", kept.find(t => t.kind === "comma").at);
    return kept;
  }

  // Names: a whole word, or the one way to cut it into known pieces
  function piece(word) {
    if (has(symbols, word)) return {name: symbols[word]};
    if (has(short, word)) return {short: short[word]};
    return null;
  }
  function read(word, at) {
    const whole = piece(word);
    if (whole) return [whole];
    if (has(quantities, word)) throw new Fault("fault.quantity", quantities[word], at);
    const ends = {s: "sin", c: "cos", sin: "sin", cos: "cos"};
    if (has(ends, word)) return [{function: ends[word]}];
    const ways = [[[]]];
    for (let end = 1; end <= Math.min(word.length, 80); end++) {
      const here = [];
      for (let start = 0; start < end; start++) {
        let part = piece(word.slice(start, end));
        if (!part && end === word.length && start && has(ends, word.slice(start))) part = {function: ends[word.slice(start)]};
        if (part) for (const way of ways[start]) here.push([...way, part]);
      }
      ways.push(here.sort((a, b) => a.length - b.length).slice(0, 8));
    }
    const found = (ways[word.length] || []).filter((way, _, all) => way.length === all[0].length);
    if (!found.length) throw new Fault("fault.name", word, at);
    if (found.length > 1) throw new Fault("fault.ambiguous", word, at);
    return found[0];
  }

  // A formula becomes a function of a point
  function formula(text) {
    let list = tokens(text);
    list = list.filter((t, i) => !(t.text === "{" && list[i + 1] && list[i + 1].text === "}") && !(t.text === "}" && i && list[i - 1].text === "{"));
    list = timeless(list);
    if (!list.length) throw new Fault("fault.empty", "", 0);
    let next = 0, depth = 0;
    const peek = () => list[next];
    const sees = (kind, ...texts) => peek() && peek().kind === kind && (!texts.length || texts.includes(peek().text));
    const take = () => { if (!peek()) throw new Fault("fault.end", "", text.length); return list[next++]; };

    function sum() {
      if (++depth > 60) throw new Fault("fault.deep", "", peek() ? peek().at : text.length);
      let negative = sees("op", "+", "-") && take().text === "-";
      const terms = [];
      for (;;) {
        terms.push([negative ? -1 : 1, term()]);
        if (!sees("op", "+", "-")) break;
        negative = take().text === "-";
      }
      depth--;
      return terms.length === 1 && terms[0][0] === 1 ? terms[0][1] : p => terms.reduce((total, [s, f]) => total + s * f(p), 0);
    }
    function term() {
      let value = factor(), divided = null;
      for (;;) {
        if (sees("op", "*")) { take(); value = times(value, signed()); divided = null; }
        else if (sees("op", "/")) {
          const slash = take(), number = sees("number"), above = value, below = signed();
          value = p => above(p) / below(p);
          divided = number ? null : slash;
        } else if (peek() && ["number", "word", "open", "command", "function"].includes(peek().kind)) {
          if (divided && peek().kind !== "function") throw new Fault("fault.division", "", divided.at);
          value = times(value, factor());
        } else return value;
      }
    }
    const times = (f, g) => p => f(p) * g(p);
    function signed() {
      if (!sees("op", "+", "-")) return factor();
      const negative = take().text === "-", value = factor();
      return negative ? p => -value(p) : value;
    }
    function factor() {
      const token = take();
      if (token.kind === "number") return raised(() => token.value);
      if (token.kind === "word") return word(token, token.dots);
      if (token.kind === "open") return raised(bracket(token));
      if (token.kind === "function") return call(token, FUNCTIONS[token.text]);
      if (token.kind === "command" && token.text === "frac") {
        const above = group(), below = group();
        return raised(p => above(p) / below(p));
      }
      if (token.kind === "command") return word(...accented(token));
      throw new Fault("fault.here", token.text, token.at);
    }
    function bracket(open) {
      const inner = sum();
      if (!sees("close", CLOSING[open.text])) throw new Fault("fault.bracket", "", open.at);
      take();
      return inner;
    }
    function group() {
      const token = take();
      if (token.kind === "open" && token.text === "{") return bracket(token);
      if (token.kind === "number" && /^\d+$/.test(token.text)) {
        if (token.text.length > 1) {
          const left = token.text.slice(1);
          list.splice(--next, 1, {kind: "number", text: left, value: Number(left), at: token.at + 1});
        }
        const digit = Number(token.text[0]);
        return () => digit;
      }
      throw new Fault("fault.here", token.text, token.at);
    }
    function accented(token) {
      const braced = sees("open", "{");
      if (braced) take();
      let name = take();
      if (name.kind !== "word") throw new Fault("fault.here", name.text, name.at);
      if (braced) {
        if (!sees("close", "}")) throw new Fault("fault.bracket", "", token.at);
        const closed = take();
        const digit = sees("number") && peek().at === closed.at + 1 && !has(symbols, name.text) && has(symbols, name.text + peek().text);
        if (sees("sub") || digit) name = {...name, text: name.text + take().text};
      }
      return [name, token.text === "dot" ? 1 : 2];
    }
    function call(token, apply) {
      let power = 1;
      if (sees("op", "^")) {
        power = exponent(take());
        if (power < 1) throw new Fault("fault.power", "", token.at);
      }
      if (!peek()) throw new Fault("fault.argument", "", token.at);
      let inner, closed = false;
      if (peek().kind === "open") { inner = bracket(take()); closed = true; }
      else {
        const factors = [];
        while (sees("number") || sees("command", "frac")) factors.push(sees("number") ? (n => () => n)(take().value) : factor());
        if (sees("word") || sees("command", "dot", "ddot")) {
          const [name, dots] = sees("word") ? [peek(), take().dots] : accented(take());
          factors.push(product(name, read(name.text, name.at), dots));
        }
        if (!factors.length) throw new Fault("fault.argument", "", token.at);
        inner = factors.reduce(times);
        if (sees("op", "^")) throw new Fault("fault.argument", "", peek().at);
      }
      const value = p => apply(inner(p)) ** power;
      return closed ? raised(value) : value;
    }
    function word(token, dots) {
      const pieces = read(token.text, token.at), last = pieces[pieces.length - 1];
      if (last.function) {
        const value = call(token, FUNCTIONS[last.function]);
        return pieces.length > 1 ? times(product(token, pieces.slice(0, -1), dots), value) : value;
      }
      const end = raised(product(token, [last], pieces.length === 1 ? dots : 0));
      return pieces.length > 1 ? times(product(token, pieces.slice(0, -1), dots), end) : end;
    }
    function product(token, pieces, dots) {
      return pieces.map((part, i) => {
        if (part.function) throw new Fault("fault.argument", "", token.at);
        if (part.short) {
          if (dots && !i) throw new Fault("fault.dots", token.text, token.at);
          const [name, angles] = part.short;
          return p => FUNCTIONS[name](angles.reduce((total, q) => total + p[q], 0));
        }
        let name = part.name;
        if (dots && !i) {
          if (!has(dotted, name)) throw new Fault("fault.dots", token.text, token.at);
          name = dotted[name][dots - 1];
        }
        return p => p[name];
      }).reduce(times);
    }
    function raised(base) {
      if (!sees("op", "^")) return base;
      const power = exponent(take());
      return p => base(p) ** power;
    }
    function exponent(caret) {
      const sign = sees("op", "-") ? -1 : 1;
      if (sees("op", "+", "-")) take();
      const token = take();
      let value = token.value;
      if (token.kind === "open") {
        const begin = next, inner = bracket(token);
        if (list.slice(begin, next).some(t => t.kind === "word")) throw new Fault("fault.power", "", token.at);
        value = inner({});
      } else if (token.kind !== "number" || (token.text.length > 1 && !caret.long)) throw new Fault("fault.power", "", token.at);
      if (!(Number.isInteger(value) && Math.abs(value) <= 32) && value !== 0.5) throw new Fault("fault.power", "", token.at);
      return sign * value;
    }

    const value = sum();
    if (peek()) throw new Fault("fault.here", peek().text, peek().at);
    return value;
  }

  const TOLERANCE = 1e-9, ROUNDED = 1e-4;  // of the largest value: doubles lose some digits, wrong answers all of them
  // Whether a potential energy that changes with position differs from the answer by what does not
  function elsewhere(key, mine) {
    const right = values[key], size = Math.max(...right.slice(0, drawn).map(Math.abs), ...mine.slice(0, drawn).map(Math.abs), 1e-12);
    const changes = list => [...Array(twins).keys()].map(k => list[drawn + k] - list[k]);
    const moved = changes(right), yours = changes(mine);
    return moved.some(x => Math.abs(x) > 1e-6 * size) && moved.every((x, k) => Math.abs(x - yours[k]) <= TOLERANCE * size);
  }

  const said = (right, word, place = "") => ({right, text: words[word].replace("{text}", place).replace("{factor}", place)});
  function judge(key, source) {
    try {
      if (source.length > 5000) throw new Fault("fault.deep", "", 0);
      const parts = members(source), named = parts.map(label);
      const last = parts.length - 1, formulas = [];
      parts.forEach((part, k) => {
        if (named[k] && parts.length > 1) return;
        if (named[k]) throw new Fault("fault.quantity", named[k], 0);
        try {
          formulas.push(points.map(formula(part)));
        } catch (fault) {
          const onTheWay = fault instanceof Fault && fault.key === "fault.name" && k < last && (k === 0 || new RegExp(`^(?:${speeds})$`).test(fault.text));
          if (!onTheWay) throw fault;
        }
      });
      if (!formulas.length) throw new Fault("fault.quantity", named.find(Boolean) || parts[0].trim(), 0);
      if (!formulas.every(mine => mine.every(Number.isFinite))) return said(false, "answer.undefined");
      const told = has(balances, key) ? balanced(key, formulas) : formulas.map(mine => valued(key, mine));
      return told.find(one => !one.right) || told.find(one => one.text !== words["answer.right"]) || told[0];
    } catch (fault) {
      if (!(fault instanceof Fault)) throw fault;
      return said(false, fault.key, fault.text);
    }
  }

  // A quantity
  function valued(key, mine) {
    const agrees = (factor, first, end, tolerance) => {
      const right = values[key].slice(first, end), size = Math.max(...right.map(Math.abs), 1e-4);
      return right.every((x, i) => Math.abs(mine[first + i] - factor * x) <= tolerance * size * Math.max(1, Math.abs(factor)));
    };
    const near = (factor, tolerance = TOLERANCE) => agrees(factor, 0, drawn, tolerance);
    if (near(1)) return said(true, "answer.right");
    if (free.includes(key) && elsewhere(key, mine)) return said(true, "answer.shifted");
    if (points.length > bound && agrees(1, bound, points.length, TOLERANCE)) return said(true, "answer.numbers");
    if (near(1, ROUNDED)) return said(false, "answer.rounded");
    const changes = free.includes(key), rule = mistaken(key, (changes ? marks.free : marks.plain).map(k => mine[k]), changes);
    if (mine.every(x => x === 0) && !(rule && ["product", "slope"].includes(rule.rule))) return forgot(["nothing", "", ""]);
    if (rule) return rule;
    if (near(-1)) return said(false, "answer.turned");
    const size = Math.max(...values[key].slice(0, drawn).map(Math.abs)), k = values[key].findIndex(x => Math.abs(x) > 0.1 * size);
    const factor = mine[k] / values[key][k];
    if (Math.abs(factor) > 1e-6 && near(factor)) return said(false, "answer.factor", String(Number(factor.toPrecision(6))).replace("-", "\u2212").replace(".", words.decimal));
    return united(key, mine) ? said(false, "answer.wrong") : forgot(["dimension", "", ""]);
  }
  const close = (a, b) => Math.abs(a - b) <= 1e-7 * Math.max(Math.abs(a), Math.abs(b), 1e-12);
  const forgot = row => ({right: false, rule: row[0], text: words["answer.mistake"].replace("{rule}", () => words.mistakes[row[0]] + (row[1] ? words.mistakes.where.replace("{of}", () => row[1]) : "") + (row[2] ? words.mistakes.or + words.mistakes[row[2]] : ""))});
  // Which rule a wrong value forgets, by what such a mistake is worth at a few points
  function mistaken(key, at, changes) {
    const mine = changes ? [at[0] - at[1], at[2] - at[3]] : at;
    const row = (mistakes[key] || []).find(one => [3, 5].some(k => one.length > k + 1 && close(mine[k - 3], one[k]) && close(mine[k - 2], one[k + 1])));
    return row && forgot(row);
  }
  // Whether lengths, masses and times in other units change a value as they change the result, where that can be told
  function united(key, mine) {
    const right = values[key], k = QUESTIONS.scaled;
    return !QUESTIONS.united.includes(key) || close(mine[k] * right[0], mine[0] * right[k]);
  }

  // An equation, in any order of terms and times any factor that is free of rates; solved for an acceleration or not
  function balanced(key, formulas) {
    const {zero, drive, alone, beside} = balances[key];
    const sides = formulas.length > 1 ? formulas.slice(1).map(mine => mine.map((x, i) => formulas[0][i] - x))
      : [formulas[0].map((x, i) => x - (drive ? points[i][drive] : 0))];
    if (formulas.length === 1) {
      const mine = formulas[0], right = values[key];
      const size = Math.max(...right.map(Math.abs), 1e-12);
      if (mine.every((x, i) => Math.abs(x - right[i]) <= TOLERANCE * size)) return [said(true, "answer.right")];
      if (beside) return [equation(key, mine.map((x, i) => x - right[i] + zero[i]), zero)];  // what stands there, not the drive alone
      if (proportional(mine, zero, 0)) return [said(true, "answer.right")];
      if (alone) sides.push(mine.map((x, i) => points[i][alone] - x));
    }
    return sides.map(mine => equation(key, mine, zero)).sort((a, b) => formulas.length === 1 ? b.right - a.right || !!b.rule - !!a.rule : 0).slice(0, formulas.length === 1 ? 1 : sides.length);
  }
  const PAIRS = [[0, 0], [1, 1], [2, 2]];
  const proportional = (mine, zero, first) => (first ? [[0, 2], [1, 3]].map(([a, b]) => [first + a, first + b]) : PAIRS.map(([a, b]) => [a, drawn + twins + b]))
    .every(([a, b]) => Math.abs(mine[a] * zero[b] - mine[b] * zero[a]) <= 1e-8 * Math.abs(mine[a] * zero[b]) && mine[a] * zero[b] !== 0);
  function equation(key, mine, zero) {
    if (mine.every(x => Math.abs(x) <= 1e-12)) return said(false, "answer.always");
    const {drive} = balances[key];
    if (drive && mine.every((x, i) => Math.abs(x) === Math.abs(points[i][drive]))) return forgot(["nothing", "", ""]);
    if (proportional(mine, zero, 0)) return said(true, "answer.right");
    if (points.length > bound && proportional(mine, zero, bound)) return said(true, "answer.numbers");
    const held = (one, k) => [k, k + 2].every(j => mine[pairs[j - 3]] * one[j] !== 0 && close(mine[pairs[j - 3]] * one[j + 1], mine[pairs[j - 2]] * one[j]));
    const row = (mistakes[key] || []).find(one => [3, 7].some(k => one.length > k + 3 && held(one, k)));
    return row ? forgot(row) : said(false, "answer.wrong");
  }
  return {formula: text => formula(spelled(plain(text))), judge};
})();
