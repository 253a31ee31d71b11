"""What rows of loops are called, wrenches and directions in words, and what is said where equations of motion end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.constraint_rows import Label
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import Scene

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_numbers import Numbers


def unbound(scene: Scene, entries: Sequence[Expr]) -> list[str]:
    """Return the names of the free parameters that entries depend on."""
    names = {node.value for node in reachable(entries) if node.op is Op.SYMBOL}
    return [parameter.name for parameter in scene.free_parameters if parameter.name in names]


def spoken(numbers: Numbers, q: Array) -> tuple[str, ...]:
    """Return what every row of G forbids: its owner, and a direction in the axes of the joint frame on the parent."""
    labels = numbers.constraints.labels
    wrenches = {k: one.wrench for k, one in enumerate(labels) if one.wrench is not None and not one.name}
    found = numbers.at([x for pair in wrenches.values() for part in pair for x in part], q).reshape(-1, 2, 3)
    known = dict(zip(wrenches, found, strict=True))

    def words(k: int, label: Label) -> str:
        if k not in known:
            return label.name or "row"
        force, moment = known[k]
        return in_words(force, moment if label.loop else np.zeros(3))  # a contact's acts where it touches

    return tuple(f"{one.owner}: {words(k, one)}" for k, one in enumerate(labels))


def missed(label: Label, numbers: Numbers, q: Array, by: float) -> str:
    """Return by how much a residual misses zero: "its gap along y is 25.8 m", "its direction about x is off by 0.3"."""
    assert label.wrench is not None, "a formula of the user has no residual"
    force, moment = (numbers.at(part, q) for part in label.wrench)
    if np.abs(force).max() > 1e-12:
        return f"its gap along {direction_words(force)} is {by:.3g} m"
    return f"its direction about {direction_words(moment)} is off by {by:.3g}"


def in_words(force: Array, moment: Array) -> str:
    """Return a wrench in words, such as "force along x"."""
    if np.abs(force).max() > 1e-12:
        pitch = " with its moment" if np.abs(moment).max() > 1e-12 else ""
        return f"force along {direction_words(force)}{pitch}"
    return f"moment about {direction_words(moment)}"


def direction_words(vector: Array) -> str:
    """Return x, y or z where the vector lies along one, else its components."""
    unit = vector / np.linalg.norm(vector)
    for k, name in enumerate("xyz"):
        if abs(abs(unit[k]) - 1) < 1e-12:
            return name
    return "(" + ", ".join(f"{x + 0.0:.4g}" for x in unit) + ")"
