"""The fewest columns that span the driving forces of a tree: base parameters of link frames, and what is no inertia.

By second moments J, in the frames that the generator chose (`reduced_tree`); equal columns are one. A ball and a free
body keep all ten.

Reference: Gautier and Khalil, Direct calculation of minimum set of inertial parameters of serial robots (1990); Khalil
and Dombre (2002), chapters 9 and 12.

The parameters that a scene's driving forces are linear in, as symbols: what columns of regressors stand for.

    τ = Y(q, q̇, q̈) π + r           r: what depends on none of π

Parameters that forces are not linear in, such as a length, keep their values. Where two of them multiply each other,
one is a column and the other one keeps its value: of a spring the stiffness and not the free length, as without the
stiffness nothing is left of either; else the first.

Reference: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.links import Moments, six
from symdyn.dynamics.recursive.reduced_tree import ReducedTree, slides_along_all_turns, split
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene import INERTIAL, Quantity, with_force_parameters
from symdyn.scene.forces import FORCES
from symdyn.spatial import Mat, Transform, dot, zero_vector


@dataclass(frozen=True)
class Linear:
    """A scene whose linear parameters are symbols."""

    workspace: Workspace  # of that scene
    columns: tuple[str, ...]  # names of the parameters that are columns
    known: dict[Expr, Expr]  # what the other symbols stand for
    declared: tuple[Expr, ...]  # values of the columns' parameters as the scene declares them
    requesting: Workspace  # the workspace whose scene it is, with values

    @classmethod
    def of(cls, w: Workspace) -> Linear:
        """Return the linear parameters of a workspace's scene, found once."""
        return w.once(linear)

    def parameters(self) -> list[Expr]:
        """Return π, what the columns of the regressor are to be multiplied by, on the graph that was asked."""
        return substitute(self.declared, {}, self.requesting.graph)

    def named(self) -> tuple[tuple[str, Expr], ...]:
        return tuple(zip(self.columns, self.parameters(), strict=True))

    def remainder(self, of: Callable[[Workspace], Sequence[Expr]] | None = None) -> list[Expr]:
        """Return r, the driving forces where all of π is zero, shape (n,), N m or N; or what else is linear in π."""
        there = self.workspace
        nothing = {there.graph.symbol(name): there.graph.zero for name in self.columns}
        return substitute(substitute((of or driving)(there), {**self.known, **nothing}), {}, self.requesting.graph)

    def slopes(self, entries: Sequence[Expr]) -> list[list[Expr]]:
        """Return the derivatives of entries by the columns, a row an entry."""
        symbols = [self.workspace.graph.symbol(name) for name in self.columns]
        rows = [gradient(entry, symbols) for entry in entries]
        flat = iter(substitute([one for row in rows for one in row], self.known))
        return [[next(flat) for _ in symbols] for _ in rows]


def linear(w: Workspace) -> Linear:
    """Return the scene's linear parameters; DerivationError where matter flows, whose ways begin at centres of mass."""
    scene = w.scene
    if flows := [one.name for one in scene.loads if FORCES[one.kind].push.carried]:
        why = f"flows {', '.join(flows)} are not linear in masses and centres of mass"
        raise DerivationError(f"{scene.name}: there is no regressor, as {why}; take them out, and what they change")
    opened = with_force_parameters(scene)
    there = Workspace(opened, w.closing)
    own = [p.name for p in scene.parameters if p.name in {q.name for q in opened.parameters}]
    added = [p for p in opened.parameters if p.name not in own]
    values = {p.name: p.value.express(there.graph) for p in added if p.value is not None}
    ten = {p.name for p in added if p.value is None}
    symbols = {name: there.graph.symbol(name) for name in (*(p.name for p in added), *own)}
    by_force = [gradient(force, list(symbols.values())) for force in driving(there)]
    rows = {name: [row[k] for row in by_force] for k, name in enumerate(symbols)}
    own_symbols = {*symbols.values()}
    met = {name: {str(node.value) for node in reachable(rows[name]) if node in own_symbols} for name in rows}
    possible = [name for name, slopes in rows.items() if name not in met[name] and (name in ten or _any(slopes))]
    nothing = {symbols[name]: there.graph.zero for name in possible}
    alone = ten.union(name for name in possible if _any(substitute(rows[name], nothing)))
    kept: list[str] = []
    for name in sorted(possible, key=lambda name: name not in alone):
        if not met[name] & {*kept}:
            kept.append(name)  # all ten of a body, whether they are felt or not
    kept = [name for name in possible if name in kept]
    known = {symbols[name]: value for name, value in values.items() if name not in kept}
    bodies = [body_inertia(body, there.graph) for body in scene.bodies]
    declared = [entry for body in bodies for entry in (body.m, *body.h, *six(body.I))]
    declared += [values.get(name, symbols[name]) for name in kept if name not in ten]
    return Linear(there, tuple(kept), known, tuple(declared), w)


def _any(slopes: Sequence[Expr]) -> bool:
    return any(not slope.is_zero for slope in slopes)


def driving(w: Workspace) -> list[Expr]:
    """Return the driving forces by recursion, shape (n,); N m or N."""
    return w.forces(list(w.state.qdd))


def lagrange_driving(w: Workspace) -> list[Expr]:
    """Return the driving forces by Lagrange's equations, shape (n,); N m or N."""
    return w.energy.driving_forces()


def columns(w: Workspace) -> tuple[str, ...]:
    """Return a label for each parameter that is a column of the regressor."""
    return Linear.of(w).columns


TURNING = ("mx", "my", "Jxx", "Jyy", "Jxy", "Jxz", "Jyz")
SLIDING = ("m", "mx", "my", "mz")
"""What a revolute and a prismatic joint feel of a body, see `reduced_tree.split`."""

ALONG = ("m", "mz")
"""What a prismatic joint feels whose direction all turns before it have for their axis."""

ALL = ("m", "mx", "my", "mz", "Jxx", "Jyy", "Jzz", "Jxy", "Jxz", "Jyz")


@dataclass(frozen=True)
class Base:
    """Base parameters of the moving bodies, each a symbol."""

    names: tuple[str, ...]  # such as "mxR2" or "JxxR1", R1 the frame of the first moving body
    symbols: tuple[Expr, ...]  # of the parameters, in the same order
    values: tuple[Expr, ...]  # what they are made of, kg, kg m, kg m^2
    tree: ReducedTree  # the link frames, bodies that have these parameters alone, without rotors


def base(w: Workspace) -> Base:
    """Return the base parameters of a scene, felt or not; a ball and a free body keep all ten of theirs."""
    graph, zero, reduced = w.graph, w.graph.zero, w.whole
    together = {k: block[-1] for block in reduced.block if len(block) > 1 for k in block}
    names, symbols, values = list[str](), list[Expr](), list[Expr]()
    bodies = [Moments(zero, zero_vector(graph), Mat.symmetric(*(zero,) * 6))]
    along = (
        ()
        if together
        else tuple(k for k in reduced.outward() if reduced.slides[k] and slides_along_all_turns(reduced, k))
    )
    grouped = _given_on(reduced, along) if along else reduced.body
    for k in reduced.outward():
        own = dict(zip(ALL, (grouped[k].m, *grouped[k].h, *six(grouped[k].J)), strict=True))
        felt: tuple[str, ...] = ALONG if k in along else SLIDING if reduced.slides[k] else TURNING
        if k in together:  # joints that act as one: only behind the last of them is there a frame that is a body's
            felt = ALL if k == together[k] else ()
        here = {word: graph.symbol(f"{word} of link frame {k}") for word in felt}
        names += [f"{word}R{k}" for word in felt]
        symbols += here.values()
        values += [own[word] for word in felt]
        m, x, y, z, xx, yy, zz, xy, xz, yz = (here.get(word, zero) for word in ALL)
        bodies.append(Moments(m, (x, y, z), Mat.symmetric(xx, yy, zz, xy, xz, yz)))
    still = (zero,) * len(reduced.parent)
    tree = replace(reduced, body=tuple(bodies), armature=still, spherical_rotors=())
    return Base(tuple(names), tuple(symbols), tuple(values), tree)


def _given_on(reduced: ReducedTree, along: tuple[int, ...]) -> list[Moments]:
    """Return the bodies of a tree where slides along all turns give what lies beside them to what they slide on."""
    zero = reduced.graph.zero
    bodies = list(reduced.body)
    for k in reduced.inward():
        given, p = split(bodies[k], reduced.slides[k])[1], reduced.parent[k]
        if k in along:
            x, y, _ = bodies[k].h
            given = replace(given, h=(x, y, zero))
        bodies[p] = bodies[p] + reduced.X[k].fixed_part(reduced.slides[k]).moments_back(given)
    return bodies


@dataclass(frozen=True)
class BaseColumns:
    """The columns of a base regressor: groups of equal ones.

    Attributes:
        w: the workspace whose regressor it is.
        names: of the columns, equal ones as a sum, such as "JxxR1 + JyyR1 + Ia1".
        groups: of each column, the places of those that are equal to it among base parameters and what is no inertia.
    """

    w: Workspace
    names: tuple[str, ...]
    groups: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, w: Workspace) -> BaseColumns:
        """Return the columns of a workspace, found once."""
        return w.once(grouped)

    def values(self) -> list[Expr]:
        """Return β, what the columns are to be multiplied by: formulas of declared parameters."""
        own: Base = self.w.once(base)
        every = [*own.values, *Linear.of(self.w).parameters()[len(INERTIAL) * len(self.w.scene.bodies) :]]
        return [self.w.graph.total(every[k] for k in group) for group in self.groups]

    def named(self) -> tuple[tuple[str, Expr], ...]:
        return tuple(zip(self.names, self.values(), strict=True))

    def of_columns(self) -> list[Expr]:
        """Return β as formulas of π, the columns of the regressor, on the graph where these are symbols (`Linear`)."""
        found = Linear.of(self.w)
        there = found.workspace
        opened: Base = there.once(base)
        value = dict(zip(opened.names, opened.values, strict=True))
        own = self.w.once(base).names
        assert value.keys() == {*own}, f"link frames part: {own} and {opened.names}"
        every = [value[name] for name in own]
        every += [there.graph.symbol(name) for name in found.columns[len(INERTIAL) * len(self.w.scene.bodies) :]]
        return [there.graph.total(every[k] for k in group) for group in self.groups]


def grouped(w: Workspace) -> BaseColumns:
    """Return the columns that forces depend on, the first of equal ones in its place."""
    names, slopes = w.once(felt)
    groups: dict[tuple[Expr, ...], list[int]] = {}
    for k, column in enumerate(slopes):
        if any(not slope.is_zero for slope in column):
            groups.setdefault(tuple(column), []).append(k)
    told = tuple(" + ".join(names[k] for k in group) for group in groups.values())
    return BaseColumns(w, told, tuple(tuple(group) for group in groups.values()))


def felt(w: Workspace) -> tuple[tuple[str, ...], list[list[Expr]]]:
    """Return names and columns of all base parameters, then of what is no inertia of a body; by recursion."""
    found: Base = w.once(base)
    forces = rnea(found.tree, w.state.qd, w.state.qdd)
    rows = [gradient(force, found.symbols) for force in forces]
    names, more = w.once(others)
    suffix = ""
    while {f"{name}{suffix}" for name in found.names} & {*names}:
        suffix += "_b"  # a letter of the scene's own is called as one of these
    return (*(f"{name}{suffix}" for name in found.names), *names), [*map(list, zip(*rows, strict=True)), *more]


def others(w: Workspace) -> tuple[tuple[str, ...], list[list[Expr]]]:
    """Return names and columns of the linear parameters that are no inertia of a body, by recursion."""
    return _beside(w, driving)


def _beside(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> tuple[tuple[str, ...], list[list[Expr]]]:
    found = Linear.of(w)
    ten = len(INERTIAL) * len(w.scene.bodies)
    rows = found.slopes(forces(found.workspace))
    columns = [substitute(column, {}, w.graph) for column in list(zip(*rows, strict=True))[ten:]]
    return found.columns[ten:], columns


def base_columns(w: Workspace) -> tuple[str, ...]:
    """Return a label for each column of the base regressor."""
    return BaseColumns.of(w).names


def base_by_lagrange(w: Workspace) -> list[list[Expr]]:
    """Return all columns from K = 1/2 tr(dT/dt S dT/dt^T) and P = -g.S of every link frame T, S the moments."""
    found: Base = w.once(base)
    K, P = w.graph.zero, w.graph.zero
    placed = [Transform.unit(w.graph)]
    for k in found.tree.outward():
        placed.append(placed[found.tree.parent[k]] @ found.tree.X[k].transform)
        body, T = found.tree.body[k], placed[k]
        columns = [*T.R.T, T.p]
        rates = [tangents(column, w.state.velocity) for column in columns]
        S = [[*body.J[i], body.h[i]] for i in range(3)] + [[*body.h, body.m]]
        for i, j in product(range(4), repeat=2):
            K = K + S[i][j] * w.graph.dot(rates[i], rates[j]) / 2
        P = P - w.graph.total(S[3][j] * dot(found.tree.gravity, columns[j]) for j in range(4))
    bare = tuple(replace(joint, damping=Quantity.ZERO, dry=None) for joint in w.scene.joints)
    energy = replace(w.energy, K=K, G=P, E=w.graph.zero, scene=replace(w.scene, elements=(), joints=bare))
    rows = [gradient(force, found.symbols) for force in energy.driving_forces()]
    return [*map(list, zip(*rows, strict=True)), *_beside(w, lagrange_driving)[1]]


def chosen(w: Workspace, slopes: Sequence[Sequence[Expr]]) -> list[Expr]:
    """Return the first column of each group, row by row."""
    return [slopes[group[0]][i] for i in range(w.state.n) for group in BaseColumns.of(w).groups]
