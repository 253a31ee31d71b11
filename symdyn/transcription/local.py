"""Functions of a problem at each place of a motion: entries on the graph, and their nonzero partial derivatives.

One compiled function serves all places, as a batch. The functions come from a scene, what is free in it, and formulas
of the user. Unknowns at a place are of these kinds:

    q, s, u      coordinates, states of one's own, velocities       λ    multipliers of all rows, "multiplier"
    a            accelerations u̇                                    y    what the ends of intervals give way by, "slack"
    λ, Λ         forces and impulses of contacts, "contact" and "impulse", see `contact_entries`
    τ            driving forces and inputs, "force"                 t    time
    p            parameters that are unknowns, "free"

    balance      M u̇ + h - τ - Gᵀ λ,  then  G u̇ + Ġ u               at stages
    rates        q̇ = H(q) u,  then  ṡ                               at stages
    held         r(q), G u, |e|² - 1                                at the ends of intervals
    pull         H Gᵀ ν + ρ e,  0,  Gᵀ μ;  y = (ν, μ, ρ)            at the end of an interval
    path         formulas of the user                               at the ends of intervals
    running      the integrand of the cost                          at stages
    final        the cost of the end                                at the end
    cone, open   what contacts keep inside a phase                  at stages, at the ends of intervals
    momentum, law, touch, struck                                    between two phases

The balance is that of inverse dynamics, with accelerations as unknowns: it takes about half the operations of forward
dynamics, has no matrix to factor in it, and its derivatives take a third. A prescribed motion is a constraint
u_k = ṗ(t) like those of loops; its multiplier is the force that it takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain, product
from operator import add

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import Argument, LoopChoices, Workspace
from symdyn.dynamics.mechanism import TIME, cost, quaternions, refuse_ideal_friction
from symdyn.dynamics.outputs import Moving, dot, inverse_derivatives, kinks
from symdyn.errors import listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, gradient, reachable, substitute, tangents
from symdyn.scene import Quantity, Scene, parse
from symdyn.scene.joints import start_of
from symdyn.scene.values import Faults
from symdyn.simulation import compiled_entries
from symdyn.simulation.prescribed import drive_names, number_of, parameter_values
from symdyn.transcription.contact_entries import Contacts

PLACES = {
    "balance": "stage",
    "rates": "stage",
    "running": "stage",
    "cone": "stage",
    "held": "node",
    "pull": "node",
    "path": "node",
    "open": "node",
    "final": "end",
    "momentum": "joint",
    "law": "joint",
    "touch": "joint",
    "struck": "joint",
}
"""Where each local function is asked for."""

GIVEN = ("mode", "law")
"""Kinds of numbers that are no unknowns: what contacts do in a phase, and in a passage."""

Pattern = tuple[tuple[int, str, int], ...]


@dataclass(frozen=True)
class Local:
    """Entries at every place of some kind, and their slopes.

    Attributes:
        size: number of entries.
        pattern: of each partial derivative that is not zero: entry, kind of the unknown, its place in that kind.
        value, slopes: functions of the unknowns by kind, shape (count, width), to (count, size) and (count,
            nonzeros).
        linear: whether the slopes are the same everywhere.
    """

    size: int
    pattern: Pattern
    value: Callable[[Mapping[str, Array]], Array]
    slopes: Callable[[Mapping[str, Array]], Array]
    linear: bool = False


@dataclass(frozen=True)
class Written:
    """Entries of every local function on a workspace's graph.

    Attributes:
        kinds: symbols of the unknowns by kind.
        entries: by name of the function.
        driven: velocities whose driving forces are unknowns; behind velocities, as `Forces` counts them, all inputs.
        rows: number of rows, those of prescribed motions last.
        holding: the rows among them that hold a position.
        rest: the balance without what inverse dynamics finds.
        contacts: what opens and closes.
    """

    kinds: Mapping[str, tuple[Expr, ...]]
    entries: Mapping[str, Sequence[Expr]]
    driven: tuple[int, ...]
    rows: int
    holding: tuple[int, ...]
    rest: tuple[Expr, ...]
    contacts: Contacts


def written(w: Workspace, free: Sequence[str], formulas: Mapping[str, Sequence[Quantity]]) -> Written:
    """Return the entries of a scene; `formulas` are those of path, running and final.

    Raises:
        DerivationError: the equations do not exist, or have no derivative.
    """
    refuse_ideal_friction(w.scene)
    graph, n, given = w.graph, w.state.n, w.prescribed
    G, residual, rate, acceleration = _rows(w)
    holding = tuple(k for k, entry in enumerate(residual) if not entry.is_zero)
    own = [k for k, name in enumerate(w.scene.drives) if name and k not in given.place]
    driven = (*own, *range(n, n + len(w.inputs)))
    parts = [[w.scene.coordinates.index(name) for name in names] for names in quaternions(w.scene)]
    contacts = Contacts.of(w, len(G))
    count, first = len(contacts.gaps) + len(contacts.forces), len(holding) + len(G) + len(parts)
    kinds = {
        "q": w.state.q,
        "s": w.states,
        "u": w.state.qd,
        "a": w.state.qdd,
        "multiplier": symbols_of(w, "multiplier", len(G)),
        "force": (*(w.state.tau[k] for k in own), *w.inputs),
        "slack": symbols_of(w, "slack", first + count),
        "free": tuple(graph.symbol(name) for name in free),
        TIME: (graph.symbol(TIME),),
        "contact": contacts.forces,
        "mode": contacts.mode,
        "before": contacts.before,
        "impulse": contacts.impulses,
        "law": contacts.law,
    }
    forces = w.forces(list(w.state.qdd))
    across = [[row[k] for row in G] for k in range(n)]
    held = [graph.dot(row, kinds["multiplier"]) for row in across]
    for row, force in zip(contacts.rows, contacts.forces, strict=True):
        held = [x + part * force for x, part in zip(held, row, strict=True)]
    acting = [-(w.state.tau[k] if k in own else graph.zero) - held[k] for k in range(n)]
    nu, mu = kinds["slack"][: len(holding)], kinds["slack"][len(holding) : len(holding) + len(G)]
    moved = [graph.total(across[k][r] * x for r, x in zip(holding, nu, strict=True)) for k in range(n)]
    turned = [graph.total(across[k][r] * x for r, x in enumerate(mu)) for k in range(n)]
    if contacts.touches:
        more = contacts.pulled(kinds["slack"][first:], n)
        moved, turned = ([*map(add, *both)] for both in zip((moved, turned), more, strict=True))
        accelerated = (x for one in contacts.touches for x in one.rows)
        acceleration += contacts.balance([dot(row.entries, w.state.qdd) + row.bias for row in accelerated])
    pull = substitute(w.state.rates, dict(zip(w.state.qd, moved, strict=True)))
    for part, rho in zip(parts, kinds["slack"][len(holding) + len(G) : first], strict=True):
        for k in part:
            pull[k] = pull[k] + rho * w.state.q[k]
    pull += [graph.zero for _ in w.states]
    pull += turned
    lengths = [graph.total(w.state.q[k] * w.state.q[k] for k in part) - graph.one for part in parts]
    entries: dict[str, Sequence[Expr]] = {
        "balance": [*map(add, forces, acting), *acceleration],
        "rates": [*w.state.rates, *w.state_rates],
        "held": [*(residual[k] for k in holding), *rate, *lengths, *contacts.held(w.state.qd)],
        "pull": pull if kinds["slack"] else [],
    }
    entries |= {name: _expressed(w, found) for name, found in formulas.items()}
    if contacts.touches:
        entries |= {"cone": contacts.cone, "open": contacts.open(w.state.qd), **contacts.passage(w, G, forces)}
    return Written(kinds, entries, driven, len(G), holding, (*acting, *acceleration), contacts)


def _rows(w: Workspace) -> tuple[list[list[Expr]], list[Expr], list[Expr], list[Expr]]:
    """Return G, residuals, G u and G u̇ + Ġ u of all rows, those of prescribed motions last."""
    graph, u, a = w.graph, w.state.qd, w.state.qdd
    G: list[list[Expr]] = []
    residual: list[Expr] = []
    bias: list[Expr] = []
    if w.scene.is_constrained:
        rows = w.loops.recursive
        G, residual, bias = w.loops.G(rows), w.loops.residual(rows), w.loops.bias(rows)
    rate = [dot(row, u) for row in G]
    acceleration = [dot(row, a) + rest for row, rest in zip(G, bias, strict=True)]
    given = w.prescribed
    at = {speed: q for q, speed in zip(w.state.q, w.state.rates, strict=True)}
    for k, p, v, b in zip(given.place, given.position, given.velocity, given.acceleration, strict=True):
        G.append([graph.one if i == k else graph.zero for i in range(w.state.n)])
        residual.append(at[u[k]] - p)
        rate.append(u[k] - v)
        acceleration.append(a[k] - b)
    return G, residual, rate, acceleration


def symbols_of(w: Workspace, name: str, count: int) -> tuple[Expr, ...]:
    """Return so many symbols of unknowns."""
    return tuple(w.graph.symbol(f"{name}[{k}]") for k in range(count))


def _expressed(w: Workspace, formulas: Sequence[Quantity]) -> list[Expr]:
    """Return formulas on the graph: drives, accelerations and points by the names that trajectories give them."""
    return Moving(w, lambda: w.state.qdd, lambda: w.state.tau, lambda _: (), lambda: ()).expressed(formulas)


def partials(entries: Sequence[Expr], inputs: Sequence[Expr]) -> dict[tuple[int, int], Expr]:
    """Return the partial derivatives that are not zero, by entry and input: by columns or by rows, as costs less."""
    columns = [tangents(entries, {x: x.graph.one}) for x in inputs]
    rows = [gradient(entry, inputs) for entry in entries]
    by_columns = {(i, k): columns[k][i] for i in range(len(entries)) for k in range(len(inputs))}
    by_rows = {(i, k): rows[i][k] for i in range(len(entries)) for k in range(len(inputs))}
    found = min(by_columns, by_rows, key=lambda one: cost(one.values(), inputs))
    return {place: slope for place, slope in found.items() if not slope.is_zero}


def slopes_of(w: Workspace, result: Written, name: str, inputs: Sequence[Expr]) -> dict[tuple[int, int], Expr]:
    """Return the partial derivatives of a local function; those of inverse dynamics by recursion where that costs less.

    The recursion differentiates along velocities, which are plain partial derivatives where no quaternion is.
    """
    by_graph = partials(result.entries[name], inputs)
    if name != "balance" or w.state.rates != w.state.qd:
        return by_graph
    state, n = {"q": w.state.q, "qd": w.state.qd, "qdd": w.state.qdd}, w.state.n
    place = {x: k for k, x in enumerate(chain(*state.values()))}
    recursion = inverse_derivatives(w, tuple(state))
    slopes = {(i, k): x for (i, k), x in by_graph.items() if i >= n or inputs[k] not in place}
    beside = partials(result.rest[:n], inputs)
    for i, (k, x) in product(range(n), enumerate(inputs)):
        if x in place:
            slope = recursion[i * 3 * n + place[x]] + beside.get((i, k), w.graph.zero)
            slopes |= {} if slope.is_zero else {(i, k): slope}
    return min(by_graph, slopes, key=lambda one: cost(one.values(), inputs))


def locals_of(w: Workspace, result: Written) -> dict[str, Local]:
    """Return the local functions that have entries, compiled into one library."""
    parts, patterns, takes, linear = {}, {}, {}, {}
    for name, entries in result.entries.items():
        if not entries:
            continue
        inputs = inputs_of(result, entries)
        slopes = slopes_of(w, result, name, [symbol for _, _, symbol in inputs])
        places = sorted(slopes)
        patterns[name] = tuple((i, *inputs[k][:2]) for i, k in places)
        linear[name] = not appearing(slopes.values()) & set(chain(*result.kinds.values()))
        for which, some in ((name, list(entries)), (_slopes(name), [slopes[place] for place in places])):
            symbols = appearing(some)
            kinds = [kind for kind, those in result.kinds.items() if kind == "q" or not symbols.isdisjoint(those)]
            takes[which] = kinds
            parts[which] = some, [argument_of(kind, result.kinds[kind]) for kind in kinds]
    calls = compiled_entries(w, parts)

    def caller(which: str) -> Callable[[Mapping[str, Array]], Array]:
        if which not in calls:  # nothing varies
            return lambda at: np.zeros((len(at["q"]), 0))
        return lambda at: np.asarray(calls[which](*(at[kind] for kind in takes[which])), dtype=np.float64)

    made = {
        name: Local(len(result.entries[name]), pattern, caller(name), caller(_slopes(name)), linear[name])
        for name, pattern in patterns.items()
    }
    if result.entries["rates"] == list(w.state.qd):
        made["rates"] = replace(made["rates"], value=lambda at: at["u"])
    return made


def inputs_of(result: Written, entries: Sequence[Expr]) -> list[tuple[str, int, Expr]]:
    """Return the unknowns that entries have in them: kind, place in it, symbol."""
    seen = appearing(entries)
    flat = [(kind, k, symbol) for kind, symbols in result.kinds.items() for k, symbol in enumerate(symbols)]
    flat = [one for one in flat if one[0] not in GIVEN]
    return [one for one in flat if one[2] in seen]


def _slopes(name: str) -> str:
    return f"{name}_slopes"


def appearing(entries: Iterable[Expr]) -> set[Expr]:
    """Return the symbols in entries."""
    return {node for node in reachable(list(entries)) if node.op is Op.SYMBOL}


NAMES = {"q": "q", "s": "internal", "u": "qd", "a": "qdd", "force": "tau", "free": "values"}
"""What an argument of generated code is called where it is not called by its kind."""


def argument_of(kind: str, symbols: tuple[Expr, ...]) -> Argument:
    """Return the argument that unknowns of a kind are in generated code."""
    return Argument(NAMES.get(kind, kind), symbols, kind, (), scalar=kind == TIME)


Formulas = tuple[tuple[str, tuple[Quantity, ...]], ...]
"""Those of the user, by the function that they are."""


@dataclass(frozen=True, eq=False)
class Source:
    """Where the functions of a problem come from: the same for every mesh, method and bounds.

    Pickled is what they are made from; another process makes them again.
    """

    scene: Scene  # the mechanism
    free: tuple[str, ...]  # names of the parameters that are unknowns
    formulas: Formulas  # those of path, running and final
    workspace: Workspace  # with the graph that they are written on
    written: Written  # their entries
    locals: Mapping[str, Local]  # the functions, compiled

    def __reduce__(self) -> tuple[Callable[..., Source], tuple[Scene, tuple[str, ...], Formulas]]:
        """Return the function that makes it, and of what."""
        return source, (self.scene, self.free, self.formulas)


@lru_cache(maxsize=16)
def source(scene: Scene, free: tuple[str, ...], formulas: Formulas) -> Source:
    """Return the functions of a scene, the parameters that are unknowns without value; theirs decide about loops."""
    values = parameter_values(scene)
    opened = replace(scene, parameters=tuple(replace(p, value=None) if p.name in free else p for p in scene.parameters))
    at = {name: number_of(values[name], values, f"parameters.{name}", Faults("")) or 0.0 for name in free}
    w = Workspace(opened, LoopChoices(parameters=tuple(at.items())))
    found = written(w, free, dict(formulas))
    return Source(scene, free, formulas, w, found, locals_of(w, found))


WHAT = {
    "balance": "the equations of motion",
    "rates": "the rates of states",
    "held": "loops and prescribed motions",
    "path": "the path",
    "open": "contacts",
    "law": "impacts",
    "running": "the cost",
    "final": "the final cost",
}
"""What functions are called that may have kinks."""


def remarks(source: Source) -> Iterator[str]:
    """Tell where functions have kinks, and whether the start, which is given whole, fixes what is unknown."""
    w, found = source.workspace, source.written
    meant = dict(zip(w.state.tau, map(w.graph.symbol, drive_names(w.scene)), strict=True))
    varied = substitute(list(chain(*found.kinds.values())), meant)
    for name, what in WHAT.items():
        if told := kinks(substitute(list(found.entries.get(name, ())), meant), varied):
            yield f"slopes of {what} are {told.removeprefix('; ')}"
    if "held" in source.locals:
        pattern = source.locals["held"].pattern
        moving = {source.free[k] for i, kind, k in pattern if kind == "free" and i < len(found.holding)}
        if moving:
            yield (
                f"rows at the start, which is given whole, have {listed(sorted(moving))} in them: only values that "
                "close them there are left"
            )


def taken(scene: Scene, free: Sequence[str], given: Mapping[str, Mapping[str, object]]) -> Iterator[str]:
    """Tell where the guess of an unknown parameter is taken for its value: in what must be a number."""
    formulas = [
        (f"{where}: {name}", parse(text))
        for where, one in given.items()
        for name, text in one.items()
        if isinstance(text, str)
    ]
    for where, names, those in (
        ("start", scene.coordinates, start_of(scene).position),
        ("start", [one.name for one in scene.states], [one.value for one in scene.states]),
        ("start rates", scene.velocities, start_of(scene).velocity),
    ):
        formulas += [(f"{where}: {n}", x) for n, x in zip(names, those, strict=True) if n not in given.get(where, {})]
    for joint in scene.moving:
        limits = joint.limits
        every = (limits.lower, limits.upper, limits.velocity, limits.effort)
        formulas += [(f"limits of {joint.name}", x) for x in every if isinstance(x, Quantity)]
    for where, formula in formulas:
        if unknown := [name for name in formula.symbols if name in free]:
            yield f"{where} takes {listed(unknown)} as the scene has it, not as it is found"
