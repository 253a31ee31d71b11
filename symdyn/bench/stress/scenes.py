"""The built-in scenes of the hard cases, as files say them, and what cases are measured with.

That is every implementation of a function at given states, and the truth at 50 digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

import numpy as np
from flint import arb_mat

from symdyn.algebra import Array, Balls, Floats
from symdyn.bench.reference import Reference, column, norm, reference
from symdyn.dynamics import Equations, Function, Requested, Workspace, derive_one, row_of
from symdyn.emit import emit
from symdyn.errors import MissingCompiler
from symdyn.frozen import dataclass, replace
from symdyn.graph import evaluate
from symdyn.program import Program, choose, identifier, lower
from symdyn.runtime import RUNNERS, build
from symdyn.scene import Quantity, Scene, read_text
from symdyn.scene.values import Body

DOWN = "gravity = [0, -9.81, 0]"

ROUND = 'type = "revolute"'

SLIDE = 'type = "prismatic", parent = "ground", child = "b", axis = [1, 0, 0], coordinate = "x"'


def two_link(first: Fraction | int = 1, second: Fraction | int = 1) -> Scene:
    """Return two point masses on massless links of 1 m; angles from the downward vertical and from link 1."""
    return read_text(f"""
        name = "two_link"
        {DOWN}
        bodies.b1.particles = [{{ mass = "{first}", at = [0, -1, 0] }}]
        bodies.b2.particles = [{{ mass = "{second}", at = [0, -1, 0] }}]
        joints.j1 = {{ {ROUND}, parent = "ground", child = "b1" }}
        joints.j2 = {{ {ROUND}, parent = "b1", child = "b2", origin = [0, -1, 0] }}
        points.tool = {{ body = "b2", at = [0, -1, 0] }}
    """)


def chain(n: int, absolute: bool = False) -> Scene:
    """Return n unit point masses on links of 1 m, with angles relative to the link before or to the vertical.

    An absolute angle is a joint that takes the angle before it back, then one that turns by its own.
    """
    lines = [f'name = "chain{n}{"_absolute" if absolute else ""}"', DOWN]
    for k in range(1, n + 1):
        parent, origin = ("ground", 0) if k == 1 else (f"b{k - 1}", -1)
        if absolute and k > 1:
            back = f'mimic = {{ joint = "j{k - 1}", ratio = -1 }}'
            lines += [
                f"bodies.a{k} = {{}}",
                f'joints.back{k} = {{ {ROUND}, parent = "{parent}", child = "a{k}", origin = [0, -1, 0], {back} }}',
            ]
            parent, origin = f"a{k}", 0
        lines += [
            f"bodies.b{k}.particles = [{{ mass = 1, at = [0, -1, 0] }}]",
            f'joints.j{k} = {{ {ROUND}, parent = "{parent}", child = "b{k}", origin = [0, {origin}, 0] }}',
        ]
    return read_text("\n".join(lines))


def gimbal() -> Scene:
    """Return a rigid body with inertia diag(1, 2, 3) on three massless gimbals z, y, x, free of gravity."""
    return read_text(f"""
        name = "gimbal"
        bodies.outer = {{}}
        bodies.inner = {{}}
        bodies.top = {{ mass = 1, inertia = [1, 2, 3], inertia_about = "com" }}
        joints.yaw = {{ {ROUND}, parent = "ground", child = "outer", axis = [0, 0, 1], coordinate = "psi" }}
        joints.pitch = {{ {ROUND}, parent = "outer", child = "inner", axis = [0, 1, 0], coordinate = "theta" }}
        joints.roll = {{ {ROUND}, parent = "inner", child = "top", axis = [1, 0, 0], coordinate = "phi" }}
    """)


def arm(n: int = 6) -> Scene:
    """Return an arm of n links of full inertia, each axis across the one before it."""
    axes = ([0, 0, 1], [0, 1, 0], [1, 0, 0])
    tensor = "inertia = { xx = 0.03, yy = 0.04, zz = 0.02, xy = 0.002, xz = -0.003, yz = 0.001 }"
    solid = f'com = [0.1, -0.02, 0.05], {tensor}, inertia_about = "com"'
    lines = ['name = "arm"']
    for k in range(1, n + 1):
        placed = f"axis = {axes[k % 3]}, origin = [{0.3 if k > 1 else 0}, 0, 0.2]"
        parent = f"b{k - 1}" if k > 1 else "ground"
        lines += [
            f"bodies.b{k} = {{ mass = {n + 1 - k}, {solid} }}",
            f'joints.j{k} = {{ {ROUND}, parent = "{parent}", child = "b{k}", {placed} }}',
        ]
    return read_text("\n".join(lines))


def heavier(one: Scene, factors: Sequence[Fraction | int]) -> Scene:
    """Return a scene whose bodies are so many times as heavy, density by density."""

    def scaled(part: Body, factor: Quantity) -> Body:
        particles = tuple(replace(p, mass=p.mass * factor) for p in part.particles)
        inertia = None if part.inertia is None else tuple(x * factor for x in part.inertia)
        return replace(part, mass=part.mass * factor, inertia=inertia, particles=particles)  # type: ignore[arg-type]

    return replace(one, bodies=tuple(scaled(b, Quantity.number(f)) for b, f in zip(one.bodies, factors, strict=True)))


def one_body(kind: str = "revolute") -> Scene:
    """Return a pendulum, or a mass on a slide."""
    return read_text(f"""
        name = "one_body"
        {DOWN}
        bodies.b = {{ mass = 1, com = [0, -1, 0], inertia = [0.1, 0.1, 0.1], inertia_about = "com" }}
        joints.j = {{ type = "{kind}", parent = "ground", child = "b" }}
    """)


def offset_pendulum() -> Scene:
    """Return a pendulum of 1 m hung so that its point stands in the origin at rest: its height is 1 - cos q."""
    return read_text(f"""
        name = "offset_pendulum"
        {DOWN}
        bodies.b.particles = [{{ mass = 1, at = [0, -1, 0] }}]
        joints.j = {{ {ROUND}, parent = "ground", child = "b", origin = [0, 1, 0] }}
        points.bob = {{ body = "b", at = [0, -1, 0] }}
    """)


def pinned() -> Scene:
    """Return a point mass on a massless link of 1 m, free in its plane and held by a pin: a pendulum as a loop."""
    return read_text(f"""
        name = "pinned"
        {DOWN}
        loop = [{{ name = "pin", {ROUND}, parent = "ground", child = "b", tip = [1, 0, 0] }}]
        bodies.b.particles = [{{ mass = 1, at = [0, 0, 0] }}]
        [joints.j]
        type = "planar"
        parent = "ground"
        child = "b"
        coordinates = ["x", "y", "phi"]
        start = [1, 0, 0]
        drive = false
    """)


def heavy_top() -> Scene:
    """Return the heavy top of Geradin and Cardona: m = 15, J = diag(15/64, 15/32, 15/64), 1 m from the fixed point."""
    return read_text("""
        name = "heavy_top"
        bodies.top = { mass = 15, com = [0, 1, 0], inertia = ["15/64", "15/32", "15/64"], inertia_about = "com" }
        joints.ball = { type = "spherical", parent = "ground", child = "top", start_rates = [0, 150, -4.61538] }
    """)


def free_top() -> Scene:
    """Return a top of inertia diag(1, 2, 3) that spins about its middle axis, without gravity."""
    return read_text("""
        name = "free_top"
        bodies.top = { mass = 1, inertia = [1, 2, 3], inertia_about = "com" }
        joints.ball = { type = "spherical", parent = "ground", child = "top", start_rates = [0.001, 10, 0.001] }
    """)


def stiff_spring(stiffness: int, damping: int) -> Scene:
    """Return a mass of 1 kg on a slide with a spring and a damper, one metre out."""
    return read_text(f"""
        name = "stiff_spring"
        bodies.b.mass = 1
        joints.j = {{ {SLIDE}, start = 1 }}
        springs.s = {{ joint = "j", stiffness = {stiffness} }}
        dampers.d = {{ joint = "j", damping = {damping} }}
    """)


def rubbing() -> Scene:
    """Return a mass of 1 kg on a slide with Stribeck's friction, a spring and a damper, half a metre out."""
    friction = "{ coulomb = 1, static = 1.5, stribeck = 0.05, smoothing = 0.001 }"
    return read_text(f"""
        name = "rubbing"
        bodies.b.mass = 1
        joints.j = {{ {SLIDE}, start = 0.5, friction = {friction} }}
        springs.s = {{ joint = "j", stiffness = 50 }}
        dampers.d = {{ joint = "j", damping = 0.4 }}
    """)


def parallelogram(second: bool = False) -> Scene:
    """Return a parallelogram of unit rods, which meets its change point; with a second coupler loops are redundant.

    Two couplers of equal length between the same rods say one thing twice.
    """
    rod = 'mass = 1, com = [0.5, 0, 0], inertia = [0, "1/12", "1/12"], inertia_about = "com"'
    up = f'{ROUND}, drive = false, start = "pi/2", start_rates = -1'
    level = f'{ROUND}, drive = false, start = "-pi/2", start_rates = 1'
    closed = f'{ROUND}, child = "c", origin = [1, 0, 0]'
    lines = [
        f'name = "parallelogram"\n{DOWN}',
        *(f"bodies.{name} = {{ {rod} }}" for name in ("abcd" if second else "abc")),
        f'joints.j1 = {{ {up}, parent = "ground", child = "a" }}',
        f'joints.j2 = {{ {level}, parent = "a", child = "b", origin = [1, 0, 0] }}',
        f'joints.j3 = {{ {up}, parent = "ground", child = "c", origin = [1, 0, 0] }}',
    ]
    rings = [f'{{ name = "ring", parent = "b", {closed}, tip = [-1, 0, 0] }}']
    if second:
        lines += [f'joints.j4 = {{ {level}, parent = "a", child = "d", origin = [0.5, 0, 0] }}']
        rings += [f'{{ name = "ring2", parent = "d", {closed}, tip = [-0.5, 0, 0] }}']
    return read_text("\n".join([*lines, f"loop = [{', '.join(rings)}]"]))


SINGULAR_BITS = 600
"""Bits of the reference where a mass matrix is inverted: condition numbers reach 1e30."""


@dataclass(frozen=True)
class Calls:
    """A scene's functions, ready to be measured."""

    program: Program  # of them
    others: Program  # functions without code
    modules: Mapping[str, Any]  # NumPy module and compiled C by name; the second is missing where there is no compiler

    def function(self, name: str) -> Function:
        """Return the function of an output, with code or without; where loops close, its own name may be another."""
        return next(program[name] for program in (self.program, self.others) if name in program).function

    def results(self, name: str, states: Mapping[str, Array]) -> dict[str, Array]:
        """Return the results of every implementation at states, a row a state; shapes (N, size)."""
        function = self.function(name)
        legal = identifier(function.name)
        given = [states[a.name][..., 0] if a.scalar else states[a.name] for a in function.arguments]
        count = max(
            (len(x) for x, a in zip(given, function.arguments, strict=True) if x.ndim > len(a.shape)), default=1
        )
        found = {}
        with np.errstate(all="ignore"):
            for way, module in self.modules.items():
                call = getattr(module, legal)
                found[f"{way}, many states"] = np.asarray(call(*given), float).reshape(count, -1)
                rows = [call(*(x[k] for x in given)) for k in range(count)]
                found[f"{way}, one state"] = np.asarray(rows, float).reshape(count, -1)
        return found

    def truth(self, name: str, states: Mapping[str, Array]) -> Reference:
        """Return exact results with running error bounds."""
        count = max(len(value) for value in states.values())
        return reference(self.function(name), states, count)


def looked_at(scene: Scene) -> tuple[str, ...]:
    """Return the outputs that a first look at a scene shows, as far as it has them."""
    there, _ = Requested.of(Workspace(scene)).available()
    return tuple(name for name in there if row_of(name)[0].default_in == "overview")


class Interpreted:
    """A program's functions by name, run operation by operation in doubles: for those too long to be compiled."""

    def __init__(self, program: Program) -> None:
        self.functions = {routine.function.name: routine.function for routine in program.routines}

    def __getattr__(self, name: str) -> Callable[..., Array]:
        """Return a function by name, of one state or of many."""
        if name.startswith("_") or name not in self.functions:
            raise AttributeError(name)
        function = self.functions[name]

        def call(*given: Array) -> Array:
            if given[0].ndim > len(function.arguments[0].shape):
                return np.array([call(*one) for one in zip(*given, strict=True)])
            return np.array(evaluate(function.entries, Floats(), function.values(given))).reshape(function.shape)

        return call


def calls(
    scene: Scene,
    outputs: Sequence[str],
    real: str = "double",
    formulation: str | None = None,
    beside: Sequence[str] = (),
    compiled: bool = True,
) -> Calls:
    """Return functions of a scene in NumPy and in C with batch code.

    Of outputs `beside` them true values are needed and no code. What is not `compiled` is run operation by operation
    in place of both. A formulation of None is the one that is preferred.
    """
    w = Workspace(scene)
    functions = (
        choose(w, outputs) if formulation is None else tuple(derive_one(w, name, formulation) for name in outputs)
    )
    program = lower(Equations(scene, w.graph, functions))
    others = lower(Equations(scene, w.graph, tuple(derive_one(w, name) for name in beside)), passes=())
    if not compiled:
        return Calls(program, others, {"program": Interpreted(program)})
    modules: dict[str, Any] = {"NumPy": RUNNERS["numpy"].run(emit(program, real=real))}
    with suppress(MissingCompiler):
        modules["C"] = build(program, real=real)
    return Calls(program, others, modules)


@dataclass(frozen=True)
class Solved:
    """How well M qdd = tau - h was solved, infinity norms."""

    forward: float  # |qdd - true| / (n eps |M^-1| (|M||qdd| + |h| + |tau|))
    backward: float  # |M qdd + h - tau| / (eps (|M||qdd| + |h| + |tau|))
    where: str  # implementation and state


EPSILON = 2.0**-52


def solved(made: Calls, states: Mapping[str, Array]) -> list[Solved]:
    """Return how well every implementation of forward dynamics solves at every state where M and h are finite.

    Args:
        made: has forward_dynamics, mass_matrix and inverse_dynamics.
        states: q, qd, tau of shapes (N, n), and params if there are free ones.
    """
    n, count = states["tau"].shape[1], len(states["q"])
    at_rest = {**states, "qdd": np.zeros((count, n))}
    name = "forward_dynamics"
    M, h, exact = (_exact(made.function(one), at_rest, count) for one in (*row_of(name)[0].solves, name))
    results = made.results(name, states)
    found = []
    with Balls(SINGULAR_BITS) as algebra:
        for k in range(count):
            if not all(ball.is_finite() for ball in (*M[k], *h[k])):
                continue  # there is nothing to solve
            matrix, force = arb_mat(n, n, M[k]), arb_mat(n, 1, h[k])
            inverse = norm(matrix.inv())
            tau = column(states["tau"][k], algebra)
            for way, values in results.items():
                if not np.isfinite(values[k]).all():
                    found.append(Solved(np.inf, np.inf, f"{way}, state {k}"))
                    continue
                qdd = column(values[k], algebra)
                size = EPSILON * (norm(matrix) * norm(qdd) + norm(force) + norm(tau) or 1.0)
                error, residual = norm(qdd - arb_mat(n, 1, exact[k])), norm(matrix * qdd + force - tau)
                found.append(Solved(error / (n * inverse * size), residual / size, f"{way}, state {k}"))
    return found


def _exact(function: Function, states: Mapping[str, Array], count: int) -> list[list[Any]]:
    found = []
    with Balls(SINGULAR_BITS) as algebra:
        for k in range(count):
            given = [states[argument.name][k] for argument in function.arguments]
            found.append(evaluate(function.entries, algebra, function.values(given, algebra.number)))
    return found
