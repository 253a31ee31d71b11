"""Letters of a lesson's page in Markdown, and where the page says what they are, as a reader sees them.

A letter is a sign with its indices: `k_{z,11}`, `\\lambda_1`, `F_{\\mathrm{axle},x}`. Dots are derivatives, and no part
of it; bars, tildes and bold type are. It is defined by

    a row of a table     the letter alone in the first cell, what it means or what it is in another
    a formula            the letter alone on the left of an equals sign, below a brace, or an entry of the matrix on
                         the right
    a sentence           the letter alone in the text, with a verb behind it, or what it is in front of it, or among
                         those that are zero

What is defined with an index i, j, k, l or e is defined with all others in its place, and what is defined, with its
components. The time is t everywhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

GREEK = (
    "alpha|beta|gamma|delta|epsilon|varepsilon|zeta|eta|theta|vartheta|iota|kappa|lambda|mu|nu|xi|rho|sigma|tau|upsilon|"
    "phi|varphi|chi|psi|omega|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Upsilon|Phi|Psi|Omega|ell"
)
GROUP = r"\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}"
SIGN = rf"(?:\\(?:{GREEK})(?![a-zA-Z])|\\math(?:rm|bf|cal|it)\{{[A-Za-z]+\}}|[A-Za-z])"
SCRIPT = rf"(?:[_^](?:{GROUP}|{SIGN}|[0-9*']))"
LETTER = re.compile(rf"(?P<mark>\\(?:tilde|bar|hat)\s*)?(?P<sign>{SIGN})(?P<scripts>{SCRIPT}*)")
HELD = re.compile(rf"(\\(?:d+ot|tilde|bar|hat))\s*\{{({SIGN}{SCRIPT}*)\}}")
WORDS = re.compile(
    rf"\\tag{GROUP}|\\(?:begin|end)\{{\w+\}}|\\mathrm\{{d\}}|\\math(?:bf|rm)\{{[01]\}}|\\(?:text|operatorname|mbox){GROUP}|"
    rf"\\(?!(?:tilde|bar|hat|math(?:rm|bf|cal|it)|{GREEK})(?![a-zA-Z]))(?:[a-zA-Z]+|.)"
)
BRACED = re.compile(rf"\\underbrace\s*({GROUP})_({GROUP})")
INLINE = re.compile(r"\$([^$]+)\$")
BEHIND = re.compile(
    r"(?:(?:,| and) \$[^$]+\$)*\s*(?:,|and|\()?\s*(?:which|t|is|are|has|have|holds|stands|means|counts|names|says|"
    r"gives|bodies|joints|moving|the|per)\b|\s*[=:≈]"
)
BEFORE = re.compile(
    r"(?:\b(?:[Tt]he|[Aa]ll|one|[Bb]ody|[Ff]rame|[Cc]lass|its|angle|[Jj]oints?) (?:[a-z]+ ){0,2}|"
    r"zero:(?: \$[^$]+\$,)* )$"
)
GENERIC = re.compile(r"(?<![A-Za-z])[ijkle](?![a-z]{2})|(?<=[TO])[ijkle]|(?<=\b[ijkle])[ijkle]\b")
COMPONENT = re.compile(r",?(?:[xyz]|\d+)$")
ENTRIES = re.compile(r"\\begin\{bmatrix\}(.*?)\\end\{bmatrix\}", re.DOTALL)
ALWAYS = "t"
ASKED = ("?", "is found like this.")
"""Ends of sentences that name what they do not explain."""


@dataclass(frozen=True, order=True)
class Letter:
    """A sign, what stands above it, and its indices: "r", "tilde", "0j", ""."""

    sign: str
    mark: str = ""
    below: str = ""
    above: str = ""

    def __str__(self) -> str:
        """Return it as it is told."""
        below, above = (f"{kind}{text}" * bool(text) for kind, text in (("_", self.below), ("^", self.above)))
        return f"{self.mark} {self.sign}{below}{above}".strip()


def letters(math: str) -> Iterator[Letter]:
    """Yield the letters of a formula in LaTeX."""
    math = BRACED.sub(r"\1 \2", math)
    for _ in range(2):
        math = HELD.sub(r"\1 \2", math)
    for found in LETTER.finditer(WORDS.sub(" ", math)):
        scripts = [(one[0], _bare(one[1:])) for one in re.findall(SCRIPT, found["scripts"])]
        above = "".join(text for kind, text in scripts if kind == "^")
        yield Letter(
            _bare(found["sign"]),
            _bare(found["mark"] or ""),
            ",".join(text for kind, text in scripts if kind == "_"),
            above if re.fullmatch(r"\*?[A-SU-Z]?", above) else "",
        )


def _bare(text: str) -> str:
    return re.sub(r"\\math(?:rm|it)|[{}\\\s]", "", text.replace("\\mathbf", "bold ").replace("\\mathcal", "script "))


@dataclass
class Page:
    """What a page uses, letters with the line in which each is used first, and what it defines."""

    used: dict[Letter, str]
    defined: set[Letter]

    def strange(self, *others: Page) -> dict[Letter, str]:
        """Return the letters that neither the page defines nor others do."""
        known = self.defined.union(*(one.defined for one in others))
        return {one: line for one, line in self.used.items() if not any(_covers(other, one) for other in known)}


def _covers(known: Letter, letter: Letter) -> bool:
    """Tell whether a definition is one of a letter, of all of its kind, or of what it is a component of."""
    marks = (letter.mark, "" if letter.mark == "tilde" else letter.mark)  # what a tilde does is said of all vectors
    if (known.sign, known.above) != (letter.sign, letter.above) or known.mark not in marks:
        return False
    if known.below == letter.below:
        return True
    pairs = (
        (known.below, letter.below),
        (known.below, COMPONENT.sub("", letter.below)),
        (COMPONENT.sub("", known.below), letter.below),
    )
    return any(a == b or _stands_for(a, b) or _stands_for(b, a) for a, b in pairs)


def _stands_for(generic: str, index: str) -> bool:
    """Tell whether an index, with others in place of i, j, k, l and e, is another one."""
    places = {found.start() for found in GENERIC.finditer(generic)}
    other = r"(?:\d+|[ijkle]|[A-Za-z]\w+),?"
    pattern = "".join(other if k in places else re.escape(x) for k, x in enumerate(generic))
    return bool(places) and bool(re.fullmatch(pattern, index))


def page_of(markdown: str) -> Page:
    """Return what a page in Markdown uses and defines, but for its appendix of what a book has wrong."""
    page = Page({}, {Letter(ALWAYS)})
    display: list[str] | None = None
    for line in markdown.partition("\n## Appendix")[0].splitlines():
        if line.strip() == "$$":
            if display is None:
                display = []
                continue
            _formula(page, " ".join(display))
            display = None
        elif display is not None:
            display.append(line)
        elif line.startswith("| "):
            _row(page, line)
        elif not line.startswith("!["):
            _prose(page, line)
    return page


def _use(page: Page, math: str, line: str) -> None:
    for letter in letters(math):
        page.used.setdefault(letter, line)


def _define(page: Page, math: str) -> None:
    """Note the letter that a piece of mathematics is, squared or with a sign in front."""
    found = list(letters(math))
    for _ in range(2):
        math = HELD.sub(r"\1 \2", math)
    rest = LETTER.sub("", WORDS.sub(" ", math))
    varied = len(found) == 2 and found[0].sign.lower() == "delta"  # a step of what stands behind it
    if (len(found) == 1 or varied) and not re.sub(r"[-−{}^2\s]", "", rest):
        page.defined.update(found)


def _formula(page: Page, math: str) -> None:
    math = re.sub(r"\\(?:begin|end)\{aligned\}|&(?==|\\approx)", "", math)
    for _, under in BRACED.findall(math):
        _define(page, under[1:-1])
    *sides, right = re.split(r" = | \\approx ", math)
    for side in sides:
        _define(page, side)
    for entries in ENTRIES.findall(right) if sides else ():
        for entry in re.split(r"&|\\\\", entries):
            _define(page, entry)
    _use(page, math, math)


def _row(page: Page, line: str) -> None:
    cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
    if re.fullmatch(r"\$[^$]+\$", cells[0]) and any(cells[1:]):
        _define(page, cells[0].strip("$"))
    for math in INLINE.findall(line):
        _use(page, math, line)


def _prose(page: Page, line: str) -> None:
    asked = line.strip("* ").endswith(ASKED)
    for found in INLINE.finditer(line):
        if not asked and (BEHIND.match(line[found.end() :]) or BEFORE.search(line[: found.start()])):
            _define(page, found[1])
        _use(page, found[1], line)
