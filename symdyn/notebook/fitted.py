"""Parameters that were found by simulated runs, in a notebook."""

from __future__ import annotations

from symdyn.identification import OutputFit
from symdyn.notebook.page import Markup, head, note, notes, table


def output_fit(found: OutputFit) -> list[Markup]:
    """Return what was found, before and after, and how far the run is from what was measured."""
    columns = ("", "unit", "before", "after", "standard error")
    scatter = ", ".join(f"{name} {size:.3g}" for name, size in zip(found.measured, found.noise, strict=True))
    return [
        head(found.scene.name, f"parameters by output error, {found.runs} runs"),
        table(columns, list(found.table()), "estimates"),
        note(f"residuals: {scatter}; condition number {found.condition:.3g}; {found.dof} degrees of freedom"),
        *notes(found.notes),
    ]
