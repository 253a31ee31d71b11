"""Names of quantities in a document: how they are printed, and what they are worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from symdyn.graph import Expr


@dataclass(frozen=True)
class Letter:
    """A letter with indices: K_1, ẋ_2 (one dot), v_2² (power 2), k_{z,12}.

    Attributes:
        letter: one Latin letter, the name of a Greek one in Latin ("omega"), or LaTeX that begins with a backslash.
        index: what stands below, parts set apart by commas: ("z", "12").
        dots: time derivatives.
        power: exponent above.
        above: what stands above to the right: A, D, R for actions, inertia, reactions.
        accent: "bar" or "" above the letter.
    """

    letter: str
    index: tuple[str, ...] = ()
    dots: int = 0
    power: int = 1
    above: str = ""
    accent: str = ""


@dataclass(frozen=True)
class Slope:
    """∂of/∂by; both are symbols of the scene or keys of names."""

    of: str
    by: str


@dataclass(frozen=True)
class Rate:
    """d/dt of a symbol of the scene or a key of names."""

    of: str


@dataclass(frozen=True)
class Name:
    """A quantity that the document names.

    Attributes:
        look: how it is printed; None: as the symbol of the scene that the key is.
        node: its value on `Document.graph`; None for what has no value of its own, such as a point.
    """

    look: Union[Letter, Slope, Rate, None]
    node: Expr | None = None
