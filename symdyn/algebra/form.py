"""Forms: expressions as a reader would write them. A small frozen tree that printers walk.

The graph shares and orders for machines; a form keeps the brackets, the order of terms and the sums inside a sine.
`express_form` takes a form back to a graph, so every algebra can check what is printed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Union

from symdyn.graph import Expr, Graph, Op, evaluate, reachable

Form = Union["Number", "Pi", "Symbol", "Sum", "Product", "Power", "Function"]


class _Hashed:
    """A form whose hash is worked out once: forms are keys of many tables, and a hash walks the whole tree below.

    Hashes of words differ between processes, so a pickle leaves them out.
    """

    def __init_subclass__(cls) -> None:
        """Hold on to this hash, in whose place a dataclass would put its own."""
        cls.__hash__ = cls.__hash__  # type: ignore[method-assign]

    def __hash__(self) -> int:
        """Return the hash of what the form consists of."""
        known = self.__dict__.get("_hash")
        if known is None:
            known = self.__dict__["_hash"] = hash((type(self), *self.__dict__.values()))
        return int(known)

    def __getstate__(self) -> dict[str, object]:
        """Return the fields alone."""
        return {name: value for name, value in self.__dict__.items() if name != "_hash"}


@dataclass(frozen=True)
class Number(_Hashed):
    """An exact number."""

    value: Fraction

    def __hash__(self) -> int:
        """Return the hash of the two integers, at a tenth of the price of a fraction's own."""
        return hash((self.value.numerator, self.value.denominator))


@dataclass(frozen=True)
class Pi(_Hashed):
    """The constant π."""


@dataclass(frozen=True)
class Symbol(_Hashed):
    """A named coordinate, velocity or parameter."""

    name: str


@dataclass(frozen=True)
class Sum(_Hashed):
    """Two terms or more, in order."""

    terms: tuple[Form, ...]


@dataclass(frozen=True)
class Product(_Hashed):
    """Two factors or more, in order; a number comes first."""

    factors: tuple[Form, ...]


@dataclass(frozen=True)
class Power(_Hashed):
    """A base to an integer power other than 0 and 1."""

    base: Form
    exponent: int


@dataclass(frozen=True)
class Function(_Hashed):
    """A function of the graph, such as sin, of forms."""

    op: Op
    args: tuple[Form, ...]


ZERO = Number(Fraction(0))
ONE = Number(Fraction(1))
MINUS_ONE = Number(Fraction(-1))


def sum_of(terms: Iterable[Form]) -> Form:
    """Return the sum of `terms`; sums among them are laid open, zeros left out."""
    flat: list[Form] = []
    for term in terms:
        flat += term.terms if isinstance(term, Sum) else [] if term == ZERO else [term]
    return Sum(tuple(flat)) if len(flat) > 1 else flat[0] if flat else ZERO


def product_of(factors: Iterable[Form]) -> Form:
    """Return the product of `factors`; products among them are laid open, numbers multiplied and put first."""
    over, under, flat = 1, 1, list[Form]()  # integers: a fraction reduces itself at every step
    for factor in factors:
        for part in factors_of(factor):
            if isinstance(part, Number):
                over, under = over * part.value.numerator, under * part.value.denominator
            else:
                flat.append(part)
    if over == 0:
        return ZERO
    if over != under or not flat:
        flat.insert(0, MINUS_ONE if over == -under else Number(Fraction(over, under)))
    return Product(tuple(flat)) if len(flat) > 1 else flat[0]


def power_of(base: Form, exponent: int) -> Form:
    """Return base to an integer power."""
    if exponent == 0:
        return ONE
    if isinstance(base, Power):
        return power_of(base.base, base.exponent * exponent)
    return base if exponent == 1 else Power(base, exponent)


def split_sign(form: Form) -> tuple[int, Form]:
    """Return (sign, rest) with form = sign · rest and no minus sign left in front of `rest`."""
    if isinstance(form, Number) and form.value < 0:
        return -1, Number(-form.value)
    if isinstance(form, Product) and isinstance(form.factors[0], Number) and form.factors[0].value < 0:
        return -1, product_of((MINUS_ONE, *form.factors))
    return 1, form


def terms_of(form: Form) -> tuple[Form, ...]:
    """Return the terms of a sum, or the form alone; none for zero."""
    if form == ZERO:
        return ()
    return form.terms if isinstance(form, Sum) else (form,)


def factors_of(form: Form) -> tuple[Form, ...]:
    """Return the factors of a product, or the form alone."""
    return form.factors if isinstance(form, Product) else (form,)


def signed_product(form: Form, rate: Form) -> Form:
    """Return form · rate; a sum of negative terms takes its sign in front."""
    terms = terms_of(form)
    if len(terms) > 1 and all(split_sign(term)[0] < 0 for term in terms):
        return product_of((MINUS_ONE, sum_of(split_sign(term)[1] for term in terms), rate))
    return product_of((form, rate))


def parts_of(form: Form) -> tuple[Form, ...]:
    """Return terms, factors, the base or the arguments that a form is made of."""
    if isinstance(form, Sum):
        return form.terms
    if isinstance(form, Product):
        return form.factors
    return (form.base,) if isinstance(form, Power) else form.args if isinstance(form, Function) else ()


def with_parts(form: Form, parts: Iterable[Form]) -> Form:
    """Return a form with others in place of its parts."""
    if isinstance(form, Sum):
        return sum_of(parts)
    if isinstance(form, Product):
        return product_of(parts)
    if isinstance(form, Power):
        (base,) = parts
        return power_of(base, form.exponent)
    return Function(form.op, tuple(parts)) if isinstance(form, Function) else form


def forms_in(form: Form) -> Iterator[Form]:
    """Yield a form and all that it is made of, as they are read."""
    yield form
    for part in parts_of(form):
        yield from forms_in(part)


def symbols_of(form: Form) -> list[str]:
    """Return the names of the symbols in a form, in order of appearance, repeats included."""
    return [one.name for one in forms_in(form) if isinstance(one, Symbol)]


def numbers_of(form: Form) -> Iterator[Number]:
    """Return the numbers that stand in a form, exponents left out."""
    return (one for one in forms_in(form) if isinstance(one, Number))


class Forms:
    """The algebra that turns a graph into a form as it stands."""

    def constant(self, value: Fraction) -> Form:
        """Return the number."""
        return Number(value)

    def pi(self) -> Form:
        """Return π."""
        return Pi()

    def add(self, a: Form, b: Form) -> Form:
        """Return a + b."""
        return sum_of((a, b))

    def sub(self, a: Form, b: Form) -> Form:
        """Return a - b, the sign in every term."""
        return sum_of((a, self.neg(b)))

    def mul(self, a: Form, b: Form) -> Form:
        """Return a b; x x is a square."""
        if a == b and not isinstance(a, Number):
            return Power(a.base, 2 * a.exponent) if isinstance(a, Power) else Power(a, 2)
        return product_of((a, b))

    def div(self, a: Form, b: Form) -> Form:
        """Return a / b."""
        return product_of((a, Power(b, -1)))

    def neg(self, a: Form) -> Form:
        """Return -a."""
        return sum_of(product_of((MINUS_ONE, term)) for term in terms_of(a))

    def function(self, node: Expr, args: Sequence[Form]) -> Form:
        """Return node.op(args)."""
        return Function(node.op, tuple(args))


def form_of(node: Expr) -> Form:
    """Return a node as a form, unsimplified."""
    symbols: dict[Expr, Form] = {x: Symbol(str(x.value)) for x in reachable([node]) if x.op is Op.SYMBOL}
    return evaluate([node], Forms(), symbols)[0]


def express_form(form: Form, graph: Graph) -> Expr:
    """Return a form as a node of `graph`; symbols keep their names."""
    if isinstance(form, Number):
        return graph.constant(form.value)
    if isinstance(form, Symbol):
        return graph.symbol(form.name)
    if isinstance(form, Pi):
        return graph.pi
    if isinstance(form, Sum):
        return graph.total(express_form(term, graph) for term in form.terms)
    if isinstance(form, Power):
        return graph.power(express_form(form.base, graph), form.exponent)
    if isinstance(form, Function):
        return graph.function(form.op, *(express_form(arg, graph) for arg in form.args))
    result = graph.one
    for factor in form.factors:
        result = graph.mul(result, express_form(factor, graph))
    return result


def in_any_order(form: Form) -> object:
    """Return what two forms share that differ in the order of their terms and factors alone."""
    parts = tuple(map(in_any_order, parts_of(form)))
    if isinstance(form, (Sum, Product)):
        return type(form), frozenset(Counter(parts).items())
    if isinstance(form, Power):
        return form.exponent, parts
    return (form.op, parts) if isinstance(form, Function) else form


def in_place(form: Form, known: Mapping[str, Form]) -> Form:
    """Return a form with other forms in place of symbols."""
    if isinstance(form, Symbol):
        return known.get(form.name, form)
    return with_parts(form, (in_place(part, known) for part in parts_of(form)))
