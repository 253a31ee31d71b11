"""Derivatives of a motion in a notebook: a linear system with its modes, and how an end depends on its start."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Array
from symdyn.linear import Linearization
from symdyn.notebook.page import Markup, beside, head, note, notes, shown, verdict
from symdyn.simulation import Sensitivity
from symdyn.table import Table

WIDEST = 16
"""Columns of a matrix that are shown."""


def linearization(system: Linearization) -> list[Markup]:
    """Return the matrices of a linear system, its modes, and whether it is stable."""
    told = system.stability
    states, inputs, outputs = system.states.names, system.inputs.names, system.outputs.names
    axes = {"A": (states, states), "B": (states, inputs), "C": (outputs, states), "D": (outputs, inputs)}
    matrices = [_matrix(letter, getattr(system, letter), *axes[letter]) for letter in axes]
    return [
        head(system.scene.name, f"linearised {system.manner}"),
        verdict(told.verdict != "unstable", told.words),
        note(system.place),
        beside(*matrices),
        shown(system.mode_table()),
        *(note(line) for line in told.lines),
        *notes(system.notes),
    ]


def latex_of_linearization(system: Linearization) -> str:
    """Return the linear system in LaTeX."""
    return system.latex()


def sensitivity(result: Sensitivity) -> list[Markup]:
    """Return the derivatives of the end of a run."""
    matrix = _matrix("d end / d start", result.matrix, result.rows, result.columns)
    text = f"{result.method}, {result.steps} steps, {result.by}"
    return [
        head(result.scene.name, f"how the end at t = {result.t:g} s depends on the start; {text}"),
        matrix,
        *notes(result.notes),
    ]


def _matrix(name: str, matrix: Array, rows: Sequence[str], columns: Sequence[str]) -> Markup:
    """Return a matrix with names on its rows and columns; one that is zero or wide in a line."""
    if not matrix.size:
        return Markup("")
    if not matrix.any():
        return note(f"{name} = 0")
    if len(columns) > WIDEST:
        return note(f"{name}: {len(rows)} × {len(columns)} numbers")
    return shown(Table.matrix(name, rows, columns, matrix.tolist()))
