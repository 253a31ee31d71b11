"""Reading one declared table: every fault is collected, a usable stand-in takes its place, reading goes on."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

from symdyn.arguments import SympyExpression, argument, is_sympy
from symdyn.errors import SceneError, SimulateError, hint, nearest, printable, spoken, suggestion, without_long_words
from symdyn.frozen import dataclass
from symdyn.scene.values.body import ELEMENTARY, UNMOVED, Pose
from symdyn.scene.values.formula import formula_text, quantity
from symdyn.scene.values.grammar import check_words
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector, spell

T = TypeVar("T")

MOST_FAULTS = 100
"""Faults that are told together; a file with more of them is broken as a whole, and looking on would only cost time."""

DEEPEST = 2
"""Levels of a nested value that a message shows below the first."""

LONGEST_PART = 600
"""Characters of a place, or of what is wrong there, that a message shows."""


class Faults:
    """The faults of one scene, in the order they were found, and notes of what is doubtful but no fault."""

    def __init__(self, source: str) -> None:
        """Start without faults; `source` stands in front of every one."""
        self.source = source
        self.lines: list[str] = []
        self.notes: list[str] = []

    def add(self, where: str, what: str) -> None:
        """Add a fault: where, what was found, what would work.

        Raises:
            SceneError: there are `MOST_FAULTS` now, so that reading ends here.
        """
        line = self._line(where, what)
        if line not in self.lines:
            self.lines.append(line)
        if len(self.lines) >= MOST_FAULTS:
            raise SceneError([*self.lines, self._line("", f"has {MOST_FAULTS} faults up to here; mend these first")])

    def nameless(self, where: str, key: str, name: str) -> None:
        """Add a fault for an empty name; readers leave one behind where they have reported a fault already."""
        if not name and not self.told(where):
            self.add(where, f'{key} = "" names nothing; write a name')

    def told(self, where: str, begin: str = "") -> bool:
        """Tell whether a place has a fault, or one whose words begin so."""
        return any(line.startswith(f"{self._line(where, '')}: {begin}") for line in self.lines)

    def note(self, where: str, what: str) -> None:
        """Add a note: where, what was found, what became of it."""
        self.notes.append(self._line(where, what))

    def _line(self, where: str, what: str) -> str:
        what = without_long_words(what)
        told = (part if len(part) <= LONGEST_PART else f"{part[:LONGEST_PART]}..." for part in (shorten(where), what))
        line = ": ".join(part for part in (self.source, *told) if part)
        return printable(line, keep="")  # no name breaks a line, to begin one that looks like ours

    @property
    def own(self) -> bool:
        """Whether they are of a scene in TOML or Python."""
        return Path(self.source).suffix in ("", ".toml")

    @property
    def excuse(self) -> str:
        """How to keep an inertia that no body has; a robot file has no key for it."""
        return (
            "write allow_invalid_inertia = true" if self.own else f"read with {argument('allow_invalid_inertia', True)}"
        )

    @property
    def unchecked(self) -> str:
        """How to have no dimensions checked, of a scene that is dimensionless on purpose."""
        return (
            'write units = "none" at the top' if self.own else "read with " + argument("no_units", True, 'units="none"')
        )

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Take the faults that a block ends with to the others."""
        try:
            yield
        except (SceneError, SimulateError) as error:
            self.lines += error.faults

    def taken(self, part: Callable[[], T], otherwise: Any) -> T:
        """Return what a part returns; after a fault, which is taken to the others, something else."""
        with self.noted():
            return part()
        return otherwise

    def close(self, error: Callable[[Sequence[str]], Exception] = SceneError) -> None:
        """Raise all faults together, if there are any."""
        if self.lines:
            raise error([*dict.fromkeys(self.lines)])


@dataclass(frozen=True)
class Entry:
    """A declared table, as raw as the user wrote it."""

    name: str  # of the parameter, body, joint or point
    table: Mapping[str, object]  # its keys and raw values
    where: str  # for messages, such as "bodies.link1"


def show(value: object, depth: int = 0) -> str:
    """Return a raw value as a scene file would write it, shortened for a message."""
    if depth > DEEPEST:
        return "..."
    if value is True or value is False:
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, Mapping):
        text = "{" + ", ".join(f"{key} = {show(item, depth + 1)}" for key, item in list(value.items())[:9]) + "}"
    elif isinstance(value, (list, tuple)):
        text = f"[{', '.join(show(item, depth + 1) for item in value[:9])}]"
    else:
        text = spoken(value) if not isinstance(value, int) or abs(value) < 10**80 else "a very long integer"
    return shorten(" ".join(text.split()))


def shorten(text: str) -> str:
    """Return text that fits a message."""
    return text if len(text) <= 100 else text[:97] + "..."


def shown(quantity: Quantity) -> str:
    """Return a quantity for a message."""
    return shorten(spell(quantity))


def plain(value: object) -> object:
    """Return arrays, and a row or column of SymPy, as lists; everything else as it is."""
    line = is_sympy(value) and 1 in getattr(value, "shape", ())
    convert = getattr(value, "flat" if line else "tolist", None)
    return convert() if callable(convert) else value


def as_list(value: object) -> list[object]:
    """Return a list as it is, anything else that is given as the only entry of one."""
    value = plain(value)
    return [] if value is None else list(value) if isinstance(value, (list, tuple)) else [value]


class EntryReader:
    """Typed access to the keys of a declared table; what is wrong is a fault of its place."""

    def __init__(self, entry: Entry, faults: Faults, keys: Sequence[str], refused: Sequence[str] = ()) -> None:
        self.entry, self.faults, self.raw = entry, faults, entry.table
        for key in entry.table:
            if key not in keys and key not in refused:  # which its reader reports
                section, _, name = entry.where.rpartition(": ")[2].partition(".")
                near = "stiffness" if nearest(str(key), (*keys, "stiffness")) == "stiffness" else str(key)
                told = hint("keys", near, [section]).replace("$", name).replace("@", show(entry.table[key]))
                self.fault(f"unknown key {show(str(key))}; {told or suggestion(str(key), keys)}")

    def fault(self, what: str) -> None:
        self.faults.add(self.entry.where, what)

    def __contains__(self, key: str) -> bool:
        return key in self.raw

    def quantity(self, key: str, default: Quantity = Quantity.ZERO) -> Quantity:
        return self.parsed(key, default, quantity) if key in self else default

    def vector(self, key: str, default: Vector = NULL) -> Vector:
        return self.parsed(key, default, vector) if key in self else default

    def pose(self, key: str, default: Pose = UNMOVED) -> Pose:
        return self.parsed(key, default, pose) if key in self else default

    def text(self, key: str, default: str = "") -> str:
        """Return text: one line of bearable length."""
        value = self.raw.get(key, default)
        if isinstance(value, str):
            fault = check_words(value)
            if fault is None:
                return value
            self.fault(f"{key} = {show(value)} {fault}")
            return default
        self.fault(f'{key} = {show(value)} is not text; put it in quotes, such as {key} = "{default or "m1"}"')
        return default

    def flag(self, key: str, default: bool = False) -> bool:
        value = self.raw.get(key, default)
        if isinstance(value, bool):
            return value
        self.fault(f"{key} = {show(value)} is neither true nor false")
        return default

    def inner(self, key: str, keys: Sequence[str], advice: str) -> EntryReader:
        """Return the table under a key that is given; an empty one after a fault."""
        raw = self.raw[key]
        if not isinstance(raw, Mapping):
            self.fault(f"{key} = {show(raw)} is not a table; {advice}")
            raw = {}
        return EntryReader(Entry(key, raw, f"{self.entry.where}: {key}"), self.faults, keys)

    def parsed(self, key: str, default: T, reader: Callable[[object], T]) -> T:
        """Return what a reader makes of a value that is given; after a fault, which it raises, the default."""
        try:
            return reader(plain(self.raw[key]))
        except FormulaError as error:
            self.refuse(key, error)
            return default

    def refuse(self, key: str, error: FormulaError) -> None:
        """Report a value that its reader refused."""
        shown, reason = show(self.raw[key]), str(error).replace("write [", f"write {key} = [")
        if reason.startswith(shown):  # the formula reader quotes the text itself
            self.fault(f"{key} = {reason}")
        else:
            self.fault(f"{key} = {shown}{' ' if reason.startswith(('is ', 'has ')) else ': '}{reason}")


def quantities(values: Iterable[object]) -> tuple[Quantity, ...]:
    """Return numbers or formulas; FormulaError where one of them is none."""
    return tuple(quantity(plain(one)) for one in values)


def vector(value: object) -> Vector:
    """Return three quantities from a list.

    Raises:
        FormulaError: it is no list of three numbers or formulas.
    """
    value = plain(value)
    if not isinstance(value, (list, tuple)):
        listed = as_vector(value)
        raise FormulaError(f"is not a list of three; {f'write {listed}' if listed else 'give one such as [0, 0, 1]'}")
    if len(value) != 3:
        has = "1 entry" if len(value) == 1 else f"{len(value)} entries"
        raise FormulaError(f"has {has}; three are needed, such as [0, 0, 1]")
    return (quantity(value[0]), quantity(value[1]), quantity(value[2]))


def as_vector(value: object, size: str = "1") -> str:
    """Return the list of three that text means: a letter, "-x", or three numbers; "" where it means none."""
    text = str(value).strip().lower()
    letter = re.fullmatch(r"([+-]?) ?(?:e_?)?([xyz])(?:[ _-]?axis)?", text)
    parts = [letter[1].strip("+") + size if letter[2] == one else "0" for one in "xyz"] if letter else []
    parts = parts or re.split(r"[\s,;]+", text.strip("()[] "))
    return f"[{', '.join(parts)}]" if len(parts) == 3 and all(re.fullmatch(r"-?[\d.]+", x) for x in parts) else ""


def pose(value: object) -> Pose:
    """Return a placement from {xyz, rpy}, from three coordinates, or from a list of elementary steps.

    The angles are those of URDF: about the fixed axes, roll first, so that R = Rz(yaw) Ry(pitch) Rx(roll).

    Raises:
        FormulaError: it is none of these.
    """
    if isinstance(value, Pose):
        return value
    if isinstance(value, Mapping):
        for key in value:
            if key not in ("xyz", "rpy"):
                raise FormulaError(f"has an unknown key {show(str(key))}; {suggestion(str(key), ('xyz', 'rpy'))}")
        shift = vector(value.get("xyz", NULL))
        roll, pitch, yaw = vector(value.get("rpy", NULL))
        return compose(*zip(("Tx", "Ty", "Tz"), shift, strict=True), ("Rz", yaw), ("Ry", pitch), ("Rx", roll))
    if not isinstance(value, (list, tuple)):
        raise FormulaError("is not a placement; give { xyz = [0, 0, 0], rpy = [0, 0, 0] }")
    if value and not any(isinstance(item, (list, tuple)) for item in value) and str(value[0]) not in ELEMENTARY:
        return compose(*zip(("Tx", "Ty", "Tz"), vector(value), strict=True))
    steps = []
    for step in value:
        if not isinstance(step, (list, tuple)) or len(step) != 2 or step[0] not in ELEMENTARY:
            raise FormulaError(f'is not made of steps: {show(step)}; give a list such as [["Tz", 0.1], ["Rx", "pi/2"]]')
        steps.append((str(step[0]), quantity(step[1])))
    return compose(*steps)


STRAIGHT = ("Tx", "Ty", "Tz", "Rz", "Ry", "Rx")
"""The steps of { xyz, rpy }, in their order."""


def said_pose(pose: Pose) -> object:
    """Return [x, y, z], { xyz, rpy } or a list of steps, the first of them that says the same."""
    steps = compose(*pose.steps).steps
    kinds = [kind for kind, _ in steps]
    if kinds != sorted(set(kinds), key=STRAIGHT.index):
        return [list(step) for step in steps]
    placed = dict.fromkeys(ELEMENTARY, Quantity.ZERO) | dict(steps)
    xyz, rpy = ([placed[kind] for kind in part] for part in (ELEMENTARY[:3], ELEMENTARY[3:]))
    if not any(kind.startswith("R") for kind in kinds):
        return xyz
    return ({"xyz": xyz} if any(kind.startswith("T") for kind in kinds) else {}) | {"rpy": rpy}


def compose(*steps: tuple[str, Quantity]) -> Pose:
    """Return the product of elementary motions, without those that do nothing."""
    return Pose(tuple(step for step in steps if step[1] != Quantity.ZERO))


# In Python

Number = int | float | Fraction | str | Quantity | SympyExpression
Three = Sequence[Number]
Placement = Pose | Mapping[str, Three] | Sequence[object]
"""What a user writes in Python wherever a scene wants a number, a direction or a placement."""


def rows_of(points: Any) -> Any:
    """Return the rows of what has columns, or values, by name: a dict, what pandas has; all else as it is."""
    if not hasattr(points, "items"):
        return points
    columns = [one for _, one in points.items()]
    return list(zip(*columns, strict=True)) if all(hasattr(one, "__len__") for one in columns) else list(points.items())


def entry(kind: str, name: str, **table: object) -> Entry:
    """Return a table of what was given; what is None or at its default was not."""
    given = {key: value for key, value in table.items() if value is not None}
    return Entry(str(name), given, f"{kind}.{name}")


def names_in(found: Any) -> dict[Any, str]:
    """Return the symbols, functions and derivatives of an expression of SymPy, each with its name in formulas."""
    from sympy import Derivative, Symbol
    from sympy.core.function import AppliedUndef

    names = {one: str(one) for one in found.atoms(Symbol, AppliedUndef, Derivative)}
    for one in names:
        with suppress(FormulaError):
            names[one] = formula_text(one)
    return names
