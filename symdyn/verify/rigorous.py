"""Guaranteed bounds of the error of generated code at given states: the equations over ball arithmetic.

    |computed - true|  ≤  |computed - midpoint| + radius

for the number that the code returned, taken exactly, and a ball that holds the true value of the equations at the very
doubles that the code was given. The equations are those of the scene, before any pass: whatever rounding, a pass or a
compiler did to the result is in the bound. Balls are computed with twice as many bits until their radii no longer
matter. Where an equation has no real value, such as the root of a negative number, there is nothing to be near to.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from flint import arb

from symdyn.algebra import Balls, BigFloats
from symdyn.dynamics import Equations, Function, LoopChoices, Workspace
from symdyn.emit.code import REALS
from symdyn.errors import VerifyError, suggestion
from symdyn.frozen import asdict, dataclass
from symdyn.graph import Expr, evaluate
from symdyn.program import Sampling, lower
from symdyn.rounding import finite
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits, scene_of
from symdyn.scene.joints import start_of
from symdyn.scene.values import Faults
from symdyn.shown import Shown
from symdyn.simulation.prescribed import read_number
from symdyn.verdict import Claims, Judged, Unclaimed, Verdict
from symdyn.verify.accuracy import Array
from symdyn.verify.building import modules_of, requested_targets
from symdyn.verify.claims import taken
from symdyn.verify.natural_positions import lost_rank

MOST_BITS = 4096
ENOUGH = 2.0**-20  # of an ulp of the largest entry: radii below this are not made smaller

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Bound:
    """How far one entry of one function may be off, at any of the states.

    Attributes:
        function: its name.
        index: of the entry in the result, () for a scalar.
        module: its target, a key of `TARGETS`.
        computed: what the code returned at the state with the largest error.
        error: no computed value of this entry is farther than this from the true one; infinite where nothing is known.
        ulps: `error` in units in the last place of `computed`.
        state: which state that was, counted from 0.
        verdict: one of `symdyn.verdict`: PROVED where the error is bounded at all states, NOT_SHOWN where the equations
            have no value at one, DIFFERENT where they have, and the code has not.
    """

    function: str
    index: tuple[int, ...]
    module: str
    computed: float
    error: float
    ulps: float
    state: int
    verdict: str


@dataclass(frozen=True)
class Rigorous(Shown, Claims):
    """Guaranteed bounds of a scene's functions.

    Attributes:
        scene: its name.
        real: "double" or "float", of the code.
        states: the values of all arguments by function, exact doubles, one dict a state.
        bounds: a row for every function, entry and module.
        bits: the most that any ball took.
        notes: what was left out and why.
        absent: what does not exist there, of which nothing is claimed.
        not_run: what this machine cannot run.
    """

    scene: str
    real: str
    states: Mapping[str, tuple[Mapping[str, Any], ...]]
    bounds: tuple[Bound, ...]
    bits: int
    notes: tuple[str, ...]
    absent: tuple[Unclaimed, ...] = ()
    not_run: tuple[Unclaimed, ...] = ()

    @property
    def claims(self) -> tuple[Judged, ...]:
        """What was claimed, and what became of it: a claim a function and module."""
        entries: dict[tuple[str, str], list[str]] = {}
        for one in self.bounds:
            entries.setdefault((one.function, one.module), []).append(one.verdict)
        worst = {f"error of {function} in {name}": Verdict.worst(some) for (function, name), some in entries.items()}
        return tuple(Judged(what, said, _WHY.get(said, "")) for what, said in worst.items())

    def as_dict(self) -> dict[str, Any]:
        facts: dict[str, Any] = finite(asdict(self) | self._verdicts())
        return facts


_WHY = {
    Verdict.NOT_SHOWN: "the equations have no value at one of the states",
    Verdict.DIFFERENT: "the equations have a value there, and the code returns none",
}


def rigorous(
    scene: SceneLike,
    outputs: Sequence[str] | None = None,
    at: Mapping[str, float | str] | None = None,
    states: int = 4,
    seed: int = 1,
    real: str = "double",
    formulation: str | None = None,
    progress: Progress = lambda _: None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Rigorous:
    """Return guaranteed bounds of the error of a scene's generated code.

    Args:
        scene: the mechanism.
        outputs: as for `certify`.
        at: values of coordinates, velocities ("q1_dot"), accelerations ("q1_ddot"), driving forces by the names of the
            drives, t and free parameters; what is not named is as the scene starts, free parameters are one. None
            samples states.
        states: how many states are sampled for every function.
        seed: of the states.
        real: "double" or "float".
        formulation: as for `certify`.
        progress: called with what is being done.
        closing: as for `certify`.

    Raises:
        DerivationError: an output that was asked for does not exist, or no output has the formulation.
        VerifyError: a name in `at` that is no argument.
    """
    scene = scene_of(scene)
    workspace = Workspace(scene, closing)
    progress("deriving")
    _, functions, notes, absent = taken(workspace, outputs, formulation)
    absent += [Unclaimed(one.name, "it has no entries") for one in functions if not one.entries]
    equations = Equations(scene, workspace.graph, functions)
    program = lower(equations)
    given = None if at is None else _given(scene, workspace, at, real)
    progress("building")
    made = modules_of(program, real, requested_targets(None, real))
    if made.refused:
        raise VerifyError(f"{scene.name}: the code was refused: {made.refused}")
    progress("bounding")
    parameters = {p.name: p.value.express(workspace.graph) for p in scene.parameters if p.value is not None}
    bounds: list[Bound] = []
    tried: dict[str, tuple[Mapping[str, Any], ...]] = {}
    bits = Balls().bits
    for function, routine in zip(equations.functions, program.routines, strict=True):
        if not function.entries:
            continue
        rng = random.Random(f"{seed}:{function.name}")
        if given is None:
            points = [Sampling(routine.function.arguments, rng, real).state() for _ in range(states)]
        else:
            points = [
                [np.array([given[str(x.value)] for x in one.symbols]).reshape(one.shape) for one in function.arguments]
            ]
        balls = []
        for point in points:
            held, used = _balls(function, point, parameters, real)
            balls.append(held)
            bits = max(bits, used)
        if given is not None and not all(ball.is_finite() for ball in balls[0]):
            q = np.array([given[str(node.value)] for node in workspace.state.q])
            if why := lost_rank(workspace, q):
                absent.append(Unclaimed(f"{function.name} at this state", why))
                continue
        bounds += _bounds(function, points, balls, made.built, real)
        names = [argument.name for argument in function.arguments]
        tried[function.name] = tuple(dict(zip(names, (x.tolist() for x in point), strict=True)) for point in points)
    return Rigorous(scene.name, real, tried, tuple(bounds), bits, tuple(notes), tuple(absent), made.missing)


def _given(scene: Scene, workspace: Workspace, at: Mapping[str, float | str], real: str) -> dict[str, float]:
    """Return the value of every symbol that may be an argument; VerifyError of a name that is none, or no value."""
    state = workspace.state
    known: dict[str, str] = {str(node.value): str(node.value) for node in (*state.q, *state.qd, *state.qdd)}
    known |= {drive: str(node.value) for drive, node in zip(scene.drives, state.tau, strict=True) if drive}
    known |= {str(node.value): str(node.value) for node in state.tau}
    known |= {name: name for name in ("t", *(p.name for p in scene.given), *(p.name for p in scene.free_parameters))}
    wrong = [name for name in at if name not in known]
    if wrong:
        lines = [f"{scene.name}: {name} is no argument; {suggestion(name, known)}" for name in wrong]
        raise VerifyError("\n".join(lines))
    values = dict.fromkeys(known.values(), 0.0)
    values |= {p.name: 1.0 for p in scene.free_parameters}
    values |= {p.name: _number(p.value, workspace) for p in scene.given}
    for nodes, quantities in ((state.q, start_of(scene).position), (state.qd, start_of(scene).velocity)):
        values |= {str(n.value): _number(x, workspace) for n, x in zip(nodes, quantities, strict=True)}
    faults, letter = Faults(""), SceneUnits(scene).letter
    values |= {known[name]: read_number(x, {}, f"at: {name}", faults, letter(name)) or 0.0 for name, x in at.items()}
    faults.close(lambda lines: VerifyError("\n".join(lines)))
    return {name: float(np.float32(value)) for name, value in values.items()} if real == "float" else values


def _number(quantity: Quantity, workspace: Workspace) -> float:
    """Return the double nearest to a number of the scene; 0 where it depends on a free parameter."""
    try:
        return float(evaluate([quantity.express(workspace.graph)], BigFloats(), {})[0])
    except KeyError:
        return 0.0


def _balls(
    function: Function, point: Sequence[Array], parameters: Mapping[str, Expr], real: str
) -> tuple[list[Any], int]:
    """Return a ball for every entry at a state, small beside an ulp of the largest entry, and the bits that it took."""
    bits, kind = Balls().bits, REALS[real]
    while True:
        algebra = Balls(bits)
        with algebra:
            values = function.values(point, algebra.number)
            graph = function.entries[0].graph
            values |= {graph.symbol(name): evaluate([node], algebra, {})[0] for name, node in parameters.items()}
            held = evaluate(function.entries, algebra, values)
            largest = max((float(ball.abs_upper()) for ball in held if ball.is_finite()), default=0.0)
            wanted = max(ENOUGH * kind.roundoff * largest, kind.tiniest * kind.roundoff)
            if bits >= MOST_BITS or all(ball.is_finite() and float(ball.rad()) <= wanted for ball in held):
                return held, bits
        bits *= 2


def _bounds(
    function: Function, points: Sequence[Sequence[Array]], balls: Sequence[Any], modules: Mapping[str, Any], real: str
) -> list[Bound]:
    """Return a row for every entry and module: the largest bound of all states."""
    rows = []
    for name, module in modules.items():
        if not hasattr(module, function.name):
            continue
        with np.errstate(all="ignore"):
            results = [np.ravel(getattr(module, function.name)(*point)).tolist() for point in points]
        for place, index in enumerate(np.ndindex(*function.shape)):
            errors = [distance(result[place], held[place]) for result, held in zip(results, balls, strict=True)]
            state = max(range(len(errors)), key=errors.__getitem__)
            computed, error = results[state][place], errors[state]
            ulp = float(np.spacing(np.abs(np.array(computed, REALS[real].dtype)))) if math.isfinite(error) else 1.0
            known = [ball[place].is_finite() for ball in balls]
            lost = any(there and not math.isfinite(r[place]) for there, r in zip(known, results, strict=True))
            said = Verdict.of(all(known), lost, proved=True)
            rows.append(Bound(function.name, index, name, computed, error, error / ulp, state, said))
    return rows


def distance(computed: float, ball: Any) -> float:
    """Return a double that is not less than |computed - true| for any true value in the ball; infinite if it is not.

    This is |computed - midpoint| + radius, each step rounded up.
    """
    if not (math.isfinite(computed) and ball.is_finite()):
        return math.inf
    bound = (arb(computed) - ball).abs_upper()
    nearest = float(bound)
    return nearest if arb(nearest) >= bound else math.nextafter(nearest, math.inf)
