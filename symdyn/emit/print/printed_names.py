r"""How names look in print: `I1xx` is I_{1,xx}, `theta1` is θ_1, whatever the name is in code.

Pages introduce letters beside the scene's own: K for the kinetic energy, x_2 for a place, I_1 for an inertia. A scene
may call a stiffness K and a coordinate x1. A family of quantities that would print as one of its symbols takes its next
letters, all of it together: places x_i, y_i, z_i become X_i, Y_i, Z_i. No two families share a letter, so every name on
a page means one thing. Lessons print a parameter with another index instead where it has a letter of every textbook.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain, count
from typing import ClassVar

from symdyn.emit.print.breaking import together
from symdyn.emit.render import in_latex
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import GREEK, LatexSymbol, acceleration_name, velocity_name
from symdyn.unlocked import cached_property

AXES = "(?:xx|yy|zz|xy|xz|yz|yx|zx|zy|x|y|z)"

ANGLES = {"th": "theta", "ph": "phi", "ps": "psi", "al": "alpha", "be": "beta", "ga": "gamma", "de": "delta"}
"""Greek letters of angles by two of theirs; other names of two letters are a letter and its index."""


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
    def of_latex(cls, latex: str) -> PrintName:
        """Return LaTeX as head and subscript, where a letter has one."""
        parts = re.fullmatch(r"(\\?[A-Za-z]+)_(?:\{((?:[^{}]|\{[^{}]*\})*)\}|(\w))", latex)
        return cls(parts[1], parts[2] or parts[3]) if parts else cls(latex)

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
        if first in GREEK or len(first) == 1:
            head = _upright(first)
        elif len(first) == 2 or re.fullmatch(f"[Im]{AXES}", first):
            head, rest = first[0], [first[1:], *rest]
        else:
            head = f"\\mathit{{{first}}}"
        return cls(head, ",".join(map(_upright, rest)))

    def __str__(self) -> str:
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
        unsaid = _of_frame if name in velocities else PrintName.of_code
        shown = PrintName.of_latex(latex) if latex else unsaid(name)
        if LatexSymbol(str(shown)).letters in taken:
            shown = PrintName(f"\\mathtt{{{in_latex(name)}}}")
        taken.add(LatexSymbol(str(shown)).letters)
        found[name] = str(shown)
        return shown

    for joint, coordinate, unit in SceneUnits(scene).each_coordinate():
        greek = ANGLES.get(re.split("[0-9_]", coordinate)[0]) if unit == "rad" else None
        latex = dict(joint.latex).get(coordinate) or (greek and str(PrintName.of_code(greek + coordinate[2:])))
        shown, rate = enter(coordinate, latex), velocity_name(coordinate)
        found[rate] = shown.accented("dot")
        if rate in velocities:
            found[acceleration_name(rate)] = shown.accented("ddot")
    for velocity in scene.velocities:
        if velocity not in found:
            shown = enter(velocity)
            found[acceleration_name(velocity)] = shown.accented("dot")
    taken.update(LatexSymbol(one).letters for one in found.values())
    entered: dict[str, PrintName] = {}
    for letter in (*scene.parameters, *scene.given):
        entered[letter.name] = entered[letter.of] if letter.of else enter(letter.name, letter.latex)
        if letter.of:
            second = letter.of in scene.rates.values()
            found[letter.name] = entered[letter.of].accented("ddot" if second else "dot")
    rates = {acceleration_name(name): name for name in entered}
    for name in (*(acceleration_name(state.name) for state in scene.states), *filter(None, scene.drives), *others):
        if name in rates:
            found.setdefault(name, entered[rates[name]].accented("dot"))
        elif name not in found:
            enter(name)
    for name in moving:
        shown, rate = enter(name), velocity_name(name)
        found |= {rate: shown.accented("dot"), acceleration_name(rate): shown.accented("ddot")}
    return found


def _of_frame(velocity: str) -> PrintName:
    r"""Return \omega_{x,joint} of joint_wx and v_{x,joint} of joint_vx, which are along a joint's own axes."""
    found = re.fullmatch(r"(\w+)_([vw])([xyz])", velocity)
    if found is None:
        return PrintName.of_code(velocity)
    joint, kind, axis = found.groups()
    index = [axis, *re.findall(r"[A-Za-z]+|\d+", joint)]
    return PrintName("v" if kind == "v" else r"\omega", ",".join(map(_upright, index)))


RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
LETTERS = {"°": r"{}^{\circ}", "%": r"\%", "μ": r"\mu ", "Ω": r"\Omega "}
UNIT = rf"([A-Za-z{''.join(LETTERS)}]+)(?:(?:\^|\*\*)?(-?\d+))?|([/()1])|[*·⋅ ]"


def latex_unit(unit: str) -> str:
    r"""Return a unit such as "kg m^2", "m/s²" or "N·m/(rad s)" upright, with thin spaces; other text as it stands."""
    plain = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", lambda raised: f"^{raised[0].translate(RAISED)}", unit)
    plain = unicodedata.normalize("NFKC", plain)  # one µ, one Ω
    text, at = "", 0
    while at < len(plain):
        token = re.compile(UNIT).match(plain, at)
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


EXPONENTS = {"λ": "lambda", "κ": "kappa", "σ": "sigma", "χ": "chi", "ζ": "zeta", "η": "eta"}
"""Letters of a growth, by what they are called."""

_TAG = r"\d+[a-h]?"  # of a mass: its body, and a letter where the body has several
_AXIS = "[xyz]"
_JOINT = "{joints}"

NOBODY = "(?!)"
"""The pattern of no index at all."""

_LENGTH = "length"
_COSINES = "direction cosines"


@dataclass(frozen=True)
class Family:
    """Quantities that share their letters.

    Attributes:
        of: what they are.
        index: what stands below the letter, indices side by side; `{joints}` for the names of joints, `{slides}` for
            the numbers of velocities in m/s, `{struts}` for the names of struts between points.
        choices: letters, the first wanted most; each choice has as many.
        requested: what pages ask for them by, where that is not the letters wanted most.
    """

    of: str
    index: str
    choices: tuple[tuple[str, ...], ...]
    requested: tuple[str, ...] = ()

    def pattern(self, places: Mapping[str, str]) -> str:
        """Return the pattern of its indices in a scene, where each place of `index` has one of some names."""
        return self.index.format(**{key: f"(?:{some or NOBODY})" for key, some in places.items()})


KINETIC = Family("kinetic energies", rf"|{_TAG}(?:h|omega)?|{_JOINT}", (("K",), ("T",)))
POTENTIAL = Family("potential energies, direction cosines", rf"|{_TAG}|E|\d+|0j|j[0e]", (("P",), ("U",), ("Pi",)))
LAGRANGIAN = Family("the Lagrangian", "", (("L",), ("Lambda",)))
COEFFICIENTS = Family("coefficients", r"[zDGE]\d+|C\d+", (("k",), ("kappa",)))
TEXTBOOK = (KINETIC, POTENTIAL, LAGRANGIAN, COEFFICIENTS)
"""Families whose letter every reader knows."""

FAMILIES = (
    Family("places", rf"{_TAG}|0j", (("x", "y", "z"), ("X", "Y", "Z"), ("xi", "eta", "zeta"))),
    Family("speeds", _TAG, (("v",), ("V",), ("nu",))),
    KINETIC,
    POTENTIAL,
    LAGRANGIAN,
    Family("the energy of all", "", (("E",), ("H",), ("Xi",))),
    Family("angular velocities", rf"{_TAG}{_AXIS}?|\d+|0j|[sun]\d*", (("omega",), ("Omega",))),
    Family("moments of inertia", r"\d+[a-h]?\d*|jj|[xyz]", (("I",), ("J",), ("Theta",))),
    Family("masses that slides move, a number of reactions", "{slides}|R", (("m",), ("mu",))),
    Family("distances", r"\d+[a-h]?\d*|\d+[OT]\d+|[0j][OT]?j|je", (("r",), ("rho",), ("R",))),
    Family("induced forces", r"\d+", (("N",), ("Gamma",))),
    Family("moments and forces", rf"[zGD]\d+|{_JOINT}{_AXIS}|jj?yy|0j|jj|je|ee|[xyz]", (("M", "F"), ("Psi", "Phi"))),
    Family("other reactions", rf"{_JOINT}\d+", (("R",), ("Upsilon",))),
    Family("driving forces", rf"\d+|{_JOINT}\d+", (("tau",), ("sigma",), ("theta",))),
    Family("sums of acting forces", r"\d+", (("S",), ("Sigma",))),
    Family("generalized forces", r"\d+|i", (("Q",), ("Z",))),
    Family("any coordinate", "i", (("q",), ("s",))),
    Family("direction cosines of neighbours", rf"|\d+(?:{_AXIS}{_AXIS})?", (("C",), ("D",)), (_COSINES,)),
    Family("multipliers", r"\d+|[nt]\d*", (("lambda",), ("upsilon",))),
    Family("weights", _TAG, (("G",), ("W",))),
    Family("lengths of springs and dampers", "{struts}", (("s",), ("l",), ("zeta",)), (_LENGTH,)),
    Family("counts of bodies, freedoms, classes and joints", r"t?", (("n", "u", "t", "s"), ("n", "u", "t", "d"))),
    Family("coefficients of a loop", r"\d*", (("A", "B", "C"), ("U", "V", "W"))),
    Family("origins", r"\d+", (("O",), ("o",))),
    Family("products of inertia, of Delassus", r"xy|xz|yz|(?:[nt][nt])?\d*", (("D",), ("Delta",))),
    COEFFICIENTS,
    Family("conditions and slips", r"\d+", (("f", "c"), ("h", "b"))),
    Family("slopes of conditions", r"|\d+", (("J",), ("Gamma",))),
    Family("matrices of a system", "", ((r"\mathcal{B}",), (r"\mathcal{C}",))),
    Family("ratios of velocities", r"\d+", (("Y",), ("i",))),
    Family("roots", r"|\d+", (("w",), ("chi",))),
    Family("angular momenta", rf"{_TAG}{_AXIS}", (("H",), ("D",), ("Xi",))),
    Family("momenta", r"\d+", (("p",), ("pi",))),
    Family("right-hand sides of accelerations", r"|\d+", (("h",), ("eta",))),
    Family("gaps", r"|\d+", (("g",), ("delta",), ("epsilon",))),
    Family("percussions", r"[nt]?\d*", (("Lambda",), ("Pi",), ("Psi",), ("Upsilon",))),
    Family("right-hand sides with multipliers, sums of squares", r"|\d+|[su]", (("b",), ("beta",))),
)


@dataclass(frozen=True)
class Letters:
    """The letters of one page, beside the symbols of its scene.

    Attributes:
        scene: the mechanism.
        LENGTH, COSINES: what pages ask for the letter of a strut's length, of a matrix of a neighbour's axes by.
    """

    scene: Scene
    LENGTH: ClassVar[str] = _LENGTH
    COSINES: ClassVar[str] = _COSINES

    def __getitem__(self, letter: str) -> str:
        """Return what stands for a family's wanted letter: a Latin letter, a Greek name, or LaTeX with a backslash."""
        return self._chosen.get(letter, letter)

    def latex(self, letter: str) -> str:
        """Return what stands for a family's wanted letter in LaTeX."""
        return head(self[letter])

    def coefficient(self, kind: str, indices: Sequence[int]) -> str:
        """Return a coefficient in LaTeX with the letter of this page; see `coefficient_index`."""
        return f"{self.latex('k')}_{{{coefficient_index(kind, indices)}}}"

    @cached_property
    def mass_matrix(self) -> str:
        """Letter of mass matrices: M, in bold type beside a mass M."""
        return r"\mathbf{M}" if "M" in latex_symbols(self.scene).values() else "M"

    @cached_property
    def exponent(self) -> str:
        """Letter λ of a motion that goes like exp λt, or another where the scene has it."""
        taken = self._taken()
        return next(one for one, name in EXPONENTS.items() if name not in taken)

    def circular(self, choices: Sequence[str]) -> str:
        """Return the first pair of letters that no symbol has with the number of a joint, "" for none."""
        taken = [bare(one) for pair in latex_symbols(self.scene).items() for one in pair]
        return next((letters for letters in choices if not _any(letters, r"\d+", taken)), "")

    @staticmethod
    def body_number(j: int) -> int:
        """Return the number of body j of a scene, from 1, as its mass has; the ground is 0, in the textbook 1."""
        return j + 1

    @cached_property
    def _chosen(self) -> dict[str, str]:
        taken, used, found = self._taken(), set[str](), dict[str, str]()
        for family in FAMILIES:
            index = family.pattern(self._places)
            if index == f"(?:{NOBODY})":  # it has no member, and leaves its letters to others
                continue
            letters = next(
                one for one in _offered(family.choices) if not used & set(one) and not _any(one, index, taken)
            )
            used |= set(letters)
            found |= dict(zip(family.requested or family.choices[0], letters, strict=True))
        return found

    @cached_property
    def _places(self) -> Mapping[str, str]:
        scene = self.scene
        units = SceneUnits(scene).velocities
        return {
            "joints": "|".join(re.escape(bare(one.name)) for one in (*scene.joints, *scene.loops)),
            "slides": "|".join(str(i) for i, unit in enumerate(units, 1) if unit == "m"),
            "struts": "|".join(re.escape(bare(one.name)) for one in scene.struts if one.ends),
        }

    def apart(self) -> dict[str, str]:
        """Return LaTeX with one more index for each parameter that prints as a letter of `TEXTBOOK`, by name."""
        symbols, found = latex_symbols(self.scene), dict[str, str]()
        for name in (parameter.name for parameter in self.scene.parameters):
            if self._clashes(symbols[name]):
                shown = PrintName.of_latex(symbols[name])
                index = (",".join(filter(None, (shown.subscript, "p" * k))) for k in count(1))
                offered = (str(replace(shown, subscript=one)) for one in index)
                found[name] = next(x for x in offered if x not in symbols.values() and not self._clashes(x))
        return found

    def _clashes(self, latex: str) -> bool:
        return any(_any(one.choices[0], one.pattern(self._places), [bare(latex)]) for one in TEXTBOOK)

    def _taken(self) -> list[str]:
        """Return the scene's symbols as they print, but for a drive tau_i of velocity i, which pages mean too."""
        own = {drive for i, drive in enumerate(self.scene.drives, 1) if drive and bare(drive) == f"tau{i}"}
        return [bare(shown) for name, shown in latex_symbols(self.scene).items() if name not in own]


def coefficient_index(kind: str, indices: Sequence[int]) -> str:
    """Return z,12 or C,1,23 or D,12 or G,1 below the letter of a coefficient; indices of ten and more are set apart."""
    first, *rest = map(str, indices)
    return f"{kind[-1]},{first},{together(rest)}" if len(rest) > 1 else f"{kind[-1]},{together([first, *rest])}"


def bare(latex: str) -> str:
    r"""Return a symbol as letters and digits alone: \mathit{l}_{1,x} is l1x."""
    return re.sub(r"\\(?:mathrm|mathit|text[a-z]*|operatorname)(?![A-Za-z])|[^A-Za-z0-9]", "", latex)


def _offered(choices: tuple[tuple[str, ...], ...]) -> Iterator[tuple[str, ...]]:
    """Yield the choices, then sans serif letters without end."""
    initials = [letter[0] for letter in choices[0]]
    return chain(choices, (tuple(rf"\mathsf{{{x * times}}}" for x in initials) for times in count(1)))


def _any(letters: Sequence[str], index: str, taken: Sequence[str]) -> bool:
    """Tell whether a letter with one of its indices prints as a symbol that is taken."""
    starts = tuple(map(bare, letters))
    near = [symbol for symbol in taken if symbol.startswith(starts)]  # most families have none, and need no pattern
    pattern = rf"(?:{'|'.join(map(re.escape, starts))})(?:{index})"
    return any(re.fullmatch(pattern, symbol) for symbol in near)
