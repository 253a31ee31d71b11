"""Springs, dampers and loads as tables: raw keys to nouns, every fault collected."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene.folding import FormulaError, add, function, mul, neg
from symdyn.scene.formula import quantity
from symdyn.scene.loads import Damper, Load, Place, Spring
from symdyn.scene.model import Point, Pose
from symdyn.scene.names import suggestion
from symdyn.scene.quantity import NULL, ONE, PI, ZERO, Quantity, Vector, number
from symdyn.scene.table import Entry, Faults, Table, plain, show

END_KEYS = ("joint", "from", "to")

SPRING_KEYS = (*END_KEYS, "stiffness", "free", "preload")

DAMPER_KEYS = (*END_KEYS, "damping")

LOAD_KEYS = ("body", "point", "at", "force", "couple", "frame")

ENDS = 'write joint = "NAME", or from and to, each the name of a body or point or { body = "NAME", at = [0, 0, 0] }'

Points = Mapping[str, Point]


def read_spring(entry: Entry, points: Points, faults: Faults) -> Spring:
    """Return a declared spring."""
    table = Table(entry, faults, SPRING_KEYS)
    joint, ends = _ends(table, points)
    if "stiffness" not in table and "preload" not in table:
        table.fault("stiffness is missing; write stiffness = 100, or a list of coefficients")
    stiffness = _coefficients(table, "stiffness")
    return Spring(entry.name, joint, ends, stiffness, table.quantity("free"), table.quantity("preload"))


def read_damper(entry: Entry, points: Points, faults: Faults) -> Damper:
    """Return a declared damper."""
    table = Table(entry, faults, DAMPER_KEYS)
    joint, ends = _ends(table, points)
    if "damping" not in table:
        table.fault("damping is missing; write damping = 10, or a list of coefficients of v, v**3, ...")
    return Damper(entry.name, joint, ends, _coefficients(table, "damping"))


def read_load(entry: Entry, points: Points, faults: Faults) -> Load:
    """Return a declared wrench."""
    table = Table(entry, faults, LOAD_KEYS)
    frame = table.text("frame", "ground")
    if frame not in ("ground", "body"):
        table.fault(f'frame = "{frame}" is not known; write "ground" or "body"')
        frame = "ground"
    if "force" not in table and "couple" not in table:
        table.fault("has neither force nor couple; write one, such as force = [0, 0, 10]")
    return Load(entry.name, place_of(table, points), table.vector("force"), table.vector("couple"), frame)


def _coefficients(table: Table, key: str) -> tuple[Quantity, ...]:
    """Return one number or a list of them."""
    if key not in table:
        return ()
    raw = plain(table.raw[key])
    given = list(raw) if isinstance(raw, (list, tuple)) else [raw]
    if not given:
        table.fault(f"{key} = [] holds no number; give one, or a list of coefficients")
    try:
        return tuple(quantity(plain(one)) for one in given)
    except FormulaError as error:
        table.refuse(key, error)
        return ()


def _ends(table: Table, points: Points) -> tuple[str, tuple[Place, ...]]:
    """Return the joint that it is at, or the points that it connects."""
    given = [key for key in END_KEYS if key in table]
    if given == ["joint"]:
        return table.text("joint"), ()
    if given == ["from", "to"]:
        return "", (_end(table, "from", points), _end(table, "to", points))
    table.fault(f"has {' and '.join(given) or 'neither joint nor from and to'}; {ENDS}")
    return "", ()


def _end(table: Table, key: str, points: Points) -> Place:
    raw = plain(table.raw[key])
    if isinstance(raw, Place):
        return raw
    if isinstance(raw, str):
        return _at_point(points[raw]) if raw in points else Place(raw)
    if not isinstance(raw, Mapping):
        table.fault(f"{key} = {show(raw)} is no end; {ENDS}")
        return Place("")
    return place_of(table.inner(key, ("body", "point", "at"), ENDS), points)


def place_of(table: Table, points: Points) -> Place:
    """Return the point of a body that `body` and `at`, or `point`, name."""
    if ("body" in table) == ("point" in table):
        table.fault('give body and at, or point; write body = "NAME" and at = [0, 0, 0]')
        return Place("")
    if "body" in table:
        return Place(table.text("body"), table.vector("at"))
    if "at" in table:
        table.fault("at goes with body; a point has a place of its own")
    name = table.text("point")
    if name not in points:
        table.fault(f'point = "{name}" is not a point; {suggestion(name, points)}')
        return Place("")
    return _at_point(points[name])


def _at_point(point: Point) -> Place:
    return Place(point.body, translation(point.at))


def translation(pose: Pose) -> Vector:
    """Return where a placement puts the origin, m."""
    r = list(NULL)
    for kind, amount in reversed(pose.steps):
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            r[k] = add(r[k], amount)
            continue
        i, j = (k + 1) % 3, (k + 2) % 3
        if r[i] == r[j] == ZERO:
            continue
        c, s = _QUARTERS.get(amount) or (function(Op.COS, amount), function(Op.SIN, amount))
        r[i], r[j] = add(mul(c, r[i]), neg(mul(s, r[j]))), add(mul(s, r[i]), mul(c, r[j]))
    return (r[0], r[1], r[2])


_MINUS = number(-1)

_QUARTERS = {  # cosine and sine, exact
    mul(number(Fraction(k, 2)), PI): pair
    for k, pair in ((-2, (_MINUS, ZERO)), (-1, (ZERO, _MINUS)), (1, (ZERO, ONE)), (2, (_MINUS, ZERO)))
}
