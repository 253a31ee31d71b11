"""Forms: expressions as a reader would write them. A small frozen tree that printers walk.

The graph shares and orders for machines; a form keeps the brackets, the order of terms and the sums inside a sine.
`Form.express` takes a form back to a graph, so every algebra can check what is printed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, ClassVar

from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, Piecewise, evaluate, reachable


class Form:
    """One of the seven below. Its hash is worked out once: forms are keys of many tables, and it walks the whole tree.

    Hashes of words differ between processes, so a pickle leaves them out.
    """

    def __init_subclass__(cls) -> None:
        """Hold on to this hash, in whose place a dataclass would put its own."""
        cls.__hash__ = cls.__hash__  # type: ignore[method-assign]

    def __hash__(self) -> int:
        known = self.__dict__.get("_hash")
        if known is None:
            known = self.__dict__["_hash"] = hash((type(self), *self.__dict__.values()))
        return int(known)

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in self.__dict__.items() if name != "_hash"}

    @staticmethod
    def of(node: Expr) -> Form:
        """Return a node as a form, unsimplified."""
        symbols: dict[Expr, Form] = {x: Symbol(str(x.value)) for x in reachable([node]) if x.op is Op.SYMBOL}
        tables = node.graph.found.get("tables", {})
        for one in reachable([node]) if tables else ():
            if one in tables:
                name, args = tables[one]
                body, *given = evaluate([one, *args], Forms(), symbols)
                symbols[one] = Function(Op.SELECT, tuple(given), name, body)
        return evaluate([node], Forms(), symbols)[0]

    @staticmethod
    def sum(terms: Iterable[Form]) -> Form:
        """Return the sum of `terms`; sums among them are laid open, zeros left out."""
        flat = [part for term in terms for part in term.terms]
        return Sum(tuple(flat)) if len(flat) > 1 else flat[0] if flat else Number.ZERO

    @staticmethod
    def product(factors: Iterable[Form]) -> Form:
        """Return the product of `factors`; products among them are laid open, numbers multiplied and put first."""
        over, under, flat = 1, 1, list[Form]()  # integers: a fraction reduces itself at every step
        for factor in factors:
            for part in factor.factors:
                if isinstance(part, Number):
                    over, under = over * part.value.numerator, under * part.value.denominator
                else:
                    flat.append(part)
        if over == 0:
            return Number.ZERO
        if over != under or not flat:
            flat.insert(0, Number.MINUS_ONE if over == -under else Number(Fraction(over, under)))
        return Product(tuple(flat)) if len(flat) > 1 else flat[0]

    @property
    def terms(self) -> tuple[Form, ...]:
        """The terms of a sum, or the form alone; none of zero."""
        return (self,)

    @property
    def factors(self) -> tuple[Form, ...]:
        """The factors of a product, or the form alone."""
        return (self,)

    @property
    def parts(self) -> tuple[Form, ...]:
        """Terms, factors, the base or the arguments that the form is made of."""
        return ()

    def with_parts(self, parts: Iterable[Form]) -> Form:
        """Return the form with others in place of its parts."""
        return self

    def walk(self) -> Iterator[Form]:
        """Yield the form and all that it is made of, as they are read."""
        yield self
        for part in self.parts:
            yield from part.walk()

    @property
    def symbols(self) -> list[str]:
        """The names of the symbols, in order of appearance, repeats included."""
        return [one.name for one in self.walk() if isinstance(one, Symbol)]

    @property
    def numbers(self) -> Iterator[Number]:
        """The numbers that stand in it, exponents left out."""
        return (one for one in self.walk() if isinstance(one, Number))

    def split_sign(self) -> tuple[int, Form]:
        """Return (sign, rest) with form = sign · rest and no minus sign left in front of `rest`."""
        return 1, self

    @property
    def negative(self) -> Form:
        """The form with its sign turned, of a sum that of every term."""
        return Form.sum(Form.product((Number.MINUS_ONE, term)) for term in self.terms)

    @property
    def plus_first(self) -> Form:
        """The form, of a sum with a term without a minus in front, if there is one."""
        first = next((k for k, x in enumerate(self.terms) if x.split_sign()[0] > 0), 0)
        return Form.sum((self.terms[first], *self.terms[:first], *self.terms[first + 1 :])) if first else self

    def power(self, exponent: int) -> Form:
        """Return the form to an integer power; an even one has no minus in front of its base."""
        base = self if exponent % 2 else self.split_sign()[1]
        return Number.ONE if exponent == 0 else self if exponent == 1 else Power(base, exponent)

    @property
    def in_powers(self) -> Form:
        """The form, of a product with no base twice above or below, numbers but: x³ for x x²."""
        powers = Counter[tuple[Form, bool, int]]()
        for k, x in enumerate(self.factors):
            base, exponent = (x.base, x.exponent) if isinstance(x, Power) else (x, 1)
            powers[base, exponent > 0, k * isinstance(base, Number)] += exponent
        whole = len(powers) == len(self.factors)
        return self if whole else Form.product(base.power(k) for (base, *_), k in powers.items())

    def signed_product(self, rate: Form) -> Form:
        """Return form · rate, a rate times itself as its square; a sum of negative terms takes its sign in front."""
        terms = self.terms
        if len(terms) > 1 and all(term.split_sign()[0] < 0 for term in terms):
            return Form.product((Number.MINUS_ONE, Form.sum(term.split_sign()[1] for term in terms), rate))
        if rate in self.factors:
            return Form.product(rate.power(2) if x == rate else x for x in self.factors)
        return Form.product((self, rate))

    def substitute(self, known: Mapping[str, Form]) -> Form:
        """Return the form with other forms in place of symbols."""
        return self.with_parts(part.substitute(known) for part in self.parts)

    def exchanged(self, swaps: Mapping[Form, Form]) -> Form:
        """Return the form with others in place of some that it is made of, the whole before its parts."""
        return swaps[self] if self in swaps else self.with_parts(part.exchanged(swaps) for part in self.parts)

    def express(self, graph: Graph) -> Expr:
        """Return the form as a node of `graph`; symbols keep their names."""
        raise NotImplementedError

    def to_sympy(self, positive: Sequence[str] = ()) -> Any:
        """Return a SymPy expression, with the grouping and the sums of angles that are shown.

        Symbols are real, those of `positive` positive too.
        """
        from symdyn.algebra.sympy_algebra import graph_to_sympy

        return graph_to_sympy([self.express(Graph())], positive)[0]


@dataclass(frozen=True)
class Number(Form):
    """An exact number."""

    value: Fraction

    ZERO: ClassVar[Number]
    ONE: ClassVar[Number]
    MINUS_ONE: ClassVar[Number]

    def __hash__(self) -> int:
        """Return the hash of the two integers, at a tenth of the price of a fraction's own."""
        return hash((self.value.numerator, self.value.denominator))

    @property
    def terms(self) -> tuple[Form, ...]:
        """The number, but for zero."""
        return (self,) if self.value else ()

    def split_sign(self) -> tuple[int, Form]:
        return (-1, Number(-self.value)) if self.value < 0 else (1, self)

    def express(self, graph: Graph) -> Expr:
        return graph.constant(self.value)


Number.ZERO, Number.ONE, Number.MINUS_ONE = Number(Fraction(0)), Number(Fraction(1)), Number(Fraction(-1))


@dataclass(frozen=True)
class Pi(Form):
    """The constant π."""

    def express(self, graph: Graph) -> Expr:
        return graph.pi


@dataclass(frozen=True)
class Symbol(Form):
    """A named coordinate, velocity or parameter."""

    name: str

    def substitute(self, known: Mapping[str, Form]) -> Form:
        return known.get(self.name, self)

    def express(self, graph: Graph) -> Expr:
        return graph.symbol(self.name)


@dataclass(frozen=True)
class Sum(Form):
    """Two terms or more, in order."""

    args: tuple[Form, ...]

    @property
    def terms(self) -> tuple[Form, ...]:
        return self.args

    @property
    def parts(self) -> tuple[Form, ...]:
        return self.args

    def with_parts(self, parts: Iterable[Form]) -> Form:
        return Form.sum(parts)

    def express(self, graph: Graph) -> Expr:
        return graph.total(term.express(graph) for term in self.args)


@dataclass(frozen=True)
class Product(Form):
    """Two factors or more, in order; a number comes first."""

    args: tuple[Form, ...]

    @property
    def factors(self) -> tuple[Form, ...]:
        return self.args

    @property
    def parts(self) -> tuple[Form, ...]:
        return self.args

    def with_parts(self, parts: Iterable[Form]) -> Form:
        return Form.product(parts)

    def split_sign(self) -> tuple[int, Form]:
        """Return the sign of the number in front, and the product without it."""
        first = self.args[0]
        negative = isinstance(first, Number) and first.value < 0
        return (-1, Form.product((Number.MINUS_ONE, *self.args))) if negative else (1, self)

    def express(self, graph: Graph) -> Expr:
        result = graph.one
        for factor in self.args:
            result = graph.mul(result, factor.express(graph))
        return result


@dataclass(frozen=True)
class Power(Form):
    """A base to an integer power other than 0 and 1."""

    base: Form
    exponent: int

    @property
    def parts(self) -> tuple[Form, ...]:
        return (self.base,)

    def with_parts(self, parts: Iterable[Form]) -> Form:
        (base,) = parts
        return base.power(self.exponent)

    def power(self, exponent: int) -> Form:
        return self.base.power(self.exponent * exponent) if exponent else Number.ONE

    def express(self, graph: Graph) -> Expr:
        return graph.power(self.base.express(graph), self.exponent)


@dataclass(frozen=True)
class Function(Form):
    """A function of the graph, such as sin, of forms; or a table by its `name`, and the `body` that it stands for."""

    op: Op
    args: tuple[Form, ...]
    name: str = ""
    body: Form | None = None

    @property
    def parts(self) -> tuple[Form, ...]:
        return self.args

    def with_parts(self, parts: Iterable[Form]) -> Form:
        """Return the function of others; a table's value stays."""
        return replace(self, args=tuple(parts))

    def substitute(self, known: Mapping[str, Form]) -> Form:
        args = tuple(arg.substitute(known) for arg in self.args)
        return replace(self, args=args, body=self.body and self.body.substitute(known))

    def express(self, graph: Graph) -> Expr:
        args = tuple(arg.express(graph) for arg in self.args)
        return graph.table(self.name, self.body.express(graph), args) if self.body else graph.function(self.op, *args)


class Forms:
    """The algebra that turns a graph into a form as it stands."""

    def constant(self, value: Fraction) -> Form:
        return Number(value)

    def pi(self) -> Form:
        return Pi()

    def add(self, a: Form, b: Form) -> Form:
        return Form.sum((a, b))

    def sub(self, a: Form, b: Form) -> Form:
        """Return a - b, the sign in every term."""
        return Form.sum((a, b.negative))

    def mul(self, a: Form, b: Form) -> Form:
        """Return a b; x x is a square."""
        if a == b and not isinstance(a, Number):
            return Power(a.base, 2 * a.exponent) if isinstance(a, Power) else Power(a, 2)
        return Form.product((a, b))

    def div(self, a: Form, b: Form) -> Form:
        return Form.product((a, Power(b, -1)))

    def neg(self, a: Form) -> Form:
        return a.negative

    def function(self, node: Expr, args: Sequence[Form]) -> Form:
        if isinstance(node.value, Piecewise):
            return node.value.over(self, args[0])
        return Function(node.op, tuple(args))


def in_any_order(form: Form) -> object:
    """Return what two forms share that differ in the order of their terms and factors alone."""
    parts = tuple(map(in_any_order, form.parts))
    if isinstance(form, (Sum, Product)):
        return type(form), frozenset(Counter(parts).items())
    if isinstance(form, Power):
        return form.exponent, parts
    return (form.op, form.name, parts) if isinstance(form, Function) else form
