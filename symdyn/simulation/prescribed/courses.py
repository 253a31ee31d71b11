"""Inputs over time: tables, and of inputs with rates the rates, which a formula in t or a spline through rows tells.

A step has no rate, and neither has what depends on the state, whose accelerations are not known beforehand.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import TIME
from symdyn.errors import listed
from symdyn.frozen import dataclass
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import Faults, acceleration_name, spell, velocity_name
from symdyn.simulation.prescribed.formulas_in_time import Columns, bound, counted, jump_of, parameter_values
from symdyn.simulation.prescribed.motion_laws import column_curve
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class ForceTable:
    """Numbers over rising times, interpolated; held before the first and after the last.

    Attributes:
        t: s, shape (N,).
        x: shape (N,).
        spline: of an input with rates what goes through them, of which this is the derivative of an `order`.
    """

    t: Array
    x: Array
    spline: Callable[[Array, int], Array] | None = None
    order: int = 0

    @cached_property
    def _curve(self) -> Callable[[Array], Array]:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.t, self.x)

    def __call__(self, times: Array) -> Array:
        if self.spline is not None:
            return np.asarray(self.spline(np.clip(times, self.t[0], self.t[-1]), self.order), dtype=np.float64)
        return np.asarray(self._curve(np.clip(times, self.t[0], self.t[-1])), dtype=np.float64)


def with_its_rates(scene: Scene, name: str) -> tuple[str, ...]:
    """Return a name and those of the rates that an input of this name has."""
    return (name, *(with_its_rates(scene, scene.rates[name]) if name in scene.rates else ()))


def rate_of(scene: Scene, name: str) -> str:
    """Return the input that is given where a name is that of one of its rates, "" of another name."""
    given = (one.name for one in scene.inputs if one.rates)
    return next((of for of in given if name in with_its_rates(scene, of)[1:]), "")


SHORTEST = 6
"""Rows of a table through which there is one spline of degree 5."""


def tables_of(scene: Scene, name: str, table: Columns, faults: Faults) -> dict[str, ForceTable]:
    """Return what a table tells of a force or an input, and of the rates that this has, by name."""
    from scipy.interpolate import make_interp_spline  # late: it takes long to load

    names = with_its_rates(scene, name)
    if names == (name,):
        return {name: table.curves.get(name) or ForceTable(table.t, table.values[name])}
    if len(table.t) < SHORTEST and not set(names) <= table.values.keys():
        few = f"{counted(len(table.t), 'row')} are too few: {name} has rates"
        faults.add(table.source, f"{few}, and a spline that has them takes {SHORTEST} at least")
        return {}
    curve = column_curve(table, name, velocity_name(name), acceleration_name(velocity_name(name)))
    if velocity_name(name) not in table.values:  # accelerations without kinks
        curve = make_interp_spline(table.t, table.values[name], k=5)
    return {one: ForceTable(table.t, table.values[name], spline=curve, order=order) for order, one in enumerate(names)}


def formulas_of(scene: Scene, name: str, formula: Quantity, where: str, faults: Faults) -> dict[str, Quantity]:
    """Return the formula of a force or an input, and those of the rates that this has, by name.

    A formula of more than t is a fault there, and one with a step where the rate acts.
    """
    names, values, found = with_its_rates(scene, name), parameter_values(scene), {name: formula}
    others = [one for one in formula.symbols if one != TIME and one not in values]
    if names[1:] and others:
        faults.add(where, f"{name} = {spell(formula)} depends on {listed(others)}, and {name} has rates; give it in t")
        return found
    acts = _order_used(scene, names) if names[1:] else 0
    for order, rate in enumerate(names[1:]):
        at = jump_of(bound(found[names[order]], values)) if order < acts else None
        if at is not None:
            what = f"{'the rate of ' * order}{name} = {spell(formula)} has a step at t = {at:.6g} s"
            faults.add(where, f"{what}, where {rate} acts and has no value; give a smoother one")
            return found
        found[rate] = found[names[order]].slope(TIME)
    return found


def _order_used(scene: Scene, names: tuple[str, ...]) -> int:
    """Return which derivative of an input acts, the highest one: what moves with it takes more than it names."""
    inside = {one for formula in Quantity.inside(scene) for one in formula.symbols}
    led = {one for joint in scene.joints if joint.motion is not None for one in joint.motion.symbols}
    damped = (at for strut, at in scene.supports if FORCES[strut.kind].pull.energy is None)  # a spring takes no rate
    ends = {one for at in damped for x in at for one in x.symbols}
    used = [order for order, one in enumerate(names) if one in inside]
    return max(2 * (names[0] in led), 1 * (names[0] in ends), *used, 0)
