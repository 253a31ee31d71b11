"""Parameters that were found from measured motion, and scenes that have them, in a notebook."""

from __future__ import annotations

from symdyn.identification import Identification, Identified, OutputFit
from symdyn.notebook.page import Markup, head, note, notes, shown, table


def output_fit(result: OutputFit) -> list[Markup]:
    """Return what was found, before and after, and how far the run is from what was measured."""
    scatter = ", ".join(f"{name} {size:.3g}" for name, size in zip(result.measured, result.noise, strict=True))
    return [
        head(result.scene.name, f"parameters by output error, {result.runs} runs"),
        shown(result.table()),
        note(f"residuals: {scatter}; condition number {result.condition:.3g}; {result.dof} degrees of freedom"),
        *notes(result.notes),
    ]


def identification(result: Identification) -> list[Markup]:
    """Return base parameters before and after, how well forces are predicted, and what could not be told."""
    regression = result.regression
    columns = zip(
        result.names, result.units, result.before, result.after, result.errors, regression.identifiable, strict=True
    )
    rows = [(n, u, float(b), float(a), float(e) if told else "not told") for n, u, b, a, e, told in columns]
    fits = [(one.drive, one.unit, one.size, one.error, one.held_back) for one in result.fits]
    count = len(result.model.names)
    gains = [(one.drive, one.unit, one.value, one.error) for one in result.gains]
    return [
        head(result.scene.name, f"{int(regression.identifiable[:count].sum())} of {count} base parameters are told"),
        table(("", "unit", "before", "after", "standard error"), rows[: len(rows) - len(gains)], "base parameters"),
        *([table(("", "unit", "gain", "standard error"), gains, "gains of drives")] if gains else []),
        table(("", "unit", "measured", "error", "error held back"), fits, "driving forces, root mean squares"),
        note(
            f"condition number {regression.condition:.3g}; band {result.band:.3g} Hz; "
            f"{regression.dof} degrees of freedom"
        ),
        *notes(result.notes),
    ]


def identified(result: Identified) -> list[Markup]:
    """Return bodies, or parameters with names, before and after."""
    parts = [head(result.scene.name, "identified")]
    if result.named is not None:
        one = result.named
        columns = zip(one.names, one.before, one.values, one.errors, strict=True)
        rows = [(name, float(before), float(value), float(error)) for name, before, value, error in columns]
        parts.append(table(("", "before", "after", "standard error"), rows, "parameters with names"))
    if result.physical is not None:
        known = result.physical.unknowns
        both = (("before", known.inertias(known.values)), ("after", known.inertias(result.physical.values)))
        bodies: list[list[str | int | float | Markup]] = [
            [name, when, mass, *map(float, (*centre, *moments))]
            for k, name in enumerate(known.bodies)
            for when, each in both
            for mass, centre, moments, _ in [each[k]]
        ]
        heads = ("", "", "mass, kg", "x, m", "y, m", "z, m", "I1, kg m\u00b2", "I2", "I3")
        parts.append(table(heads, bodies, "masses, centres of mass, principal moments"))
    return [*parts, *notes(result.notes)]
