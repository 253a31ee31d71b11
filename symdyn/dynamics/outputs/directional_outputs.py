"""Derivatives along one direction, of one weighted sum, and of second order: rows of OUTPUTS, when they are asked for.

    J        derivatives of an output f along X_1 … X_N, a column each (see `tangent_space`)
    d        a direction of every argument: dq along the velocities, dqd, dqdd or dtau
    φ        Σ w_i f_i, the entries of f with weights; f itself if it is one number
    jvp      J d                          vjp      wᵀ J, X_k φ
    H        H[k, j] = X_j X_k φ          H d      Σ_j X_j X_k φ d_j

H is what differentiates vjp along all columns of J, and not symmetric where a quaternion turns:

    X_j X_k φ - X_k X_j φ = Σ_l γ^l_jk X_l φ        brackets of the velocities, 0 for rates of coordinates

(H + Hᵀ)/2 is the second order of φ(q ∘ exp ξ, …) in ξ, which differential dynamic programming wants.

Sweeps that code is generated from read turns (`symdyn.dynamics.outputs.tree_formulations`) where that costs less;
those beside which they are proved do not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain

from symdyn.dynamics.loops.manifold import Seeds
from symdyn.dynamics.mechanism.linear_solve import RowSolve, RowStep
from symdyn.dynamics.outputs import implicit
from symdyn.dynamics.outputs.derivative_outputs import EACH, derived, differentiable, entries_of, rows_of
from symdyn.dynamics.outputs.named_functions import WEIGHTS, direction
from symdyn.dynamics.outputs.output import Formulation, Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.recursive_derivatives import forward_with_factors
from symdyn.dynamics.outputs.result_labels import Axis
from symdyn.dynamics.outputs.tangent_space import FREE, SWEEPS, TangentSpace, cheaper, forward, reverse
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, LocalPartials, substitute, tangents

Ways = Sequence[str]
"""Arguments along which an output is differentiated."""

Way = Callable[..., Sequence[Expr]]
"""Takes the workspace, the row of f, the arguments along which that is differentiated, and a place if f is of one."""


def amounts(w: Workspace, along: Ways) -> list[Expr]:
    """Return the entries of d in the order of the columns of J."""
    return list(chain.from_iterable(FREE.amounts(w, along).values()))


def weights(w: Workspace, count: int, row: Output) -> tuple[Expr, ...]:
    """Return the weights of the entries, 1 where there is one number."""
    return direction(w.graph, WEIGHTS, count) if row.axes else (w.graph.one,)


def weighted(w: Workspace, row: Output, *place: str) -> Expr:
    """Return φ."""
    entries = entries_of(w, row, *place)
    return w.graph.dot(weights(w, len(entries), row), entries)


# J d and wᵀ J


def along_one(w: Workspace, seeds: Seeds, entries: Sequence[Expr], formulation: str = "") -> list[Expr]:
    """Return J d of entries by one sweep forward; Lagrange's equations prove the others, and read no turns."""
    sweep = partial(tangents, entries, seeds)
    return sweep() if formulation == "lagrange" else cheaper(w, entries, sweep)


def pulled_back(
    w: Workspace, entries: Sequence[Expr], weights: Sequence[Expr], space: TangentSpace, formulation: str, along: Ways
) -> list[Expr]:
    """Return wᵀ J of entries by one sweep backwards, likewise."""
    phi = w.graph.dot(weights, entries)
    sweep = partial(space.pullback, w, formulation, along, phi)
    return sweep() if formulation == "lagrange" else cheaper(w, [phi], sweep)


def jvp(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return J d by one sweep forward."""
    entries = entries_of(w, row, *place)
    return along_one(w, FREE.direction(w, "", along), entries)


def jvp_of_rows(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return J d from J."""
    J, d = reverse(entries_of(w, row, *place), FREE.seeds(w, "", along)), amounts(w, along)
    return [w.graph.dot(J[k : k + len(d)], d) for k in range(0, len(J), len(d))]


def vjp(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return wᵀ J by one sweep backwards."""
    entries = entries_of(w, row, *place)
    return pulled_back(w, entries, weights(w, len(entries), row), FREE, "", along)


def vjp_of_columns(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return wᵀ J from J."""
    entries = entries_of(w, row, *place)
    columns = (tangents(entries, one) for one in FREE.seeds(w, "", along))
    return [w.graph.dot(weights(w, len(entries), row), column) for column in columns]


# Second order


def hessian(sweep: str, first: Way, w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return H row by row, from wᵀ J; its lower half from the upper one by brackets: X_k X_j = X_j X_k + [X_k, X_j]."""
    directions, slopes = FREE.seeds(w, "", along), first(w, row, along, *place)
    N = len(directions)

    def entries(read: LocalPartials) -> list[Expr]:
        H = [[w.graph.zero] * N for _ in range(N)]
        for k in range(N):
            H[k][k:] = SWEEPS[sweep]([slopes[k]], directions[k:], read)
            for j in range(k + 1, N):
                turned = w.graph.total(value * slopes[m] for m, value in _brackets(w, along, k, j))
                H[j][k] = H[k][j] + turned
        return [entry for line in H for entry in line]

    return cheaper(w, slopes, entries)


def _decided_in_rows(w: Workspace) -> RowSolve:
    """Return what H of λᵀ q̈ is solved from: rows J of forward dynamics behind T, which D J is taken from; H = T + Tᵀ.

    H = -(X_j X_k μᵀ τ + Σ_m (D_km J_mj + D_jm J_mk)) with μ = M⁻¹ λ, and D_km = X_k (M μ)_m, at μ and q̈ that are held.
    """
    n, free, one, known = w.state.n, w.prescribed.free, w.graph.one, w.once(forward_with_factors)
    N, given, zeros = 3 * n, direction(w.graph, WEIGHTS, n), [w.graph.zero] * 3 * n
    values = dict(zip((*w.state.qdd, *given), (*known.accelerations, *zeros[:n]), strict=True))
    for i, (mu,) in zip(free, known.factors.solve([[given[i]] for i in free]), strict=True):
        values[given[i]] = mu
    entries = substitute(hessian("reverse", vjp, w, OUTPUTS["inverse_dynamics"], ("q", "qd", "qdd")), values)
    H = [entries[N * k : N * (k + 1)] for k in range(N)]
    every = range(2 * n)
    sides = [(k, (*zeros[:k], -(H[k][k] * (one / 2)), *(-x for x in H[k][k + 1 : 2 * n]), *zeros[:n])) for k in every]
    turned = [(N * j + k, H[k][j] - H[j][k]) for k in every for j in every[k + 1 :] if H[j][k] is not H[k][j]]
    sides += [(N + k, (*known.rows[k], *zeros[:i], one, *zeros[i + 1 : n])) for k, i in enumerate(free)]
    D = [tuple((x, N + m) for m, i in enumerate(free) if not (x := H[k][2 * n + i]).is_zero) for k in every]
    steps = *known.factors.steps(range(N, N + n)), *(RowStep(k, one, D[k]) for k in every if D[k])
    return RowSolve(w.scene, tuple(sides), N + len(free), steps, ((None,) * N,) * N, turned=tuple(turned))


def _decided_hessian(w: Workspace) -> list[Expr]:
    """Return H of λᵀ q̈ from the same, J as it is without rows."""
    found: RowSolve = w.once(_decided_in_rows)
    J, N = w.once(forward_with_factors).jacobians, len(found.beside)
    rows = {k: [w.graph.zero] * N for k in range(N)} | {k: list(side) for k, side in found.sides}
    rows |= {k: [*J["q"][i], *J["qd"][i], *J["tau"][i]] for k, i in enumerate(w.prescribed.free, N)}
    for step in found.steps:
        for j, x in enumerate(rows[step.row] if step.row < N else ()):
            rows[step.row][j] = found.stepped(x, step.scale, ((D, rows[m][j]) for D, m in step.terms))
    return found.added([x for k in range(N) for x in rows[k]], found.turned or ())


def hessian_by_columns(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return H row by row, a sweep forward for each column of each row."""
    directions, entry = FREE.seeds(w, "", along), weighted(w, row, *place)
    return forward(forward([entry], directions), directions)


def hessian_vector(first: Way, w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return H d: wᵀ J moved along d."""
    slopes = first(w, row, along, *place)
    return cheaper(w, slopes, partial(tangents, slopes, FREE.direction(w, "", along)))


def hessian_vector_backwards(w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return H d: the gradient of φ's slope along d, and brackets: d_j X_j X_k = X_k d_j X_j + d_j [X_j, X_k]."""
    directions, d, phi = FREE.seeds(w, "", along), amounts(w, along), weighted(w, row, *place)
    slopes = reverse([phi], directions)
    found = reverse(tangents([phi], FREE.direction(w, "", along)), directions)
    return [
        one + w.graph.total(d[j] * value * slopes[m] for j in range(len(d)) for m, value in _brackets(w, along, j, k))
        for k, one in enumerate(found)
    ]


def _brackets(w: Workspace, along: Ways, j: int, k: int) -> Sequence[tuple[int, int]]:
    """Return pairs (l, γ^l_jk) of two columns of J; velocities and forces have none."""
    return w.directions.brackets.get((j, k), ()) if along[0] == "q" else ()


HESSIAN, TENSOR = "_hessian", "_second_derivatives"

WHOLE, PACKED_TENSOR = ("inverse_dynamics", "forward_dynamics"), f"{TENSOR}_packed"
"""Outputs of trees that have all that need not vanish, see `second_derivatives`, and what is behind their names."""

LARGEST = 4_000
"""Entries up to which a tensor of second derivatives is written out."""


def tensor(sweep: str, name: str, w: Workspace, row: Output, along: Ways, *place: str) -> list[Expr]:
    """Return X_j X_k f_i, j running fastest, then k; DerivationError where these are too many."""
    entries, directions = entries_of(w, row, *place), FREE.seeds(w, "", along)
    m, N = len(entries), len(directions)
    if m * N * N > LARGEST:
        packed = f", or {name}{PACKED_TENSOR}, those that need not vanish" if name in WHOLE else ""
        raise DerivationError(
            f"{w.scene.name}: {name}{TENSOR} has {m} x {N} x {N} = {m * N * N} entries, and no more than {LARGEST} are "
            f"written out; ask for {name}{HESSIAN}, a sum of them with weights, or {name}{HESSIAN}_vector{packed}"
        )
    return SWEEPS[sweep](SWEEPS[sweep](entries, directions), directions)


def _decided(rule: Callable[..., list[Expr]]) -> Way:
    """Return the way that the equations of motion have to derivatives of what they decide."""

    def way(w: Workspace, row: Output, along: Sequence[str]) -> list[Expr]:
        return rule(implicit.motion, implicit.accelerations, FREE, along, w)

    return way


JVPS: dict[str, dict[str, Way]] = {"forward_dynamics": {"solved": _decided(implicit.jvp)}}
VJPS: dict[str, dict[str, Way]] = {"forward_dynamics": {"solved": _decided(implicit.vjp)}}
HESSIANS = {"forward_dynamics": {"implicit": Formulation(_decided_hessian, solve=lambda w: w.once(_decided_in_rows))}}
"""Ways to J d, wᵀ J, and H of an output beside sweeps, by its name and theirs."""


def _slopes(name: str) -> dict[str, Way]:
    """Return the ways to wᵀ J that do not go by J."""
    return {**VJPS.get(name, {}), "reverse": vjp}


def _formulations(name: str, row: Output, ways: Mapping[str, Way | Formulation]) -> dict[str, Formulation]:
    """Return ways along all arguments of an output."""
    along = differentiable(row)
    if not along:
        raise DerivationError(f"{name} takes {', '.join(row.arguments) or 'nothing'}; it has no derivatives by that")

    def formulation(way: Way) -> Formulation:
        return Formulation(lambda w, *place: way(w, row, along, *place))

    return {one: way if isinstance(way, Formulation) else formulation(way) for one, way in ways.items()}


def _row(name: str, row: Output, text: str, ways: Mapping[str, Way | Formulation], **changes: object) -> Output:
    """Return a row of second derivatives, of a sum with weights; {d} in its text is J, block by block."""
    along, of = differentiable(row), {"arguments": _given(row, WEIGHTS), "weighs": rows_of(row)}
    of |= {
        "units": f"{row.units}{_times(row)}, per units of what moves",
        "formulations": _formulations(name, row, ways),
    }
    text = f"{text.format(d=FREE.jacobian(row.result, along), f=row.result)}, of {row.text}"
    return derived(row, along, text=text, **{**of, **changes})


def _given(row: Output, *more: str) -> tuple[str, ...]:
    """Return the arguments of an output and more, weights left out where it is one number."""
    return (*row.arguments, *(name for name in more if name != WEIGHTS or row.axes))


def _directions(row: Output, space: TangentSpace = FREE) -> tuple[str, ...]:
    return tuple(space.amounts_of[name] for name in differentiable(row))


def _columns(row: Output, space: TangentSpace = FREE) -> Axis:
    return lambda w: space.labels(w, differentiable(row))


def jvp_row(row: Output, space: TangentSpace, how: str, ways: Mapping[str, Formulation], **changes: object) -> Output:
    """Return the row of J d of an output along all its arguments, `how` they move in words."""
    return derived(
        row,
        differentiable(row),
        text=f"derivative {space.jacobian(row.result, differentiable(row))} d along one direction d{how} of {row.text}",
        formulations=ways,
        arguments=_given(row, *_directions(row, space)),
        result=f"d{row.result}",
        units=f"{row.units}, per unit of the direction",
        size=row.size.times(2.2),
        **changes,
    )


def vjp_row(row: Output, space: TangentSpace, how: str, ways: Mapping[str, Formulation], **changes: object) -> Output:
    """Return the row of wᵀ J of an output along all its arguments, `how` they move in words."""
    J = space.jacobian(row.result, differentiable(row))
    return derived(
        row,
        differentiable(row),
        text=f"derivatives{' weights^T' if row.axes else ''} {J}{how} of {row.text}",
        formulations=ways,
        arguments=_given(row, WEIGHTS),
        weighs=rows_of(row),
        axes=(_columns(row, space),),
        result="slopes",
        units=f"{row.units}{_times(row)}, per unit of what moves",
        size=row.size.times(2),
        **changes,
    )


def _jvp_row(name: str, row: Output) -> Output:
    ways = {**JVPS.get(name, {}), "forward": jvp, "rows": jvp_of_rows}
    return jvp_row(row, FREE, " of its arguments,", _formulations(name, row, ways))


def _vjp_row(name: str, row: Output) -> Output:
    ways = {**_slopes(name), "columns": vjp_of_columns}
    return vjp_row(row, FREE, f"{_of_sum(row)},", _formulations(name, row, ways))


ORDER = "row k, column j: X_j X_k, not symmetric where quaternions turn"


def _of_sum(row: Output) -> str:
    return " of the sum of all entries, each with its weight" if row.axes else ""


def _times(row: Output) -> str:
    return ", times weights" if row.axes else ""


def _hessian_row(name: str, row: Output) -> Output:
    ways = _slopes(name)
    return _row(
        name,
        row,
        f"second derivatives along the directions of {{d}}{_of_sum(row)}; {ORDER}",
        {
            **HESSIANS.get(name, {}),
            **{f"{way} over {of}": partial(hessian, way, ways[of]) for of in ways for way in ("reverse", "forward")},
            "columns": hessian_by_columns,
        },
        axes=(_columns(row), _columns(row)),
        result="H",
        size=row.size.columns(1.5),
    )


def _hessian_vector_row(name: str, row: Output) -> Output:
    return _row(
        name,
        row,
        f"second derivatives along the directions of {{d}}{_of_sum(row)}; {ORDER}; times one direction d",
        {
            **{f"forward over {way}": partial(hessian_vector, first) for way, first in _slopes(name).items()},
            "reverse over forward": hessian_vector_backwards,
        },
        arguments=_given(row, WEIGHTS, *_directions(row)),
        axes=(_columns(row),),
        result="Hd",
        size=row.size.times(5),
    )


def _tensor_row(name: str, row: Output) -> Output:
    return _row(
        name,
        row,
        "second derivatives along the directions of {d}; entry i, k, j: X_j X_k {f}_i, not symmetric where quaternions "
        "turn",
        {way: partial(tensor, way, name) for way in SWEEPS},
        arguments=row.arguments,
        weighs=row.weighs,
        axes=(rows_of(row), _columns(row), _columns(row)),
        result=f"dd{row.result}",
        units=f"{row.units}, per units of what moves",
        size=row.size.columns(EACH).columns(EACH).times(len(differentiable(row)) ** 2),
    )


ALONG_ONE: dict[str, Callable[[str, Output], Output]] = {
    "_jvp": _jvp_row,
    "_vjp": _vjp_row,
    f"{HESSIAN}_vector": _hessian_vector_row,
    HESSIAN: _hessian_row,
    TENSOR: _tensor_row,
}
"""What can be asked of every output, by what is written behind its name."""
