"""What the derivation hands to all other packages: named functions on one graph, their arguments, their cost.

Formulations are compared by counts of operations. Categories and weights are those of
`symdyn.dynamics.mechanism.cost`. What has no symbol below it is a constant and costs nothing at run time. Binding time
says when the arguments of an operation are known: work on parameters alone is done once for a mechanism, work on q once
for a configuration, and so on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from symdyn.arguments import check_arguments
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.mechanism.cost import CATEGORY, FREE, WEIGHTS as COSTS
from symdyn.dynamics.mechanism.linear_solve import RowSolve
from symdyn.dynamics.mechanism.state import INPUTS, STATES, TIME, letters_of, symbols_of
from symdyn.dynamics.outputs.contact_rows import Touch, touching
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.pair_runs import PairRuns
from symdyn.dynamics.recursive.table_loops import TableLoop, count_loop
from symdyn.errors import UnknownNameError, choice, listed
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import force_unit
from symdyn.shown import Shown


@dataclass(frozen=True)
class Argument:
    """One argument of a function: a vector, or one number.

    Attributes:
        name: "q", "qd", "qdd", "tau", "p", "t", "inputs", "internal", "params", or "prepared" in programs that prepare.
        symbols: graph symbols of its entries, shape (len,).
        text: what it is, for headers and docstrings.
        units: unit of each entry, "" where there is none; () where they are not told.
        scalar: whether it is one number and no vector, as time is.
        names: names and conventions of the entries, one line; "" where the text says them.
    """

    name: str
    symbols: tuple[Expr, ...]
    text: str
    units: tuple[str, ...]
    scalar: bool = False
    names: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape: () for one number."""
        return () if self.scalar else (len(self.symbols),)


@dataclass(frozen=True)
class Function:
    """One generated function: entries of an array as expressions of its arguments.

    Attributes:
        name: as in generated code, e.g. "inverse_dynamics", "pose_tool", or "tree_mass_matrix" of a scene with loops.
        text: what it computes, one line.
        arguments: in calling order; free parameters last, whether used or not.
        result: name of the result, e.g. "tau".
        shape: shape of the result; () for a scalar.
        entries: row-major, length = product of shape.
        units: unit of the result, one line.
        formulation: which one derived it, e.g. "rnea".
        request: what to ask `derive` for, e.g. "pose:tool".
        unique: which entries rigid bodies determine, row-major; () for all. The others are one choice among many.
        labels: what its rows stand for, then its columns; () where none is given.
        loop: the table that code may go over in a loop; None where it is lines. With it, entries may be left out.
        solve: what entries come from at last, as equations have it; None where code has nothing to go over in a loop.
    """

    name: str
    text: str
    arguments: tuple[Argument, ...]
    result: str
    shape: tuple[int, ...]
    entries: tuple[Expr, ...]
    units: str
    formulation: str
    request: str = ""
    unique: tuple[bool, ...] = ()
    labels: tuple[tuple[str, ...], ...] = ()
    loop: TableLoop | None = None
    solve: RowSolve | PairRuns | None = None

    @property
    def is_loop_alone(self) -> bool:
        """Whether its entries were left out, so that nothing but a loop over its table computes it."""
        return self.loop is not None and not self.entries

    def values(self, given: Iterable[Any], number: Callable[[Any], Any] = float) -> dict[Expr, Any]:
        """Return the value of every symbol of its arguments, given in calling order, each as `number` makes it."""
        import numpy as np  # what computes nothing does without

        return {
            symbol: number(value)
            for argument, values in zip(self.arguments, given, strict=True)
            for symbol, value in zip(argument.symbols, np.ravel(values).tolist(), strict=True)
        }


@dataclass(frozen=True)
class Equations(Shown):
    """Named functions of a scene on one graph; `closing` is what was chosen about its loops."""

    scene: Scene
    graph: Graph
    functions: tuple[Function, ...]
    closing: LoopChoices = LoopChoices()

    def __repr__(self) -> str:
        shown = (f"{one.name}({', '.join(x.name for x in one.arguments)})" for one in self.functions)
        return f"<Equations of {self.scene.name}: {listed(shown)}>"

    def __getitem__(self, name: str) -> Function:
        """Return the function called `name`, or asked for by it; UnknownNameError if it was not derived."""
        check_arguments(Equations.__getitem__, locals(), UnknownNameError)
        for function in self.functions:
            if name in (function.name, function.request):
                return function
        raise UnknownNameError(f"{name} was not derived; {choice(name, (f.name for f in self.functions))}")

    def at_rest(self) -> Equations:
        """Return the equations of the mechanism at rest, q̇ = 0 and no longer an argument, on the same graph.

        Inverse dynamics at rest is M(q) q̈ + g(q), forward dynamics starts from standstill, and velocity forces are
        zero. Functions without velocities are left as they are.
        """
        symbols = [x for one in self.functions for a in one.arguments if a.name == VELOCITIES for x in a.symbols]
        every = [entry for one in self.functions for entry in one.entries]
        entries = iter(substitute(every, dict.fromkeys(symbols, self.graph.zero)))

        def resting(one: Function) -> Function:
            others = tuple(a for a in one.arguments if a.name != VELOCITIES)
            if len(others) == len(one.arguments):
                return one
            return replace(one, text=f"{one.text}; at rest, qd = 0", arguments=others, loop=None, solve=None)

        functions = [replace(resting(one), entries=tuple(next(entries) for _ in one.entries)) for one in self.functions]
        return Equations(self.scene, self.graph, tuple(functions))


DRIVES = "tau"
"""The argument of what finds a motion."""

VELOCITIES = "qd"

ARGUMENTS: dict[str, tuple[str, dict[str, str]]] = {  # text, unit by unit of the coordinate
    "q": ("joint positions", {"rad": "rad", "m": "m", "1": "1"}),
    "qd": ("joint velocities", {"rad": "rad/s", "m": "m/s"}),
    "qdd": ("joint accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "tau": ("driving forces, positive accelerates the joint", {unit: force_unit(unit) for unit in ("rad", "m")}),
    TIME: ("time", {"s": "s"}),
    INPUTS: ("inputs", {}),
    STATES: ("states", {}),
    "dinternal": ("direction of the states", {}),
    "qi": ("independent joint positions", {"rad": "rad", "m": "m"}),
    "ui": ("independent joint velocities", {"rad": "rad/s", "m": "m/s"}),
    "multipliers": ("multipliers of the rows that close loops", {"": "N or N m"}),
    "p": ("generalized momenta M qd", {"rad": "kg m^2/s", "m": "kg m/s"}),
    "dp": ("direction of the momenta", {"rad": "kg m^2/s", "m": "kg m/s"}),
    "dq": ("direction of the positions, along the velocities", {"rad": "rad", "m": "m"}),
    "dqd": ("direction of the velocities", {"rad": "rad/s", "m": "m/s"}),
    "dqdd": ("direction of the accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "dtau": ("direction of the driving forces", {unit: force_unit(unit) for unit in ("rad", "m")}),
    "dqi": ("direction of the independent positions", {"rad": "rad", "m": "m"}),
    "dui": ("direction of the independent velocities", {"rad": "rad/s", "m": "m/s"}),
    "dmultipliers": ("direction of the multipliers", {"": "N or N m"}),
    "dq_i": ("direction of the independent positions, along the velocities", {"rad": "rad", "m": "m"}),
    "dqd_i": ("direction of the independent velocities", {"rad": "rad/s", "m": "m/s"}),
    "dqdd_i": ("direction of the independent accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "qd_r": ("reference velocities", {"rad": "rad/s", "m": "m/s"}),
    "qdd_r": ("reference accelerations", {"rad": "rad/s^2", "m": "m/s^2"}),
    "forces": ("forces on the velocities", {unit: force_unit(unit) for unit in ("rad", "m")}),
    "step": ("displacement along the velocities", {"rad": "rad", "m": "m"}),
    "q_to": ("joint positions to be reached", {"rad": "rad", "m": "m", "1": "1"}),
    "pose": ("pose [R | p], row by row", {"": ""}),
    "weights": ("weights of the entries of the result, row by row", {"": ""}),
    "mask": ("1 for each contact that is closed, else 0", {"": "1"}),
    "proximal": ("term on the diagonal of W M^-1 W^T, such as 1e-5 of its trace", {"": "1/kg"}),
    "slip": ("direction of the slip of each contact, a sign or a unit vector, 0 where it sticks", {"": "1"}),
}

MODES, PROXIMAL = ("mask", "slip"), "proximal"  # of every contact; of the equations of their forces

ALONG_MANIFOLD = {"q": "dq_i", "qd": "dqd_i", "qdd": "dqdd_i", "tau": "dtau"}
"""The same of closed scenes, where dependent positions, velocities and accelerations move along."""

MOMENTA, MULTIPLIERS = "p", "multipliers"
"""Arguments of what takes momenta in place of velocities, and the multipliers as given."""

DIRECTIONS = {
    "q": "dq",
    "qd": "dqd",
    "qdd": "dqdd",
    "tau": "dtau",
    MOMENTA: "dp",
    "qi": "dqi",
    "ui": "dui",
    MULTIPLIERS: "dmultipliers",
    STATES: "dinternal",
}
"""The argument that says along which way another one moves."""

OF_INDEPENDENT = {"qi", "ui", "dqi", "dui"}
"""Arguments of the independent velocities of a closed scene, or of the coordinates whose rates they are."""

RIGHT, STEP, TO = "forces", "step", "q_to"
"""Arguments of what solves with the mass matrix, adds displacements to positions, and takes them apart."""

POSE = "pose"
"""The argument of what finds positions."""

REFERENCE, REFERENCE_RATE = "qd_r", "qdd_r"
"""Arguments of what goes along a reference motion beside the motion itself."""

WEIGHTS = "weights"
"""The argument that makes one number of a result: their sum, each entry with its weight."""


def independent_symbols(workspace: Workspace, name: str) -> tuple[Expr, ...]:
    """Return the independent velocities of a closed scene ("ui"), or the coordinates whose rates they are ("qi")."""
    whole = workspace.state.qd if name == "ui" else workspace.loops.coordinates
    return tuple(whole[k] for k in workspace.loops.decisions.partition.independent)


def multiplier_symbols(workspace: Workspace) -> tuple[Expr, ...]:
    """Return the symbols of the multipliers of a closed scene's independent rows."""
    return direction(workspace.graph, MULTIPLIERS, len(workspace.loops.decisions.independent_rows))


def direction(graph: Graph, name: str, n: int) -> tuple[Expr, ...]:
    """Return the symbols of an argument that the scene's formulas cannot name, shape (n,)."""
    return tuple(graph.symbol(f"{name}[{k}]") for k in range(n))


BODY_AXES = "velocities v and w of free joints and w of spherical joints are along the axes of the moved frame"


def conventions(scene: Scene, name: str) -> str:
    """Return the names of the coordinates or velocities, and what they mean where that is not plain; else ""."""
    plain = len(scene.coordinates) == len(scene.velocities)
    if name in ("q", TO):
        told = scene.coordinates_of_joints() or runs(scene.coordinates)
        return told + ("" if plain else "; quaternions are in the order (w, x, y, z)")
    if name in ("qd", "dq", "qd_r", "p", "dp", RIGHT, STEP) and not plain:
        return f"{runs(scene.velocities)}; {BODY_AXES}"
    return ""


def runs(names: Sequence[str]) -> str:
    """Return names in order, those that count up told by the first and the last: "x, q1 ... q7"."""
    groups: list[list[str]] = []
    for name in names:
        if groups and _next(groups[-1][-1]) == name:
            groups[-1].append(name)
        else:
            groups.append([name])
    return ", ".join(", ".join(g) if len(g) < 4 else f"{g[0]} ... {g[-1]}" for g in groups)


def _next(name: str) -> str:
    stem = name.rstrip("0123456789")
    digits = name[len(stem) :]
    return f"{stem}{int(digits) + 1}" if digits.isdecimal() else ""


def _of_the_scene(workspace: Workspace, name: str, text: str, weighed: Sequence[str]) -> Argument | None:
    """Return an argument whose entries are other than velocities or coordinates; None of these."""
    scene, graph = workspace.scene, workspace.graph
    if name == WEIGHTS:
        return Argument(name, direction(graph, name, len(weighed)), text, (), names=runs(weighed))
    if name in (INPUTS, STATES):
        letters = letters_of(scene, name)
        told = runs([one.name for one in letters])
        return Argument(name, symbols_of(scene, graph, name), f"{text}: {told}", tuple(one.unit for one in letters))
    if name == DIRECTIONS[STATES]:
        nodes = direction(graph, name, len(scene.states))
        told = runs([one.name for one in scene.states])
        return Argument(name, nodes, f"{text}: {told}", tuple(one.unit for one in scene.states))
    if name in MODES:
        names = mode_names(workspace, name)
        return Argument(name, direction(graph, name, len(names)), f"{text}: {runs(names)}", ("1",) * len(names))
    if name == POSE:
        return Argument(name, direction(graph, name, 12), text, ("1", "1", "1", "m") * 3)
    if name == PROXIMAL:
        return Argument(name, direction(graph, name, 1), text, ("1/kg",), scalar=True)
    if name in (MULTIPLIERS, DIRECTIONS[MULTIPLIERS]):
        decisions = workspace.loops.decisions
        told = "; ".join(decisions.names[k] for k in decisions.independent_rows)
        return Argument(name, direction(graph, name, len(decisions.independent_rows)), f"{text}: {told}", ())
    return None


def mode_names(workspace: Workspace, name: str) -> list[str]:
    """Return what the entries of `mask` or of `slip` are called: two of a contact that slips along two directions."""
    touches: tuple[Touch, ...] = workspace.once(touching, True)
    sizes = [max(1, len(one.tangents)) if name == MODES[1] else 1 for one in touches]
    words = [("",) if size == 1 else (" along", " across") for size in sizes]
    return [f"{one.law.name}{word}" for one, some in zip(touches, words, strict=True) for word in some]


def arguments(workspace: Workspace, names: Sequence[str], weighed: Sequence[str] = ()) -> tuple[Argument, ...]:
    """Return arguments in calling order: state, time where it is asked for, the free parameters if there are any.

    `weighed` is what the entries of `weights` stand for.
    """
    scene, state = workspace.scene, workspace.state
    symbols: dict[str, tuple[Expr, ...]] = {"q": state.q, "qd": state.qd, "qdd": state.qdd, "tau": state.tau}
    independent = workspace.loops.decisions.partition.independent if OF_INDEPENDENT & set(names) else ()
    if TIME in names:  # a graph without the symbol need not be searched for it
        symbols[TIME] = (workspace.graph.symbol(TIME),)
    units = SceneUnits(scene).coordinates
    speeds = SceneUnits(scene).velocities
    result = []
    for name in names:
        text, spelled = ARGUMENTS[name]
        if (found := _of_the_scene(workspace, name, text, weighed)) is not None:
            result.append(found)
            continue
        if name in ("dq_i", "dqd_i", "dqdd_i"):
            loops = workspace.loops
            among = (loops.position_level[1] if name == "dq_i" else loops.decisions.partition).independent
            told = runs([scene.velocities[k] for k in among])
            nodes, entries = direction(workspace.graph, name, len(among)), tuple(spelled[speeds[k]] for k in among)
            result.append(Argument(name, nodes, f"{text}: {told}", entries))
            continue
        kinds, nodes = units if name in ("q", TO) else ["s"] if name == TIME else speeds, symbols.get(name, ())
        if name in OF_INDEPENDENT:
            kinds = [speeds[k] for k in independent]
            text = f"{text}: {', '.join(str(node.value) for node in independent_symbols(workspace, name[-2:]))}"
        if name in ("qi", "ui"):
            nodes = independent_symbols(workspace, name)
        elif name in (REFERENCE, REFERENCE_RATE, MOMENTA, RIGHT, STEP, TO, *DIRECTIONS.values()):
            nodes = direction(workspace.graph, name, len(kinds))
        entries = tuple(spelled[kind] for kind in kinds)
        result.append(Argument(name, nodes, text, entries, name == TIME, conventions(scene, name)))
    free = scene.free_parameters
    if free:
        nodes = tuple(workspace.graph.symbol(parameter.name) for parameter in free)
        text = "free parameters: " + ", ".join(parameter.name for parameter in free)
        result.append(Argument("params", nodes, text, tuple(parameter.unit for parameter in free)))
    return tuple(result)


SYMBOL = Op.SYMBOL  # see `Op`

BINDING: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("params", ("params", "prepared")),
    ("q", ("q",)),
    ("q, qd", ("qd",)),
    ("all", ("qdd", "tau")),
)
"""Binding times from early to late, and the arguments that are known from then on."""


@dataclass(frozen=True)
class Counts:
    """Operations of one call; additions include subtractions, sincos counts distinct angles."""

    multiplications: int = 0
    additions: int = 0
    divisions: int = 0
    sincos: int = 0
    others: int = 0

    @classmethod
    def of(cls, function: Function) -> Counts:
        """Return the operations that one call of `function` takes, every shared subexpression computed once."""
        return sum(cls.by_binding(function).values(), cls())

    @staticmethod
    def by_binding(function: Function) -> dict[str, Counts]:
        """Return the operations of `function` by binding time, a key for every row of `BINDING`.

        Symbols are told by their names; one that is no argument counts as known last.
        """
        if function.loop and function.is_loop_alone:
            return {name: Counts.of_loop(function.loop) if name == BINDING[-1][0] else Counts() for name, _ in BINDING}
        known = {symbol.value: _time(argument.name) for argument in function.arguments for symbol in argument.symbols}
        times: dict[Expr, int] = {}  # -1 for what has no symbol below it
        tallies = [Counter[str]() for _ in BINDING]
        angles: set[Expr] = set()
        for node in reachable(function.entries):
            op = node.op
            if op is SYMBOL:
                times[node] = known.get(node.value, len(BINDING) - 1)
                continue
            time = -1
            for arg in node.args:
                time = max(time, times[arg])
            times[node] = time
            category = CATEGORY[op]
            if time >= 0 and category and not (category == "sincos" and node.args[0] in angles):
                tallies[time][category] += 1
                if category == "sincos":
                    angles.add(node.args[0])
        return {name: Counts(**tally) for (name, _), tally in zip(BINDING, tallies, strict=True)}

    @staticmethod
    def counts_alone(op: Op) -> bool:
        """Whether an operation costs something, and is not counted in pairs as sines are."""
        return CATEGORY[op] not in (FREE, "sincos")

    @classmethod
    def of_loop(cls, loop: TableLoop) -> Counts:
        """Return the operations of one call of a loop over a table; what several hand to one joint is added."""
        return cls(**count_loop(loop))

    @property
    def cost(self) -> int:
        """All operations in one number, by `COSTS`."""
        return sum(weight * int(getattr(self, name)) for name, weight in COSTS.items())

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(int(getattr(self, name)) + int(getattr(other, name)) for name in COSTS))

    def __sub__(self, other: Counts) -> Counts:
        return Counts(*(int(getattr(self, name)) - int(getattr(other, name)) for name in COSTS))

    def __str__(self) -> str:
        words = (
            f"{self.multiplications} mul",
            f"{self.additions} add",
            *(f"{number} {name}" for number, name in ((self.divisions, "div"), (self.sincos, "sincos")) if number),
            *(f"{self.others} other" for _ in range(bool(self.others))),
        )
        return ", ".join(words)


def _time(argument: str) -> int:
    """Return the binding time of an argument, a row of `BINDING`; the last one if it is in no row."""
    return next((k for k, (_, names) in enumerate(BINDING) if argument in names), len(BINDING) - 1)
