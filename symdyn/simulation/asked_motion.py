"""A motion as a shell asks for it: laws, paths and inputs as words and files, and the times of its samples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.values import Faults
from symdyn.simulation.initial import Values
from symdyn.simulation.inverse_run import inverse
from symdyn.simulation.prescribed.forces import Forces, read_inputs
from symdyn.simulation.prescribed.path_entries import read_path
from symdyn.simulation.prescribed.point_path import ScenePath
from symdyn.simulation.prescribed.scene_motion import SceneMotion, motion_times, read_motion
from symdyn.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class AskedMotion:
    """A motion that is prescribed: of a scene, its laws, paths of its points, what is given of inputs, and times."""

    scene: Scene
    motion: SceneMotion
    path: ScenePath
    forces: Forces
    times: Array

    @classmethod
    def read(
        cls,
        scene: Scene,
        laws: Sequence[str],
        paths: Sequence[str],
        forces: Sequence[str],
        until: float | None,
        every: float | None,
    ) -> AskedMotion:
        """Return what words and files say; until and every, s, of None are those of the one table among them.

        Raises:
            SimulateError: with every fault of all, one line each.
        """
        faults = Faults("")
        with faults.noted():
            motion = read_motion(scene, laws)
        with faults.noted():
            path = read_path(scene, paths)
        with faults.noted():
            given = read_inputs(scene, forces)
        with faults.noted():
            times = motion_times(laws, paths, until, every)
        faults.close(SimulateError)
        return cls(scene, motion, path, given, times)

    def run(self, start: Values, reactions: str, say: Callable[[str], None]) -> Trajectory:
        """Return the driving forces that it takes; arguments and errors as of `inverse`."""
        return inverse(
            self.scene, self.motion, self.times, reactions, say, path=self.path, start=start, forces=self.forces
        )  # fmt: skip
