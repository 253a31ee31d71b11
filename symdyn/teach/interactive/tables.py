"""Tables: of what each force is made, and what drives, loops and rows of a closed mechanism exert."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symdyn.emit import in_html
from symdyn.emit.print import Letters, latex_symbols
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import acceleration_name
from symdyn.teach.derivations.lagrange.equation_steps import coefficient_unit
from symdyn.teach.interactive.controls import UNITS
from symdyn.teach.interactive.live import Live, Term
from symdyn.teach.mathml import inline

PHRASES = (
    *("force along the track", "force across the track", "normal force", "force across the blade"),
    *("force along", "moment about", "with its moment", "row"),
)
"""What a multiplier may be, longer phrases first: keys of the words of the page."""


def force_tables(scene: Scene, computed: Live, words: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return, row by row, its name, its unit and its terms."""
    symbols, letters = latex_symbols(scene), Letters(scene)
    units = SceneUnits(scene).velocities
    slides = [units[velocity] == "m" for velocity in computed.rows]
    tables = []
    for i, velocity in enumerate(computed.rows):
        drive = scene.drives[velocity]
        if computed.held:
            label, drives = rf"{letters.latex('tau')}_{{{i + 1}}}^{{*}}", computed.held.drives
            passive = velocity not in drives and set(drives) <= set(computed.rows)
        else:
            label, passive = symbols[drive] if drive else rf"{letters.latex('tau')}_{{{i + 1}}}", not drive
        terms = [(k, term) for k, term in enumerate(computed.terms) if term.row == i]
        tables.append(
            {
                "label": inline(label),
                "passive": passive,
                "unit": scene.shown_unit(UNITS[units[velocity]][3]),
                "terms": [
                    {
                        "number": k,
                        "unit": scene.shown_unit(coefficient_unit(term.of, [i + 1 for i in term.indices], slides)),
                        **_term(scene, term, symbols, letters, words, "*" if computed.held else ""),
                    }
                    for k, term in terms
                ],
            }
        )
    return tables


def _term(
    scene: Scene, term: Term, symbols: Mapping[str, str], letters: Letters, words: Mapping[str, str], star: str
) -> dict[str, str]:
    """Return how a term is printed: its coefficient and what that is multiplied by."""
    names = {"qd": scene.velocities, "qdd": tuple(acceleration_name(v) for v in scene.velocities)}
    factors = [symbols[names[kind][k]] for kind, k in term.rates]
    square = len(factors) == 2 and factors[0] == factors[1]
    rate = inline(f"{_grouped(factors[0])}^{{2}}") if square else "\u00a0".join(inline(x) for x in factors)
    above = f"^{{{star}}}" if star else ""
    if term.sign < 0:
        Q = letters.latex("Q")
        return {"coefficient": f"−{inline(f'{Q}_{{{term.row + 1}}}{above}')}", "rate": "", "text": words["Q"]}
    coefficient = letters.coefficient(term.function, [index + 1 for index in term.indices])
    return {"coefficient": inline(f"{coefficient}{above}"), "rate": rate, "text": ""}


def _grouped(latex: str) -> str:
    return f"{{{latex}}}" if "^" in latex else latex


def exerted(scene: Scene, computed: Live, words: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return rows of what drives and multipliers exert, none for a tree: name, words, unit, which result and entry."""
    if computed.held is None:
        return []
    symbols, multiplier = latex_symbols(scene), Letters(scene).latex("lambda")
    rows = []
    driven = [k for k, drive in enumerate(scene.drives) if drive]
    for k, (joint, drive, unit) in zip(driven, SceneUnits(scene).each_drive(), strict=True):
        if k in computed.held.drives:
            text = words["drive"].format(joint=joint.name)
            rows.append(
                _exerted(
                    inline(symbols[drive]), text, scene.shown_unit(unit).replace(" ", "\u202f"), "inverse_dynamics", k
                )
            )
    for k, (owner, wrench) in enumerate(computed.held.multipliers):
        text = wrench.partition(" along (")[0].partition(" about (")[0]
        for phrase in PHRASES:
            text = text.replace(phrase, words[phrase])
        unit = "N" if wrench.startswith("force") else UNITS["rad"][3] if wrench.startswith("moment") else ""
        rows.append(
            _exerted(inline(rf"{multiplier}_{{{k + 1}}}"), f"{owner}: {text}", scene.shown_unit(unit), "multipliers", k)
        )
    return rows


def _exerted(label: str, text: str, unit: str, function: str, entry: int) -> dict[str, Any]:
    return {"label": label, "text": in_html(text), "unit": unit, "function": function, "entry": entry}
