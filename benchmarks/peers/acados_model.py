"""Run by a Python that has acados: integrators and an optimal control problem of models that lie in a folder.

Reads JSON of `benchmarks/acados_model.py` from standard input, and writes JSON behind the last line of acados' own.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def installed() -> dict[str, str]:
    """Let `acados_template` be imported, and return where its C is; comma-deps-acados has it in folders of its own."""
    try:
        acados = importlib.import_module("acados")
    except ImportError:
        return {}
    source = Path(tempfile.mkdtemp())
    for name in ("include", "lib", "bin"):
        (source / name).symlink_to(Path(acados.DIR) / name)
    (source / "interfaces" / "acados_template").mkdir(parents=True)
    (source / "interfaces" / "acados_template" / "acados_template").symlink_to(acados.TEMPLATE_DIR)
    os.environ |= {"ACADOS_SOURCE_DIR": str(source), "TERA_PATH": acados.TERA_PATH}
    sys.path.insert(0, str(Path(acados.TEMPLATE_DIR).parent))
    return {"acados_include_path": acados.INCLUDE_DIR, "acados_lib_path": acados.LIB_DIR}


PLACES = installed()
TEMPLATE = importlib.import_module("acados_template")


def placed(problem: object) -> None:
    """Say where the C of acados is."""
    for name, place in PLACES.items():
        setattr(problem, name, place)


def model_of(one: dict) -> object:
    """Return the model, a new one, of our C where there is a library."""
    module, model = importlib.import_module(f"{one['name']}_acados"), TEMPLATE.AcadosModel()
    return module.filled(model, one["library"]) if one["library"] else module.filled(model)


def integrated(one: dict, kind: str) -> dict:
    """Return where a step ends, its sensitivities, and the Hessian with the seed of ones, which is of `S_adj`."""
    sim = TEMPLATE.AcadosSim()
    sim.model = model_of(one)
    sim.model.name = f"{one['name']}_{kind.lower()}"
    placed(sim)
    sim.solver_options.T = one["T"]
    sim.solver_options.integrator_type = kind
    sim.solver_options.num_stages, sim.solver_options.num_steps = 4, one["steps"]
    sim.solver_options.newton_iter = 20
    sim.solver_options.sens_adj = sim.solver_options.sens_hess = True
    sim.code_export_directory = f"c_{sim.model.name}"
    solver = TEMPLATE.AcadosSimSolver(sim, json_file=f"{sim.model.name}.json")
    n = len(one["x"])

    def run(x: list, u: list) -> None:
        solver.set("x", np.array(x))
        solver.set("u", np.array(u))
        solver.set("seed_adj", np.ones(n))
        if status := solver.solve():
            raise RuntimeError(f"acados ends with status {status}")

    run(one["x"], one["u"])
    found = {name: np.array(solver.get(name)).tolist() for name in ("x", "S_forw", "S_hess")}
    given, rows = np.array([*one["x"], *one["u"]]), []
    for k in range(len(given)):
        ends = []
        for sign in (1, -1):
            moved = given.copy()
            moved[k] += sign * 1e-5
            run(moved[:n].tolist(), moved[n:].tolist())
            ends.append(np.array(solver.get("S_adj")))
        rows.append(((ends[0] - ends[1]) / 2e-5).tolist())
    return {**found, "differences": rows}


def optimum(one: dict) -> dict:
    """Return what bringing x to zero in one second costs with exact Hessians, and how it was found."""
    ocp = TEMPLATE.AcadosOcp()
    ocp.model = model_of(one)
    ocp.model.name = f"{one['name']}_ocp"
    placed(ocp)
    n, m, N = len(one["x"]), len(one["u"]), 20
    ocp.dims.N = N
    ocp.cost.cost_type, ocp.cost.cost_type_e = "LINEAR_LS", "LINEAR_LS"
    ocp.cost.W, ocp.cost.W_e = np.diag([1.0] * n + [0.01] * m), 10 * np.eye(n)
    ocp.cost.Vx, ocp.cost.Vu = np.vstack([np.eye(n), np.zeros((m, n))]), np.vstack([np.zeros((n, m)), np.eye(m)])
    ocp.cost.Vx_e, ocp.cost.yref, ocp.cost.yref_e = np.eye(n), np.zeros(n + m), np.zeros(n)
    ocp.constraints.x0 = np.array(one["x"])
    options = ocp.solver_options
    options.tf, options.integrator_type, options.nlp_solver_type = 1.0, "ERK", "SQP"
    options.hessian_approx, options.regularize_method = "EXACT", "MIRROR"
    options.qp_solver, options.nlp_solver_max_iter = "PARTIAL_CONDENSING_HPIPM", 100
    ocp.code_export_directory = f"c_{ocp.model.name}"
    began = time.perf_counter()
    solver = TEMPLATE.AcadosOcpSolver(ocp, json_file=f"{ocp.model.name}.json")
    built = time.perf_counter() - began
    status = solver.solve()
    hessian = Path(ocp.code_export_directory) / f"{ocp.model.name}_model" / f"{ocp.model.name}_expl_ode_hess.c"
    return {
        "status": int(status),
        "cost": float(solver.get_cost()),
        "iterations": int(np.array(solver.get_stats("sqp_iter")).ravel()[0]),
        "residuals": float(np.max(solver.get_residuals())),
        "built": built,
        "seconds": float(np.array(solver.get_stats("time_tot")).ravel()[0]),
        "bytes": hessian.stat().st_size,
    }


def main() -> None:
    """Answer."""
    asked = json.load(sys.stdin)
    os.chdir(asked["folder"])
    sys.path.insert(0, asked["folder"])
    found = {
        one["name"]: {"ERK": integrated(one, "ERK"), "IRK": integrated(one, "IRK"), "optimum": optimum(one)}
        for one in asked["models"]
    }
    print("\n" + json.dumps(found))


if __name__ == "__main__":
    main()
