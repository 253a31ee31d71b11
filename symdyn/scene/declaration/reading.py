"""Files of scenes: their contents, what a reader is asked and answers, what a writer answers and cannot hold.

A letter's value and unit as a table says them: `{ value = 500, unit = "mm" }`, `"500 mm"`, or a unit alone.

The value becomes SI, and its unit the coherent one; the unit that was chosen is kept, for whoever writes the scene.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from os import PathLike, fsdecode
from pathlib import Path
from typing import ClassVar, Protocol

from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError, beside
from symdyn.frozen import dataclass
from symdyn.resources import example_files
from symdyn.scene.forces.force_table import FORCES, place_of
from symdyn.scene.values.dimensional_analysis import fits
from symdyn.scene.values.entry import EntryReader
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.letters import Letter
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, spell
from symdyn.scene.values.unit import Unit, UnitError, in_si, out_of_si

_ENCODING = r"""\A(\ufeff?\s*<\?xml\s[^>]{0,200}?)\sencoding\s*=\s*(?:"[^"]*"|'[^']*')"""

BEGIN = "check the path, or begin a scene with symdyn new"
"""What to do where there is no scene."""

LARGEST = BOUNDS["bytes of an XML file"]
"""No reader of scenes takes more bytes."""


class Readable(Protocol):
    """An open file, of text or of bytes, or what else is read like one."""

    def read(self, size: int, /) -> str | bytes:
        """Return at most so many characters or bytes."""


@dataclass(frozen=True)
class Opened:
    """An open stream, in place of a file."""

    path: Path  # its name, that of a file or another; what it names stands in its folder
    content: bytes  # all that was left to be read in it

    def __str__(self) -> str:
        return str(self.path)


def opened(file: Readable) -> Opened:
    """Return what is left to be read in an open file; of more than any reader takes, as much as is too much.

    Raises:
        SceneError: it cannot be read, and why, or nothing is left in it.
    """
    name = getattr(file, "name", None)
    path = Path(fsdecode(name) if isinstance(name, (str, bytes, PathLike)) else "scene")
    try:
        content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if not isinstance(content, (str, bytes)):
        raise SceneError(f"{path}: gives {type(content).__name__} to be read; give a file opened for text or bytes")
    if not content:
        raise SceneError(f"{path}: nothing is left to be read; an open file is read once, seek(0) goes back")
    if isinstance(content, str):  # its declaration tells the encoding that it had
        content = re.sub(_ENCODING, r"\1", content, count=1).encode("utf-8", "surrogatepass")
    return Opened(path, content)


def read_bounded(path: Path | Opened, most: int, requested: str, advice: str, missing: str = "check the path") -> bytes:
    """Return the contents of a file of at most `most` bytes: a device without an end, or a film, fills no memory.

    Args:
        path: of the file, or the file that is open already.
        most: a multiple of 2**20.
        requested: what kind of file, such as "a scene file".
        advice: behind the message that the file is larger.
        missing: behind the message that there is none.

    Raises:
        SceneError: it cannot be read, and why, or holds more.
    """
    try:
        if isinstance(path, Opened):
            content = path.content
        else:
            with path.open("rb") as file:
                content = file.read(most + 1)
    except FileNotFoundError:
        if missing == BEGIN and isinstance(path, Path) and path.stem in example_files():  # as pages name it
            missing = f"symdyn new --example {path.stem} writes the scene of that name that comes with the package"
        missing = beside(Path(str(path)), missing)
        raise SceneError(f"{path}: there is no such file; {missing}") from None
    except IsADirectoryError:
        raise SceneError(f"{path}: is a folder; give {requested}") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if len(content) > most:
        raise SceneError(f"{path}: holds more than {most >> 20} MB; {advice}")
    return content


@dataclass(frozen=True)
class ReadOptions:
    """How to read a file.

    Attributes:
        snap: whether a decimal of at least eight digits that is a small rational multiple of π, correctly rounded at
            them, is read as that multiple.
        allow_invalid_inertia: whether inertias that no body has are notes instead of faults.
        spanning_tree: names of the joints to cut where joints close loops; None chooses them, with a note for each.
        floating_base: name of a free joint with a quaternion between the ground and the root of a robot; None: the root
            is the ground.
        dimensionless: whether no dimensions are checked, as of a scene that says so itself.
    """

    snap: bool = True
    allow_invalid_inertia: bool = False
    spanning_tree: tuple[str, ...] | None = None
    floating_base: str | None = None
    dimensionless: bool = False


@dataclass(frozen=True)
class Reading:
    """A scene as it was read.

    Attributes:
        scene: checked and in order.
        notes: what the reader changed, doubts or leaves out of the equations, one line each, "<source>: " in front.
    """

    UNUSED: ClassVar = "no formula of the scene has it"  # end of a note; a formula of a request may have it

    scene: Scene
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Written:
    """A scene as text of some format, and what that cannot hold, one line each."""

    text: str
    lost: tuple[str, ...] = ()


def lost_words(scene: Scene) -> Iterator[str]:
    """Return what robot files have no words for, one line each: loops, what acts, and where a scene starts."""
    yield from (f"loops.{one.name}: closes a loop, and the file holds trees" for one in scene.loops)
    yield from (f"{place_of(one)}: {FORCES[one.kind].lost}" for one in scene.elements)
    for body in scene.bodies:
        if body.shape is not None:
            yield f"bodies.{body.name}: shape = {body.shape.type}: what it looks like"
    for joint in scene.joints:
        where = f"joints.{joint.name}"
        if any(force != Quantity.ZERO for force in joint.forces):
            shown = ", ".join(spell(force) for force in joint.forces)
            yield f"{where}: force = {shown}: there are no forces in formulas"
        if joint.dry is not None:
            yield f"{where}: {FORCES[joint.dry.kind].lost}"
        if joint.limits.restitution is not None:
            yield f"{where}: limits.restitution: the file has limits that nothing strikes"
        if joint.limits.one_way:
            yield f"{where}: limits.one_way: {FORCES['one_way'].lost}"
        if joint.motion is not None:
            yield f"{where}: motion = {spell(joint.motion)}"
        if any(x != Quantity.ZERO for x in (*joint.start, *joint.start_rates)):
            yield f"{where}: where it starts"
    yield from (f"inputs.{one.name}: the file has no inputs" for one in scene.inputs)
    yield from (f"states.{one.name}: the file has no states" for one in scene.states)
    yield from (f"outputs.{one.name} = {spell(one.formula)}: the file has no outputs" for one in scene.outputs)


@dataclass(frozen=True)
class Valued:
    """A value with its unit."""

    value: Quantity | None = None  # in SI; None where none is said
    unit: str = ""  # the coherent unit, "" where none is said
    written: str = ""  # the unit that was chosen, where it is another one


def read_valued(table: EntryReader) -> Valued:
    """Return what `value` and `unit` of a table say; what is wrong with them is a fault of the table."""
    text = table.text("unit")
    value: Quantity | None = table.parsed("value", None, quantity) if "value" in table else None
    try:
        unit = Unit.read(text) if text else None
    except UnitError as error:
        table.refuse("unit", error)
        return Valued(value)
    if value is not None and value.symbols and unit is not None and not unit.is_coherent:
        table.fault(_incoherent("unit", text, unit))
        unit = Unit.read(unit.si)
    try:
        # a bare number is in the unit beside it, one with a unit of its own is converted
        if value is None or not value.unit:
            return valued(value and in_si(value, unit) if unit else value, unit)
        fits(value, unit)
        return valued(value, unit or Unit.read(value.unit))
    except FormulaError as error:
        table.refuse("value", error)
        return valued(None, unit)


def said_value(letter: Letter) -> tuple[Quantity | None, str]:
    """Return a letter's value and unit as its writer chose it, wherever that reads as the same value again."""
    value, unit = letter.value, letter.unit
    if value is not None and value.unit:
        return value, "" if value.unit == (letter.written or unit) else letter.written or unit
    if letter.written:
        chosen = Unit.read(letter.written)
        there = None if value is None else out_of_si(value, chosen)
        if there is None or in_si(there, chosen) == value:
            return there, letter.written
    return value, unit


def read_coherent(table: EntryReader, key: str, usual: str) -> str:
    """Return the unit of a table whose formula is computed, which is in SI."""
    text = table.text(key, usual)
    try:
        unit = Unit.read(text) if text else None
    except UnitError as error:
        table.refuse(key, error)
        return usual
    if unit is None or unit.is_coherent:
        return text
    table.fault(_incoherent(key, text, unit))
    return unit.si


def _incoherent(key: str, text: str, unit: Unit) -> str:
    return f'{key} = "{text}" is of numbers that are not in SI, and what is computed is; write "{unit.si}"'


def valued(value: Quantity | None, unit: Unit | None) -> Valued:
    """Return a value in SI beside the unit that was chosen."""
    if unit is None:
        return Valued(value)
    return Valued(value, unit.si, "" if unit.is_coherent else unit.text)


def value_for(letter: Letter, raw: object) -> tuple[Quantity, str, str]:
    """Return a value that is given to a letter, SI where it has no unit of its own; and the letter's units then.

    Raises:
        FormulaError: it is no value, or one of another kind.
    """
    value = quantity(raw)
    if not value.unit:
        return value, letter.unit, letter.written
    unit = Unit.read(letter.unit) if letter.unit else None
    fits(value, unit)
    own = valued(value, unit or Unit.read(value.unit))
    return value, own.unit, letter.written if unit else own.written
