"""What is linearised, derived once for all values of parameters; and the linear system at a state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics import LoopChoices
from symdyn.dynamics.mechanism import TIME
from symdyn.dynamics.outputs import COLUMNS
from symdyn.errors import LinearizeError, NoValueError
from symdyn.graph import Op, reachable
from symdyn.linear.axis import Axis
from symdyn.linear.eliminated import Choice, LinearPoint, chosen, independent, matrices, place, symbols_at
from symdyn.linear.linearization import Linearization
from symdyn.linear.outputs import Outputs, read_outputs
from symdyn.linear.variations import Variations, variations
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import Faults, force_unit
from symdyn.simulation import Forces, Problem, opened

CORNER = 1e-12
"""What a sign is of, as far as it is zero."""


@dataclass(frozen=True)
class Prepared:
    """What is linearised: a scene at its values under forces, and what is looked at; the functions are derived."""

    scene: Scene
    forces: Forces
    outputs: Outputs
    functions: Variations
    independent: tuple[int, ...]

    @property
    def drives(self) -> list[int]:
        """Velocities whose drives are inputs; a prescribed motion finds its own."""
        led = self.functions.w.prescribed.place
        return [k for k, drive in enumerate(self.scene.drives) if drive and k not in led]

    @property
    def timed(self) -> bool:
        """Whether time itself acts: in formulas of forces and loads, tables, and prescribed accelerations."""
        v = self.functions
        return bool(self.forces.tables) or v.w.graph.symbol(TIME) in v.motion.order

    def place(self, q: Array, u: Array, t: float = 0.0, given: Array | None = None) -> LinearPoint:
        """Return what happens at a state; forces, then inputs, are `given` in place of what tables say."""
        values = opened(self.scene).values
        tables = self.forces.tabulated(np.asarray(t), len(u) + len(self.scene.inputs)) if given is None else given
        try:
            with np.errstate(all="ignore"):
                return place(self.functions, values, t, q, u, tables)
        except NoValueError as fault:
            raise LinearizeError(f"{self.scene.name}: {fault}") from None

    def kinematics(self, q: Array, t: float = 0.0) -> tuple[Array, Array]:
        """Return the rows that hold velocities, those of prescribed motions last, shape (rows, nv), and H: q̇ = H u."""
        v, still = self.functions, np.zeros(len(self.scene.velocities))
        nothing = np.zeros(len(still) + len(self.scene.inputs))
        found = v.motion.at(symbols_at(v, opened(self.scene).values, t, q, still, nothing))
        return found["G"], found["H"]

    def at(
        self,
        q: Array,
        u: Array,
        t: float = 0.0,
        notes: Sequence[str] = (),
        given: Array | None = None,
        like: Linearization | None = None,
    ) -> Linearization:
        """Return the linear system at a state, of the same states as another one is; errors as of `linearize`."""
        v, scene = self.functions, self.scene
        here = self.place(q, u, t, given)
        try:
            choice = chosen(here, self.independent) if like is None else self._like(here, like)
            with np.errstate(all="ignore"):  # what has no finite value is told below
                found = matrices(v, here, choice, self.drives)
        except NoValueError as fault:
            raise LinearizeError(f"{scene.name}: {fault}") from None
        except np.linalg.LinAlgError:
            raise LinearizeError(f"{scene.name}: independent states do not determine the others there") from None
        for matrix in (found.A, found.B, found.C, found.D):
            if not np.isfinite(matrix).all():
                raise LinearizeError(
                    f"{scene.name}: a derivative has no finite value there; give another place, or other values"
                )
        units, labels, told = SceneUnits(scene).velocities, COLUMNS["q"](v.w), SceneUnits(scene).inferred
        shown = scene.shown_unit
        states = Axis(
            (*(labels[k] for k in choice.positions), *(scene.velocities[k] for k in choice.velocities)),
            (*(shown(units[k]) for k in choice.positions), *(shown(f"{units[k]}/s") for k in choice.velocities)),
        )
        inputs = Axis(
            (*(str(scene.drives[k]) for k in self.drives), *v.inputs),
            (*(shown(force_unit(units[k])) for k in self.drives), *(told[one.name] for one in scene.inputs)),
        )
        return Linearization(
            scene, here.point, states, inputs, Axis(self.outputs.names, self.outputs.units), found.A, found.B, found.C,
            found.D, len(choice.positions), found.moves, found.directions, found.rates,
            notes=(*notes, *self._corners(here)), feeding=self._feeding(here, given),
        )  # fmt: skip

    def _feeding(self, here: LinearPoint, given: Array | None) -> tuple[float, ...]:
        """Return the forces at a place, those `given` apart, if formulas of them depend on the state."""
        state, formulas = {*self.scene.coordinates, *self.scene.velocities}, self.forces.formulas
        n = len(self.scene.velocities)
        led = [k for k in formulas if k < n and not self.scene.drives[k]]
        if not led and not any(state.intersection(one.symbols) for one in formulas.values()):
            return ()
        found = np.concatenate([here.point.tau, here.point.inputs])
        return tuple((found - (0.0 if given is None else given)).tolist())

    def _corners(self, here: LinearPoint) -> list[str]:
        """Return what is said of signs and absolute values that turn over at a place."""
        corners = self.functions.corners
        (_, nodes), values = corners.parts["of"], corners.at(here.values)["of"]
        known = {*self.scene.coordinates, *self.scene.velocities}
        turned = (node for node, x in zip(nodes, values.tolist(), strict=True) if abs(x) <= CORNER)
        names = dict.fromkeys(
            str(one.value) for node in turned for one in reachable([node]) if one.op is Op.SYMBOL and one.value in known
        )
        if not names:
            return []
        return [
            f"one-sided: a sign or an absolute value of {', '.join(names)} turns over here; A takes signs for constant "
            "and absolute values for flat, which dry friction at rest is not"
        ]

    def _like(self, here: LinearPoint, other: Linearization) -> Choice:
        names, labels = self.scene.velocities, COLUMNS["q"](self.functions.w)
        p = other.positions
        positions = [k for k, name in enumerate(labels) if name not in other.states.names[:p]]
        return independent(here, positions, [k for k, name in enumerate(names) if name not in other.states.names[p:]])


def prepared(problem: Problem, outputs: str | Sequence[str] = (), independent: str | Sequence[str] = ()) -> Prepared:
    """Return what is linearised, derived once for all values of parameters; arguments and errors as of `linearize`."""
    independent = (independent,) if isinstance(independent, str) and independent else tuple(independent)
    scene, faults = problem.scene, Faults("")
    found = opened(scene)
    if not scene.velocities:
        raise LinearizeError(f"{scene.name}: nothing moves: no joint has a coordinate")
    if independent and not scene.is_closed:
        raise LinearizeError(
            f"{scene.name}: --independent: it has no loops and no rows, all its coordinates are independent; leave "
            "--independent out"
        )
    forces = problem.driving
    forces.check_differentiable(faults)
    faults.close(LinearizeError)
    looked = read_outputs(scene, outputs)
    closing = LoopChoices(tuple(independent), parameters=found.closing.parameters)
    if not scene.is_closed:
        closing = LoopChoices()  # nothing is decided in numbers, and one derivation serves all values
    usual = {k: one.value for k, one in enumerate(scene.inputs, len(scene.velocities)) if k not in forces.outside}
    v = variations(found.scene, closing, tuple((usual | dict(forces.formulas)).items()), looked.formulas)
    every = range(len(scene.velocities))
    wanted = v.w.loops.decisions.partition.independent if scene.is_closed else every
    return Prepared(scene, forces, looked, v, tuple(k for k in wanted if k not in v.w.prescribed.place))
