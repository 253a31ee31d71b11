"""Which derivation of an output becomes code: the one that was asked for, else the one that its row prefers.

From so many joints on as `TABLE_LOOPS` says what can be a loop over a table is one in the languages that have it,
beside the lines by the preferred formulation, and these need not be derived at all. A formulation that is asked for is
taken at any number of joints.

Closed forms with sums of angles are no formulation: they trade multiplications for sines, and a rounded sum of angles
has lost digits that the product form keeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics import (
    Equations,
    Function,
    LoopChoices,
    Workspace,
    derive_one,
    formulations_of,
    known_formulation,
    loop_alone,
)
from symdyn.graph import growing
from symdyn.program.lower import lower
from symdyn.program.routine import Program
from symdyn.scene import Scene


@growing()
def formulate(
    scene: Scene,
    outputs: Sequence[str],
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    lines: bool = True,
) -> Equations:
    """Return the equations of a scene, each output by the formulation that becomes code.

    Args:
        scene: the mechanism.
        outputs: as for `derive`.
        formulation: take this derivation wherever a function has it; None takes the one that its row prefers.
        closing: what to choose about closed loops.
        lines: whether loops over tables are derived in lines as well; `emit` does it where it has to. Beside functions
            that are no loops they always are.

    Raises:
        DerivationError: an unknown output, body or point, equations that do not exist, a formulation that no output
            has.
    """
    workspace = Workspace(scene, closing)
    if closing.independent:
        _ = workspace.loops.decisions
    return Equations(scene, workspace.graph, choose(workspace, outputs, formulation, lines), closing)


def choose(
    workspace: Workspace, outputs: Sequence[str], formulation: str | None = None, lines: bool = True
) -> tuple[Function, ...]:
    """Return the outputs on the workspace's graph; see `formulate`."""
    known_formulation(workspace.scene, outputs, formulation)
    lines = lines or not all(loop_alone(workspace, request, formulation) for request in outputs)
    return tuple(choose_one(workspace, request, formulation, lines) for request in outputs)


@growing()
def choose_one(workspace: Workspace, request: str, formulation: str | None = None, lines: bool = True) -> Function:
    """Return one output by the formulation that was asked for, if it has that, else by the one that its row prefers.

    Without `lines` a loop over a table is not derived in lines as well, where it need not be.
    """
    alone = loop_alone(workspace, request, formulation)
    if alone and not lines and not (alone.loop and alone.loop.may_fail(workspace.scene)):
        return alone
    if formulation in formulations_of(request, workspace.scene):
        return derive_one(workspace, request, formulation)
    found = derive_one(workspace, request)
    return replace(found, loop=alone.loop) if alone else found


def in_lines(program: Program) -> Program:
    """Return the program without loops over tables or rows; functions whose entries were left out are derived now."""
    functions = [routine.function for routine in program.routines]
    if any(function.is_loop_alone for function in functions):
        program = lower(formulate(program.scene, [function.request for function in functions]))
    elif not any(function.loop or function.solve for function in functions):
        return program
    plain = (replace(one, function=replace(one.function, loop=None, solve=None)) for one in program.routines)
    return replace(program, routines=tuple(plain))
