"""Equations as a short Python program: after `from sympy import *` it defines symbols, coefficients and equations.

Names of the scene win: one that SymPy uses otherwise (I, E, S, N) becomes the symbol. Only what the text itself needs
(Eq, Rational, …) stays, and the variable of such a symbol takes an underscore: `Eq_ = symbols("Eq", real=True)`.

Lengths of struts are functions of what they depend on, `s_sf = Function("s_sf")(x, y)`, so that a derivative of what
holds them is none that is wrong; `.subs(sub).doit()` writes them out.

Matrices and symbols of SymPy, to substitute, simplify and lambdify, are

    M q̈ + C q̇ + g + k_E = τ + Gᵀ λ      c = C q̇
    r(q) = 0,  G q̇ = 0,  G q̈ + Ġ q̇ = 0        rows of loops and contacts
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from symdyn.algebra import Form, Number, Symbol
from symdyn.arguments import check_arguments
from symdyn.dynamics.mechanism import TIME, State
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.written_page import coefficient_name
from symdyn.errors import UnknownNameError
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name, choice, listed
from symdyn.shown import Shown
from symdyn.unlocked import cached_property

WORDS = ("symbols", "Eq", "Matrix", "Rational", "pi", "Function")
"""What the text takes from SymPy beside its functions."""

Names = Mapping[tuple[str, tuple[int, ...]], str]  # variable of a coefficient, by kind and indices


class _Variables:
    """The variables of the program: symbols first, then what is defined with them.

    Attributes:
        depending: names that are no symbols but functions of others, with what they stand for.
    """

    def __init__(self, scene: Scene, used: Iterable[str], depending: Mapping[str, Form] | None = None) -> None:
        """Name the symbols, those of the scene in its order, then the others."""
        from symdyn.algebra import NAMES

        order = [parameter.name for parameter in scene.parameters]
        order += [*scene.coordinates, *scene.velocities, *map(acceleration_name, scene.velocities)]
        self.depending = depending or {}
        hidden = [name for form in self.depending.values() for name in form.symbols]
        needed = dict.fromkeys([*(name for name in used if name not in self.depending), *hidden])
        self.positive = [parameter.name for parameter in scene.parameters if parameter.positive]
        self._taken = {*WORDS, *NAMES.values()}
        self.symbols: dict[str, str] = {}
        for name in [*(name for name in order if name in needed), *(name for name in needed if name not in order)]:
            self.symbols[name] = self.fresh(name)
        self.symbols |= {name: self.fresh(name) for name in self.depending}

    def fresh(self, name: str) -> str:
        """Return a variable called `name`, with underscores if that is taken."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def declarations(self) -> Iterator[str]:
        """Yield one line for real symbols, one for positive ones."""
        for assumption in ("positive", "real"):
            group = {
                name: v
                for name, v in self.symbols.items()
                if name not in self.depending and (name in self.positive) == (assumption == "positive")
            }
            if group:
                yield f'{", ".join(group.values())} = symbols("{" ".join(group)}", {assumption}=True)'
        for name, form in self.depending.items():
            of = ", ".join(self.symbols[x] for x in self.symbols if x in form.symbols)
            yield f'{self.symbols[name]} = Function("{name}", real=True)({of})'

    def substitution(self) -> Iterator[str]:
        """Yield the dictionary of what is written as a function."""
        if self.depending:
            pairs = (f"{self.symbols[name]}: {self.show(form)}" for name, form in self.depending.items())
            yield f"{self.fresh('sub')} = {{{', '.join(pairs)}}}"

    def show(self, form: Form) -> str:
        """Return a form as Python."""
        return _text(form.to_sympy(self.positive), self.symbols)


def sympy_page(page: Printable, group: str) -> str:
    """Return the equations as Python that runs after `from sympy import *`."""
    n, found = range(len(page.rows)), page.constraints
    forms = [page.left(i) for i in n] + [c.rate for row in page.rows for c in row] + [page.driving(i) for i in n]
    forms += [*found.positions(), *found.accelerations()]
    forms += [form for name, motion in page.motions for form in (Symbol(name), motion)]
    explicit = {name: page.lengths.explicit[name] for name, _ in page.definitions}
    variables = _Variables(page.scene, (name for form in forms for name in form.symbols), explicit)
    lines = [*variables.declarations(), *variables.substitution(), *LINES[group](page, variables)]
    lines += [
        f"{variables.fresh(f'motion_{name}')} = Eq({variables.symbols[name]}, {variables.show(form)})"
        for name, form in page.motions
    ]
    return "\n".join([*lines, *_constraints(page, variables)])


def sympy_definitions(scene: Scene, named: Sequence[tuple[str, Form]]) -> str:
    """Return `name = formula`, one a line, after the symbols."""
    variables = _Variables(scene, (name for _, form in named for name in form.symbols))
    lines = [f"{variables.fresh(name)} = {variables.show(form)}" for name, form in named]
    return "\n".join([*variables.declarations(), *lines])


def _equations(page: Printable, variables: _Variables) -> Iterator[str]:
    for i in range(len(page.rows)):
        sides = variables.show(page.left(i)), variables.show(page.driving(i))
        yield f"{variables.fresh(f'equation{i + 1}')} = Eq({', '.join(sides)})"


def _coefficients(page: Printable, variables: _Variables) -> Iterator[str]:
    yield from _named(page, variables, _names(page, variables))


def _textbook(page: Printable, variables: _Variables) -> Iterator[str]:
    """Yield the coefficients, and the equations with coefficients by name."""
    names = _names(page, variables)
    yield from _named(page, variables, names)
    for i, row in enumerate(page.rows):
        terms = ((names[c.kind, c.indices], c) for c in row if not c.vanishes)
        left = " + ".join(f"{name}*{variables.show(c.rate)}" if c.of else name for name, c in terms) or "0"
        yield f"{variables.fresh(f'equation{i + 1}')} = Eq({left}, {variables.show(page.driving(i))})"


def _names(page: Printable, variables: _Variables) -> Names:
    return {(c.kind, c.indices): variables.fresh(coefficient_name(c.kind, c.indices)) for c in page.coefficients}


def _named(page: Printable, variables: _Variables, names: Names) -> Iterator[str]:
    for c in page.written:
        yield f"{' = '.join(names[c.kind, place] for place in c.places)} = {variables.show(c.form)}"
    for zero in page.vanishing:
        yield f"{' = '.join(names[c.kind, c.indices] for c in zero)} = 0"


def _matrix(page: Printable, variables: _Variables) -> Iterator[str]:
    n = range(len(page.rows))
    rows = [[variables.show(c.form) for c in page.inertia(i)] for i in n]
    columns = {
        "qdd": [variables.show(c.rate) for c in page.inertia(0)],
        "c": [variables.show(page.coriolis(i)) for i in n],
        "g": [variables.show(page.gravity(i)) for i in n],
        "tau": [variables.show(right) for right in page.right],
    }
    shown = ",\n    ".join(f"[{', '.join(row)}]" for row in rows)
    M, names = variables.fresh("M"), [variables.fresh(name) for name in columns]
    yield f"{M} = Matrix([\n    {shown},\n])"
    yield from (f"{name} = Matrix([{', '.join(x)}])" for name, x in zip(names, columns.values(), strict=True))
    qdd, c, g, tau = names
    kept = page.constraints.rows
    if not kept:
        yield f"{variables.fresh('equation')} = Eq({M}*{qdd} + {c} + {g}, {tau})"
        return
    G, sizes = variables.fresh("G"), variables.fresh("multipliers")
    entries = ",\n    ".join(f"[{', '.join(map(variables.show, row.G))}]" for row in kept)
    yield f"{G} = Matrix([\n    {entries},\n])"
    yield f"{sizes} = Matrix([{', '.join(variables.symbols[row.multiplier] for row in kept)}])"
    yield f"{variables.fresh('equation')} = Eq({M}*{qdd} + {c} + {g}, {tau} + {G}.T*{sizes})"


def _constraints(page: Printable, variables: _Variables) -> Iterator[str]:
    """Yield what the multipliers are, and the rows that they keep."""
    found = page.constraints
    for row in found.rows:
        yield f"# {row.multiplier}: {row.text}{f', {row.unit}' if row.unit else ''}"
    if found.missing:
        yield f"# G has no closed form: {found.missing}"
    blocks = (("position", found.positions()), ("velocity", found.rates()), ("acceleration", found.accelerations()))
    for name, forms in blocks:
        for k, form in enumerate(forms, 1):
            yield f"{variables.fresh(f'{name}{k}')} = Eq({variables.show(form)}, 0)"


LINES = {"equations": _equations, "coefficients": _coefficients, "textbook": _textbook, "matrix": _matrix}


def _text(expression: Any, variables: Mapping[str, str]) -> str:
    """Return a SymPy expression as Python that gives it back exactly after `from sympy import *`.

    `variables` are the Python variables of its symbols, by name.
    """
    from sympy.printing.str import StrPrinter

    class Printer(StrPrinter):  # type: ignore[misc]
        def _print_Symbol(self, symbol: Any) -> str:
            return variables[symbol.name]

        def _print_Rational(self, number: Any) -> str:  # 1/3 alone would be a float
            return f"Rational({number.p}, {number.q})"

    return str(Printer({"order": "lex"}).doprint(expression))


HALF = Number(Fraction(1, 2))


@dataclass(frozen=True, eq=False)
class SympyEquations(Shown):
    """The equations of motion in SymPy: matrices immutable, numbers exact.

    Attributes:
        scene: the mechanism.
        symbols: what stands for each name: parameters, coordinates, velocities (q1_dot), accelerations (q1_ddot),
            drives, inputs, multipliers (lambda1), t, and lengths of struts (s_sf, s_sf_dot).
        q, qd, qdd: coordinates, velocities and accelerations, shape (n, 1); rad or m, and per s.
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
    K: Any
    P: Any
    sub: Mapping[Any, Any] = field(default_factory=dict)
    unsimplified: str = ""

    def __repr__(self) -> str:
        rows = ", G, multipliers, bias, residual" if self.G.rows else ""
        coordinates = listed(self.scene.coordinates)
        return f"<SympyEquations of {self.scene.name}: M, C, c, g, k_E, tau{rows}, K and P in {coordinates}>"

    def __getitem__(self, name: str) -> Any:
        """Return what stands for a name; UnknownNameError if there is none, with those that there are."""
        check_arguments(SympyEquations.__getitem__, locals(), UnknownNameError)
        if name not in self.symbols:
            raise UnknownNameError(f"there is no {name!r}; {choice(name, self.symbols)}")
        return self.symbols[name]

    @cached_property
    def values(self) -> dict[Any, Any]:
        """Values of parameters, exact, as `subs` takes them; parameters without a value are left out.

        >>> import symdyn
        >>> arm = symdyn.equations(symdyn.example("four_bar")).sympy()
        >>> arm.M.subs(arm.values)[2, 2]
        343/24
        """
        from symdyn.algebra import graph_to_sympy

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


def sympy_equations(page: Printable, dynamic: bool = False) -> SympyEquations:
    """Return what a page says in SymPy; with `dynamic` what moves is a function of time."""
    from sympy import ImmutableMatrix

    from symdyn.algebra import graph_to_sympy

    scene, rows, n = page.scene, page.constraints.rows, range(len(page.rows))
    positive = [one.name for one in scene.parameters if one.positive]
    rates, accelerations = scene.velocities, [acceleration_name(u) for u in scene.velocities]
    sizes = [row.multiplier for row in rows]
    names = [*(one.name for one in scene.parameters), *scene.coordinates, *rates, *accelerations]
    names += [*filter(None, scene.drives), *(one.name for one in scene.inputs), *sizes, TIME]
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

    kept = _as_derived(scene) if page.constraints.missing else [(row.G, row.bias, row.residual) for row in rows]
    return SympyEquations(
        scene=scene,
        symbols=symbols,
        q=column(map(Symbol, scene.coordinates)),
        qd=column(map(Symbol, rates)),
        qdd=column(map(Symbol, accelerations)),
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
        K=write(page.K),
        P=write(page.P),
        sub={function: write(page.lengths.explicit[name]) for name, function in functions.items()},
        unsimplified=page.constraints.missing,
    )


def _christoffel(page: Printable, i: int) -> list[Form]:
    """Return row i of C: k_D,ij q̇_j + Σ_k k_C,i,jk q̇_k / 2, half of each product of two velocities to either one."""
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
    return [Form.sum(some) for some in terms]


def _as_derived(scene: Scene) -> list[tuple[tuple[Expr, ...], Expr, Expr | None]]:
    """Return G, Ġ u and residual of the rows of a scene, for those without a closed form."""
    from symdyn.dynamics import Workspace  # trees need none
    from symdyn.dynamics.loops import differentiated

    graph = Graph()
    found = differentiated(scene, graph, State.of(scene, graph))
    return [
        (found.G[k], found.bias[k], found.residual[k] if found.labels[k].holonomic else None)
        for k in Workspace(scene).loops.decisions.independent_rows
    ]


def _functions(page: Printable, plain: Mapping[str, Any], moved: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the lengths of struts and their rates as functions of what they depend on, so that these move them."""
    from sympy import Function

    used = page.lengths.used((*page.forms, page.P))
    found = {}
    for name, _ in used:
        needed = set(page.lengths.explicit[name].symbols)
        arguments = [plain[one].xreplace(moved) for one in plain if one in needed]
        found[name] = Function(name, real=True)(*arguments)
    return found


def _in_time(scene: Scene, multipliers: Sequence[str]) -> dict[str, Any]:
    """Return what moves and what drives it as SymPy's `dynamicsymbols`, velocities as derivatives, and its t."""
    from sympy.physics.vector import dynamicsymbols

    found = {TIME: dynamicsymbols._t}
    given = [*filter(None, scene.drives), *(one.name for one in scene.inputs), *multipliers]
    found |= {name: dynamicsymbols(name) for name in given}
    for coordinate, velocity in zip(scene.coordinates, scene.velocities, strict=True):
        found[coordinate] = dynamicsymbols(coordinate)
        found[velocity] = found[coordinate].diff(found[TIME])
        found[acceleration_name(velocity)] = found[velocity].diff(found[TIME])
    return found
