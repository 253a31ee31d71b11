"""MuJoCo: its C functions, called from a loop in C; the model is the one that its reader makes of the URDF.

M stays in MuJoCo's sparse form and forward dynamics are factorisation and solution with it; constraints, contacts and
actuators, which these robots have not, are no part of what is called.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cases import Case
from harness import Timed
from native import HERE, NATIVE, MissingError, address, compiled

from peers.pinocchio_cpp import restored

NAME = "MuJoCo C"

CODES = {"inverse_dynamics": 0, "mass_matrix": 1, "forward_dynamics": 2, "gravity_forces": 3}

COMPILER = '<mujoco><compiler fusestatic="true" balanceinertia="false" discardvisual="true"/></mujoco>'


def version() -> str:
    """Return its version."""
    import mujoco

    return f"{mujoco.__version__}, the wheel's library"


@cache
def model_of(urdf: str) -> Any:
    """Return the model of a URDF text."""
    import mujoco

    opening, rest = urdf.split("<robot", 1)
    head, body = rest.split(">", 1)
    try:
        model = mujoco.MjModel.from_xml_string(f"{opening}<robot{head}>{COMPILER}{body}")
    except ValueError as fault:
        raise MissingError(f"it refuses the model ({' '.join(str(fault).split())})") from fault
    if model.nq != model.nv:
        raise MissingError("it gives the model quaternions")
    return model


def timed(case: Case, output: str) -> list[Timed]:
    """Return the output by mj_rne, mj_makeM, mj_factorM and mj_solveM."""
    import mujoco

    folder = Path(mujoco.__file__).parent
    found = sorted(folder.glob("libmujoco.so.*"))
    if not found:
        raise MissingError("its wheel has no libmujoco.so")
    flags = (*NATIVE, f"-I{folder}/include")
    source = HERE / "peers" / "mujoco_calls.c"
    code = ctypes.CDLL(str(compiled(source, flags, more=(str(found[0]), f"-Wl,-rpath,{folder}"))))
    code.peer_time.restype = ctypes.c_double
    model = model_of(case.urdf)
    data = mujoco.MjData(model)
    order = np.array([case.joints.index(model.joint(k).name) for k in range(model.nv)])
    arguments = [np.ascontiguousarray(case.states[a][:, order]) for a in (*case.arguments(output), "q", "q")[:3]]
    states, size = len(arguments[0]), case.references[output].shape[1]
    out = np.zeros((states, size))
    at = [ctypes.c_void_p(model._address), ctypes.c_void_p(data._address)]

    def run(sweeps: int, into: ctypes.c_void_p | None = None, keep: tuple[Any, Any] = (model, data)) -> float:
        where = [address(a) for a in arguments]
        return code.peer_time(*at, CODES[output], ctypes.c_long(states), ctypes.c_long(sweeps), *where, into)

    def result() -> np.ndarray:
        run(1, address(out))
        return restored(out, order, case.n)

    return [Timed(case.name, output, NAME, "state", states, run, result)]
