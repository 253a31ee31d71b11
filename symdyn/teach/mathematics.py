"""The mathematics of a document in LaTeX, which every format starts from: names, formulas, lines that fit."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from symdyn.algebra import Form
from symdyn.emit import in_latex
from symdyn.emit.print import BREAK, Latex, PrintName, latex_symbols
from symdyn.rounding import digits_or, in_digits
from symdyn.scene.values import GREEK
from symdyn.teach.document import Braced, Document, Formula, Letter, Matrix, Name, Rate, Words
from symdyn.teach.languages import language_of

DIGITS = 4  # of numbers in prose
LARGEST = 60  # denominator of a fraction that no decimal writes: 1/24


@dataclass(frozen=True)
class _Fractions(Latex):
    """Writes 1/24 as it is, which six digits do not, and decimals as the language does.

    Attributes:
        decimal: what stands before them.
    """

    decimal: str = "."

    def number(self, value: Fraction) -> str:
        """Return a number that is not negative."""
        repeats = value.denominator % 3 == 0 or value.denominator % 7 == 0
        if repeats and value.denominator <= LARGEST and value.numerator <= LARGEST:
            return rf"\tfrac{{{value.numerator}}}{{{value.denominator}}}"
        return super().number(value).replace(".", "." if self.decimal == "." else f"{{{self.decimal}}}")


class Spelling:
    """Writes the forms of one document in LaTeX."""

    def __init__(self, document: Document, digits: int | None = 6) -> None:
        """Spell every name of the document; `digits` as in `Latex`, None writes every number exactly."""
        self.symbols = latex_symbols(document.scene)
        for key, name in document.names.items():
            if name.look is not None:
                self.symbols[key] = self._spelled(name)
        self.decimal = language_of(document.language).decimal
        limit = None if digits is None else digits_or(digits)
        self._write = _Fractions(self.symbols, limit, decimal=self.decimal)

    def _spelled(self, name: Name) -> str:
        look = name.look
        if isinstance(look, Letter):
            return letter(look)
        assert look is not None, "a name without a look is a symbol of the scene"
        of = self.symbols[look.of]
        if isinstance(look, Rate):
            return rf"\frac{{\mathrm{{d}}}}{{\mathrm{{d}}t}} {of}"
        return rf"\frac{{\partial {of}}}{{\partial {self.symbols[look.by]}}}"

    def __call__(self, form: Form) -> str:
        """Return a form with break marks."""
        return self._write(form)

    def inline(self, form: Form) -> str:
        """Return a form in one line."""
        return self._write.unbroken(form)

    def sign(self, *forms: Form) -> str:
        r"""Return what stands before a form: "=", \approx where a number is printed with fewer digits than it has."""
        numbers = [abs(number.value) for form in forms for number in form.numbers]
        exact = replace(self._write, decimal=".")
        return "=" if all(_is_whole(exact.number(value), value) for value in numbers) else r"\approx"

    def formula(self, formula: Formula) -> tuple[str, str]:
        """Return (left, "= right") of a formula, with break marks."""
        if not formula.left:
            assert formula.right is not None, "a formula without a name on the left has two sides"
            return "", f"{self(formula.form)} {BREAK}{self.sign(formula.form, formula.right)} {self(formula.right)}"
        chain = f"{self.sign(formula.form)} {self(formula.form)}"
        if formula.right is not None:
            chain += f" {BREAK}{self.sign(formula.form, formula.right)} {self(formula.right)}"
        return self.symbols[formula.left], chain

    def braced(self, formula: Braced) -> tuple[str, str]:
        r"""Return (left, "= right") with \underbrace{coefficient}_{name} rate, as (5.40)."""
        text = ""
        for brace in formula.terms:
            sign, shown = "+", self.inline(brace.form)
            if brace.under:
                sign, shown = self._write.underbraced(brace.form, self.symbols[brace.under])
            rate = self.inline(brace.rate)
            shown += "" if rate == "1" else rf"\, {rate}"
            text += f" {BREAK}{sign} {shown}" if text else f"{sign.removeprefix('+')}{shown}"
        sign = self.sign(*(brace.form for brace in formula.terms))
        return self(formula.left), f"{sign} {text or '0'}"

    def matrix(self, matrix: Matrix) -> str:
        r"""Return left &= \begin{bmatrix} ... \end{bmatrix}, with \approx where a number is rounded."""
        cells = [self.inline(entry) for entry in matrix.entries]
        rows = r" \\ ".join(" & ".join(cells[k : k + matrix.width]) for k in range(0, len(cells), matrix.width))
        return rf"{self.symbols[matrix.left]} &{self.sign(*matrix.entries)} \begin{{bmatrix}} {rows} \end{{bmatrix}}"

    def named_matrix(self, matrix: Matrix) -> tuple[list[list[str]], list[tuple[str, str]]]:
        """Return the rows of a matrix with entries by name, zeros as they are, and (name, "= entry") of the others."""
        shown = [self.symbols[name] if x.terms else "0" for name, x in zip(matrix.names, matrix.entries, strict=True)]
        pairs = zip(matrix.names, matrix.entries, strict=True)
        rows = [shown[k : k + matrix.width] for k in range(0, len(shown), matrix.width)]
        return rows, [(self.symbols[name], f"{self.sign(x)} {self(x)}") for name, x in pairs if x.terms]

    def written(self, value: float) -> str:
        """Return a number of prose."""
        return written(value, self.decimal)

    def words(self, words: Words, plain: Callable[[str], str]) -> str:
        """Return prose, each piece made plain for its target, with forms between dollar signs."""
        return "".join(plain(x) if isinstance(x, str) else f"${self.inline(x)}$" for x in words.parts)


def _is_whole(text: str, value: Fraction) -> bool:
    """Tell whether a number is printed with all of its digits."""
    found = re.fullmatch(r"([\d.]+)(?: \\cdot 10\^\{(-?\d+)\})?", text)
    return found is None or Fraction(found[1]) * Fraction(10) ** int(found[2] or 0) == value


def written(value: float, decimal: str = ".") -> str:
    """Return a number of prose, with four significant digits, a true minus and the language's decimal mark."""
    text = in_digits(0.0 if abs(value) < 1e-12 else value, DIGITS)
    mantissa, _, exponent = text.partition("e")
    mantissa = mantissa.replace(".", decimal)
    return (f"{mantissa} · 10^{int(exponent)}" if exponent else mantissa).replace("-", "−")


def about(value: float, decimal: str = ".") -> str:
    """Return a number as it is written, after ≈ where digits are left out."""
    text = written(value)
    exact = abs(float(text.replace("−", "-").replace(" · 10^", "e")) - value) <= 1e-12 * abs(value)
    return written(value, decimal) if exact else f"≈ {written(value, decimal)}"


def equals(value: float, decimal: str = ".") -> str:
    """Return what follows a name: "= 3", or "≈ 3.142"."""
    text = about(value, decimal)
    return text if text.startswith("≈") else f"= {text}"


def letter(look: Letter) -> str:
    r"""Return \dot x_{2}, v_{2}^{2} or \bar F_{22}^{A}."""
    shown = PrintName.of(look.letter, *map(_index, look.index))
    if look.dots:
        return shown.accented("d" * look.dots + "ot")
    text = shown.accented(look.accent) if look.accent else str(shown)
    if look.above:
        return f"{text}^{{{look.above}}}"
    return text + (f"^{look.power}" if look.power > 1 else "")


def _index(part: str) -> str:
    if part in GREEK:
        return f"\\{part}"
    if part.replace(" ", "").isdigit():
        return part.replace(" ", r"\,")
    return part if len(part) <= 2 else rf"\mathrm{{{in_latex(part)}}}"
