"""Scenes as Khalil parameter files, `.par`; the words are OpenSYMORO's.

A frame of such a file has its z axis along its joint. Joints about other axes and body frames behind their joints (a
standard Denavit-Hartenberg table) are brought into that shape exactly, and inertias move along: the frames of a body
and of its link may differ, the equations do not. Parameters with a value enter by their value, for the format has
symbols and numbers but no symbols with a value.

Any placement as rows of Khalil's six parameters, without a rounding.

    row = Rz(γ) Tz(b) Rx(α) Tx(d) Rz(θ) Tz(r)

Steps along one axis commute and add up, and what happens about y is what happens about x seen from a frame turned by
90° about z: Ty(y) = Rz(π/2) Tx(y) Rz(-π/2). So every placement is a product of motions about z and x in turn, and
every "z x z" of it is a row. One row is enough for all but a few placements; the others take massless frames between.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import groupby, permutations, product

from symdyn.arguments import argument
from symdyn.errors import SceneError
from symdyn.frozen import dataclass
from symdyn.scene.declaration.reading import Written, lost_words
from symdyn.scene.formats.par import FIXED, TYPES
from symdyn.scene.formats.par_sheet import INERTIAL, NOTHING, Link, link
from symdyn.scene.formats.placing import angle_text
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values import folding
from symdyn.scene.values.body import RIGHT, Step, inverse_steps, plus, quarter_turns, towards, turns
from symdyn.scene.values.joint import Joint, Limits
from symdyn.scene.values.letters import Parameter
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity, spell

SLOTS = ("Rz", "Tz", "Rx", "Tx", "Rz", "Tz")

MOST_ORDERS = 720


@dataclass(frozen=True)
class ParRow:
    """The six parameters of a frame, rad and m."""

    gamma: Quantity = Quantity.ZERO
    b: Quantity = Quantity.ZERO
    alpha: Quantity = Quantity.ZERO
    d: Quantity = Quantity.ZERO
    theta: Quantity = Quantity.ZERO
    r: Quantity = Quantity.ZERO


@dataclass(frozen=True)
class Screw:
    """A turn about an axis "x" or "z" with a shift along it."""

    axis: str
    angle: Quantity = Quantity.ZERO
    shift: Quantity = Quantity.ZERO


def rows(steps: Sequence[Step]) -> list[ParRow]:
    """Return the fewest rows found whose product is the placement; one row of zeros for the identity."""
    direct = _direct(steps)
    if direct is not None:
        return [direct]
    best = [_chop(_screws(order)) for order in _orders(steps)]
    found = min(best, key=len)
    single = _right_angled(steps) if len(found) > 1 else None
    return [single] if single else found


def _direct(steps: Sequence[Step]) -> ParRow | None:
    """Return the row whose steps are exactly these, the last slots taken first."""
    amounts = [Quantity.ZERO] * 6
    slot = 5
    for kind, amount in reversed(steps):
        while slot >= 0 and SLOTS[slot] != kind:
            slot -= 1
        if slot < 0:
            return None
        amounts[slot] = amount
        slot -= 1
    return ParRow(*amounts)


def _orders(steps: Sequence[Step]) -> Iterator[list[Step]]:
    """Return the steps in every order that means the same: neighbouring shifts commute and add up."""
    runs: list[list[tuple[Step, ...]]] = []
    count = 1
    for shifts, run in groupby(steps, key=lambda step: step[0][0] == "T"):
        if not shifts:
            runs.append([tuple(run)])
            continue
        sums: dict[str, Quantity] = {}
        for kind, amount in run:
            sums[kind] = folding.add(sums.get(kind, Quantity.ZERO), amount)
        orders = list(permutations(sums.items()))
        count *= len(orders)
        runs.append(orders if count <= MOST_ORDERS else orders[:1])
    for choice in product(*runs):
        yield [step for part in choice for step in part]


def _screws(steps: Sequence[Step]) -> list[Screw]:
    """Return a placement as screws about z and x in turn."""
    found: list[Screw] = []
    for kind, amount in steps:
        axis = kind[1]
        screw = Screw(
            "z" if axis == "z" else "x", *((amount, Quantity.ZERO) if kind[0] == "R" else (Quantity.ZERO, amount))
        )
        around = (Screw("z", RIGHT), screw, Screw("z", folding.neg(RIGHT))) if axis == "y" else (screw,)
        for part in around:
            _append(found, part)
    return found


def _append(screws: list[Screw], screw: Screw) -> None:
    if screws and screws[-1].axis == screw.axis:
        last = screws.pop()
        screw = Screw(screw.axis, _plus(last.angle, screw.angle), folding.add(last.shift, screw.shift))
    if screw.angle != Quantity.ZERO or screw.shift != Quantity.ZERO:
        screws.append(screw)


def _plus(a: Quantity, b: Quantity) -> Quantity:
    """Return the sum of two angles; multiples of π lose whole turns."""
    total = plus(a, b)
    whole = turns(total)
    if whole is None:
        return total
    rest = (whole + 1) % 2 - 1
    return folding.mul(Quantity.number(1 if rest == -1 else rest), Quantity.PI)


def _chop(screws: Sequence[Screw]) -> list[ParRow]:
    """Return screws that take turns about z and x as rows: z x z, x z, x z, ..."""
    found: list[ParRow] = []
    left = list(screws)
    while left or not found:
        first = left.pop(0) if not found and len(left) > 1 and left[0].axis == "z" else Screw("z")
        middle = left.pop(0) if left and left[0].axis == "x" else Screw("x")
        last = left.pop(0) if left else Screw("z")
        found.append(ParRow(first.angle, first.shift, middle.angle, middle.shift, last.angle, last.shift))
    return found


def _right_angled(steps: Sequence[Step]) -> ParRow | None:
    """Return the row of a placement whose turns are all by right angles, None if there is none or it has others.

    With R = Rz(γ) Rx(α) Rz(θ) and p = Rz(γ) (d, -r sin α, b + r cos α), whole numbers of right angles are tried.
    """
    if any(kind[0] == "R" and quarter_turns(amount) is None for kind, amount in steps):
        return None
    matrix, place = _frame(steps)
    for g, a, t in product((0, 1, 3, 2), (0, 1, 3, 2), (0, 1, 3, 2)):
        turned, _ = _frame((("Rz", _quarters(g)), ("Rx", _quarters(a)), ("Rz", _quarters(t))))
        if turned != matrix:
            continue
        _, (d, across, up) = _frame((("Rz", _quarters(-g % 4)), *zip(("Tx", "Ty", "Tz"), place, strict=True)))
        if a in (1, 3):
            r = folding.neg(across) if a == 1 else across
            return ParRow(_quarters(g), up, _quarters(a), d, _quarters(t), r)
        if across == Quantity.ZERO:
            return ParRow(_quarters(g), up, _quarters(a), d, _quarters(t))
    return None


def _quarters(k: int) -> Quantity:
    return (Quantity.ZERO, RIGHT, Quantity.PI, folding.neg(RIGHT))[k]


def _frame(steps: Sequence[Step]) -> tuple[list[list[int]], tuple[Quantity, Quantity, Quantity]]:
    """Return rotation and origin of a placement with right angles only."""
    matrix = [[int(i == j) for j in range(3)] for i in range(3)]
    place = [Quantity.ZERO, Quantity.ZERO, Quantity.ZERO]
    for kind, amount in steps:
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            for i in range(3):
                moved = folding.mul(Quantity.number(matrix[i][k]), amount)
                place[i] = folding.add(place[i], moved)
            continue
        u, v = (k + 1) % 3, (k + 2) % 3
        for _ in range(quarter_turns(amount) or 0):
            for line in matrix:
                line[u], line[v] = line[v], -line[u]
    return matrix, (place[0], place[1], place[2])


ANGLES = ("gamma", "alpha", "theta")
SIGMA = {kind: str(sigma) for sigma, kind in enumerate(TYPES)}


@dataclass(frozen=True)
class Frame:
    """One frame of the file.

    Attributes:
        link, joint: names of the body and of the joint that carries it.
        ant: number of the frame it hangs on, 0 for the ground.
        sigma: "0", "1" or "2".
        row: its six parameters; theta or r without the coordinate.
        carrier: the joint of the scene, None for a frame between.
        inertial: of its link.
    """

    link: str
    joint: str
    ant: int
    sigma: str
    row: ParRow
    carrier: Joint | None = None
    inertial: Link = NOTHING


def write_text(scene: Scene) -> Written:
    """Return the scene as a parameter file, with what the format has no place for.

    Raises:
        SceneError: a joint that the format has no type for; the file would be another mechanism.
    """
    _refuse(scene)
    filled = scene.in_numbers([parameter.name for parameter in scene.parameters])
    return Written(_page(filled, _frames(filled)), tuple(_lost(scene)))


def _refuse(scene: Scene) -> None:
    reasons = []
    for joint in scene.joints:
        where = f"{scene.source or scene.name}: joints.{joint.name}"
        if joint.type not in SIGMA:
            reasons.append(f"{where}: a .par file has no {joint.type} joints; it has {', '.join(SIGMA)}")
        elif joint.coupling is not None:
            advice = "give it a coordinate of its own, or convert to TOML"
            reasons.append(f"{where}: a .par file has no joints that follow others; {advice}")
    if reasons:
        raise SceneError(reasons)


def _lost(scene: Scene) -> Iterator[str]:
    for parameter in scene.parameters:
        if parameter.value is not None:
            yield f"parameters.{parameter.name}: its value {spell(parameter.value)} stands in place of the name"
            if parameter.tolerance:
                yield f"parameters.{parameter.name}: tolerance"
        elif parameter != Parameter(parameter.name):
            words = [key for key in ("positive", "unit", "latex", "text", "tolerance") if getattr(parameter, key)]
            yield f"parameters.{parameter.name}: {', '.join(words)}"
    for body in scene.bodies:
        if body.allow_invalid_inertia:
            again = argument("allow_invalid_inertia", True)
            yield f"bodies.{body.name}: allow_invalid_inertia; read it back with {again}"
    for joint in scene.joints:
        if joint.limits != Limits():
            yield f"joints.{joint.name}: limits"
    for point in scene.points:
        yield f"points.{point.name}"
    yield from lost_words(scene)


def _frames(scene: Scene) -> list[Frame]:
    """Return the frames of the file, and between them massless ones where one row does not reach.

    A joint moves along its axis A z, and its body frame is what A⁻¹ and the tip add: children and inertias are placed
    from the frame of the file by that.
    """
    frames: list[Frame] = []
    number = {Scene.GROUND: 0}
    behind: dict[str, tuple[Step, ...]] = {Scene.GROUND: ()}
    taken = dict.fromkeys([body.name for body in scene.bodies] + [joint.name for joint in scene.joints])
    for body, joint in zip(scene.bodies, scene.joints, strict=True):
        turn = towards(joint.axis) if joint.moves else ()
        lead = (*behind[joint.parent], *joint.origin.steps)
        after = (*inverse_steps(turn), *joint.tip.steps)
        path = rows((*lead, *turn)) if joint.moves else rows((*lead, *after))
        if _hides_coordinate(joint, path[-1]):
            path.append(ParRow())
        ant = number[joint.parent]
        for k, row in enumerate(path[:-1], start=1):
            names = [_fresh(f"{name}_frame{k}", taken) for name in (body.name, joint.name)]
            frames.append(Frame(names[0], names[1], ant, str(FIXED), row))
            ant = len(frames)
        behind[body.name] = after if joint.moves else ()
        inertial = link(body, behind[body.name])
        frames.append(Frame(body.name, joint.name, ant, SIGMA[joint.type], path[-1], joint, inertial))
        number[body.name] = len(frames)
    return frames


def _hides_coordinate(joint: Joint, row: ParRow) -> bool:
    """Whether symbols would stand beside the coordinate, so that a reader could not tell which of them moves."""
    offset = row.r if JOINTS[joint.type].slides(joint) else row.theta
    return joint.moves and bool(offset.symbols)


def _fresh(name: str, taken: dict[str, None]) -> str:
    while name in taken:
        name += "_"
    taken[name] = None
    return name


def _page(scene: Scene, frames: Sequence[Frame]) -> str:
    n = len(frames)
    chain = all(frame.ant == j for j, frame in enumerate(frames))
    lines = [f"(* Robotname = '{scene.name}' *)"]
    for remark, default, names in (
        ("Link names", "link", [frame.link for frame in frames]),
        ("Joint names", "joint", [frame.joint for frame in frames]),
    ):
        if names != [f"{default}{j + 1}" for j in range(n)]:
            lines.append(f"(* {remark} = '{', '.join(names)}' *)")
    lines += [f"NL = {n}", f"NJ = {n}", f"NF = {n}", f"Type = {0 if chain else 1}", "is_floating = 0", "is_mobile = 0"]
    lines += ["", "(* Geometric parameters *)"]
    lines += [_list(key, [_parameter(key, frame) for frame in frames]) for key in _GEOMETRY]
    lines += ["", "(* Dynamic parameters and external forces *)"]
    lines += [_list(key, [spell(getattr(frame.inertial, key)) for frame in frames]) for key in INERTIAL]
    for key, name in (("IA", "armature"), ("FV", "damping"), ("FS", "friction")):
        lines.append(_list(key, [spell(getattr(frame.carrier, name, Quantity.ZERO)) for frame in frames]))
    lines += [_list(key, ["0"] * n) for key in ("FX", "FY", "FZ", "CX", "CY", "CZ")]
    lines += ["", "(* Joint parameters *)"]
    lines += [_list(key, ["0"] * n) for key in ("eta", "k")]
    lines += [_list(key, [f"{key}{j + 1}" for j in range(n)]) for key in ("QP", "QDP")]
    lines.append(_list("GAM", [(frame.carrier and frame.carrier.drive) or "0" for frame in frames]))
    lines += ["", "(* Velocity and acceleration of the base *)"]
    lines += [_list(key, ["0"] * 3) for key in ("W0", "WP0", "V0", "VP0")]
    lines += ["", "(* Acceleration of gravity *)", _list("G", [spell(x) for x in scene.gravity])]
    unit = [str(int(i == j)) for i in range(4) for j in range(4)]
    lines += ["", "(* Transformation of 0 frame position fT0 *)", _list("Z", unit), "", "(* End of definition *)"]
    return "\n".join(lines) + "\n"


_GEOMETRY = ("ant", "sigma", "b", "d", "r", "gamma", "alpha", "mu", "theta")


def _list(key: str, values: Sequence[str]) -> str:
    return f"{key} = {{{', '.join(values)}}}"


def _parameter(key: str, frame: Frame) -> str:
    """Return one geometric parameter of one frame, with the coordinate in its place."""
    if key in ("ant", "sigma"):
        return str(getattr(frame, key))
    if key == "mu":
        return "1" if frame.carrier and frame.carrier.drive else "0"
    value = getattr(frame.row, key)
    if key in ANGLES and isinstance(value.value, Fraction):
        angle = value.value  # a decimal, which no reader takes for a multiple of π
        if key != "theta" or frame.sigma != "0" or frame.carrier is None:
            return angle_text(angle)
        name = frame.carrier.coordinate
        return f"{name} {'-' if angle < 0 else '+'} {angle_text(abs(angle))}" if angle else name
    moving = {"0": "theta", "1": "r"}.get(frame.sigma)
    if key != moving or frame.carrier is None:
        return spell(value)
    q = Quantity.symbol(frame.carrier.coordinate)
    return spell(folding.sub(q, folding.neg(value)) if spell(value).startswith("-") else folding.add(q, value))
