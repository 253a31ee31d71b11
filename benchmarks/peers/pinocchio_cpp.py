"""Pinocchio: its C++ recursions, compiled from the wheel's headers for this machine, called from a loop in C++.

The model is the one that its URDF reader makes; results stay in its data and are not copied while the clock runs.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path

import numpy as np
from cases import Case
from harness import Timed
from native import FOLDER, HERE, NATIVE, MissingError, address, compiled

NAME = "Pinocchio C++"

CODES = {
    "inverse_dynamics": 0,
    "mass_matrix": 1,
    "forward_dynamics": 2,
    "gravity_forces": 4,
    "inverse_dynamics_derivatives": 5,
    "forward_dynamics_derivatives": 6,
    "regressor": 7,
    "coriolis_matrix": 8,
}

Places = dict[str, np.ndarray]
"""Our place of each entry of its arguments, by our name of the argument."""

FREE = (0, 1, 2, 4, 5, 6, 3)
"""Our places of the coordinates of a free joint: its quaternions end with the scalar part."""

DEFINES = (
    "-DNDEBUG",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
"""Those of Pinocchio's own CMake files."""


def version() -> str:
    """Return its version."""
    import pinocchio

    return f"{pinocchio.__version__}, g++ {' '.join(NATIVE)}"


def include() -> list[str]:
    """Return flags that find the headers of Pinocchio, and of Eigen in the wheels of CasADi or cmeel-eigen."""
    import pinocchio

    root = next(p for p in Path(pinocchio.__file__).parents if p.name == "cmeel.prefix")
    eigen = [f"{root}/include/eigen3", "/usr/include/eigen3"]
    try:
        import casadi

        eigen.insert(0, f"{Path(casadi.__file__).parent}/include/eigen3")
    except ImportError:
        pass
    found = next((folder for folder in eigen if Path(folder).is_dir()), None)
    if found is None:
        raise MissingError("there are no Eigen headers; pip install casadi or cmeel-eigen brings them")
    return [f"-I{root}/include", f"-I{found}"]


@cache
def model_of(urdf: str):
    """Return the model of a URDF text."""
    import pinocchio

    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / "robot.urdf"
    path.write_text(urdf, "utf-8")
    return pinocchio.buildModelFromUrdf(str(path), False)


def numbers(case: Case) -> tuple[np.ndarray, Places]:
    """Return the model as the rows of pinocchio_robot.hpp, and our places of its coordinates and velocities."""
    model = model_of(case.urdf)
    rows: list[list[float]] = []
    positions: list[int] = []
    velocities: list[int] = []
    for i in range(1, model.njoints):
        joint, placement, inertia = model.joints[i], model.jointPlacements[i], model.inertias[i]
        ours = case.scene.moving[case.joints.index(model.names[i])]
        rates = ours.velocities or ours.rates
        first, rate = case.scene.coordinates.index(ours.coordinates[0]), case.scene.velocities.index(rates[0])
        axis = np.zeros(3)
        if joint.nv == 1:
            data = joint.createData()
            joint.calc(data, np.array([1.0, 0.0]) if joint.nq == 2 else np.zeros(1))
            axis = np.asarray(data.S).reshape(6)[3:]
        J = inertia.inertia
        entries = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        place = [*placement.rotation.ravel(), *placement.translation]
        rows.append([model.parents[i], *axis, *place, inertia.mass, *inertia.lever, *entries])
        positions += [first] if joint.nv == 1 else [first + k for k in FREE]
        velocities += [rate + k for k in range(joint.nv)]
    places = {"q": np.array(positions), **dict.fromkeys(("qd", "qdd", "tau"), np.array(velocities))}
    return np.array(rows, dtype=float), places


def given(case: Case, output: str, places: Places) -> list[np.ndarray]:
    """Return the arguments of an output in its order, three at least."""
    return [np.ascontiguousarray(case.states[a][:, places[a]]) for a in (*case.arguments(output), "q", "q")[:3]]


def timed(case: Case, output: str) -> list[Timed]:
    """Return the output by rnea, crba (its upper triangle alone), aba, computeGeneralizedGravity, or its derivatives.

    Those are computeRNEADerivatives and computeABADerivatives, whose third matrix is M and M⁻¹.
    """
    flags = ("-std=c++17", "-w", *NATIVE, *DEFINES, *include())
    code = ctypes.CDLL(str(compiled(HERE / "peers" / "pinocchio_calls.cpp", flags, "g++")))
    code.peer_robot.restype = ctypes.c_void_p
    code.peer_time.restype = ctypes.c_double
    rows, places = numbers(case)
    robot = ctypes.c_void_p(code.peer_robot(len(rows), address(rows)))
    arguments = given(case, output, places)
    states, size = case.references[output].shape
    out = np.zeros((states, size))

    def run(sweeps: int, into: ctypes.c_void_p | None = None) -> float:
        where = [address(a) for a in arguments]
        return code.peer_time(robot, CODES[output], ctypes.c_long(states), ctypes.c_long(sweeps), *where, into)

    def result() -> np.ndarray:
        run(1, address(out))
        return restored(out, places["qd"], case.n)

    return [Timed(case.name, output, NAME, "state", states, run, result)]


def parameters(case: Case) -> np.ndarray:
    """Return its ten parameters of every body, shape (10 bodies,), what its regressor is to be multiplied by."""
    model = model_of(case.urdf)
    return np.concatenate([model.inertias[i].toDynamicParameters() for i in range(1, model.njoints)])


def restored(out: np.ndarray, order: np.ndarray, n: int) -> np.ndarray:
    """Return results with the coordinates in our order; a regressor has ten columns a body in theirs."""
    back = np.argsort(order)
    if out.shape[1] == n:
        return out[:, back]
    if out.shape[1] == 10 * n * n:
        return out.reshape(len(out), n, 10 * n)[:, back].reshape(len(out), -1)
    blocks = out.reshape(len(out), n, -1, n)  # matrices side by side
    return blocks[:, back][..., back].reshape(len(out), -1)
