"""Constraints in mechanism words: "force along x of loop cut", "moment about (0.6, 0, 0.8)"."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from symdyn.dynamics.loops.rows import Label

if TYPE_CHECKING:
    from symdyn.dynamics.loops.numbers import Array, Numbers


def spoken(label: Label, numbers: Numbers, q: Array) -> str:
    """Return what a row of G forbids, in the axes of the joint frame on the parent."""
    if label.wrench is None:
        return "row"
    force, moment = (numbers.at(part, q) for part in label.wrench)
    return in_words(force, moment)


def in_words(force: Array, moment: Array) -> str:
    """Return a wrench in words, such as "force along x"."""
    if np.abs(force).max() > 1e-12:
        pitch = " with its moment" if np.abs(moment).max() > 1e-12 else ""
        return f"force along {_direction(force)}{pitch}"
    return f"moment about {_direction(moment)}"


def _direction(vector: Array) -> str:
    """Return x, y or z where the vector lies along one, else its components."""
    unit = vector / np.linalg.norm(vector)
    for k, name in enumerate("xyz"):
        if abs(abs(unit[k]) - 1) < 1e-12:
            return name
    return "(" + ", ".join(f"{x + 0.0:.4g}" for x in unit) + ")"
