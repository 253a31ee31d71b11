"""The acados target: the scene as an AcadosModel, of the functions of the CasADi target, which stand beside.

    x    coordinates, velocities, states of one's own        u    driving forces, then inputs        p    parameters

Explicitly x' is forward dynamics; implicitly, where nothing is closed and no state is one's own, inverse dynamics. Both
have their Jacobians written out where velocities are rates of coordinates, so that acados' sensitivities take these.

Reference: Verschueren et al., acados, Mathematical Programming Computation 14 (2022); docs.acados.org, AcadosModel.
"""

from __future__ import annotations

from symdyn.dynamics import OUTPUTS
from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code.target import Contents, Draft, Target, alone
from symdyn.emit.render import in_docstring, render
from symdyn.emit.targets.casadi_modules import CASADI, jacobians
from symdyn.emit.targets.fmu_variables import driven, parameters_of
from symdyn.errors import EmitError
from symdyn.program import Program
from symdyn.scene import Scene

FORWARD, INVERSE, RATES, WHOLE_STATE = "forward_dynamics", "inverse_dynamics", "coordinate_rates", "state_rates"


def needed(scene: Scene) -> tuple[str, ...]:
    """Return the functions that the model of a scene is made of: what moves it first."""
    found = [WHOLE_STATE] if scene.states else [FORWARD] if scene.is_constrained else [FORWARD, INVERSE]
    if OUTPUTS[RATES].exists(scene):
        return (*found, RATES)
    if len(found) > 1:
        along = ["derivatives", *(["by_inputs"] if scene.inputs else [])]
        found += [f"{name}_{one}" for name in found for one in along]
    return tuple(found)


def _write(draft: Draft) -> dict[str, Contents]:
    """Return the module, and that of CasADi's functions."""
    program, scene = draft.program, draft.program.scene
    if not scene.velocities:
        raise EmitError(f"{scene.name}: nothing moves: no joint has a coordinate")
    timed = [r.function.name for r in program.routines if any(one.name == TIME for one in r.function.arguments)]
    if timed:
        raise EmitError(
            f"{scene.name}: {', '.join(timed)} depend on time, which acados' explicit integrators do not know; make it "
            "an input, in [inputs]"
        )
    pairs = list(zip(program.routines, draft.page.functions, strict=True))
    calls = {
        one.function.request or one.function.name: f"{text.name}({', '.join(a.name for a in text.arguments)})"
        for one, text in pairs
    }
    forces = driven(scene)
    drives = [name for name in forces if name]
    moving = calls.get(WHOLE_STATE) or calls[FORWARD]
    values = {
        "about": draft.about,
        "stem": draft.stem,
        "functions": f"{draft.stem}_casadi",
        "x": [*scene.coordinates, *scene.first_order],
        "u": [*drives, *(one.name for one in scene.inputs)],
        "p": parameters_of(program),
        "nq": len(scene.coordinates),
        "nv": len(scene.velocities),
        "own": bool(scene.states),
        "inputs": len(scene.inputs),
        "forces": [f"u[{drives.index(name)}]" if name else "0" for name in forces],
        "prepare": next((text.name for one, text in pairs if one.function.name == Program.PREPARE), ""),
        "motion": moving,
        "rates": calls.get(RATES),
        "inverse": calls.get(INVERSE),
        "jacobian": FORWARD in jacobians(program, CASADI.keywords),
    }
    module = {f"{draft.stem}_acados.py": render("acados/module.py.jinja", values)}
    return {**module, **CASADI.write(CASADI.draft(program, draft.real, draft.page.command))}


ACADOS = Target(
    name="acados",
    title="acados",
    text="a model for optimal control by acados, over functions of CasADi",
    reals=("double",),
    options={},
    files={"{stem}_acados.py": str, "{stem}_casadi.py": str},
    first=0,
    keywords=CASADI.keywords,
    lacks={},
    functions=needed,
    tunes=False,
    printer=CASADI.printer,
    comment=in_docstring,
    write=_write,
    beside=alone,
    shortens=(),
    loops=False,
)
