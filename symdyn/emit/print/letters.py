r"""Letters that pages introduce beside the scene's own: K for the kinetic energy, x_2 for a place, I_1 for an inertia.

A scene may call a stiffness K and a coordinate x1. A family of quantities that would print as one of its symbols takes
its next letters, all of it together: places x_i, y_i, z_i become X_i, Y_i, Z_i. No two families share a letter, so
every name on a page means one thing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, count
from typing import ClassVar

from symdyn.emit.print.breaking import together
from symdyn.emit.print.printed_names import head, latex_symbols
from symdyn.scene import Scene, SceneUnits
from symdyn.unlocked import cached_property

_TAG = r"\d+[a-h]?"  # of a mass: its body, and a letter where the body has several
_AXIS = "[xyz]"
_JOINT = "{joints}"

NOBODY = "(?!)"
"""The pattern of no index at all."""

_LENGTH = "length"


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


FAMILIES = (
    Family("places", rf"{_TAG}|0j", (("x", "y", "z"), ("X", "Y", "Z"), ("xi", "eta", "zeta"))),
    Family("speeds", _TAG, (("v",), ("V",), ("nu",))),
    Family("kinetic energies", rf"|{_TAG}(?:h|omega)?|{_JOINT}", (("K",), ("T",))),
    Family("potential energies, direction cosines", rf"|{_TAG}|E|\d+|0j|j[0e]", (("P",), ("U",), ("Pi",))),
    Family("the Lagrangian", "", (("L",), ("Lambda",))),
    Family("the energy of all", "", (("E",), ("H",), ("Xi",))),
    Family("angular velocities", rf"{_TAG}{_AXIS}?|\d+|0j", (("omega",), ("Omega",))),
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
    Family("direction cosines of neighbours", rf"\d+(?:{_AXIS}{_AXIS})?", (("C",), ("D",))),
    Family("multipliers", r"\d+", (("lambda",), ("upsilon",))),
    Family("weights", _TAG, (("G",), ("W",))),
    Family("lengths of springs and dampers", "{struts}", (("s",), ("l",), ("zeta",)), (_LENGTH,)),
    Family("counts of bodies, freedoms, classes and joints", r"t?", (("n", "u", "t", "s"), ("n", "u", "t", "d"))),
    Family("coefficients of a loop", r"\d*", (("A", "B", "C"), ("U", "V", "W"))),
    Family("origins", r"\d+", (("O",), ("o",))),
    Family("products of inertia", "xy|xz|yz", (("D",), ("Delta",))),
    Family("coefficients", r"[zDGE]\d+|C\d+", (("k",), ("kappa",))),
    Family("conditions and slips", r"\d+", (("f", "c"), ("h", "b"))),
    Family("slopes of conditions", r"|\d+", (("J",), ("Gamma",))),
    Family("matrices of a system", "", ((r"\mathcal{B}",), (r"\mathcal{C}",))),
    Family("ratios of velocities", r"\d+", (("Y",), ("i",))),
    Family("roots", r"|\d+", (("w",), ("chi",))),
    Family("angular momenta", rf"{_TAG}{_AXIS}", (("H",), ("D",), ("Xi",))),
    Family("momenta", r"\d+", (("p",), ("pi",))),
)


@dataclass(frozen=True)
class Letters:
    """The letters of one page, beside the symbols of its scene.

    Attributes:
        scene: the mechanism.
        LENGTH: what pages ask for the letter of a strut's length by.
    """

    scene: Scene
    LENGTH: ClassVar[str] = _LENGTH

    def __getitem__(self, letter: str) -> str:
        """Return what stands for a family's wanted letter: a Latin letter, a Greek name, or LaTeX with a backslash."""
        return self._chosen.get(letter, letter)

    def latex(self, letter: str) -> str:
        """Return what stands for a family's wanted letter in LaTeX."""
        return head(self[letter])

    def coefficient(self, kind: str, indices: Sequence[int]) -> str:
        """Return a coefficient in LaTeX with the letter of this page; see `coefficient_index`."""
        return f"{self.latex('k')}_{{{coefficient_index(kind, indices)}}}"

    @staticmethod
    def body_number(j: int) -> int:
        """Return the number of body j of a scene, from 1, as its mass has; the ground is 0, in the textbook 1."""
        return j + 1

    @cached_property
    def _chosen(self) -> dict[str, str]:
        scene = self.scene
        units = SceneUnits(scene).velocities
        places = {
            "joints": [re.escape(bare(one.name)) for one in (*scene.joints, *scene.loops)],
            "slides": [str(i) for i, unit in enumerate(units, 1) if unit == "m"],
            "struts": [re.escape(bare(one.name)) for one in scene.struts if one.ends],
        }
        taken, used, found = self._taken(), set[str](), dict[str, str]()
        for family in FAMILIES:
            index = family.index.format(**{key: f"(?:{'|'.join(some) or NOBODY})" for key, some in places.items()})
            if index == f"(?:{NOBODY})":  # it has no member, and leaves its letters to others
                continue
            letters = next(
                one for one in _offered(family.choices) if not used & set(one) and not _any(one, index, taken)
            )
            used |= set(letters)
            found |= dict(zip(family.requested or family.choices[0], letters, strict=True))
        return found

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
    pattern = re.compile(rf"(?:{'|'.join(re.escape(bare(x)) for x in letters)})(?:{index})")
    return any(pattern.fullmatch(symbol) for symbol in taken)
