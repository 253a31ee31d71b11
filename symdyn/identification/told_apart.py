"""Which combinations of parameters a motion does not tell, in words: what they are, why, and what motion would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.identification.directions import echelon
from symdyn.identification.filtered import Motion
from symdyn.identification.linear_model import LinearModel
from symdyn.scene import Scene

SMALL = 1e-3
"""Part of the largest share below which a parameter is no part of a combination."""

STILL = 1e-3
"""rad or m within which a joint stands still, if its noise is smaller."""

STRUCTURE = 1e-9
"""Part of its terms that a combination has at most in random motions, if no motion tells it."""

NEVER = "no motion tells them apart"
RICHER = "a richer motion would tell, as --excite finds"

MOST = 4
"""Parameters of a combination that are named; others are counted."""


@dataclass(frozen=True)
class Untold:
    """Parameters that data do not tell apart: along a direction forces are the same, and the scene's values stay.

    Attributes:
        combination: that direction, as a formula of their names.
        why: what the motion lacks, "" where that is not known.
        helps: what motion would tell it.
        parameters: the names in it.
    """

    combination: str
    why: str
    helps: str
    parameters: tuple[str, ...]

    @property
    def words(self) -> str:
        """All of it as one line."""
        several = len(self.parameters) > 1
        what = (
            f"along {self.combination} parameters are not told apart" if several else f"{self.combination} is not told"
        )
        why = f": {self.why}" if self.why else ""
        return f"{what}{why}; the scene's own value{'s stay' if several else ' stays'} there; {self.helps}"


def untold(model: LinearModel, directions: Array, scale: Array, motions: Sequence[Motion]) -> tuple[Untold, ...]:
    """Return the combinations that rows of `motions` do not tell, with reasons.

    Args:
        model: whose parameters they are.
        directions: orthonormal in units of `scale`, shape (u, p).
        scale: of the columns, shape (p,).
        motions: that were fitted.
    """
    if not len(directions):
        return ()
    found = []
    lacking = _lacking(model.scene, motions)
    generic = _generic(model, motions)
    size = np.linalg.norm(generic, axis=(0, 1))
    for row in echelon(directions):
        part = np.flatnonzero(np.abs(row) > SMALL * np.abs(row).max())
        part = part[np.argsort(-np.abs(row[part]), kind="stable")]
        names = tuple(model.names[k] for k in part)
        along = np.zeros(len(row))
        along[part] = row[part] / scale[part]
        formula = _formula(along[part], names)
        if np.linalg.norm(generic @ along) < STRUCTURE * np.linalg.norm(size * along):
            found.append(Untold(formula, NEVER, "leave a term out, or know one of them", names))
            continue
        joints = [j for j in range(generic.shape[1]) if np.abs(generic[:, j] @ along).max() > 1e-9]
        reasons = [lacking[j] for j in joints if j in lacking]
        why = "; ".join(dict.fromkeys(one[0] for one in reasons))
        helps = "; ".join(dict.fromkeys(one[1] for one in reasons))
        found.append(Untold(formula, why, helps or RICHER, names))
    return tuple(found)


def _formula(coefficients: Array, names: Sequence[str]) -> str:
    parts: list[str] = []
    for c, name in list(zip(coefficients / coefficients[np.abs(coefficients).argmax()], names, strict=True))[:MOST]:
        size = f"{abs(c):.3g}"
        text = f"({name})" if " + " in name and size != "1" else name
        text = text if size == "1" else f"{size} {text}"
        parts.append(f"{'- ' if c < 0 else '+ ' if parts else ''}{text}")
    more = len(names) - MOST
    return " ".join(parts) + (f" and {more} more" if more > 0 else "")


def _generic(model: LinearModel, motions: Sequence[Motion]) -> Array:
    """Return the regressor of random motions, shape (states, nv, p)."""
    rng = np.random.default_rng(0)
    nq, nv = motions[0].q.shape[1], motions[0].qd.shape[1]
    q, qd, qdd = rng.uniform(-1, 1, (200, nq)), rng.uniform(-1, 1, (200, nv)), rng.uniform(-1, 1, (200, nv))
    return np.nan_to_num(model.regressor(q, qd, qdd))


def _lacking(scene: Scene, motions: Sequence[Motion]) -> dict[int, tuple[str, str]]:
    """Return what the motion of each joint lacks, and what would help, by the index of its velocity."""
    found: dict[int, tuple[str, str]] = {}
    for j, velocity in enumerate(scene.velocities):
        name = velocity.removesuffix("_dot")
        rate = np.concatenate([one.qd[:, j] for one in motions])
        noise = max(float(one.noise[1, j]) for one in motions)
        far = max(float(np.abs(np.cumsum(one.qd[:, j]) * (one.t[1] - one.t[0])).max()) for one in motions)
        if far < STILL and np.abs(rate).max() < max(STILL, 6 * noise):
            found[j] = (f"{name} never moves", f"move {name}")
        elif np.ptp(rate) < max(6 * noise, 1e-3 * np.abs(rate).max()):
            found[j] = (
                f"{name} has one speed all the time, so that friction, offset and gravity look alike",
                f"move {name} at several speeds, both ways",
            )
        elif rate.min() > -3 * noise or rate.max() < 3 * noise:
            found[j] = (
                f"{name} turns one way only, so that dry friction looks like an offset",
                f"move {name} both ways",
            )
    return found
