"""The outputs that a scene has without being asked for them, and why others are left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import prod

from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.roads.derive import derive_one, expected, of_place, row_of
from symdyn.dynamics.roads.outputs import OUTPUTS
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import growing
from symdyn.scene import Scene
from symdyn.scene.values.names import listed

LARGE = 12
"""Velocities up to which outputs that grow with their cube are wanted unasked."""

LARGEST = 200
"""Velocities up to which square matrices, and Jacobians of many points, are wanted unasked."""

ASK = "ask with --functions"


def available(
    scene: Scene,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs of `available_on` for a scene."""
    return available_on(Workspace(scene, closing))


@growing()
def available_on(workspace: Workspace) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that a user expects of a scene without asking, and why others are left out.

    These are its dynamics, and the kinematics of its declared points. Left out is what does not exist (forward
    dynamics where the mass matrix is singular) and what is too large to be wanted unasked.
    """
    wanted, left_out = wanted_on(workspace)
    found, faults = there(workspace, wanted, _look_at)
    return found, left_out + faults


def wanted_on(workspace: Workspace) -> tuple[list[str], list[str]]:
    """Return the outputs that a scene of its kind has and that are not too large, and why others are left out.

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
    if n > LARGEST:
        large = _square(workspace, wanted)
        wanted = [name for name in wanted if name not in large]
        left_out.append(f"{listed(large, 6)}: left out, since their entries grow with the square of {n}; {ASK}")
    return wanted, left_out


def _square(workspace: Workspace, wanted: Sequence[str]) -> list[str]:
    """Return the outputs that have more entries than a square matrix of `LARGEST` rows; of points, all together.

    What a scene may lack is a vector; what it has rows for is not known before.
    """
    rows = {name: row_of(name)[0] for name in wanted}
    sure = {name: row for name, row in rows.items() if row.lacks == "never"}
    sizes = {name: prod(max(1, len(axis(workspace))) for axis in row.axes) for name, row in sure.items()}
    of_points = [name for name, row in sure.items() if row.place]
    if sum(sizes[name] for name in of_points) <= LARGEST**2:
        of_points = []
    return [name for name, size in sizes.items() if size > LARGEST**2 or name in of_points]


def there(
    workspace: Workspace, wanted: Sequence[str], derive: Callable[[Workspace, str], object]
) -> tuple[tuple[str, ...], list[str]]:
    """Return the outputs that can be derived, and what is told of others.

    Raises:
        DerivationError: an output cannot be derived that no scene lacks.
    """
    found, faults = [], []
    for name in wanted:
        lacks = row_of(name)[0].lacks
        try:
            derive(workspace, name)
        except DerivationError as fault:
            if lacks == "never":
                raise
            if lacks == "told" and str(fault) not in faults:
                faults.append(str(fault))
        else:
            found.append(name)
    return tuple(found), faults


def _look_at(workspace: Workspace, name: str) -> None:
    """Derive what the scene may lack."""
    if row_of(name)[0].lacks != "never":
        derive_one(workspace, name)
