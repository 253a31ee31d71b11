"use strict";
// What a typed answer is read as, in MathML: the tokens and names that the judge reads, in its grammar.
const Echo = (() => {
  const {shown} = QUESTIONS;
  const row = parts => parts.length === 1 ? parts[0] : `<mrow>${parts.join("")}</mrow>`;
  const sign = text => `<mo>${text}</mo>`, named = text => `<mi mathvariant="normal">${text}</mi>`;
  const fraction = (above, below) => `<mfrac>${above}${below}</mfrac>`;
  const THIN = '<mspace width="0.17em"></mspace>';

  function formula(list) {
    let next = 0;
    const peek = () => list[next], take = () => list[next++];
    const sees = (kind, ...texts) => peek() && peek().kind === kind && (!texts.length || texts.includes(peek().text));

    function sum() {
      const parts = [];
      while (peek() && peek().kind !== "close") {
        if (sees("op", "+", "-")) parts.push(sign(take().text === "-" ? "\u2212" : "+"));
        parts.push(product());
      }
      return row(parts);
    }
    // From left to right: what follows a quotient without a sign stands beside it
    function product() {
      let parts = [];
      const before = () => parts.flatMap((part, k) => k ? [THIN, part] : [part]);
      while (peek() && peek().kind !== "close" && !sees("op", "+", "-")) {
        if (sees("op", "*")) { take(); continue; }
        if (!sees("op", "/")) { parts.push(factor()); continue; }
        take();
        const minus = sees("op", "-") && take(), below = factor();
        parts = [fraction(row(before()), minus ? row([sign("\u2212"), below]) : below)];
      }
      return row(before());
    }
    function raised(base) {
      if (!sees("op", "^")) return base;
      take();
      return `<msup>${row([base])}${exponent()}</msup>`;
    }
    function exponent() {
      const minus = sees("op", "-") && take(), above = sees("open") ? bracket(take(), false) : primary(take());
      return minus ? row([sign("\u2212"), above]) : above;
    }
    function bracket(open, drawn = true) {
      const inner = sum();
      take();
      const [left, right] = open.text === "\\lvert" ? ["|", "|"] : ["(", ")"];
      return drawn && open.text !== "{" ? row([sign(left), inner, sign(right)]) : inner;
    }
    const factor = () => raised(primary(take()));
    function primary(token) {
      if (token.kind === "number") return `<mn>${token.text.replace("{,}", ".").replace(",", ".").replace(/[^0-9.eE+-]/g, "")}</mn>`;
      if (token.kind === "constant") return "<mi>π</mi>";
      if (token.text === "e" && !Object.hasOwn(QUESTIONS.symbols, "e") && sees("op", "^")) return raised("<mi>e</mi>");
      if (token.kind === "word") return word(token.spelled, token.dots, true);
      if (token.kind === "open") return bracket(token);
      if (token.kind === "function") return call(token.text);
      if (token.text === "frac") { const above = group(); return fraction(above, group()); }
      if (token.text === "rate") return row([fraction("<mi>d</mi>", row(["<mi>d</mi>", shown.t || "<mi>t</mi>"])), bracket(take())]);
      if (/dot$/.test(token.text)) return accented(token.text === "dot" ? 1 : 2);
      return group();
    }
    function group() {
      const token = take();
      if (token.kind === "open") return bracket(token, false);
      if (token.text.length > 1) list.splice(next, 0, {...token, text: token.text.slice(1)});
      return `<mn>${token.text[0].replace(/\D/, "")}</mn>`;
    }
    function accented(dots) {
      const braced = sees("open", "{") && take();
      let {spelled} = take();
      if (braced && take() && sees("sub")) spelled += "_" + take().text;
      return word(spelled, dots);
    }
    function call(name) {
      const power = sees("op", "^") && take() ? exponent() : "";
      const head = power ? `<msup>${named(name)}${power}</msup>` : named(name);
      if (sees("open")) return row([head, sign("&#x2061;"), bracket({text: take().text === "\\lvert" ? "\\lvert" : "("})]);
      const argument = [];
      while (sees("number") || sees("constant") || sees("command", "frac")) argument.push(primary(take()));
      if (sees("word") || sees("command", "dot", "ddot")) argument.push(primary(take()));
      while (argument.length && sees("word", "t")) argument.push(primary(take()));
      return row([head, sign("&#x2061;"), THIN, row(argument)]);
    }
    function word(text, dots, primed) {
      const pieces = Formulas.read(text), carrier = primed ? pieces.length - 1 : 0;
      const parts = pieces.map((part, k) => {
        if (part.function) return call(part.function);
        if (!part.name) return row([named(part.short[0]), sign("("), row(part.short[1].flatMap((q, j) => j ? [sign("+"), shown[q]] : [shown[q]])), sign(")")]);
        const name = dots && k === carrier ? (QUESTIONS.dotted[part.name] || [])[dots - 1] : part.name;
        return shown[name] || named(name || "?");
      });
      return row(parts.flatMap((part, k) => k ? [THIN, part] : [part]));
    }
    return sum();
  }

  // What stands in the answer's MathML, nothing for what cannot be read
  function mathematics(source) {
    try {
      const parts = Formulas.members(source.slice(0, 5000));
      const sides = parts.map(part => {
        if (Formulas.label(part)) return named(Formulas.label(part));
        Formulas.parsed(part);
        return formula([...part]);
      });
      return row(sides.flatMap((side, k) => k ? [sign("="), side] : [side]));
    } catch {
      return "";
    }
  }
  return {mathematics};
})();
