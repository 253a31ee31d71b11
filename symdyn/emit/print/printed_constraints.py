"""Loops and contacts in print: the multipliers, their generalized forces Gᵀ λ, and the rows that they keep.

M u̇ + h = τ + Gᵀ λ        r(q) = 0,  G u = 0,  G u̇ + Ġ u = 0        λ_k is the size of wrench k on the child
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass

from symdyn.algebra.form import Form, Power, Symbol, product_of, signed_product, sum_of
from symdyn.dynamics.closed_forms.constraint_forms import ClosedRow, closed_constraints
from symdyn.scene import Scene, acceleration_name


@dataclass(frozen=True)
class PrintedRow:
    """One row of G.

    Attributes:
        multiplier: its name.
        text: what the multiplier is, in words; "of" what it belongs to included.
        unit: N or N m; "" for a row of the user.
        G: entries by velocity; where there is no closed form names, and zero where an entry vanishes.
        residual: what vanishes where the loop is closed; None where nothing does.
        bias: Ġ u; None without a closed form.
    """

    multiplier: str
    text: str
    unit: str
    G: tuple[Form, ...]
    residual: Form | None
    bias: Form | None


@dataclass(frozen=True)
class PrintedConstraints:
    """All rows of a scene; none for a tree.

    Attributes:
        rows: one a multiplier.
        velocities: names of the velocities.
        missing: why there is no closed form, one line; "" if there is one.
    """

    rows: tuple[PrintedRow, ...]
    velocities: tuple[str, ...]
    missing: str = ""

    def carried(self, i: int) -> Form:
        """Return Σ_k G_ki λ_k, the generalized force of the constraints on velocity i."""
        return sum_of(signed_product(row.G[i], Symbol(row.multiplier)) for row in self.rows)

    def positions(self) -> list[Form]:
        """Return r(q), rows without one left out."""
        return [row.residual for row in self.rows if row.residual is not None]

    def rates(self) -> list[Form]:
        """Return G u."""
        return [self._along(row, self.velocities) for row in self.rows if row.bias is not None]

    def accelerations(self) -> list[Form]:
        """Return G u̇ + Ġ u."""
        names = [acceleration_name(u) for u in self.velocities]
        return [sum_of((self._along(row, names), row.bias)) for row in self.rows if row.bias is not None]

    def _along(self, row: PrintedRow, names: tuple[str, ...] | list[str]) -> Form:
        return sum_of(signed_product(entry, Symbol(name)) for entry, name in zip(row.G, names, strict=True))


def printed_constraints(scene: Scene, write: Callable[[Form], Form], taken: Container[str]) -> PrintedConstraints:
    """Return the rows of a scene.

    Args:
        scene: the mechanism.
        write: what happens to every form, such as short notation.
        taken: names that stand for something else.

    Raises:
        DerivationError: the loops cannot be assembled, so that nobody knows which rows are independent.
    """
    if not scene.is_closed:
        return PrintedConstraints((), scene.velocities)
    found = closed_constraints(scene)
    rows = tuple(_row(scene, k, row, write, taken) for k, row in enumerate(found.rows, 1))
    return PrintedConstraints(rows, scene.velocities, found.missing)


def _row(scene: Scene, k: int, row: ClosedRow, write: Callable[[Form], Form], taken: Container[str]) -> PrintedRow:
    unit = "N" if "force" in row.words else "N m" if "moment" in row.words else ""
    name, text = fresh(f"lambda{k}", taken), _text(scene, row)
    if not row.G:
        entries = (Symbol(fresh(f"G{k}_{i}", taken)) if used else sum_of(()) for i, used in enumerate(row.uses, 1))
        return PrintedRow(name, text, unit, tuple(entries), None, None)
    residual = write(row.residual) if row.closes and row.residual is not None else None
    rates = [Symbol(u) for u in scene.velocities]
    bias = sum_of(
        signed_product(write(form), Power(rates[j], 2) if j == k else product_of((rates[j], rates[k])))
        for j, k, form in row.bias
    )
    return PrintedRow(name, text, unit, tuple(map(write, row.G)), residual, bias)


def _text(scene: Scene, row: ClosedRow) -> str:
    """Return what a multiplier is, such as "force along x of loop hinge, exerted by coupler on rocker"."""
    if not row.loop:
        one = next(one for one in scene.rows if one.name == row.owner)
        pair = f", exerted by {one.plane.body} on {one.place.body}" if one.place else ""
        return f"{row.words} of contact {row.owner}{pair}" if pair else f"of row {row.owner}"
    loop = next(joint for joint in scene.loops if joint.name == row.owner)
    return f"{row.words} of loop {row.owner}, exerted by {loop.parent} on {loop.child}"


def fresh(name: str, taken: Container[str]) -> str:
    """Return a name, with underscores if it stands for something else."""
    while name in taken:
        name += "_"
    return name
