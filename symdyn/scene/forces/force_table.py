"""The kinds of elements: everything that acts in a scene beside gravity and drives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symdyn.errors import hint, suggestion
from symdyn.frozen import replace
from symdyn.scene.forces.applied_forces import DAMPER, FRICTION, LOAD, SPRING
from symdyn.scene.forces.constraints import FORMULA, KNIFE_EDGE, ROLLING, Formula, lacks_place
from symdyn.scene.forces.flows import FLOW
from symdyn.scene.forces.force_kind import ForceKind, Rub, Scope
from symdyn.scene.forces.ropes import DAMPING, ELASTIC, ROPE, SLACK
from symdyn.scene.forces.unilateral import BALL, DRY_JOINT, GAP, ONE_WAY, POINT, STOP, WHEEL
from symdyn.scene.values.description import DESCRIBED
from symdyn.scene.values.entry import Entry, EntryReader, Faults, show
from symdyn.scene.values.joint import Element, Strut
from symdyn.scene.values.key import fields_of, keys_of, raw_of
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL

_ROWS: dict[str, ForceKind] = {
    "spring": SPRING,
    "damper": DAMPER,
    "friction": FRICTION,
    "load": LOAD,
    "flow": FLOW,
    "formula": FORMULA,
    "knife_edge": KNIFE_EDGE,
    "rolling": ROLLING,
    "rope": ROPE,
    "slack": SLACK,
    "elastic": ELASTIC,
    "damping": DAMPING,
    "point": POINT,
    "ball": BALL,
    "wheel": WHEEL,
    "gap": GAP,
    "joint_stop": STOP,
    "joint_friction": DRY_JOINT,
    "one_way": ONE_WAY,
}
FORCES = {
    name: row if isinstance(row.law, Rub) else replace(row, parts=(*row.parts, DESCRIBED))
    for name, row in _ROWS.items()
}
"""Every kind of element; scenes hold elements in this order, and joints what stands in their own tables."""


def sections() -> tuple[str, ...]:
    """Return the tables of a file that declare elements."""
    return tuple(dict.fromkeys(kind.section for kind in FORCES.values() if not isinstance(kind.law, Rub)))


def kinds_of(section: str) -> dict[str, ForceKind]:
    """Return the kinds that a section declares; the first of them is meant where no type is given."""
    return {name: kind for name, kind in FORCES.items() if kind.section == section}


def read_elements(entries: Mapping[str, Iterable[Entry]], scope: Scope, faults: Faults) -> list[tuple[str, Element]]:
    """Return the declared elements of all sections with their places, in the order of `FORCES`."""
    found = []
    for section in sections():
        for entry in entries.get(section, ()):
            one = _read(entry, kinds_of(section), scope, faults)
            if one is not None:
                found.append((entry.where, one))
    return found


def read_rubbing(entry: Entry, key: str, faults: Faults) -> Element | None:
    """Return what stands under a key in the table of a joint, whose name the entry has."""
    return _read(entry, kinds_of(key), Scope({}, NULL, ()), faults)


def _read(entry: Entry, kinds: Mapping[str, ForceKind], scope: Scope, faults: Faults) -> Element | None:
    own = ("type",) if len(kinds) > 1 else ()
    type_ = entry.table.get("type", next(iter(kinds))) if own else next(iter(kinds))
    if not isinstance(type_, str) or type_ not in kinds:
        noun = next(iter(kinds.values())).section.removesuffix("s")
        known = suggestion(str(type_), kinds)
        told = known if known.startswith("did you mean") else hint("types", str(type_)) or known
        faults.add(entry.where, f"type = {show(type_)} is not a {noun}; {told}")
        return None
    kind = kinds[type_]
    table = EntryReader(entry, faults, (*own, *keys_of(kind.parts)))
    if kind.missing and not any(key in table for key in kind.needs):
        table.fault(kind.missing)
    return kind.noun(name=entry.name, **fields_of(kind.parts, table, scope))


def place_of(one: Element) -> str:
    """Return where a file declares an element, for messages."""
    return f"{FORCES[one.kind].section}.{one.name}"


def table_of(one: Element, scope: Scope) -> dict[str, object]:
    """Return what the table of an element says, its type first."""
    kind, kinds = FORCES[one.kind], kinds_of(FORCES[one.kind].section)
    type_: dict[str, object] = {} if one.kind == next(iter(kinds)) else {"type": one.kind}
    return type_ | raw_of(kind.parts, one, scope)


def elastic(scene: Scene) -> tuple[Strut, ...]:
    """Return the struts that store energy."""
    return tuple(one for one in scene.struts if FORCES[one.kind].pull.energy is not None)


def without_place(scene: Scene) -> tuple[str, ...]:
    """Return the names of rows whose force may act on any bodies, since nothing says on which it does."""
    return tuple(c.name for c in scene.constraints if isinstance(c, Formula) and lacks_place(c, scene.velocities))
