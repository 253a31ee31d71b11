r"""The mathematics of a document in LaTeX, which every format starts from: names, formulas, lines that fit.

MathML is made by latex2mathml, with what browsers need beside it: spaces around functions, low accents, lines. Lessons
hold thousands of formulas, so the markup is short: thin spaces stand in the tokens beside them, as characters.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import cache
from itertools import accumulate
from xml.etree import ElementTree

from symdyn.algebra import Form
from symdyn.emit import in_html, in_latex
from symdyn.emit.print import BREAK, Latex, PrintName, latex_symbols, latex_width
from symdyn.errors import EmitError
from symdyn.extras import install
from symdyn.frozen import dataclass, replace
from symdyn.rounding import digits_or, in_digits
from symdyn.scene.values import GREEK
from symdyn.teach.document import Braced, Document, Formula, Letter, Matrix, Name, Rate, Words
from symdyn.teach.languages import language_of

DIGITS = 4  # of numbers in prose
LARGEST = 60  # denominator of a fraction that no decimal writes: 1/24


@dataclass(frozen=True)
class _Fractions(Latex):
    """Writes 1/24 as it is, which six digits do not, and decimals as the language does."""

    decimal: str = "."  # what stands before them

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


def eigenvalues(values: Iterable[complex], written: Callable[[float], str]) -> str:
    """Return eigenvalues in print, 1/s, of a pair the one above; "0" where there are none."""
    told = []
    for x in values:
        real = written(x.real) if not x.imag or abs(x.real) > 1e-9 * abs(x) else ""
        told.append(f"{real} ± {written(x.imag)} i".strip() if x.imag else real)
    return "; ".join(told) or "0"


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
        return shown.accented("d" * look.dots + "ot") + (f"^{{{look.above}}}" if look.above else "")
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


BRACKET = 150.0  # pt at 10 pt: what is no longer stays in one line, which a phone has room for
PART = " <wbr>"  # the space belongs to the line that ends
NAMES = "sin|cos|tan|tanh|exp|ln|max|min|operatorname{[a-z]+}"
_BEFORE = re.compile(rf"(?<=[\w}})]) (?=\\(?:{NAMES})(?![a-z]))")
_AFTER = re.compile(rf"(\\(?:{NAMES})(?:\^(?:\d|{{\d+}}))?) (?=[\w\\])")
_ACCENTED = re.compile(r"<mover>((?:(?!</?mover>).)*)<mo>([¨˙])</mo></mover>")
_BRACED = re.compile(r"<munder><munder>(.*?)<mo>⏟</mo></munder>")
_NUMBERED = re.compile(r"&#x0*([0-9A-Fa-f]+);")
_DECIMAL = re.compile(r"\d+\.\d+(?![\de])")  # not the width of a space, 0.167em
_OPERATOR = re.compile(r"\s*([=+-]|\\approx(?![A-Za-z])|)\s*(.*?)\s*", re.DOTALL)
_THIN = '<mspace width="0.167em" />'
_THIN_AFTER = re.compile(rf"(<mn>[^<]*|<mi>[^<]{{2,}})(</m[in]>){_THIN}")
_THIN_RAISED = re.compile(rf"(<mn>[^<]*)(</mn></m(?:sup|sub|subsup)>){_THIN}")
_THIN_BEFORE = re.compile(rf"{_THIN}((?:<m(?:sup|row)>)*<mi>)(?=[a-z]{{2}})")
_NAMED = re.compile(r"<mo /><mrow>((?:<m[in]>\w</m[in]>)+)</mrow>")
_ALONE = re.compile(r"<mrow>(<m[ino]>[^<]*</m[ino]>)</mrow>")
_WRAPPED = re.compile(r"<math[^>]*><mrow>(.*)</mrow></math>", re.DOTALL)


def inline(latex: str) -> str:
    """Return a formula that stands in a line of text."""
    return f"<math>{inner(latex)}</math>"


def flow(left: str, right: str) -> str:
    r"""Return "left = right" in pieces, between which lines may part: terms, and terms in brackets that are long."""
    return PART.join(pieces(left, right))


def pieces(left: str, right: str) -> list[str]:
    r"""Return "left", where there is one, and the terms of "= right"."""
    shown = [inline(left)] if left else []
    term: list[str] = []
    depth = 0
    for piece in _whole(right.split(BREAK)):
        found = _OPERATOR.fullmatch(piece)
        assert found is not None, "a pattern of any text"
        sign, rest = found[1].replace("-", "−").replace(r"\approx", "≈"), found[2]
        term.append(f"{sign} {inline(rest)}" if sign else inline(rest))
        depth += _depths(piece)[-1]
        if depth <= 0:
            shown.append(term[0] if len(term) == 1 else f'<span class="term">{PART.join(term)}</span>')
            term = []
    return [*shown, *term]


def _whole(pieces: list[str]) -> list[str]:
    """Return the pieces with short brackets put together."""
    found = [pieces[-1]]
    for piece in reversed(pieces[:-1]):
        found.append(piece)
        while (count := _closing(found)) and latex_width(whole := "".join(reversed(found[-count:]))) <= BRACKET:
            found[-count:] = [whole]
    return found[::-1]


def _closing(pieces: list[str]) -> int:
    """Return how many pieces, the last first, close a bracket that the last one opens; 0 where it opens none."""
    depth = inside = _depths(pieces[-1])[-1]
    if depth > 0:
        for count, piece in enumerate(reversed(pieces[:-1]), 2):
            depths = _depths(piece)
            if inside + min(depths) < depth:
                return count
            inside += depths[-1]
    return 0


def _depths(piece: str) -> list[int]:
    """Return the depth of brackets before and behind each of them."""
    return [0, *accumulate(1 if x == "(" else -1 for x in piece if x in "()")]


def inner(latex: str) -> str:
    """Return the MathML of a formula without the element around it; formulas that differ in decimals alone share one.

    Raises:
        EmitError: latex2mathml is not installed.
    """
    decimals = iter(_DECIMAL.findall(latex))
    return _DECIMAL.sub(lambda _: next(decimals), _inner(_DECIMAL.sub("0.0", latex)))


@cache
def _inner(latex: str) -> str:
    """Return the MathML of a formula in which decimals are 0.0."""
    try:
        from latex2mathml.converter import convert
    except ModuleNotFoundError as fault:
        raise EmitError(f"mathematics in HTML needs latex2mathml: {install('teach')}") from fault
    if not latex.strip():
        return ""
    spaced = _AFTER.sub(r"\1 \\, ", _BEFORE.sub(r" \\, ", latex))
    found = _WRAPPED.fullmatch(convert(spaced))
    assert found is not None, "latex2mathml writes one mrow in one math element"
    text = _NUMBERED.sub(_character, found[1])
    text = _BRACED.sub(r'<munder><mrow class="brace">\1</mrow>', text)  # a glyph that browsers stretch in part only
    text = text.replace('<mo stretchy="true" fence="true" minsize', "<mo minsize")
    text = _NAMED.sub(lambda found: f"<mi>{_TAG.sub('', found[1])}</mi>", text)  # atan2
    text = _ALONE.sub(r"\1", text)
    text = _THIN_BEFORE.sub("\\1\u2009", _THIN_AFTER.sub("\\1\u2009\\2", text))
    text = _THIN_RAISED.sub("\\1\u2005\\2", text)  # as wide, in smaller type
    text = _ACCENTED.sub(_dotted, text)
    return f"<mrow>{text}</mrow>" if "<mtable" in text else text  # Firefox stretches no bracket in math itself


def _dotted(match: re.Match[str]) -> str:
    """Return a base with dots: low ones on a letter, above a word where they are none of its own letters'."""
    word = match[1].count("<mi") > 1
    low = "" if word else ' accent="true"'
    return f"<mover{low}>{match[1]}<mo>{match[2]}</mo></mover>"


def _character(match: re.Match[str]) -> str:
    character = chr(int(match[1], 16))
    return match[0] if character in "<>&" else character


# What a screen reader says: names of formulas (browsers make none of `alttext`), hidden words in heads of tables

_MATH = re.compile(r"<math>(.*?)</math>", re.DOTALL)
_HEAD = re.compile(r"<th(| [^>]*)>((?:(?!</th>).)*?</math>)</th>", re.DOTALL)
_TAG = re.compile(r"<[^>]*>")
DOTS = {"˙": "dot", "¨": "dots", "¯": "bar"}
SIGNS = {"+": "plus", "−": "minus", "=": "equal", "≈": "about", "∂": "partial", "⋅": "times", "·": "times"}


def with_words(page: str, words: Mapping[str, str]) -> str:
    """Return a page whose formulas say in words what they show; `words` by the keys "say_…" of a language's page."""
    said: dict[str, str] = {}

    def text(inside: str) -> str:
        if inside not in said:
            said[inside] = in_html(_said(ElementTree.fromstring(f"<math>{inside}</math>"), words))
        return said[inside]

    def head(found: re.Match[str]) -> str:
        if _TAG.sub("", _MATH.sub("", found[2])).strip():
            return found[0]
        label = " ".join(text(inside) for inside in _MATH.findall(found[2]))
        return f'<th{found[1]}><span class="said">{label}</span><span aria-hidden="true">{found[2]}</span></th>'

    page = _HEAD.sub(head, page)
    return _MATH.sub(lambda found: f'<math aria-label="{text(found[1])}">{found[1]}</math>', page)


def _said(element: ElementTree.Element, words: Mapping[str, str]) -> str:
    """Return an element in words."""
    parts = [_said(child, words) for child in element]
    tag, own = element.tag, (element.text or "").strip()
    if not parts:
        return words[f"say_{SIGNS[own]}"] if own in SIGNS else own
    if tag == "mfrac":
        return f"{_grouped(parts[0])} {words['say_over']} {_grouped(parts[1])}"
    if tag == "msqrt":
        return f"{words['say_root']} {_grouped(' '.join(parts))}"
    if tag == "mover" and parts[1] in DOTS:
        return f"{parts[0]} {words[f'say_{DOTS[parts[1]]}']}"
    if tag in ("msup", "msubsup"):
        base, power = " ".join(parts[:-1]), parts[-1]
        return f"{base} {words['say_squared']}" if power == "2" else f"{base} {words['say_power']} {power}"
    return " ".join(filter(None, parts))


def _grouped(text: str) -> str:
    """Return what is more than one word in brackets, so that it is heard where it ends."""
    return f"({text})" if " " in text else text
