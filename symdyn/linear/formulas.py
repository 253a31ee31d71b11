"""A, B, C, D of a linear system as SymPy matrices, of any size.

Small systems at rest have the short formulas that are printed. All others are written by the graph: derivatives as
`variations` has them, and what `symbolic.assembled` makes of them, over nodes instead of numbers. What many entries
share has then a symbol of its own, as `sympy.cse` gives it, so that no entry is long.

    M ẋ = A x + B w        the implicit form, M = [1 0; 0 Nᵀ M N], in which nothing is divided by masses
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from itertools import count
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from symdyn.algebra import Array, Nodes, shared_to_sympy
from symdyn.arguments import SympyExpression, check_arguments, checked, is_sympy
from symdyn.emit.print import latex_symbols
from symdyn.errors import ArgumentError, LinearizeError, listed, quoted, suggestion
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, growing, substitute
from symdyn.linear.symbolic import EXACT, Blocks, assembled, blocks_of, entries_of, exact, fresh, kept, places, symbolic
from symdyn.linear.weights import Axis, places as channel
from symdyn.shown import Shown
from symdyn.simulation.prescribed import drive_names

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.prepared import Prepared

LONG = 4000
"""Operations of all entries, written out, beyond which what they share has symbols of its own."""

SPIN = "Omega{}{}"
"""Name of an entry of Ω, of axes that spin against a body."""


@dataclass(frozen=True, eq=False)
class Formulas(Shown):
    """The matrices of a linear system as SymPy matrices, in exact numbers and real symbols.

    Angles at the point that are multiples of 15 degrees, and what is zero there, are put in; all else has symbols.

    >>> import symdyn
    >>> found = symdyn.linearize(symdyn.example("cart_pole")).formulas
    >>> found.A[3, 1], found.implicit[0][2, 3]
    (6*g*(mc + mp)/(l*(4*mc + mp)), -l*mp/2)

    Attributes:
        name: of the scene.
        states, inputs, outputs: what x, w and y are, as columns of symbols.
        A, B, C, D: as of the linearization.
        implicit: M, A, B of M ẋ = A x + B w, as SymPy's `Linearizer` returns them: entries are shorter, as nothing is
            divided by masses.
        definitions: symbols that stand for what entries share, and what each is, in symbols before it; none for what is
            small. Multipliers and accelerations at the point are symbols as parameters are.
        point: values of all symbols, those of `definitions` too: `A.subs(point)` is A in numbers, and
            `A.xreplace(point)` is it sooner.
    """

    name: str
    states: Any
    inputs: Any
    outputs: Any
    A: Any
    B: Any
    C: Any
    D: Any
    implicit: tuple[Any, Any, Any]
    definitions: Mapping[Any, Any]
    point: Mapping[Any, float]
    letters: Mapping[str, str] = field(repr=False)
    rates: Mapping[str, str] = field(repr=False)

    def __call__(self) -> Formulas:
        """Return them, as a method would."""
        return self

    def __repr__(self) -> str:
        sizes = ", ".join(f"{x} {getattr(self, x).rows}×{getattr(self, x).cols}" for x in "ABCD")
        more = f"; {len(self._needed())} definitions" if self._needed() else ""
        return f"<Formulas of {self.name}: {sizes}{more}; .implicit, .point, .transfer(), .lambdify(), .latex()>"

    def _needed(self) -> list[tuple[Any, Any]]:
        """Return the definitions that A, B, C, D need, in order."""
        needed = set().union(*(one.free_symbols for one in (self.A, self.B, self.C, self.D)))
        for symbol, form in reversed(list(self.definitions.items())):
            needed |= form.free_symbols if symbol in needed else set()
        return [one for one in self.definitions.items() if one[0] in needed]

    def evaluated(self) -> tuple[Array, Array, Array, Array]:
        """Return A, B, C, D in numbers at the point: those of the linearization, to rounding."""
        A, B, C, D = (
            np.array([float(x) for x in one.xreplace(self.point)]).reshape(one.shape)
            for one in (self.A, self.B, self.C, self.D)
        )
        return A, B, C, D

    @checked(LinearizeError)
    def transfer(self, output: str | None = None, input: str | None = None) -> Any:
        """Return the transfer function to an output from an input, G(s) in lowest terms.

        s is `sympy.Symbol("s")`, or `Symbol("s_")` where the scene has a letter s. G is a rational function of all
        symbols, those of `definitions` too: det [s M - A, -B; C, D] / det (s M - A) of `implicit`, B and D polynomials
        in s for an input with rates. Beyond some eight states it takes long.

        Raises:
            LinearizeError: a name that is not known, or one is left out where there are several.
        """
        from sympy import Matrix, Symbol, cancel, collect, fraction
        from sympy.polys.matrices import DomainMatrix

        y, w, x = (tuple(map(str, one)) for one in (self.outputs, self.inputs, self.states))
        i, k = channel(Axis(y, y), Axis(w, w), (output, input), x)
        s = Symbol(fresh("s", {*map(str, self.point), *x, *w}))
        B, D, power, name = 0 * self.B[:, 0], 0 * s, 0, w[k]
        while name in w:
            B, D = B + s**power * self.implicit[2][:, w.index(name)], D + s**power * self.D[i, w.index(name)]
            name, power = self.rates.get(name, "") if w[k] not in self.rates.values() else "", power + 1
        P = s * self.implicit[0] - self.implicit[1]
        whole = Matrix([[P, -B], [self.C[i, :], Matrix([[D]])]])
        two = [DomainMatrix.from_Matrix(one, extension=True) for one in (whole, P)]
        above, below = (one.domain.to_sympy(one.charpoly()[-1]) for one in two)
        above, below = fraction(cancel(-above / below))
        return collect(above, s) / collect(below, s)

    def lambdify(self, *symbols: str | SympyExpression | Sequence[str | SympyExpression]) -> Callable[..., list[Array]]:
        """Return a function of symbols, or names, each once, in SI, that gives A, B, C, D; others keep their values.

        Raises:
            LinearizeError: a name that no formula has.
        """
        import sympy

        known = {str(one): one for one in self.point if one not in self.definitions}
        lists: Any = ([one] if isinstance(one, str) or is_sympy(one) else one for one in symbols)
        names = [*dict.fromkeys(str(one) for some in lists for one in some)]
        for name in names:
            if name not in known:
                raise LinearizeError(f"{self.name}: no formula of A, B, C, D has {name}; {suggestion(name, known)}")
        free = [known[name] for name in names]
        kept = {one: self.point[one] for name, one in known.items() if name not in names}
        defined = [(symbol, one.xreplace(kept)) for symbol, one in self._needed()]
        parts = [one.xreplace(kept) for one in (self.A, self.B, self.C, self.D)]

        @wraps(made := sympy.lambdify(free, parts, "numpy", cse=lambda entries: (defined, entries)))
        def matrices(*values: Any) -> list[Array]:
            if len(values) != len(names) or any(isinstance(one, str) for one in values):
                raise ArgumentError(f"{quoted(values)}: give a number in SI for each of: {listed(names)}")
            return [*made(*values)]

        return matrices

    def latex(self, part: Literal["", "A", "B", "C", "D"] = "") -> str:
        """Return ẋ = A x + B w, y = C x + D w in LaTeX and what its symbols stand for, or one matrix alone."""
        from sympy import latex

        check_arguments(Formulas.latex, locals())
        names = {one: self.letters[str(one)] for one in self.point if str(one) in self.letters}
        A, B, C, D = every = [
            str(latex(getattr(self, one), symbol_names=names, mat_str="bmatrix", mat_delim="")) for one in "ABCD"
        ]
        if part:
            return every["ABCD".index(part)]
        x, w = r"\mathbf{x}", r"\mathbf{w}"
        driven = f" + {B} {w}" if self.inputs.rows else ""
        through = "" if self.D.is_zero_matrix else f" + {D} {w}"
        rows = [rf"\dot{{{x}}} &= {A} {x}{driven}", rf"\mathbf{{y}} &= {C} {x}{through}"]
        rows += [f"{latex(symbol)} &= {latex(one, symbol_names=names)}" for symbol, one in self._needed()]
        return "\n".join([r"\begin{align*}", " \\\\\n".join(rows), r"\end{align*}"])


@growing()
def formulas(system: Linearization) -> Formulas:
    """Return a linear system in formulas.

    Raises:
        LinearizeError: it does not come from a scene's equations.
    """
    from sympy import ImmutableMatrix, Symbol

    prepared, scene = system.prepared, system.scene
    if prepared is None:
        raise LinearizeError(f"{scene.name}: it is not known what was linearised; take the system of symdyn.linearize")
    if prepared.asked[-1]:
        raise LinearizeError(f"{scene.name}: a mode of contacts is linearised in numbers alone; read .A, .B, .C, .D")
    letters, at = _letters(prepared), system.point
    free = prepared.place(at.q, at.u, at.t, np.zeros(len(scene.velocities) + len(at.inputs))).point
    given = np.concatenate([at.tau - free.tau, at.inputs - free.inputs])  # beside formulas
    point = dict(prepared.place(at.q, at.u, at.t, given).values)
    values = {letters.get(node, str(node.value)): x for node, x in point.items()}
    values |= {SPIN.format(i + 1, k + 1): system.spin[i, k] for i, k in np.argwhere(system.spin)}
    states, inputs, outputs = len(system.states), len(system.inputs), len(system.outputs)
    shapes = ((states, states), (states, inputs), (outputs, states), (outputs, inputs))
    positive = [one.name for one in scene.parameters if one.positive]

    def symbol(name: str) -> Any:
        return Symbol(name, real=True, **({"positive": True} if name in positive else {}))

    short = symbolic(prepared, system)
    blocks = _written(prepared, system, point)
    parts = [blocks.mass, blocks.side] if short else [getattr(blocks, x) for x in ("A", "B", "C", "D", "mass", "side")]
    taken = {*values, *system.states.names, *system.inputs.names, *system.outputs.names}
    taken |= {name for name, _ in short.defined} if short else set()
    names = (name for k in count() if (name := f"z{k}") not in taken)
    flat = [x for rows in parts for row in rows for x in row]
    defined, found = shared_to_sympy(flat, positive, names, LONG)
    written = iter(found)
    if short:
        forms = (short.A, short.B, short.C, short.D)
        written = iter([*(x.to_sympy(positive) for rows in forms for row in rows for x in row), *found])
        defined = [*((symbol(name), form.to_sympy(positive)) for name, form in reversed(short.defined)), *defined]
    A, B, C, D, M, side = (
        ImmutableMatrix(rows, columns, [next(written) for _ in range(rows * columns)])
        for rows, columns in (*shapes, (states, states), (states, states + inputs))
    )
    used = set().union(*(one.free_symbols for one in (A, B, C, D, M, side, *(x for _, x in defined))))
    numbers = {one: x for name, x in values.items() if (one := symbol(name)) in used}
    for one, form in defined:
        numbers[one] = float(form.xreplace(numbers))
    x, w, y = (
        ImmutableMatrix(len(axis), 1, [symbol(name) for name in axis.names])
        for axis in (system.states, system.inputs, system.outputs)
    )
    implicit = (M, side[:, :states], side[:, states:])
    return Formulas(
        scene.name, x, w, y, A, B, C, D, implicit, dict(defined), numbers, latex_symbols(scene), scene.rates
    )


def _letters(prepared: Prepared) -> dict[Expr, str]:
    """Return what users call driving forces and multipliers."""
    v, scene = prepared.functions, prepared.scene
    taken = {*scene.coordinates, *scene.first_order, *(one.name for one in scene.parameters)}
    pulls = (fresh(f"lambda{k}", taken) for k in range(1, len(v.multipliers) + 1))
    return dict(zip((*v.w.state.tau, *v.multipliers), (*drive_names(scene), *pulls), strict=True))


def _written(prepared: Prepared, system: Linearization, point: Mapping[Expr, float]) -> Blocks:
    """Return a linear system in nodes: zero what is zero at the point, coordinates exact that can be."""
    v, w = prepared.functions, prepared.functions.w
    n, graph = len(v.u), w.graph
    moving = (*v.u, *v.a, *w.state.tau, *v.multipliers, *map(graph.symbol, v.inputs))
    known = {one: graph.symbol(name) for one, name in _letters(prepared).items()}
    field = Nodes(graph, {**point, **{symbol: point[one] for one, symbol in known.items()}})
    known |= {one: graph.zero for one in moving if abs(point[one]) <= EXACT}
    if system.kind == "rest":
        known |= dict.fromkeys((*w.state.qd, *v.a), graph.zero)
    u, ad_u = substitute(v.u, known), [[graph.zero] * n for _ in range(n)]
    for (j, i), terms in w.directions.brackets.items():
        for k, value in terms:
            ad_u[k][i] = ad_u[k][i] + value * u[j]
    spin = [[graph.zero] * n for _ in range(n)]
    for i, k in np.argwhere(system.spin).tolist():
        spin[i][k] = graph.symbol(SPIN.format(i + 1, k + 1))

    def tried(place: Mapping[Expr, Expr]) -> Blocks:
        blocks = blocks_of(v, substitute(entries_of(v), {**known, **place}))
        found = assembled(field, blocks | {"ad_u": ad_u, "spin": spin}, prepared, *places(prepared, system))
        return found.without(*kept(prepared, system))

    try:
        return tried(exact(prepared, system)[0])
    except ZeroDivisionError:
        return tried({})
