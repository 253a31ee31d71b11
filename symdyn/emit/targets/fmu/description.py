"""What the templates of model descriptions are given: every attribute as finished text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symdyn.emit.code.target import Draft
from symdyn.emit.escape import in_xml
from symdyn.emit.targets.fmu.variables import Variable
from symdyn.scene.values import Unit, UnitError

VARIABILITY = {"independent": "continuous", "parameter": "tunable"}
"""Of each causality; "continuous" of all others."""


def described(draft: Draft, variables: Sequence[Variable], differentiated: bool, tolerance: str) -> dict[str, Any]:
    """Return the facts of a model description."""
    outputs = [one for one in variables if one.causality == "output"]
    rates = [one for one in variables if one.state]
    computed = sorted([*(one for one in outputs if one.start is None), *rates], key=lambda one: one.reference)
    names = dict.fromkeys(one.unit for one in variables if one.unit and one.unit != "1")
    return {
        "model": in_xml(draft.program.scene.name),
        "identifier": in_xml(draft.stem),
        "description": in_xml(f"{draft.page.command}"),
        "differentiated": "true" if differentiated else "false",
        "tolerance": tolerance,
        "units": [{"name": in_xml(name), "base": _base(name)} for name in names],
        "variables": [_variable(one) for one in variables],
        "outputs": [_unknown(one) for one in outputs],
        "rates": [_unknown(one) for one in rates],
        "initial": [_unknown(one) for one in computed],
    }


def _base(unit: str) -> str:
    """Return a unit in those of SI, as attributes; "" where it cannot be read."""
    try:
        found = Unit.read(unit)
    except UnitError:  # such as one of a row, "m/s or 1/s"
        return ""
    exponents = [*found.dimension.powers, ("rad", found.radians)]
    if any(count.denominator != 1 for _, count in exponents):
        return ""
    told = "" if found.is_coherent else f' factor="{found.size!r}"'
    return "".join(f' {name}="{count}"' for name, count in exponents if count) + told or ' factor="1"'


def _variable(one: Variable) -> dict[str, Any]:
    initial = "" if one.causality in ("independent", "input") else "calculated" if one.start is None else "exact"
    manner = f' causality="{one.causality}" variability="{VARIABILITY.get(one.causality, "continuous")}"'
    unit = f' unit="{in_xml(one.unit)}"' if one.unit and one.unit != "1" else ""
    start = "" if one.start is None else f' start="{one.start!r}"'
    limits = "".join(f' {k}="{x!r}"' for k, x in (("min", one.least), ("max", one.most)) if x is not None)
    return {
        "name": in_xml(one.name),
        "reference": one.reference,
        "manner": manner + (f' initial="{initial}"' if initial else ""),
        "description": f' description="{in_xml(one.text)}"' if one.text else "",
        "real2": unit + limits + start + (f' derivative="{one.state + 1}"' if one.state else ""),
        "real3": unit + limits + start + (f' derivative="{one.state}"' if one.state else ""),
    }


def _unknown(one: Variable) -> dict[str, Any]:
    return {
        "reference": one.reference,
        "index": one.reference + 1,
        "references": " ".join(map(str, one.depends)),
        "indices": " ".join(str(k + 1) for k in one.depends),
    }
