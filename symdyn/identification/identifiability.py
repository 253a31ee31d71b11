"""Which combinations of parameters a motion does not tell, in words: what they are, why, and what motion would help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.identification.bounds import fits
from symdyn.identification.directions import echelon
from symdyn.identification.filtered import Motion
from symdyn.identification.fitting import Fitted
from symdyn.identification.gains import Gains
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.payload import Carried
from symdyn.scene import Scene
from symdyn.simulation.prescribed import drive_names

SMALL = 1e-3
"""Part of the largest share below which a parameter is no part of a combination."""

STILL = 1e-3
"""rad or m within which a joint stands still, if its noise is smaller."""

STRUCTURE = 1e-9
"""Part of its terms that a combination has at most in random motions, if no motion tells it."""

NEVER = "no motion tells them apart"
RICHER = "a richer motion would tell"

UNFELT = "its drive feels nothing of known size"
WEIGH = "a payload that it feels would tell, or a gain that is known, as in --units {}=0.12*A"

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


def untold(
    model: LinearModel, carried: Carried, shown: Mapping[int, str], fitted: Fitted, places: Sequence[int]
) -> tuple[Untold, ...]:
    """Return the combinations that the rows of a fit do not tell, with reasons.

    Args:
        model: whose parameters they are.
        carried: payloads by log.
        shown: what drives show that do not show their force, by the number of their velocity.
        fitted: the fit.
        places: of the log of each motion.
    """
    regression = fitted.regression
    if not len(regression.untold):
        return ()
    told = []
    lacking = _lacking(model.scene, fitted.motions)
    generic = _generic(model, carried, shown, fitted, sorted(set(places)))
    size = np.linalg.norm(generic, axis=(0, 1))
    first_gain = len(regression.names) - len(shown)
    for row in echelon(regression.untold):
        part = np.flatnonzero(np.abs(row) > SMALL * np.abs(row).max())
        part = part[np.lexsort((-np.abs(row[part]), part < first_gain))]
        names = tuple(regression.names[k] for k in part)
        along = np.zeros(len(row))
        along[part] = row[part] / regression.scale[part]
        formula = _formula(along[part], names)
        if np.linalg.norm(generic @ along) < STRUCTURE * np.linalg.norm(size * along):
            why, helps = NEVER, "leave a term out, or know one of them"
            if part[0] >= first_gain:
                why, helps = UNFELT, WEIGH.format(drive_names(model.scene)[list(shown)[part[0] - first_gain]])
            told.append(Untold(formula, why, helps, names))
            continue
        joints = [j for j in range(generic.shape[1]) if np.abs(generic[:, j] @ along).max() > 1e-9]
        reasons = [lacking[j] for j in joints if j in lacking]
        why = "; ".join(dict.fromkeys(one[0] for one in reasons))
        helps = "; ".join(dict.fromkeys(one[1] for one in reasons))
        told.append(Untold(formula, why, helps or richer(model.scene), names))
    return tuple(told)


def richer(scene: Scene) -> str:
    """Return what helps where nothing else is known; --excite only where it finds motions."""
    return RICHER if fits(scene) else f"{RICHER}, as --excite finds"


def _formula(coefficients: Array, names: Sequence[str]) -> str:
    parts: list[str] = []
    for c, name in list(zip(coefficients / coefficients[np.abs(coefficients).argmax()], names, strict=True))[:MOST]:
        size = f"{abs(c):.3g}"
        text = f"({name})" if " + " in name and size != "1" else name
        text = text if size == "1" else f"{size} {text}"
        parts.append(f"{'- ' if c < 0 else '+ ' if parts else ''}{text}")
    more = len(names) - MOST
    return " ".join(parts) + (f" and {more} more" if more > 0 else "")


def _generic(
    model: LinearModel, carried: Carried, shown: Mapping[int, str], fitted: Fitted, places: Sequence[int]
) -> Array:
    """Return the columns of random motions with the payloads of each log, shape (states, nv, p)."""
    rng = np.random.default_rng(0)
    nq, nv = fitted.motions[0].q.shape[1], fitted.motions[0].qd.shape[1]
    state = rng.uniform(-1, 1, (200, nq)), rng.uniform(-1, 1, (200, nv)), rng.uniform(-1, 1, (200, nv))
    gains = Gains(shown, fitted.gains, fitted.regression.estimate[: len(fitted.regression.names) - len(shown)])
    loads = dict[tuple[bytes, bytes], int]()
    for place in places:
        loads.setdefault((carried.unknown[place].tobytes(), carried.known[place].tobytes()), place)
    columns = []
    for place in loads.values():
        both = np.nan_to_num(np.concatenate([model.regressor(*state), carried.columns(model, place, *state)], axis=2))
        joint = np.tile(np.arange(nv), len(both))
        columns.append(gains.columns(both.reshape(len(joint), -1), joint).reshape(len(both), nv, -1))
    return np.concatenate(columns)


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
