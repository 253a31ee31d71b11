"""What the interactive page computes: the scene's own functions, and where everything is that it draws, as one program.

All parameters are arguments here, those with values too, so that each of them can be moved by hand. The textbook's
equation (5.40), row i, with what else acts on the joint:

    tau_i = Σ k_z,ij q̈_j + Σ k_C,i,jk q̇_j q̇_k + Σ k_D,ij q̇_j² + k_G,i + k_E,i - Q_i
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from symdyn.draw.places import drawn, elastic
from symdyn.dynamics import Equations, Function, Workspace, is_closed
from symdyn.dynamics.derive import arguments
from symdyn.dynamics.prescribed import TIME
from symdyn.dynamics.state import quaternions
from symdyn.errors import DerivationError, TeachError
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.program import Program, choose, lower
from symdyn.scene import GROUND, Scene, Spring
from symdyn.spatial import Vec
from symdyn.verify.equality import DIFFERENT, UNDEFINED, Claim, prove

COEFFICIENTS = ("k_z", "k_C", "k_D", "k_G")
ENERGIES = ("kinetic_energy", "potential_energy")

ROUND = ("revolute", "helical", "cylindrical", "universal", "spherical", "planar", "custom")
"""Joints that are drawn around an axis; the others slide, or hold."""


@dataclass(frozen=True)
class Mark:
    """Something to draw.

    Attributes:
        kind: "link", "particle", "com" or "point"; "turn", "slide" or "weld", a joint; "support" or "rail", where one
            stands on the ground; "frame", "spring", "damper" or "load".
        rows: of `drawn_points` that it needs, points first, then directions.
        body: number of the body that it belongs to, which is its colour; -1 for the ground.
        text: its name.
    """

    kind: str
    rows: tuple[int, ...]
    body: int
    text: str


@dataclass(frozen=True)
class Term:
    """One term of τ_i.

    Attributes:
        function: "k_z", "k_C", "k_D", "k_G", "k_E" or "applied_forces".
        entry: of its result, row by row.
        row: i, from 0.
        indices: those of the coefficient's name after its letter, from 0.
        rates: what it is multiplied by: ("qdd", j), or ("qd", j) once or twice.
        sign: -1 for what acts on the joint beside its drive.
    """

    function: str
    entry: int
    row: int
    indices: tuple[int, ...]
    rates: tuple[tuple[str, int], ...]
    sign: int = 1


@dataclass(frozen=True)
class Live:
    """The functions of the page and what they are for.

    Attributes:
        program: with `drawn_points`, shape (K, 3), and where something acts beside drives `applied_forces`, shape (n,).
        marks: in the order of drawing.
        points: rows of `drawn_points` that are points and no directions.
        gravity: row of `drawn_points` that is the acceleration of free fall.
        terms: those that do not vanish.
        stuck: why the motion cannot be computed; "" where it can.
    """

    program: Program
    marks: tuple[Mark, ...]
    points: tuple[int, ...]
    gravity: int
    terms: tuple[Term, ...]
    stuck: str


def live(scene: Scene) -> Live:
    """Return what the page of a scene computes.

    Raises:
        TeachError: loops, constraints, quaternions or prescribed motions, which sliders cannot move.
        DerivationError: no equation of motion exists.
    """
    _check(scene)
    free = replace(scene, parameters=tuple(replace(parameter, value=None) for parameter in scene.parameters))
    workspace = Workspace(free)
    coefficients = COEFFICIENTS + (("k_E",) if scene.springs else ())
    functions = list(choose(workspace, (*coefficients, "inverse_dynamics", *ENERGIES)))
    stuck = ""
    try:
        functions += choose(workspace, ("forward_dynamics",))
    except DerivationError as fault:
        stuck = str(fault)
    if any(not force.is_zero for force in workspace.Q):
        text = "generalized forces Q of loads, dampers, friction and declared forces"
        functions.append(_function(workspace, "applied_forces", text, workspace.Q, (workspace.state.n,)))
    sheet = _Sheet(free, workspace.graph)
    text = "points and directions that are drawn, ground frame"
    entries = [x for row in sheet.rows for x in row]
    functions.append(_function(workspace, "drawn_points", text, entries, (len(sheet.rows), 3)))
    equations = Equations(free, workspace.graph, tuple(functions))
    terms = _lasting(equations, _terms(equations))
    return Live(lower(equations), tuple(sheet.marks), tuple(sheet.points), sheet.gravity, terms, stuck)


def _check(scene: Scene) -> None:
    """Raise TeachError for what sliders cannot move."""
    if is_closed(scene):
        reason = "its loops or constraints tie coordinates together"
    elif quaternions(scene):
        reason = "a quaternion has no coordinates that move alone; give the joint three axes, such as zyx"
    elif any(joint.motion is not None for joint in scene.joints):
        reason = "motions are prescribed; leave them out"
    elif not scene.coordinates:
        reason = "nothing moves"
    else:
        return
    raise TeachError(f"{scene.name}: there is no interactive page, {reason}")


def _function(workspace: Workspace, name: str, text: str, entries: Sequence[Expr], shape: tuple[int, ...]) -> Function:
    timed = any(node.op is Op.SYMBOL and node.value == TIME for node in reachable(entries))
    given = arguments(workspace, ("q", "qd", *((TIME,) if timed else ())))
    return Function(name, text, given, name, shape, tuple(entries), "", "positions", name)


def _terms(equations: Equations) -> list[Term]:
    """Return all terms of all rows, in the order of (5.40)."""
    names = [function.name for function in equations.functions]
    n = len(equations.scene.velocities)
    pairs = list(combinations(range(n), 2))
    terms = []
    for i in range(n):
        terms += [Term("k_z", i * n + j, i, (i, j), (("qdd", j),)) for j in range(n)]
        terms += [
            Term("k_C", i * len(pairs) + p, i, (i, j, k), (("qd", j), ("qd", k))) for p, (j, k) in enumerate(pairs)
        ]
        terms += [Term("k_D", i * n + j, i, (i, j), (("qd", j), ("qd", j))) for j in range(n)]
        terms.append(Term("k_G", i, i, (i,), ()))
        terms += [Term("k_E", i, i, (i,), ())] if "k_E" in names else []
        terms += [Term("applied_forces", i, i, (i,), (), -1)] if "applied_forces" in names else []
    return terms


def _lasting(equations: Equations, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Return the terms whose coefficients do not vanish; sums that cancel are found by proof, not by their looks."""
    entries = [equations[term.function].entries[term.entry] for term in terms]
    claims = [Claim(str(k), "coefficient", "zero", (x,), (x.graph.zero,)) for k, x in enumerate(entries)]
    _, findings = prove(claims)
    return tuple(
        term for term, finding in zip(terms, findings, strict=True) if finding.verdict in (DIFFERENT, UNDEFINED)
    )


class _Sheet:
    """Rows of `drawn_points` and the marks that use them."""

    def __init__(self, scene: Scene, graph: Graph) -> None:
        """Collect everything of a scene; what is drawn is what pictures show."""
        self.rows: list[Vec] = []
        self.points: list[int] = []
        self.marks: list[Mark] = []
        self._found = drawn(scene, graph)
        self._number = {body.name: k for k, body in enumerate(scene.bodies)} | {GROUND: -1}
        self.gravity = self._direction(self._found["gravity",])
        starts = {joint.child: self._point(self._found["moved", joint.name][9:]) for joint in scene.joints}
        tips: dict[str, list[int]] = {name: [] for name in (GROUND, *(body.name for body in scene.bodies))}
        joints, masses = self._joints(scene, starts, tips), self._masses(scene, starts, tips)
        acting = self._acting(scene, tips)
        for body in scene.bodies:
            for tip in tips[body.name]:
                self._mark("link", (starts[body.name], tip), body.name, body.name)
        self.marks += [*masses, *joints, *acting]

    def _point(self, at: Sequence[Expr]) -> int:
        """Return the row of a point."""
        self.points.append(len(self.rows))
        return self._direction(at)

    def _direction(self, way: Sequence[Expr]) -> int:
        """Return the row of a direction."""
        x, y, z = way
        self.rows.append((x, y, z))
        return len(self.rows) - 1

    def _axes(self, frame: Sequence[Expr]) -> tuple[int, ...]:
        """Return the rows of the axes of a frame, the columns of R."""
        return tuple(self._direction((frame[k], frame[3 + k], frame[6 + k])) for k in range(3))

    def _made(self, kind: str, rows: tuple[int, ...], body: str, text: str) -> Mark:
        return Mark(kind, rows, self._number[body], text)

    def _mark(self, kind: str, rows: tuple[int, ...], body: str, text: str) -> None:
        self.marks.append(self._made(kind, rows, body, text))

    def _joints(self, scene: Scene, starts: dict[str, int], tips: dict[str, list[int]]) -> list[Mark]:
        """Return supports, symbols and frames of all joints; links reach to where joints begin."""
        marks = []
        for joint in scene.joints:
            fixed, axis = self._found["fixed", joint.name], self._found["axis", joint.name]
            at = self._point(fixed[9:])
            tips[joint.parent].append(at)
            x, y, z = axis[:3]
            way = self._direction([fixed[3 * k] * x + fixed[3 * k + 1] * y + fixed[3 * k + 2] * z for k in range(3)])
            place = starts[joint.child]
            kind = "turn" if joint.type in ROUND else "slide" if joint.moves else "weld"
            if joint.parent == GROUND:
                self._mark("rail" if kind == "slide" else "support", (at, way), GROUND, "")
            marks.append(self._made(kind, (place, way), joint.child, ", ".join(joint.coordinates)))
            axes = self._axes(self._found["moved", joint.name])
            marks.append(self._made("frame", (place, *axes), joint.child, joint.child))
        return marks

    def _masses(self, scene: Scene, starts: dict[str, int], tips: dict[str, list[int]]) -> list[Mark]:
        """Return centres of mass, particles and named points."""
        marks = []
        for body in scene.bodies:
            for k in range(len(body.particles)):
                at = self._point(self._found["particle", body.name, str(k)][1:])
                tips[body.name].append(at)
                marks.append(self._made("particle", (at,), body.name, body.name))
            if ("com", body.name) in self._found:
                at = self._point(self._found["com", body.name])
                tips[body.name].append(at)
                marks.append(self._made("com", (at,), body.name, body.name))
        for point in scene.points:
            at = self._point(self._found["point", point.name][9:])
            tips[point.body].append(at)
            marks.append(self._made("point", (at, starts.get(point.body, at)), point.body, point.name))
        return marks

    def _acting(self, scene: Scene, tips: dict[str, list[int]]) -> list[Mark]:
        """Return springs, dampers and loads."""
        marks = []
        for one in elastic(scene):
            if not one.ends:
                continue
            rows = tuple(self._point(self._found["end", one.name, str(k)]) for k in range(2))
            for end, row in zip(one.ends, rows, strict=True):
                tips[end.body].append(row)
            marks.append(self._made("spring" if isinstance(one, Spring) else "damper", rows, GROUND, one.name))
        for load in scene.loads:
            found = self._found["load", load.name]
            at = self._point(found[:3])
            tips[load.place.body].append(at)
            marks.append(self._made("load", (at, self._direction(found[3:6])), load.place.body, load.name))
        return marks
