"""Bodies as tables: raw keys to `Body`, every fault collected."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from symdyn.bounds import BOUNDS
from symdyn.scene.declaration.dh import BODY_KEYS
from symdyn.scene.values.body import Body, Outline, Particle
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.outline import OUTLINES
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity
from symdyn.scene.values.table import Entry, Faults, Table, plain, show, shown, vector

MOST_PARTICLES = BOUNDS["particles of a body"]
"""Particles of a body; each is a term of every formula, so that more of them are given by their sums."""

INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")


def read_body(entry: Entry, faults: Faults) -> Body:
    """Return a declared body."""
    table = Table(entry, faults, BODY_KEYS if not entry.where.startswith("dh.") else tuple(entry.table))
    about = table.text("inertia_about", "frame" if "first_moment" in table else "com")
    if about not in ("com", "frame"):
        table.fault(f'inertia_about = "{about}" is not known; write "com" or "frame"')
    elif "inertia" in table and "inertia_about" not in table:
        table.fault('inertia_about is missing; write "com" (centre of mass) or "frame" (origin of the body frame)')
    if "first_moment" in table:
        if "com" in table:
            table.fault("com and first_moment say the same thing twice; give one of them")
        if about == "com":
            table.fault(
                'first_moment goes with inertia_about = "frame"; give com instead, or the inertia about the frame'
            )
    return Body(
        name=entry.name,
        mass=table.quantity("mass"),
        com=None if "first_moment" in table else table.vector("com"),
        first_moment=table.vector("first_moment") if "first_moment" in table else None,
        inertia=_inertia(table),
        about=about,
        particles=_particles(table, faults),
        allow_invalid_inertia=table.flag("allow_invalid_inertia"),
        shape=_shape(table, faults) if "shape" in table else None,
    )


def _inertia(table: Table) -> tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity]:
    """Return (xx, yy, zz, xy, xz, yz) from a diagonal, a table of entries or a symmetric matrix."""
    nothing = (Quantity.ZERO,) * 6
    raw = plain(table.raw.get("inertia", (0, 0, 0)))
    try:
        if isinstance(raw, Mapping):
            for key in raw:
                if key not in INERTIA_KEYS:
                    raise FormulaError(f"has an unknown key {show(str(key))}; {suggestion(str(key), INERTIA_KEYS)}")
            xx, yy, zz, xy, xz, yz = (quantity(raw.get(key, 0)) for key in INERTIA_KEYS)
            return xx, yy, zz, xy, xz, yz
        if not isinstance(raw, (list, tuple)) or len(raw) != 3:
            raise FormulaError("is neither [xx, yy, zz] nor a table { xx = 1, yy = 1, zz = 1, xy = 0, xz = 0, yz = 0 }")
        if not any(isinstance(row, (list, tuple)) for row in raw):
            return (*vector(raw), Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
        rows = [vector(row) for row in raw]
        if any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise FormulaError("is not symmetric; entry [i][j] must equal entry [j][i]")
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = rows
    except FormulaError as error:
        table.refuse("inertia", error)
        return nothing
    return xx, yy, zz, xy, xz, yz


def _shape(table: Table, faults: Faults) -> Outline | None:
    """Return what a body looks like, from a word or a table with sizes."""
    raw = plain(table.raw["shape"])
    if isinstance(raw, Outline):
        return raw
    given: Mapping[str, object] = raw if isinstance(raw, Mapping) else {"type": raw}
    if not isinstance(given.get("type"), str) or given["type"] not in OUTLINES:
        known = ", ".join(f'"{word}"' for word in OUTLINES)
        table.fault(f"shape = {show(raw)} is not known; write one of {known}, or a table with such a type")
        return None
    kind = OUTLINES[str(given["type"])]
    keys = ("type", *(() if kind.axis is None else ("axis",)), *kind.sizes)
    row = Table(Entry("", given, f"{table.entry.where}: shape"), faults, keys)
    sizes = tuple((size, row.quantity(size)) for size in kind.sizes if size in row)
    for size, length in sizes:
        if isinstance(length.value, Fraction) and length.value <= 0:
            row.fault(f"{size} = {shown(length)} is no length; give one above zero")
    bare = all(entry == Quantity.ZERO for entry in _inertia(table)) or table.quantity("mass") == Quantity.ZERO
    if bare and len(sizes) < len(kind.sizes):
        row.fault(f"{' and '.join(kind.sizes)} missing, which no inertia tells; write them beside type")
    axis = row.vector("axis") if "axis" in row else None
    if axis is not None and (any(x.symbols for x in axis) or axis == NULL):
        row.fault("axis is no direction in numbers; give one such as [0, 0, 1]")
        axis = None
    return Outline(str(given["type"]), sizes, axis)


def _particles(table: Table, faults: Faults) -> tuple[Particle, ...]:
    raw = table.raw.get("particles", ())
    advice = 'give a list such as [{ mass = "m1", at = [0, 0, 0] }]'
    if not isinstance(raw, (list, tuple)):
        table.fault(f"particles = {show(raw)} is not a list; {advice}")
        return ()
    if len(raw) > MOST_PARTICLES:
        table.fault(
            f"particles lists {len(raw)}; {MOST_PARTICLES} are allowed, give the mass, com and inertia of all together"
        )
        return ()
    particles = []
    for k, item in enumerate(raw):
        if isinstance(item, Particle):
            particles.append(item)
            continue
        if not isinstance(item, Mapping):
            table.fault(f"particles[{k}] = {show(item)} is not a table; {advice}")
            continue
        row = Table(Entry("", item, f"{table.entry.where}: particles[{k}]"), faults, ("mass", "at"))
        for key in ("mass", "at"):
            if key not in row:
                row.fault(f"{key} is missing; {advice}")
        particles.append(Particle(row.quantity("mass"), row.vector("at")))
    return tuple(particles)
