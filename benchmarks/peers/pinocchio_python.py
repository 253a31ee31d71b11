"""Pinocchio's Python calls: what a script pays for one state, the call's overhead included."""

from __future__ import annotations

import numpy as np
from cases import Case
from harness import Timed
from native import MissingError

from peers import pinocchio_cpp

NAME = "Pinocchio, Python"

version = pinocchio_cpp.version


def timed(case: Case, output: str) -> list[Timed]:
    """Return one call from Python on one state."""
    import pinocchio

    model = pinocchio_cpp.model_of(case.urdf)
    if model.nq != model.nv:
        model = bounded(case)
    data = model.createData()
    order = np.array([case.joints.index(name) for name in list(model.names)[1:]])
    function = {
        "inverse_dynamics": pinocchio.rnea,
        "mass_matrix": pinocchio.crba,
        "forward_dynamics": pinocchio.aba,
        "gravity_forces": pinocchio.computeGeneralizedGravity,
    }[output]
    columns = [case.states[a][:, order] for a in case.arguments(output)]
    first = [np.ascontiguousarray(c[0]) for c in columns]

    def sweep(sweeps: int) -> float:
        import time

        turns = range(sweeps)
        start = time.perf_counter()
        for _ in turns:
            function(model, data, *first)
        return time.perf_counter() - start

    def result() -> np.ndarray:
        found = []
        for k in range(4):
            value = np.array(function(model, data, *(np.ascontiguousarray(c[k]) for c in columns)))
            if value.ndim == 2:
                value = np.triu(value) + np.triu(value, 1).T
            found.append(value.ravel())
        return pinocchio_cpp.restored(np.array(found), order, case.n)

    return [Timed(case.name, output, NAME, "python", 1, sweep, result)]


def bounded(case: Case):
    """Return the model with bounded joints: it keeps an unbounded angle as a cosine and a sine."""
    text = case.urdf.replace('type="continuous"', 'type="revolute"')
    if 'type="revolute"' not in text:
        raise MissingError("the URDF has no rotary joint")
    limits = '<limit lower="-1000" upper="1000" effort="1000" velocity="1000"/>'
    lines = []
    for line in text.splitlines():
        lines.append(line)
        if "<axis" in line:
            lines.append(limits)
    return pinocchio_cpp.model_of("\n".join(lines))
