"""Laws that are looked at in numbers, where proofs see nothing: inequalities, and positions that are special."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from symdyn.build import run_python
from symdyn.emit import emit
from symdyn.program.states import sample
from symdyn.verify.equality import DIFFERENT, NUMERICAL, UNDEFINED, Finding
from symdyn.verify.law import Look, Seen
from symdyn.verify.natural import forward_findings, reaction_findings

STATES = 50  # at which positive definiteness is looked at


def positive_definite(seen: Seen) -> tuple[list[Finding], list[str]]:
    """Return that M is positive definite at sampled states, where it should be and parameters have sensible values."""
    scene, mass = seen.program.scene, seen.program["mass_matrix"].function
    if not all(parameter.positive for parameter in scene.free_parameters):
        return [], ["positive definiteness of M: left out, free parameters that are not declared positive"]
    rng = random.Random(seen.seed)
    states = [sample(mass.arguments, rng, widen=1.0 + k % 4 * 8) for k in range(4 * STATES)]
    measured = next(iter(seen.modules.values()), None)  # whose own accuracy is known
    module = run_python(emit(seen.program)) if measured is None else measured
    with np.errstate(all="ignore"):
        matrices = [getattr(module, mass.name)(*state) for state in states]
    real = [M for M in matrices if np.isfinite(M).all()][:STATES]  # a formula may be real for some parameters only
    where = next((k for k, M in enumerate(real) if not _is_definite(M, scene.is_closed)), -1)
    verdict = UNDEFINED if not real else NUMERICAL if where < 0 else DIFFERENT
    return [Finding("mass matrix: positive definite", verdict, len(real), 0, 0.0, where)], []


def _is_definite(M: np.ndarray[Any, Any], closed: bool) -> bool:
    """Whether M is positive definite; only not negative for a spanning tree, which may end in a massless coupler."""
    values = np.linalg.eigvalsh(M)
    return bool(values.min() >= -1e-12 * values.max() if closed else values.min() > 0)


LOOKS: list[Look] = [
    Look(
        None,
        ("forward_dynamics", "multipliers"),
        "looking at natural positions",
        lambda seen: forward_findings(seen.workspace),
    ),
    Look(
        None,
        ("forward_dynamics", "multipliers", "reactions"),
        "looking at reactions there",
        lambda seen: reaction_findings(seen.workspace),
    ),
    Look(
        ("mass_matrix", "forward_dynamics"),
        ("mass_matrix", "forward_dynamics"),
        "looking at the inertia matrix",
        positive_definite,
    ),
]
