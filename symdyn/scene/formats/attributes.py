"""Numbers in attributes of XML elements: exact as written, angles snapped, every fault collected."""

from __future__ import annotations

import re
from decimal import Decimal

from symdyn.scene.formats.snap import snap_angle
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector
from symdyn.scene.values.spelling import spell
from symdyn.scene.values.table import Faults, show

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
