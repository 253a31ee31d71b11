"""Names as they are lettered in a picture: q1 is an italic q with a subscript, words stay words."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from itertools import groupby

from symdyn.emit import in_html
from symdyn.emit.print import PrintName
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
        """The characters alone."""
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
        """Return the tspans."""
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
            slanted = "i" if not face and len(text) == 1 and text.isalpha() and not _capital(text) else ""
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


def _capital(letter: str) -> bool:
    """Return whether it is a Greek capital, which is upright."""
    return letter.isupper() and "GREEK" in unicodedata.name(letter, "")


def _wide(run: LetterRun) -> float:
    """Return the width in heights of the line of a wide serif type."""
    total = 0.0
    for character in run.text:
        if unicodedata.combining(character):
            continue
        narrow, broad = character in "iljtfrI.,' ·′|", character in "mwMW@"
        total += 0.4 if narrow else 0.95 if broad else 0.76 if character.isupper() else 0.62
    return total
