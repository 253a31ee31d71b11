"""Directions along which outputs are differentiated: of every argument for itself, or along a closed scene's manifold.

    f        an output of q, u, and u̇ or τ
    X_k f    its derivative along velocity k: d/dε f(q ∘ exp(ε X_k), u, ·) at ε = 0, all other arguments held
    J        [X f | ∂f/∂u | …], a column for every direction of every argument, in their order
    d        a direction of every argument: an amount for each column

Coordinates have as many columns as there are velocities: plain partial derivatives where velocities are rates of
coordinates, else along the axes of the moved frame (v, then ω). Derivatives of second order do not commute there.

Along the manifold independent positions and velocities, and forces or independent accelerations, have a column each,
and dependent ones move along (`Manifold`). With rolling there are more independent positions than velocities. The same
independent velocities serve all outputs; of inverse dynamics, which may solve for other ones, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import ClassVar

from symdyn.dynamics.loops.manifold import Manifold, Seeds
from symdyn.dynamics.loops.partition import Partition
from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.state import INPUTS, STATES, TIME, letters_of, symbols_of
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.named_functions import (
    ALONG_MANIFOLD,
    DIRECTIONS,
    MOMENTA,
    MULTIPLIERS,
    direction,
    independent_symbols,
    multiplier_symbols,
)
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.tree_formulations import turns
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, LocalPartials, gradient, operands, tangents
from symdyn.scene.values import acceleration_name

# What the columns stand for


def _label(w: Workspace, k: int) -> str:
    """Return the coordinate whose rate velocity k is, or the velocity along which a quaternion moves."""
    rates = [q for q, rate in zip(w.scene.coordinates, w.state.rates, strict=True) if rate is w.state.qd[k]]
    return rates[0] if rates else f"along {w.scene.velocities[k]}"


def declared(w: Workspace, argument: str) -> tuple[str, ...]:
    """Return the names of inputs or states; DerivationError where there are none."""
    if not (letters := letters_of(w.scene, argument)):
        what, such = ("inputs", "[inputs.u]") if argument == INPUTS else ("states", "[states.s]")
        raise DerivationError(f"{w.scene.name} has no {what} to differentiate by; declare one, such as {such}")
    return tuple(one.name for one in letters)


COLUMNS: dict[str, Axis] = {
    "q": lambda w: tuple(_label(w, k) for k in range(w.state.n)),
    "qd": labels.velocities,
    "qdd": lambda w: tuple(map(acceleration_name, w.scene.velocities)),
    "tau": lambda w: tuple(f"force on {name}" for name in w.scene.velocities),
    MOMENTA: lambda w: tuple(f"momentum of {name}" for name in w.scene.velocities),
    "qi": lambda w: tuple(str(one.value) for one in independent_symbols(w, "qi")),
    "ui": lambda w: tuple(str(one.value) for one in independent_symbols(w, "ui")),
    MULTIPLIERS: lambda w: tuple(f"multiplier of {name}" for name in labels.kept_rows(w)),
    TIME: labels.fixed(TIME),
    INPUTS: partial(declared, argument=INPUTS),
    STATES: partial(declared, argument=STATES),
}
"""Arguments that an output is differentiated along, and what the columns stand for."""


def independent_positions(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent position; those of independent velocities come first."""
    return tuple(COLUMNS["q"](w)[k] for k in w.loops.position_level[1].independent)


def independent_velocities(w: Workspace) -> tuple[str, ...]:
    """Return a label for each independent velocity."""
    return tuple(w.scene.velocities[k] for k in w.loops.decisions.partition.independent)


def directions_of(w: Workspace, argument: str) -> list[Seeds]:
    """Return the directions of one argument: how fast each symbol of it moves along each, as many as it has columns."""
    if argument == "q":
        return list(w.directions.along)
    if argument in ("qi", "ui"):
        symbols = independent_symbols(w, argument)
    elif argument == MULTIPLIERS:
        symbols = multiplier_symbols(w)
    elif argument == MOMENTA:
        symbols = direction(w.graph, MOMENTA, w.state.n)
    elif argument == TIME:
        symbols = (w.graph.symbol(TIME),)
    elif argument in (INPUTS, STATES):
        symbols = symbols_of(w.scene, w.graph, argument)
    else:
        symbols = {"qd": w.state.qd, "qdd": w.state.qdd, "tau": w.state.tau}[argument]
    return [{one: w.graph.one} for one in symbols]


# Differentiation of a graph


def forward(entries: Sequence[Expr], directions: Sequence[Seeds], slopes: LocalPartials = operands) -> list[Expr]:
    """Return the derivatives of entries along directions, row by row, a sweep for each column."""
    return by_row([tangents(entries, seeds, slopes) for seeds in directions], len(entries))


def by_row(columns: Sequence[Sequence[Expr]], rows: int) -> list[Expr]:
    """Return the entries of columns, row by row."""
    return [column[i] for i in range(rows) for column in columns]


def reverse(entries: Sequence[Expr], directions: Sequence[Seeds], slopes: LocalPartials = operands) -> list[Expr]:
    """Return the derivatives of entries along directions, row by row, a sweep for each row."""
    inputs = list(dict.fromkeys(symbol for one in directions for symbol in one))
    found = []
    for entry in entries:
        partials = dict(zip(inputs, gradient(entry, inputs, slopes), strict=True))
        found += [entry.graph.total(h * partials[x] for x, h in one.items()) for one in directions]
    return found


SWEEPS = {"forward": forward, "reverse": reverse}


def cheaper(w: Workspace, nodes: Sequence[Expr], sweep: Callable[[LocalPartials], list[Expr]]) -> list[Expr]:
    """Return what a sweep over nodes finds, turns read as such or not: by the variant that costs least."""
    state = (*w.state.q, *w.state.qd, *w.state.qdd, *w.state.tau)
    return min((sweep(slopes) for slopes in (operands, turns(nodes))), key=lambda found: cost(found, state))


# Where outputs are differentiated


class TangentSpace:
    """All directions of every argument, the others held: of trees, and of closed scenes as if no loop tied them.

    Methods take the workspace, the formulation of what is differentiated, and the arguments along which it is.
    """

    columns: ClassVar[Mapping[str, Axis]] = COLUMNS
    """What the columns of a Jacobian stand for, by argument."""
    amounts_of: ClassVar[Mapping[str, str]] = DIRECTIONS
    """The argument that says along which way another one moves."""
    blocks: ClassVar[Mapping[str, str]] = {}
    """What an argument is called below a derivative, where it has another name there."""

    def jacobian(self, result: str, along: Sequence[str]) -> str:
        """Return what J is made of, in words."""
        return f"[{' | '.join(f'd{result}/d{self.blocks.get(one, one)}' for one in along)}]"

    def labels(self, w: Workspace, along: Sequence[str]) -> tuple[str, ...]:
        """Return what the columns of J stand for."""
        return tuple(label for one in along for label in self.columns[one](w))

    def amounts(self, w: Workspace, along: Sequence[str]) -> dict[str, tuple[Expr, ...]]:
        """Return the entries of d, in the order of the columns of J, by argument."""
        return {one: direction(w.graph, self.amounts_of[one], len(self.columns[one](w))) for one in along}

    def seeds(self, w: Workspace, formulation: str, along: Sequence[str]) -> list[Seeds]:
        """Return how fast each symbol moves along each column of J."""
        return [one for name in along for one in directions_of(w, name)]

    def direction(self, w: Workspace, formulation: str, along: Sequence[str]) -> Seeds:
        """Return how fast each symbol moves along d."""
        found: Seeds = {}
        amounts = chain.from_iterable(self.amounts(w, along).values())
        for amount, way in zip(amounts, self.seeds(w, formulation, along), strict=True):
            for symbol, h in way.items():
                found[symbol] = found.get(symbol, w.graph.zero) + amount * h
        return found

    def pullback(
        self, w: Workspace, formulation: str, along: Sequence[str], phi: Expr, slopes: LocalPartials = operands
    ) -> list[Expr]:
        """Return the slopes of one number along the columns of J, by sweeps backwards."""
        return reverse([phi], self.seeds(w, formulation, along), slopes)

    def by_parameter(self, w: Workspace, formulation: str, symbol: Expr) -> Seeds:
        """Return how fast each symbol moves with a parameter, the arguments held."""
        return {symbol: w.graph.one}


class AlongManifold(TangentSpace):
    """Directions along which loops stay closed: dependent positions and velocities move along with independent ones."""

    columns: ClassVar = {
        "q": independent_positions,
        "qd": independent_velocities,
        "ui": independent_velocities,
        "qdd": lambda w: tuple(map(acceleration_name, independent_velocities(w))),
        "tau": COLUMNS["tau"],
    }
    amounts_of = ALONG_MANIFOLD
    blocks: ClassVar = {"q": "q_i", "qd": "qd_i", "qdd": "qdd_i"}

    def __init__(self, accelerating: bool = False) -> None:
        """Take accelerations along or not: where they are an argument, dependent ones move with all the others."""
        self.accelerating = accelerating

    def seeds(self, w: Workspace, formulation: str, along: Sequence[str]) -> list[Seeds]:
        """Return how fast each symbol moves along each column of J."""
        manifold, found = manifold_of(w, formulation), list[Seeds]()
        for name in along:
            if name == "qdd":
                found += manifold.by_acceleration
                continue
            velocity, force = manifold.by_velocity, manifold.by_force
            moved = {"q": manifold.by_position, "qd": velocity, "ui": velocity, "tau": force}[name]
            found += map(manifold.accelerating, moved) if self.accelerating else moved
        return found

    def direction(self, w: Workspace, formulation: str, along: Sequence[str]) -> Seeds:
        """Return how fast each symbol moves along d."""
        return manifold_of(w, formulation).direction(self.amounts(w, along))

    def pullback(
        self, w: Workspace, formulation: str, along: Sequence[str], phi: Expr, slopes: LocalPartials = operands
    ) -> list[Expr]:
        """Return the slopes of one number along the columns of J, by sweeps backwards."""
        found = manifold_of(w, formulation).pullback(phi, along, slopes)
        return [x for name in along for x in found[name]]

    def by_parameter(self, w: Workspace, formulation: str, symbol: Expr) -> Seeds:
        """Return how fast each symbol moves with a parameter, what is independent held."""
        loops, manifold = w.loops, manifold_of(w, formulation)
        rows = loops.differentiated if formulation == "lagrange" else loops.recursive
        seeds = manifold.by_parameter(symbol, [rows.residual[k] for k in loops.position_level[0]])
        return manifold.accelerating(seeds) if self.accelerating else seeds


def manifold_of(w: Workspace, formulation: str) -> Manifold:
    """Return the manifold as derivatives of a formulation take it: all states of a tree."""
    if not w.scene.is_constrained:
        every = Partition(tuple(range(w.state.n)), (), ())
        return Manifold(w.graph, w.state, w.directions.along, [], every, [], [], every, Partition.solve_dependent)
    return w.loops.differentiated_manifold if formulation == "lagrange" else w.loops.recursive_manifold


FREE, MANIFOLD, MOTION = TangentSpace(), AlongManifold(), AlongManifold(accelerating=True)
