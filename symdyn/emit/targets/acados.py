"""The acados target: the scene as an AcadosModel, of the functions of the CasADi target, which stand beside.

    x    coordinates, velocities, states of one's own        u    driving forces, then inputs        p    parameters

Explicitly x' is forward dynamics; implicitly, where nothing is closed and no state is one's own, inverse dynamics. Both
have their Jacobians written out where velocities are rates of coordinates, so that acados' sensitivities take these.
`external`, acados' own C calls ours, for exact Hessians too: nothing is left for CasADi to differentiate.

Reference: Verschueren et al., acados, Mathematical Programming Computation 14 (2022); docs.acados.org, AcadosModel.
"""

from __future__ import annotations

from symdyn.arguments import argument
from symdyn.dynamics import OUTPUTS
from symdyn.dynamics.mechanism import TIME
from symdyn.emit.code.target import Contents, Draft, Target, alone
from symdyn.emit.render import in_docstring, render
from symdyn.emit.targets.casadi_modules import BACK, BENT, CASADI, EXTERNAL, WHOLE, jacobians
from symdyn.emit.targets.fmu_variables import driven, parameters_of
from symdyn.errors import EmitError
from symdyn.program import Program
from symdyn.scene import Scene

FORWARD, INVERSE, RATES, WHOLE_STATE = "forward_dynamics", "inverse_dynamics", "coordinate_rates", "state_rates"


def needed(scene: Scene, option: str = "") -> tuple[str, ...]:
    """Return the functions that the model of a scene is made of: what moves it first."""
    found = [WHOLE_STATE] if scene.states else [FORWARD] if scene.is_constrained else [FORWARD, INVERSE]
    if OUTPUTS[RATES].exists(scene):
        return (*found, RATES)
    if len(found) > 1 and option == EXTERNAL:
        return tuple(f"{name}{more}" for name in found for more in ("", WHOLE, BACK, BENT))
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
    blocks, external = jacobians(program, CASADI.keywords), draft.option == EXTERNAL
    whole = calls.get(INVERSE) == f"{INVERSE}(q, qd, qdd)" and len(blocks.get(INVERSE, ())) == len(("q", "qd", "qdd"))
    if external and not whole:
        raise EmitError(
            f"{scene.name}: our C has Hessians of open mechanisms whose velocities are rates of coordinates, without "
            f"inputs, states of one's own, or parameters that have no value; leave {argument('external')} out"
        )
    forces = driven(scene)
    drives = [name for name in forces if name]
    moving = calls.get(WHOLE_STATE) or calls[FORWARD]
    values = {
        "about": draft.about,
        "stem": draft.stem,
        "functions": f"{draft.stem}_casadi",
        "external": external,
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
        "jacobian": FORWARD in blocks,
    }
    module = {f"{draft.stem}_acados.py": render("acados/module.py.jinja", values)}
    files = CASADI.write(CASADI.draft(program, draft.real, draft.page.command, draft.option))
    return {**module, **{name: text for name, text in files.items() if external == name.endswith(".c")}}


ACADOS = Target(
    name="acados",
    title="acados",
    text="a model for optimal control by acados, over functions of CasADi",
    reals=("double",),
    options={EXTERNAL: "our C, with exact Hessians, which acados' own calls"},
    files={"{stem}_acados.py": str, "{stem}_casadi.py": str, "{stem}_external.c": str},
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
