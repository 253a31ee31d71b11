"""What a page of equations says, before it is spelled in LaTeX, plain text or SymPy.

    k_z,ij q̈_j + k_C,i,jk q̇_j q̇_k + k_D,ij q̇_j² + k_G,i + k_E,i = drive + Q_i + G_ki λ_k    sums over j, j < k, k

The coefficients carry their own sign (the textbook's (5.40) pulls the minus of k_C and k_D in front).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

from symdyn.algebra.form import Form, Power, Symbol, form_of, product_of, signed_product, sum_of, terms_of
from symdyn.dynamics.closed_forms.closed_form import ClosedForm, closed_form, coefficient_form, coefficient_names
from symdyn.dynamics.closed_forms.coefficient_key import MOST_TERMS, Key, too_long
from symdyn.emit.print.formula_text import rounded, shortened
from symdyn.emit.print.printed_constraints import PrintedConstraints, printed_constraints
from symdyn.graph import Graph
from symdyn.scene import Scene, acceleration_name, express
from symdyn.scene.units import coordinate_units

KINDS = ("k_z", "k_C", "k_D", "k_G", "k_E")

ALONE = ("k_G", "k_E")
"""Kinds that multiply no rate."""


@dataclass(frozen=True)
class Coefficient:
    """One coefficient.

    Attributes:
        kind: "k_z", "k_C", "k_D", "k_G" or "k_E".
        indices: from 1: (i, j), (i, j, k), (i, j) or (i,).
        form: its value.
        rate: what it multiplies: q̈_j, q̇_j q̇_k, q̇_j² or 1.
    """

    kind: str
    indices: tuple[int, ...]
    form: Form
    rate: Form

    @property
    def vanishes(self) -> bool:
        """Whether it is identically zero."""
        return not terms_of(self.form)

    @property
    def term(self) -> Form:
        """The product of form and rate; a sum of negative terms takes its sign in front."""
        return signed_product(self.form, self.rate)


@dataclass(frozen=True)
class Printable:
    """All that a page about a scene says, before it is spelled.

    Attributes:
        scene: the mechanism.
        rows: for each joint its coefficients, those that vanish included: k_z, k_C, k_D, k_G, k_E.
        right: for each joint drive + Q, the right-hand side but for what loops and contacts carry.
        constraints: rows of loops and contacts, with their multipliers.
        motions: coordinates whose motion is prescribed, with their formulas in time.
        K, P: the energies.
        short: whether s12 stands for sin(q1 + q2).
    """

    scene: Scene
    rows: tuple[tuple[Coefficient, ...], ...]
    right: tuple[Form, ...]
    constraints: PrintedConstraints
    motions: tuple[tuple[str, Form], ...]
    K: Form
    P: Form
    short: bool

    @property
    def coefficients(self) -> list[Coefficient]:
        """All coefficients: k_z row by row, then k_C, k_D, k_G, k_E."""
        return [c for kind in KINDS for row in self.rows for c in row if c.kind == kind]

    def left(self, joint: int) -> Form:
        """Return the left-hand side of one equation."""
        return sum_of(c.term for c in self.rows[joint] if not c.vanishes)

    def driving(self, joint: int) -> Form:
        """Return the right-hand side of one equation: drive + Q + Gᵀ λ."""
        return sum_of((self.right[joint], self.constraints.carried(joint)))


def printable(scene: Scene | ClosedForm, short: bool = False, digits: int | None = None) -> Printable:
    """Return what is to be printed; `digits` are the most that a number has, None leaves them exact."""
    closed = scene if isinstance(scene, ClosedForm) else closed_form(scene)
    scene = closed.scene
    names = {parameter.name for parameter in scene.parameters} | set(scene.coordinates)
    names |= {drive for drive in scene.drives if drive}
    units = coordinate_units(scene)
    numbers = {q: i for i, (q, unit) in enumerate(zip(scene.coordinates, units, strict=True), 1) if unit == "rad"}

    def spelled(form: Form) -> Form:
        form = shortened(form, numbers, names) if short else form
        return form if digits is None else rounded(form, digits)

    def write(key: Key) -> Form:
        return spelled(coefficient_form(closed, key))

    keys = coefficient_names(closed)
    if (terms := sum(len(closed[key]) for key in keys if key[0] != "k_E")) > MOST_TERMS:
        one = "; symdyn.closed_form(scene).sympy('k_z', 0, 0) gives a single coefficient in Python"
        raise too_long(scene, f"its coefficients have {terms} terms", one)
    rates = _rates(closed)
    rows: list[list[Coefficient]] = [[] for _ in scene.velocities]
    for key in keys:
        rows[key[1]].append(_coefficient(key, write(key), rates[key[0]]))
    right = tuple(map(spelled, _right_hand_sides(closed)))
    constraints = printed_constraints(scene, spelled, names | set(scene.velocities))
    graph = Graph()
    motions = [(j.coordinate, form_of(express(j.motion, graph))) for j in scene.moving if j.motion is not None]
    K, P = write(("K",)), write(("P",))
    return Printable(scene, tuple(map(tuple, rows)), right, constraints, tuple(motions), K, P, short)


Rates = list[tuple[tuple[int, ...], Form]]  # indices from 1 and what the coefficient multiplies


def _rates(closed: ClosedForm) -> dict[str, Rates]:
    """Return what the coefficients of a row multiply, by kind."""
    qd = [Symbol(str(rate.value)) for rate in closed.state.qd]
    n = range(closed.n)
    return {
        "k_z": [((j + 1,), Symbol(acceleration_name(u))) for j, u in enumerate(closed.scene.velocities)],
        "k_C": [((j + 1, k + 1), product_of((qd[j], qd[k]))) for j, k in combinations(n, 2)],
        "k_D": [((j + 1,), Power(qd[j], 2)) for j in n],
        "k_G": [((), product_of(()))],
        "k_E": [((), product_of(()))],
    }


def _coefficient(key: Key, form: Form, rates: Rates) -> Coefficient:
    kind, i, *place = key
    indices, rate = rates[place[0] if place else 0]
    return Coefficient(kind, (i + 1, *indices), form, rate)


def _right_hand_sides(closed: ClosedForm) -> tuple[Form, ...]:
    """Return drive + Q of every coordinate; Q holds declared forces, damping, friction and loads."""
    drives = [[Symbol(drive)] if drive else [] for drive in closed.scene.drives]
    acting = closed.loads.acting(closed.compactor)
    return tuple(sum_of([*drive, force]) for drive, force in zip(drives, acting, strict=True))


def coriolis(page: Printable, joint: int) -> Form:
    """Return c_i = Σ k_C q̇_j q̇_k + Σ k_D q̇_j² of one joint."""
    return sum_of(c.term for c in page.rows[joint] if c.kind in ("k_C", "k_D") and not c.vanishes)


def gravity(page: Printable, joint: int) -> Form:
    """Return g_i = k_G,i + k_E,i of one joint."""
    return sum_of(c.form for c in page.rows[joint] if c.kind in ALONE)
