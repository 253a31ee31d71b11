"""Rows as tables: formulas, knife edges, and contacts of wheels and balls with a plane; every fault collected.

A plane without a normal is level: its normal points against gravity as the scene declares it, whatever values its
parameters are given later.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence

from symdyn.scene.folding import FormulaError, neg
from symdyn.scene.load_table import Points, place_of
from symdyn.scene.loads import Place, Plane, Row
from symdyn.scene.mapping import substituted
from symdyn.scene.model import GROUND, Parameter
from symdyn.scene.names import suggestion
from symdyn.scene.quantity import NULL, ONE, ZERO, Quantity, Vector, number
from symdyn.scene.spelling import spell
from symdyn.scene.table import Entry, Faults, Table, plain, show
from symdyn.scene.value import value_of

ROW_KEYS = {
    "formula": ("type", "formula"),
    "knife_edge": ("type", "body", "point", "at", "axis", "plane"),
    "rolling": ("type", "body", "point", "at", "axis", "radius", "plane", "normal", "components"),
}

PLANE_KEYS = ("body", "at", "normal")

COMPONENTS = ("along", "across", "normal")

DRAWS, SAME = 6, 1e-12
"""Random values of free parameters at which a direction is looked at, and what it may differ by."""


def read_row(entry: Entry, points: Points, level: Vector | str, faults: Faults) -> Row:
    """Return a declared row.

    Args:
        entry: the table.
        points: the scene's points by name.
        level: the normal of level ground, from `level_normal`; or why there is none.
        faults: where they are collected.
    """
    kind = entry.table.get("type", "formula")
    if not isinstance(kind, str) or kind not in ROW_KEYS:
        faults.add(entry.where, f"type = {show(kind)} is not a constraint; {suggestion(str(kind), ROW_KEYS)}")
        return Row(entry.name, place=Place(""))
    table = Table(entry, faults, ROW_KEYS[kind])
    if kind == "formula":
        if "formula" not in table:
            table.fault('formula is missing; write what vanishes, such as formula = "x_dot - r*phi_dot"')
        return Row(entry.name, formula=table.quantity("formula"))
    usual = Row(entry.name)
    key = "radius" if kind == "rolling" else "axis"
    if key not in table:
        table.fault(f"{key} is missing; write {'axis = [0, 1, 0]' if key == 'axis' else 'radius = 0.1'}")
    ball = kind == "rolling" and "axis" not in table
    place = place_of(table, points)
    return Row(
        entry.name,
        type=kind,
        place=place,
        axis=None if ball else table.vector("axis", usual.axis or NULL),
        radius=table.quantity("radius"),
        plane=_plane(table, kind == "rolling", level),
        components=_components(table, COMPONENTS if ball else usual.components),
    )


def _plane(table: Table, needs_normal: bool, level: Vector | str) -> Plane:
    """Return the plane that a row declares, level where it says nothing else."""
    declared, where = "plane" in table, table
    if declared:
        advice = "write plane = { at = [0, 0, 0], normal = [0, 0, 1] }"
        where = table.inner("plane", PLANE_KEYS, f"{advice}, with body = NAME where it is not the ground's")
        if "normal" in table:
            table.fault("normal is given beside plane; write it into plane")
    body = where.text("body", GROUND) if declared else GROUND
    at = where.vector("at") if declared else NULL
    normal = where.vector("normal", Plane().normal)
    if "normal" not in where and needs_normal and body != GROUND:
        where.fault(f'normal is missing; a plane on body "{body}" has one of its own, such as normal = [0, 0, 1]')
    elif "normal" not in where and (needs_normal or declared):
        if isinstance(level, str):
            where.fault(f"normal is missing, and {level}; write normal = [0, 0, 1]")
        else:
            normal = level
            if normal != Plane().normal:
                text = ", ".join(spell(x) for x in normal)
                table.faults.note(table.entry.where, f"its plane is level: normal = [{text}], against gravity")
    return Plane(body, at, normal, declared)


def _components(table: Table, usual: tuple[str, ...]) -> tuple[str, ...]:
    raw = plain(table.raw.get("components", usual))
    some = isinstance(raw, (list, tuple)) and raw and all(one in COMPONENTS for one in raw)
    if not isinstance(raw, (list, tuple)) or not some or len(set(raw)) < len(raw):
        table.fault(
            f'components = {show(raw)} is not a list of "along", "across" and "normal"; leave it out for '
            f"{' and '.join(usual) if len(usual) == 2 else 'all three'}"
        )
        return usual
    return tuple(raw)


def level_normal(gravity: Vector, parameters: Sequence[Parameter]) -> Vector | str:
    """Return the direction against gravity, free of symbols; or why it is not decided, for a message.

    Parameters with a value have that value; the direction must be the same whatever the others are.
    """
    given = {p.name: p.value for p in parameters if p.value is not None}
    free = [p for p in parameters if p.value is None]
    text = f"gravity = [{', '.join(spell(x) for x in gravity)}]"
    draws = [given | drawn for drawn in _drawn(free)]
    directions = [found for values in draws if (found := _unit(gravity, values)) is not None]
    if len(directions) < len(draws):
        return f"{text} has no direction"
    if any(math.dist(directions[0], one) > SAME for one in directions):
        names = [p.name for p in free if any(p.name in x.symbols for x in gravity)]
        return f"the direction of {text} depends on {', '.join(names)}, which may be negative"
    lengths = [k for k in range(3) if abs(directions[0][k]) > SAME]
    if len(lengths) == 1:
        up = ONE if directions[0][lengths[0]] < 0 else neg(ONE)
        x, y, z = (up if k == lengths[0] else ZERO for k in range(3))
    else:
        x, y, z = (neg(substituted(entry, draws[0])) for entry in gravity)
    return (x, y, z)


def _drawn(free: Sequence[Parameter]) -> list[dict[str, Quantity]]:
    """Return values of free parameters: ones, ones with either sign, and random ones."""
    rng = random.Random("gravity")
    sizes = [[1] * len(free), [1] * len(free), *([rng.randint(1, 99) for _ in free] for _ in range(DRAWS))]
    signs = [1, -1, *(rng.choice((-1, 1)) for _ in range(DRAWS))]
    return [
        {p.name: number(size if p.positive else sign * size) for p, size in zip(free, some, strict=True)}
        for some, sign in zip(sizes, signs, strict=True)
    ]


def _unit(vector: Vector, values: Mapping[str, Quantity]) -> tuple[float, ...] | None:
    """Return the direction of a vector at values of its symbols; None where it has none."""
    try:
        numbers = [float(value_of(substituted(x, values), {}) or 0) for x in vector]
    except (FormulaError, ZeroDivisionError):
        return None  # reported as a formula without a value
    length = math.hypot(*numbers)
    return tuple(x / length for x in numbers) if length else None
