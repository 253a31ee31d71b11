"""What the page shows: a picture, coordinates to pull, messages. A file with a fault leaves the last good picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.draw import Stage, pose
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.mechanism import quaternions
from symdyn.errors import DerivationError, DrawError, SymdynError, printable
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import velocity_name

LEG = 0.1
"""How far a coordinate of a closed mechanism is pulled at once, rad or m, so that it stays on its branch."""

LEGS = 40


@dataclass(frozen=True)
class Slider:
    """A coordinate to pull; unit and range are of its joint."""

    name: str
    unit: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class Sheet:
    """What is shown at one moment.

    Attributes:
        title: name of the scene.
        picture: SVG text.
        sliders: one a coordinate.
        faults: why what is shown is not what the file says, one line each.
        notes: what the reader of the file, and whoever pulled, should know.
    """

    title: str
    picture: str = ""
    sliders: tuple[Slider, ...] = ()
    faults: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Standing:
    """A scene in a position: q, shape (nq,), values of all parameters, and ranges of sliders."""

    scene: Scene
    q: Array
    values: dict[str, float]
    spans: tuple[tuple[str, str, float, float], ...]
    numbers: Numbers | None = field(default=None, compare=False)

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
        if self.numbers is None:
            q[k] = value
            return replace(self, q=_normalised(self.scene, q))
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
    numbers = Numbers(scene) if scene.is_closed else None
    if numbers is not None:
        numbers = numbers.bound_to({p.name: values[p.name] for p in scene.free_parameters})
    return Standing(scene, q, values, tuple(spans), numbers)


def _normalised(scene: Scene, q: Array) -> Array:
    names = list(scene.coordinates)
    for group in quaternions(scene):
        part = slice(names.index(group[0]), names.index(group[0]) + 4)
        length = float(np.linalg.norm(q[part]))
        q[part] = q[part] / length if length else (1.0, 0.0, 0.0, 0.0)
    return q


def _lines(fault: Exception) -> tuple[str, ...]:
    """Return what a fault says; one of ours does not end the page, which goes on with the next text of the file."""
    if isinstance(fault, SymdynError):
        return tuple(getattr(fault, "faults", ()) or [str(fault)])
    told = printable(f"{type(fault).__name__}: {fault}", keep="")
    return (f"symdyn itself has failed ({told}); please report it with the file; the page goes on",)


Loaded = tuple[Scene, Sequence[str]]
Drawn = Callable[[Scene, Array, dict[str, float]], str]


class Show:
    """The sheet of a file, made anew as the file or a hand changes it.

    Attributes:
        sheet: what is shown now.
        scene: what the equations are of: the last one that could be read; None before there is one.
    """

    def __init__(self, title: str, load: Callable[[], Loaded], draw: Drawn, at: dict[str, float]) -> None:
        """Take how the file is read, how a scene is drawn, and where coordinates begin."""
        self._load, self._draw, self._at = load, draw, at
        self._pulled: dict[str, float] = {}
        self._standing: Standing | None = None
        self._notes: tuple[str, ...] = ()
        self.sheet = Sheet(title)
        self.scene: Scene | None = None

    def read(self) -> None:
        """Show what the file says now; its fault, where it has one, and the picture before."""
        try:
            scene, notes = self._load()
            found = standing(scene, self._at)
            for name in [name for name in self._pulled if name in scene.coordinates]:
                try:
                    found = found.pulled(name, self._pulled[name])
                except DrawError:
                    del self._pulled[name]
            picture = self._draw(scene, found.q, found.values)
        except Exception as fault:
            self.sheet = replace(self.sheet, faults=_lines(fault))
            return
        self._standing, self.scene, self._notes = found, scene, tuple(notes)
        self.sheet = Sheet(scene.name, picture, found.sliders(), (), self._notes)

    def gone(self, text: str) -> None:
        """Show that the file is not there."""
        self.sheet = replace(self.sheet, faults=(text,))

    def pull(self, name: str, value: float) -> None:
        """Pull a coordinate; where it cannot go is said, and it stays."""
        if self._standing is None or name not in self._standing.scene.coordinates or not math.isfinite(value):
            return
        try:
            found = self._standing.pulled(name, value)
            picture = self._draw(found.scene, found.q, found.values)
        except Exception as fault:
            self.sheet = replace(self.sheet, notes=(*self._notes, *_lines(fault)))
            return
        self._standing, self._pulled[name] = found, value
        self.sheet = replace(self.sheet, picture=picture, sliders=found.sliders(), notes=self._notes)

    def back(self) -> None:
        """Forget what was pulled."""
        self._pulled.clear()
        self.read()
