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
from symdyn.unlocked import cached_property

ANGLES = np.radians(np.arange(0, 360, 22.5))
WAYS = (0.0, 5.0, 11.0, 18.0, 27.0, 38.0, 52.0, 70.0)
CROSSING, DISTANCE, TURNED = 16.0, 0.35, 3.0  # what a crossed line, a unit of way, and a turn away cost
DEAREST = 44.0  # what the place of a label may cost: less than three crossed lines
LEADER = 20.0  # from this way on a thin line leads to the label
LED = 8.0  # what such a line costs
ROUGH = 3.0  # room around a label
AT_ONCE, MOMENTS = 16, 4000  # places that are looked at together, and places times moments
SAME = 1e-9  # costs that differ by less are equal

OUTWARDS = np.repeat(WAYS, len(ANGLES))
"""How far out each place that is tried lies, nearest first, shape (places,)."""

DIRECTIONS = np.tile(np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1), (len(WAYS), 1))
"""And in which direction, shape (places, 2)."""


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

    @cached_property
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
    """Return the offset that costs least; of several, the nearest, and of these the first round the anchor."""
    offsets = np.round(
        DIRECTIONS * (label.gap + OUTWARDS[:, None])
        + np.sign(np.round(DIRECTIONS, 9)) * label.half * np.minimum(1.0, np.abs(DIRECTIONS) * 1.6),
        2,
    )  # all of half a box lies between the anchor's circle and its middle, or none sideways
    costs = OUTWARDS * DISTANCE
    if label.away is not None:
        costs = costs + TURNED * (1 - DIRECTIONS @ label.away)
    best, least = -1, most
    order, several = np.argsort(costs, kind="stable"), max(1, min(AT_ONCE, MOMENTS // len(segments)))
    for block in np.split(order, range(several, len(order), several)):
        if costs[block[0]] > least:
            break
        middles = label.at[:, None] + offsets[block]
        low, high = middles - label.half - ROUGH, middles + label.half + ROUGH
        free = np.logical_not(_overlaps(low, high, boxes))
        crossed = np.mean(np.sum(crosses(low, high, segments[:, None]), axis=2), axis=0)
        for k, crossings in zip(block[free].tolist(), crossed[free].tolist(), strict=True):
            cost, led = float(costs[k]) + CROSSING * crossings, Put(label, offsets[k])
            if led.leader is not None and cost <= least:
                cost += LED
                if boxes.shape[1] and _on_a_label(_led(led), boxes):
                    continue
            if cost < least - SAME or (k < best and cost < least + SAME):
                best, least = k, min(cost, least)
    return offsets[best] if best >= 0 else None


def _led(one: Put) -> Array:
    """Return the line that leads to a label, shape (N, 1, 2, 2)."""
    assert one.leader is not None, "asked only of labels far from their anchors"
    return np.stack([one.label.at + end for end in one.leader], axis=1)[:, None]


def _on_a_label(leader: Array, boxes: Array) -> bool:
    return any(bool(crosses(boxes[:, k, 0], boxes[:, k, 1], leader).any()) for k in range(boxes.shape[1]))


def _overlaps(low: Array, high: Array, boxes: Array) -> Array:
    """Return which of the boxes with corners of shape (N, B, 2) meet others, shape (N, K, 2, 2): shape (B,)."""
    others = boxes[:, None]
    apart = (others[..., 1, :] <= low[:, :, None]) | (others[..., 0, :] >= high[:, :, None])
    return np.asarray(np.any(~np.any(apart, axis=3), axis=(0, 2)))


def crosses(low: Array, high: Array, segments: Array) -> Array:
    """Return which segments, shape (..., S, 2, 2), meet which box, corners of shape (..., 2): shape (..., S)."""
    middle, half = (low + high)[..., None, :] / 2, (high - low)[..., None, :] / 2
    a, b = segments[..., 0, :], segments[..., 1, :]
    centre, reach = (a + b) / 2 - middle, (b - a) / 2
    beside = np.any(np.abs(centre) > half + np.abs(reach), axis=-1)
    turned = np.abs(centre[..., 0] * reach[..., 1] - centre[..., 1] * reach[..., 0])
    limit = half[..., 0] * np.abs(reach[..., 1]) + half[..., 1] * np.abs(reach[..., 0])
    return np.asarray(~(beside | (turned > limit)))
