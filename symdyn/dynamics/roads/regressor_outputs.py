"""Regressors: driving forces, power and energies as a matrix times the parameters that they are linear in.

    τ = Y(q, q̇, q̈) π + r           r: what depends on none of the columns' parameters, zero in most scenes

    regressor          π: ten parameters of every body about its frame, m, m r, I; armatures, damping, dry friction,
                       stiffness and preload of springs, loads: by the names of `--symbolic all`, or of the scene's own
                       parameters where one stands there
    base_regressor     the fewest columns that span the same forces: base parameters of the moving bodies in the link
                       frames that the generator chose (`lean_tree`), by second moments J; equal columns are one

Parameters that forces are not linear in, such as a spring's free length, keep their values. Where two of them multiply
each other, the first is a column and the other one keeps its value.

Reference: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986); Khalil
and Dombre (2002), chapters 9 and 12; Gautier and Khalil (1990).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

from symdyn.dynamics.lagrange import second_kind as lagrange
from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.dynamics.recursive.lean_tree import LeanTree, potential_energy, slides_along_all_turns, split
from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.rnea import rnea
from symdyn.dynamics.roads import result_labels as labels
from symdyn.dynamics.roads.closed_outputs import drives_of, lagrange_drives_of
from symdyn.dynamics.roads.output import Output, Own, Road, Unasked, by_lagrange
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene import Joint, Scene
from symdyn.scene.symbolic import with_force_parameters
from symdyn.scene.ten_parameters import INERTIAL
from symdyn.scene.values.quantity import ZERO, express
from symdyn.spatial import Inertia, dot, symmetric, transpose, unit_transform, zero_vector

TURNING = ("mx", "my", "Jxx", "Jyy", "Jxy", "Jxz", "Jyz")
SLIDING = ("m", "mx", "my", "mz")
"""What a revolute and a prismatic joint feel of a body, see `lean_tree.split`."""

ALONG = ("m", "mz")
"""What a prismatic joint feels whose direction all turns before it have for their axis."""

ALL = ("m", "mx", "my", "mz", "Jxx", "Jyy", "Jzz", "Jxy", "Jxz", "Jyz")


@dataclass(frozen=True)
class Linear:
    """A scene whose linear parameters are symbols.

    Attributes:
        workspace: of that scene.
        columns: names of the parameters that are columns.
        known: what the other symbols stand for.
        declared: values of the columns' parameters as the scene declares them.
    """

    workspace: Workspace
    columns: tuple[str, ...]
    known: dict[Expr, Expr]
    declared: tuple[Expr, ...]

    def slopes(self, entries: Sequence[Expr]) -> list[list[Expr]]:
        """Return the derivatives of entries by the columns, a row an entry."""
        symbols = [self.workspace.graph.symbol(name) for name in self.columns]
        rows = [gradient(entry, symbols) for entry in entries]
        flat = iter(substitute([one for row in rows for one in row], self.known))
        return [[next(flat) for _ in symbols] for _ in rows]


def linear(w: Workspace) -> Linear:
    """Return the scene's linear parameters."""
    scene = w.scene
    opened = with_force_parameters(scene)
    there = Workspace(opened, w.closing)
    own = [p.name for p in scene.parameters if p.name in {q.name for q in opened.parameters}]
    added = [p for p in opened.parameters if p.name not in own]
    values = {p.name: express(p.value, there.graph) for p in added if p.value is not None}
    ten = {p.name for p in added if p.value is None}
    symbols = {name: there.graph.symbol(name) for name in (*(p.name for p in added), *own)}
    kept: list[str] = []
    for name, slopes in _slopes(_driving(there), symbols):
        met = {str(node.value) for node in reachable(slopes) if node in symbols.values()}
        if not met & {name, *kept} and (name in ten or any(not slope.is_zero for slope in slopes)):
            kept.append(name)  # all ten of a body, whether they are felt or not
    known = {symbols[name]: value for name, value in values.items() if name not in kept}
    declared = [entry for body in scene.bodies for entry in _declared(body_inertia(body, there.graph))]
    declared += [values.get(name, symbols[name]) for name in kept if name not in ten]
    return Linear(there, tuple(kept), known, tuple(declared))


def _declared(body: Inertia) -> tuple[Expr, ...]:
    """Return the ten of a body about its frame, in the order of `INERTIAL`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.I
    return (body.m, *body.h, xx, yy, zz, xy, xz, yz)


def parameters(w: Workspace) -> list[Expr]:
    """Return π, what the columns of the regressor are to be multiplied by, on the graph of the workspace."""
    found: Linear = w.once(linear)
    return substitute(found.declared, {}, w.graph)


def remainder(w: Workspace, of: Callable[[Workspace], Sequence[Expr]] | None = None) -> list[Expr]:
    """Return r, the driving forces where all of π is zero, shape (n,), N m or N; or what else is linear in π."""
    found: Linear = w.once(linear)
    nothing = {found.workspace.graph.symbol(name): found.workspace.graph.zero for name in found.columns}
    return substitute(substitute((of or _driving)(found.workspace), {**found.known, **nothing}), {}, w.graph)


def _slopes(forces: Sequence[Expr], symbols: dict[str, Expr]) -> list[tuple[str, list[Expr]]]:
    rows = [gradient(force, list(symbols.values())) for force in forces]
    return [(name, [row[k] for row in rows]) for k, name in enumerate(symbols)]


def _driving(w: Workspace) -> list[Expr]:
    return w.forces(list(w.state.qdd))


def _lagrange(w: Workspace) -> list[Expr]:
    return lagrange.driving_forces(w.energy)


def columns(w: Workspace) -> tuple[str, ...]:
    """Return a label for each parameter that is a column of the regressor."""
    found: Linear = w.once(linear)
    return found.columns


def _regressor(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> list[Expr]:
    """Return Y row by row, on the graph of the workspace."""
    found: Linear = w.once(linear)
    rows = found.slopes(forces(found.workspace))
    return substitute([one for row in rows for one in row], {}, w.graph)


# Base parameters


@dataclass(frozen=True)
class Base:
    """Base parameters of the moving bodies, each a symbol.

    Attributes:
        names: such as "mxR2" or "JxxR1", R1 the frame of the first moving body.
        symbols: of the parameters, in the same order.
        values: what they are made of, kg, kg m, kg m^2.
        tree: the link frames, bodies that have these parameters alone, without rotors.
    """

    names: tuple[str, ...]
    symbols: tuple[Expr, ...]
    values: tuple[Expr, ...]
    tree: LeanTree


def base(w: Workspace) -> Base:
    """Return the base parameters of a scene, felt or not; a ball and a free body keep all ten of theirs."""
    graph, zero, lean = w.graph, w.graph.zero, w.whole
    together = {k: block[-1] for block in lean.block if len(block) > 1 for k in block}
    names, symbols, values = list[str](), list[Expr](), list[Expr]()
    bodies = [Moments(zero, zero_vector(graph), symmetric(*(zero,) * 6))]
    along = () if together else tuple(k for k in lean.outward() if lean.slides[k] and slides_along_all_turns(lean, k))
    grouped = _given_on(lean, along) if along else lean.body
    for k in lean.outward():
        own = dict(zip(ALL, _ten(grouped[k]), strict=True))
        felt: tuple[str, ...] = ALONG if k in along else SLIDING if lean.slides[k] else TURNING
        if k in together:  # moves that act as one: only behind the last of them is there a frame that is a body's
            felt = ALL if k == together[k] else ()
        here = {word: graph.symbol(f"{word} of link frame {k}") for word in felt}
        names += [f"{word}R{k}" for word in felt]
        symbols += here.values()
        values += [own[word] for word in felt]
        m, x, y, z, xx, yy, zz, xy, xz, yz = (here.get(word, zero) for word in ALL)
        bodies.append(Moments(m, (x, y, z), symmetric(xx, yy, zz, xy, xz, yz)))
    still = (zero,) * len(lean.parent)
    tree = replace(lean, body=tuple(bodies), armature=still, balls=())
    return Base(tuple(names), tuple(symbols), tuple(values), tree)


def _given_on(lean: LeanTree, along: tuple[int, ...]) -> list[Moments]:
    """Return the bodies of a tree where slides along all turns give what lies beside them to what they slide on."""
    zero = lean.graph.zero
    bodies = list(lean.body)
    for k in lean.inward():
        given, p = split(bodies[k], lean.slides[k])[1], lean.parent[k]
        if k in along:
            x, y, _ = bodies[k].h
            given = replace(given, h=(x, y, zero))
        bodies[p] = bodies[p] + lean.link[k].at_rest(lean.slides[k]).moments_back(given)
    return bodies


def _ten(body: Moments) -> tuple[Expr, ...]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    return (body.m, *body.h, xx, yy, zz, xy, xz, yz)


@dataclass(frozen=True)
class Columns:
    """The columns of a base regressor: groups of equal ones.

    Attributes:
        names: of the columns, equal ones as a sum, such as "JxxR1 + JyyR1 + Ia1".
        groups: of each column, the places of those that are equal to it among base parameters and what is no inertia.
    """

    names: tuple[str, ...]
    groups: tuple[tuple[int, ...], ...]


def grouped(w: Workspace) -> Columns:
    """Return the columns that forces depend on, the first of equal ones in its place."""
    names, slopes = w.once(felt)
    groups: dict[tuple[Expr, ...], list[int]] = {}
    for k, column in enumerate(slopes):
        if any(not slope.is_zero for slope in column):
            groups.setdefault(tuple(column), []).append(k)
    told = tuple(" + ".join(names[k] for k in group) for group in groups.values())
    return Columns(told, tuple(tuple(group) for group in groups.values()))


def felt(w: Workspace) -> tuple[tuple[str, ...], list[list[Expr]]]:
    """Return names and columns of all base parameters, then of what is no inertia of a body; by recursion."""
    found: Base = w.once(base)
    forces = rnea(found.tree, w.state.qd, w.state.qdd)
    rows = [gradient(force, found.symbols) for force in forces]
    names, more = w.once(others)
    return (*found.names, *names), [*map(list, zip(*rows, strict=True)), *more]


def others(w: Workspace) -> tuple[tuple[str, ...], list[list[Expr]]]:
    """Return names and columns of the linear parameters that are no inertia of a body, by recursion."""
    return _beside(w, _driving)


def _beside(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> tuple[tuple[str, ...], list[list[Expr]]]:
    found: Linear = w.once(linear)
    ten = len(INERTIAL) * len(w.scene.bodies)
    rows = found.slopes(forces(found.workspace))
    columns = [substitute(column, {}, w.graph) for column in list(zip(*rows, strict=True))[ten:]]
    return found.columns[ten:], columns


def base_values(w: Workspace) -> list[Expr]:
    """Return β, what the columns of the base regressor are to be multiplied by: formulas of declared parameters."""
    found, own = w.once(grouped), w.once(base)
    every = [*own.values, *parameters(w)[len(INERTIAL) * len(w.scene.bodies) :]]
    return [w.graph.total(every[k] for k in group) for group in found.groups]


def base_columns(w: Workspace) -> tuple[str, ...]:
    """Return a label for each column of the base regressor."""
    found: Columns = w.once(grouped)
    return found.names


def base_by_lagrange(w: Workspace) -> list[list[Expr]]:
    """Return all columns from K = 1/2 tr(dT/dt S dT/dt^T) and P = -g.S of every link frame T, S the moments."""
    found: Base = w.once(base)
    K, P = w.graph.zero, w.graph.zero
    placed = [unit_transform(w.graph)]
    for k in found.tree.outward():
        placed.append(placed[found.tree.parent[k]] @ found.tree.link[k].transform)
        body, T = found.tree.body[k], placed[k]
        columns = [*transpose(T.R), T.p]
        rates = [tangents(column, w.state.velocity) for column in columns]
        S = [[*body.J[i], body.h[i]] for i in range(3)] + [[*body.h, body.m]]
        for i, j in product(range(4), repeat=2):
            K = K + S[i][j] * w.graph.total(x * y for x, y in zip(rates[i], rates[j], strict=True)) / 2
        P = P - w.graph.total(S[3][j] * dot(found.tree.gravity, columns[j]) for j in range(4))
    energy = replace(w.energy, K=K, G=P, E=w.graph.zero, scene=replace(w.scene, elements=(), joints=_bare(w.scene)))
    rows = [gradient(force, found.symbols) for force in lagrange.driving_forces(energy)]
    return [*map(list, zip(*rows, strict=True)), *_beside(w, _lagrange)[1]]


def _bare(scene: Scene) -> tuple[Joint, ...]:
    """Return the joints without damping and friction."""
    return tuple(replace(joint, damping=ZERO, dry=None) for joint in scene.joints)


def chosen(w: Workspace, slopes: Sequence[Sequence[Expr]]) -> list[Expr]:
    """Return the first column of each group, row by row."""
    found: Columns = w.once(grouped)
    return [slopes[group[0]][i] for i in range(w.state.n) for group in found.groups]


def linear_parameters(scene: Scene, output: str = "regressor") -> tuple[tuple[str, Expr], ...]:
    """Return name and value of what the columns of a regressor are to be multiplied by, formulas of the scene's names.

    Args:
        scene: the mechanism.
        output: "regressor", or "base_regressor" for that of the fewest columns; kg, kg m, kg m^2 and the units of what
            acts.

    Raises:
        DerivationError: `output` is neither.
    """
    known = {"regressor": (columns, parameters), "base_regressor": (base_columns, base_values)}
    if output not in known:
        raise DerivationError(f"{output} has no parameters of its own; give {' or '.join(known)}")
    w = Workspace(scene)
    names, values = known[output]
    return tuple(zip(names(w), values(w), strict=True))


# Where loops close: what each column takes from the drives


def _driven(w: Workspace, entries: Sequence[Expr], drives: Callable[[Workspace, list[Expr]], list[Expr]]) -> list[Expr]:
    """Return a regressor of the spanning tree as that of the drives, row by row."""
    count = len(entries) // w.state.n
    found = [drives(w, [entries[i * count + k] for i in range(w.state.n)]) for k in range(count)]
    return [column[i] for i in range(w.state.n) for column in found]


def _in_loops(recursive: Callable[[Workspace], list[Expr]], differentiated: Callable[[Workspace], list[Expr]]) -> Own:
    """Return the row of scenes with loops, for the roads to the regressor of a tree."""
    return Own(
        {
            "rnea": Road(lambda w: _driven(w, recursive(w), drives_of)),
            "lagrange": by_lagrange(lambda w: _driven(w, differentiated(w), lagrange_drives_of)),
        }
    )


# Energies and power


def _energies(w: Workspace, of: Callable[[Workspace], tuple[Expr, Expr]]) -> list[Expr]:
    """Return the slopes of K, then those of P, by the columns of the regressor."""
    found: Linear = w.once(linear)
    return substitute([one for row in found.slopes(of(found.workspace)) for one in row], {}, w.graph)


def energies_by_momentum(w: Workspace) -> tuple[Expr, Expr]:
    """Return K and P by recursion, J."""
    K = w.graph.total(p * u for p, u in zip(w.momentum, w.state.qd, strict=True)) / 2
    return K, potential_energy(w.lean) + w.elastic.energy


def _power(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> list[Expr]:
    """Return q̇ᵀ Y."""
    rows, count = _regressor(w, forces), len(columns(w))
    return [w.graph.total(u * rows[i * count + k] for i, u in enumerate(w.state.qd)) for k in range(count)]


# Rows of the table


def _whole(w: Workspace) -> list[Expr]:
    return _regressor(w, _driving)


def _whole_by_lagrange(w: Workspace) -> list[Expr]:
    return _regressor(w, _lagrange)


def _fewest(w: Workspace) -> list[Expr]:
    return chosen(w, w.once(felt)[1])


def _fewest_by_lagrange(w: Workspace) -> list[Expr]:
    return chosen(w, base_by_lagrange(w))


_row = partial(Output, unasked=Unasked.NEVER)
_PER_UNIT = "N m or N, per unit of the parameter"

REGRESSORS: dict[str, Output] = {
    "regressor": _row(
        "regressor Y(q, qd, qdd) of the driving forces tau = Y pi, pi the parameters that they are linear in",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, columns),
        _PER_UNIT,
        in_loops="own",
        roads={"rnea": Road(_whole), "lagrange": by_lagrange(_whole_by_lagrange)},
        own=_in_loops(_whole, _whole_by_lagrange),
        lacks="told",
        depends=("independent",),
    ),
    "base_regressor": _row(
        "base regressor Y(q, qd, qdd) of the driving forces tau = Y beta, beta the base parameters",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, base_columns),
        _PER_UNIT,
        in_loops="own",
        roads={"rnea": Road(_fewest), "lagrange": by_lagrange(_fewest_by_lagrange)},
        own=_in_loops(_fewest, _fewest_by_lagrange),
        lacks="told",
        depends=("independent",),
    ),
    "energy_regressor": _row(
        "regressor Y(q, qd) of the energies [K; P] = Y pi, pi the parameters of the regressor",
        ("q", "qd"),
        "Y",
        (labels.fixed("kinetic", "potential"), columns),
        "J, per unit of the parameter",
        in_loops="same",
        roads={
            "recursive": Road(lambda w: _energies(w, energies_by_momentum)),
            "lagrange": Road(lambda w: _energies(w, lambda there: (there.energy.K, there.energy.P))),
        },
    ),
    "power_regressor": _row(
        "regressor y(q, qd, qdd) of the power of the driving forces qd.tau = y.pi, pi the parameters of the regressor",
        ("q", "qd", "qdd"),
        "y",
        (columns,),
        "W, per unit of the parameter",
        in_loops="tree",
        roads={
            "rnea": Road(lambda w: _power(w, _driving)),
            "lagrange": by_lagrange(lambda w: _power(w, _lagrange)),
        },
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""
