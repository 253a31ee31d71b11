r"""From tokens to a form: by binding power, bounded in depth and length. Nothing is evaluated.

    sum       [+-] term ([+-] term)*
    term      factor ([* /] [+-] factor)*    no sign between two factors is a product
    factor    primary [^ exponent]
    primary   number, word, bracket, \frac{}{}, \sqrt{}, \dot q, sin of a bracket or of [number] word

How close operators bind, and what functions there are, is said in `grammar`. Products and quotients go from left to
right: a/b c is (a/b) c, and a/(b c) (d) is a d/(b c). What two readers would read differently is refused: \cos q^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Pi, Symbol
from symdyn.dynamics.mechanism import TIME
from symdyn.graph import Graph, Op, tangents
from symdyn.scene.values import shorten
from symdyn.teach.student.grammar import BEGINS, CLOSING, DEEPEST, FUNCTIONS, LARGEST_POWER, OPERATORS, Names
from symdyn.teach.student.tokens import Cursor, Source, Token

LARGEST = 10**60  # a number, or one over it
TOO_LARGE = "a number beyond 1e60, or below 1e-60, has no place in a formula"
SUM, PRODUCT, POWER = OPERATORS["+"], OPERATORS["*"], OPERATORS["^"]
UNARY = {name: Op[name.upper()] for name in FUNCTIONS.values() if name not in ("tan", "cot", "sec", "atan")}


def parse(source: Source, tokens: Sequence[Token], names: Names, end: int) -> Form:
    """Return the one formula that the tokens are, without rows, stops and "="; it ends at `end` in the source's text.

    Raises:
        TeachError: it is none.
    """
    form = _Parser(source, tokens, names, end).run()
    if any(map(_too_large, form.numbers)):
        raise source.fault(tokens[0].at, TOO_LARGE)
    return form


class _Parser(Cursor):
    def __init__(self, source: Source, tokens: Sequence[Token], names: Names, end: int) -> None:
        super().__init__(source, tokens, end)
        self.names, self.depth = names, 0

    def run(self) -> Form:
        form = self.sum()
        if self.peek() is not None:
            token = self.take()
            raise self.fault(token, f"{token.text} does not fit here")
        return form

    # Operators

    def sum(self) -> Form:
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.fault(self.take(), f"brackets nest deeper than {DEEPEST} levels")
        form = self.joined(SUM)
        self.depth -= 1
        return form

    def joined(self, power: int) -> Form:
        """Return what operators of a binding power join; what binds closer is a part of it."""
        if power == POWER:
            return self.factor()
        parts = [self.signed(PRODUCT) if power == SUM else self.joined(POWER)]
        while (operator := self.operator()) is not None and OPERATORS[operator] == power:
            token = self.take() if operator else None
            part = self.signed(POWER) if power == PRODUCT and operator else self.joined(power + 1)
            if token is not None and operator == "/":
                part = self.inverse(token, part)
            parts.append(_minus(part) if operator == "-" else part)
        return Form.sum(parts) if power == SUM else Form.product(parts)

    def operator(self) -> str | None:
        """Return the operator that comes next, "" for a product without a sign, None for none."""
        token = self.peek()
        if token is None:
            return None
        return "" if token.kind in BEGINS else token.text if token.kind == "op" and token.text in OPERATORS else None

    def signed(self, power: int) -> Form:
        negative = self.sees("op", "+", "-") and self.take().text == "-"
        form = self.joined(power)
        return _minus(form) if negative else form

    def inverse(self, token: Token, below: Form) -> Form:
        if below.express(Graph()).is_zero:
            raise self.fault(token, "division by zero")
        return Number(1 / below.value) if isinstance(below, Number) else below.power(-1)

    # Factors

    def factor(self) -> Form:
        token = self.take()
        if token.kind == "number":
            return self.raised(self.checked(token, Number(token.value)))
        if token.kind == "constant":
            name = self.names.symbols.get(token.text, token.text)
            return self.raised(Pi() if name == "pi" and "pi" not in self.names.symbols else Symbol(name))
        if token.text == "e" and "e" not in self.names.symbols and self.sees("op", "^"):
            self.take()
            return Function(Op.EXP, (self.bracket(self.take()) if self.sees("open") else self.argument(token),))
        if token.kind == "word":
            return self.word(token, token.dots)
        if token.kind == "open":
            return self.raised(self.bracket(token))
        if token.kind == "function":
            return self.function(token)
        if token.kind == "command":
            return self.command(token)
        if token.kind == "sub":
            raise self.fault(token, "an index belongs right behind its symbol, before an exponent: q_1^2")
        raise self.fault(token, f"a number, a name or a bracket is expected, not {token.text}")

    def bracket(self, opened: Token) -> Form:
        if self.sees("close"):
            raise self.fault(opened, "nothing stands in this bracket")
        inner = self.sum()
        closed = self.peek()
        if closed is None or closed.kind != "close":
            raise self.fault(opened, f"this {opened.text} is not closed")
        if closed.text != CLOSING[opened.text]:
            raise self.fault(closed, f"{closed.text} closes {opened.text}; {CLOSING[opened.text]} is expected")
        self.next += 1
        return Function(Op.ABS, (inner,)) if opened.text == "\\lvert" else inner

    def group(self, of: Token) -> Form:
        r"""Return what stands in braces after a command; \frac12 takes single digits."""
        token = self.take()
        if token.kind == "open" and token.text == "{":
            return self.bracket(token)
        if token.kind == "number" and token.text.isdigit():
            if len(token.text) > 1:  # \frac12: the other digits are the next argument
                rest = token.text[1:]
                self.next -= 1
                left = replace(token, text=rest, value=Fraction(rest), at=token.at + 1)
                self.tokens = [*self.tokens[: self.next], left, *self.tokens[self.next + 1 :]]
            return Number(Fraction(int(token.text[0])))
        raise self.fault(token, f"\\{of.text} needs braces: \\{of.text}{{...}}")

    def command(self, token: Token) -> Form:
        if token.text == "frac":
            above, below = self.group(token), self.group(token)
            return self.raised(Form.product((above, self.inverse(token, below))))
        if token.text in ("dot", "ddot"):
            return self.word(*self.dotted(token))
        if token.text == "rate":
            return self.raised(self.rate(token))
        inner = self.group(token)  # what is under a brace, or over it
        if (self.sees("sub") or self.sees("op", "^")) and self.take().kind == "op":
            self.group(token)
        return inner

    def rate(self, of: Token) -> Form:
        """Return the derivative of a bracket with respect to time."""
        inner = self.bracket(self.take())
        graph, own = Graph(), self.names
        found = [name for name in inner.symbols if own.moves(name) or name == TIME]
        rates = {name: "" if name == TIME else own.differentiated(name, 1) for name in found}
        if lost := [name for name, rate in rates.items() if rate is None]:
            raise self.fault(of, f"d/dt of {lost[0]} is not read here; write accelerations with two dots")
        forms = {name: own.formulas.get(rate, Symbol(rate)) if rate else Number.ONE for name, rate in rates.items()}
        seeds = {graph.symbol(name): form.express(graph) for name, form in forms.items()}
        return Form.of(tangents([inner.express(graph)], seeds)[0])

    def function(self, token: Token) -> Form:
        """Return a function of a bracket, or of a number times one name."""
        power = 1
        if self.sees("op", "^"):
            power = int(self.exponent(self.take(), half=False))
            if power < 1:
                message = f"a negative exponent at {token.text} has two readings; write 1/{token.text}(...)"
                raise self.fault(token, message)
        if self.peek() is None:
            raise self.fault(token, f"{token.text} of what? write {token.text}(q)")
        bare = not self.sees("open")
        inner = self.argument(token) if bare else self.bracket(self.take())
        if bare and self.sees("op", "^"):
            raise self.fault(self.take(), f"does the exponent belong to {token.text} or to its angle? write brackets")
        result = _function(token.text, inner).power(power)
        return result if bare else self.raised(result)

    def argument(self, of: Token) -> Form:
        factors: list[Form] = []
        while self.sees("number") or self.sees("command", "frac") or self.sees("constant"):
            factors.append(Number(self.take().value) if self.sees("number") else self.factor())
        if self.sees("word"):
            factors.append(self.named(self.take()))
        elif self.sees("command", "dot", "ddot"):
            token, dots = self.dotted(self.take())
            factors.append(self.product(token, self.read(token), dots))
        while factors and self.sees("word", TIME):  # sin Ω t
            factors.append(self.named(self.take()))
        if not factors:
            raise self.fault(self.tokens[self.next - 1], f"{of.text} of what? write {of.text}(q)")
        return Form.product(factors)

    def named(self, token: Token) -> Form:
        return self.product(token, self.read(token), token.dots)

    def dotted(self, token: Token) -> tuple[Token, int]:
        """Return the word under an accent, in braces or not, then perhaps its index, and the number of dots."""
        braced = self.sees("open", "{")
        if braced:
            self.take()
        word = self.take()
        if word.kind != "word":
            raise self.fault(token, f"\\{token.text} needs a coordinate: \\{token.text} q_1")
        if braced:
            closed = self.take()
            if closed.text != "}":
                raise self.fault(closed, f"}} is expected after \\{token.text}{{{word.text}")
            if self.sees("sub"):
                index = self.take()
                word = replace(word, text=word.text + index.text, spelled=f"{word.spelled}_{index.text}")
        return word, 1 if token.text == "dot" else 2

    # Words

    def read(self, token: Token) -> list[str | Form]:
        ways = self.names.read(token.spelled)
        if len(ways) == 1:
            return ways[0]
        if not ways:
            scene, near = self.names.scene.name, self.names.nearest(token.text)
            raise self.fault(token, f"{shorten(token.spelled)} is no symbol of {scene}; {near}")
        shown = " or ".join(" ".join(p if isinstance(p, str) else "..." for p in way) for way in ways[:2])
        raise self.fault(token, f"{token.text} can be read as {shown}; put spaces between factors")

    def word(self, token: Token, dots: int) -> Form:
        pieces = self.read(token)
        last = pieces[-1]
        if isinstance(last, Function) and not last.args:  # c q_1, the book's cosine
            before = [self.product(token, pieces[:-1], dots)] if pieces[1:] else []
            return Form.product((*before, self.function(replace(token, text=last.op.name.lower()))))
        behind = token.dots > 0 or len(pieces) == 1  # m_1r' has its prime at the end, an accent stands on the first
        first = self.product(token, pieces[:-1], 0 if behind else dots)
        return Form.product((first, self.raised(self.product(token, pieces[-1:], dots if behind else 0))))

    def product(self, token: Token, pieces: Sequence[str | Form], dots: int) -> Form:
        factors: list[Form] = []
        dotted = len(pieces) - 1 if token.dots else 0
        for i, piece in enumerate(pieces):
            if isinstance(piece, str):
                name = self.names.differentiated(piece, dots if i == dotted else 0)
                if name is None:
                    raise self.fault(token, f"{piece} has no such derivative; only coordinates carry dots")
                factors.append(self.names.formulas.get(name, Symbol(name)))
            elif dots and i == dotted:
                raise self.fault(token, f"{shorten(token.text)} carries no dots; only coordinates do")
            elif isinstance(piece, Function) and not piece.args:
                scene = self.names.scene.name
                raise self.fault(token, f"{shorten(token.text)} is no symbol of {scene}; write sin(...) in full")
            else:
                factors.append(piece)
        return Form.product(factors)

    # Powers

    def raised(self, base: Form) -> Form:
        if not self.sees("op", "^"):
            return base
        caret = self.take()
        exponent = self.exponent(caret)
        if exponent.denominator == 2:
            root = Function(Op.SQRT, (base,))
            return root if exponent > 0 else self.inverse(caret, root)
        if isinstance(base, Number) and (base != Number.ZERO or exponent >= 0):
            return self.checked(caret, Number(self.checked(caret, base).value ** int(exponent)))
        return base.power(int(exponent)) if exponent >= 0 else self.inverse(caret, base.power(-int(exponent)))

    def checked(self, token: Token, number: Number) -> Number:
        if _too_large(number):
            raise self.fault(token, TOO_LARGE)
        return number

    def exponent(self, caret: Token, half: bool = True) -> Fraction:
        """Return an exponent, an integer or one half: a digit, digits in brackets or after **."""
        sign = -1 if self.sees("op", "-") else 1
        if self.sees("op", "+", "-"):
            self.take()
        token = self.take()
        value = token.value if token.kind == "number" else None
        if token.kind == "open":
            value = _number(self.bracket(token))
        whole = value is not None and value.denominator == 1 and abs(value) <= LARGEST_POWER
        if value is None or not (whole or (half and abs(value) == Fraction(1, 2))):
            raise self.fault(token, f"an exponent is an integer up to {LARGEST_POWER}, or 1/2; more of it in braces")
        if token.kind == "number" and len(token.text) > 1 and not self.source.text.startswith("**", caret.at):
            raise self.fault(token, f"{token.text} without braces has two readings; write ^{{{token.text}}}")
        return sign * value


def _function(name: str, inner: Form) -> Form:
    """Return a function; tangents and secants by sine and cosine."""
    if name == "atan":
        return Function(Op.ATAN2, (inner, Number.ONE))
    if name in UNARY:
        return Function(UNARY[name], (inner,))
    sin, cos = Function(Op.SIN, (inner,)), Function(Op.COS, (inner,))
    above, below = {"tan": (sin, cos), "cot": (cos, sin), "sec": (Number.ONE, cos)}[name]
    return Form.product((above, below.power(-1)))


def _too_large(number: Number) -> bool:
    """Whether a number is larger than anything that is measured, or smaller."""
    size = abs(number.value)
    return size > LARGEST or 0 < size < Fraction(1, LARGEST)


def _number(form: Form) -> Fraction | None:
    """Return the value of a number, or of a sum of numbers; None of other forms."""
    terms = [term.value for term in form.terms if isinstance(term, Number)]
    return sum(terms, Fraction(0)) if len(terms) == len(form.terms) else None


def _minus(form: Form) -> Form:
    return Form.product((Number.MINUS_ONE, form))
