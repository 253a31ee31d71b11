"""Derivatives of closed scenes along the manifold of their states: rows that they have in place of what operators make.

    ξ, v     independent positions, of the rows that hold positions; independent velocities, of all rows
    J        [∂f/∂ξ | ∂f/∂v | ∂f/∂τ], dependent positions and velocities (and accelerations) moving along
    R        M u̇ + h - Gᵀ λ - τ, and C = G u̇ + γ, which vanish

With rolling there are more ξ than v. The same independent velocities serve all outputs; of inverse dynamics, which may
solve for other ones, too. The road "implicit" differentiates R and C at fixed u̇ and λ and solves what forward dynamics
solves once more:

    M δu̇ - Gᵀ δλ = -δR,    G δu̇ = -δC

and needs one tangent of unsolved equations a column; "recursive" takes that of the tree's forces from its recursion.
The other roads differentiate what is solved, each its own. All of it is proved off the manifold too, where
M u̇ + h = τ + Gᵀ λ and G u̇ + γ = 0 hold as well.

Who keeps all coordinates and multipliers asks for the derivatives of "motion_residual", which are R and C, by q, u, u̇,
τ and λ; or for "unprojected" derivatives of what is solved, its coordinates taken as independent.

Reference: Carpentier, Budhiraja and Mansard, Proximal and sparse resolution of constrained dynamic equations (2021),
section IV, for the derivatives of what is solved by those of what is not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from symdyn.dynamics.loops import reduction
from symdyn.dynamics.loops.constraint_rows import Constraints
from symdyn.dynamics.loops.manifold import Manifold, Seeds
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.roads import closed_outputs as closed
from symdyn.dynamics.roads import recursive_derivatives
from symdyn.dynamics.roads import result_labels as labels
from symdyn.dynamics.roads.derivative_outputs import COLUMNS, along_all, derivatives
from symdyn.dynamics.roads.kinks import kinks
from symdyn.dynamics.roads.named_functions import MULTIPLIERS, multiplier_symbols
from symdyn.dynamics.roads.output import FORCES, Output, Road, Unasked, by_lagrange
from symdyn.dynamics.roads.result_labels import Axis
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene import acceleration_name

Columns = list[list[Expr]]
Entries = Callable[[Workspace], Sequence[Expr]]

# What the columns stand for


def independent_positions(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent position; those of independent velocities come first."""
    return tuple(COLUMNS["q"](w)[k] for k in w.loops.held_positions[1].independent)


def independent_velocities(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent velocity."""
    return tuple(w.scene.velocities[k] for k in w.loops.decisions.partition.independent)


def _independent_accelerations(w: Workspace) -> tuple[str, ...]:
    return tuple(map(acceleration_name, independent_velocities(w)))


ALONG: dict[str, Axis] = {
    "q": independent_positions,
    "qd": independent_velocities,
    "ui": independent_velocities,
    "qdd": _independent_accelerations,
    "tau": COLUMNS["tau"],
}
"""What the columns stand for, by argument."""


def manifold_of(w: Workspace, road: str) -> Manifold:
    """Return the manifold by the road that derivatives of a name take."""
    return w.loops.differentiated_manifold if road == "lagrange" else w.loops.recursive_manifold


def along_manifold(w: Workspace, road: str, along: Sequence[str]) -> list[Seeds]:
    """Return how all symbols move, a column each; accelerations are no argument."""
    manifold = manifold_of(w, road)
    ways = {"q": manifold.by_position, "qd": manifold.by_velocity, "ui": manifold.by_velocity, "tau": manifold.by_force}
    return [one for name in along for one in ways[name]]


def along_motion(w: Workspace, road: str, along: Sequence[str]) -> list[Seeds]:
    """Return the same where accelerations are an argument: dependent ones move with positions and velocities too."""
    manifold, found = manifold_of(w, road), list[Seeds]()
    for name in along:
        if name == "qdd":
            found += manifold.by_acceleration
        else:
            found += map(manifold.accelerating, along_manifold(w, road, [name]))
    return found


WAYS: dict[str, Callable[[Workspace, str, Sequence[str]], list[Seeds]]] = {
    "manifold": along_manifold,
    "motion": along_motion,
    "free": lambda w, _, along: along_all(w, along),
}
"""How symbols move, column by column, by name: from the road and the arguments."""


# Roads: each takes the name of a way, and the arguments along which derivatives are wanted


def by_row(columns: Columns, rows: int) -> list[Expr]:
    """Return the entries of columns, row by row."""
    return [column[i] for i in range(rows) for column in columns]


def _tangent(of: Entries, road: str, w: Workspace, way: str, *along: str) -> list[Expr]:
    entries: Sequence[Expr] = w.once(of)
    return by_row([tangents(entries, one) for one in WAYS[way](w, road, along)], len(entries))


def equations(w: Workspace) -> list[Expr]:
    """Return R and C by recursion, shape (nv + kept rows,)."""
    return _equations(w, w.forces(list(w.state.qdd)), w.loops.recursive)


def _lagrange_equations(w: Workspace) -> list[Expr]:
    return _equations(w, w.loops.lagrange_forces, w.loops.differentiated)


def _equations(w: Workspace, forces: Sequence[Expr], rows: Constraints) -> list[Expr]:
    loops, state = w.loops, w.state
    carried = loops.constraint_forces(multiplier_symbols(w), rows)
    motion = [f - x - tau for f, x, tau in zip(forces, carried, state.tau, strict=True)]
    return [*motion, *loops.gains(rows, loops.gamma(rows))]


def solution(w: Workspace, way: str) -> tuple[list[Expr], list[Expr]]:
    """Return u̇ and λ, of factors that their derivatives share."""
    _ = w.once(closed.forward)  # tells what moves no mass
    rest = [tau - h for tau, h in zip(w.state.tau, w.forces(w.still), strict=True)]
    gamma = w.loops.gamma(w.loops.recursive)
    return w.loops.solved(rest, gamma, w.prescribed.acceleration, _together(w, way))


def _together(w: Workspace, way: str) -> bool:
    """Whether all rows are taken at once: where a partition fails, which directions along the manifold need anyway."""
    return w.loops.decisions.fails and way == "free"


def implicit(w: Workspace, way: str, *along: str) -> list[tuple[list[Expr], list[Expr]]]:
    """Return δu̇ and δλ of every column, by differentiating the equations of motion before they are solved."""
    entries = w.once(equations)
    return _solved(w, way, along, [tangents(entries, one) for one in WAYS[way](w, "implicit", along)])


def by_recursion(w: Workspace, way: str, *along: str) -> list[tuple[list[Expr], list[Expr]]]:
    """Return the same, forces of the tree differentiated along all directions by its recursion first."""
    n, tau = w.state.n, w.state.tau
    by_tree = recursive_derivatives.inverse(w, ("q", "qd"))
    carried = w.loops.constraint_forces(multiplier_symbols(w))
    rest = [*(-x - force for x, force in zip(carried, tau, strict=True)), *w.once(equations)[n:]]
    sides = []
    for seeds, step in zip(WAYS[way](w, "implicit", along), _steps(w, way, along), strict=True):
        moved = tangents(rest, seeds)
        for i in range(n):
            moved[i] = moved[i] + w.graph.total(by_tree[2 * n * i + k] * x for k, x in step.items())
        sides.append(moved)
    return _solved(w, way, along, sides)


def _steps(w: Workspace, way: str, along: Sequence[str]) -> list[dict[int, Expr]]:
    """Return how directions (from 0) and velocities (from nv) move, a column each."""
    n, every = w.state.n, w.loops.recursive_manifold.slopes
    slopes = every if way == "manifold" else [{k: w.graph.one} for k in range(n)]
    slopes = slopes if "q" in along else []
    return [
        (slopes[k] if k < len(slopes) else {}) | {n + i: seeds[u] for i, u in enumerate(w.state.qd) if u in seeds}
        for k, seeds in enumerate(WAYS[way](w, "implicit", along))
    ]


Solved = list[tuple[list[Expr], list[Expr]]]


def _solved(w: Workspace, way: str, along: Sequence[str], sides: Sequence[list[Expr]]) -> Solved:
    """Return δu̇ and δλ from δR and δC at symbols for u̇ and λ."""
    n, together = w.state.n, _together(w, way)
    accelerations, multipliers = w.once(solution, way)
    known = dict(zip((*w.state.qdd, *multiplier_symbols(w)), (*accelerations, *multipliers), strict=True))
    moved = [substitute(one, known) for one in sides]
    found = [w.loops.solved([-x for x in one[:n]], one[n:], together=together) for one in moved]
    for k, (pulled, _) in enumerate(found[-n:] if along[-1] == "tau" else ()):  # symmetric in fact: one of each pair
        for j in range(k):
            pulled[j] = found[j - n][0][k]
    return found


def _columns(by: Callable[..., Solved], part: int, w: Workspace, way: str, *along: str) -> list[Expr]:
    columns = [one[part] for one in w.once(by, way, *along)]
    return by_row(columns, len(w.loops.decisions.kept) if part else w.state.n)


def carried_forces(w: Workspace) -> list[Expr]:
    """Return f - Gᵀ λ at fixed λ: the drives of inverse dynamics, once λ is what its partition finds."""
    forces = w.forces(list(w.state.qdd))
    return [f - x for f, x in zip(forces, w.loops.constraint_forces(multiplier_symbols(w)), strict=True)]


def driven(w: Workspace, moved: Sequence[Expr]) -> list[Expr]:
    """Return how the drives change, from how what is carried does at fixed λ."""
    loops = w.loops
    known = dict(zip(multiplier_symbols(w), w.once(closed.carried), strict=True))
    changes = substitute(moved, known)
    G = loops.G(loops.recursive)
    return closed.at_drives(w, changes, G, reduction.solve_transposed(G, loops.driven, changes))


def _implicit_inverse(w: Workspace, way: str, *along: str) -> list[Expr]:
    entries = w.once(carried_forces)
    return by_row([driven(w, tangents(entries, one)) for one in WAYS[way](w, "implicit", along)], w.state.n)


COUNTED = 8
"""Velocities up to which roads are counted; beyond, the recursion is cheaper where it is, then unsolved equations."""


def _cheaper(roads: dict[str, Road], w: Workspace) -> str:
    """Return the road that costs least."""
    quick = [name for name in ("recursive", "implicit", "forward") if name in roads]
    if w.state.n > COUNTED:
        return quick[0]
    varying = (*w.state.q, *w.state.qd, *w.state.qdd, *w.state.tau)
    return min(quick, key=lambda name: cost(w.once(roads[name].derive), varying))


def _velocities(w: Workspace, way: str, *along: str) -> list[Expr]:
    """Return S and T, in terms of the independent velocities."""
    known = dict(zip(w.state.qd, w.once(closed.velocities), strict=True))
    seeds = WAYS[way](w, "partition", along)
    return by_row([substitute([one.get(u, w.graph.zero) for u in w.state.qd], known) for one in seeds], w.state.n)


def _normal_velocities(w: Workspace, _: str, *along: str) -> list[Expr]:
    manifold, u = w.loops.differentiated_manifold, w.state.qd
    free = {"q": manifold.by_position, "ui": [{u[k]: w.graph.one} for k in manifold.partition.independent]}
    entries: list[Expr] = w.once(closed.normal_velocities)
    return by_row([tangents(entries, one) for name in along for one in free[name]], w.state.n)


def _positions(manifold: Callable[[Workspace], Manifold], w: Workspace, *_: str) -> list[Expr]:
    columns = manifold(w).slopes
    return by_row([[column.get(k, w.graph.zero) for k in range(w.state.n)] for column in columns], w.state.n)


# Rows


@dataclass(frozen=True)
class Derivative:
    """What is differentiated along the manifold, and how.

    Attributes:
        text: what it is, in words.
        arguments: of the function, and of its derivatives.
        result: its short name.
        rows: what its entries stand for.
        units: its unit.
        roads: derivations, each takes the workspace, a way and the arguments along which derivatives are wanted.
        depends: which choices about closed loops its formulas depend on.
        solved: its entries by road, those of which derivatives are taken after they are solved.
        way: how symbols move along the manifold, a key of `WAYS`.
    """

    text: str
    arguments: tuple[str, ...]
    result: str
    rows: Axis
    units: str
    roads: dict[str, Callable[..., Sequence[Expr]]]
    depends: tuple[str, ...]
    solved: dict[str, Entries] = field(default_factory=dict)
    way: str = "manifold"

    def row(self, along: tuple[str, ...]) -> Output:
        """Return the row of the table, along some of the arguments."""
        how = "along the manifold, dependent positions and velocities moving along,"
        return self._row(along, self.way, ALONG, [BLOCKS[name] for name in along], how)

    def unprojected(self) -> Output:
        """Return the row of derivatives along all directions, as if no loop tied them."""
        how = "along the directions of the velocities, all else held, as if no loop tied the coordinates,"
        return self._row(self.arguments, "free", COLUMNS, self.arguments, how)

    def _row(self, along: tuple[str, ...], way: str, axes: dict[str, Axis], blocks: Sequence[str], how: str) -> Output:
        roads = {
            name: (by_lagrange if name == "lagrange" else Road)(_derived(derive, way, along))
            for name, derive in self.roads.items()
        }
        return Output(
            f"derivatives [{' | '.join(f'd{self.result}/d{one}' for one in blocks)}] {how} of {self.text}",
            self.arguments,
            f"d{self.result}",
            (self.rows, lambda w: tuple(label for name in along for label in axes[name](w))),
            f"{self.units}, per unit of what moves",
            "same",
            roads,
            loops_only=True,
            unasked=Unasked.NEVER,
            lacks="told",
            depends=self.depends,
            prefer=partial(_cheaper, roads) if "implicit" in roads else None,
            remark=self.remark,
        )

    def remark(self, w: Workspace) -> str:
        """Return where it has no value."""
        entries: Sequence[Expr] = w.once(self.solved["forward"]) if self.solved else ()
        return UNDETERMINED + kinks(entries, (*w.state.q, *w.state.qd))

    @property
    def blocks(self) -> str:
        """What J is made of, in words."""
        return f"[{' | '.join(f'd{self.result}/d{BLOCKS[name]}' for name in self.arguments)}]"


def _derived(derive: Callable[..., Sequence[Expr]], way: str, along: tuple[str, ...]) -> Entries:
    return lambda w: derive(w, way, *along)


UNDETERMINED = "; no number where independent positions or velocities do not determine the others"

BLOCKS = {"q": "q_i", "qd": "qd_i", "ui": "ui", "qdd": "qdd_i", "tau": "tau"}

_OF_MOTION = ("q", "qd", "tau")
_CHOICES = ("independent", "alpha", "beta")

ALONG_MANIFOLD: dict[str, Derivative] = {
    "forward_dynamics": Derivative(
        "the accelerations of the closed mechanism",
        _OF_MOTION,
        "qdd",
        labels.velocities,
        "rad/s^2 or m/s^2",
        {
            "implicit": partial(_columns, implicit, 0),
            "recursive": partial(_columns, by_recursion, 0),
            "forward": partial(_tangent, closed.forward, "forward"),
            "lagrange": partial(_tangent, closed.lagrange_forward, "lagrange"),
        },
        _CHOICES,
        {"forward": closed.forward, "lagrange": closed.lagrange_forward},
    ),
    "multipliers": Derivative(
        "the multipliers",
        _OF_MOTION,
        "lambda",
        labels.kept_rows,
        "N or N m",
        {
            "implicit": partial(_columns, implicit, 1),
            "recursive": partial(_columns, by_recursion, 1),
            "forward": partial(_tangent, closed.multipliers, "forward"),
            "lagrange": partial(_tangent, closed.lagrange_multipliers, "lagrange"),
        },
        _CHOICES,
        {"forward": closed.multipliers, "lagrange": closed.lagrange_multipliers},
    ),
    "inverse_dynamics": Derivative(
        "the driving forces of the closed mechanism",
        ("q", "qd", "qdd"),
        "tau",
        labels.velocities,
        FORCES,
        {
            "implicit": _implicit_inverse,
            "forward": partial(_tangent, closed.inverse, "forward"),
            "lagrange": partial(_tangent, closed.lagrange_inverse, "lagrange"),
        },
        ("independent",),
        {"forward": closed.inverse, "lagrange": closed.lagrange_inverse},
        "motion",
    ),
    "velocities": Derivative(
        "the velocities that the loops allow",
        ("q", "ui"),
        "qd",
        labels.velocities,
        "rad/s or m/s",
        {"partition": _velocities, "normal": _normal_velocities},
        ("independent",),
    ),
    "positions": Derivative(
        "the positions at which the loops stay closed, along the directions of the velocities",
        ("q",),
        "q",
        COLUMNS["q"],
        "rad or m",
        {
            "partition": partial(_positions, lambda w: w.loops.recursive_manifold),
            "normal": partial(_positions, lambda w: w.loops.differentiated_manifold),
        },
        ("independent",),
    ),
}
"""What is differentiated along the manifold, by its name."""


MOTION_RESIDUAL = Output(
    "what vanishes in every motion: M qdd + h - tau - G^T lambda, then G qdd + Gdot qd",
    ("q", "qd", "qdd", "tau", MULTIPLIERS),
    "residual",
    (lambda w: (*w.scene.velocities, *labels.kept_rows(w)),),
    f"{FORCES}, then m/s^2 or 1/s^2",
    "same",
    {"rnea": Road(equations), "lagrange": by_lagrange(_lagrange_equations)},
    loops_only=True,
    unasked=Unasked.NEVER,
    lacks="told",
    depends=("alpha", "beta"),
)
"""The equations that closed scenes solve, unsolved."""

RESIDUAL = "motion_residual"

CLOSED_DERIVATIVES: dict[str, Output] = {
    **{f"{name}_derivatives": one.row(one.arguments) for name, one in ALONG_MANIFOLD.items()},
    **{
        f"{name}_by_{argument}": one.row((argument,))
        for name, one in ALONG_MANIFOLD.items()
        for argument in one.arguments
        if name != "positions"
    },
    **{
        f"{name}_unprojected_derivatives": ALONG_MANIFOLD[name].unprojected()
        for name in ("forward_dynamics", "inverse_dynamics", "multipliers")
    },
    RESIDUAL: MOTION_RESIDUAL,
    f"{RESIDUAL}_derivatives": derivatives("", MOTION_RESIDUAL),
    **{f"{RESIDUAL}_by_{one}": derivatives("", MOTION_RESIDUAL, one) for one in MOTION_RESIDUAL.arguments},
}
"""Rows of closed scenes, by what is asked; what operators make is asked of all others."""
