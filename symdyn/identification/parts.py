"""Motions and what they are held against: columns of parameters and payloads, and rows of these by frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.identification.filtered import Flags, Motion, projected
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.payload import Carried
from symdyn.identification.regression import Rows
from symdyn.identification.validation import blocks

SLOW = 3.0
"""Standard deviations of a velocity's noise within which a joint stands, where its dry friction jumps."""


@dataclass(frozen=True)
class DataPart:
    """One motion, and what it is held against.

    Attributes:
        motion: with what drives show.
        Y: columns of β, of what is not known of payloads, and last the force of what is, shape (N, nv, b + 1).
        drawn: what noise of the motion makes of them; None where there is none.
        blocks: which samples are held back.
    """

    motion: Motion
    Y: Array
    drawn: Array | None
    blocks: tuple[tuple[slice, bool], ...]


@dataclass(frozen=True)
class Evidence:
    """What all fits of the same motions share, whichever gains they look for.

    Attributes:
        parts: the motions.
        used: of each, which samples are fitted before outliers are left out, shapes (N, nv).
        rows: of these samples.
    """

    parts: tuple[DataPart, ...]
    used: tuple[Flags, ...]
    rows: Rows


def evidence(model: LinearModel, moved: Sequence[tuple[int, Motion]], carried: Carried, hold_back: float) -> Evidence:
    """Return motions, each with the place of its log, beside the columns that they are held against.

    Raises:
        IdentifyError: a regressor without finite values.
    """
    parts = tuple(_part(model, one, carried, place, hold_back) for place, one in moved)
    used = tuple(moving(model, one.motion) for one in parts)
    return Evidence(parts, used, rows_of(model, parts, used, False))


def moving(model: LinearModel, motion: Motion) -> Flags:
    """Return which samples of which joints are fitted: not where dry friction jumps within the noise of a velocity."""
    used = np.ones(motion.tau.shape, bool)
    for j in model.jumps:
        used[:, j] = np.abs(motion.qd[:, j]) > SLOW * motion.noise[1, j]
    return used


def _part(model: LinearModel, motion: Motion, carried: Carried, place: int, hold_back: float) -> DataPart:
    """Return a motion with the columns that it is held against."""

    def columns(*state: Array) -> Array:
        found = model.regressor(*state)
        return np.concatenate([found, carried.columns(model, place, *state)], axis=2)

    both = columns(motion.q, motion.qd, motion.qdd)
    bad = np.argwhere(~np.isfinite(both))
    if len(bad):
        raise IdentifyError(
            f"{motion.source}: at t = {motion.t[bad[0][0]]:.6g} s the regressor has no finite value, as at a dead "
            "centre; leave such samples out"
        )
    drawn = None
    if motion.noise.any() and motion.q.shape == motion.qd.shape:
        drawn = columns(*_shaken(motion)) - both
    return DataPart(motion, both, drawn, tuple(blocks(len(motion.t), hold_back)))


def _shaken(motion: Motion) -> tuple[Array, Array, Array]:
    """Return a motion with one draw of its noise; None of it has what was not differentiated."""
    rng = np.random.default_rng(0)
    step = float(motion.t[1] - motion.t[0])
    frequency = np.fft.rfftfreq(len(motion.t), step)
    shape = (len(frequency), motion.q.shape[1])
    white = (rng.normal(size=shape) + 1j * rng.normal(size=shape)) * (frequency <= motion.band)[:, None]
    turn = 2j * np.pi * frequency[:, None]
    parts = [np.fft.irfft(white * turn**k, len(motion.t), axis=0) for k in range(3)]
    level = motion.noise[1] / np.maximum(np.std(parts[1], axis=0), 1e-300)
    q, qd, qdd = (x + p * level for x, p in zip((motion.q, motion.qd, motion.qdd), parts, strict=True))
    return q, qd, qdd


def held_in(part: DataPart) -> Flags:
    """Return which samples of a motion are held back, shape (N,)."""
    mask = np.zeros(len(part.motion.t), bool)
    for samples, back in part.blocks:
        mask[samples] = back
    return mask


def rows_of(model: LinearModel, parts: Sequence[DataPart], used: Sequence[Flags], back: bool) -> Rows:
    """Return what drives show and the columns beside it, of samples that are held back, or of those that are not."""
    found: list[tuple[Any, ...]] = []
    group = 0
    for one, mask in zip(parts, used, strict=True):
        motion, Y, drawn = one.motion, one.Y, one.drawn
        step = float(motion.t[1] - motion.t[0])
        for part, held in one.blocks:
            n = part.stop - part.start
            count = int(min(n, 2 * motion.band * step * n))
            if held is not back or count < 1:
                continue
            frequency = np.arange(count) / (2 * step * n)
            for j in model.rows:
                take = mask[part, j].astype(float)[:, None]
                if not take.any():
                    continue
                own = projected(np.column_stack([Y[part, j], motion.tau[part, j]]) * take, count)
                lost = np.zeros((count, Y.shape[2])) if drawn is None else projected(drawn[part, j] * take, count)
                numbers = group + np.arange(count)
                found.append((own[:, :-1], own[:, -1], np.full(count, j), frequency, numbers, lost))
            group += count
    if not found:
        p = parts[0].Y.shape[2]
        none = np.zeros(0)
        return Rows(np.zeros((0, p)), none, none.astype(int), none, none.astype(int), np.zeros((0, p)))
    columns, tau, joint, frequency, numbers, lost = (np.concatenate(one) for one in zip(*found, strict=True))
    return Rows(columns, tau, joint, frequency, numbers, lost if lost.any() else np.zeros((0, 0)))
