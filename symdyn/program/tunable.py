"""Parameters that keep their values as a start: code in which they are free, and a scene that says what they are.

What a simulator may set while it runs cannot be bound. The equations are derived with every parameter free; decisions
about loops, which are made in numbers, are made at the values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.dynamics import LoopChoices
from symdyn.errors import DerivationError
from symdyn.program.formulation import formulate
from symdyn.program.lower import lower
from symdyn.program.routine import Program
from symdyn.scene import Scene


def tunable(
    scene: Scene,
    outputs: Sequence[str],
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Program:
    """Return the program of outputs with every parameter in `params`; its scene keeps their values.

    Args:
        scene: the mechanism.
        outputs: as for `derive`.
        formulation: as for `formulate`.
        closing: what to choose about closed loops.

    Raises:
        DerivationError: as `formulate`; or loops close a scene of which a parameter has no value.
    """
    free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    if scene.is_closed:
        if scene.free_parameters:
            names = [one.name for one in scene.free_parameters]
            raise DerivationError(
                f"{scene.name}: {', '.join(names)} {'has' if len(names) == 1 else 'have'} no value, at which the loops "
                f"are looked at; give --bind {','.join(f'{name}=1' for name in names)}, or what they are"
            )
        known = ((one.name, one.value.at({})) for one in scene.parameters if one.value is not None)
        closing = replace(closing, parameters=tuple((name, float(value or 0)) for name, value in known))
    return replace(lower(formulate(free, outputs, formulation, closing)), scene=scene)
