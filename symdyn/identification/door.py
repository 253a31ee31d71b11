"""The door `identify`: logs of motion and driving forces in, base parameters with standard errors out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.errors import IdentifyError
from symdyn.identification.filtered import Flags, Motion, choose_band, motions, projected
from symdyn.identification.identification import Identification
from symdyn.identification.linear_model import LinearModel, linear_model
from symdyn.identification.log import Log, read_logs
from symdyn.identification.outliers import Outlier, far, stretches
from symdyn.identification.regression import Regression, Rows, solve
from symdyn.identification.told_apart import untold
from symdyn.identification.units import forces_off
from symdyn.identification.validation import Fit, blocks, mean_square
from symdyn.scene import SceneLike, bind, scene_of
from symdyn.scene.units import velocity_units
from symdyn.simulation.prescribed.forces import drive_names

SLOW = 3.0
"""Standard deviations of a velocity's noise within which a joint stands, where its dry friction jumps."""

ROUNDS = 4
"""Of leaving out outliers and fitting again."""


def identify(
    scene: SceneLike,
    data: Any,
    band: float | None = None,
    friction: str | Sequence[str] = (),
    hold_back: float = 0.0,
    outliers: bool = True,
    units: Mapping[str, str] | None = None,
    values: Mapping[str, object] | None = None,
    say: Callable[[str], None] | None = None,
) -> Identification:
    """Return the base parameters of a scene that measured motion and driving forces tell, with standard errors.

    >>> import numpy as np
    >>> import symdyn
    >>> scene = symdyn.example("pendulum")
    >>> motion, values = "q1=sin(t)+0.4*sin(2.7*t)", {"m": 1.2, "b": 0.03}
    >>> log = symdyn.inverse(scene, motion, times=np.linspace(0, 10, 1001), values=values)
    >>> found = symdyn.identify(scene, {"t": log.t, "q1": log["q1"], "tau1": log["tau1"]})
    >>> [f"{name} = {value:.3f}" for name, value in zip(found.names, found.after, strict=True)]
    ['mxR1 = 0.000', 'myR1 = -0.600', 'JxxR1 + JyyR1 = 0.300', 'b = 0.030']

    Args:
        scene: the mechanism; its own numbers are what parameters that the data do not tell keep.
        data: path of a CSV file with the columns t, coordinates and driving forces, as `simulate` writes them; arrays
            by name, a data frame or a run; or a list of such, a log each. Velocities and accelerations may be among
            them, else they are differentiated.
        band: highest frequency that is used, Hz; None takes it from where positions stand above their noise.
        friction: terms that joints with a drive have beside what the scene declares: "viscous", "coulomb", "offset",
            "armature".
        hold_back: share of every log, in contiguous blocks, that is not fitted and judges the result; 0 to 0.9.
        outliers: whether samples that no noise explains are left out; they are told.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg", "t": "ms"}.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        say: takes what a user should know, a line at a time.

    Raises:
        IdentifyError: with every fault of the data, one line each.
        SceneError: the file of the scene has faults.
        DerivationError: the scene has no driving forces.
    """
    scene = scene_of(scene)
    scene = bind(scene, values) if values else scene
    faults = []
    if band is not None and not (np.isfinite(band) and band > 0):
        faults.append(f"band = {band!r:.40}: give a frequency in Hz above zero, such as 10")
    if not 0 <= hold_back <= 0.9:
        faults.append(f"hold_back = {hold_back!r:.40}: give a share of the data, 0 to 0.9, such as 0.25")
    if faults:
        raise IdentifyError(faults)
    logs = read_logs(scene, data, units)
    _check_logs(logs, band)
    model = linear_model(scene, (friction,) if isinstance(friction, str) else tuple(friction))
    band = choose_band(logs) if band is None else band
    parts = [motions(log, band) for log in logs]
    moved = tuple(one for some, _ in parts for one in some)
    if not moved:
        raise IdentifyError([note for _, told in parts for note in told])
    found = _fitted(model, moved, band, hold_back, outliers)
    notes = [note for log, (_, told) in zip(logs, parts, strict=True) for note in (*log.notes, *told)]
    notes += [*_expected(model, logs, moved), *found.notes]
    lost = untold(model, found.regression.untold, found.regression.scale, moved)
    for one in lost:
        notes.append(one.words)
    if say is not None:
        for note in notes:
            say(note)
    return Identification(
        scene, model, logs, moved, band, found.regression, found.fits, tuple(found.outliers), lost, tuple(notes),
        found.predicted, found.used, found.held,
    )  # fmt: skip


def _check_logs(logs: Sequence[Log], band: float | None) -> None:
    """Raise IdentifyError for a log that counts twice, and for a band that samples cannot show."""
    faults = []
    for k, log in enumerate(logs):
        if any(np.array_equal(log.t, one.t) and np.array_equal(log.tau, one.tau) for one in logs[:k]):
            faults.append(f"{log.source}: is a log that is given already; twice the same tells no more, leave it out")
        half = 0.5 / float(np.median(np.diff(log.t)))
        if band is not None and band > half:
            faults.append(
                f"{log.source}: band = {band:.6g} Hz: samples show no more than {half:.6g} Hz, half of their rate; "
                "give less, or leave it out"
            )
    if faults:
        raise IdentifyError(faults)


def _expected(model: LinearModel, logs: Sequence[Log], moved: Sequence[Motion]) -> list[str]:
    """Return notes on driving forces that are far from what the scene expects of the motion."""
    if not np.isfinite(model.prior).all():
        return []
    tau = np.concatenate([one.tau for one in moved])
    before = np.concatenate([model.regressor(one.q, one.qd, one.qdd) @ model.prior for one in moved])
    driven = [j for j in model.rows if model.scene.drives[j]]
    names = [drive_names(model.scene)[j] for j in driven]
    kinds = [velocity_units(model.scene)[j] for j in driven]
    return forces_off(logs[0].source, names, kinds, tau[:, driven], before[:, driven])


class _Fitted:
    """What a fit found, gathered."""

    regression: Regression
    fits: tuple[Fit, ...]
    outliers: list[Outlier]
    notes: list[str]
    predicted: tuple[Array, ...]
    used: tuple[Flags, ...]
    held: tuple[Flags, ...]


def _fitted(model: LinearModel, moved: tuple[Motion, ...], band: float, hold_back: float, leave_out: bool) -> _Fitted:
    """Return the regression of motions, outliers left out."""
    scene = model.scene
    nv = len(scene.velocities)
    Ys = [model.regressor(one.q, one.qd, one.qdd) for one in moved]
    _check_finite(Ys, moved)
    drawn = [_drawn(model, one, Y) for one, Y in zip(moved, Ys, strict=True)]
    used = [_moving(model, one) for one in moved]
    parts = [blocks(len(one.t), hold_back) for one in moved]
    held = []
    for one, some in zip(moved, parts, strict=True):
        mask = np.zeros(len(one.t), bool)
        for part, back in some:
            mask[part] = back
        held.append(mask)
    out = [np.zeros(one.tau.shape, bool) for one in moved]
    for k in range(ROUNDS if leave_out else 1):
        rows = _rows(model, moved, Ys, drawn, used, parts, False)
        if len(rows.tau) < len(model.names) // 4 + 2:
            raise IdentifyError(
                f"{moved[0].source}: the data leave {len(rows.tau)} rows below {band:.3g} Hz for "
                f"{len(model.names)} parameters; give a longer log, or a wider band"
            )
        regression = solve(model.names, rows, model.prior, band, nv)
        residuals = [one.tau - Y @ regression.estimate for one, Y in zip(moved, Ys, strict=True)]
        if not leave_out or k == ROUNDS - 1:
            break
        new = _far(residuals, used, [one.tau for one in moved], model.rows)
        if not any(one.any() for one in new):
            break
        out = [one | more for one, more in zip(out, new, strict=True)]
        used = [one & ~more for one, more in zip(used, new, strict=True)]
    found = _Fitted()
    found.regression = regression
    found.used, found.held = tuple(used), tuple(held)
    found.predicted = tuple(Y @ regression.estimate for Y in Ys)
    names = drive_names(scene)
    found.outliers = [
        one
        for motion, mask, left in zip(moved, out, residuals, strict=True)
        for one in stretches(mask, left, motion.t, motion.source, names)
    ]
    found.fits = _fits(model, moved, Ys, drawn, used, parts, regression)
    found.notes = [*_standing(model, moved), *_told_of(found.outliers, out)]
    return found


def _far(residuals: list[Array], used: list[Flags], taus: list[Array], rows: tuple[int, ...]) -> list[Flags]:
    """Return which samples are far off, of each motion."""
    lengths = np.cumsum([len(one) for one in residuals])[:-1]
    every = far(np.concatenate(residuals), np.concatenate(used), np.concatenate(taus))
    passive = [j for j in range(every.shape[1]) if j not in rows]
    every[:, passive] = False
    return np.split(every, lengths)


def _told_of(found: list[Outlier], out: list[Flags]) -> list[str]:
    count = int(sum(one.sum() for one in out))
    if not count:
        return []
    worst = sorted(found, key=lambda one: -abs(one.worst))[:3]
    where = "; ".join(f"{one.drive} at t = {one.start:.6g} s, off by {one.worst:.3g}" for one in worst)
    return [f"{count} sample{'s' * (count != 1)} of a force left out that no noise explains: {where}"]


def _check_finite(Ys: list[Array], moved: tuple[Motion, ...]) -> None:
    for Y, one in zip(Ys, moved, strict=True):
        bad = np.argwhere(~np.isfinite(Y))
        if len(bad):
            raise IdentifyError(
                f"{one.source}: at t = {one.t[bad[0][0]]:.6g} s the regressor has no finite value, as at a dead "
                "centre; leave such samples out"
            )


def _moving(model: LinearModel, motion: Motion) -> Flags:
    """Return which samples of which joints are fitted: not where dry friction jumps within the noise of a velocity."""
    used = np.ones(motion.tau.shape, bool)
    for j in model.jumps:
        used[:, j] = np.abs(motion.qd[:, j]) > SLOW * motion.noise[1, j]
    return used


def _standing(model: LinearModel, moved: Sequence[Motion]) -> list[str]:
    """Return a note on samples of joints that were left out as `_moving` says."""
    left = 1 - np.concatenate([_moving(model, one) for one in moved]).mean(axis=0)
    names = drive_names(model.scene)
    parts = [f"{100 * left[j]:.2g} % of {names[j]}" for j in model.rows if left[j] > 0]
    return [f"left out where a joint stands, where dry friction jumps: {', '.join(parts)}"] if parts else []


def _drawn(model: LinearModel, motion: Motion, Y: Array) -> Array | None:
    """Return one draw of what noise of the motion makes of its regressor, None where nothing was differentiated."""
    if not motion.noise.any() or motion.q.shape != motion.qd.shape:
        return None
    rng = np.random.default_rng(0)
    step = float(motion.t[1] - motion.t[0])
    frequency = np.fft.rfftfreq(len(motion.t), step)
    shape = (len(frequency), motion.q.shape[1])
    white = (rng.normal(size=shape) + 1j * rng.normal(size=shape)) * (frequency <= motion.band)[:, None]
    turn = 2j * np.pi * frequency[:, None]
    parts = [np.fft.irfft(white * turn**k, len(motion.t), axis=0) for k in range(3)]
    level = motion.noise[1] / np.maximum(np.std(parts[1], axis=0), 1e-300)
    moved: Array = model.regressor(
        *(x + p * level for x, p in zip((motion.q, motion.qd, motion.qdd), parts, strict=True))
    )
    found: Array = moved - Y
    return found


def _rows(
    model: LinearModel,
    moved: Sequence[Motion],
    Ys: Sequence[Array],
    drawn: Sequence[Array | None],
    used: Sequence[Flags],
    parts: Sequence[Sequence[tuple[slice, bool]]],
    back: bool,
) -> Rows:
    """Return the rows of the parts that are held back, or of those that are not."""
    found: list[tuple[Any, ...]] = []
    group = 0
    for motion, Y, draw, mask, some in zip(moved, Ys, drawn, used, parts, strict=True):
        step = float(motion.t[1] - motion.t[0])
        for part, held in some:
            n = part.stop - part.start
            count = int(min(n, 2 * motion.band * step * n))
            if held is not back or count < 1:
                continue
            frequency = np.arange(count) / (2 * step * n)
            for j in model.rows:
                take = mask[part, j].astype(float)
                if not take.any():
                    continue
                own = projected(np.column_stack([Y[part, j], motion.tau[part, j]]) * take[:, None], count)
                lost = (
                    np.zeros((count, Y.shape[2])) if draw is None else projected(draw[part, j] * take[:, None], count)
                )
                numbers = group + np.arange(count)
                found.append((own[:, :-1], own[:, -1], np.full(count, j), frequency, numbers, lost))
            group += count
    if not found:
        p = len(model.names)
        none = np.zeros(0)
        return Rows(np.zeros((0, p)), none, none.astype(int), none, none.astype(int), np.zeros((0, p)))
    Y, tau, joint, frequency, numbers, lost = (np.concatenate(one) for one in zip(*found, strict=True))
    return Rows(Y, tau, joint, frequency, numbers, lost if lost.any() else np.zeros((0, 0)))


def _fits(
    model: LinearModel,
    moved: Sequence[Motion],
    Ys: Sequence[Array],
    drawn: Sequence[Array | None],
    used: Sequence[Flags],
    parts: Sequence[Sequence[tuple[slice, bool]]],
    regression: Regression,
) -> tuple[Fit, ...]:
    """Return how well each driving force is predicted; root mean squares over samples, in the band."""
    own = _rows(model, moved, Ys, drawn, used, parts, False)
    other = _rows(model, moved, Ys, drawn, used, parts, True)
    back = {held: sum(p.stop - p.start for some in parts for p, one in some if one is held) for held in (False, True)}
    units, names = velocity_units(model.scene), drive_names(model.scene)
    known = bool(np.isfinite(model.prior).all())
    found = []
    for j in model.rows:

        def size(rows: Rows, left: Array, held: bool) -> float:
            mine = left[rows.joint == j]  # noqa: B023  called at once
            return mean_square(mine) * float(np.sqrt(len(mine) / back[held])) if len(mine) else float("nan")

        found.append(
            Fit(
                names[j],
                "N m" if units[j] == "rad" else "N",
                size(own, own.tau, False),
                size(own, own.tau - own.Y @ regression.estimate, False),
                size(own, own.tau - own.Y @ model.prior, False) if known else float("nan"),
                size(other, other.tau - other.Y @ regression.estimate, True),
            )
        )
    return tuple(found)
