r"""Inverse kinematics of an arm in print: the angles in the order in which they are found, by the output's derivation.

    R, p     the pose that is asked for                  b      from axis 1 to where the last axes meet
    σ        1 or -1: each choice is another branch      w      what two links across parallel axes have to reach
    d, r     x cos q + y sin q = d, r² = x² + y² - d²    u, t   axes 6 and 5 as they shall be, seen from the wrist

Where an angle, a root or a vector is found, it is written down, and the derivation goes on with a letter for it.

Reference: Craig, Introduction to Robotics (2005), sections 4.4 and 4.6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from symdyn.algebra import Form, Function, Symbol
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism import joints_below, vanishes
from symdyn.dynamics.outputs import BRANCHES, KINDS, POSE, REST, ArmAngles, Turn, arm_angles, direction, sense
from symdyn.emit.print.formulation_groups import EquationGroup, EquationRow, fresh, ordered_workspace, written_forms
from symdyn.emit.print.printed_names import PrintName, latex_symbols
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, substitute
from symdyn.scene import Scene
from symdyn.spatial import Mat, Vec

CHOICES = {
    0: (
        "shoulder to the left or to the right",
        "the point where the last axes meet is as near to axis 1 as it can be",
        "any angle will do where the point where the last axes meet is on axis 1",
    ),
    2: ("elbow up or down", "the arm is stretched or folded", ""),
    4: ("wrist flipped or not", "two of its axes are in line, and one of their two angles can be any", ""),
}
"""What a sign chooses, where its two branches meet, and what is said where there is no root; by the axis."""

ENTRIES = ["R11", "R12", "R13", "p1", "R21", "R22", "R23", "p2", "R31", "R32", "R33", "p3"]
"""Letters of [R p], row by row."""

SUM = 3
"""The angle of an axis that is told as a sum, q2 + q3 + q4, where 2, 3 and 4 are parallel."""

Told = tuple[tuple[Expr, ...], Callable[..., Form]]
"""Nodes, and what makes a formula of theirs."""


@dataclass(frozen=True)
class ToldAngles(ArmAngles):
    """Angles of an arm as a page tells them: one branch, with letters for signs.

    Attributes:
        names: the coordinates; of axis 4 the letter of a sum, where three axes are parallel, and its own at the end.
        senses: of these 1, or -1 of axes that point against the parallel ones.
        three: whether three axes are parallel.
        own: returns a name that the scene has not.
        told: what is written down, by name.
    """

    names: Sequence[str] = ()
    senses: Sequence[int] = ()
    own: Callable[[str], str] = str
    three: bool = False
    told: dict[str, Told] = field(default_factory=dict)

    @classmethod
    def of(
        cls, names: Sequence[str], own: Callable[[str], str], h: Sequence[Vec], c: list[Vec], R: Mat, p: Vec
    ) -> ToldAngles:
        """Return those of an arm that is given as `ArmAngles` is."""
        arm = ArmAngles(h, c, R, p)
        three = arm.parallel(1, SUM) and arm.meeting((3, 4, 5)) is None
        senses = [1, 1, sense(arm, 2), 1, 1, 1, sense(arm, SUM)]
        shown = [*names[:SUM], own("phi") if three else names[SUM], *names[SUM + 1 :], names[SUM]]
        return cls(h, c, R, p, names=shown, senses=senses, own=own, three=three)

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
        graph, way = turn.s.graph, self.senses[k]
        q, told = graph.symbol(self.names[k]), (way * turn.s, turn.c)
        if k == REST:  # of angles, not of their sines
            _, second, third, whole = (graph.symbol(name) for name in self.names[: SUM + 1])
            self.told.setdefault(self.names[k], ((way * (whole - second - self.senses[2] * third),), lambda form: form))
        self.told.setdefault(self.names[k], (told, lambda *two: Function(Op.ATAN2, two)))
        return Turn(way * graph.function(Op.SIN, q), graph.function(Op.COS, q))

    def noted(self, name: str, x: Expr) -> Expr:
        """Write down what is a formula, and return its letter."""
        if x.op in (Op.CONSTANT, Op.SYMBOL):
            return x
        return x.graph.zero if vanishes(x) else self._letter(name, x, lambda form: form)

    def flipped(self, turn: Turn, rho: Expr, k: int) -> tuple[Turn, Expr]:
        """Return both with one sign, the turn by its angle, the length by its letter."""
        (length,) = self.both(rho, k + 1)
        s, c = (x for (x,) in (self.both(x, k + 1) for x in turn))
        return self.named(Turn(s, c), k), length

    def _letter(self, name: str, x: Expr, form_of: Callable[[Form], Form]) -> Expr:
        self.told.setdefault(self.own(name), ((x,), form_of))
        return x.graph.symbol(self.own(name))

    def direction(self, x: Expr, y: Expr, known: Expr | None = None, other: Turn | None = None) -> tuple[Turn, Expr]:
        """Return the turn from (1, 0) to (x, y), as long as it is, and its length."""
        return Turn(y, x), x.graph.sqrt(x * x + y * y)


def inverse_kinematics(scene: Scene) -> Iterator[EquationGroup]:
    """Yield the angles of every arm that a point is the end of, in the order in which they are found.

    Raises:
        DerivationError: none of the points, or bodies at an end where there are none, has a closed form.
    """
    carrying = {joint.parent for joint in scene.joints}
    ends = [point.name for point in scene.points] or [one.name for one in scene.bodies if one.name not in carrying]
    found, refused = list[EquationGroup](), DerivationError(f"{scene.name} has no body, and so no arm")
    for end in ends:
        try:
            found += _arm(scene, end)
        except DerivationError as error:
            refused = error
    if not found:
        raise refused
    yield from found


def _arm(scene: Scene, end: str) -> Iterator[EquationGroup]:
    """Yield the angles of one arm, of which each ends a group; DerivationError where it has no closed form."""
    if scene.is_constrained:
        derive_one(Workspace(scene), f"inverse_kinematics:{end}")  # refuses
    w, joints = ordered_workspace(scene, "inverse kinematics"), joints_below(scene, end)
    names = [joint.coordinates[0] for joint in joints if joint.coordinates]
    arm = arm_angles(w, end, lambda *given: ToldAngles.of(names, lambda name: fresh(scene, (name,))[0], *given))
    assert isinstance(arm, ToldAngles), "the kind that was asked for"
    pose = dict(zip(direction(w.graph, POSE, 12), (w.graph.symbol(arm.own(x)) for x in ENTRIES), strict=True))
    values = {name: substitute(nodes, pose) for name, (nodes, _) in arm.told.items()}
    write, rows = written_forms(w, [x for nodes in values.values() for x in nodes]), list[EquationRow]()
    symbols = latex_symbols(scene)

    def group(key: str, title: str, said: Callable[[Callable[[str], str]], str]) -> EquationGroup:
        shown = said(lambda name: f"${symbols.get(name, PrintName.of_code(name))}$")
        ends = ":" if rows else "."
        return EquationGroup(key, title, said(str), tuple(rows), f"{shown[0].upper()}{shown[1:]}{ends}")

    yield group(f"arm_{end}", f"Inverse kinematics of {end}", partial(_of_the_arm, arm, names))
    for name, (_, form_of) in arm.told.items():
        latex = name if name in names else str(PrintName.of_code(name))
        rows.append(EquationRow(name, latex, form_of(*map(write, values[name]))))
        if name in arm.names:
            yield group(f"{end}_{name}_", f"Angle {name}", partial(_of_an_angle, arm, rows))
            rows = []


def _of_the_arm(arm: ToldAngles, names: Sequence[str], of: Callable[[str], str]) -> str:
    """Return what is said of an arm, by what writes a name."""
    parallel, _, meet, _ = KINDS[arm.three]
    same, meeting = (listed([of(names[k]) for k in row]) for row in (parallel, meet))
    R, p = (of(arm.own(letter)) for letter in "Rp")
    signs = ", ".join(of(arm.own(f"sigma{k + 1}")) for k in CHOICES)
    return (
        f"the axes of {same} are parallel, those of {meeting} meet in a point; {R} and {p} are the pose that is asked "
        f"for; {signs} are 1 or -1 each, which makes {BRANCHES} branches; angles are up to whole turns, and the pose "
        "is out of reach where a root is of a negative number"
    )


def _of_an_angle(arm: ToldAngles, rows: Sequence[EquationRow], of: Callable[[str], str]) -> str:
    """Return what the sign in rows chooses, and where that is no choice, by what writes a name."""
    used = {name for row in rows for name in (row.name, *row.form.symbols)}
    for k, (choice, meeting, without) in CHOICES.items():
        sign, root = (arm.own(f"{letter}{k + 1}") for letter in ("sigma", "r"))
        if sign in used:
            meets = f"its branches meet where {of(root)} = 0: {meeting}" if root in used else without
            return f"{of(sign)} chooses the {choice}; {meets}"
    return "one for each branch so far"
