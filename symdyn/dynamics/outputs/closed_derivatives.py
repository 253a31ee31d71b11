"""Derivatives of closed scenes along the manifold of their states: rows that they have in place of what operators make.

`closed_slopes` has the formulations, and the legend. Who keeps all coordinates and multipliers asks for the derivatives
of "motion_residual", the equations before they are solved, by q, u, u̇, τ and λ; or for "unprojected" derivatives of
what is solved, its coordinates taken as independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.row_solve import RowSolve
from symdyn.dynamics.outputs import closed_outputs as closed, result_labels as labels
from symdyn.dynamics.outputs.closed_slopes import (
    Entries,
    by_recursion,
    columns_of,
    equations,
    implicit,
    implicit_inverse,
    lagrange_equations,
    normal_slopes_of_velocities,
    slopes_of_positions,
    slopes_of_velocities,
    solve_of,
    tangent,
)
from symdyn.dynamics.outputs.derivative_outputs import BESIDE, COLUMNS, derivatives
from symdyn.dynamics.outputs.kinks import kinks
from symdyn.dynamics.outputs.named_functions import MULTIPLIERS
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, by_lagrange
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.size import Size
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr
from symdyn.scene.values import acceleration_name

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


COUNTED = 8
"""Velocities up to which formulations are counted; beyond, the recursion is cheaper, then unsolved equations."""


def _cheaper(formulations: dict[str, Formulation], w: Workspace) -> str:
    """Return the formulation that costs least."""
    quick = [name for name in ("recursive", "implicit", "forward") if name in formulations]
    if w.state.n > COUNTED:
        return quick[0]
    varying = (*w.state.q, *w.state.qd, *w.state.qdd, *w.state.tau)
    return min(quick, key=lambda name: cost(w.once(formulations[name].derive), varying))


@dataclass(frozen=True)
class Derivative:
    """What is differentiated along the manifold, and how.

    Attributes:
        text: what it is, in words.
        arguments: of the function, and of its derivatives.
        result: its short name.
        rows: what its entries stand for.
        units: its unit.
        formulations: derivations, each takes the workspace, a way and the arguments along which derivatives are wanted.
        depends: which choices about closed loops its formulas depend on.
        solves: what the entries of formulations are solved from, called as they are.
        solved: its entries by formulation, those of which derivatives are taken after they are solved.
        way: how symbols move along the manifold, a key of `WAYS`.
    """

    text: str
    arguments: tuple[str, ...]
    result: str
    rows: Axis
    units: str
    formulations: dict[str, Callable[..., Sequence[Expr]]]
    depends: tuple[str, ...]
    solves: dict[str, Callable[..., RowSolve | None]] = field(default_factory=dict)
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
        formulations = {
            name: (by_lagrange if name == "lagrange" else Formulation)(_derived(derive, way, along))
            for name, derive in self.formulations.items()
        }
        formulations |= {
            name: replace(formulations[name], solve=_derived(one, way, along)) for name, one in self.solves.items()
        }
        return Output(
            f"derivatives [{' | '.join(f'd{self.result}/d{one}' for one in blocks)}] {how} of {self.text}",
            self.arguments,
            f"d{self.result}",
            (self.rows, lambda w: tuple(label for name in along for label in axes[name](w))),
            f"{self.units}, per unit of what moves",
            "only",
            formulations,
            default_in="request",
            may_fail="reported",
            depends=self.depends,
            prefer=partial(_cheaper, formulations) if "implicit" in formulations else None,
            size=Size((0, 45), 1.5).times(len(along)),
            remark=self.kinks if way == "free" else self.remark,
        )

    def remark(self, w: Workspace) -> str:
        """Return what is independent, and where there is no value."""
        return chosen(w) + self.kinks(w)

    def kinks(self, w: Workspace) -> str:
        """Return where it has no slope."""
        entries: Sequence[Expr] = w.once(self.solved["forward"]) if self.solved else ()
        return kinks(entries, (*w.state.q, *w.state.qd))

    @property
    def blocks(self) -> str:
        """What J is made of, in words."""
        return f"[{' | '.join(f'd{self.result}/d{BLOCKS[name]}' for name in self.arguments)}]"


def _derived(derive: Callable[..., Any], way: str, along: tuple[str, ...]) -> Callable[[Workspace], Any]:
    return lambda w: derive(w, way, *along)


def chosen(w: Workspace) -> str:
    """Return what is independent in a closed scene, behind the text of what moves along its manifold."""
    places, speeds = (", ".join(one(w)) or "nothing" for one in (independent_positions, independent_velocities))
    return (
        f"; independent positions are {places}, velocities {speeds}; no number where these do not determine the others"
    )


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
            "implicit": partial(columns_of, implicit, 0),
            "recursive": partial(columns_of, by_recursion, 0),
            "forward": partial(tangent, closed.forward, "forward"),
            "lagrange": partial(tangent, closed.lagrange_forward, "lagrange"),
        },
        _CHOICES,
        {"implicit": partial(solve_of, implicit, 0), "recursive": partial(solve_of, by_recursion, 0)},
        {"forward": closed.forward, "lagrange": closed.lagrange_forward},
    ),
    "multipliers": Derivative(
        "the multipliers",
        _OF_MOTION,
        "lambda",
        labels.kept_rows,
        "N or N m",
        {
            "implicit": partial(columns_of, implicit, 1),
            "recursive": partial(columns_of, by_recursion, 1),
            "forward": partial(tangent, closed.multipliers, "forward"),
            "lagrange": partial(tangent, closed.lagrange_multipliers, "lagrange"),
        },
        _CHOICES,
        {"implicit": partial(solve_of, implicit, 1), "recursive": partial(solve_of, by_recursion, 1)},
        {"forward": closed.multipliers, "lagrange": closed.lagrange_multipliers},
    ),
    "inverse_dynamics": Derivative(
        "the driving forces of the closed mechanism",
        ("q", "qd", "qdd"),
        "tau",
        labels.velocities,
        FORCES,
        {
            "implicit": implicit_inverse,
            "forward": partial(tangent, closed.inverse, "forward"),
            "lagrange": partial(tangent, closed.lagrange_inverse, "lagrange"),
        },
        ("independent",),
        {},
        {"forward": closed.inverse, "lagrange": closed.lagrange_inverse},
        "motion",
    ),
    "velocities": Derivative(
        "the velocities that the loops allow",
        ("q", "ui"),
        "qd",
        labels.velocities,
        "rad/s or m/s",
        {"partition": slopes_of_velocities, "normal": normal_slopes_of_velocities},
        ("independent",),
    ),
    "positions": Derivative(
        "the positions at which the loops stay closed, along the directions of the velocities",
        ("q",),
        "q",
        COLUMNS["q"],
        "rad or m",
        {
            "partition": partial(slopes_of_positions, lambda w: w.loops.recursive_manifold),
            "normal": partial(slopes_of_positions, lambda w: w.loops.differentiated_manifold),
        },
        ("independent",),
    ),
}
"""What is differentiated along the manifold, by its name."""


MOTION_RESIDUAL = Output(
    "residual of the equations of motion, M qdd + h - tau - G^T lambda, and of their rows, G qdd + Gdot qd",
    ("q", "qd", "qdd", "tau", MULTIPLIERS),
    "residual",
    (lambda w: (*w.scene.velocities, *labels.kept_rows(w)),),
    f"{FORCES}, then m/s^2 or 1/s^2",
    "only",
    {"rnea": Formulation(equations), "lagrange": by_lagrange(lagrange_equations)},
    default_in="request",
    may_fail="reported",
    depends=("alpha", "beta"),
)
"""The equations that closed scenes solve, unsolved."""

RESIDUAL, UNPROJECTED = "motion_residual", "_unprojected_derivatives"

CLOSED_DERIVATIVES: dict[str, Output] = {
    **{f"{name}_derivatives": one.row(one.arguments) for name, one in ALONG_MANIFOLD.items()},
    **{
        f"{name}_by_{argument}": one.row((argument,))
        for name, one in ALONG_MANIFOLD.items()
        for argument in one.arguments
        if name != "positions"
    },
    **{
        f"{name}{UNPROJECTED}": ALONG_MANIFOLD[name].unprojected()
        for name in ("forward_dynamics", "inverse_dynamics", "multipliers")
    },
    **{
        f"{name}_by_{argument}": replace(derivatives("", OUTPUTS[name].constrained, argument), when_constrained="only")
        for argument in BESIDE
        for name in ("forward_dynamics", "inverse_dynamics", "multipliers")
    },
    RESIDUAL: MOTION_RESIDUAL,
}
"""Rows of closed scenes, by what is asked; what operators make is asked of all others, and of the residual."""
