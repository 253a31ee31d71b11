"""Where sliders begin: at the state of the lesson's numbers, or where the scene starts."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

from symdyn.dynamics.mechanism.prescribed import TIME
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import SymdynError
from symdyn.scene import Scene, acceleration_name
from symdyn.teach.balance import Balance
from symdyn.teach.shown_motion import choose_motion
from symdyn.teach.shown_state import shown_state, starting_rates


@dataclass(frozen=True)
class Start:
    """A state: q, shape (nq,), qd and qdd, shape (nv,), values of all parameters, and the time, s."""

    q: list[float]
    qd: list[float]
    qdd: list[float]
    parameters: dict[str, float]
    t: float


def start(scene: Scene) -> Start:
    """Return the state at which the scene's lesson shows numbers, with the velocities that the scene starts with.

    Of closed mechanisms that is D'Alembert's lesson. There is none for quaternions: closed ones begin at rest where the
    scene says nothing.
    """
    chosen, still = shown_state(scene), scene.is_closed
    if still and not quaternions(scene):
        with suppress(SymdynError):  # too large for a lesson
            chosen, still = choose_motion(Balance(scene, "en")), False
    numbers = {str(symbol.value): value for symbol, value in chosen.values.items()}
    rates = [numbers.get(u, 0.0) for u in scene.velocities]
    led = any(joint.motion is not None for joint in scene.joints)
    declared = any(joint.start_rates for joint in scene.joints)
    if still or (declared and not led and not scene.is_closed):
        rates = starting_rates(scene, chosen.parameters)
    accelerations = [numbers.get(acceleration_name(u), 0.0) for u in scene.velocities]
    return Start(list(chosen.q), rates, accelerations, dict(chosen.parameters), numbers[TIME] if led else 0.0)
