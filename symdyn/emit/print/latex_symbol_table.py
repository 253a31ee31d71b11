"""The table of symbols of a page in LaTeX: what each letter is, its unit and its value."""

from __future__ import annotations

from symdyn.dynamics.mechanism import TIME
from symdyn.emit.escape import in_latex
from symdyn.emit.print.formula_text import Latex, value_text
from symdyn.emit.print.printed_names import latex_unit
from symdyn.scene import Scene, SceneUnits


def symbol_table(scene: Scene, write: Latex, timed: bool) -> list[dict[str, str]]:
    """Return the rows: coordinates, drives, time, parameters."""
    rows, told = [], SceneUnits(scene).inferred
    for joint, q, unit in SceneUnits(scene).each_coordinate():
        rows.append(
            symbol_row(write.symbols[q], f"coordinate of joint {joint.name}, {joint.type}", scene.shown_unit(unit))
        )
    for joint, drive, unit in SceneUnits(scene).each_drive():
        text = f"driving {'force' if unit == 'N' else 'torque'} of joint {joint.name}"
        rows.append(symbol_row(write.symbols[drive], text, scene.shown_unit(unit)))
    if timed:
        rows.append(symbol_row(write.symbols[TIME], "time", scene.shown_unit("s")))
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
