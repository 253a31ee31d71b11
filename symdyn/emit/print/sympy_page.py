"""Equations as a short Python program: after `from sympy import *` it defines symbols, coefficients and equations.

Names of the scene win: one that SymPy uses otherwise (I, E, S, N) becomes the symbol. Only what the text itself needs
(Eq, Rational, …) stays, and the variable of such a symbol takes an underscore: `Eq_ = symbols("Eq", real=True)`.

Lengths of struts are functions of what they depend on, `s_sf = Function("s_sf")(x, y)`, so that a derivative of what
holds them is none that is wrong; `.subs(sub).doit()` writes them out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from symdyn.algebra import Form, Symbol
from symdyn.emit.print.formula_text import text_of
from symdyn.emit.print.printable import Printable
from symdyn.emit.print.written_page import coefficient_name
from symdyn.scene import Scene
from symdyn.scene.values import acceleration_name

WORDS = ("symbols", "Eq", "Matrix", "Rational", "pi", "Function")
"""What the text takes from SymPy beside its functions."""

Names = Mapping[tuple[str, tuple[int, ...]], str]  # variable of a coefficient, by kind and indices


class _Variables:
    """The variables of the program: symbols first, then what is defined with them, `depending` on others."""

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
        return _text(form.to_sympy(self.positive), self.symbols)


def sympy_page(page: Printable, group: str) -> str:
    """Return the equations as Python that runs after `from sympy import *`."""
    n, found = range(len(page.rows)), page.constraints
    forms = [page.left(i) for i in n] + [c.rate for row in page.rows for c in row] + [page.driving(i) for i in n]
    forms += [*found.positions(), *found.accelerations()]
    forms += [form for name, motion in page.beside for form in (Symbol(name), motion)]
    explicit = {name: page.lengths.explicit[name] for name, _ in page.definitions}
    variables = _Variables(page.scene, (name for form in forms for name in form.symbols), explicit)
    lines = [*variables.declarations(), *variables.substitution(), *LINES[group](page, variables)]
    lines += [
        f"{variables.fresh(f'{kind}_{name}')} = Eq({variables.symbols[name]}, {variables.show(form)})"
        for kind, some in (("motion", page.motions), ("rate", page.rates))
        for name, form in some
    ]
    short = (f"# {one}" for one in page.shorthands(text_of))
    return "\n".join([*lines, *_constraints(page, variables), *short])


def sympy_definitions(scene: Scene, named: Sequence[tuple[str, Form]]) -> str:
    """Return `name = formula`, one a line, after the symbols."""
    variables = _Variables(scene, (name for _, form in named for name in form.symbols))
    lines = [f"{variables.fresh(name)} = {variables.show(form)}" for name, form in named]
    return "\n".join([*variables.declarations(), *lines])


def sympy_rows(scene: Scene, rows: Sequence[tuple[str, str, Form]]) -> str:
    """Return equations as Python, each by a key, its left side (a name, its square "p**2", or 0) and the right one."""
    left = [(name.removesuffix("**2"), "**2" * name.endswith("**2")) for _, name, _ in rows]
    left = [(name.replace("*", "_star"), square) for name, square in left]
    used = [*(x for *_, form in rows for x in form.symbols), *(name for name, _ in left if name != "0")]
    variables, count = _Variables(scene, used), Counter[str]()
    lines = [*variables.declarations()]
    for (key, _, form), (name, square) in zip(rows, left, strict=True):
        count[key] += 1
        side = f"{variables.symbols.get(name, name)}{square}"
        lines.append(f"{variables.fresh(f'{key}{count[key]}')} = Eq({side}, {variables.show(form)})")
    return "\n".join(lines)


def _equations(page: Printable, variables: _Variables) -> Iterator[str]:
    for i in range(len(page.rows)):
        sides = variables.show(page.left(i)), variables.show(page.driving(i))
        yield f"{variables.fresh(f'equation{i + 1}')} = Eq({', '.join(sides)})"


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


LINES = {
    "equations": _equations,
    "coefficients": lambda page, variables: _named(page, variables, _names(page, variables)),
    "textbook": _textbook,
    "matrix": _matrix,
}


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
