"""Derivatives by central differences in 50 digits, along motions that are made here: what graphs are differentiated to.

A state moves by its own motion: coordinates by a step, quaternions by e ∘ (cos ε/2, a sin ε/2), and the position of
free flight by ε along an axis of the moved frame. Nothing here reads how symdyn differentiates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symdyn.algebra.big import BigFloats
from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS

BIG = BigFloats(50)
STEP = BIG.number("1e-12")
State = dict[str, list[Any]]
"""Values by the name of an argument."""


def turned(e: Sequence[Any], axis: int, angle: Any) -> list[Any]:
    """Return e ∘ exp(angle / 2 axis)."""
    c, s = BIG.context.cos(angle / 2), BIG.context.sin(angle / 2)
    w, x, y, z = e
    across = ((-x, w, z, -y), (-y, -z, w, x), (-z, y, -x, w))[axis]  # e ∘ i, e ∘ j, e ∘ k
    return [c * a + s * b for a, b in zip(e, across, strict=True)]


def slid(p: Sequence[Any], e: Sequence[Any], axis: int, way: Any) -> list[Any]:
    """Return p + way R(e) axis."""
    w, x, y, z = e
    columns = (
        (w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z),
    )
    return [a + way * b for a, b in zip(p, columns[axis], strict=True)]


def moved(scene: Scene, q: Sequence[Any], velocity: int, step: Any) -> list[Any]:
    """Return q ∘ exp(step X_velocity)."""
    q, first, here = list(q), 0, 0
    for joint in scene.moving:
        for block in JOINTS[joint.type].blocks(joint):
            n, m = len(block.coordinates), len(block.velocities)
            k = velocity - here
            if 0 <= k < m:
                part = q[first : first + n]
                if not block.letters:
                    part[k] += step
                elif m == 6 and k < 3:
                    part[:3] = slid(part[:3], part[3:], k, step)
                else:
                    part[-4:] = turned(part[-4:], k % 3, step)
                q[first : first + n] = part
            first, here = first + n, here + m
    return q


@dataclass(frozen=True)
class Numbers:
    """Functions of one scene in 50 digits."""

    workspace: Workspace

    def function(self, request: str) -> Function:
        """Return an output as it is derived first."""
        return derive_one(self.workspace, request)

    def at(self, request: str, state: State) -> list[Any]:
        """Return the entries of an output."""
        function = self.function(request)
        values = {
            symbol: value
            for argument in function.arguments
            for symbol, value in zip(argument.symbols, state[argument.name], strict=True)
        }
        graph, parameters = self.workspace.graph, self.workspace.scene.parameters
        for p in parameters:
            if p.value is not None:
                (values[graph.symbol(p.name)],) = evaluate([p.value.express(graph)], BIG, {})
        return evaluate(function.entries, BIG, values)

    def stepped(self, state: State, along: str, k: int, step: Any) -> State:
        """Return the state that is moved along one direction of an argument."""
        values = list(state[along])
        if along == "q":
            values = moved(self.workspace.scene, values, k, step)
        else:
            values[k] += step
        return state | {along: values}

    def slope(self, request: str, state: State, along: str, k: int) -> list[Any]:
        """Return the central difference of an output along one direction."""
        there, here = (self.at(request, self.stepped(state, along, k, sign * STEP)) for sign in (1, -1))
        return [(a - b) / (2 * STEP) for a, b in zip(there, here, strict=True)]

    def slope_of_slope(self, request: str, state: State, outer: tuple[str, int], inner: tuple[str, int]) -> list[Any]:
        """Return X_outer X_inner of an output: the slope along `inner`, where `outer` has led."""
        there, here = (self.slope(request, self.stepped(state, *outer, sign * STEP), *inner) for sign in (1, -1))
        return [(a - b) / (2 * STEP) for a, b in zip(there, here, strict=True)]


def largest(values: Sequence[Any]) -> Any:
    """Return the size of the largest of several numbers."""
    return max((abs(x) for x in values), default=BIG.number(0))


def apart(found: Sequence[Any], expected: Sequence[Any]) -> float:
    """Return the largest difference over the largest of what is expected, over 1 where that is smaller."""
    assert len(found) == len(expected)
    return float(largest([a - b for a, b in zip(found, expected, strict=True)]) / max(1, largest(expected)))
