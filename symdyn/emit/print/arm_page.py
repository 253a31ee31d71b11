r"""Inverse kinematics of an arm in print: the angles in the order in which they are found, by the output's derivation.

    R, p     the pose that is asked for                  b      from axis 1 to where the last axes meet
    σ        1 or -1: each choice is another branch      w      what two links across parallel axes have to reach
    d, r     x cos q + y sin q = d, r² = x² + y² - d²    u, t   axes 6 and 5 as they shall be, seen from the wrist

Reference: Craig, Introduction to Robotics (2005), sections 4.4 and 4.6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from symdyn.algebra import Form, Function, Symbol
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism import joints_below, vanishes
from symdyn.dynamics.outputs import BRANCHES, KINDS, POSE, ArmAngles, Turn, arm_angles, direction, sense
from symdyn.emit.print.formulation_groups import EquationGroup, EquationRow, fresh, ordered_workspace, written_forms
from symdyn.emit.print.printed_names import PrintName, latex_symbols
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, substitute
from symdyn.scene import Scene

SIGNS = (0, 2, 4)
"""Axes whose angle a sign chooses."""

SAID = {
    "arm": "the axes of {parallel} are parallel, those of {meeting} meet in a point; {R} and {p} are the pose that is "
    "asked for; {signs} are 1 or -1 each, which makes {branches} branches; angles are up to whole turns, and the pose "
    "is out of reach where a root is of a negative number",
    "sign.1": "{sign} chooses the shoulder to the left or to the right",
    "meet.1": "its branches meet where {root} = 0: the point where the last axes meet is as near to axis 1 as it can "
    "be",
    "sign.3": "{sign} chooses the elbow up or down",
    "meet.3": "its branches meet where {root} = 0: the arm is stretched or folded",
    "sign.5": "{sign} chooses the wrist flipped or not",
    "meet.5": "its branches meet where {root} = 0: two of its axes are in line, and one of their two angles can be any",
    "meet": "any angle will do where the point where the last axes meet is on axis 1",
    "one": "one for each branch so far",
}
"""What is said of an arm, of an angle whose sign chooses, where its branches meet, and of any other angle."""

ENTRIES, SUM = ["R11", "R12", "R13", "p1", "R21", "R22", "R23", "p2", "R31", "R32", "R33", "p3"], 3
"""Letters of [R p]; the axis in place of whose angle q2 + q3 + q4 is told, where 2, 3 and 4 are parallel."""


@dataclass(frozen=True)
class ToldAngles(ArmAngles):
    """One branch of an arm, with letters for signs: what is found is written down, and goes on as its letter.

    Attributes:
        names: the coordinates.
        own: returns a name that the scene has not.
        told: what is written down, by name: nodes, and what makes a formula of theirs.
    """

    names: Sequence[str] = ()
    own: Callable[[str], str] = str
    told: dict[str, tuple[tuple[Expr, ...], Callable[..., Form]]] = field(default_factory=dict)

    @property
    def order(self) -> list[str]:
        """Names of angles by axis; of axis 4 that of a sum, where three are parallel, and its own at the end."""
        three = self.parallel(1, SUM) and self.meeting((3, 4, 5)) is None
        return [*self.names[:SUM], self.own("phi") if three else self.names[SUM], *self.names[4:], self.names[SUM]]

    def both(self, x: Expr, k: int) -> Sequence[Expr]:
        """Return one number with the letter of its sign; a root by its letter."""
        sign = self.own(f"sigma{k + 1}")
        if x.op is not Op.SQRT:
            return (x.graph.symbol(sign) * x,)
        within = x.args[0]
        left = within.args[-1] if within.op is Op.SELECT else within
        shown = lambda form: Form.product((Symbol(sign), Function(Op.SQRT, (form,))))  # noqa: E731
        return (self._letter(f"r{k + 1}", left, shown),)

    def named(self, turn: Turn, k: int, over: Expr | None = None) -> Turn:
        """Write down an angle, and return its turn by the sine and the cosine of its name."""
        graph, names = turn.s.graph, self.order
        way = sense(self, SUM if k == 6 else k) if k in (2, 6) else 1
        q = graph.symbol(names[k])
        if k == 6:  # of angles, not of their sines
            _, second, third, whole = (graph.symbol(name) for name in names[: SUM + 1])
            self.told.setdefault(names[k], ((way * (whole - second - sense(self, 2) * third),), lambda form: form))
        self.told.setdefault(names[k], ((way * turn.s, turn.c), lambda *two: Function(Op.ATAN2, two)))
        return Turn(way * graph.function(Op.SIN, q), graph.function(Op.COS, q))

    def noted(self, name: str, x: Expr) -> Expr:
        """Write down what is a formula, and return its letter."""
        if x.op in (Op.CONSTANT, Op.SYMBOL):
            return x
        return x.graph.zero if vanishes(x) else self._letter(name, x, lambda form: form)

    def _letter(self, name: str, x: Expr, form_of: Callable[[Form], Form]) -> Expr:
        self.told.setdefault(self.own(name), ((x,), form_of))
        return x.graph.symbol(self.own(name))

    def direction(self, x: Expr, y: Expr, *_: Any, k: int = 0, **__: Any) -> tuple[Turn, Expr]:
        """Return the turn from (1, 0) to (x, y), as long as it is, and its length; of a wrist named, with a sign."""
        if not k:
            return Turn(y, x), x.graph.sqrt(x * x + y * y)
        s, c, length = (self.both(one, k)[0] for one in (y, x, x.graph.sqrt(x * x + y * y)))
        return self.named(Turn(s, c), k - 1), length


def inverse_kinematics(scene: Scene) -> Iterator[EquationGroup]:
    """Yield the angles of every arm that a point is the end of, in the order in which they are found.

    Raises:
        DerivationError: none of the points, or of the bodies where there are none, has a closed form.
    """
    found, refused = list[EquationGroup](), DerivationError(f"{scene.name} has no body, and so no arm")
    for end in scene.points or scene.bodies:
        try:
            found += _arm(scene, end.name)
        except DerivationError as error:
            refused = error
    if not found:
        raise refused
    yield from found


class ArmStep(NamedTuple):
    """What is told of an arm, or of the angle `title`: keys of `SAID`, names of the places in these, and formulas."""

    keys: tuple[str, ...]
    names: Mapping[str, Sequence[str]]
    rows: tuple[EquationRow, ...] = ()
    title: str = ""


def _arm(scene: Scene, end: str) -> Iterator[EquationGroup]:
    """Yield the angles of one arm, of which each ends a group."""
    symbols = latex_symbols(scene)

    def said(step: ArmStep, of: Callable[[str], str]) -> str:
        names = {place: listed([*map(of, found)]) for place, found in step.names.items()}
        return "; ".join(SAID[key].format(branches=BRANCHES, **names) for key in step.keys)

    for step in arm_steps(scene, end):
        shown = said(step, lambda name: f"${symbols.get(name, PrintName.of_code(name))}$")
        key = f"{end}_{step.title}_" if step.title else f"arm_{end}"
        title = f"Angle {step.title}" if step.title else f"Inverse kinematics of {end}"
        latex = f"{shown[0].upper()}{shown[1:]}{':' if step.rows else '.'}"
        yield EquationGroup(key, title, said(step, str), step.rows, latex)


def arm_steps(scene: Scene, end: str) -> Iterator[ArmStep]:
    """Yield what is told of an arm, then of each angle; DerivationError where it has no closed form."""
    if scene.is_constrained:
        derive_one(Workspace(scene), f"inverse_kinematics:{end}")  # refuses
    w, joints = ordered_workspace(scene, "inverse kinematics"), joints_below(scene, end)
    names = [joint.coordinates[0] for joint in joints if joint.coordinates]
    arm = arm_angles(w, end, partial(ToldAngles, names=names, own=lambda name: fresh(scene, (name,))[0]))
    assert isinstance(arm, ToldAngles), "the kind that was asked for"
    pose = dict(zip(direction(w.graph, POSE, 12), (w.graph.symbol(arm.own(x)) for x in ENTRIES), strict=True))
    values = {name: substitute(nodes, pose) for name, (nodes, _) in arm.told.items()}
    write, rows = written_forms(w, [x for nodes in values.values() for x in nodes]), list[EquationRow]()
    parallel, _, meet, _ = KINDS[arm.order[SUM] != names[SUM]]
    told = {"parallel": [names[k] for k in parallel], "meeting": [names[k] for k in meet]}
    yield ArmStep(
        ("arm",), told | {x: [arm.own(x)] for x in "Rp"} | {"signs": [arm.own(f"sigma{k + 1}") for k in SIGNS]}
    )
    for name, (_, form_of) in arm.told.items():
        latex = name if name in names else str(PrintName.of_code(name))
        rows.append(EquationRow(name, latex, form_of(*map(write, values[name]))))
        if name in arm.order:
            yield ArmStep(*_of_an_angle(arm, rows), tuple(rows), name)
            rows = []


def _of_an_angle(arm: ToldAngles, rows: Sequence[EquationRow]) -> tuple[tuple[str, ...], dict[str, Sequence[str]]]:
    used = {name for row in rows for name in (row.name, *row.form.symbols)}
    for k in SIGNS:
        sign, root = (arm.own(f"{letter}{k + 1}") for letter in ("sigma", "r"))
        if sign in used:
            return (f"sign.{k + 1}", f"meet.{k + 1}" if root in used else "meet"), {"sign": [sign], "root": [root]}
    return ("one",), {}
