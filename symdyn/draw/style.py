"""The looks of pictures: colours for light and dark, the same shapes in both, light in print; and names as lettered.

In a picture q1 is an italic q with a subscript, words stay words. What draws without a browser reads the style sheet
rule by rule: which colours and lines an element has.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from functools import cache
from itertools import groupby

from symdyn.emit import in_html
from symdyn.emit.print import PrintName
from symdyn.errors import DrawError, choice
from symdyn.frozen import dataclass
from symdyn.scene.values import GREEK
from symdyn.unlocked import cached_property

FONT = 17.0  # units of the picture
SMALL = 0.7  # size of a subscript
DROP = 0.28  # how far it is set down, in heights of the line

TOKEN = re.compile(r"\\([A-Za-z]+)\s?|\\(.)|([_^])|([{}])|(.)", re.DOTALL)
FACES = {"mathit": "i", "mathrm": "", "mathtt": "t", "text": "", "mathsf": "", "operatorname": "", "textit": "i"}
FACES |= {"mathbf": "", "boldsymbol": "i", "mathcal": "i", "textrm": ""}
ACCENTS = {"vec": "\u20d7", "dot": "\u0307", "ddot": "\u0308", "hat": "\u0302", "bar": "\u0304", "tilde": "\u0303"}
ACCENTS |= {"check": "\u030c", "breve": "\u0306", "acute": "\u0301", "grave": "\u0300", "overline": "\u0305"}
ACCENTS |= {"widehat": "\u0302", "widetilde": "\u0303", "underline": "\u0332"}
SIGNS = {"cdot": "·", "times": "×", "circ": "°", "infty": "∞", "pm": "±", "prime": "′", "quad": " ", "ast": "∗"}
SIGNS |= {"star": "⋆", "bullet": "•", "dagger": "†", "ddagger": "‡", "perp": "⟂", "parallel": "∥", "mp": "∓"}
SIGNS |= {"partial": "∂", "nabla": "∇", "ell": "ℓ", "hbar": "ℏ", "imath": "ı", "jmath": "ȷ", "Re": "ℜ", "Im": "ℑ"}
SIGNS |= {"varpi": "ϖ", "varsigma": "ς"}
LEGAL = {"var" + name: name for name in ("theta", "phi", "epsilon", "rho")}


@dataclass(frozen=True)
class LetterRun:
    """Characters of one face ("i", "t" or ""), on level -1 (subscript), 0 or 1."""

    text: str
    face: str
    level: int


@dataclass(frozen=True)
class Text:
    """A lettered name."""

    runs: tuple[LetterRun, ...]

    @property
    def spoken(self) -> str:
        """What a screen reader says: the letter, then what stands below or above it."""
        return " ".join(run.text for run in self.runs)

    @property
    def plain(self) -> str:
        return "".join(run.text for run in self.runs)

    @cached_property
    def width(self) -> float:
        """An estimate, on the wide side, in units of the picture."""
        return FONT * sum(_wide(run) * (SMALL if run.level else 1.0) for run in self.runs)

    @property
    def lowered(self) -> bool:
        """Whether something hangs below the line."""
        return any(run.level < 0 for run in self.runs)

    def with_unit(self, unit: str) -> Text:
        """Return the words of an axis with its unit behind, as they are where it has none."""
        return Text((*self.runs, LetterRun(f", {unit}", "", 0))) if unit else self

    def svg(self) -> str:
        pieces, level = [], 0
        for run in self.runs:
            shift = (level - run.level) * DROP * FONT
            level = run.level
            attributes = f' class="{run.face}"' if run.face else ""
            attributes += f' dy="{shift:.2f}"' if shift else ""
            attributes += f' font-size="{SMALL * FONT:.1f}"' if run.level else ""
            text = in_html(run.text)
            pieces.append(f"<tspan{attributes}>{text}</tspan>" if attributes else text)
        return "".join(pieces)

    @classmethod
    def of_name(cls, name: str) -> Text:
        """Return a name of code, or LaTeX such as `m_1 g`, as it is lettered."""
        if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
            return cls.of_latex(name)
        return cls.of_latex(str(PrintName.of_code(name)))

    @classmethod
    def of_part(cls, name: str) -> Text:
        """Return the name of a body or joint: a symbol where it looks like one, such as b1, else as it is written."""
        shown = PrintName.of_code(name)
        symbolic = re.fullmatch(r"[A-Za-z]|\\[A-Za-z]+", shown.head) and not re.fullmatch(r"[A-Za-z]{2}.*", name)
        return cls.of_latex(str(shown)) if symbolic else cls.as_written(name)

    @classmethod
    def of_latex(cls, latex: str) -> Text:
        """Return the LaTeX of a symbol as runs; what a name does not need is set as it stands."""
        runs: list[LetterRun] = []
        stack: list[tuple[str, int]] = [("", 0)]  # face and level of every open brace
        ahead, face_ahead, level_ahead = "", "", 0
        for command, escaped, script, brace, character in TOKEN.findall(latex):
            face, level = stack[-1]
            if script:
                level_ahead = 1 if script == "^" else -1
                continue
            if brace == "{":
                stack.append((face_ahead or face, level_ahead or level))
                face_ahead, level_ahead = "", 0
                continue
            if brace == "}":
                if len(stack) > 1:
                    stack.pop()
                continue
            if command in FACES:
                face_ahead = FACES[command] or "r"
                continue
            if command in ACCENTS:
                ahead = ACCENTS[command]
                continue
            text = _letter(command) if command else " " if escaped in (",", ";") else escaped or character
            if text == " " and character:
                continue
            text = {"-": "−", "'": "′"}.get(text, text)
            face, face_ahead = face_ahead or face, ""
            plain = face or len(text) != 1 or not text.isalpha()
            upright = plain or (text.isupper() and "GREEK" in unicodedata.name(text, ""))
            slanted = "" if upright else "i"
            runs.append(LetterRun(text + ahead, (face or slanted).replace("r", ""), level_ahead or level))
            ahead, level_ahead = "", 0
        alike = groupby(runs, lambda run: (run.face, run.level))
        return cls(tuple(LetterRun("".join(run.text for run in group), face, level) for (face, level), group in alike))

    @classmethod
    def as_written(cls, text: str) -> Text:
        """Return words that are no symbol."""
        return cls((LetterRun(text, "", 0),))


def lowered(text: Text) -> float:
    """Return how far below the middle of its box the line of a name lies, in units of the picture."""
    return FONT * (0.17 if text.lowered else 0.3)


def _letter(command: str) -> str:
    command = LEGAL.get(command, command)
    if command not in GREEK:
        return SIGNS.get(command, command)
    size = "CAPITAL" if command[0].isupper() else "SMALL"
    return unicodedata.lookup(f"GREEK {size} LETTER {command.upper().replace('LAMBDA', 'LAMDA')}")


def _wide(run: LetterRun) -> float:
    """Return the width in heights of the line of a wide serif type."""
    total = 0.0
    for character in run.text:
        if unicodedata.combining(character):
            continue
        narrow, broad = character in "iljtfrI.,' ·′|", character in "mwMW@"
        total += 0.4 if narrow else 0.95 if broad else 0.76 if character.isupper() else 0.62
    return total


LIGHT = {
    "paper": "#ffffff", "ink": "#1b1f24", "soft": "#5c6672", "shade": "#e9edf2", "mark": "#00665f",
    "force": "#b3261e", "couple": "#7a3aa8", "x": "#b3261e", "y": "#1f7a3d", "z": "#2456b8",
    "body0": "#2f66b0", "body1": "#b4540f", "body2": "#2a7f50", "body3": "#98658c", "body4": "#4b3300",
    "body5": "#69003e",
}  # fmt: skip

DARK = {
    "paper": "#12171d", "ink": "#e8ebef", "soft": "#a3adb8", "shade": "#2a323c", "mark": "#58d1c4",
    "force": "#ff8a7d", "couple": "#d0a2f2", "x": "#ff8a7d", "y": "#74d394", "z": "#8db8ff",
    "body0": "#86b4f2", "body1": "#f2a06e", "body2": "#73cc9c", "body3": "#ffc8e8", "body4": "#f5ff79",
    "body5": "#a27596",
}  # fmt: skip

SCHEMES = {"light": LIGHT, "dark": DARK}

RULES = """
@media screen{.symdyn{max-width:100%;height:auto}}
.symdyn .sheet{fill:[paper]}
.symdyn path,.symdyn circle,.symdyn ellipse{fill:none;stroke:[ink];stroke-linejoin:round}
.symdyn .joint,.symdyn .com,.symdyn .ring{fill:[paper]}
.symdyn ellipse.joint,.symdyn path.joint,.symdyn .ball{fill:[shade]}
.symdyn .edge,.symdyn .inside{fill:none}
.symdyn path.inside{stroke:[shade]}
.symdyn .halo{stroke:[paper];stroke-linecap:round}
.symdyn .link{stroke-linecap:round}
.symdyn ellipse.link{stroke-width:3}
.symdyn .quarters,.symdyn .weld{fill:[ink];stroke:none}
.symdyn .stem,.symdyn .hatch,.symdyn .rail,.symdyn .flight,.symdyn .axis,.symdyn .rod,.symdyn .trace{stroke:[soft]}
.symdyn .support,.symdyn .stand,.symdyn .plate{fill:[shade];stroke:[soft]}
.symdyn .post{stroke:[soft]}
.symdyn .plate{fill-opacity:.4}
.symdyn .axis{stroke-dasharray:7 2.5 1.5 2.5}
.symdyn .axis.head{fill:[soft];stroke-dasharray:none}
.symdyn .flight,.symdyn .gap{stroke-dasharray:4 3}
.symdyn .gap{stroke:[force]}
.symdyn .mark{stroke:[mark]}
.symdyn .sense{stroke-dasharray:4 2.5}
.symdyn .head{stroke-dasharray:none}
.symdyn .mark.head{fill:[mark]}
.symdyn .zero{stroke:[soft];stroke-dasharray:3 2.5}
.symdyn .extension,.symdyn .leader{stroke:[soft]}
.symdyn .force{stroke:[force]}
.symdyn .force.head{fill:[force]}
.symdyn .couple{stroke:[couple]}
.symdyn .couple.head{fill:[couple]}
.symdyn .gravity{stroke:[ink]}
.symdyn .gravity.head{fill:[ink]}
.symdyn text{fill:[ink];font-family:serif;text-anchor:middle}
.symdyn text:nth-child(n){\
font-family:"STIX Two Text","Latin Modern Roman",Cambria,Georgia,"Times New Roman",serif}
.symdyn .mark-text{fill:[mark]}
.symdyn .force-text{fill:[force]}
.symdyn .couple-text{fill:[couple]}
.symdyn .i{font-style:italic}
.symdyn .t{font-family:monospace}
"""

"""Programs of Qt know no list of fonts and no selector that counts: they take the first of both rules for letters."""

HALO = """\
@supports (paint-order:stroke){.symdyn text{stroke:[paper];stroke-width:3;paint-order:stroke;stroke-linejoin:round}}
"""
"""Letters stand out of lines by an edge, where it is painted behind them; other programs would paint it over them."""


def plain(scheme: str) -> str:
    """Return the scheme that stands for one where there is no reader whose preference it could follow.

    Raises:
        DrawError: another scheme.
    """
    if scheme not in ("auto", *SCHEMES):
        raise DrawError(f'colour scheme "{scheme}" is unknown; {choice(scheme, ("auto", *SCHEMES))}')
    return "light" if scheme == "auto" else scheme


def style(scheme: str) -> str:
    """Return the style sheet.

    Colours are written out, and once more for the dark: programs that draw pictures outside browsers know no variables
    of CSS, and paint black what they cannot read. The scheme "auto" follows the reader's preference.

    Raises:
        DrawError: another scheme.
    """
    if scheme != "auto":
        return _coloured(SCHEMES[plain(scheme)])
    dark = "\n".join(line for line in _coloured(DARK).splitlines() if "fill:" in line or "stroke:" in line)
    return (
        f"{_coloured(LIGHT)}{HALO.replace('[paper]', LIGHT['paper'])}"
        f"@media screen and (prefers-color-scheme:dark){{\n{dark}\n{HALO.replace('[paper]', DARK['paper'])}}}\n"
    )


def _coloured(colours: dict[str, str]) -> str:
    rules = f"{RULES.strip()}\n.symdyn text{{font-size:{FONT:g}px}}\n"
    rules += "".join(
        f".symdyn .link.body{k}{{stroke:[body{k}]}}\n.symdyn .particle.body{k}{{fill:[body{k}]}}\n" for k in range(6)
    )
    rules += "".join(
        f".symdyn .triad-{a}{{stroke:[{a}]}}\n.symdyn .triad-{a}.head,.symdyn .{a}-text{{fill:[{a}]}}\n" for a in "xyz"
    )
    for name, colour in colours.items():
        rules = rules.replace(f"[{name}]", colour)
    return rules


Look = dict[str, str]


@dataclass(frozen=True)
class Rule:
    """What the style sheet says of one kind of element."""

    tag: str  # its name, "" for any
    classes: frozenset[str]  # that it must have
    look: Mapping[str, str]  # properties by name


@cache
def rules(scheme: str = "light") -> tuple[Rule, ...]:
    """Return the rules of a plain scheme, in order; "auto" is light, as it is in print.

    Raises:
        DrawError: another scheme.
    """
    found = []
    text = style(plain(scheme))
    for selectors, body in re.findall(r"^([^@{}\n][^{}]*)\{([^{}]*)\}", text, re.MULTILINE):
        look = dict(part.split(":", 1) for part in body.split(";") if ":" in part)
        for selector in selectors.split(","):
            tag, *classes = selector.split()[-1].split(".")
            found.append(Rule(tag, frozenset(classes), look))
    return tuple(found)


def look_of(tag: str, classes: str, scheme: str = "light", **own: str) -> Look:
    """Return how an element looks that has classes and attributes of its own; the style sheet has the last word."""
    having = set(classes.split())
    fitting = [rule for rule in rules(scheme) if rule.tag in ("", tag) and rule.classes <= having]
    fitting.sort(key=lambda rule: (len(rule.classes), bool(rule.tag)))  # stable: the later of two alike wins
    look: Look = dict(own)
    for rule in fitting:
        look |= rule.look
    return look
