"""A scene as TOML: read back, it is the same scene, digit for digit.

What has its default value is not written. Formulas come in the reader's normal form, so that the text of a scene that
was read, read and written again, is the same text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from symdyn.scene.declare import INERTIA_KEYS, LIMIT_KEYS
from symdyn.scene.model import STANDARD_GRAVITY, Body, Coupling, Joint, Parameter, Point, Pose, Scene
from symdyn.scene.quantity import NULL, ONE, ZERO, Quantity, Vector
from symdyn.scene.reading import Written
from symdyn.scene.spelling import spell
from symdyn.scene.table import compose

STRAIGHT = ("Tx", "Ty", "Tz", "Rz", "Ry", "Rx")  # the steps of { xyz, rpy }, in their order

LONGEST_NUMBER = 40  # digits; what is longer is written as a fraction in quotes
LONGEST_ZEROS = 5
LONGEST_INTEGER = 19  # digits; TOML promises 64 bits


def write_text(scene: Scene) -> Written:
    """Return the scene as TOML, which holds all of it."""
    blocks = [_head(scene), *_parameters(scene.parameters)]
    blocks += [_block(f"bodies.{body.name}", _body(body)) for body in scene.bodies]
    leaders = {joint.coordinate: joint.name for joint in scene.moving}
    moving = 0
    for joint in scene.joints:
        moving += bool(joint.coordinate)
        blocks.append(_block(f"joints.{joint.name}", _joint(joint, moving, leaders)))
    blocks += [_block(f"points.{point.name}", _point(point)) for point in scene.points]
    return Written("\n".join(blocks))


def _block(header: str, pairs: Iterator[tuple[str, str]]) -> str:
    return "".join([f"[{header}]\n", *(f"{key} = {value}\n" for key, value in pairs)])


def _head(scene: Scene) -> str:
    text = f"name = {_text(scene.name)}\n"
    if scene.gravity == STANDARD_GRAVITY:
        return text
    return text + f"gravity = {_text('none') if scene.gravity == NULL else _vector(scene.gravity)}\n"


def _parameters(parameters: Sequence[Parameter]) -> list[str]:
    return [_block("parameters", ((p.name, _parameter(p)) for p in parameters))] if parameters else []


def _parameter(parameter: Parameter) -> str:
    pairs = [("value", _number(parameter.value))] if parameter.value is not None else []
    pairs += [("unit", _text(parameter.unit))] if parameter.unit else []
    pairs += [("positive", "true")] if parameter.positive else []
    pairs += [("latex", _text(parameter.latex))] if parameter.latex is not None else []
    pairs += [("text", _text(parameter.text))] if parameter.text else []
    return pairs[0][1] if [key for key, _ in pairs] == ["value"] else _inline(pairs)


def _body(body: Body) -> Iterator[tuple[str, str]]:
    if body.mass != ZERO:
        yield "mass", _number(body.mass)
    if body.first_moment is not None:
        yield "first_moment", _vector(body.first_moment)
    elif body.com is not None and body.com != NULL:
        yield "com", _vector(body.com)
    if any(entry != ZERO for entry in body.inertia):
        yield "inertia", _inertia(body)
        yield "inertia_about", _text(body.about)
    elif body.about != ("com" if body.first_moment is None else "frame"):
        yield "inertia_about", _text(body.about)
    if body.particles:
        rows = [_inline([("mass", _number(p.mass)), ("at", _vector(p.at))]) for p in body.particles]
        yield "particles", f"[{', '.join(rows)}]"
    if body.allow_invalid_inertia:
        yield "allow_invalid_inertia", "true"


def _inertia(body: Body) -> str:
    if not any(entry != ZERO for entry in body.inertia[3:]):
        return _vector(body.inertia[:3])
    entries = zip(INERTIA_KEYS, body.inertia, strict=True)
    return _inline([(key, _number(entry)) for key, entry in entries if entry != ZERO])


def _joint(joint: Joint, k: int, leaders: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Return the keys of a joint; if it has a coordinate, it is the k-th that does."""
    yield from (("type", _text(joint.type)), ("parent", _text(joint.parent)), ("child", _text(joint.child)))
    if joint.moves:
        yield "axis", _vector(joint.axis)
    for key, placed in (("origin", _plain(joint.origin)), ("tip", _plain(joint.tip))):
        if placed.steps:
            yield key, _pose(placed)
    if joint.coordinate not in ("", f"q{k}"):
        yield "coordinate", _text(joint.coordinate)
    if joint.coordinate and joint.drive != f"tau{k}":
        yield "drive", "false" if joint.drive is None else _text(joint.drive)
    if joint.coupling is not None:
        yield "mimic", _mimic(joint.coupling, leaders)
    for key, amount in (
        ("force", joint.force),
        ("armature", joint.armature),
        ("damping", joint.damping),
        ("friction", joint.friction),
    ):
        if amount != ZERO:
            yield key, _number(amount)
    limits = [(key, getattr(joint.limits, key)) for key in LIMIT_KEYS]
    if any(limit is not None for _, limit in limits):
        yield "limits", _inline([(key, _number(limit)) for key, limit in limits if limit is not None])


def _mimic(coupling: Coupling, leaders: dict[str, str]) -> str:
    pairs = [("joint", _text(leaders[coupling.coordinate]))]
    pairs += [("ratio", _number(coupling.ratio))] if coupling.ratio != ONE else []
    pairs += [("offset", _number(coupling.offset))] if coupling.offset != ZERO else []
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
        return f"[{', '.join(f'[{_text(kind)}, {_number(amount)}]' for kind, amount in pose.steps)}]"
    placed = {kind: _number(amount) for kind, amount in pose.steps}
    shift, turn = ([placed.get(kind, "0") for kind in part] for part in (("Tx", "Ty", "Tz"), ("Rx", "Ry", "Rz")))
    xyz, rpy = f"[{', '.join(shift)}]", f"[{', '.join(turn)}]"
    if not any(kind.startswith("R") for kind in kinds):
        return xyz
    return _inline([("xyz", xyz)] * any(kind.startswith("T") for kind in kinds) + [("rpy", rpy)])


def _vector(quantities: Vector) -> str:
    return f"[{', '.join(_number(x) for x in quantities)}]"


def _inline(pairs: Sequence[tuple[str, str]]) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in pairs)} }}" if pairs else "{}"


def _number(quantity: Quantity) -> str:
    """Return a number as TOML writes it where it is a decimal of bearable length, else a formula in quotes."""
    if isinstance(quantity.value, Fraction):
        plain = decimal(quantity.value)
        if plain is not None:
            return plain
    return _text(spell(quantity))


def decimal(value: Fraction) -> str | None:
    """Return a fraction as a decimal, exactly; None if it has none of at most `LONGEST_NUMBER` digits."""
    twos = (value.denominator & -value.denominator).bit_length() - 1
    rest, fives = value.denominator >> twos, 0
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    places = max(twos, fives)
    if rest != 1:
        return None
    digits = str(abs(value.numerator) * 10**places // value.denominator)
    significant = digits.rstrip("0") or "0"
    if len(significant) > LONGEST_NUMBER:
        return None
    sign = "-" if value < 0 else ""
    exponent = len(digits) - places - 1  # of the first digit
    if exponent < -LONGEST_ZEROS or len(digits) - len(significant) > 2 * LONGEST_ZEROS:
        mantissa = f"{significant[0]}.{significant[1:]}".rstrip(".")
        return f"{sign}{mantissa}e{exponent}"
    padded = digits.rjust(places + 1, "0")
    if places:
        return f"{sign}{padded[:-places]}.{padded[-places:]}"
    return f"{sign}{digits}" if len(digits) < LONGEST_INTEGER else None


def _text(text: str) -> str:
    """Return a TOML string."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
