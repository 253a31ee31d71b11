"""The table of symbols of a page in LaTeX: what each letter is, its unit and its value."""

from __future__ import annotations

from symdyn.dynamics.mechanism import TIME
from symdyn.emit.escape import in_latex
from symdyn.emit.print.formula_text import Latex, value_text
from symdyn.emit.print.printed_names import latex_unit
from symdyn.scene import Scene, coordinates_with_units, drives_with_units, shown_unit, told_units


def symbol_table(scene: Scene, write: Latex, timed: bool) -> list[dict[str, str]]:
    """Return the rows: coordinates, drives, time, parameters."""
    rows, told = [], told_units(scene)
    for joint, q, unit in coordinates_with_units(scene):
        rows.append(
            symbol_row(write.symbols[q], f"coordinate of joint {joint.name}, {joint.type}", shown_unit(scene, unit))
        )
    for joint, drive, unit in drives_with_units(scene):
        text = f"driving {'force' if unit == 'N' else 'torque'} of joint {joint.name}"
        rows.append(symbol_row(write.symbols[drive], text, shown_unit(scene, unit)))
    if timed:
        rows.append(symbol_row(write.symbols[TIME], "time", shown_unit(scene, "s")))
    for given in scene.inputs:
        rows.append(symbol_row(write.symbols[given.name], given.text or "input", told[given.name]))
    for parameter in scene.parameters:
        value = in_latex(value_text(parameter.value)) if parameter.value is not None else ""
        rows.append(
            symbol_row(write.symbols[parameter.name], parameter.text or "parameter", told[parameter.name], value)
        )
    return rows


def symbol_row(symbol: str, text: str, unit: str, value: str = "") -> dict[str, str]:
    """Return one row of the table."""
    shown = latex_unit(unit)
    return {"symbol": symbol, "text": in_latex(text), "unit": f"${shown}$" if shown else "", "value": value}
