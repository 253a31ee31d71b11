"""A scene in its positions as pictures see it: where its parts are, and the view in which they fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.draw.ground import patches
from symdyn.draw.places import Array, Places, places
from symdyn.draw.positions import values_of
from symdyn.draw.view import View, look
from symdyn.scene import Scene
from symdyn.unlocked import cached_property


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene in positions.

    Attributes:
        scene: any.
        q: positions, shape (N, nq), in the order of the scene; rad, m or 1.
        parameters: values of all of them; None for the declared ones, and 1 for what has none.
        direction: azimuth and elevation of the viewer in degrees; None chooses.
    """

    scene: Scene
    q: Array
    parameters: Mapping[str, float] | None = None
    direction: tuple[float, float] | None = None

    @cached_property
    def values(self) -> Mapping[str, float]:
        """Values of all parameters."""
        return values_of(self.scene) if self.parameters is None else self.parameters

    @cached_property
    def places(self) -> Places:
        """Where everything is."""
        return places(self.scene, self.q, self.values)

    @cached_property
    def view(self) -> View:
        """The view in which everything fits."""
        nudged = self.q[:1] + 0.1 * (1 + np.arange(self.q.shape[-1]) % 5)  # by which chance shows
        first = [self.places, places(self.scene, nudged, self.values)]
        return look(first, spread(self.scene, self.places), self.direction)

    @property
    def extent(self) -> float:
        """The largest extent of all that a picture must hold, m; 1 of what has none."""
        return float(np.ptp(spread(self.scene, self.places), axis=0).max()) or 1.0


def spread(scene: Scene, result: Places) -> Array:
    """Return all points that a picture must hold, shape (K, 3)."""
    spots = result.spots + [at for ends in result.ends.values() for at in ends]
    for centre, _, radius in result.wheels.values():
        spots += [centre + sign * radius * axis for axis in np.eye(3) for sign in (-1, 1)]
    for body in result.bodies:
        if (outline := result.outlines.get(body.name)) is not None:
            spots += [body.frame.point(outline.centre + sign * x) for x in outline.ways for sign in (-1, 1)]
    spots += [corners[:, k] for _, corners in patches(scene, result) for k in range(4)]
    return np.concatenate(spots) if spots else np.zeros((1, 3))
