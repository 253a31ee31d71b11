"""How names look in print: `I1xx` is I_{1,xx}, `theta1` is θ_1, whatever the name is in code."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from symdyn.emit.escape import in_latex
from symdyn.scene import Scene
from symdyn.scene.values import GREEK, LatexSymbol, acceleration_name, velocity_name

AXES = "(?:xx|yy|zz|xy|xz|yz|yx|zx|zy|x|y|z)"


@dataclass(frozen=True)
class PrintName:
    """A symbol in LaTeX: head and subscript, so that an accent sits on the head."""

    head: str
    subscript: str = ""

    @classmethod
    def of(cls, letter: str, *index: str) -> PrintName:
        """Return a letter, Greek by its name or LaTeX, with indices."""
        return cls(head(letter), ",".join(index))

    @classmethod
    def of_code(cls, name: str) -> PrintName:
        """Return how a name of code is printed.

        A Greek name becomes its letter, digits and what follows the first letter the subscript, words stay words.
        """
        inertial = re.fullmatch(rf"([Im])_?({AXES})_?(\d+)((?:_\w+)?)", name)
        if inertial:
            head, axes, digits, rest = inertial.groups()
            return cls(head, ",".join([digits, axes, *map(_upright, filter(None, rest.split("_")))]))
        words = [part for part in re.findall(r"[A-Za-z]+|\d+", name) if part]
        if not words or not name[0].isalpha():
            return cls(f"\\mathtt{{{in_latex(name)}}}")
        first, *rest = words
        if first in GREEK:
            head = f"\\{first}"
        elif len(first) == 1:
            head = first
        elif len(first) == 2 or re.fullmatch(f"[Im]{AXES}", first):
            head, rest = first[0], [first[1:], *rest]
        else:
            head = f"\\mathit{{{first}}}"
        return cls(head, ",".join(map(_upright, rest)))

    def __str__(self) -> str:
        """Return the symbol."""
        return self.head + _index(self.subscript)

    def accented(self, accent: str) -> str:
        r"""Return the symbol with an accent, such as "dot"."""
        simple = len(self.head) == 1
        return f"\\{accent}{' ' if simple else '{'}{self.head}{'' if simple else '}'}{_index(self.subscript)}"


def head(letter: str) -> str:
    """Return a letter in LaTeX; what begins with a backslash is LaTeX."""
    return f"\\{letter}" if letter in GREEK else letter


def _index(subscript: str) -> str:
    return "" if not subscript else f"_{subscript}" if len(subscript) == 1 else f"_{{{subscript}}}"


def _upright(part: str) -> str:
    if part in GREEK:
        return f"\\{part}"
    plain = part.isdigit() or len(part) == 1 or re.fullmatch(AXES, part)
    return part if plain else f"\\mathrm{{{part}}}"


def latex_symbols(scene: Scene, others: Iterable[str] = (), moving: Iterable[str] = ()) -> dict[str, str]:
    """Return LaTeX for every parameter, input, coordinate, velocity, acceleration and drive, by its name in code.

    `others` are names beside them, such as those of multipliers; `moving` those of what has a rate, as coordinates do.
    Two names that would look alike (m1 and m_1) are told apart: the later one is printed as it is written in code.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    velocities = set(scene.velocities)

    def enter(name: str, latex: str | None = None) -> PrintName:
        shown = _declared(latex) if latex else _of_frame(name) if name in velocities else PrintName.of_code(name)
        if LatexSymbol(str(shown)).letters in taken:
            shown = PrintName(f"\\mathtt{{{in_latex(name)}}}")
        taken.add(LatexSymbol(str(shown)).letters)
        found[name] = str(shown)
        return shown

    for coordinate in scene.coordinates:
        shown = enter(coordinate)
        if (velocity := velocity_name(coordinate)) in velocities:
            found[velocity] = shown.accented("dot")
            found[acceleration_name(velocity)] = shown.accented("ddot")
    for velocity in scene.velocities:
        if velocity not in found:
            shown = enter(velocity)
            found[acceleration_name(velocity)] = shown.accented("dot")
    taken.update(LatexSymbol(one).letters for one in found.values())
    for parameter in scene.parameters:
        enter(parameter.name, parameter.latex)
    for given in scene.inputs:
        enter(given.name, given.latex)
    for drive in scene.drives:
        if drive and drive not in found:
            enter(drive)
    for name in others:
        enter(name)
    for name in moving:
        found[velocity_name(name)] = enter(name).accented("dot")
    return found


def _of_frame(velocity: str) -> PrintName:
    r"""Return \omega_{x,joint} of joint_wx and v_{x,joint} of joint_vx, which are along a joint's own axes."""
    found = re.fullmatch(r"(\w+)_([vw])([xyz])", velocity)
    if found is None:
        return PrintName.of_code(velocity)
    joint, kind, axis = found.groups()
    index = [axis, *re.findall(r"[A-Za-z]+|\d+", joint)]
    return PrintName("v" if kind == "v" else r"\omega", ",".join(map(_upright, index)))


def _declared(latex: str) -> PrintName:
    parts = re.fullmatch(r"(\\?[A-Za-z]+)_(?:\{([^{}]*)\}|(\w))", latex)
    return PrintName(parts[1], parts[2] or parts[3]) if parts else PrintName(latex)


RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
LETTERS = {"°": r"{}^{\circ}", "%": r"\%", "μ": r"\mu ", "Ω": r"\Omega "}
UNIT = re.compile(rf"([A-Za-z{''.join(LETTERS)}]+)(?:(?:\^|\*\*)?(-?\d+))?|([/()1])|[*·⋅ ]")


def latex_unit(unit: str) -> str:
    r"""Return a unit such as "kg m^2", "m/s²" or "N·m/(rad s)" upright, with thin spaces; other text as it stands."""
    plain = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", lambda raised: f"^{raised[0].translate(RAISED)}", unit)
    plain = unicodedata.normalize("NFKC", plain)  # one µ, one Ω
    text, at = "", 0
    while at < len(plain):
        token = UNIT.match(plain, at)
        if token is None:
            return rf"\text{{{in_latex(unit.encode('ascii', 'replace').decode())}}}"
        letters, power, mark = token.groups()
        if letters:
            text += "" if not text or text[-1] in "/(" else r"\,"
            text += rf"\mathrm{{{''.join(LETTERS.get(letter, letter) for letter in letters).strip()}}}"
            text += f"^{{{power}}}" if power else ""
        elif mark:
            text += r"\," * (mark == "(" and bool(text) and text[-1] not in "/(") + mark
        at = token.end()
    return text
