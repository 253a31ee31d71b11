"""A scene as TOML: read back, it is the same scene, digit for digit.

What has its default value is not written. Formulas come in the reader's normal form, so that the text of a scene that
was read, read and written again, is the same text.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from decimal import Inexact
from fractions import Fraction
from itertools import chain

from symdyn.scene.declaration.declare import INERTIA_KEYS
from symdyn.scene.declaration.joint_table import LIMIT_KEYS
from symdyn.scene.declaration.reading import Written
from symdyn.scene.forces.force_kind import Scope
from symdyn.scene.forces.force_table import place_of, table_of
from symdyn.scene.formats.placing import exact_decimal
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.body import Body, Pose
from symdyn.scene.values.entry import compose
from symdyn.scene.values.joint import Coupling, Joint
from symdyn.scene.values.model import STANDARD_GRAVITY, Input, Parameter, Point, Scene, Signal
from symdyn.scene.values.quantity import NULL, Quantity, Vector, spell
from symdyn.scene.values.tolerance import Tolerance
from symdyn.scene.values.unit import Unit, in_si, out_of_si

STRAIGHT = ("Tx", "Ty", "Tz", "Rz", "Ry", "Rx")  # the steps of { xyz, rpy }, in their order

LONGEST_ZEROS = 5
LONGEST_INTEGER = 19  # digits; TOML promises 64 bits


def write_text(scene: Scene) -> Written:
    """Return the scene as TOML, which holds all of it."""
    blocks = [_head(scene), *_parameters(scene.parameters)]
    blocks += [_block(f"bodies.{body.name}", _body(body)) for body in scene.bodies]
    nq = nv = 0
    leaders = {joint.coordinate: joint.name for joint in scene.moving}
    for joint in scene.joints:
        blocks.append(_block(f"joints.{joint.name}", _joint(joint, nq, nv, leaders)))
        nq, nv = nq + len(joint.coordinates), nv + len(joint.rates)
    blocks += [_block(f"points.{point.name}", _point(point)) for point in scene.points]
    blocks += [_block("[loop]", chain([("name", _text(joint.name))], _placed(joint))) for joint in scene.loops]
    scope = Scope({}, scene.gravity, scene.parameters)
    blocks += [_block(place_of(one), _said(table_of(one, scope))) for one in scene.elements]
    blocks += [_block(f"inputs.{one.name}", _input(one)) for one in scene.inputs]
    blocks += [_block(f"outputs.{one.name}", _output(one)) for one in scene.outputs]
    return Written("\n".join(blocks))


def _block(header: str, pairs: Iterator[tuple[str, str]]) -> str:
    return "".join([f"[{header}]\n", *(f"{key} = {value}\n" for key, value in pairs)])


def _head(scene: Scene) -> str:
    text = f"name = {_text(scene.name)}\n" + (f"units = {_text('none')}\n" if scene.dimensionless else "")
    if scene.gravity == STANDARD_GRAVITY:
        return text
    return text + f"gravity = {_text('none') if scene.gravity == NULL else _vector(scene.gravity)}\n"


def _parameters(parameters: Sequence[Parameter]) -> list[str]:
    return [_block("parameters", ((p.name, _parameter(p)) for p in parameters))] if parameters else []


def _parameter(parameter: Parameter) -> str:
    pairs = list(_valued(parameter))
    pairs += [("positive", "true")] if parameter.positive else []
    pairs += [("tolerance", _tolerance(parameter.tolerance))] if parameter.tolerance else []
    pairs += [("latex", _text(parameter.latex))] if parameter.latex is not None else []
    pairs += _described(parameter)
    return pairs[0][1] if [key for key, _ in pairs] == ["value"] else _inline(pairs)


def _valued(letter: Parameter | Input) -> Iterator[tuple[str, str]]:
    """Return a letter's value and unit as its writer chose it, wherever that reads as the same value again."""
    value, unit = letter.value, letter.unit
    if value is not None and value.unit:
        unit = "" if value.unit == (letter.written or unit) else letter.written or unit
    elif letter.written:
        chosen = Unit.read(letter.written)
        there = None if value is None else out_of_si(value, chosen)
        if there is None or in_si(there, chosen) == value:
            value, unit = there, letter.written
    if value is not None and not (isinstance(letter, Input) and value == Quantity.ZERO):
        yield "value", _number(value)
    if unit:
        yield "unit", _text(unit)


def _tolerance(one: Tolerance) -> str:
    return _inline([("sigma", _text(one.text))]) if one.sigma else _text(one.text)


def _input(one: Input) -> Iterator[tuple[str, str]]:
    yield from _valued(one)
    if one.latex:
        yield "latex", _text(one.latex)
    yield from _described(one)


def _output(one: Signal) -> Iterator[tuple[str, str]]:
    yield "formula", _number(one.formula)
    yield from [("unit", _text(one.unit))] if one.unit else []
    yield from _described(one)


def _described(one: Parameter | Input | Signal) -> list[tuple[str, str]]:
    """Return what it is, in one language or in several."""
    if not one.texts:
        return [("text", _text(one.text))] if one.text else []
    english = [] if one.text in dict(one.texts).values() else [("en", one.text)]
    return [("text", _inline([(code, _text(text)) for code, text in (*english, *one.texts)]))]


def _body(body: Body) -> Iterator[tuple[str, str]]:
    if body.mass != Quantity.ZERO:
        yield "mass", _number(body.mass)
    if body.first_moment is not None:
        yield "first_moment", _vector(body.first_moment)
    elif body.com is not None and body.com != NULL:
        yield "com", _vector(body.com)
    if any(entry != Quantity.ZERO for entry in body.inertia):
        yield "inertia", _inertia(body)
        yield "inertia_about", _text(body.about)
    elif body.about != ("com" if body.first_moment is None else "frame"):
        yield "inertia_about", _text(body.about)
    if body.particles:
        rows = [_inline([("mass", _number(p.mass)), ("at", _vector(p.at))]) for p in body.particles]
        yield "particles", f"[{', '.join(rows)}]"
    if body.allow_invalid_inertia:
        yield "allow_invalid_inertia", "true"
    if body.shape is not None:
        said = [*body.shape.sizes, *([("axis", body.shape.axis)] if body.shape.axis else [])]
        yield "shape", _value({"type": body.shape.type, **dict(said)}) if said else _text(body.shape.type)


def _inertia(body: Body) -> str:
    if not any(entry != Quantity.ZERO for entry in body.inertia[3:]):
        return _vector(body.inertia[:3])
    entries = zip(INERTIA_KEYS, body.inertia, strict=True)
    return _inline([(key, _number(entry)) for key, entry in entries if entry != Quantity.ZERO])


def _joint(joint: Joint, nq: int, nv: int, leaders: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Return the keys of a joint; nq coordinates and nv velocities come before its own."""
    yield from _placed(joint)
    names = joint.coordinates
    if names and (
        JOINTS[joint.type].names_coordinates or names != tuple(f"q{nq + k}" for k in range(1, len(names) + 1))
    ):
        yield from _one_or_more("coordinate", "coordinates", [_text(name) for name in names])
    if names:
        yield from _drives(joint, nv)
    if joint.coupling is not None:
        yield "mimic", _mimic(joint.coupling, leaders)
    if any(force != Quantity.ZERO for force in joint.forces):
        yield from _one_or_more("force", "forces", [_number(force) for force in joint.forces])
    for key, amount in (("armature", joint.armature), ("damping", joint.damping), ("friction", joint.friction)):
        if amount != Quantity.ZERO:
            yield key, _number(amount)
    if joint.dry is not None:
        yield "friction", _value(table_of(joint.dry, Scope({}, NULL, ())))
    limits = [(key, getattr(joint.limits, key)) for key in LIMIT_KEYS]
    if any(limit is not None for _, limit in limits):
        yield "limits", _inline([(key, _number(limit)) for key, limit in limits if limit is not None])
    for key, numbers in (("start", joint.start), ("start_rates", joint.start_rates)):
        if numbers:
            yield from _one_or_more(key, key, [_number(x) for x in numbers])
    if joint.motion is not None:
        yield "motion", _number(joint.motion)


def _placed(joint: Joint) -> Iterator[tuple[str, str]]:
    """Return type, bodies, frames and shape."""
    yield from (("type", _text(joint.type)), ("parent", _text(joint.parent)), ("child", _text(joint.child)))
    yield from ((key.name, _value(value)) for key, value in JOINTS[joint.type].values(joint))
    for key, placed in (("origin", _plain(joint.origin)), ("tip", _plain(joint.tip))):
        if placed.steps:
            yield key, _pose(placed)


def _value(value: object) -> str:
    """Return what a key says."""
    if isinstance(value, Mapping):
        return _inline(list(_said(value)))
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Pose):
        return _steps(value)
    return _number(value) if isinstance(value, Quantity) else _text(str(value))


def _one_or_more(one: str, several: str, values: Sequence[str]) -> Iterator[tuple[str, str]]:
    yield (one, values[0]) if len(values) == 1 else (several, f"[{', '.join(values)}]")


def _drives(joint: Joint, nv: int) -> Iterator[tuple[str, str]]:
    if not any(joint.drives):
        yield "drive", "false"
    elif joint.drives != tuple(f"tau{nv + k}" for k in range(1, len(joint.rates) + 1)):
        yield from _one_or_more("drive", "drives", [_text(name) if name else "false" for name in joint.drives])


def _said(table: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Return the keys of a table and what they say."""
    yield from ((key, _value(value)) for key, value in table.items())


def _mimic(coupling: Coupling, leaders: dict[str, str]) -> str:
    leader = leaders.get(coupling.coordinate)
    pairs = [("joint", _text(leader)) if leader else ("coordinate", _text(coupling.coordinate))]
    pairs += [("ratio", _number(coupling.ratio))] if coupling.ratio != Quantity.ONE else []
    pairs += [("offset", _number(coupling.offset))] if coupling.offset != Quantity.ZERO else []
    return _inline(pairs)


def _point(point: Point) -> Iterator[tuple[str, str]]:
    yield "body", _text(point.body)
    at = _plain(point.at)
    if at.steps:
        yield "at", _pose(at)


def _plain(pose: Pose) -> Pose:
    """Return a placement without steps that do nothing, as the reader gives it."""
    return compose(*pose.steps)


def _pose(pose: Pose) -> str:
    """Return [x, y, z], { xyz, rpy } or a list of steps, the first of them that says the same."""
    kinds = [kind for kind, _ in pose.steps]
    if kinds != sorted(set(kinds), key=STRAIGHT.index):
        return _steps(pose)
    placed = {kind: _number(amount) for kind, amount in pose.steps}
    shift, turn = ([placed.get(kind, "0") for kind in part] for part in (("Tx", "Ty", "Tz"), ("Rx", "Ry", "Rz")))
    xyz, rpy = f"[{', '.join(shift)}]", f"[{', '.join(turn)}]"
    if not any(kind.startswith("R") for kind in kinds):
        return xyz
    return _inline([("xyz", xyz)] * any(kind.startswith("T") for kind in kinds) + [("rpy", rpy)])


def _steps(pose: Pose) -> str:
    """Return a list of steps."""
    return f"[{', '.join(f'[{_text(kind)}, {_number(amount)}]' for kind, amount in pose.steps)}]"


def _vector(quantities: Vector) -> str:
    return f"[{', '.join(_number(x) for x in quantities)}]"


def _inline(pairs: Sequence[tuple[str, str]]) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in pairs)} }}" if pairs else "{}"


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
    """Return a TOML string."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(x if x.isprintable() else f"\\U{ord(x):08x}" for x in plain) + '"'
