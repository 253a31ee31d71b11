"""Derivatives of a motion in a notebook: a linear system with its modes, and how an end depends on its start."""

from __future__ import annotations

import numpy as np

from symdyn.algebra import Array
from symdyn.linear import HEAD, KINDS, Axis, Linearization, eigenvalue, latex, number, shape, stability, where
from symdyn.notebook.page import Cell, Markup, beside, head, note, notes, table, verdict
from symdyn.simulation import Sensitivity

WIDEST = 16
"""Columns of a matrix that are shown."""


def linearization(found: Linearization) -> list[Markup]:
    """Return the matrices of a linear system, its modes, and whether it is stable."""
    told = stability(found)
    axes = {"A": (found.states, found.states), "B": (found.states, found.inputs),
            "C": (found.outputs, found.states), "D": (found.outputs, found.inputs)}  # fmt: skip
    shown = [_matrix(letter, getattr(found, letter), *axes[letter]) for letter in axes]
    modes = [(eigenvalue(mode, found), mode.frequency, mode.damping, shape(mode, found)) for mode in found.modes]
    return [
        head(found.scene.name, f"linearised {KINDS[found.kind]}"),
        verdict(told.verdict != "unstable", told.words),
        note(where(found)),
        beside(*shown),
        table(HEAD, modes, "modes"),
        *(note(line) for line in told.lines),
        *notes(found.notes),
    ]


def latex_of_linearization(found: Linearization) -> str:
    """Return the linear system in LaTeX."""
    return latex(found)


def sensitivity(found: Sensitivity) -> list[Markup]:
    """Return the derivatives of the end of a run."""
    matrix = _matrix("d end / d start", found.matrix, Axis(found.rows, ()), Axis(found.columns, ()))
    text = f"{found.method}, {found.steps} steps, {found.by}"
    return [
        head(found.scene.name, f"how the end at t = {found.t:g} s depends on the start; {text}"),
        matrix,
        *notes(found.notes),
    ]


def _matrix(name: str, matrix: Array, rows: Axis, columns: Axis) -> Markup:
    """Return a matrix with names on its rows and columns; one that is zero or wide in a line."""
    if not matrix.size:
        return Markup("")
    if not matrix.any():
        return note(f"{name} = 0")
    if len(columns) > WIDEST:
        return note(f"{name}: {len(rows)} × {len(columns)} numbers")
    size = float(np.abs(matrix).max(initial=0.0))
    body: list[list[Cell]] = [
        [row, *(float(number(x, size)) for x in cells)] for row, cells in zip(rows.names, matrix, strict=True)
    ]
    return table((name, *columns.names), body)
