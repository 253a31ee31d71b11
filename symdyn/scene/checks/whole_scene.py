"""Checks of a scene as a whole: names, tree, loops, symbols, values, physics. Every fault is reported."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from symdyn.graph import Graph, Op
from symdyn.scene.checks.declared_names import check_names, check_symbols
from symdyn.scene.checks.dimensions import check_dimensions
from symdyn.scene.checks.draft import Draft, uses
from symdyn.scene.checks.joints_and_elements import check_elements, check_joints
from symdyn.scene.checks.topology import check_loops, check_tree
from symdyn.scene.checks.welded import judge
from symdyn.scene.values.physical import mass_faults
from symdyn.scene.values.quantity import FormulaError, Quantity, Value
from symdyn.scene.values.table import Faults, shown
from symdyn.scene.values.unit import Unit, UnitError
from symdyn.scene.values.with_unit import fits, with_unit


def check(
    draft: Draft, faults: Faults, allow_invalid_inertia: bool = False, dimensions: bool = True
) -> tuple[str, ...]:
    """Report every fault of a draft, those of its `dimensions` where these are asked for.

    Returns:
        The bodies whose inertia is a note instead, if that is allowed.
    """
    values = _parameter_values(draft, faults)
    check_names(draft, faults)
    check_symbols(draft, faults)
    check_tree(draft, faults)
    check_loops(draft, faults)
    check_joints(draft, values, faults)
    check_elements(draft, values, faults)
    _formulas(draft, values, faults)
    _units(draft, faults, dimensions and not draft.scene.dimensionless)
    return tuple(_masses(draft, values, faults, allow_invalid_inertia))


def _parameter_values(draft: Draft, faults: Faults) -> dict[str, Value]:
    values: dict[str, Value] = {}
    for where, parameter in zip(draft.where["parameters"], draft.scene.parameters, strict=True):
        value = None if parameter.value is None else _constant(where, parameter.value, faults)
        if parameter.value is None or value is None:
            continue
        if parameter.positive and value <= 0:
            faults.add(where, f"value = {shown(parameter.value)} is not positive; correct it or drop positive = true")
        values[parameter.name] = value
    for where, letter in zip(draft.where["inputs"], draft.scene.inputs, strict=True):
        _constant(where, letter.value, faults)
    return values


def _constant(where: str, value: Quantity, faults: Faults) -> Value | None:
    """Return what a value without symbols is, None after a fault."""
    if value.symbols:
        names = ", ".join(value.symbols)
        faults.add(where, f"value = {shown(value)} uses {names}; a value may hold numbers and pi only")
        return None
    try:
        value.express(Graph())  # sees that sin(pi) is zero, which a float does not
        found = value.at({})
    except (FormulaError, ZeroDivisionError) as error:
        why = error if isinstance(error, FormulaError) else "divides by zero"
        faults.add(where, f"value = {shown(value)} {why}; give a finite number")
        return None
    assert found is not None, "a formula without symbols has a value"
    return found


def _formulas(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Every formula has a value: no division by what is zero, no root of what is negative."""
    graph = Graph()
    for use in uses(draft):
        if use.quantity.op is Op.CONSTANT:
            continue
        try:
            use.quantity.express(graph)
            use.quantity.at(values)
        except ZeroDivisionError:
            faults.add(use.where, f"{use.key} = {shown(use.quantity)} divides by zero; check the denominator")
        except FormulaError as error:
            faults.add(use.where, f"{use.key} = {shown(use.quantity)} {error}; check the values of its parameters")


def _units(draft: Draft, faults: Faults, dimensions: bool) -> None:
    """Every value that was written with a unit is in one that fits where it stands; and every formula fits there."""
    formulas, parameters = [], {one.name for one in draft.scene.parameters}
    for use in uses(draft):
        if use.quantity.op is not Op.CONSTANT and use.quantity.symbols:
            formulas += [use] if parameters.union(use.allowed).issuperset(use.quantity.symbols) else []
        elif use.quantity.unit and use.unit:
            try:
                if not (use.other and Unit.read(use.quantity.unit).misfit(Unit.read(use.other)) is None):
                    fits(use.quantity, Unit.read(use.unit), parameters.union(use.allowed))
            except UnitError as error:
                asked = f"{use.unit} or {use.other}" if use.other else use.unit
                why = str(error).replace(f"{use.unit} is asked", f"{asked} is asked")
                faults.add(use.where, f'{use.key} = "{with_unit(use.quantity, use.quantity.unit)}" {why}')
    if formulas and dimensions:
        check_dimensions(draft.scene, formulas, faults)


def _masses(draft: Draft, values: Mapping[str, Value], faults: Faults, allow: bool) -> Iterator[str]:
    negative = set()
    for where, body in zip(draft.where["bodies"], draft.scene.bodies, strict=True):
        for fault in mass_faults(body, values):
            faults.add(where, fault)
            negative.add(body.name)
    about_frame = {body.name for body in draft.scene.bodies if body.about == "frame"}
    for where, name, why, advice, fine in judge(draft, values):
        if name in negative & about_frame:
            continue
        if fine:
            faults.note(where, why)
        elif allow:
            faults.note(where, f"{why}; kept as it is")
            yield name
        else:
            faults.add(where, f"{why}; {advice}, or {faults.excuse}")
