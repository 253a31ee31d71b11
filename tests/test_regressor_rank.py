"""Base parameters are as many as the rank of their regressor, stacked over states.

Of every tree, and of the spanning tree of every loop, the rank is exact: over a prime field, at random states. Where
loops close it is that of the drives along motions of the mechanism, where singular values leave a wide gap; how many
columns depend on others there stands in `docs/regressors.md`.
"""

from __future__ import annotations

import contextlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.algebra.finite_field import FiniteField, Needs, Redraw
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs.base_columns import base_columns
from symdyn.dynamics.outputs.derive import derive_one
from symdyn.graph import Op, reachable
from symdyn.scene import Scene, examples
from symdyn.scene.forces import FORCES

PAGE = Path(__file__).parent.parent / "docs" / "regressors.md"
CLOSED = ("four_bar", "rssr", "rsup", "slider_crank", "spatial_slider_crank")
"""Whose singular values leave a gap along motions from the start; a governor's arms hardly move there."""


def exact_rank(scene: Scene) -> tuple[int, int]:
    """Return rank and columns of the base regressor of a tree, over a prime field, stacked over random states."""
    w = Workspace(scene)
    entries = derive_one(w, "base_regressor").entries
    count = len(base_columns(w))
    wanted = Needs.of(reachable(entries))
    field = FiniteField(wanted.prime(1), 1, wanted)
    symbols = [x for x in reachable(list(entries)) if x.op is Op.SYMBOL]
    draw = np.random.default_rng(0)
    rows: list[list[int]] = []
    for _ in range(100 * (count + 2)):  # roots of four struts exist at one of sixteen points
        values = {x: int(draw.integers(1, 2**62)) % field.p for x in symbols}
        with contextlib.suppress(Redraw):
            found = field.evaluate(entries, values)
            rows += [found[k : k + count] for k in range(0, len(found), count)]
        if len(rows) >= (count + 2) * (len(entries) // count):
            break
    return rank(rows, field.p), count


def rank(rows: list[list[int]], p: int) -> int:
    """Return the rank of a matrix over the field of p elements, by elimination."""
    rows, found = [list(row) for row in rows], 0
    for column in range(len(rows[0])):
        pivot = next((k for k in range(found, len(rows)) if rows[k][column] % p), None)
        if pivot is None:
            continue
        rows[found], rows[pivot] = rows[pivot], rows[found]
        inverse = pow(rows[found][column], -1, p)
        head = rows[found] = [x * inverse % p for x in rows[found]]
        for k in range(found + 1, len(rows)):
            if factor := rows[k][column]:
                rows[k] = [(x - factor * y) % p for x, y in zip(rows[k], head, strict=True)]
        found += 1
    return found


@pytest.mark.wide(3)
@pytest.mark.heavy("quadruped")
@pytest.mark.long
@pytest.mark.parametrize("name", examples())
def test_no_column_of_a_tree_is_too_many(name: str) -> None:
    scene = symdyn.example(name)
    tied = ("constraints", "flows")
    kept = tuple(one for one in scene.elements if FORCES[one.kind].section not in tied and not one.is_taut)
    found, count = exact_rank(replace(scene, loops=(), elements=kept))
    assert found == count


LEAST = 1e-9
"""Singular value of columns of length one, over the largest, below which they depend on each other."""


def in_motion(name: str) -> tuple[int, int, float]:
    """Return rank and columns where loops close, along driven motions, and the least and the next singular value."""
    scene = symdyn.example(name)
    call = symdyn.load(scene, ["base_regressor", "forward_dynamics"])
    draw = np.random.default_rng(0)
    drives = [one for one in scene.drives if one]
    rows = []
    for k in range(6):
        given = ",".join(f"{one}={3 * draw.normal():.3f}*sin({1 + 3 * draw.random():.3f}*t + {k})" for one in drives)
        run = symdyn.simulate(scene, forces=given, until=3, every=0.05)
        q = np.stack([run[one] for one in scene.coordinates], axis=1)
        u = np.stack([run[one] for one in scene.velocities], axis=1)
        tau = np.where([bool(one) for one in scene.drives], draw.normal(size=u.shape) * 5, 0.0)
        found = call.forward_dynamics(q, u, tau)
        qdd = found[0] if isinstance(found, tuple) else found
        rows.append(call.base_regressor(q, u, qdd))
    Y = np.concatenate(rows).reshape(-1, rows[0].shape[-1])
    size = np.linalg.norm(Y, axis=0)
    values = np.linalg.svd(Y / np.where(size > 0, size, 1.0), compute_uv=False)
    count = int(np.sum(values > LEAST * values[0]))
    after = values[count] if count < len(values) else 0.0
    return count, len(values), float(after / values[count - 1])


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", CLOSED)
def test_columns_of_a_loop_depend_on_each_other_as_the_page_says(name: str) -> None:
    found, count, gap = in_motion(name)
    said = re.search(rf"^\| `{name}` \| (\d+) \| (\d+) \|$", PAGE.read_text(), re.MULTILINE)
    assert said is not None
    assert (int(said[1]), int(said[2])) == (count, found)
    assert gap < 1e-6
