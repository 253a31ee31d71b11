"""What a scene has without being asked: outputs that fit it, exist and are not too large."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import prod
from typing import ClassVar

from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.outputs.closed_derivatives import RESIDUAL, UNPROJECTED
from symdyn.dynamics.outputs.derive import derive_one
from symdyn.dynamics.outputs.operators import WORDS
from symdyn.dynamics.outputs.output import DefaultIn
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.requests import expected, of_place, row_of
from symdyn.dynamics.outputs.state_matrices import STATE_MATRICES
from symdyn.dynamics.outputs.too_large import too_large
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import growing
from symdyn.scene import Scene
from symdyn.scene.values import listed

LARGE = 12
"""Velocities up to which outputs that grow with their cube are wanted by default."""

ASK = "ask with --functions"


@dataclass(frozen=True)
class Requested:
    """What a scene of its kind has by default and that is not too large; whether all of it exists derivations tell.

    Attributes:
        workspace: of the scene.
        outputs: as of `derive`.
        left_out: why others are left out.
    """

    workspace: Workspace
    outputs: tuple[str, ...]
    left_out: tuple[str, ...]

    LARGEST: ClassVar[int] = 200
    """Velocities up to which square matrices, and Jacobians of many points, are wanted by default."""

    @classmethod
    def of(cls, workspace: Workspace, by: DefaultIn = "generate") -> Requested:
        """Return what is wanted by who writes; who proves wants the last body's too, and what no one writes.

        Raises:
            DerivationError: the independent coordinates that were chosen are none.
        """
        scene, n = workspace.scene, workspace.state.n
        if workspace.closing.independent:
            _ = workspace.loops.decisions  # a wrong choice is a mistake, not an output that the scene lacks
        wanted = [*expected(scene), *(one for point in scene.points for one in of_place(point.name))]
        left_out = []
        if n > LARGE:
            wanted = [name for name in wanted if not row_of(name)[0].cubic]
            cubic = ", ".join(name for name, row in OUTPUTS.items() if row.cubic)
            left_out.append(f"{cubic} are left out for more than {LARGE} coordinates; {ASK}")
        large = {name: fault for name in wanted if (fault := too_large(workspace, name))}
        wanted = [name for name in wanted if name not in large]
        left_out += large.values()
        if n > cls.LARGEST:
            square = _square(workspace, wanted)
            wanted = [name for name in wanted if name not in square]
            left_out.append(f"{listed(square, 6)}: left out, since their entries grow with the square of {n}; {ASK}")
        if by == "verify":
            wanted += of_place(scene.bodies[-1].name, by)
            wanted += [name for name in expected(scene, by) if row_of(name)[0].default_in == by]
        return cls(workspace, tuple(wanted), tuple(left_out))

    @property
    def on_request(self) -> list[str]:
        """The outputs of the whole scene that no one has by default, and how derivatives of all are asked for."""
        scene = self.workspace.scene
        alone = [STATE_MATRICES, *((RESIDUAL, f"NAME{UNPROJECTED}") if scene.is_closed else ())]
        return [*(name for name in expected(scene, "request") if name not in expected(scene)), *alone, *WORDS]

    @growing()
    def available(self) -> tuple[tuple[str, ...], list[str]]:
        """Return the outputs that exist, derived where that tells, and why all others are left out."""
        found, faults = self.there(lambda w, name: row_of(name)[0].may_fail == "never" or derive_one(w, name))
        return found, [*self.left_out, *faults]

    def there(self, derive: Callable[[Workspace, str], object]) -> tuple[tuple[str, ...], list[str]]:
        """Return the outputs that can be derived, and what is told of others.

        Raises:
            DerivationError: an output cannot be derived that no scene lacks.
        """
        found, faults = [], []
        for name in self.outputs:
            may_fail = row_of(name)[0].may_fail
            try:
                derive(self.workspace, name)
            except DerivationError as fault:
                if may_fail == "never":
                    raise
                if may_fail == "reported" and str(fault) not in faults:
                    faults.append(str(fault))
            else:
                found.append(name)
        return tuple(found), faults


def available(
    scene: Scene,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted by default.
    """
    return Requested.of(Workspace(scene, closing)).available()


def _square(workspace: Workspace, requested: Sequence[str]) -> list[str]:
    """Return the outputs with more entries than a square matrix of `Requested.LARGEST` rows; of points, all together.

    What a scene may lack is a vector; what it has rows for is not known before.
    """
    rows = {name: row_of(name)[0] for name in requested}
    sure = {name: row for name, row in rows.items() if row.may_fail == "never"}
    sizes = {name: prod(max(1, len(axis(workspace))) for axis in row.axes) for name, row in sure.items()}
    of_points = [name for name, row in sure.items() if row.place]
    if sum(sizes[name] for name in of_points) <= Requested.LARGEST**2:
        of_points = []
    return [name for name, size in sizes.items() if size > Requested.LARGEST**2 or name in of_points]
