"""Where labels go: near what they name, clear of each other, and on as few lines as can be.

Every label tries places around its anchor, near ones first. A place costs what lies under it and how far away it is;
one on another label is not taken at all, and a label that finds none worth reading is left out (its group still has a
title).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.draw.lettering import FONT, Text
from symdyn.draw.places import Array

ANGLES = np.radians(np.arange(0, 360, 22.5))
WAYS = (0.0, 5.0, 11.0, 18.0, 27.0, 38.0, 52.0, 70.0)
CROSSING, DISTANCE, TURNED = 16.0, 0.35, 3.0  # what a crossed line, a unit of way, and a turn away cost
DEAREST = 44.0  # what the place of a label may cost: less than three crossed lines
LEADER = 20.0  # from this way on a thin line leads to the label
LED = 8.0  # what such a line costs
ROUGH = 3.0  # room around a label


@dataclass(frozen=True)
class Label:
    """A name to be put somewhere.

    Attributes:
        id: of its element, without the picture's prefix.
        at: anchor at N moments, shape (N, 2).
        gap: distance from the anchor at which the label may begin.
        away: preferred direction, shape (2,); None for none.
        look: its classes in the style sheet.
    """

    id: str
    text: Text
    at: Array
    gap: float
    away: Array | None = None
    look: str = ""

    @property
    def half(self) -> Array:
        """Half its width and half its height."""
        return np.array([self.text.width / 2, FONT * (0.62 if self.text.lowered else 0.5)])


@dataclass(frozen=True)
class Put:
    """A label and the middle of its box as seen from the anchor, shape (2,)."""

    label: Label
    offset: Array

    @property
    def box(self) -> Array:
        """Low and high corner at every moment, shape (N, 2, 2)."""
        middle = self.label.at + self.offset
        return np.stack([middle - self.label.half, middle + self.label.half], axis=1)

    @property
    def leader(self) -> tuple[Array, Array] | None:
        """Ends of the line that leads to a label far from its anchor, seen from the anchor; None for a near one."""
        edge = self.offset - np.clip(self.offset, -self.label.half, self.label.half)
        length = float(np.linalg.norm(edge))
        if length < LEADER + self.label.gap:
            return None
        return edge / length * self.label.gap, edge * (1 - 2 / length)


def put(labels: Sequence[Label], segments: Array, most: float = DEAREST) -> tuple[Put, ...]:
    """Return the labels that find a place, in order; earlier ones choose first.

    They keep clear of segments, shape (N, S, 2, 2); a label that finds no place that costs at most so much is left out.
    """
    done: list[Put] = []
    for label in labels:
        boxes = np.stack([one.box for one in done], axis=1) if done else np.zeros((len(segments), 0, 2, 2))
        offset = _best(label, segments, boxes, most)
        if offset is None:
            continue
        done.append(Put(label, offset))
        if done[-1].leader is not None:
            segments = np.concatenate([segments, _led(done[-1])], axis=1)
    return tuple(done)


def _best(label: Label, segments: Array, boxes: Array, most: float) -> Array | None:
    best, least = None, most
    for way in WAYS:
        if way * DISTANCE >= least:
            break
        for angle in ANGLES:
            direction = np.array([np.cos(angle), np.sin(angle)])
            offset = np.round(
                direction * (label.gap + way) + np.sign(np.round(direction, 9)) * label.half * _lean(direction), 2
            )
            cost = way * DISTANCE
            if label.away is not None:
                cost += TURNED * (1 - float(direction @ label.away))
            if cost >= least:
                continue
            low, high = label.at + offset - label.half - ROUGH, label.at + offset + label.half + ROUGH
            if _overlaps(low, high, boxes):
                continue
            led = Put(label, offset)
            if led.leader is not None:
                cost += LED
                if boxes.shape[1] and _on_a_label(_led(led), boxes):
                    continue
            cost += CROSSING * float(np.mean(np.sum(crosses(low, high, segments), axis=1)))
            if cost < least - 1e-9:
                best, least = offset, cost
    return best


def _led(one: Put) -> Array:
    """Return the line that leads to a label, shape (N, 1, 2, 2)."""
    assert one.leader is not None, "asked only of labels far from their anchors"
    return np.stack([one.label.at + end for end in one.leader], axis=1)[:, None]


def _on_a_label(leader: Array, boxes: Array) -> bool:
    return any(bool(crosses(boxes[:, k, 0], boxes[:, k, 1], leader).any()) for k in range(boxes.shape[1]))


def _lean(direction: Array) -> Array:
    """Return how much of half a box lies between the anchor's circle and its middle: all of it, or none sideways."""
    return np.minimum(1.0, np.abs(direction) * 1.6)


def _overlaps(low: Array, high: Array, boxes: Array) -> bool:
    apart = (boxes[:, :, 1] <= low[:, None]) | (boxes[:, :, 0] >= high[:, None])
    return bool(np.any(~np.any(apart, axis=2)))


def crosses(low: Array, high: Array, segments: Array) -> Array:
    """Return which segments, shape (N, S, 2, 2), meet which box, corners of shape (N, 2): shape (N, S)."""
    middle, half = (low + high)[:, None] / 2, (high - low)[:, None] / 2
    a, b = segments[:, :, 0], segments[:, :, 1]
    centre, reach = (a + b) / 2 - middle, (b - a) / 2
    beside = np.any(np.abs(centre) > half + np.abs(reach), axis=2)
    turned = np.abs(centre[..., 0] * reach[..., 1] - centre[..., 1] * reach[..., 0])
    limit = half[..., 0] * np.abs(reach[..., 1]) + half[..., 1] * np.abs(reach[..., 0])
    return np.asarray(~(beside | (turned > limit)))
