"""What readers of URDF and SDF share: numbers of XML elements, inertias, limits, names, and what is told of them.

Numbers are exact as written, angles snapped, every fault collected.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from decimal import Decimal

from symdyn.errors import listed
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.inertias import Entries, turned
from symdyn.scene.formats.placing import printable_names, snap_angle
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values import folding
from symdyn.scene.values.body import Step
from symdyn.scene.values.entry import Faults, show
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector, spell

_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?\Z", re.ASCII)


class Attributes:
    """Typed access to attributes. What cannot be read is a fault, and a usable stand-in takes its place."""

    def __init__(self, faults: Faults, snap: bool) -> None:
        """Remember where faults go and whether angles are snapped to multiples of π."""
        self.faults, self.snap = faults, snap
        self._snapped: dict[tuple[str, Quantity], list[str]] = {}

    def text(self, where: str, element: XmlElement, key: str, advice: str) -> str:
        """Return text that must be given, "" after a fault."""
        value = element.attributes.get(key, "").strip()
        if not value:
            self.faults.add(where, f"<{element.tag}> has no {key}; {advice}")
        return value

    def number(self, where: str, element: XmlElement, key: str, default: Quantity | None = Quantity.ZERO) -> Quantity:
        """Return a number; one that must be given has no default."""
        if key not in element.attributes:
            if default is None:
                self.faults.add(where, f'<{element.tag}> has no {key}; give a number such as {key}="1.0"')
            return default or Quantity.ZERO
        return self._read(where, element, key, element.attributes[key].strip())

    def angle(self, where: str, element: XmlElement, key: str) -> Quantity:
        """Return an angle, rad; 0 when it is not given."""
        value = self.number(where, element, key)
        return self._snap(where, key, element.attributes.get(key, ""), value)

    def vector(self, where: str, element: XmlElement | None, key: str, default: Vector = NULL) -> Vector:
        """Return three numbers; the default when the element or the attribute is not there."""
        words = self._three(where, element, key)
        if element is None or words is None:
            return default
        return self._triple([self._read(where, element, key, word) for word in words])

    def angles(self, where: str, element: XmlElement | None, key: str) -> Vector:
        """Return three angles, rad; zeros when the element or the attribute is not there."""
        words = self._three(where, element, key)
        if element is None or words is None:
            return NULL
        place = f"<{element.tag}> {key}"
        values = [self._snap(where, place, word, self._read(where, element, key, word)) for word in words]
        return self._triple(values)

    def note_snaps(self) -> None:
        """Note every angle that was read as a multiple of π, one line for each spelling."""
        for (text, value), places in self._snapped.items():
            self.faults.note("", f"{text} is read as {spell(value)} in {', '.join(places)}")

    def _three(self, where: str, element: XmlElement | None, key: str) -> list[str] | None:
        if element is None or key not in element.attributes:
            return None
        words = element.attributes[key].split()
        if len(words) == 3:
            return words
        shown = show(element.attributes[key])
        advice = f'three are needed, such as {key}="0 0 1"'
        self.faults.add(where, f"<{element.tag}> {key}={shown} has {len(words)} numbers; {advice}")
        return None

    def _triple(self, values: list[Quantity]) -> Vector:
        x, y, z = values
        return (x, y, z)

    def _read(self, where: str, element: XmlElement, key: str, text: str) -> Quantity:
        try:
            if not _DECIMAL.match(text):
                raise FormulaError("is not a decimal number; write one such as 0.35 or 1e-3")
            return quantity(Decimal(text))
        except FormulaError as error:
            reason = str(error)
            verb = "" if reason.startswith("is ") else "cannot be used: "
            self.faults.add(where, f"<{element.tag}> {key}={show(text)} {verb}{reason}")
            return Quantity.ZERO

    def _snap(self, where: str, place: str, text: str, value: Quantity) -> Quantity:
        snapped = snap_angle(text) if self.snap and value != Quantity.ZERO else None
        if snapped is None:
            return value
        places = self._snapped.setdefault((text.strip(), snapped), [])
        name = f"{where} {place}"
        if name not in places:
            places.append(name)
        return snapped


UNLIMITED = 10**9
"""A limit of this size or more is none: the format demands numbers, and files write 1e9 or 1e16 for "no limit"."""

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class RobotFile:
    """One walk over one file.

    Attributes:
        attributes: reads numbers.
        data: what is told of several elements at the end, with their names.
    """

    def __init__(self, root: XmlElement, faults: Faults, options: ReadOptions) -> None:
        """Remember the root element, and where faults go."""
        self.root, self.faults = root, faults
        self.source = faults.source
        self.attributes = Attributes(faults, options.snap)
        self.data: dict[str, list[str]] = {}

    def note(self, what: str, name: str) -> None:
        """Note something of one element; what is noted of several is one line."""
        self.data.setdefault(what, []).append(name)

    def note_data(self) -> None:
        """Note what was snapped, and what was read that the equations do not hold, or that other tools leave out."""
        self.attributes.note_snaps()
        for what, names in self.data.items():
            self.faults.note("", f"{what} ({listed(names)})")

    def named(self, element: XmlElement) -> tuple[str, XmlElement]:
        """Return an element with its name, "" after a fault."""
        name = element.attributes.get("name", "").strip()
        if not name:
            advice = f'give one such as name="{element.tag}_1"'
            self.faults.add(f"line {element.line}", f"<{element.tag}> has no name; {advice}")
        return name, element

    def where(self, name: str, element: XmlElement) -> str:
        return f"line {element.line}: {element.tag} {name}".rstrip()

    def printable(self, names: Sequence[str], kind: str) -> dict[str, str]:
        """Return a printable name for each name, with a note for each that is another one."""
        chosen = printable_names(names, kind)
        for name, better in chosen.items():
            if name != better:
                self.faults.note(f"{kind} {show(name)}", f"is called {better} here")
        return chosen

    def inertia(
        self, where: str, element: XmlElement, turn: Sequence[Step], default: Mapping[str, Quantity] | None = None
    ) -> dict[str, object]:
        """Return the keys of a body that say its inertia about the centre of mass.

        Args:
            where: for messages.
            element: <inertia>, products being matrix entries.
            turn: of its axes in the frame of the link.
            default: of what it leaves out; without it, all six must be given.
        """
        xx, yy, zz, xy, xz, yz = (
            self.attributes.number(where, element, key, default[key] if default else None) for key in INERTIA
        )
        entries: Entries = turned((xx, yy, zz, xy, xz, yz), turn)
        named = dict(zip(("xx", "yy", "zz", "xy", "xz", "yz"), entries, strict=True))
        return {"inertia": named, "inertia_about": "com"}

    def limits(self, where: str, limit: XmlElement, keys: Mapping[str, Quantity | None]) -> dict[str, Quantity]:
        """Return the limits of a joint, as far as there are some.

        Args:
            where: for messages.
            limit: <limit>.
            keys: what is read of it, and what stands for what is not given; None where it must be.
        """
        limits = {}
        for key, default in keys.items():
            if limit.attributes.get(key, "").strip().lstrip("+-").lower() in ("inf", "infinity"):
                continue
            value = self.attributes.number(where, limit, key, default)
            size = folding.fraction(value)
            if size is None or -UNLIMITED < size < UNLIMITED:
                limits[key] = value
        low, high = (folding.fraction(limits[key]) if key in limits else None for key in ("lower", "upper"))
        if low is not None and high is not None and low > high:
            shown = (f"{key}={show(limit.attributes.get(key, '0'))}" for key in ("lower", "upper"))
            self.faults.add(where, f"<limit> {' is above '.join(shown)}; swap them")
            return {}
        return limits
