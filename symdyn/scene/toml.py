"""Scenes from TOML files, and as such. Numbers keep the digits they are written with; faults name file, table and key.

Read back, what was written is the same scene, digit for digit. What has its default value is not written. Formulas come
in the reader's normal form, so that the text of a scene that was read, read and written again, is the same text.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from decimal import Decimal, Inexact, InvalidOperation
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

from symdyn.arguments import checked
from symdyn.bounds import BOUNDS
from symdyn.errors import SceneError, hint, listed, nearest, suggestion
from symdyn.scene.declaration.declare import SECTIONS, Declaration, reading_of
from symdyn.scene.declaration.joint_table import Standing, said_joint, said_place
from symdyn.scene.declaration.reading import BEGIN, Opened, Reading, ReadOptions, Written, read_bounded
from symdyn.scene.declaration.scene_table import BODY, HEAD, INPUT, OUTPUT, PARAMETER, POINT, SHORT
from symdyn.scene.declaration.states import SIGNAL, STATE
from symdyn.scene.declaration.tables import TABLE
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import place_of, sections, table_of
from symdyn.scene.places import place_at, placing
from symdyn.scene.values.body import Pose
from symdyn.scene.values.entry import Entry, Faults, shorten, show
from symdyn.scene.values.folding import tables_in
from symdyn.scene.values.grammar import check_scene_name
from symdyn.scene.values.key import Part, keys_of, raw_of
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity, exact_decimal, spell
from symdyn.scene.values.unit import Unit, in_si, out_of_si

LARGEST_FILE = BOUNDS["bytes of a TOML file"]
MOST_VALUES = BOUNDS["values of a TOML file"]
DEEPEST = BOUNDS["levels of a TOML file"]
MOST_PARTS = BOUNDS["parts of a dotted key"]
"""Bounds of a file: bytes, values, nesting, parts of a dotted key. A chain of 5000 bodies takes a third of them."""

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""

_DOTTED = (
    rf'"""(?s:[^\\]|\\.)*?"""|{chr(39) * 3}(?s:.)*?{chr(39) * 3}|#.*|(?P<key>{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*+)'
)
"""Texts of several lines and comments, or else a dotted key; a text of one line, a word and a number look like one."""


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in a TOML file, and notes.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    content = read_bounded(path, LARGEST_FILE, "a scene file such as arm.toml", "no mechanism needs as much", BEGIN)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8", "replace")
        place = place_at(before, len(before))
        told = f"{path}:{place.line}: byte {error.start} is not UTF-8; save the file as UTF-8 text"
        raise SceneError(told, [place]) from None
    return _reading(text, Faults(str(path)), options)


@checked(SceneError)
def read_text(text: str, source: str = "scene.toml") -> Scene:
    """Return the scene in TOML text.

    Args:
        text: the contents of a scene file.
        source: stands in front of every fault; its stem is the name of a scene that gives none.

    Raises:
        SceneError: with every fault of the text, one line each.
    """
    return _reading(text, Faults(source), ReadOptions()).scene


def _reading(text: str, faults: Faults, options: ReadOptions) -> Reading:
    with placing(text, faults.source):
        return reading_of(_declaration(_tables_of(text, faults.source), faults.source, faults), faults, options)


def tables_of(text: str, source: str) -> dict[str, object]:
    """Return the tables of TOML text; numbers with a point are decimals.

    Raises:
        SceneError: it is no TOML, or has more values, or deeper ones, than any file of ours.
    """
    with placing(text, source):
        return _tables_of(text, source)


def _tables_of(text: str, source: str) -> dict[str, object]:
    _refuse_long_keys(text, source)
    try:
        root = tomllib.loads(text.removeprefix("\ufeff"), parse_float=_decimal)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{source}: {_reworded(str(error), text)}") from None
    except (ValueError, RecursionError) as error:
        long = "an integer has more digits than any number needs"  # int refuses it in words for programmers
        reason = "it nests too deep" if isinstance(error, RecursionError) else long
        raise SceneError(f"{source}: is not TOML that can be read: {reason}") from None
    _refuse_many_values(root, source)
    return root


def _refuse_long_keys(text: str, source: str) -> None:
    """Refuse keys of many parts, on which the parser spends the square of their number."""
    if all(line.count(".") < MOST_PARTS for line in text.splitlines()):
        return
    for found in re.finditer(_DOTTED, text):
        parts = re.findall(_PART, found["key"] or "")
        if len(parts) > MOST_PARTS:
            line = text.count("\n", 0, found.start()) + 1
            told = f"{shorten(found['key'])} is a key of {len(parts)} parts; no key of a scene has more than three"
            raise SceneError(f"{source}: line {line}: {told}")


def _refuse_many_values(root: Mapping[str, object], source: str) -> None:
    count, level = 0, cast("list[object]", [root])
    for _ in range(DEEPEST):
        inner: list[object] = []
        for value in level:
            inner += value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
        count, level = count + len(inner), inner
        if count > MOST_VALUES:
            raise SceneError(f"{source}: holds more than {MOST_VALUES} values; no mechanism needs as many")
    if level:
        raise SceneError(f"{source}: nests deeper than {DEEPEST} levels; a scene needs five")


def _decimal(digits: str) -> Decimal:
    try:
        return Decimal(digits)
    except InvalidOperation:  # an exponent of twenty digits
        return Decimal("-Infinity" if digits.startswith("-") else "Infinity")


def _reworded(message: str, text: str) -> str:
    place = re.search(r" \(at (.*)\)$", message)
    what = message[: place.start()] if place else message
    where = f"{place[1]}: " if place else ""
    twice = re.search(r"Cannot (?:declare|mutate immutable namespace) \((.*)\)", what)
    if twice and "twice" in what:
        name = ".".join(re.findall(r"'([^']*)'", twice[1]))
        return f"{where}{name} is declared twice; give each table a name of its own"
    line, column = (*map(int, re.findall(r"\d+", where)), 0, 0)[:2]
    row = text.split("\n")[line - 1] if line else ""
    if "Cannot overwrite" in what:
        key = re.match(r"\s*([\w.-]+)\s*=", row)
        return f"{where}{shorten(key[1]) if key else 'a key'} is given twice in one table; remove one of them"
    read = row[: column - 1] if "Expected '='" in what else row * ("after a statement" in what)
    if comma := re.search(r"(\d+),(\d+) *$", read):
        return f"{where}decimals have a point; write {shorten('.'.join(comma.groups()))}"
    value = what.startswith(("Invalid value", "Unclosed", "Expected newline"))
    if value and (told := _unquoted(row, column)):
        return f"{where}{told}"
    if "\r" in row:
        return f"{where}lines end in CR alone; save the file with line ends of Unix or Windows"
    if "after a statement" in what:
        what += '; a value with a unit stands in quotes, "170 deg"'
    if "Illegal character '\\n'" in what:
        what = 'the text has no end; write " behind it'
    return f"{where}is not valid TOML: {what}"


_BARE = r"""(?P<value>(?:[^,\]}#="'()\[{]|\((?:[^()]|\([^()]*\))*\))*)(?P<end>.?)"""
"""A value that begins with no quote or bracket, and what stands behind it."""


def _unquoted(row: str, column: int) -> str:
    """Return what is wrong with the value at a place where TOML reads none, "" where it is none of a scene either."""
    found = re.compile(_BARE).match(row, max(row.rfind(mark, 0, column - 1) for mark in "=,[{") + 1)
    value = found["value"].strip() if found and found["end"] not in ("=", '"', "'") and found.start() else ""
    if value in ("True", "False"):
        return f"write {value.lower()} in small letters"
    if re.fullmatch(r"[-+]?(\.\d+|\d+\.)", value):
        return f"{value} lacks a digit beside its point; write {float(value)}"
    if re.fullmatch(r"[-+\d.e]+( +[-+\d.e]+)+", value):
        return f"{shorten(value)}: a comma stands between numbers"
    if re.fullmatch(r"\(.*,.*\)", value):
        return f"a list stands in [ and ]; write [{shorten(value[1:-1])}]"
    if (straight := value.strip("“”„‘’")) != value:
        return f'{shorten(value)} stands in curly quotes; write "{shorten(straight)}"'
    if re.fullmatch(r"[−–—][\d.]+", value):
        return f"{value} has no minus of a keyboard; write -{value[1:]}"
    if value and not re.fullmatch(r"[-+\d._]+|true|false", value):
        return f'quotes are missing around {shorten(value)}; write "{shorten(value)}"'
    return ""


def _declaration(root: Mapping[str, object], source: str, faults: Faults) -> Declaration:
    keys = ("name", "text", "gravity", "units", *SECTIONS, *sections(), "loop", "dh")
    _refuse_headers(root, keys, faults)
    inside = root.get("parameters")
    if "gravity" not in root and isinstance(inside, Mapping) and "gravity" in inside:
        tell = faults.add if isinstance(inside["gravity"], list) or inside["gravity"] == "none" else faults.note
        tell("parameters.gravity", "is a parameter here; write what acts, gravity = [0, 0, -9.81], above all tables")
    name = root.get("name", _default_name(source))
    if not isinstance(name, str):
        faults.add("", f'name = {show(name)} is not text; write one such as name = "two_link"')
        name = _default_name(source)
    dh = root.get("dh")
    if dh is not None and not isinstance(dh, Mapping):
        faults.add("dh", f'is {show(dh)}, not a table; write [dh] and convention = "standard" or "modified"')
        dh = None
    return Declaration(
        name=name,
        gravity=root.get("gravity"),
        units=root.get("units"),
        text=root.get("text"),
        **{kind: _entries(root, kind, faults) for kind in SECTIONS},
        elements={section: _entries(root, section, faults) for section in sections()},
        loops=_loops(root, faults),
        dh=None if dh is None else Entry("dh", dh, "dh"),
    )


def _refuse_headers(root: Mapping[str, object], keys: Sequence[str], faults: Faults) -> None:
    """Report keys that are none, parameters above their table, and lists; what refers to tables unread is not told."""
    unknown = [key for key in root if key not in keys]
    words = {k for k in unknown if isinstance(x := root[k], str) and x not in root and not re.search(r"[\d*/(]|^-", x)}
    none = words.union(key for key in unknown if isinstance(root[key], (Mapping, list, bool)))
    lone = [key for key in unknown if key not in none and nearest(key, keys) is None]
    lone = [] if all(hint("keys", key, [""]) for key in lone) else lone
    if lone:
        head = [key for key in keys_of(HEAD) if key in root]
        do = f"write [parameters] {f'below {listed(head)} and ' if head else ''}above"
        do = "move it below [parameters]:" if "parameters" in root else do
        faults.add("", f"unknown key {show(lone[0])}; {do} {listed(lone)}")
    for key in (one for one in unknown if one not in lone):
        faults.add("", f"unknown key {show(key)}; {hint('keys', key, ['']) or suggestion(key, keys)}")
    rows = [(kind, one) for kind in (*SECTIONS, *sections()) if isinstance(one := root.get(kind), list)]
    for kind, one in ((kind, one[0]) for kind, one in rows if one and isinstance(one[0], Mapping)):
        header = f"[{kind}.{one['name']}] without name" if "name" in one else f"[{kind}.NAME]"
        faults.add(kind, f"[[{kind}]] is a list of tables; write {header}")
    if lone or rows or any(isinstance(root[key], (Mapping, list)) for key in unknown):
        faults.close()


def _entries(root: Mapping[str, object], kind: str, faults: Faults) -> tuple[Entry, ...]:
    tables = root.get(kind, {})
    if not isinstance(tables, Mapping):
        faults.add(kind, f"is {show(tables)}, not a table; write [{kind}.NAME]")
        return ()
    entries = []
    for name, table in tables.items():
        where = f"{kind}.{name}"
        if isinstance(table, Mapping):
            entries.append(Entry(name, table, where))
        elif kind in SHORT:
            entries.append(Entry(name, {SHORT[kind]: table}, where))
        else:
            faults.add(where, f"is {show(table)}, not a table; write [{where}] and its keys below")
    return tuple(entries)


def _loops(root: Mapping[str, object], faults: Faults) -> tuple[Entry, ...]:
    """Return the tables [[loop]], by default called loop1, loop2, ..."""
    rows = root.get("loop", [])
    if not isinstance(rows, list) or not all(isinstance(row, Mapping) for row in rows):
        faults.add("loop", f"is {show(rows)}, not a list of tables; write one [[loop]] and its keys below for each")
        return ()
    entries = []
    for k, row in enumerate(rows, start=1):
        name = row.get("name", f"loop{k}")
        if not isinstance(name, str):
            faults.add("loop", f'name = {show(name)} is not text; write one such as name = "loop{k}"')
            name = f"loop{k}"
        table = {key: value for key, value in row.items() if key != "name"}
        entries.append(Entry(name, table, f"loop.{name}"))
    return tuple(entries)


def _default_name(source: str) -> str:
    """Return the stem of a file as a name: two-link.toml is the scene two_link."""
    stem = re.sub(r"[^A-Za-z0-9_]+", "_", Path(source).stem).strip("_")
    return stem if check_scene_name(stem) is None else f"scene_{stem}".rstrip("_")[:60]


LONGEST_ZEROS = 5
LONGEST_INTEGER = 19  # digits; TOML promises 64 bits


def write_text(scene: Scene) -> Written:
    """Return the scene as TOML, which holds all of it."""
    blocks = [_lines(raw_of(HEAD, scene))]
    if letters := {one.name: raw_of(PARAMETER, one) for one in (*scene.parameters, *scene.derived)}:
        blocks.append(_block("parameters", {name: _shortened(said) for name, said in letters.items()}))
    blocks += _blocks("bodies", BODY, scene.bodies)
    nq = nv = 0
    leaders = {joint.coordinate: joint.name for joint in scene.moving}
    for joint in scene.joints:
        blocks.append(_block(f"joints.{joint.name}", said_joint(joint, Standing(joint, nq, nv, leaders))))
        nq, nv = nq + len(joint.coordinates), nv + len(joint.rates)
    blocks += _blocks("points", POINT, scene.points)
    blocks += [_block("[loop]", {"name": joint.name, **said_place(joint)}) for joint in scene.loops]
    scope = Scope({}, scene.gravity, scene.parameters)
    blocks += [_block(place_of(one), table_of(one, scope)) for one in scene.elements]
    blocks += _blocks("inputs", INPUT, [one for one in scene.inputs if not one.of])
    blocks += _blocks("states", STATE, scene.states)
    blocks += [*_blocks("signals", SIGNAL, scene.signals), *_blocks("outputs", OUTPUT, scene.outputs)]
    blocks += _blocks("tables", TABLE, tables_in(scene))
    return Written("\n".join(blocks))


def _blocks(section: str, parts: Sequence[Part], nouns: Sequence[Any]) -> list[str]:
    return [_block(f"{section}.{one.name}", raw_of(parts, one)) for one in nouns]


def _block(header: str, table: Mapping[str, object]) -> str:
    return f"[{header}]\n{_lines(table)}"


def _lines(table: Mapping[str, object]) -> str:
    return "".join(f"{key} = {_value(value)}\n" for key, value in table.items())


def _shortened(letter: Mapping[str, object]) -> object:
    """Return a value in place of a table that says nothing else."""
    return letter["value"] if list(letter) == ["value"] else letter


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{key} = {_value(inner)}" for key, inner in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Pose):
        return _value(value.steps)
    if isinstance(value, bool):
        return str(value).lower()
    return _number(value) if isinstance(value, Quantity) else _text(str(value))


def _number(quantity: Quantity) -> str:
    """Return a number as TOML writes it where it is a decimal of bearable length, else a formula in quotes.

    One that was written with a unit is written so again.
    """
    if quantity.unit:
        there = out_of_si(quantity, unit := Unit.read(quantity.unit))
        if isinstance(there.value, Fraction) and in_si(there, unit) == quantity:
            return _text(f"{spell(there.value)} {unit.text}")
    if isinstance(quantity.value, Fraction):
        plain = decimal(quantity.value)
        if plain is not None:
            return plain
    return _text(spell(quantity))


def decimal(value: Fraction) -> str | None:
    """Return a fraction as a decimal, exactly; None if it has none of at most `MOST_DIGITS` digits."""
    try:
        exact = exact_decimal(value)
    except Inexact:
        return None
    sign, digits, zeros = exact.as_tuple()
    assert isinstance(zeros, int), "a quotient of whole numbers is finite"
    if exact.adjusted() < -LONGEST_ZEROS or zeros > 2 * LONGEST_ZEROS:
        mantissa = f"{digits[0]}.{''.join(map(str, digits[1:]))}".rstrip(".")
        return f"{'-' * sign}{mantissa}e{exact.adjusted()}"
    return None if zeros >= 0 and exact.adjusted() + 1 >= LONGEST_INTEGER else f"{exact:f}"


def _text(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(x if x.isprintable() else f"\\U{ord(x):08x}" for x in plain) + '"'
