"""Rational functions of what a graph names, in lowest terms: what small exact matrices are solved in.

Generators are symbols, π, and functions of anything (sin q, a root), each an unknown of its own but for

    sin²x = 1 - cos²x,  √x² = x            x any node; of roots only where x is a polynomial

so that equal functions may still look different where angles are added: they are equal, and no one says that they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from symdyn.algebra.form import Form, Number
from symdyn.graph import Arithmetic, Expr, Graph, Op, evaluate, reachable

Polynomial = Any  # flint.fmpq_mpoly, which carries no type hints

LONG = 2000
"""Products of terms above and below a line beyond which what they share is not looked for; that grows fast."""

MOST = 20_000
"""Products of terms above and below lines, all together, that small matrices take; OverflowError beyond."""

EXTRA = "x"
"""Name of the generator that stands for an eigenvalue."""


class Ratio(NamedTuple):
    """A quotient, in lowest terms if it is not long, the denominator's leading coefficient one."""

    over: Polynomial
    under: Polynomial

    @property
    def is_zero(self) -> bool:
        return bool(self.over == 0)

    @property
    def size(self) -> int:
        """How many terms it has."""
        return len(self.over) + len(self.under)


class Solving(Arithmetic):
    """Small matrices over a field whose pivots have a rank, the best the least."""

    zero: Any
    one: Any

    def rank(self, pivot: Any) -> float:
        """Return what is least for the best pivot."""
        raise NotImplementedError

    def solved(self, A: Sequence[Sequence[Any]], B: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """Return X of A X = B, by Gauss and Jordan; ZeroDivisionError where A is singular."""
        n = len(A)
        rows = [[*a, *b] for a, b in zip(A, B, strict=True)]
        for k in range(n):
            pivot = min(
                (r for r in range(k, n) if not rows[r][k].is_zero), key=lambda r: self.rank(rows[r][k]), default=None
            )
            if pivot is None:
                raise ZeroDivisionError
            rows[k], rows[pivot] = rows[pivot], rows[k]
            head = rows[k][k]
            rows[k] = [x if x.is_zero else self.div(x, head) for x in rows[k]]
            for r in range(n):
                share = rows[r][k]
                if r != k and not share.is_zero:
                    rows[r] = [
                        x if y.is_zero else self.sub(x, self.mul(share, y))
                        for x, y in zip(rows[r], rows[k], strict=True)
                    ]
        return [row[n:] for row in rows]

    def product(self, A: Sequence[Sequence[Any]], B: Sequence[Sequence[Any]]) -> list[list[Any]]:
        columns = list(zip(*B, strict=True))
        return [[self._dot(row, column) for column in columns] for row in A]

    def _dot(self, a: Sequence[Any], b: Sequence[Any]) -> Any:
        total = self.zero
        for x, y in zip(a, b, strict=True):
            if not (x.is_zero or y.is_zero):
                total = self.add(total, self.mul(x, y))
        return total


class Nodes(Solving):
    """The nodes of a graph; pivots are those that are largest at a point, where symbols have `values`."""

    def __init__(self, graph: Graph, values: Mapping[Expr, float]) -> None:
        self.zero, self.one, self._known = graph.zero, graph.one, dict(values)

    def rank(self, pivot: Expr) -> float:
        """Return minus its size there."""
        from symdyn.algebra.numeric import Floats  # starts NumPy

        return -abs(float(evaluate([pivot], Floats(), self._known, known=self._known)[0]))


class Ratios(Solving):
    """The field: an `Algebra`."""

    def __init__(self, outputs: Iterable[Expr]) -> None:
        self._spent = 0
        plain = (Op.CONSTANT, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG)
        self.atoms = [node for node in reachable(outputs) if node.op not in plain]
        self.atoms.sort(key=lambda node: node.op is not Op.SQRT)  # so that roots are divided by before what is in them
        self._ctx = fmpq_mpoly_ctx.get((EXTRA, *(f"a{k}" for k in range(len(self.atoms)))), Ordering.lex)
        self.extra, *generators = self._ctx.gens()
        self._generators = dict(zip(self.atoms, generators, strict=True))
        self._one = self.extra**0
        self.zero, self.one = self._ratio(0 * self._one), self._ratio(self._one)
        self._relations: dict[Expr, Polynomial] = {}
        for node in self.atoms:
            if node.op is Op.SIN:
                other = self._generators.get(node.graph.cos(node.args[0]))
                if other is not None:
                    self._relations[node] = self._generators[node] ** 2 + other**2 - 1

    def _ratio(self, over: Polynomial, under: Polynomial | None = None) -> Ratio:
        under = self._one if under is None else under
        for relation in self._relations.values() if hasattr(self, "_relations") else ():
            over, under = divmod(over, relation)[1], divmod(under, relation)[1]
        if under == 0:
            raise ZeroDivisionError
        if over == 0:
            return Ratio(over, self._one)
        self._spent += len(over) * len(under)
        if self._spent > MOST:
            raise OverflowError("a quotient that is no small one")
        if len(over) * len(under) <= LONG:
            common = over.gcd(under)
            over, under = divmod(over, common)[0], divmod(under, common)[0]
        lead = under.leading_coefficient()
        return Ratio(over / lead, under / lead)

    def constant(self, value: Fraction) -> Ratio:
        return Ratio(self._one * fmpq(value.numerator, value.denominator), self._one)

    def pi(self) -> Ratio:
        (node,) = [one for one in self.atoms if one.op is Op.PI]
        return Ratio(self._generators[node], self._one)

    def symbol(self, node: Expr) -> Ratio:
        return Ratio(self._generators[node], self._one)

    def add(self, a: Ratio, b: Ratio) -> Ratio:
        return self._ratio(a.over * b.under + b.over * a.under, a.under * b.under)

    def sub(self, a: Ratio, b: Ratio) -> Ratio:
        return self._ratio(a.over * b.under - b.over * a.under, a.under * b.under)

    def mul(self, a: Ratio, b: Ratio) -> Ratio:
        return self._ratio(a.over * b.over, a.under * b.under)

    def div(self, a: Ratio, b: Ratio) -> Ratio:
        return self._ratio(a.over * b.under, a.under * b.over)

    def neg(self, a: Ratio) -> Ratio:
        return Ratio(-a.over, a.under)

    def function(self, node: Expr, args: Sequence[Ratio]) -> Ratio:
        """Return a function, a generator; its square where it is a root."""
        if node.op is Op.SQRT and args[0].under == 1 and node not in self._relations:
            self._relations[node] = self._generators[node] ** 2 - args[0].over
        return Ratio(self._generators[node], self._one)

    def rank(self, pivot: Ratio) -> float:
        """Return its length: short pivots are the best."""
        return pivot.size

    def used(self, ratio: Ratio) -> list[Expr]:
        """Return the generators that a quotient uses."""
        powers = [one for part in ratio for one in part.monoms()]
        return [node for k, node in enumerate(self.atoms, start=1) if any(one[k] for one in powers)]

    def values(self) -> dict[Expr, Ratio]:
        return {node: self.symbol(node) for node in self.atoms if node.op is Op.SYMBOL}

    @staticmethod
    def form_of(node: Expr) -> Form:
        """Return a node as a quotient, both sides in factors."""
        field = Ratios([node])
        return field.form(evaluate([node], field, field.values())[0])

    @staticmethod
    def collected(node: Expr) -> Form:
        """Return a node as a sum of quotients in factors, one for each of the letters that it is linear in."""
        field = Ratios([node])
        over, under = evaluate([node], field, field.values())[0]
        powers, below = over.monoms(), {k for one in under.monoms() for k, power in enumerate(one) if power}
        linear = list[int]()
        for k in range(1, len(field.atoms) + 1):
            others = [one for one in powers if any(one[j] for j in linear)]
            if k not in below and max((one[k] for one in powers), default=0) == 1 and not any(x[k] for x in others):
                linear.append(k)
        parts: dict[int, dict[tuple[int, ...], Any]] = {}
        for one, coefficient in over.terms():
            parts.setdefault(next((k for k in linear if one[k]), 0), {})[one] = coefficient
        return Form.sum(field.form(field._ratio(field._ctx.from_dict(part), under)) for part in parts.values())

    def form(self, ratio: Ratio) -> Form:
        """Return a quotient as a formula, both sides in factors."""
        if ratio.is_zero:
            return Number(Fraction(0))
        above, over = self._factors(ratio.over)
        below, under = self._factors(ratio.under)
        value = above / below  # 3 g/(2 l) is read more easily than (3/2) g/l
        number = Number(Fraction(value.numerator))
        under = under if value.denominator == 1 else [Number(Fraction(value.denominator)), *under]
        whole = Form.product(under) if under else None
        return Form.product((number, *over, *([] if whole is None else [whole.power(-1)])))

    def _factors(self, p: Polynomial) -> tuple[Fraction, list[Form]]:
        scale, factors = p.factor()
        number, found = Fraction(int(scale.p), int(scale.q)), []
        for one, power in factors:
            content = Fraction(int(one.leading_coefficient().p), int(one.leading_coefficient().q))
            terms = [(powers, Fraction(int(c.p), int(c.q))) for powers, c in one.terms()]
            sign = -1 if sum(c < 0 for _, c in terms) * 2 > len(terms) else 1
            number *= Fraction(sign) ** int(power)
            assert content != 0, "a factor has a leading term"
            found.append(Form.sum([self._term(sign * c, powers) for powers, c in terms]).power(int(power)))
        return number, found

    def _term(self, coefficient: Fraction, powers: Sequence[int]) -> Form:
        """Return a term; the first generator is the extra one, which no formula shows."""
        bases = [Form.of(node) for node in self.atoms]
        factors = [base.power(int(k)) for base, k in zip(bases, powers[1:], strict=True) if k]
        return Form.product((Number(coefficient), *factors))

    def characteristic(self, A: Sequence[Sequence[Ratio]]) -> list[Ratio]:
        """Return the coefficients of det(λ - A), that of λⁿ first, by Faddeev and LeVerrier."""
        n = len(A)
        coefficients, M = [self.one], [[self.zero] * n for _ in range(n)]
        for k in range(1, n + 1):
            M = self.product(A, M)
            for i in range(n):
                M[i][i] = self.add(M[i][i], coefficients[-1])
            trace = self.zero
            for i, row in enumerate(self.product(A, M)):
                trace = self.add(trace, row[i])
            coefficients.append(self.mul(self.constant(Fraction(-1, k)), trace))
        return coefficients

    def factors(self, coefficients: Sequence[Ratio]) -> list[tuple[list[Ratio], int]]:
        """Return factors of a polynomial, each monic by its coefficients, highest first, and how often it is one."""
        under = self.one.over
        for one in coefficients:
            under = divmod(under * one.under, under.gcd(one.under))[0]
        n = len(coefficients) - 1
        whole = sum(
            divmod(one.over * under, one.under)[0] * self.extra ** (n - k) for k, one in enumerate(coefficients)
        )
        found = []
        for factor, power in whole.factor()[1]:
            parts: dict[int, Polynomial] = {}
            for powers, c in factor.terms():
                rest = self.one.over * c
                for generator, exponent in zip(self._ctx.gens()[1:], powers[1:], strict=True):
                    rest = rest * generator ** int(exponent)
                parts[int(powers[0])] = parts.get(int(powers[0]), 0) + rest
            top = max(parts)
            if top:
                zero = 0 * self.one.over
                found.append(([self._ratio(parts.get(k, zero), parts[top]) for k in range(top, -1, -1)], int(power)))
        return found

    def number_at(self, ratio: Ratio, values: Mapping[Expr, float]) -> float:
        """Return the value of a quotient where all its generators have one."""

        def value(p: Polynomial) -> float:
            total = 0.0
            for powers, c in p.terms():
                term = int(c.p) / int(c.q)
                for node, exponent in zip(self.atoms, powers[1:], strict=True):
                    term *= values[node] ** int(exponent) if exponent else 1.0
                total += term
            return total

        return value(ratio.over) / value(ratio.under)
