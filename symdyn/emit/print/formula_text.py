"""Forms as LaTeX and as plain text.

A printer yields text with break marks in front of every + and - at which a line may end;
`symdyn.emit.print.breaking` uses them or takes them out.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import lru_cache

from symdyn.algebra import AngleGroup, Compactor, Form, Function, Number, Pi, Power, Product, Sum, Symbol
from symdyn.dynamics.mechanism import State
from symdyn.emit.print.breaking import BREAK, LINE, Sizes, latex_width, parts
from symdyn.emit.print.printed_names import PrintName
from symdyn.emit.render import in_latex
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.rounding import digits_or
from symdyn.scene import Quantity
from symdyn.scene.values import LatexSymbol, spell

LONGEST_VALUE = 24  # characters of a formula in a table
FRACTIONS = (2, 3, 4, 6, 7, 8, 9, 11, 12)  # 1/12 stays a fraction; 7/20 is read as 0.35


@lru_cache(maxsize=10_000)  # long formulas have the same few numbers in thousands of places
def significant(value: Fraction, digits: int) -> str:
    """Return a positive value rounded to significant digits, as a decimal, or as a·10^k written "aek"."""
    exponent = 0
    while value >= Fraction(10) ** (exponent + 1):
        exponent += 1
    while value < Fraction(10) ** exponent:
        exponent -= 1
    scaled = round(value * Fraction(10) ** (digits - 1 - exponent))
    if scaled == 10**digits:
        exponent, scaled = exponent + 1, 10 ** (digits - 1)
    if -4 <= exponent < digits + 2:
        return spell(Fraction(scaled) * Fraction(10) ** (exponent - digits + 1))
    return f"{spell(Fraction(scaled, 10 ** (digits - 1)))}e{exponent}"


def rounded(form: Form, digits: int) -> Form:
    """Return a form whose numbers have no more than `digits` significant digits."""
    if isinstance(form, Number):
        value = abs(form.value)
        long = len(str(value.numerator).strip("0")) > digits or len(str(value.denominator)) > digits
        near = Fraction(significant(value, digits)) if long else value
        return Number(near if form.value > 0 else -near)
    return form.with_parts(rounded(x, digits) for x in form.parts)


def value_text(formula: Quantity) -> str:
    """Return what a parameter is worth for a table: its formula where that is short, else its value to six digits."""
    text, digits = spell(formula), digits_or(6)
    if len(text) <= max(LONGEST_VALUE, digits):
        return text
    value = Fraction(formula.at({}) or 0)
    near = significant(abs(value), digits) if value else "0"
    return f"≈ {'-' if value < 0 else ''}{near}"


# Plain text


def text_of(form: Form, digits: int | None = None) -> str:
    """Return a form as text that `symdyn.scene.parse` and Python read, numbers exact, or to so many digits."""
    return _text(form if digits is None else rounded(form, digits)).replace(BREAK, "")


def broken_text(form: Form) -> str:
    """Return the same text with break marks."""
    return _text(form)


def _text(form: Form) -> str:
    if isinstance(form, Sum):
        return _signed_sum(form, _text, _text_factor)
    if isinstance(form, Product):
        sign, rest = form.split_sign()
        if sign < 0:
            return f"-{_text_factor(rest)}"
        rest = rest.in_powers
        above = [f for f in rest.factors if not _is_inverse(f)] if isinstance(rest, Product) else [rest]
        below = [f for f in rest.factors if _is_inverse(f)] if isinstance(rest, Product) else []
        text = "*".join(map(_text_factor, above)) if above else "1"
        for factor in below:
            assert isinstance(factor, Power)
            text += _divided(factor)
        return text
    if isinstance(form, Number):
        return spell(form.value)
    if isinstance(form, Power):
        if form.exponent < 0:
            return f"1{_divided(form)}"
        bare = isinstance(form.base, (Symbol, Pi)) or (isinstance(form.base, Function) and form.base.op is not Op.POW)
        return f"{_text(form.base)}**{form.exponent}" if bare else f"({_text(form.base)})**{form.exponent}"
    if isinstance(form, Function):
        return _text_of_function(form)
    return form.name if isinstance(form, Symbol) else "pi"


def _word(form: Function) -> str:
    """Return what a function is called: max or min of two where a selection is one."""
    if form.op is Op.SELECT and not form.name:
        guard, a, b = form.args
        for word, larger, smaller in (("max", a, b), ("min", b, a)):
            if Counter(guard.terms) == Counter(Form.sum((larger, smaller.negative)).terms):
                return word
    return form.op.name.lower()


def _text_of_function(form: Function) -> str:
    args, word = [text_of(arg) for arg in form.args], _word(form)
    if form.name:
        return f'table("{form.name}", {", ".join(args)})'
    if form.op is Op.POW:
        plain = [
            isinstance(x, Symbol) or (isinstance(x, Number) and text.isdecimal())
            for x, text in zip(form.args, args, strict=True)
        ]
        return "**".join(text if bare else f"({text})" for text, bare in zip(args, plain, strict=True))
    if form.op is Op.SELECT:
        return f"{word}({', '.join(args[1:])})" if word != "select" else f"if({args[0]} > 0, {args[1]}, {args[2]})"
    return f"{word}({', '.join(args)})"


def _divided(inverse: Power) -> str:
    """Return "/m" for 1/m, and "/(m*h)" for the inverse of a product or a quotient."""
    below = Power(inverse.base, -inverse.exponent) if inverse.exponent < -1 else inverse.base
    open_ended = isinstance(below, Product) or _is_inverse(below)
    return f"/({_text(below)})" if open_ended else f"/{_text_factor(below)}"


def _text_factor(form: Form) -> str:
    text = _text(form)
    wide = isinstance(form, Sum) or form.split_sign()[0] < 0 or (isinstance(form, Number) and "/" in text)
    return f"({text})" if wide else text


def _is_inverse(form: Form) -> bool:
    return isinstance(form, Power) and form.exponent < 0


def _signed_sum(form: Form, show: Callable[[Form], str], factor: Callable[[Form], str]) -> str:
    """Return a sum with break marks; `factor` shows what stands behind a minus sign, in brackets if it is a sum."""
    text = ""
    for term in form.terms:
        sign, rest = term.split_sign()
        mark = "-" if sign < 0 else "+"
        shown = factor(rest) if sign < 0 and isinstance(rest, Sum) else show(rest)
        text += f" {BREAK}{mark} {shown}" if text else f"{mark}{shown}".removeprefix("+")
    return text


# LaTeX

FUNCTIONS: Mapping[Op, str] = {
    Op.SIN: r"\sin",
    Op.COS: r"\cos",
    Op.EXP: r"\exp",
    Op.LOG: r"\ln",
    Op.TANH: r"\tanh",
    Op.SIGN: r"\operatorname{sgn}",
    Op.ATAN2: r"\operatorname{atan2}",
}


@dataclass(frozen=True)
class Latex:
    """Writes forms in LaTeX.

    Attributes:
        symbols: LaTeX of each name; see `symdyn.emit.print.printed_names.latex_symbols`.
        digits: significant digits of numbers that are no short fractions; None writes them exactly.
        widest: fraction, root or argument, pt; a wider one is written in a row, (a + b)^{-1/2}, and may break.
    """

    symbols: Mapping[str, str]
    digits: int | None = 6
    widest: float = 0.7 * LINE
    _known: dict[int, tuple[Form, str]] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __call__(self, form: Form) -> str:
        """Return LaTeX with break marks, which is written once: a fraction is tried in several ways."""
        if id(form) not in self._known:
            self._known[id(form)] = form, self._written(form)
        return self._known[id(form)][1]

    def _written(self, form: Form) -> str:
        if isinstance(form, Sum):
            return _signed_sum(form, self, self.bracketed)
        if isinstance(form, Product):
            return self._product(form)
        if isinstance(form, Number):
            return f"-{self.number(-form.value)}" if form.value < 0 else self.number(form.value)
        if isinstance(form, Power):
            return self._power(form)
        if isinstance(form, Function):
            return self._function(form, 1)
        return self.symbols.get(form.name) or str(PrintName.of_code(form.name)) if isinstance(form, Symbol) else r"\pi"

    def number(self, value: Fraction) -> str:
        """Return a number that is not negative."""
        if value.denominator == 1 and (self.digits is None or value < 10 ** (self.digits + 2)):
            return str(value.numerator)
        if value.denominator in FRACTIONS and value.numerator <= 12:
            return rf"\tfrac{{{value.numerator}}}{{{value.denominator}}}"
        if self.digits is None:
            text = spell(value)
            return rf"\tfrac{{{value.numerator}}}{{{value.denominator}}}" if "/" in text else text
        return self.scientific(significant(value, self.digits))

    @staticmethod
    def scientific(text: str) -> str:
        r"""Return 1.5e-07 as 1.5 \cdot 10^{-7}."""
        mantissa, _, exponent = text.partition("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa

    def unbroken(self, form: Form) -> str:
        return self(form).replace(BREAK, "")

    def underbraced(self, form: Form, name: str, widest: float = math.inf) -> tuple[str, str]:
        r"""Return a sign and \underbrace{form}_{name} behind it, the name alone where the form is wider, pt."""
        negative = all(term.split_sign()[0] < 0 for term in form.terms)
        text = self.unbroken(form.negative if negative else form)
        if latex_width(text) > widest:
            return "+", name
        text = f"({text})" if len(form.terms) > 1 else text
        return ("-" if negative else "+"), rf"\underbrace{{{text}}}_{{{'-' if negative else ''}{name}}}"

    def bracketed(self, form: Form) -> str:
        """Return a factor: in brackets if it is a sum or has a sign."""
        text = self(form)
        return _brackets(text) if isinstance(form, Sum) or form.split_sign()[0] < 0 else text

    def _product(self, form: Product) -> str:
        sign, rest = form.split_sign()
        if sign < 0:
            return f"-{self.bracketed(rest)}"
        factors = rest.in_powers.factors
        below = [f.base.power(-f.exponent) for f in factors if isinstance(f, Power) and f.exponent < 0]
        above = [f for f in factors if not _is_inverse(f)]
        return self._quotient(above, below) if below else self._beside(above)

    def _quotient(self, above: Sequence[Form], below: Sequence[Form]) -> str:
        """Return a fraction; where it is too wide, sums stand behind it, and what is wide below them as powers."""
        first = above[0] if above else None
        if isinstance(first, Number) and self.number(first.value).startswith(r"\tfrac"):
            ones = [Number(Fraction(x)) for x in first.value.as_integer_ratio()]
            above, below = ([x for x in some if x != Number.ONE] for some in ([ones[0], *above[1:]], [ones[1], *below]))
        whole = self._fraction(above, below)
        if self._fits(whole):
            return whole
        sums = [f for f in above if BREAK in self(f)]
        atoms = [f for f in above if f not in sums]
        wide = [] if self._fits(self._fraction(atoms, below)) else [f for f in below if BREAK in self._plain(f)]
        narrow = [f for f in below if f not in wide]
        front = [self._fraction(atoms, narrow)] if narrow else [self._beside(atoms)] if atoms else []
        powers = [self._raised(f.base, -f.exponent) if isinstance(f, Power) else self._raised(f, -1) for f in wide]
        return " ".join([*front, *map(self.bracketed, sums), *powers])

    def _plain(self, form: Form) -> str:
        """Return a form as it would break, a root as what stands under it."""
        return self(form.args[0] if isinstance(form, Function) else form)

    def _fraction(self, above: Sequence[Form], below: Sequence[Form]) -> str:
        upper, lower = (self._beside(part).replace(BREAK, "") for part in (above, below))
        return rf"\frac{{{upper or '1'}}}{{{lower}}}"

    def _raised(self, base: Form, exponent: int) -> str:
        """Return a power of what is wide in brackets, which may break; a root's is a half."""
        if isinstance(base, Function) and base.op is Op.SQRT:
            (square,) = base.args
            power = str(exponent // 2) if exponent % 2 == 0 else f"{exponent}/2"
            return f"{_brackets(self(square))}^{{{power}}}"
        return f"{_brackets(self(base))}^{{{exponent}}}"

    def _fits(self, text: str) -> bool:
        return latex_width(text) <= self.widest

    def _beside(self, factors: Sequence[Form]) -> str:
        """Return factors side by side, a space behind a sine so that it ends there; one alone without brackets."""
        if len(factors) < 2:
            return "".join(map(self, factors))
        shown = [self.bracketed(f) for f in factors]
        text = shown[0]
        for previous, factor, following in zip(factors, factors[1:], shown[1:], strict=False):
            loose = isinstance(previous, Number) and isinstance(factor, Number)
            thin = isinstance(previous, Function) or (
                isinstance(previous, Power) and isinstance(previous.base, Function)
            )
            text += (r" \cdot " if loose else r" \, " if thin else " ") + following
        return text

    def _power(self, form: Power) -> str:
        if form.exponent < 0:
            return self._quotient([], [form.base if form.exponent == -1 else Power(form.base, -form.exponent)])
        if isinstance(form.base, Function):
            return self._function(form.base, form.exponent)
        text = self(form.base)
        # an accent or a bracketed base takes the exponent as it is: \dot q_1^2, (a + b)^2
        bare = isinstance(form.base, Pi) or (isinstance(form.base, Number) and text.isdigit())
        bare = bare or (isinstance(form.base, Symbol) and LatexSymbol(text).takes_exponent)
        exponent = str(form.exponent) if form.exponent < 10 else f"{{{form.exponent}}}"
        return f"{text}^{exponent}" if bare else f"{_brackets(text)}^{exponent}"

    def _function(self, form: Function, power: int) -> str:
        exponent = "" if power == 1 else f"^{power}" if power < 10 else f"^{{{power}}}"
        if form.name:
            inside = ", ".join(map(self.unbroken, form.args))
            return rf"\operatorname{{{in_latex(form.name)}}}{exponent}{_brackets(inside)}"
        if form.op is Op.POW:
            base, to = form.args
            bare = isinstance(base, Symbol) and LatexSymbol(self(base)).takes_exponent
            bare = bare or (isinstance(base, Function) and base.op is Op.ABS)
            text = self.unbroken(base) if bare else _brackets(self.unbroken(base))
            return f"{text}^{{{self.unbroken(Form.product((Number(Fraction(power)), to)))}}}"
        if form.op is Op.SELECT and _word(form) == "select":
            guard, a, b = map(self.unbroken, form.args)
            cases = rf"\begin{{cases}} {a} & {guard} > 0 \\ {b} & {guard} \le 0 \end{{cases}}"
            return cases if power == 1 else rf"\Bigl({cases}\Bigr){exponent}"
        if form.op is Op.SELECT:
            inside = ", ".join(map(self.unbroken, form.args[1:]))
            return rf"\{_word(form)}{exponent}{_brackets(inside)}"
        arguments = ", ".join(map(self, form.args))
        if self._fits(arguments):
            arguments = arguments.replace(BREAK, "")
        elif form.op is Op.SQRT:
            return self._raised(form, power)
        if form.op is Op.SQRT:
            return rf"\sqrt{{{arguments}}}{exponent}" if power == 1 else rf"\bigl(\sqrt{{{arguments}}}\bigr){exponent}"
        if form.op is Op.ABS:
            return rf"\lvert {arguments} \rvert{exponent}"
        if isinstance(form.args[0], (Symbol, Pi)) and len(form.args) == 1:
            return f"{FUNCTIONS[form.op]}{exponent} {arguments}"
        return f"{FUNCTIONS[form.op]}{exponent}{_brackets(arguments)}"


def _brackets(text: str) -> str:
    """Return text in brackets, larger ones around brackets or fractions."""
    if r"\bigl" in text or r"\frac" in text:
        return rf"\Bigl({text}\Bigr)" if r"\Bigl" not in text else rf"\biggl({text}\biggr)"
    return rf"\bigl({text}\bigr)" if "(" in text else f"({text})"


# Short notation


def shorthands(form: Form, numbers: Mapping[str, int], letters: str) -> dict[Form, Symbol]:
    """Return the symbols s12 for sin(q1 + q2), c2 for cos(q2), by what they stand for in a form.

    Args:
        form: what is to be rewritten.
        numbers: the number of each coordinate.
        letters: of sines and cosines.
    """
    found: dict[Form, Symbol] = {}
    separator = "_" if max(numbers.values(), default=0) > 9 else ""
    for one in form.walk():
        if isinstance(one, Function) and one.op in (Op.SIN, Op.COS):
            places = [numbers.get(term.name) if isinstance(term, Symbol) else None for term in one.args[0].terms]
            if None not in places:
                found[one] = Symbol(letters[one.op is Op.COS] + separator.join(map(str, places)))
    return found


Forms = Callable[[Expr], Form]
"""What writes nodes."""


def in_sines(nodes: Sequence[Expr], state: State, parallel: Sequence[AngleGroup]) -> Forms:
    """Return what writes nodes: as short as a ring of sines can, as they stand where there is no such ring.

    Lengths and other functions of the state that no ring has are letters of it, written out last, where that is less.
    """
    letters = (*state.q, *state.qd, *state.qdd)
    with suppress(DerivationError):
        return Compactor.of(nodes, letters, parallel, state.spheres)
    moving = set[Expr]()
    for node in reachable(nodes):
        if node in letters or not moving.isdisjoint(node.args):
            moving.add(node)
    named = {
        node: node.graph.symbol(f"function[{k}]")
        for k, node in enumerate(reachable(nodes))
        if node in moving and node.op.is_function and node.op not in (Op.SIN, Op.COS)
    }
    if not named:  # the ring's forms are too long
        return Form.of
    needed = list(dict.fromkeys([*nodes, *(arg for node in named for arg in node.args)]))
    short = dict(zip(needed, substitute(needed, named), strict=True))
    known, sizes = dict[str, Form](), Sizes()

    def shorter(node: Expr) -> Form:
        return min(Form.of(node), write(short[node]).substitute(known), key=lambda form: parts(form, sizes))

    try:
        write = Compactor.of(list(short.values()), letters, parallel, state.spheres)
        for node, symbol in named.items():  # what stands in others comes before these
            known[str(symbol.value)] = Form.of(node).with_parts(map(shorter, node.args))
    except DerivationError:
        return Form.of
    return shorter
