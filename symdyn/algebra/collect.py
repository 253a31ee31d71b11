"""Collecting terms: sums of products, with common factors taken out, the one that saves most first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from math import gcd, lcm

from symdyn.algebra.form import Form, Number

Item = tuple[Fraction, Mapping[int, int]]  # one term: a number times powers of words

SMALL = 12  # integers up to this size may stay behind when a common number is taken out


class Monomials:
    """The forms that terms are products of, numbered, so that collecting compares integers."""

    def __init__(self) -> None:
        """Start with no word."""
        self.forms: list[Form] = []
        self._numbers: dict[Form, int] = {}

    def number(self, form: Form) -> int:
        """Return the number of a word."""
        if form not in self._numbers:
            self._numbers[form] = len(self.forms)
            self.forms.append(form)
        return self._numbers[form]

    def powers(self, factors: Mapping[int, int]) -> list[Form]:
        """Return the factors of a term as forms."""
        return [self.forms[word].power(power) for word, power in factors.items()]

    def term(self, item: Item) -> Form:
        """Return number · Π word^power."""
        return Form.product([Number(item[0]), *self.powers(item[1])])

    def collect(self, items: Sequence[Item]) -> Form:
        """Return Σ number · Π word^power with common factors taken out."""
        if len(items) == 1:
            return self.term(items[0])
        number, common, rest = take_out(items)
        terms = [self.collect(part) for part in partition(rest)]
        first = next((i for i, term in enumerate(terms) if term.split_sign()[0] > 0), 0)  # without a minus in front
        inner = Form.sum([terms[first], *terms[:first], *terms[first + 1 :]])
        return Form.product([Number(number), inner, *self.powers(common)])


def partition(items: Sequence[Item]) -> list[list[Item]]:
    """Return the terms in parts that share a factor: the factor that saves most first, the rest alone."""
    counts: dict[tuple[int, int], int] = {}
    for _, factors in items:
        for word, power in factors.items():
            for k in range(1, power + 1):
                counts[word, k] = counts.get((word, k), 0) + 1
    best, saving = None, 0
    for (word, power), count in counts.items():
        if (count - 1) * power > saving:
            best, saving = (word, power), (count - 1) * power
    if best is None:
        return [[item] for item in items]
    word, power = best
    chosen = [item for item in items if item[1].get(word, 0) >= power]
    return [chosen, *partition([item for item in items if item[1].get(word, 0) < power])]


def take_out(items: Sequence[Item]) -> tuple[Fraction, dict[int, int], list[Item]]:
    """Return (number, common factors, what is left of the terms)."""
    number = content([a for a, _ in items])
    common = dict(items[0][1]) if items else {}
    for _, factors in items[1:]:
        if not common:
            break
        common = {word: min(power, factors[word]) for word, power in common.items() if word in factors}
    rest: list[Item] = []
    for a, factors in items:
        left = {word: power - common.get(word, 0) for word, power in factors.items()} if common else factors
        rest.append((a / number, {word: power for word, power in left.items() if power}))
    return number, common, rest


def content(numbers: Sequence[Fraction]) -> Fraction:
    """Return a number worth taking out of a sum: what leaves small integers, else 1; with the sign of the majority."""
    negative = sum(a < 0 for a in numbers)
    minority = 2 * negative < len(numbers) or (2 * negative == len(numbers) and (not numbers or numbers[0] > 0))
    sign = 1 if minority else -1
    if not numbers:
        return Fraction(1)
    if len(numbers) == 1:
        return numbers[0]
    scale = lcm(*(a.denominator for a in numbers))
    wholes = [a.numerator * (scale // a.denominator) for a in numbers]
    divisor = gcd(*wholes)
    if max(map(abs, wholes)) <= SMALL * divisor:
        return Fraction(sign * divisor, scale)
    return Fraction(sign)


def rounded(number: Fraction, digits: int) -> Fraction:
    """Return a number rounded to significant decimal digits."""
    with localcontext(prec=digits):
        return Fraction(Decimal(number.numerator) / number.denominator)
