"""The certificate of a scene: what was proved, over which fields, and how accurate the built code is."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from symdyn.build import build, run_python
from symdyn.build.extension import build_extension
from symdyn.build.load import is_usual
from symdyn.dynamics import (
    KINEMATICS,
    Equations,
    Function,
    Workspace,
    available,
    derive_one,
    roads,
)
from symdyn.emit import emit
from symdyn.errors import BuildError
from symdyn.graph import Expr, reachable, substitute
from symdyn.program import Program, cheapest, lower
from symdyn.scene import Scene, express
from symdyn.verify.accuracy import Accuracy, measure, sample
from symdyn.verify.equality import DIFFERENT, NUMERICAL, Claim, Fields, Finding, prove
from symdyn.verify.laws import laws

STATES = 50  # at which positive definiteness is looked at

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Certificate:
    """What is known about a scene's equations and code.

    Attributes:
        scene: its name.
        fields: primes, points and seed of the proofs.
        findings: derivations against each other, laws, and the program against the equations.
        accuracy: built modules against 50 digits.
        notes: what was left out and why.
    """

    scene: str
    fields: Fields
    findings: tuple[Finding, ...]
    accuracy: tuple[Accuracy, ...]
    notes: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing differs and every module is as accurate as doubles allow."""
        return all(f.verdict != DIFFERENT for f in self.findings) and all(a.passed for a in self.accuracy)

    def as_dict(self) -> dict[str, Any]:
        """Return the certificate for JSON."""
        return {**asdict(self), "passed": self.passed}


def certify(
    scene: Scene, outputs: Sequence[str] | None = None, seed: int = 1, progress: Progress = lambda _: None
) -> Certificate:
    """Return the certificate of a scene.

    Args:
        scene: the mechanism.
        outputs: what to certify, as for `derive`; None takes everything that the scene has.
        seed: of primes, points and states; the same seed, the same proofs.
        progress: told what is being done.

    Raises:
        DerivationError: an output that was asked for by name does not exist.
        VerifyError: the scene's equations are defined nowhere.
    """
    notes: list[str] = []
    workspace = Workspace(scene)
    progress("deriving")
    if outputs is None:
        outputs, left_out = everything(scene)
        notes += left_out
    preferred = tuple(cheapest(workspace, name) for name in outputs)
    claims = [
        Claim(name, one.formulation, road, one.entries, derive_one(workspace, name, road).entries)
        for name, one in zip(outputs, preferred, strict=True)
        for road in roads(name, scene)
        if road != one.formulation
    ]
    claims += laws(workspace, outputs)
    program = lower(Equations(scene, workspace.graph, preferred))
    claims += _program_claims(scene, preferred, program)
    progress("proving over finite fields")
    fields, findings = prove(claims, seed, positive=[p.name for p in scene.parameters if p.positive])
    progress("building")
    modules = _modules(program, notes)
    findings += _positive_definite(program, modules, seed, notes)
    progress("measuring against 50 digits")
    accuracy = measure(program, modules, seed=seed)
    return Certificate(scene.name, fields, tuple(findings), tuple(accuracy), tuple(notes))


def everything(scene: Scene) -> tuple[tuple[str, ...], list[str]]:
    """Return all outputs worth certifying, the kinematics of the last body included, and why others are left out."""
    outputs, left_out = available(scene)
    last = scene.bodies[-1]
    extra = [f"{name}:{last.name}" for name in KINEMATICS]
    extra += [f"com_acceleration:{last.name}"] if last.com is not None and not last.particles else []
    return outputs + tuple(extra), left_out


def _program_claims(scene: Scene, functions: Sequence[Function], program: Program) -> list[Claim]:
    """Return that each routine of the program computes its function, parameters with values bound."""
    values = {p.name: p.value for p in scene.parameters if p.value is not None}
    entries = [entry for function in functions for entry in function.entries]
    bound: dict[Expr, Expr] = {
        node: express(value, node.graph)
        for node in reachable(entries)
        if isinstance(node.value, str) and (value := values.get(node.value)) is not None
    }
    return [
        Claim(
            routine.function.name,
            "program",
            "equations",
            routine.function.entries,
            tuple(substitute(function.entries, bound)),
        )
        for function, routine in zip(functions, program.routines, strict=True)
    ]


def _modules(program: Program, notes: list[str]) -> dict[str, Any]:
    modules = {"numpy": run_python(emit(program, "numpy"))}
    try:
        modules["c"] = build(emit(program, "c"))
    except BuildError as fault:
        notes.append(f"C: {fault}")
        return modules
    usual = tuple(routine for routine in program.routines if is_usual(routine.function.name))
    if usual:  # compiling the others in both real types takes longer than it tells
        try:
            modules["ufunc"] = build_extension(emit(replace(program, routines=usual), "ufunc"))[1]
        except BuildError as fault:
            notes.append(f"ufunc: {fault}")
    return modules


def _positive_definite(program: Program, modules: dict[str, Any], seed: int, notes: list[str]) -> list[Finding]:
    """Return that M is positive definite at sampled states, where it should be and parameters have sensible values."""
    functions = {routine.function.name: routine.function for routine in program.routines}
    if not {"mass_matrix", "forward_dynamics"} <= functions.keys():
        return []
    if not all(parameter.positive for parameter in program.scene.free_parameters):
        notes.append("positive definiteness of M: left out, free parameters that are not declared positive")
        return []
    rng = random.Random(seed)
    states = [sample(functions["mass_matrix"].arguments, rng) for _ in range(STATES)]
    smallest = [float(np.linalg.eigvalsh(modules["numpy"].mass_matrix(*state)).min()) for state in states]
    where = next((k for k, value in enumerate(smallest) if value <= 0), -1)
    verdict = NUMERICAL if where < 0 else DIFFERENT
    return [Finding("mass matrix: positive definite", verdict, STATES, 0, 0.0, where)]
