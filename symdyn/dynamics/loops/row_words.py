"""Constraints in mechanism words: "force along x of loop cut", "moment about (0.6, 0, 0.8)"."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from symdyn.dynamics.loops.constraint_rows import Label

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_numbers import Array, Numbers


def spoken(label: Label, numbers: Numbers, q: Array) -> str:
    """Return what a row of G forbids, in the axes of the joint frame on the parent."""
    if label.wrench is None or label.name:
        return label.name or "row"
    force, moment = (numbers.at(part, q) for part in label.wrench)
    return in_words(force, moment if label.loop else np.zeros(3))  # a contact's acts where it touches


def missed(label: Label, numbers: Numbers, q: Array, by: float) -> str:
    """Return by how much a residual misses zero: "its gap along y is 25.8 m", "its direction about x is off by 0.3"."""
    assert label.wrench is not None, "a formula of the user has no residual"
    force, moment = (numbers.at(part, q) for part in label.wrench)
    if np.abs(force).max() > 1e-12:
        return f"its gap along {_direction(force)} is {by:.3g} m"
    return f"its direction about {_direction(moment)} is off by {by:.3g}"


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
