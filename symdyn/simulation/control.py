"""What acts on a run from outside of its equations: a controller, and functions that forces are given by.

It says at which times the run has rows, and what is told of the controller in the end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symdyn.algebra import Array
from symdyn.scene import Scene
from symdyn.simulation.feedback.controller import Placed, Said, placed, placed_function, read_feedback
from symdyn.simulation.feedback.loop import Loop, Loops
from symdyn.simulation.feedback.sampled_rows import held_columns, hidden, sampled_rows
from symdyn.simulation.feedback.saturation import told
from symdyn.simulation.initial import Start
from symdyn.simulation.prescribed.forces import Forces
from symdyn.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class Control:
    """What acts from outside.

    Attributes:
        controller: None where there is none.
        functions: forces that are functions.
    """

    controller: Placed | None = None
    functions: tuple[Placed, ...] = ()

    @property
    def laws(self) -> tuple[Placed, ...]:
        """All of them, the controller first."""
        return (*(() if self.controller is None else (self.controller,)), *self.functions)

    @property
    def places(self) -> tuple[int, ...]:
        """The indices of the forces and inputs on which they act."""
        return tuple(dict.fromkeys(k for law in self.laws for k in law.places))

    @property
    def sampled(self) -> Placed | None:
        """The controller if it takes samples."""
        return self.controller if self.controller is not None and self.controller.feedback.period is not None else None

    def rows(self, until: float, every: float | None, usual: Array) -> Array:
        """Return the times of the rows of a run, the usual ones unless samples are taken and nobody asks for others."""
        return usual if self.sampled is None or every is not None else sampled_rows(self.sampled, until)

    def notes(self, rows: Array) -> list[str]:
        """Return what is said of what has no effect, and of samples that lie between rows."""
        if self.controller is None:
            return []
        feedback, found = self.controller.feedback, []
        if len(feedback.initial) and not (self.sampled and feedback.delay):
            found.append("feedback: initial has no effect: without a period and a delay the first force acts at once")
        return found if self.sampled is None else found + hidden(self.sampled, rows)

    def begun(self, scene: Scene, initial: Start, until: float) -> Loops | None:
        """Return them at work at the start of a run, None where there are none."""
        if not self.laws:
            return None
        nq, nv = len(scene.coordinates), len(scene.velocities)
        found = Loops([Loop(law, nq, nv, until, len(scene.inputs)) for law in self.laws])
        found.start(initial.q, initial.u)
        return found

    def told(self, trajectory: Trajectory, forces: Forces, loops: Loops | None) -> Trajectory:
        """Return a run with what is told of the controller: what it held, when it was cut."""
        if self.controller is None or loops is None:
            return trajectory
        cuts, end = loops.loops[0].cuts, float(trajectory.t[-1])
        others = tuple(k for one in self.functions for k in one.places)
        held = () if self.sampled is None else held_columns(trajectory.scene, forces, self.sampled, others)
        notes = (*trajectory.notes, *told(cuts, end))
        return replace(trajectory, held=held, saturations=cuts.until(end), notes=notes)


def control(scene: Scene, feedback: Said | None, forces: Forces, until: float) -> Control:
    """Return what acts from outside, from what `simulate` is given.

    Raises:
        SimulateError: with every fault, one line each.
    """
    controller = None if feedback is None else placed(scene, read_feedback(scene, feedback), until)
    return Control(controller, tuple(placed_function(scene, one, until) for one in forces.functions))
