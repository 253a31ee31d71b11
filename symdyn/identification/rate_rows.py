"""Rates of states of one's own as rows of a regression, beside those of driving forces.

    rate = N / D        D: of parameters alone, such as the inductance of a coil
    D ṡ - N = Y π + r   Y: slopes by the parameters π that this is linear in; r: what depends on none of them
    Y π = -r            a row a state; -r stands where a driving force is measured

States and inputs are measured columns, filtered as positions are, and ṡ is the derivative of what is left. They stand
behind the coordinates of a motion:

    q | t | inputs | states | rates of states

A parameter that driving forces are linear in, too, such as a motor's constant k in k i and in k ω, is one column. What
driving forces know of otherwise, as a length, keeps its value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Argument, Workspace
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import IdentifyError, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, gradient, reachable, substitute
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name
from symdyn.simulation import compiled_entries

INPUTS, STATES, RATES = "inputs", "internal", "rates"


@dataclass(frozen=True)
class RateRows:
    """What measured states say, linear in parameters."""

    names: tuple[str, ...]  # of the parameters, shape (p,)
    values: tuple[Expr | None, ...]  # their values in the scene; None where it has none
    units: tuple[str, ...]  # of the rows, shape (ns,)
    slopes: Callable[[Mapping[str, Array]], Array]  # of columns by name, as of `apart`, and q̇, to Y, shape (N, ns, p)
    known: Callable[[Mapping[str, Array]], Array]  # likewise to -r, shape (N, ns)


def width(scene: Scene) -> int:
    """Return how many columns the positions of a motion have, with what stands behind coordinates."""
    more = 1 + len(scene.inputs) + 2 * len(scene.states) if scene.given else 0
    return len(scene.coordinates) + more


def apart(scene: Scene, q: Array) -> dict[str, Array]:
    """Return the columns of positions and what stands behind them, shape (N, width), by the names of arguments."""
    counts = (len(scene.coordinates), 1, len(scene.inputs), len(scene.states))
    own, t, inputs, states, rates = np.split(q, np.cumsum(counts), axis=1)
    return {"q": own, TIME: t[:, 0] if t.size else t, INPUTS: inputs, STATES: states, RATES: rates}


def rate_rows(w: Workspace, linear: Sequence[str], fixed: Sequence[str]) -> RateRows:
    """Return the rows of a scene's states.

    Args:
        w: the scene, its parameters symbols.
        linear: parameters that driving forces are linear in; they are columns here too, where rates depend on them.
        fixed: those that they know of otherwise, which keep their values.

    Raises:
        IdentifyError: what keeps its value has none.
    """
    scene, graph = w.scene, w.graph
    rates = tuple(graph.symbol(acceleration_name(one.name)) for one in scene.states)
    parameters = {graph.symbol(p.name): p for p in scene.parameters}
    rows, units = list[Expr](), list[str]()
    for state, rate, own in zip(scene.states, w.state_rates, rates, strict=True):
        N, D = _cleared(rate, set(parameters))
        rows.append(D * own - N)
        units.append(" ".join(filter(None, (parameters[D].unit if D in parameters else "", state.rate_unit))))
    order = sorted(parameters, key=lambda x: parameters[x].name not in linear)
    kept = list[Expr]()
    for symbol in (one for one in order if parameters[one].name not in fixed):
        slopes = [gradient(row, [symbol])[0] for row in rows]
        if any(not one.is_zero for one in slopes) and not {symbol, *kept} & {*reachable(slopes)}:
            kept.append(symbol)
    values = {x: None if p.value is None else p.value.express(graph) for x, p in parameters.items()}
    slopes = [one for row in rows for one in gradient(row, kept)]
    known = substitute([-row for row in rows], dict.fromkeys(kept, graph.zero))
    met = {x for x in reachable([*slopes, *known]) if x in parameters}
    if lacking := [parameters[x].name for x in met if values[x] is None]:
        raise IdentifyError(
            f"{scene.name}: {listed(lacking)}: without a value, and rates of states are not linear in it; give it one"
        )
    numbers = {x: value for x, value in values.items() if x in met and value is not None}
    kinds = {"q": w.state.q, "qd": w.state.qd, TIME: (graph.symbol(TIME),), INPUTS: w.inputs, STATES: w.states}
    kinds[RATES] = rates
    parts = {
        name: _part(substitute(entries, numbers), kinds) for name, entries in (("slopes", slopes), ("known", known))
    }
    calls = compiled_entries(w, {name: part for name, part in parts.items() if part[0]})

    def called(name: str, at: Mapping[str, Array]) -> Array:
        found = np.asarray(calls[name](*(at[one.name] for one in parts[name][1])), dtype=np.float64)
        return np.broadcast_to(found, (len(at["qd"]), len(parts[name][0]))).reshape(len(at["qd"]), len(rows), -1)

    return RateRows(
        tuple(parameters[x].name for x in kept),
        tuple(values[x] for x in kept),
        tuple(units),
        lambda at: called("slopes", at) if kept else np.zeros((len(at["qd"]), len(rows), 0)),
        lambda at: called("known", at)[..., 0],
    )


def _part(entries: list[Expr], kinds: Mapping[str, tuple[Expr, ...]]) -> tuple[list[Expr], list[Argument]]:
    """Return entries and the arguments that they take, q̇ in any case: one of them says how many rows there are."""
    seen = {*reachable(entries)}
    takes = [name for name, symbols in kinds.items() if name == "qd" or not seen.isdisjoint(symbols)]
    return entries, [Argument(name, tuple(kinds[name]), name, (), scalar=name == TIME) for name in takes]


def _cleared(rate: Expr, parameters: set[Expr]) -> tuple[Expr, Expr]:
    """Return N and D of a rate: D are the denominators that parameters alone are in."""
    one = rate.graph.one
    if rate.op is Op.NEG:
        N, D = _cleared(rate.args[0], parameters)
        return -N, D
    if rate.op not in (Op.ADD, Op.SUB, Op.MUL, Op.DIV):
        return rate, one
    (N, D), (M, E) = (_cleared(x, parameters) for x in rate.args)
    if rate.op is Op.MUL:
        return N * M, D * E
    if rate.op is Op.DIV:
        told = {x for x in reachable([rate.args[1]]) if x.op is Op.SYMBOL}
        return (N, D * rate.args[1]) if told and told <= parameters else (rate, one)
    if D is not E:
        N, M, D = N * E, M * D, D * E
    return (N + M, D) if rate.op is Op.ADD else (N - M, D)
