"""Which derivation of an output becomes code: the one whose program takes the fewest operations, counted.

Every formulation of an output is derived, lowered and counted by `Counts.cost`, for the scene at hand with its
parameters' values; of equals the first in the table wins. Two shortcuts keep this quick. A formulation whose equations
cost more than `HOPELESS` times the cheapest ones is not lowered. And formulations that grow fast are tried for few
coordinates only, none at all beyond `LONGEST`, where the table's own rule decides.

A formulation that is weighed apart is derived on a graph of its own, and on the scene's if it wins: programs are
written in the order in which nodes are born, which what is only weighed must not change.

From so many joints on as `TABLE_LOOPS` says what can be a loop over a table is one in the languages that have it,
beside the lines by the cheapest formulation, and these need not be derived at all. A formulation that is asked for is
taken at any number of joints.

Closed forms with sums of angles are no formulation: they trade multiplications for sines, and a rounded sum of angles
has lost digits that the product form keeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics import (
    Equations,
    Function,
    LoopChoices,
    Workspace,
    derive_one,
    formulations_of,
    known_formulation,
    loop_alone,
    row_of,
)
from symdyn.dynamics.outputs import Counts
from symdyn.graph import growing
from symdyn.program.lower import lower
from symdyn.program.routine import Program
from symdyn.scene import Scene

LONGEST = 16
"""Coordinates up to which formulations are compared by counting."""

HOPELESS = 1.5


@growing()
def formulate(
    scene: Scene,
    outputs: Sequence[str],
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
    lines: bool = True,
) -> Equations:
    """Return the equations of a scene, each output by the formulation that costs least.

    Args:
        scene: the mechanism.
        outputs: as for `derive`.
        formulation: take this one wherever an output has it; None leaves all to counting.
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
    every = [Candidates(workspace, request) for request in outputs]
    lines = lines or not all(one.loop(formulation) for one in every)
    return tuple(one.chosen(formulation, lines) for one in every)


@dataclass(frozen=True)
class Candidates:
    """The derivations of one output that may become code.

    Attributes:
        workspace: of the scene.
        request: what the output is asked for by.
    """

    workspace: Workspace
    request: str

    @property
    def names(self) -> tuple[str, ...]:
        """The formulations that are worth deriving to compare them, in the table's order."""
        n, row = self.workspace.state.n, row_of(self.request, self.workspace.scene)[0]
        return tuple(name for name in self._formulations() if n <= min(LONGEST, row.formulations[name].up_to))

    def cheapest(self) -> Function:
        """Return the output by the formulation that costs least; see `formulate`."""
        names, workspace, scene = self.names, self.workspace, self.workspace.scene
        if len(names) < 2:
            return derive_one(workspace, self.request, *names)
        row = row_of(self.request, scene)[0]
        places = [
            Workspace(scene, workspace.closing) if row.formulations[formulation].apart else workspace
            for formulation in names
        ]
        functions = [
            derive_one(place, self.request, formulation) for place, formulation in zip(places, names, strict=True)
        ]
        costs = [Counts.of(function).cost for function in functions]
        hopeful = [k for k, cost in enumerate(costs) if cost <= HOPELESS * min(costs)]
        lowered = {k: lower(Equations(scene, places[k].graph, (functions[k],))) for k in hopeful}
        best = min(hopeful, key=lambda k: lowered[k].routines[0].counts.cost)
        return derive_one(workspace, self.request, names[best])

    def chosen(self, formulation: str | None = None, lines: bool = True) -> Function:
        """Return the output by the formulation that was asked for, if it has that, else by the one that costs least.

        Without `lines` a loop over a table is not derived in lines as well, where it need not be.
        """
        alone, workspace = self.loop(formulation), self.workspace
        if alone and not lines and not (alone.loop and alone.loop.may_fail(workspace.scene)):
            return alone
        if formulation is not None and formulation in self._formulations():
            return derive_one(workspace, self.request, formulation)
        found = self.cheapest()
        return replace(found, loop=alone.loop) if alone else found

    def loop(self, formulation: str | None = None) -> Function | None:
        """Return it as a loop over a table alone: by the formulation asked for, or by count; None where it is none."""
        return loop_alone(self.workspace, self.request, formulation)

    def _formulations(self) -> tuple[str, ...]:
        return formulations_of(self.request, self.workspace.scene)


def in_lines(program: Program) -> Program:
    """Return the program without loops over tables or rows; functions whose entries were left out are derived now."""
    functions = [routine.function for routine in program.routines]
    if any(function.is_loop_alone for function in functions):
        program = lower(formulate(program.scene, [function.request for function in functions]))
    elif not any(function.loop or function.solve for function in functions):
        return program
    plain = (replace(one, function=replace(one.function, loop=None, solve=None)) for one in program.routines)
    return replace(program, routines=tuple(plain))
