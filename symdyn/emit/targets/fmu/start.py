"""Where an FMU starts: as `simulate` does from what the scene says, loops closed and prescribed motions at t = 0."""

from __future__ import annotations

from symdyn.dynamics.mechanism import prescribed
from symdyn.errors import EmitError
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.scene.joints import start_of


def starting_state(scene: Scene) -> tuple[list[float], list[float]]:
    """Return coordinates and velocities at the start, shapes (nq,) and (nv,); rad, m or 1, and per s.

    Args:
        scene: the mechanism, its parameters bound.

    Raises:
        EmitError: angles are singular there, or a wheel lies flat.
        DerivationError: the loops do not close, or the velocities contradict each other.
    """
    from symdyn.algebra import Floats
    from symdyn.dynamics.loops import Numbers

    numbers = Numbers(scene)
    q, u = numbers.start(), [numbers.value(x) for x in start_of(scene).velocity]
    motion = prescribed(scene, numbers.graph)
    known = numbers.parameters | scene.at_time(numbers.graph)
    count = len(motion.place)
    found = evaluate([*motion.position, *motion.velocity], Floats(), known) if count else []
    for k, place, speed in zip(motion.place, found[:count], found[count:], strict=True):
        q[scene.coordinates.index(scene.velocities[k].removesuffix("_dot"))] = place
        u[k] = speed
    if scene.is_closed:
        held = list(motion.place)
        q = numbers.normalised(q)
        assembly = numbers.closed_position(q if held or any(q) else None, held or None)
        q[:] = assembly.q
        declared = numbers.declared_rates()
        u = numbers.fitting_rates(q, declared | {k: u[k] for k in held}).tolist()
    why = numbers.singular_angles(q) or numbers.lying_flat(q)
    if why:
        raise EmitError(f"{scene.name}: start: {why}")
    return [float(x) for x in q], [float(x) for x in u]
