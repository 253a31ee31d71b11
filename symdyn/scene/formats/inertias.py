"""Inertias as robot files give them: along turned axes, by principal axes, rounded.

A base that floats: the joint that sets a robot free whose file says nothing of how it stands in the world.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene.declaration.joint_table import freedoms
from symdyn.scene.formats.placing import ROUNDING, Doubles, decimal_text, matrix_of, times
from symdyn.scene.values import folding
from symdyn.scene.values.body import Step, circular, impossible
from symdyn.scene.values.entry import Entry, Faults, show
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.grammar import check_name
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity, Value

Entries = tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]

ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}

PLACES = tuple(ENTRIES.values())

AGREEMENT = 1e-8
"""Relative; MuJoCo's compiler turns a matrix into principal axes no more accurately than this in some versions."""

SMALLEST = 2.0**-52
LARGEST = 1e-14
"""Relative to the largest entry; what rounding breaks is mended by less, and what is broken by more was so before."""


def turned(entries: Entries, steps: Sequence[Step]) -> Entries:
    """Return R I Rᵀ, exact; right angles only permute the entries.

    Args:
        entries: xx, yy, zz, xy, xz, yz of I along the turned axes, kg m^2.
        steps: R as turns about moved axes, of these axes in the body frame.
    """
    matrix = dict(zip(PLACES, entries, strict=True))
    for kind, angle in reversed(steps):
        if angle != Quantity.ZERO:
            matrix = _turned_about("xyz".index(kind[1]), angle, matrix)
    xx, yy, zz, xy, xz, yz = (matrix[key] for key in PLACES)
    return xx, yy, zz, xy, xz, yz


def _turned_about(axis: int, angle: Quantity, old: dict[tuple[int, int], Quantity]) -> dict[tuple[int, int], Quantity]:
    """Return R I Rᵀ for a rotation in the plane j, k that takes j towards k."""
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    c, s = circular(Op.COS, angle), circular(Op.SIN, angle)
    cc, ss, cs = folding.mul(c, c), folding.mul(s, s), folding.mul(c, s)

    def at(a: int, b: int) -> tuple[int, int]:
        return (a, b) if a <= b else (b, a)

    jj, kk, jk = old[at(j, j)], old[at(k, k)], old[at(j, k)]
    twice = folding.mul(Quantity.number(2), folding.mul(cs, jk))
    new = {
        at(i, i): old[at(i, i)],
        at(j, j): folding.add(folding.add(folding.mul(cc, jj), folding.neg(twice)), folding.mul(ss, kk)),
        at(k, k): folding.add(folding.add(folding.mul(ss, jj), twice), folding.mul(cc, kk)),
        at(j, k): folding.add(folding.mul(cs, folding.sub(jj, kk)), folding.mul(folding.sub(cc, ss), jk)),
        at(i, j): folding.sub(folding.mul(c, old[at(i, j)]), folding.mul(s, old[at(i, k)])),
        at(i, k): folding.add(folding.mul(s, old[at(i, j)]), folding.mul(c, old[at(i, k)])),
    }
    return {key: new[key] for key in PLACES}


def from_principal(
    principal: Sequence[float], quaternion: Sequence[float], declared: Sequence[float] | None, doubles: Doubles
) -> dict[str, Quantity]:
    """Return R diag(principal) Rᵀ, the inertia about the centre of mass along the body axes, kg m^2.

    Args:
        principal: principal moments, kg m^2.
        quaternion: w, x, y, z of the principal axes in the body frame.
        declared: xx, yy, zz, xy, xz, yz as the file writes them; they count where the compiler left them alone.
        doubles: says whether a product of inertia that is rounding beside the largest moment is zero.
    """
    computed = _rotated([float(x) for x in principal], quaternion, doubles.snap)
    largest = max(abs(x) for x in computed.values())
    if declared is not None:
        written = dict(zip(ENTRIES, map(float, declared), strict=True))
        if all(abs(written[key] - computed[key]) <= AGREEMENT * largest for key in ENTRIES):
            return {key: quantity(value) for key, value in written.items()}
    return {key: quantity(float(x)) for key, x in zip(ENTRIES, possible(list(computed.values())), strict=True)}


def _rotated(principal: list[float], quaternion: Sequence[float], tidy: bool) -> dict[str, float]:
    rotation = matrix_of(quaternion)
    if tidy:
        rotation = [[float(round(x)) if abs(x - round(x)) <= ROUNDING else x for x in row] for row in rotation]
    scaled = [[x * moment for x, moment in zip(row, principal, strict=True)] for row in rotation]
    full = times(scaled, [list(column) for column in zip(*rotation, strict=True)])
    least = ROUNDING * max(principal) if tidy else 0.0
    return {key: full[i][j] if i == j or abs(full[i][j]) > least else 0.0 for key, (i, j) in ENTRIES.items()}


def possible(entries: Sequence[Value]) -> list[Value]:
    """Return xx, yy, zz, xy, xz, yz so that their decimals are those of a body, if rounding is all that is in the way.

    The same small amount added to each moment leaves the axes alone and leads back from beyond the edge: each sum of
    two principal moments grows by twice as much as the third.
    """
    found = list(entries)
    if not _broken(found):
        return found
    largest = max(abs(float(x)) for x in found)
    slack = SMALLEST
    while slack <= LARGEST:
        raised: list[Value] = [float(x) + slack * largest for x in found[:3]]
        if not _broken([*raised, *found[3:]]):
            return [*raised, *found[3:]]
        slack *= 2
    return found


def _broken(entries: Sequence[Value]) -> bool:
    """Whether the decimals of some entries are rounded, and together those of no body."""
    at = {place: Fraction(decimal_text(x)) for place, x in zip(PLACES, entries, strict=True)}
    if all(isinstance(x, Fraction) and x == at[place] for place, x in zip(PLACES, entries, strict=True)):
        return False
    return impossible([[at[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]) is not None


WHERE = "floating base"

UNABLE: Mapping[str, str] = {
    "toml": 'declare it in the scene: a body for the base and [joints.NAME] with type = "free" and parent = "ground"',
    "par": "the file gives its base no mass; convert it to TOML, and add a body for the base and a free joint there",
}
"""Formats that have no base to set free, and what would work."""


def check_base(name: str, format: str, faults: Faults) -> None:
    """Report a name that no joint can have, and a format without a base to set free."""
    if fault := check_name(name):
        faults.add(WHERE, f"{show(name)} {fault}")
    if format in UNABLE:
        faults.add(WHERE, f"only robots in URDF and MJCF are set free; {UNABLE[format]}")


def free_base(name: str, root: str, joints: Sequence[Entry], faults: Faults, start: object = None) -> Entry:
    """Return the free joint `name` with a quaternion, without drives, that carries a root.

    Args:
        name: of the joint.
        root: body that it carries.
        joints: those of the file; none has this name, and none sets free what the root carries.
        faults: takes what is wrong.
        start: seven numbers where the base starts; the world's frame without them.
    """
    if any(joint.name == name for joint in joints):
        faults.add(WHERE, f"there is a joint {name} already; give the base another name, such as {name}_joint")
    for joint in joints:
        if freedoms(joint) == 6 and joint.table["parent"] == root:
            faults.add(WHERE, f"the joint {joint.name} sets the robot free already; leave the floating base out")
    table: dict[str, object] = {"type": "free", "parent": Scene.GROUND, "child": root, "drive": False}
    return Entry(name, table if start is None else table | {"start": start}, WHERE)
