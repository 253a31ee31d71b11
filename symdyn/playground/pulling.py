"""Pictures that are pulled: coordinates by sliders, of closed mechanisms on the branch on which they stand."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Stage, picture, pose
from symdyn.dynamics.loops import Numbers
from symdyn.errors import DerivationError, DrawError
from symdyn.frozen import asdict, dataclass, field, replace
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import velocity_name

if TYPE_CHECKING:
    from symdyn.playground.answers import Settings

LEG = 0.1
"""How far a coordinate of a closed mechanism is pulled at once, rad or m, so that it stays on its branch."""

LEGS = 40

MOST = sys.float_info.max
"""Of what a coordinate is pulled to; beyond it there are whole numbers in JSON."""


@dataclass(frozen=True)
class Slider:
    """A coordinate to pull; unit and range are of its joint."""

    name: str
    unit: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class Standing:
    """A scene in a position: q, shape (nq,), values of all parameters, and ranges of sliders."""

    scene: Scene
    q: Array
    values: dict[str, float]
    spans: tuple[tuple[str, str, float, float], ...]
    numbers: Numbers = field(compare=False)

    def sliders(self) -> tuple[Slider, ...]:
        """Return the sliders where they are."""
        pairs = zip(self.spans, self.q.tolist(), strict=True)
        return tuple(Slider(name, unit, min(low, x), max(high, x), x) for (name, unit, low, high), x in pairs)

    def pulled(self, name: str, value: float) -> Standing:
        """Return it with a coordinate pulled as far as a value; loops stay closed on their branch.

        Raises:
            DrawError: they do not close there.
        """
        k, q = self.scene.coordinates.index(name), self.q.copy()
        if not self.scene.is_constrained:
            q[k] = value
            return replace(self, q=self.numbers.normalised(q))
        rate, names = velocity_name(name), list(self.scene.velocities)
        held = [names.index(rate)] if rate in names else []
        legs = min(LEGS, max(1, math.ceil(abs(value - q[k]) / LEG)))
        for at in np.linspace(q[k], value, legs + 1)[1:]:
            tried = q.copy()
            tried[k] = at
            try:
                tried = self.numbers.newton(self.numbers.normalised(tried), held)
                closed = self.numbers.is_closed(tried)
            except DerivationError:
                closed = False
            if not closed:
                raise DrawError(f"the loops do not close with {name} = {at:.6g}; it can be pulled as far as {q[k]:.6g}")
            q = tried
        return replace(self, q=q)


def standing(scene: Scene, at: dict[str, float]) -> Standing:
    """Return a scene in the position that a picture of it shows, coordinates `at` as they are given.

    Raises:
        DrawError: it has none.
    """
    q, values = pose(scene, at)
    wide = {"rad": math.pi, "m": Stage(scene, q[None], values).places.reach if scene.coordinates else 1.0, "1": 1.0}
    spans = []
    for joint, name, unit in SceneUnits(scene).each_coordinate():
        low, high = joint.range(values)
        low, high = (x if math.isfinite(x) else sign * wide[unit] for x, sign in ((low, -1), (high, 1)))
        spans.append((name, scene.shown_unit(unit), low, high))
    numbers = Numbers(scene).bound_to({p.name: values[p.name] for p in scene.free_parameters})
    return Standing(scene, q, values, tuple(spans), numbers)


def pulled_picture(scene: Scene, settings: Settings, pulled: Mapping[str, float]) -> dict[str, Any]:
    """Return `svg`, `sliders` and `unpulled`: what could not be pulled as far as it was, and how far it could.

    Args:
        scene: what is drawn, where it stands by `settings`.
        settings: of the page.
        pulled: coordinates and their values, in the order in which they were pulled; other names say nothing.

    Raises:
        DrawError: there is no position that could be drawn.
    """
    found, refused = standing(scene, dict(settings.at)), []
    for name, value in pulled.items():
        if name in scene.coordinates and isinstance(value, (int, float)) and abs(value) <= MOST:
            try:
                found = found.pulled(name, float(value))
            except DrawError as fault:
                refused.append(str(fault))
    svg = picture(scene, found.q, found.values, settings.view, settings.frames, settings.labels, scheme=settings.scheme)
    return {"svg": svg, "sliders": [asdict(one) for one in found.sliders()], "unpulled": refused}
