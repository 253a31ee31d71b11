"""symdyn's side of a case: the scene as the options tell it, its functions as code, and calls of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symdyn.dynamics import OUTPUTS, Equations, LoopChoices, Workspace, derive_one, expected, formulations_of, of_place
from symdyn.emit import emit
from symdyn.emit.code.identifiers import function_names
from symdyn.errors import DerivationError
from symdyn.program import lower, prepare
from symdyn.runtime import run_python
from symdyn.scene import Scene, bind, read_text, with_symbols, write_text

from ..jets import number
from ..mechanism import Array
from .cases import Case


def told(case: Case) -> tuple[Scene, dict[str, float]]:
    """Return the scene as the options tell it, and values of the parameters that are free in it."""
    scene, what = read_text(case.text), case.choice["symbols"]
    values = dict(case.values)
    if what:
        before = {one.name for one in scene.parameters}
        scene = with_symbols(scene, "all" if what == "open" else what)
        if what == "open":
            added = [one for one in scene.parameters if one.name not in before]
            values |= {one.name: number(one.value, values) for one in added}
            opened = tuple(one if one.name in before else replace(one, value=None) for one in scene.parameters)
            scene = replace(scene, parameters=opened)
    if case.zeros:
        scene = bind(scene, dict.fromkeys(case.zeros, 0))
    if case.choice["reading"] == "rewritten":
        scene = read_text(write_text(scene, "toml").text)
    return scene, {one.name: values[one.name] for one in scene.free_parameters}


class Code:
    """The functions of a case.

    Attributes:
        scene: as symdyn has it. q, u: places of its coordinates and velocities among those of the reference.
        refused: why outputs have no code. arguments: names of the arguments of every function.
        chosen: names of the independent velocities or coordinates of an argument ui or qi.
    """

    def __init__(self, case: Case) -> None:
        """Derive, lower, print and load."""
        self.case, choice = case, case.choice
        self.scene, values = told(case)
        names = case.mechanism.scene.coordinates
        self.q = [names.index(name) for name in self.scene.coordinates]
        self.u = [case.mechanism.names.index(name) for name in self.scene.velocities]
        self.closed = self.scene.is_constrained
        rates = (5, 3) if choice["closing"] == "baumgarte" and self.closed else (0, 0)
        closing = LoopChoices(case.independent, *rates, parameters=tuple(values.items()))  # type: ignore[arg-type]
        workspace, functions = Workspace(self.scene, closing), []
        self.refused: dict[str, str] = {}
        self.broken: dict[str, str] = {}
        for request in requests(self.scene, choice["asked"], choice["axes"]):
            try:
                functions.append(self._derived(workspace, request, choice["formulation"]))
            except DerivationError as fault:
                self.refused[request] = str(fault)
            except Exception as fault:  # a traceback for a user, who is not to see one
                self.broken[request] = f"{type(fault).__name__}: {fault}"
        equations = Equations(self.scene, workspace.graph, tuple(functions), closing)
        program = lower(equations.at_rest() if choice["rest"] == "static" else equations)
        program = prepare(program) if choice["prepare"] else program
        module = run_python(emit(program, "numpy", choice["real"]))
        self.calls, self.arguments, self.chosen, self.formulations = {}, {}, {}, {}
        for name, routine in zip(
            function_names([r.function.name for r in program.routines]), program.routines, strict=True
        ):
            request = routine.function.request or routine.function.name
            self.calls[request] = getattr(module, name)
            self.formulations[request] = routine.function.formulation
            self.arguments[request] = [argument.name for argument in routine.function.arguments]
            for argument in routine.function.arguments:
                if argument.name in ("ui", "qi"):
                    self.chosen[request] = [str(symbol.value) for symbol in argument.symbols]
        self.params = np.array([values[one.name] for one in self.scene.free_parameters])
        if "prepare" in self.calls:
            self.params = self.calls.pop("prepare")(self.params)

    def _derived(self, workspace: Workspace, request: str, formulation: str) -> Any:
        known = formulations_of(request, self.scene)
        if formulation == "last":
            return derive_one(workspace, request, known[-1])
        return derive_one(workspace, request, formulation if formulation in known else None)

    def __call__(self, name: str, **given: Sequence[Any]) -> Array:
        """Return a function at several states: q, u (for qd), du (for qdd), tau, t, ui, qi, an entry a state each."""
        renamed = {"qd": "u", "qdd": "du", "params": "", "prepared": ""}
        rows = [np.array(given[renamed.get(a, a)], float) if renamed.get(a, a) else None for a in self.arguments[name]]
        count = len(given["q"] if "q" in given else next(iter(given.values())))
        f, call = self.calls[name], self.case.choice["call"]
        rows = [
            one[:, self.q if a == "q" else self.u] if one is not None and a in ("q", "qd", "qdd", "tau", "p") else one
            for a, one in zip(self.arguments[name], rows, strict=True)
        ]
        if call == "one" or not rows:
            every = [f(*(self.params if one is None else one[k] for one in rows)) for k in range(count)]
            return np.array(every, float)
        if call == "batch":
            wide = [np.tile(self.params, (count, 1)) if one is None else one for one in rows]
            return np.asarray(f(*wide), float)
        wide = [self.params if one is None else one[:, None] for one in rows]  # (states, 1) beside a single set
        found = np.asarray(f(*wide), float)
        return found[:, 0] if any(one is not None for one in rows) else np.array([found] * count)


COEFFICIENTS = ("k_z", "k_C", "k_D", "k_G", "k_E", "coriolis_matrix")
CENTROIDAL = (
    "centre_of_mass", "centre_of_mass_jacobian", "centroidal_momentum_matrix", "centroidal_momentum_bias",
)  # fmt: skip

CANONICAL = ("hamiltonian", "gibbs_function")

FEW = 5
"""Velocities up to which what grows with their cube is asked for."""

ALWAYS = (
    "inverse_dynamics", "forward_dynamics", "drive_forces", "tree_forces", "multipliers", "velocities", "positions",
    "constraint_residual", "constraint_jacobian", "constraint_bias",
)  # fmt: skip


def requests(scene: Scene, asked: str, axes: str) -> list[str]:
    """Return what forces and motions there are, reactions in one kind of axes, and coefficients or all the rest."""
    rest = COEFFICIENTS if asked == "coefficients" else tuple(OUTPUTS) if asked == "kinematics" else ("mass_matrix",)
    found = [
        name
        for name in expected(scene)
        if name in ALWAYS or (name in rest and (asked == "coefficients" or name not in COEFFICIENTS[:3]))
    ]
    if len(scene.velocities) > FEW:
        found = [name for name in found if not OUTPUTS[name].cubic]
    body = scene.bodies[-1]
    if asked == "kinematics":
        found += [
            *of_place(body.name),
            *(f"{name}:{body.name}" for name in ("velocity", "acceleration")),
            *CENTROIDAL,
            *CANONICAL,
            *(["constraint_forces"] if scene.is_constrained else []),
        ]
        if body.com is not None and not body.particles:  # what is about a body is taken by verify alone
            found += [f"{name}:{body.name}" for name, row in OUTPUTS.items() if row.place == "body"]
    suffix = "" if axes == "body" else f":{axes}"
    return [*found, f"reactions{suffix}", f"forward_reactions{suffix}"]
