"""Equations as matrices and symbols of SymPy, to substitute, simplify, solve and lambdify.

M q̈ + C q̇ + g + k_E = τ + Gᵀ λ      c = C q̇
r(q) = 0,  G q̇ = 0,  G q̈ + Ġ q̇ = 0        rows of loops and contacts
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

from symdyn.algebra import Form, Number, Symbol, graph_to_sympy
from symdyn.arguments import SympyExpression, check_arguments, suggesting
from symdyn.dynamics import Workspace
from symdyn.dynamics.loops import differentiated
from symdyn.dynamics.mechanism import TIME, State
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import ArgumentError, EmitError, UnknownNameError, choice, listed, quoted
from symdyn.frozen import dataclass, field, fields, replace
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene, SceneUnits, parse
from symdyn.scene.values import Faults, FormulaError, Unit, acceleration_name, fits, names_in, question, velocity_name
from symdyn.shown import BySympy, Shown
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.algebra import Array

HALF = Number(Fraction(1, 2))


@dataclass(frozen=True, eq=False)
class SympyEquations(Shown, BySympy):
    """The equations of motion in SymPy: matrices immutable, numbers exact.

    Attributes:
        scene: the mechanism.
        symbols: what stands for each name: parameters, coordinates, velocities (q1_dot), accelerations (q1_ddot),
            drives, inputs, multipliers (lambda1), t, and lengths of struts (s_sf, s_sf_dot).
        q, qd, qdd: coordinates, shape (nq, 1), velocities and accelerations, shape (n, 1); rad or m, and per s.
        rates: of the coordinates, shape (nq, 1): qd, but for quaternions, and for what flies.
        M: mass matrix, shape (n, n); kg m^2, kg m or kg.
        C: by Christoffel symbols, so that Ṁ - 2 C is skew, shape (n, n).
        c: C q̇, shape (n, 1); N m or N.
        g: ∂P/∂q of gravity, shape (n, 1); N m or N.
        k_E: ∂P/∂q of springs, shape (n, 1), zero where there are none; N m or N.
        tau: drives, declared forces, dampers, friction and loads, shape (n, 1); N m or N.
        G: rows of loops and contacts, shape (m, n).
        multipliers: λ, shape (m, 1); N or N m, on the child.
        bias: Ġ q̇, shape (m, 1).
        residual: r(q), of position-level rows, shape (p, 1).
        motions: formulas in t of the coordinates whose motion is prescribed.
        s, sd: states of one's own and their rates, shape (ns, 1).
        sub: lengths of struts between points and their rates, which stand in k_E, tau and P as functions of what they
            depend on, such as s_sf(a, x, y), with their formulas: `.subs(eq.sub).doit()` writes them out, before any
            values are put in.
        K, P: kinetic energy; potential energy of gravity and springs; J.
        unsimplified: why rows have no closed form, "" where they have one; they are then as they were derived, exact
            and long.
    """

    scene: Scene
    symbols: Mapping[str, Any]
    q: Any
    qd: Any
    qdd: Any
    rates: Any
    M: Any
    C: Any
    c: Any
    g: Any
    k_E: Any
    tau: Any
    G: Any
    multipliers: Any
    bias: Any
    residual: Any
    motions: Mapping[Any, Any]
    s: Any
    sd: Any
    K: Any
    P: Any
    sub: Mapping[Any, Any] = field(default_factory=dict)
    unsimplified: str = ""

    def __repr__(self) -> str:
        rows = ", G, multipliers, bias, residual" if self.G.rows else ""
        coordinates = listed(self.scene.coordinates)
        return f"<SympyEquations of {self.scene.name}: M, C, c, g, k_E, tau{rows}, K and P in {coordinates}>"

    def __getitem__(self, name: str | SympyExpression) -> Any:
        """Return what stands for a name; UnknownNameError if there is none, with those that there are."""
        from sympy import Basic

        check_arguments(SympyEquations.__getitem__, locals(), UnknownNameError)
        name = self._names(name).get(name, str(name)) if isinstance(name, Basic) else str(name)
        if name not in self.symbols:
            new = f"; a letter of your own is sympy.Symbol({name!r})" * name.isidentifier()
            raise UnknownNameError(f"there is no {name!r}; {choice(name, self.symbols)}{new}")
        return self.symbols[name]

    @cached_property
    def values(self) -> dict[Any, Any]:
        """Values of parameters, exact, as `subs` takes them; parameters without a value are left out.

        >>> import symdyn
        >>> arm = symdyn.equations(symdyn.example("four_bar")).sympy()
        >>> arm.M.subs(arm.values)[2, 2]
        343/24
        """
        graph = Graph()
        found = {one.name: one.value.express(graph) for one in self.scene.parameters if one.value is not None}
        numbers = graph_to_sympy(list(found.values()))
        return {self.symbols[name]: number for name, number in zip(found, numbers, strict=True)}

    @property
    def equations(self) -> list[Any]:
        """The equations of motion, one `Eq` a coordinate.

        >>> import symdyn
        >>> symdyn.equations(symdyn.example("pendulum")).sympy().equations
        [Eq(g*l*m*sin(q1) + l**2*m*q1_ddot, -b*q1_dot + tau1)]
        """
        from sympy import Eq

        left = self.M * self.qdd + self.c + self.g + self.k_E
        return [Eq(*sides) for sides in zip(left, self.tau + self.G.T * self.multipliers, strict=True)]

    @property
    def letters(self) -> dict[Any, str]:
        """What the scene's letters are in LaTeX, by symbol."""
        return {self.symbols[name]: tex for name, tex in latex_symbols(self.scene).items() if name in self.symbols}

    def latex(self) -> str:
        """Return the equations as they stand in LaTeX, with the scene's letters."""
        from sympy.physics.vector.printing import vlatex

        rows = [[vlatex(side, symbol_names=self.letters) for side in one.args] for one in self.equations]
        return "\\begin{align*}\n" + " \\\\\n".join(map(" &= ".join, rows)) + "\n\\end{align*}"

    def text(self) -> str:
        """Return the equations as they stand in plain text, which `symdyn.scene.parse` reads, one a line."""
        named = {one: Symbol(name).to_sympy() for name, one in self.symbols.items()}
        return "\n".join(" = ".join(str(side.xreplace(named)) for side in one.args) for one in self.equations)

    def sympy(self) -> SympyEquations:
        """Return these equations, as `equations(...)` has a method of that name."""
        return self

    def _sympy_(self) -> Any:
        from sympy import Tuple

        return Tuple(*self.equations)

    def subs(self, *given: Any, **by_name: Any) -> SympyEquations:
        """Return the equations with values or expressions in place of symbols, as SymPy's `subs` does, or of names.

        Lengths of struts are written out.

        >>> import symdyn
        >>> arm = symdyn.equations(symdyn.example("two_link")).sympy()
        >>> arm.subs({"m1": 0, "q2": 0}).M[0, 1], arm.subs("m1", 1).M[1, 1]
        (h1*h2*m2 + h2**2*m2, h2**2*m2)
        """
        given = (*given, by_name) if by_name else given
        pair = {given[0]: given[1]} if len(given) == 2 and isinstance(given[0], Hashable) else given
        known = self._known(given[0] if len(given) == 1 else pair)
        parts = {one.name: getattr(self, one.name) for one in fields(self)}
        put = {name: self._explicit(part).subs(known) for name, part in parts.items() if hasattr(part, "free_symbols")}
        motions = {one: form.subs(known) for one, form in self.motions.items()}
        return replace(self, **put, motions=motions, sub={})

    def _names(self, found: Any) -> dict[Any, str]:
        """Return what stands in an expression for names of here: symbols, and of what moves functions of t."""
        still = {TIME, *(one.name for one in self.scene.parameters)}
        names = {x: name for x, name in names_in(found).items() if name in self.symbols}
        for x, name in names.items():
            own = self.symbols[name].assumptions0
            if any(own.get(key, told) != told for key, told in x.assumptions0.items()):
                raise UnknownNameError(f"{name}: the scene's has other assumptions; give {name!r} or another letter")
        return {x: name for x, name in names.items() if x.is_Symbol or name not in still}

    def _known(self, values: object) -> dict[Any, Any]:
        """Return values and expressions, of which texts are formulas of symdyn, by symbol."""
        from sympy import Basic, SympifyError, sympify

        if not isinstance(values, Mapping) or any(not isinstance(one, str | Basic) for one in values):
            raise EmitError(f"given = {quoted(values)} names no values; give them by name or symbol, as in {{'m': 2}}")

        names, units = {one: name for name, one in self.symbols.items()}, SceneUnits(self.scene)

        def ours(found: Any) -> Any:
            """Return an expression in what stands here for its names: also for q(t) and its derivatives."""
            return found.xreplace({x: self.symbols[name] for x, name in self._names(found).items()})

        def read(symbol: Any, value: Any) -> Any:
            letter = units.letter(names.get(symbol, ""))
            if asked := question(letter, value):
                raise EmitError(f"given: {asked}")
            if not isinstance(value, str):
                try:
                    found = ours(sympify(value, strict=True))
                    if getattr(found, "is_Matrix", False) or not found.is_commutative:
                        raise TypeError
                    return found
                except (SympifyError, AttributeError, TypeError, ValueError, RecursionError):
                    raise EmitError(
                        f"given: {quoted(value)} is no value; give a number, a formula or an expression"
                    ) from None
            formula, faults = parse(value), Faults("")
            try:
                fits(formula, Unit.read(letter.unit) if letter.unit else None)
            except FormulaError as error:
                raise EmitError(f"given: {letter.name}: {value} {error}") from None
            units.check(formula, f"given: {letter.name}", faults, unit=letter.unit, place="bodies.")
            faults.close(lambda lines: EmitError("\n".join(lines)))
            (found,) = graph_to_sympy([formula.express(Graph())])
            return found.xreplace({one: self[str(one)] for one in found.free_symbols})

        symbols = ((self[one] if isinstance(one, str) else ours(one), value) for one, value in values.items())
        return {symbol: read(symbol, value) for symbol, value in symbols}

    def _explicit(self, part: Any) -> Any:
        """Return a matrix or an energy with lengths of struts written out."""
        return part.subs(self.sub).doit() if self.sub else part

    def _balance(self) -> tuple[Any, Any]:
        """Return A and b of A [q̈; λ] = b; where a motion is prescribed, q̈ is its own, and the drive follows."""
        from sympy import zeros

        n, rows, t = self.M.rows, self.G.rows, self.symbols[TIME]
        A = self.M.row_join(-self.G.T).col_join(self.G.row_join(zeros(rows, rows))).as_mutable()
        b = (self.tau - self.c - self.g - self.k_E).col_join(-self.bias).as_mutable()
        for k, velocity in enumerate(self.scene.velocities):
            motion = self.motions.get(self.symbols[velocity.removesuffix("_dot")])
            if motion is not None:
                A[k, :] = zeros(1, n + rows)
                A[k, k], b[k] = 1, motion.diff(t, 2)
        return A, b

    def solve_accelerations(self) -> tuple[Any, Any]:
        """Return q̈, shape (n, 1), and λ, shape (m, 1), solved for.

        >>> import symdyn
        >>> symdyn.equations(symdyn.example("pendulum")).sympy().solve_accelerations()[0]
        Matrix([[(-b*q1_dot - g*l*m*sin(q1) + tau1)/(l**2*m)]])

        Raises:
            EmitError: the solution is too long for anybody; with what works in its place.
        """
        from sympy import ImmutableMatrix

        A, b = self._balance()
        if sum(one.count_ops() for one in (*A, *b)) * GROWTH**A.rows > MOST:
            raise EmitError(
                f"{self.scene.name}: {A.rows} equations are too many, or too long, to be solved in symbols; take "
                ".lambdify(), which solves them in numbers, or symdyn.load(scene).forward_dynamics, the fastest"
            )
        found = ImmutableMatrix(A.adjugate() * b / A.det() if A.rows <= CRAMER else A.LUsolve(b))
        return found[: self.M.rows, :], found[self.M.rows :, :]

    def state_space(self) -> tuple[Any, Any]:
        """Return x = [q; u; s] and f of ẋ = f, columns in symbols: of drives, inputs, parameters and t, too.

        >>> import symdyn
        >>> x, f = symdyn.equations(symdyn.example("pendulum")).sympy().state_space()
        >>> x.T, f[0]
        (Matrix([[q1, q1_dot]]), q1_dot)

        Raises:
            EmitError: as of `solve_accelerations`.
        """
        rates = self.rates.col_join(self.solve_accelerations()[0]).col_join(self.sd)
        return self.q.col_join(self.qd).col_join(self.s), self._explicit(rates)

    def lambdify(self, values: Mapping[Any, Any] | None = None) -> Callable[[float, Any], Array]:
        """Return f(t, x) of ẋ = f as NumPy computes it, for `scipy.integrate.solve_ivp`, x = [q; u; s].

        Accelerations are solved for at every call, so that equations may be of any size.

        >>> import symdyn
        >>> from scipy.integrate import solve_ivp
        >>> rates = symdyn.equations(symdyn.example("cart_pole")).sympy().lambdify({"F": "-10*x"})
        >>> round(float(solve_ivp(rates, (0, 1), [0.1, 0, 0, 0], rtol=1e-9).y[0, -1]), 6)
        -0.053859

        Args:
            values: of parameters, drives and inputs, by name or symbol: numbers in SI, texts with units, or expressions
                in x and t. Parameters have those of the scene where none is given, drives and inputs zero.

        Raises:
            UnknownNameError: a name that is none.
            FormulaError: text that is no formula.
            EmitError: parameters without a value.
        """
        import numpy as np
        import sympy

        idle = [*filter(None, self.scene.drives), *(one.name for one in self.scene.inputs)]
        given = self._known(dict.fromkeys(idle, 0)) | self._known({} if values is None else values)
        known, x, t = self.values | given, self.q.col_join(self.qd).col_join(self.s), self.symbols[TIME]
        places = {one: sympy.Dummy() for one in (*reversed(list(x)), t)}
        for _ in given:  # values in which parameters, and others of them, stand
            known = {one: known[one].xreplace({k: v for k, v in known.items() if k not in places}) for one in known}
        parts = [self._explicit(part).xreplace(known) for part in (*self._balance(), self.rates, self.sd)]
        left = set().union(*map(names_in, parts)) - set(places)
        for one in sorted(map(str, left - set(self.symbols.values()))):
            raise UnknownNameError(f"{self.scene.name}: there is no {one}; {choice(one, self.symbols)}")
        if free := sorted(map(str, left)):
            raise EmitError(f"{self.scene.name}: no value for {listed(free)}; give {dict.fromkeys(free, 1)}")
        parts = [part.xreplace(places) for part in parts]
        shared = partial(sympy.cse, order="none", list=False)  # the usual order takes minutes of an arm
        call, n = sympy.lambdify([places[t], [places[one] for one in x]], parts, "numpy", cse=shared), self.M.rows

        @suggesting
        def rates(t: float, x: Any) -> Array:
            """Return f of ẋ = f at a time, s, and x = [q; u; s], shape of x."""
            if np.ndim(t) or np.shape(x)[:1] != (len(places) - 1,):
                raise ArgumentError(f"t = {quoted(t)}, x = {quoted(x)}: give a number and a list of {len(places) - 1}")
            A, b, moved, own = call(t, x)
            return np.concatenate([np.ravel(moved), np.linalg.solve(A, b)[:n, 0], np.ravel(own)])

        return rates


MOST, GROWTH = 500_000, 3
"""Operations that are solved in symbols, each equation making them so many times more; a four-bar has 74 thousand."""

CRAMER = 3
"""Equations that are solved by Cramer's rule, whose result is one quotient."""


def sympy_equations(page: Printable, dynamic: bool = False) -> SympyEquations:
    """Return what a page says in SymPy; with `dynamic` what moves is a function of time."""
    from sympy import ImmutableMatrix

    scene, rows, n = page.scene, page.constraints.rows, range(len(page.rows))
    positive = [one.name for one in scene.parameters if one.positive]
    rates, accelerations = scene.velocities, [acceleration_name(u) for u in scene.velocities]
    sizes, own = [row.multiplier for row in rows], [one.name for one in scene.states]
    names = [*(one.name for one in scene.parameters), *scene.coordinates, *rates, *accelerations]
    names += [*filter(None, scene.drives), *(one.name for one in scene.inputs), *sizes, TIME]
    names += [*own, *map(acceleration_name, own)]
    plain = {name: Symbol(name).to_sympy(positive) for name in names}
    symbols = plain | _in_time(scene, sizes) if dynamic else plain
    moved = {plain[name]: symbols[name] for name in names if dynamic and plain[name] != symbols[name]}
    functions = _functions(page, plain, moved)
    symbols |= functions
    moved |= {Symbol(name).to_sympy(positive): function for name, function in functions.items()}

    def write(one: Form | Expr) -> Any:
        found = graph_to_sympy([one], positive)[0] if isinstance(one, Expr) else one.to_sympy(positive)
        return found.xreplace(moved)

    def matrix(entries: Iterable[Sequence[Form | Expr]], width: int = 1) -> Any:
        listed = [write(one) for row in entries for one in row]
        return ImmutableMatrix(len(listed) // width if width else 0, width, listed)

    def column(entries: Iterable[Form | Expr]) -> Any:
        return matrix([one] for one in entries)

    def alone(kind: str) -> Any:
        return column(Form.sum(c.form for c in row if c.kind == kind) for row in page.rows)

    told = dict(page.rates)
    kept = _as_derived(scene) if page.constraints.missing else [(row.G, row.bias, row.residual) for row in rows]
    return SympyEquations(
        scene=scene,
        symbols=symbols,
        q=column(map(Symbol, scene.coordinates)),
        qd=column(map(Symbol, rates)),
        qdd=column(map(Symbol, accelerations)),
        rates=column(told.get(rate, Symbol(rate)) for rate in map(velocity_name, scene.coordinates)),
        M=matrix([[c.form for c in page.inertia(i)] for i in n], len(n)),
        C=matrix([_christoffel(page, i) for i in n], len(n)),
        c=column(page.coriolis(i) for i in n),
        g=alone("k_G"),
        k_E=alone("k_E"),
        tau=column(page.right),
        G=matrix((G for G, _, _ in kept), len(n)),
        multipliers=column(map(Symbol, sizes)),
        bias=column(bias for _, bias, _ in kept if bias is not None),
        residual=column(residual for _, _, residual in kept if residual is not None),
        motions={symbols[name]: write(form) for name, form in page.motions},
        s=column(map(Symbol, own)),
        sd=column(told[acceleration_name(name)] for name in own),
        K=write(page.K),
        P=write(page.P),
        sub={function: write(page.lengths.explicit[name]) for name, function in functions.items()},
        unsimplified=page.constraints.missing,
    )


def _christoffel(page: Printable, i: int) -> list[Form]:
    """Return row i of C: k_D,ij u_j + Σ_k (k_C,i,jk + γ^l_kj M_il) u_k / 2, γ being zero for rates of coordinates."""
    velocities = [Symbol(u) for u in page.scene.velocities]
    terms: list[list[Form]] = [[] for _ in velocities]
    for c in page.rows[i]:
        if c.of != "qd" or c.vanishes:
            continue
        _, j, *other = (index - 1 for index in c.indices)
        if other:
            terms[j].append(Form.product((HALF, c.form, velocities[other[0]])))
            terms[other[0]].append(Form.product((HALF, c.form, velocities[j])))
        else:
            terms[j].append(Form.product((c.form, velocities[j])))
    inertia = [c.form for c in page.inertia(i)]
    for (k, j), brackets in Workspace(page.scene).directions.brackets.items():
        terms[j] += [Form.product((HALF, Number(Fraction(x)), inertia[m], velocities[k])) for m, x in brackets]
    return [Form.sum(some) for some in terms]


def _as_derived(scene: Scene) -> list[tuple[tuple[Expr, ...], Expr, Expr | None]]:
    """Return G, Ġ u and residual of the rows of a scene, for those without a closed form."""
    graph = Graph()
    found = differentiated(scene, graph, State.of(scene, graph))
    return [
        (found.G[k], found.bias[k], found.residual[k] if found.labels[k].holonomic else None)
        for k in Workspace(scene).loops.decisions.independent_rows
    ]


def _functions(page: Printable, plain: Mapping[str, Any], moved: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the lengths of struts and their rates as functions of what they depend on, so that these move them."""
    from sympy import Function

    found = {}
    for name, _ in page.lengths.used((*page.forms, page.P)):
        needed = set(page.lengths.explicit[name].symbols)
        found[name] = Function(name, real=True)(*(plain[one].xreplace(moved) for one in plain if one in needed))
    return found


def _in_time(scene: Scene, multipliers: Sequence[str]) -> dict[str, Any]:
    """Return what moves and what drives it as SymPy's `dynamicsymbols`, velocities as derivatives, and its t."""
    from sympy.physics.vector import dynamicsymbols

    found = {TIME: dynamicsymbols._t}
    given = [*filter(None, scene.drives), *(one.name for one in scene.given), *multipliers]
    found |= {name: dynamicsymbols(name) for name in given}
    found |= {acceleration_name(one.name): found[one.name].diff(found[TIME]) for one in scene.states}
    found |= {coordinate: dynamicsymbols(coordinate) for coordinate in scene.coordinates}
    rates = {velocity_name(coordinate): found[coordinate].diff(found[TIME]) for coordinate in scene.coordinates}
    for velocity in scene.velocities:
        found[velocity] = rates[velocity] if velocity in rates else dynamicsymbols(velocity)
        found[acceleration_name(velocity)] = found[velocity].diff(found[TIME])
    return found
