"use strict";
// Typed formulas: read by the tables that the shell reads too, values in doubles, no evaluation of text as code.
const Formulas = (() => {
  const {symbols, dotted, formulas, short, quantities, grammar} = QUESTIONS;
  const {letters, functions, commands, timeLetters, operators, closing, begins} = grammar;
  const has = (table, key) => Object.prototype.hasOwnProperty.call(table, key);
  const sticks = (pattern, text, at) => { pattern.lastIndex = at; return pattern.exec(text); };
  const compiled = (table, flags) => table.map(([pattern, ...rest]) => [new RegExp(pattern, flags), ...rest]);
  const SPELLINGS = compiled(grammar.spellings, "gu"), TOKENS = compiled(grammar.tokens, "uy"), TIMES = compiled(grammar.times, "duy");
  const GROUP = new RegExp(grammar.group, "uy"), INDEX = new RegExp(grammar.index, "uy"), BARE = new RegExp(grammar.bare, "gu"), OF_TIME = new RegExp(grammar.ofTime, "u");
  const [SUM, PRODUCT, POWER] = ["+", "*", "^"].map(sign => operators[sign]);

  class Fault extends Error {
    constructor(key, text = "") { super(key); this.key = key; this.text = text; }
  }

  // Letters and spellings of others, in the one way that is parsed
  function plain(text) {
    const by = name => {
      const dots = 2 * name.split("\\ddot").length + name.split("\\dot").length + name.split("'").length - 4;
      return name.replace(/\\d?dot(?![A-Za-z])|[\\{}_' ]/g, "") + "dot".repeat(dots);
    };
    const equated = inside => {
      let depth = 0;
      const at = [...inside].findIndex(c => { depth += "([{".includes(c) - ")]}".includes(c); return c === "," && depth === 0; });
      return at < 0 ? inside : inside.slice(0, at) + "=" + inside.slice(at + 1);
    };
    const decomposed = letter => /^.[\u0307\u0308]*$/u.test(letter.normalize("NFD")) ? letter.normalize("NFD") : letter;
    const ways = {
      lower: found => found.toLowerCase(), letter: found => `\\${letters[found]} `, decomposed,
      slope: (_, inner) => `slope${by(inner)} `, rate: (_, inner) => `rate${inner} `, equation: (_, inner) => equated(inner),
    };
    const filled = means => (found, inner) => means.replace("$1", () => inner).replace("$k", () => found.normalize("NFKD"));
    for (const [pattern, means] of SPELLINGS) text = text.replace(pattern, has(ways, means) ? ways[means] : filled(means));
    return text;
  }

  function tokens(source) {
    const text = plain(source.replace(/\n/g, " ")), list = [];
    let at = 0;
    function index(optional) {
      const found = sticks(INDEX, text, at);
      if (!found[1] && !optional) throw new Fault("fault.here", "_");
      at += found[0].length;
      return found[1].replace(BARE, "");
    }
    function word(name) {
      if (name.length > grammar.mostLetters) throw new Fault("fault.deep");
      if (has(functions, name) && text[at] !== "_") return {kind: "function", text: functions[name]};
      while (text[at] === "_") {
        while (text[at + 1] === "_") at++;
        name += "_" + index(name.length > 1);
      }
      let dots = 0;
      while (dots < 2 && text[at] === "'") { dots++; at++; }
      const plain = name.replaceAll("_", "");
      return {kind: plain === "pi" && !dots ? "constant" : "word", text: plain, spelled: name, dots};
    }
    function upright(command) {
      const group = sticks(GROUP, text, at);
      if (!group) throw new Fault("fault.character", command);
      at += group[0].length;
      return word(group[0].split("_").map(part => part.replace(BARE, "")).join("_"));
    }
    while (at < text.length) {
      const start = at;
      let found = null, kind = TOKENS.find(([pattern]) => (found = sticks(pattern, text, at)))[1], name = found = found[0];
      at += found.length;
      if (kind === "command") [kind, name] = has(commands, found.slice(1)) ? commands[found.slice(1)] : ["unknown", found];
      if (kind === "unknown" || kind === "step") throw new Fault("fault.character", found);
      if (!kind || kind === "row" || (kind === "stop" && !/[,.:;]/.test(found))) continue;
      const last = list[list.length - 1];
      let token = {kind, text: name};
      if (kind === "word") token = word(name);
      else if (kind === "upright") token = upright(found);
      else if (kind === "number") token.value = Number(found.replace("{,}", ".").replace(",", "."));
      else if (kind === "sub") { at = start; token.text = index(false); }
      else if (found === "**") token = {kind, text: "^", long: true};
      if (kind === "close" && name === "}" && last && last.kind === "open" && last.text === "{") list.pop();
      else list.push({...token, at: start});
      if (list.length > 2000) throw new Fault("fault.deep");
    }
    return timeless(list);
  }

  // Functions of time and their derivatives, in primes
  const moving = new Set(Object.entries(dotted).flatMap(([name, rates]) => [name, ...rates]));
  const moves = word => has(symbols, word) && moving.has(symbols[word]);
  function letter({kind, text}) {
    const known = key => has(timeLetters, key) ? timeLetters[key] : "w";
    if (kind === "sub" || (kind === "number" && text !== "2")) return "_";
    if (kind !== "word") return known(kind === "command" ? "\\" + text : text);
    const without = text[0] === "d" && moves(text.slice(1));
    if (moves(text) || without) return text === "d" ? "e" : !moves(text) ? "E" : without ? "D" : "q";
    if (has(symbols, text) && text !== "d" && text !== "t") return text === "dt" ? "S" : "n";
    return known(text);
  }
  const greek = new Set(Object.values(letters));
  function timeless(given) {
    const list = [];
    for (const token of given) {
      const first = list[list.length - 1], text = first && token.kind === "word" && greek.has(first.text) && !has(symbols, first.text) && !first.dots && first.text + token.text;
      if (text && has(symbols, text)) list.splice(-1, 1, {...token, text, spelled: first.spelled + token.spelled, at: first.at});  // Δx
      else list.push(token);
    }
    let row = list.map(letter).join(""), found;
    while ((found = OF_TIME.exec(row))) {
      const [begin, end] = [found.index + found[1].length, found.index + found[0].length];
      list.splice(begin, end - begin);
      row = row.slice(0, begin) + row.slice(end);
    }
    const kept = [];
    for (let at = 0; at < list.length;) {
      const rule = TIMES.find(([pattern]) => (found = sticks(pattern, row, at)));
      if (!rule) { kept.push(list[at++]); continue; }
      const after = list[at + found[0].length];
      if (found[1] === undefined && rule[1] === 1 && after && after.kind === "open" && row[at] !== "C") {
        kept.push({...list[at], kind: "command", text: "rate", dots: 0});  // of a bracket
        at += found[0].length;
        continue;
      }
      if (found[1] === undefined) throw new Fault("fault.time");
      const token = list[found.indices[1][0] + found[1].search(/[qeDE]/)], dots = [...found[1]].reduce((n, c) => n + (c === ".") + 2 * (c === ":"), rule[1]);
      kept.push({...token, text: token.text.slice(rule[2]), spelled: token.spelled.slice(rule[2]), dots: token.dots + dots});
      at += found[0].length;
    }
    return kept;
  }

  // The members of a chain of "=" that does not stand in brackets
  function members(source) {
    const list = tokens(source), parts = [[]];
    let depth = 0;
    while (list.length && list[list.length - 1].kind === "stop") list.pop();
    for (const token of list) {
      depth += (token.kind === "open") - (token.kind === "close");
      if (depth === 0 && token.text === "=") parts.push([]); else parts[parts.length - 1].push(token);
    }
    return parts;
  }
  // Whether a member is the name of a result and nothing else
  function label([word, ...rest]) {
    const power = rest.map(token => token.text).join("");
    if (!word || word.kind !== "word" || word.dots || has(symbols, word.text) || !["", "^2", "^{2}"].includes(power)) return "";
    const name = word.text + (power && "squared");
    return has(quantities, name) ? quantities[name] : "";
  }

  // Names: a whole word, or the one way to cut it into known pieces, nowhere where an underscore stands
  const longest = Math.max(...[symbols, short, grammar.short].flatMap(Object.keys).map(word => word.length));
  function piece(word) {
    if (has(symbols, word)) return {name: symbols[word]};
    return has(short, word) ? {short: short[word]} : null;
  }
  function read(spelled) {
    const parts = spelled.split("_"), word = parts.join(""), joined = new Set(parts.map((_, k) => parts.slice(0, k + 1).join("").length));
    const whole = piece(word);
    if (whole) return [whole];
    if (has(quantities, word)) throw new Fault("fault.quantity", quantities[word]);
    if (has(grammar.short, word)) return [{function: grammar.short[word]}];
    const ways = [[[]]];
    for (let end = 1; end <= word.length; end++) {
      const here = [];
      for (let start = Math.max(0, end - longest); start < end; start++) {
        if (joined.has(start)) continue;
        const cut = word.slice(start, end), ends = end === word.length && start && has(grammar.short, cut);
        const part = (word.slice(start, end + 1) !== "tg" && piece(cut)) || (ends ? {function: grammar.short[cut]} : null);
        if (part) here.push(...ways[start].slice(0, 8).map(way => [...way, part]));
      }
      ways.push(here.sort((a, b) => a.length - b.length).slice(0, 8));
    }
    const found = ways[word.length].filter((way, _, all) => way.length === all[0].length);
    if (found.length !== 1) throw new Fault(found.length ? "fault.ambiguous" : "fault.name", spelled);
    return found[0];
  }

  // Runs of names among tokens with the stars that are read into them: m*g*l for mgl
  function starred(list) {
    const shown = part => part.name || (part.function && `${part.function}(...)`) || `${part.short[0]}(${part.short[1].join(" + ")})`;
    return list.filter(token => token.kind === "word").flatMap(token => {
      try {
        const pieces = read(token.spelled);
        return pieces.length > 1 ? [pieces.map(shown).join("*")] : [];
      } catch {
        return [];
      }
    });
  }

  const FUNCTIONS = {...Object.fromEntries(Object.getOwnPropertyNames(Math).map(name => [name, Math[name]])), cot: x => 1 / Math.tan(x), sec: x => 1 / Math.cos(x)};
  // Parts of a formula are numbers, or functions of a point
  const at = (part, point) => typeof part === "number" ? part : part(point);
  const lift = (apply, ...parts) => parts.every(part => typeof part === "number") ? apply(...parts) : p => apply(...parts.map(part => at(part, p)));
  const MOST = 60, terms = part => part.terms || [part];  // of what is multiplied out
  const spread = (value, list) => typeof value === "number" || list.length < 2 || list.length > MOST ? value : Object.assign(value, {terms: list});
  const product = parts => lift((...all) => all.reduce((a, b) => a * b), ...parts);
  const times = parts => {
    const count = parts.reduce((n, part) => n * terms(part).length, 1);
    const ways = count > 1 && count <= MOST ? parts.reduce((list, part) => list.flatMap(way => terms(part).map(one => [...way, one])), [[]]) : [];
    return spread(product(parts), ways.map(product));
  };
  const plus = parts => {
    if (parts.length === 1) return parts[0];
    const total = p => parts.reduce((sum, part) => sum + at(part, p), 0);
    return spread(Object.assign(total, {number: parts.every(part => typeof part === "number") ? total({}) : undefined}), parts.flatMap(terms));
  };
  const inverse = part => lift(x => 1 / x, part), minus = part => spread(lift(x => -x, part), terms(part).map(one => lift(x => -x, one)));

  const known = {}, worth = name => has(formulas, name) ? known[name] ||= formula(tokens(formulas[name])) : p => p[name];
  // The derivative with respect to time, by differences of fourth order along the motion
  function rate(of) {
    const STEP = 1e-3, chains = Object.entries(dotted);
    const unset = Object.fromEntries(chains.flatMap(([, [, a]]) => a ? [[a, NaN]] : []));  // what accelerations become is not known
    const later = (p, h) => ({...p, t: p.t + h, ...Object.fromEntries(chains.map(([name, [u, a]]) => [name, p[name] + h * worth(u)(p) + (a ? h * h / 2 * p[a] : 0)])), ...unset});
    return p => [-2, -1, 1, 2].reduce((sum, n) => sum + [0, 8, -1][Math.abs(n)] * Math.sign(n) * at(of, later(p, n * STEP)), 0) / (12 * STEP);
  }

  function formula(given) {
    const list = [...given];
    if (!list.length) throw new Fault("fault.empty");
    const stop = list.find(token => token.kind === "stop" || token.text === "=");
    if (stop) throw new Fault("fault.character", stop.text);
    let next = 0, depth = 0;
    const peek = () => list[next];
    const sees = (kind, ...texts) => peek() && peek().kind === kind && (!texts.length || texts.includes(peek().text));
    function take() {
      if (!peek()) throw new Fault("fault.end");
      return list[next++];
    }

    function sum() {
      if (++depth > grammar.deepest) throw new Fault("fault.deep");
      const value = joined(SUM);
      depth--;
      return value;
    }
    // What operators of a binding power join; what binds closer is a part of it
    function joined(power) {
      if (power === POWER) return factor();
      const parts = [power === SUM ? signed(PRODUCT) : joined(POWER)];
      for (let sign; operators[sign = operator()] === power;) {
        if (sign) take();
        const part = sign && power === PRODUCT ? signed(POWER) : joined(power + 1);
        parts.push(sign === "/" ? inverse(part) : sign === "-" ? minus(part) : part);
      }
      return power === SUM ? plus(parts) : times(parts);
    }
    const operator = () => peek() && (begins.includes(peek().kind) ? "" : peek().kind === "op" ? peek().text : null);
    function signed(power) {
      const negative = sees("op", "+", "-") && take().text === "-", value = joined(power);
      return negative ? minus(value) : value;
    }
    const number = ({rounded, value}) => rounded ? p => has(p, rounded) ? p[rounded] : value : value;
    function factor() {
      const token = take();
      if (token.kind === "number") return raised(number(token));
      if (token.kind === "constant") return raised(has(symbols, "pi") ? p => p[symbols.pi] : () => Math.PI);
      if (token.text === "e" && !has(symbols, "e") && sees("op", "^")) return take() && lift(Math.exp, sees("open") ? bracket(take()) : argument());
      if (token.kind === "word") return word(token, token.dots);
      if (token.kind === "open") return raised(bracket(token));
      if (token.kind === "function") return call(token.text);
      if (token.kind === "command") return command(token);
      throw new Fault("fault.here", token.text);
    }
    function bracket(open) {
      const inner = sum();
      if (!sees("close", closing[open.text])) throw new Fault("fault.bracket");
      take();
      return open.text === "\\lvert" ? lift(Math.abs, inner) : inner;
    }
    // What stands in braces after a command; \frac12 takes single digits
    function group() {
      const token = take();
      if (token.kind === "open" && token.text === "{") return bracket(token);
      if (token.kind !== "number" || !/^\d+$/.test(token.text)) throw new Fault("fault.here", token.text);
      const left = token.text.slice(1);
      if (left) list.splice(--next, 1, {...token, text: left, value: Number(left), at: token.at + 1});
      return Number(token.text[0]);
    }
    function command(token) {
      if (token.text === "frac") {
        const above = group();
        return raised(times([above, inverse(group())]));
      }
      if (token.text === "rate") return raised(rate(bracket(take())));
      if (token.text.endsWith("dot")) return word(...accented(token));
      const inner = group();
      if ((sees("sub") || sees("op", "^")) && take().kind === "op") group();
      return inner;
    }
    function accented(token) {
      const braced = sees("open", "{");
      if (braced) take();
      let name = take();
      if (name.kind !== "word") throw new Fault("fault.here", name.text);
      if (braced) {
        if (!sees("close", "}")) throw new Fault("fault.bracket");
        take();
        if (sees("sub")) name = {...name, spelled: `${name.spelled}_${peek().text}`, text: name.text + take().text};
      }
      return [name, token.text === "dot" ? 1 : 2];
    }
    function call(name) {
      const power = sees("op", "^") ? exponent(take()) : 1;
      if (power < 1) throw new Fault("fault.power");
      const closed = sees("open"), inner = closed ? bracket(take()) : argument();
      if (!closed && sees("op", "^")) throw new Fault("fault.argument");
      const value = p => FUNCTIONS[name](at(inner, p)) ** power;
      return closed ? raised(value) : value;
    }
    function argument() {
      const factors = [];
      while (sees("number") || sees("constant") || sees("command", "frac")) factors.push(sees("number") ? number(take()) : factor());
      if (sees("word") || sees("command", "dot", "ddot")) {
        const [name, dots] = sees("word") ? [peek(), take().dots] : accented(take());
        factors.push(named(name, read(name.spelled), dots));
      }
      while (factors.length && sees("word", "t")) factors.push(named(peek(), read(peek().spelled), take().dots));  // sin Ω t
      if (!factors.length) throw new Fault("fault.argument");
      return times(factors);
    }
    function word(token, dots) {
      const pieces = read(token.spelled), last = pieces.pop();
      const before = pieces.length ? [named(token, pieces, token.dots && !last.function ? 0 : dots)] : [];
      const behind = token.dots || !pieces.length;  // m_1r' has its prime at the end, an accent stands on the first
      return times([...before, last.function ? call(last.function) : raised(named(token, [last], behind ? dots : 0))]);
    }
    function named(token, pieces, dots) {
      const carrier = token.dots ? pieces.length - 1 : 0;
      return times(pieces.map((part, i) => {
        if (part.function) throw new Fault("fault.argument");
        const chain = part.name ? [part.name, ...(has(dotted, part.name) ? dotted[part.name] : [])] : [null];
        if (dots && i === carrier && dots >= chain.length) throw new Fault("fault.dots", token.text);
        if (part.name) return worth(chain[i === carrier ? dots : 0]);
        const [name, angles] = part.short;
        return p => Math[name](angles.reduce((total, q) => total + p[q], 0));
      }));
    }
    function raised(base) {
      if (!sees("op", "^")) return base;
      const power = exponent(take());
      return spread(lift(x => x ** power, base), power > 1 ? terms(times(Array(power).fill(base))) : []);
    }
    function exponent(caret) {
      const sign = sees("op", "-") ? -1 : 1;
      if (sees("op", "+", "-")) take();
      const token = take(), inner = token.kind === "open" ? bracket(token) : token.value;
      const value = typeof inner === "function" ? inner.number : inner;
      if (token.kind === "number" && token.text.length > 1 && !caret.long) throw new Fault("fault.power");
      if (!(Number.isInteger(value) && Math.abs(value) <= grammar.largestPower) && Math.abs(value) !== 0.5) throw new Fault("fault.power");
      return sign * value;
    }

    const value = sum();
    if (peek()) throw new Fault("fault.here", take().text);
    return Object.assign(p => at(value, p), {terms: terms(value).map(one => p => at(one, p))});
  }
  return {Fault, has, members, label, read, starred, parsed: formula, formula: text => formula(tokens(text))};
})();
