"""What a page of equations says, before it is spelled in LaTeX, plain text or SymPy.

    k_z,ij q̈_j + k_C,i,jk q̇_j q̇_k + k_D,ij q̇_j² + k_G,i + k_E,i = drive + Q_i + G_ki λ_k    sums over j, j < k, k

    r(q) = 0,  G u = 0,  G u̇ + Ġ u = 0        rows of loops and contacts; λ_k is the size of wrench k on the child

The coefficients carry their own sign (the textbook's (5.40) pulls the minus of k_C and k_D in front).

Lengths of struts between points, and their rates, stand by name in equations and are defined below them. A spring sf
and a damper df between the same points share the length s_sf and the rate s_sf_dot. The letter is one that no symbol of
the scene has with such an index; of two struts that are called alike the second adds its kind.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from symdyn.algebra import Form, Power, Symbol
from symdyn.dynamics import ClosedForm, closed_form, coefficients
from symdyn.dynamics.mechanism import TIME, State
from symdyn.emit.print.breaking import DIGITS
from symdyn.emit.print.formula_text import Latex, in_sines, rounded, shorthands
from symdyn.emit.print.printed_names import Letters, coefficient_index, latex_symbols
from symdyn.frozen import dataclass, replace
from symdyn.graph import Graph
from symdyn.rounding import digits_or
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Strut, acceleration_name, velocity_name
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.dynamics import ClosedRow


@dataclass(frozen=True)
class NamedLength:
    """The distance of two points that struts pull along.

    Attributes:
        struts: those between them, in the scene's order.
        index: what stands below its letter, part by part.
        name, rate: what it and its rate are called in code.
        form: the distance, m.
        rate_form: its rate, m/s; the distance in it by its name.
    """

    struts: tuple[Strut, ...]
    index: tuple[str, ...]
    name: str
    rate: str
    form: Form
    rate_form: Form

    @property
    def defined(self) -> tuple[tuple[str, Form], tuple[str, Form]]:
        """Both names with what they stand for."""
        return (self.name, self.form), (self.rate, self.rate_form)

    @property
    def text(self) -> str:
        """What it is, in words, such as "distance of the ends of spring sf and damper df"."""
        what = "length along" if self.struts[0].is_rope else "distance of the ends of"
        return f"{what} {' and '.join(one.text or f'{one.kind} {one.name}' for one in self.struts)}"


@dataclass(frozen=True)
class Lengths:
    """The lengths of a scene."""

    named: tuple[NamedLength, ...] = ()

    @property
    def names(self) -> dict[Strut, tuple[str, str]]:
        return {strut: (one.name, one.rate) for one in self.named for strut in one.struts}

    def used(self, forms: Iterable[Form]) -> list[tuple[str, Form]]:
        """Return names with what they stand for, those that stand in forms and those that stand in these."""
        found = {name for form in forms for name in form.symbols}
        found |= {one.name for one in self.named if one.rate in found}
        return [(name, form) for one in self.named for name, form in one.defined if name in found]

    @cached_property
    def explicit(self) -> dict[str, Form]:
        """What every name stands for, in coordinates and velocities alone."""
        ways = {one.name: one.form for one in self.named}
        return ways | {one.rate: one.rate_form.substitute(ways) for one in self.named}

    def written_out(self, form: Form) -> Form:
        """Return a form in coordinates and velocities alone."""
        return form.substitute(self.explicit) if self.named else form


def named_lengths(
    closed: ClosedForm, taken: Iterable[str], spelled: Callable[[Form], Form], prefix: str = ""
) -> Lengths:
    """Return the lengths of a scene.

    Args:
        closed: the mechanism, with what acts on it.
        taken: names that stand for something else.
        spelled: what is done to every form that is printed.
        prefix: what all names begin with.
    """
    scene, loads, compact = closed.scene, closed.loads, closed.compactor
    found: list[NamedLength] = []
    for struts, index, name in called(scene, loads.alongside(), taken):
        names = (f"{prefix}{name}", velocity_name(f"{prefix}{name}"))
        loads = loads.named({**loads.names, **dict.fromkeys(struts, names)})
        forms = (spelled(loads.length(struts[0], compact)), spelled(loads.rate(struts[0], compact)))
        found.append(NamedLength(struts, index, *names, *forms))
    return Lengths(tuple(found))


def called(
    scene: Scene, together: Iterable[Sequence[Strut]], taken: Iterable[str]
) -> Iterator[tuple[tuple[Strut, ...], tuple[str, ...], str]]:
    """Yield struts that share a length, what stands below its letter, and its name, which is none that is taken."""
    used, letter = set(taken), Letters(scene)[Letters.LENGTH]
    first: set[str] = set()
    for struts in together:
        one = struts[0]
        index = (*([one.kind] if one.name in first else []), *one.name.split("_"))
        first.add(one.name)
        name = "_".join((letter if letter.isalpha() and letter != Letters.LENGTH else "s", *index))
        while used & {name, velocity_name(name)}:
            name += "_"
        used |= {name, velocity_name(name)}
        yield tuple(struts), index, name


ENTRYWISE = {"equations": False, "coefficients": True, "textbook": False, "matrix": True}
"""How equations are grouped: one a joint, coefficient by coefficient, under-braced, M and c; and whether loops and rows
are then written entry by entry."""


@dataclass(frozen=True)
class Coefficient:
    """One coefficient."""

    kind: str  # its output, such as "k_z"
    indices: tuple[int, ...]  # from 1: of the row, then those of what it multiplies
    form: Form  # its value
    rate: Form  # what it multiplies: q̈_j, q̇_j q̇_k, q̇_j² or 1
    of: str = ""  # "qdd" where that is an acceleration, "qd" where it is velocities; "" where it is nothing

    @property
    def vanishes(self) -> bool:
        return not self.form.terms

    @property
    def term(self) -> Form:
        """The product of form and rate; a sum of negative terms takes its sign in front."""
        return self.form.signed_product(self.rate)

    @property
    def places(self) -> list[tuple[int, ...]]:
        """Indices of all that are the same one: M is symmetric."""
        return list(dict.fromkeys((self.indices, self.indices[::-1]))) if self.of == "qdd" else [self.indices]

    @property
    def names(self) -> list[str]:
        """Its names in LaTeX, one a place: k_{z,12} and k_{z,21}; k_{C,1,23}; k_{D,12}; k_{G,1}."""
        return [f"k_{{{coefficient_index(self.kind, place)}}}" for place in self.places]


@dataclass(frozen=True)
class PrintedRow:
    """One row of G."""

    multiplier: str  # its name
    text: str  # what the multiplier is, in words; "of" what it belongs to included
    unit: str  # N or N m; of a row of the scene what its formula tells, "" where that is nothing
    G: tuple[Form, ...]  # entries by velocity; where there is no closed form names, and zero where an entry vanishes
    residual: Form | None  # what vanishes where the loop is closed; None where nothing does
    bias: Form | None  # Ġ u; None without a closed form


@dataclass(frozen=True)
class PrintedConstraints:
    """All rows of a scene; none for a tree."""

    rows: tuple[PrintedRow, ...]  # one a multiplier
    velocities: tuple[str, ...]  # names of the velocities
    missing: str = ""  # why there is no closed form, one line; "" if there is one

    @property
    def units(self) -> dict[str, str]:
        """Units of multipliers, and "" of names for entries without a closed form."""
        letters = [name for row in self.rows for x in row.G for name in x.symbols if self.missing]
        return {row.multiplier: row.unit for row in self.rows} | dict.fromkeys(letters, "")

    def carried(self, i: int) -> Form:
        """Return Σ_k G_ki λ_k, the generalized force of the constraints on velocity i."""
        return Form.sum(row.G[i].signed_product(Symbol(row.multiplier)) for row in self.rows)

    def positions(self) -> list[Form]:
        """Return r(q), rows without one left out."""
        return [row.residual for row in self.rows if row.residual is not None]

    def rates(self) -> list[Form]:
        """Return G u."""
        return [self._along(row, self.velocities) for row in self.rows if row.bias is not None]

    def accelerations(self) -> list[Form]:
        """Return G u̇ + Ġ u."""
        names = [acceleration_name(u) for u in self.velocities]
        return [Form.sum((self._along(row, names), row.bias)) for row in self.rows if row.bias is not None]

    def _along(self, row: PrintedRow, names: Sequence[str]) -> Form:
        return Form.sum(entry.signed_product(Symbol(name)) for entry, name in zip(row.G, names, strict=True))


@dataclass(frozen=True)
class Printable:
    """All that a page about a scene says, before it is spelled.

    Attributes:
        scene: the mechanism.
        rows: for each joint its coefficients, those that vanish included: k_z, k_C, k_D, k_G, k_E.
        right: for each joint drive + Q, the right-hand side but for what loops and contacts carry.
        constraints: rows of loops and contacts, with their multipliers.
        motions: coordinates whose motion is prescribed, with their formulas in time.
        rates: of coordinates that no velocity is the rate of, and of states of one's own, by name.
        K, P: the energies.
        E: the share of struts in P.
        lengths: of struts between points, which stand in all of these by their names.
        short: what stands for sines and cosines by joint number, with these: s12, sin(q1 + q2).
    """

    scene: Scene
    rows: tuple[tuple[Coefficient, ...], ...]
    right: tuple[Form, ...]
    constraints: PrintedConstraints
    motions: tuple[tuple[str, Form], ...]
    rates: tuple[tuple[str, Form], ...]
    K: Form
    P: Form
    E: Form
    lengths: Lengths
    short: tuple[tuple[str, Form], ...] = ()

    @classmethod
    def of(
        cls, scene: Scene | ClosedForm, short: Sequence[str] = (), digits: int | None = None, lengths: str | None = ""
    ) -> Printable:
        """Return what is to be printed.

        Args:
            scene: the mechanism, or its closed forms.
            short: pairs of letters for s12 and c2, of which the first that is free is taken; without, sin(q1 + q2).
            digits: the most that a number has; None leaves them exact.
            lengths: what the names of lengths of struts begin with; None writes all lengths out.
        """
        closed = scene if isinstance(scene, ClosedForm) else closed_form(scene)
        scene = closed.scene
        names = {parameter.name for parameter in scene.parameters} | set(scene.coordinates)
        names |= {given.name for given in scene.given}
        names |= {drive for drive in scene.drives if drive}
        units = SceneUnits(scene).coordinates
        numbers = {q: i for i, (q, unit) in enumerate(zip(scene.coordinates, units, strict=True), 1) if unit == "rad"}

        letters, known = Letters(scene).circular(short), dict[Form, Symbol]()

        def spelled(form: Form) -> Form:
            if letters:
                known.update(shorthands(form, numbers, letters))
                form = form.exchanged(known)
            return form if digits is None else rounded(form, digits)

        moving = {*scene.velocities, *map(acceleration_name, scene.velocities), TIME}
        found = named_lengths(closed, names | moving, spelled, lengths or "")
        if found.named and lengths is not None:
            closed = replace(closed, loads=closed.loads.named(found.names))
        names |= {name for one in found.named for name, _ in one.defined}

        def write(*key: Any) -> Form:
            return spelled(closed.form(*key))

        closed.refuse_too_long("; symdyn.closed_form(scene).sympy('k_z', 0, 0) gives a single coefficient in Python")
        keys = closed.coefficient_names()
        rows: list[list[Coefficient]] = [[] for _ in scene.velocities]
        columns = coefficients(closed.n)
        for kind, i, *place in keys:
            rates = columns[kind][place[0] if place else 0]
            indices = (i + 1, *dict.fromkeys(j + 1 for _, j in rates))
            form = write(kind, i, *place)
            rows[i].append(Coefficient(kind, indices, form, _rate(scene, rates), rates[0][0] if rates else ""))
        drives = [[Symbol(drive)] if drive else [] for drive in closed.scene.drives]
        acting = closed.loads.acting(closed.compactor)  # declared forces, damping, friction and loads
        right = tuple(spelled(Form.sum([*drive, force])) for drive, force in zip(drives, acting, strict=True))
        constraints = _constraints(scene, spelled, names | set(scene.velocities))
        graph = Graph()
        motions = [(j.coordinate, Form.of(j.motion.express(graph))) for j in scene.moving if j.motion is not None]
        moved = [(name, spelled(form)) for name, form in other_rates(scene)]
        K, P, E = write("K"), write("P"), spelled(closed.loads.energy(closed.compactor))
        beside = tuple(motions), tuple(moved)
        named = tuple(sorted(((x.name, form) for form, x in known.items()), key=lambda one: (len(one[0]), one[0])))
        return cls(scene, tuple(map(tuple, rows)), right, constraints, *beside, K, P, E, found, named)

    @property
    def beside(self) -> tuple[tuple[str, Form], ...]:
        """What stands beside the equations: prescribed motions, and rates of what no velocity is the rate of."""
        return (*self.motions, *self.rates)

    @property
    def forms(self) -> list[Form]:
        """All coefficients and right-hand sides."""
        return [*(c.form for row in self.rows for c in row), *self.right]

    @property
    def definitions(self) -> list[tuple[str, Form]]:
        """What names in the equations stand for that are no symbols of the scene."""
        return self.lengths.used(self.forms)

    def shorthands(self, write: Callable[[Form], str], *beside: Form) -> list[str]:
        """Return s12 = sin(q1 + q2), of every shorthand that stands in the equations, or in forms beside them."""
        rows = [x for row in self.constraints.rows for x in (*row.G, row.residual, row.bias) if x is not None]
        shown = [*self.forms, *rows, *beside, *(form for _, form in (*self.definitions, *self.beside))]
        used = {name for form in shown for name in form.symbols}
        return [f"{write(Symbol(name))} = {write(form)}" for name, form in self.short if name in used]

    @property
    def coefficients(self) -> list[Coefficient]:
        """All coefficients, kind by kind: k_z row by row, then k_C, k_D, k_G, k_E."""
        kinds = list(dict.fromkeys(c.kind for row in self.rows for c in row))
        return sorted((c for row in self.rows for c in row), key=lambda c: kinds.index(c.kind))

    @property
    def written(self) -> list[Coefficient]:
        """Those that are written out: none that vanishes, of two that are the same one the first."""
        return [c for c in self.coefficients if not c.vanishes and c.indices == min(c.places)]

    @property
    def vanishing(self) -> list[list[Coefficient]]:
        zero = [c for c in self.coefficients if c.vanishes]
        return [[c for c in zero if c.kind == kind] for kind in dict.fromkeys(c.kind for c in zero)]

    def inertia(self, joint: int) -> list[Coefficient]:
        """Return row i of M."""
        return [c for c in self.rows[joint] if c.of == "qdd"]

    def coriolis(self, joint: int) -> Form:
        """Return c_i = Σ k_C q̇_j q̇_k + Σ k_D q̇_j² of one joint."""
        return Form.sum(c.term for c in self.rows[joint] if c.of == "qd" and not c.vanishes)

    def gravity(self, joint: int) -> Form:
        """Return g_i = k_G,i + k_E,i of one joint."""
        return Form.sum(c.form for c in self.rows[joint] if not c.of)

    def left(self, joint: int) -> Form:
        """Return the left-hand side of one equation."""
        return Form.sum(c.term for c in self.rows[joint] if not c.vanishes)

    def driving(self, joint: int) -> Form:
        """Return the right-hand side of one equation: drive + Q + Gᵀ λ."""
        return Form.sum((self.right[joint], self.constraints.carried(joint)))

    def writer(self) -> Latex:
        """Return what writes the forms of this page.

        It knows the names of the scene, of multipliers, of rows without a closed form and of lengths.
        """
        others, lengths = list(self.constraints.units), [one.name for one in self.lengths.named]
        return Latex(latex_symbols(self.scene, others, lengths) | {TIME: TIME}, digits_or(DIGITS))


def other_rates(scene: Scene) -> list[tuple[str, Form]]:
    """Return the rates of coordinates that are no velocities, those of quaternions, and of states, by name."""
    own = Graph()  # symbols in the order in which the formulas name them
    states = [(acceleration_name(one.name), Form.of(one.rate.express(own))) for one in scene.states]
    state = State.of(scene, Graph())
    others = [(q, rate) for q, rate in zip(scene.coordinates, state.rates, strict=True) if rate not in state.qd]
    write = in_sines([rate for _, rate in others], state, ())
    turned = [(velocity_name(q), write(rate)) for q, rate in others]
    return turned + states


def _rate(scene: Scene, rates: Sequence[tuple[str, int]]) -> Form:
    names = [scene.velocities[j] if of == "qd" else acceleration_name(scene.velocities[j]) for of, j in rates]
    return Power(Symbol(names[0]), 2) if len(set(names)) < len(names) else Form.product(map(Symbol, names))


def _constraints(scene: Scene, write: Callable[[Form], Form], taken: Container[str]) -> PrintedConstraints:
    """Return the rows of a scene, every form as `write` makes it; names that are `taken` stand for something else."""
    if not scene.is_constrained:
        return PrintedConstraints((), scene.velocities)
    from symdyn.dynamics import closed_constraints

    found = closed_constraints(scene)
    rows = tuple(_row(scene, k, row, write, taken) for k, row in enumerate(found.rows, 1))
    return PrintedConstraints(rows, scene.velocities, found.missing)


def _row(scene: Scene, k: int, row: ClosedRow, write: Callable[[Form], Form], taken: Container[str]) -> PrintedRow:
    told = "" if row.loop else SceneUnits(scene).constraints.get(row.owner, "")
    unit = scene.shown_unit("N" if "force" in row.words else "N m" if "moment" in row.words else told)
    name, text = _fresh(f"lambda{k}", taken), _text(scene, row)
    if not row.G:
        entries = (Symbol(_fresh(f"G{k}_{i}", taken)) if used else Form.sum(()) for i, used in enumerate(row.uses, 1))
        return PrintedRow(name, text, unit, tuple(entries), None, None)
    residual = write(row.residual) if row.holonomic and row.residual is not None else None
    rates = [Symbol(u) for u in scene.velocities]
    bias = Form.sum(
        write(form).signed_product(Power(rates[j], 2) if j == k else Form.product((rates[j], rates[k])))
        for j, k, form in row.bias
    )
    return PrintedRow(name, text, unit, tuple(map(write, row.G)), residual, bias)


def _text(scene: Scene, row: ClosedRow) -> str:
    """Return what a multiplier is, such as "force along x of loop hinge, exerted by coupler on rocker"."""
    if not row.loop:
        one = next((one for one in scene.contacts if one.name == row.owner), None)
        if one is None:
            return f"tension of rope {row.owner}" if row.words == "tension" else f"of row {row.owner}"
        return f"{row.words} of contact {row.owner}, exerted by {one.plane.body} on {one.place.body}"
    loop = next(joint for joint in scene.loops if joint.name == row.owner)
    return f"{row.words} of loop {row.owner}, exerted by {loop.parent} on {loop.child}"


def _fresh(name: str, taken: Container[str]) -> str:
    """Return a name, with underscores if it stands for something else."""
    while name in taken:
        name += "_"
    return name
