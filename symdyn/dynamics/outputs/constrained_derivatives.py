"""Derivatives of closed scenes along the manifold of their states: rows that they have in place of what operators make.

`implicit` has the rule and the legend, `tangent_space` says what the columns stand for. By a parameter, independent
positions and velocities (and accelerations), and forces, are held; dependent ones go where the loops take them:
G_d δξ_d = -∂r/∂p of the position-level rows, then G δu = -δ(G) u. Of mechanisms whose lengths are free, the
derivative is the one that a designer sees.

Who keeps all coordinates and multipliers asks for the derivatives of "motion_residual", the equations before they are
solved, by q, u, u̇, τ and λ; or for "unprojected" derivatives of what is solved, its coordinates taken as independent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from symdyn.dynamics.loops.manifold import Manifold
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.outputs import constrained_outputs as closed, implicit
from symdyn.dynamics.outputs.derivative_outputs import (
    BESIDE,
    SPELLED,
    derivatives,
    jacobian_row,
    kinks,
    parameter_row,
    parameters_left_out,
    slopes_by_parameters,
)
from symdyn.dynamics.outputs.directional_outputs import along_one, jvp_row, pulled_back, vjp_row
from symdyn.dynamics.outputs.named_functions import MULTIPLIERS, WEIGHTS, direction
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.result_labels import kept_rows
from symdyn.dynamics.outputs.tangent_space import (
    COLUMNS,
    FREE,
    MANIFOLD,
    MOTION,
    TangentSpace,
    by_row,
    forward,
    independent_positions,
    independent_velocities,
)
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, substitute

COUNTED = 8
"""Velocities up to which formulations are counted; beyond, the recursion is cheaper, then unsolved equations."""

SIZE = Size((0, 45), 1.5)
"""What a block of J takes."""

Entries = Callable[[Workspace], Sequence[Expr]]

Jacobian = Callable[..., Sequence[Expr]]
"""Takes how symbols move, the arguments along which derivatives are wanted and the workspace; returns J row by row."""


@dataclass(frozen=True)
class Derivative:
    """What is differentiated along the manifold, and how.

    Attributes:
        row: the output, called as its derivatives say.
        equations: what it is decided by, and where it stands in what they decide; None where it is explicit.
        sides: how their right sides are found, keys of `SIDES`.
        solved: its entries by formulation, those of which derivatives are taken after they are solved.
        explicit: formulations of J, where it is.
        space: how symbols move.
    """

    row: Output
    equations: tuple[implicit.Equations, implicit.Part] | None = None
    sides: tuple[str, ...] = ()
    solved: dict[str, Entries] = field(default_factory=dict)
    explicit: dict[str, Jacobian] = field(default_factory=dict)
    space: TangentSpace = MANIFOLD

    # Rows

    def along(self, *arguments: str) -> Output:
        """Return the row of J along some of the arguments."""
        return self._jacobian(self.space, arguments, ALONG, self.remark)

    def unprojected(self) -> Output:
        """Return the row of J along all directions, as if no loop tied them."""
        how = " along the directions of the velocities, all else held, as if no loop tied the coordinates,"
        return self._jacobian(FREE, self.row.arguments, how, self.kinks)

    def _jacobian(self, space: TangentSpace, along: tuple[str, ...], how: str, remark: Callable[..., str]) -> Output:
        found = {name: _named(name, partial(derive, space, along)) for name, derive in self.explicit.items()}
        if self.equations:
            equations, part = self.equations
            for name in self.sides:
                derive = partial(implicit.jacobian, equations, part, name, space, along)
                solve = partial(implicit.row_solve, part, name, space, along)
                found[name] = Formulation(derive, solve=solve if equations is implicit.motion else None)
        found |= {name: _named(name, partial(_slopes, of, name, space, along)) for name, of in self.solved.items()}
        prefer = partial(_cheaper, found) if "implicit" in found else None
        size = SIZE.times(len(along))
        return jacobian_row(self.row, space, along, how, found, remark=remark, prefer=prefer, size=size)

    def by_parameters(self, only: str = "") -> Output:
        """Return the row of derivatives by all named parameters or by one, what is independent held."""
        found = {
            name: _named(name, partial(_by_parameters, of, name, self.space, only)) for name, of in self.solved.items()
        }
        how = " along the manifold, independent positions and velocities held, dependent ones moving along,"
        return parameter_row(self.row, only, how, found, remark=lambda w: self.remark(w) + parameters_left_out(w, only))

    def products(self) -> dict[str, Output]:
        """Return the rows of J d and wᵀ J, by the words behind the name."""
        along = self.row.arguments
        ahead, back = dict[str, Formulation](), dict[str, Formulation]()
        if self.equations:
            ahead["implicit"] = Formulation(partial(implicit.jvp, *self.equations, self.space, along))
            if self.equations[0] is implicit.motion:  # symmetric
                back["adjoint"] = Formulation(partial(implicit.vjp, *self.equations, self.space, along))
        for name, of in self.solved.items():
            ahead[name] = _named(name, partial(_along_one, of, name, self.space, along))
            back[name] = _named(name, partial(_pulled_back, of, name, self.space, along))
        rows = {"_jvp": (jvp_row, ahead), "_vjp": (vjp_row, back)}
        return {word: row(self.row, self.space, ALONG, ways, remark=self.remark) for word, (row, ways) in rows.items()}

    # What they say

    def remark(self, w: Workspace) -> str:
        """Return what is independent, and where there is no value."""
        places, speeds = (", ".join(one(w)) or "nothing" for one in (independent_positions, independent_velocities))
        return (
            f"; independent positions are {places}, velocities {speeds}; no number where these do not determine the "
            f"others{self.kinks(w)}"
        )

    def kinks(self, w: Workspace) -> str:
        """Return where it has no slope."""
        entries: Sequence[Expr] = w.once(self.solved["forward"]) if self.solved else ()
        return kinks(entries, (*w.state.q, *w.state.qd))


ALONG = " along the manifold, dependent positions and velocities moving along,"


def _named(name: str, derive: Entries) -> Formulation:
    return by_lagrange(derive) if name == "lagrange" else Formulation(derive)


def _cheaper(formulations: Mapping[str, Formulation], w: Workspace) -> str:
    """Return the formulation that costs least."""
    quick = [name for name in ("recursive", "implicit", "forward") if name in formulations]
    if w.state.n > COUNTED:
        return quick[0]
    varying = (*w.state.q, *w.state.qd, *w.state.qdd, *w.state.tau)
    return min(quick, key=lambda name: cost(w.once(formulations[name].derive), varying))


# What is solved, differentiated


def _slopes(of: Entries, formulation: str, space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    return forward(w.once(of), space.seeds(w, formulation, along))


def _along_one(of: Entries, formulation: str, space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    return along_one(w, space.direction(w, formulation, along), w.once(of), formulation)


def _pulled_back(of: Entries, formulation: str, space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    entries: Sequence[Expr] = w.once(of)
    return pulled_back(w, entries, direction(w.graph, WEIGHTS, len(entries)), space, formulation, along)


def _by_parameters(of: Entries, formulation: str, space: TangentSpace, only: str, w: Workspace) -> list[Expr]:
    return slopes_by_parameters(w, only, space, formulation, forward, lambda there: there.once(of))


# What follows from independent positions and velocities alone: the manifold itself


def _velocities(space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    """Return S and T, in terms of the independent velocities."""
    known = dict(zip(w.state.qd, w.once(closed.velocities), strict=True))
    seeds = space.seeds(w, "partition", along)
    return by_row([substitute([one.get(u, w.graph.zero) for u in w.state.qd], known) for one in seeds], w.state.n)


def _normal_velocities(_: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    """Return the same by normal equations, differentiated."""
    manifold, u = w.loops.differentiated_manifold, w.state.qd
    free = {"q": manifold.by_position, "ui": [{u[k]: w.graph.one} for k in manifold.partition.independent]}
    return forward(w.once(closed.normal_velocities), [one for name in along for one in free[name]])


def _positions(
    manifold: Callable[[Workspace], Manifold], _: TangentSpace, along: Sequence[str], w: Workspace
) -> list[Expr]:
    """Return T_h row by row."""
    columns = manifold(w).position_tangents
    return by_row([[column.get(k, w.graph.zero) for k in range(w.state.n)] for column in columns], w.state.n)


# The table


def _called(name: str, text: str, units: str = "") -> Output:
    row = OUTPUTS[name].constrained
    return replace(row, text=text, units=units or row.units, when_constrained="only")


ALONG_MANIFOLD: dict[str, Derivative] = {
    "forward_dynamics": Derivative(
        _called("forward_dynamics", "the accelerations of the closed mechanism", "rad/s^2 or m/s^2"),
        (implicit.motion, implicit.accelerations),
        ("implicit", "recursive"),
        {"forward": closed.forward, "lagrange": closed.lagrange_forward},
    ),
    "multipliers": Derivative(
        _called("multipliers", "the multipliers"),
        (implicit.motion, implicit.multipliers),
        ("implicit", "recursive"),
        {"forward": closed.multipliers, "lagrange": closed.lagrange_multipliers},
    ),
    "inverse_dynamics": Derivative(
        _called("inverse_dynamics", "the driving forces of the closed mechanism"),
        (implicit.drives, implicit.accelerations),
        ("implicit",),
        {"forward": closed.inverse, "lagrange": closed.lagrange_inverse},
        space=MOTION,
    ),
    "velocities": Derivative(
        _called("velocities", "the velocities that the loops allow"),
        explicit={"partition": _velocities, "normal": _normal_velocities},
    ),
    "positions": Derivative(
        Output(
            "the positions at which the loops stay closed, along the directions of the velocities",
            ("q",),
            "q",
            (COLUMNS["q"],),
            "rad or m",
            "only",
            {},
            may_fail="reported",
            depends=("independent",),
        ),
        explicit={
            "partition": partial(_positions, lambda w: w.loops.recursive_manifold),
            "normal": partial(_positions, lambda w: w.loops.differentiated_manifold),
        },
    ),
}
"""What is differentiated along the manifold, by its name."""

SOLVED = tuple(name for name, one in ALONG_MANIFOLD.items() if one.solved)
"""What of it is solved: it has products, and derivatives by parameters, by time and by inputs."""


MOTION_RESIDUAL = Output(
    "residual of the equations of motion, M qdd + h - tau - G^T lambda, and of their rows, G qdd + Gdot qd",
    ("q", "qd", "qdd", "tau", MULTIPLIERS),
    "residual",
    (lambda w: (*w.scene.velocities, *kept_rows(w)),),
    f"{FORCES}, then m/s^2 or 1/s^2",
    "only",
    {"rnea": Formulation(implicit.equations), "lagrange": by_lagrange(implicit.lagrange_equations)},
    default_in="request",
    may_fail="reported",
    depends=("alpha", "beta"),
)
"""The equations that closed scenes solve, unsolved."""

RESIDUAL, UNPROJECTED = "motion_residual", "_unprojected_derivatives"

CLOSED: dict[str, Output] = {
    **{f"{name}_derivatives": one.along(*one.row.arguments) for name, one in ALONG_MANIFOLD.items()},
    **{
        f"{name}_by_{argument}": one.along(argument)
        for name, one in ALONG_MANIFOLD.items()
        for argument in one.row.arguments
        if name != "positions"
    },
    **{f"{name}{UNPROJECTED}": ALONG_MANIFOLD[name].unprojected() for name in SOLVED},
    **{
        f"{name}_by_{SPELLED.get(one, one)}": replace(
            derivatives("", OUTPUTS[name].constrained, one), when_constrained="only"
        )
        for one in BESIDE
        for name in SOLVED
    },
    RESIDUAL: MOTION_RESIDUAL,
    **{f"{name}{word}": row for name in SOLVED for word, row in ALONG_MANIFOLD[name].products().items()},
}
"""Rows of closed scenes, by what is asked; beside them derivatives by parameters, NAME_by_PARAMETER.

What operators make is asked of all others, and of the residual.
"""
