"""Laws that are looked at in numbers, where proofs see nothing: inequalities, and positions that are special."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np

from symdyn.emit import emit
from symdyn.program import Sampling
from symdyn.runtime import RUNNERS
from symdyn.verdict import Unclaimed, Verdict
from symdyn.verify.equality import Finding
from symdyn.verify.law import Look, Looked, Seen
from symdyn.verify.natural_positions import forward_findings, reaction_findings

STATES = 50  # at which positive definiteness is looked at


DEFINITE = "mass matrix: positive definite"


def positive_definite(seen: Seen) -> Looked:
    """Return that M is positive definite at sampled states, where it should be and parameters have sensible values."""
    scene, mass = seen.program.scene, seen.program["mass_matrix"].function
    signed = [parameter.name for parameter in scene.free_parameters if not parameter.positive]
    if signed:
        return [], [Unclaimed(DEFINITE, f"{', '.join(signed)} may be negative; declare it with positive = true")]
    rng = random.Random(seen.seed)
    states = [Sampling(mass.arguments, rng).state(1.0 + k % 4 * 8) for k in range(4 * STATES)]
    measured = next(iter(seen.modules.values()), None)  # whose own accuracy is known
    module = RUNNERS["numpy"].run(emit(seen.program)) if measured is None else measured
    with np.errstate(all="ignore"):
        matrices = [getattr(module, mass.name)(*state) for state in states]
    real = [M for M in matrices if np.isfinite(M).all()][:STATES]  # a formula may be real for some parameters only
    where = next((k for k, M in enumerate(real) if not _is_definite(M, scene.is_closed)), -1)
    why = "" if real else f"M has finite entries at none of {len(states)} states"
    return [Finding(DEFINITE, Verdict.of(len(real), where >= 0), len(real), 0, 0.0, where, why)], []


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


def look(seen: Seen, progress: Callable[[str], None] = lambda _: None) -> Looked:
    """Return what all laws find that are about a scene, and what is no claim."""
    findings: list[Finding] = []
    absent: list[Unclaimed] = []
    for one in LOOKS:
        if one.fits(seen.program.scene, seen.outputs):
            progress(one.doing)
            found, told = one.look(seen)
            findings, absent = findings + found, absent + told
    return findings, absent
