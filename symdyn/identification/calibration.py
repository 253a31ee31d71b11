"""Calibration of a geometry: parameters with which a point is where it was measured: `calibrate`.

    min  Σ (w (measured - pose(θ; q)))²      θ: the scene's lengths and angles, zeros of coordinates, frames

Gauss and Newton's search: each step is the weighted least squares of identification, with the derivatives of the pose
at the parameters so far as regressor. What is estimated is chosen by QR with pivoting: the scene's own parameters and
zeros of coordinates first, then frames of joints, then the point. A column that those before it make up keeps the
scene's value, as does a frame that would be known no better than `LOOSE`; what they are tied to is named.

References: Hollerbach, Khalil and Gautier, Springer Handbook of Robotics (2016), 6.2; Borm and Menq (1991).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, check_arguments, checked
from symdyn.draw import FilledFigure
from symdyn.errors import IdentifyError, UnknownNameError, choice, listed
from symdyn.frozen import dataclass, field, replace
from symdyn.identification.filtered import Flags
from symdyn.identification.geometry import GeometricModel, read_poses
from symdyn.identification.identification import NEVER, STRUCTURE, NotIdentifiable, formula
from symdyn.identification.identified_scene import Identified
from symdyn.identification.regression import Regression, Rows, far, solve
from symdyn.identification.report import written
from symdyn.identification.report_sections import SURE, figure, sure
from symdyn.scene import Scene, SceneLike, Written, scene_of
from symdyn.shown import Shown
from symdyn.simulation import write_picture
from symdyn.table import Table

TELLS, LOOSE = 1e-5, 0.03
"""Part of a column that those before it must leave; standard error, m and rad, up to which a frame is estimated."""

ORDER, TIED, SAME = 1e-3, 0.01, 1e-7
"""By how much a column counts less than the one before it, so that of equal ones the first is chosen; part of a column
below which another is not named as tied to it; and what is left of one that no pose tells from others."""

ASTRAY, FAR = 0.3, 30.0
"""Part of how far positions lie apart that may be left of them, and by what factor that may differ from the scene's:
what is beyond are no poses of this point, or other units."""

ENOUGH = 10
"""Poses beyond what the parameters take, from which on one can be told that no noise explains."""

STANDS = "the others stand for it"

STEPS, ROUNDS = 60, 12
"""Of one search; of searches with other parameters or fewer outliers."""

KINDS = (("position", "mm", slice(0, 3)), ("orientation", "mrad", slice(3, 6)))
"""Of errors, a thousand of the unit of residuals."""


@dataclass(frozen=True, eq=False)
class Calibration(Shown):
    """Geometric parameters found from measured poses.

    Attributes:
        scene: as it was declared.
        model: the pose of the point over them.
        regression: least squares of the last step: estimates, errors, covariance, condition number.
        units: of the parameters, shape (p,).
        before: their values in the scene, shape (p,).
        residuals: measured less predicted, before and after, shapes (N, 6): positions, m, and small turns about the
            axes of the ground, rad; NaN for what was not measured.
        used: which poses were fitted, shape (N,).
        not_identifiable: what keeps the scene's values, with what it is tied to.
    """

    scene: Scene
    model: GeometricModel = field(repr=False)
    regression: Regression = field(repr=False)
    units: tuple[str, ...]
    before: Array = field(repr=False)
    residuals: tuple[Array, Array] = field(repr=False)
    used: Flags = field(repr=False)
    not_identifiable: tuple[NotIdentifiable, ...] = field(repr=False)

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {a:.3g} -> {b:.3g} {unit}" for name, unit, a, b, *_ in self.fits)
        return f"<Calibration of {self.scene.name}: {len(self.names)} parameters, {told}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters that were estimated, shape (p,)."""
        return self.regression.names

    @property
    def after(self) -> Array:
        """Their estimates, shape (p,)."""
        return self.regression.estimate

    @property
    def errors(self) -> Array:
        """Their standard errors, shape (p,)."""
        return self.regression.errors

    @property
    def calibrated(self) -> Scene:
        """The scene with them: its own parameters have other values, joints and the point other placements."""
        return self.model.written(dict(zip(self.names, self.after.tolist(), strict=True)))

    def text(self, format: str, about: Sequence[str] = ()) -> Written:
        """Return the calibrated scene as a key of the table of formats, "toml" or "urdf", with comments on top."""
        check_arguments(Calibration.text, locals(), IdentifyError)
        return written(Identified(self.calibrated, {}, None, None, ()), format, about)

    @property
    def outliers(self) -> tuple[int, ...]:
        """Numbers of the poses that no noise explains and that were not fitted; the first is 1."""
        return tuple((np.flatnonzero(~self.used) + 1).tolist())

    @property
    def observability(self) -> float:
        """Index of Borm and Menq: geometric mean of the singular values of the rows, in m and rad, over √poses."""
        sizes = np.linalg.svd(self.regression.Y, compute_uv=False)
        return float(np.exp(np.mean(np.log(sizes))) / np.sqrt(self.used.sum()))

    @property
    def fits(self) -> tuple[tuple[str, str, float, float, float, float], ...]:
        """Of positions and of turns: name, unit, root mean square before and after, largest error before and after."""
        found = list[tuple[str, str, float, float, float, float]]()
        for name, unit, sizes in self._sizes():
            rms = [float(np.sqrt(np.mean(one[self.used] ** 2))) for one in sizes]
            found.append((name, unit, *rms, *(float(one[self.used].max()) for one in sizes)))  # type: ignore[arg-type]
        return tuple(found)

    def _sizes(self) -> list[tuple[str, str, list[Array]]]:
        """Return kind, unit and size of errors before and after, shapes (N,)."""
        found = []
        for name, unit, part in KINDS:
            if not np.isnan(self.residuals[0][:, part]).all():
                both = [1e3 * np.linalg.norm(np.nan_to_num(one[:, part]), axis=1) for one in self.residuals]
                found.append((name, unit, both))
        return found

    def interval(self, level: float = 0.95) -> Array:
        """Return the interval of each parameter that holds its value with this probability, shape (p, 2)."""
        check_arguments(Calibration.interval, locals(), IdentifyError)
        return self.regression.interval(level)

    def __getitem__(self, name: str) -> float:
        """Return one estimate by name; UnknownNameError if there is none."""
        if name not in self.names:
            raise UnknownNameError(f"{self.scene.name}: {name} was not estimated; {choice(name, self.names)}")
        return float(self.after[self.names.index(name)])

    @property
    def tables(self) -> tuple[Table[str], ...]:
        """Parameters with their errors, and how far the point was off before and after."""
        columns = zip(self.names, self.units, self.before, self.after, self.errors, self.interval(), strict=True)
        rows = [(n, u, figure(a), figure(b), *sure(e, ends, b)[:3]) for n, u, a, b, e, ends in columns]
        heads = ("parameter", "unit", "before", "after", *SURE[:3])
        fits = [(name, unit, *(figure(x, 3) for x in numbers)) for name, unit, *numbers in self.fits]
        of = f"Errors of {self.model.point.name}, {self.used.sum()} poses"
        told = ("error", "unit", "rms before", "after", "largest before", "after")
        return (
            Table(heads, rows, range(2, 7), f"Geometric parameters of {self.scene.name}"),
            Table(told, fits, range(2, 6), of),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know, one line each."""
        found = [one.words for one in self.not_identifiable if one.helps != STANDS]
        if alike := [one.combination for one in self.not_identifiable if one.helps == STANDS]:
            found.append(f"no motion separates these, one of each keeps the scene's value: {'; '.join(alike)}")
        if self.regression.dof < ENOUGH * np.isfinite(self.residuals[0][0]).sum():
            found.append("too few poses to tell one that no noise explains: all were fitted")
        if self.outliers:
            many = "s" * (len(self.outliers) > 1)
            found.append(f"pose{many} {listed(map(str, self.outliers))}: not fitted, no noise explains what is left")
        return tuple(found)

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as JSON values."""
        keys, fit = ("name", "unit", "before", "after", "standard_error"), ("of", "unit", "rms", "largest")
        rows = zip(self.names, self.units, *(x.tolist() for x in (self.before, self.after, self.errors)), strict=True)
        lost = [{"combination": x.combination, "why": x.why, "what_helps": x.helps} for x in self.not_identifiable]
        return {
            "scene": self.scene.name,
            "point": self.model.point.name,
            "parameters": [dict(zip(keys, row, strict=True)) for row in rows],
            "fits": [dict(zip(fit, (n, u, x[:2], x[2:]), strict=True)) for n, u, *x in self.fits],
            "condition": self.regression.condition,
            "observability": self.observability,
            "degrees_of_freedom": self.regression.dof,
            "outliers": list(self.outliers),
            "not_identifiable": lost,
        }

    def save_plot(self, file: str | Path) -> None:
        """Write the error of every pose before and after to a .svg, .pdf, .png or .html file."""
        check_arguments(Calibration.save_plot, locals(), IdentifyError)
        shown = self._sizes()

        def fill(made: Any) -> None:
            for axis, (name, unit, sizes) in zip(made.subplots(len(shown), squeeze=False)[:, 0], shown, strict=True):
                for label, size in zip(("before", "after"), sizes, strict=True):
                    axis.semilogy(np.arange(1, len(size) + 1), np.maximum(size, 1e-12), ".", label=label)
                axis.set(xlabel="pose", ylabel=f"{name}, {unit}")
                axis.legend()

        drawn = FilledFigure(f"Errors of {self.model.point.name}", (8.0, 2.8 * len(shown)), fill)
        write_picture(Path(file), f"Calibration of {self.scene.name}", drawn.picture)


@checked(IdentifyError)
def calibrate(
    scene: SceneLike,
    data: Any,
    point: str | None = None,
    parameters: str | Sequence[str] | None = None,
    outliers: bool = True,
    units: Mapping[str, str] | None = None,
    values: Mapping[str, object] | None = None,
) -> Calibration:
    """Calibrate the geometry of a scene by measured poses of a point, with standard errors.

    >>> import numpy as np
    >>> import symdyn
    >>> q1, q2 = np.random.default_rng(0).uniform(-2, 2, (2, 30))
    >>> poses = {"q1": q1, "q2": q2, "x": 0.41 * np.sin(q1) + 0.3 * np.sin(q1 + q2)}
    >>> known = {"m1": 1, "m2": 1, "h1": 0.4, "h2": 0.3, "g": 9.81}
    >>> round(symdyn.calibrate(symdyn.example("two_link"), poses, values=known)["h1"], 9)
    0.41

    Args:
        scene: the mechanism; its parameters have values, near the true ones.
        data: a CSV file, a data frame or arrays by name, a row a pose: the coordinates that move the point, and its
            position x, y, z, m, all or some, in the ground frame, also as tool.x; and, where it was measured, its
            orientation qx, qy, qz, qw, or roll, pitch, yaw, or rx, ry, rz (a rotation vector), rad.
        point: name of a point, or of a body for its frame; None for the only point of the scene.
        parameters: names or patterns of those to estimate: the scene's own, zeros of coordinates such as "q2_offset",
            corrections of frames such as "elbow.x" or "tool.rz"; "*" for all. None takes the scene's own parameters
            that move the point, and all corrections where it has none.
        outliers: whether poses that no noise explains are left out; they are reported.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg", "x": "mm"}.
        values: of parameters, in place of those that the scene gives.

    Raises:
        IdentifyError: with every fault of the data; parameters that do not move the point, too few poses.
        SceneError: the file of the scene has faults.
        SimulateError: parameters without a value.
    """
    model = GeometricModel.of(scene_of(scene, values), point)
    poses = Poses(*read_poses(model, data, units or {}))
    return _searched(model, poses, _asked(model, poses, parameters), bool(outliers))


@dataclass(frozen=True)
class Poses:
    """Coordinates, shape (N, n), positions, shape (N, 3), and orientations of the point, as of `read_poses`."""

    q: Array
    p: Array
    R: Array | None

    def rows(self, model: GeometricModel, values: Array) -> tuple[Array, Array]:
        """Return measured less predicted, shape (N, 6), and the derivatives of what is predicted, shape (N, 6, p)."""
        from scipy.spatial.transform import Rotation

        p, R, J = model.at(values, self.q)
        turned = np.full_like(p, np.nan)
        if self.R is not None:
            turned = Rotation.from_matrix(self.R @ R.swapaxes(1, 2)).as_rotvec()
        return np.hstack([self.p - p, turned]), J

    @property
    def spread(self) -> float:
        """Root mean square distance of the positions from their mean, m."""
        return float(np.sqrt(np.nansum(np.nanvar(self.p[:, self.seen[:3]], axis=0))))

    @property
    def seen(self) -> Flags:
        """Which of the six were measured."""
        return np.append(np.isfinite(self.p).all(axis=0), [self.R is not None] * 3)


def _generic(model: GeometricModel, values: Array) -> Array:
    """Return the derivatives of the pose in random states, shape (60, 6, p)."""
    return model.at(values, np.random.default_rng(0).uniform(-1.5, 1.5, (60, len(model.coordinates))))[2]


def _asked(model: GeometricModel, poses: Poses, parameters: str | Sequence[str] | None) -> list[int]:
    """Return the numbers of the parameters to estimate; IdentifyError for a name of nothing that moves the point."""
    sizes = np.linalg.norm(_generic(model, model.values)[:, poses.seen], axis=(0, 1))
    names, moving = model.names, [n for n, size in zip(model.names, sizes, strict=True) if size > STRUCTURE]
    if parameters is None:
        own = [name for name in moving if name not in model.corrections]
        return [names.index(name) for name in own or moving]
    found, faults = dict[int, None](), list[str]()
    for pattern in (parameters,) if isinstance(parameters, str) else parameters:
        hits = [names.index(name) for name in moving if fnmatchcase(name, pattern)]
        there = pattern in (*names, *(one.name for one in model.scene.parameters))
        if not hits:
            why = (
                f"{pattern} does not move {model.point.name} as it was measured" if there else f"there is no {pattern}"
            )
            faults.append(f"parameters: {why}; {choice(pattern, moving)}")
        found |= dict.fromkeys(hits)
    if not found and not faults:
        faults.append(f"parameters: none is named; give {listed(moving[:9])}")
    if faults:
        raise IdentifyError(faults)
    return list(found)


def _more(model: GeometricModel, weighted: Array, free: Sequence[int], kept: Sequence[int]) -> list[int]:
    """Return which parameters are told beside those that are kept, by QR with pivoting, rank by rank."""
    from scipy.linalg import qr

    found, ranks = list(kept), {k: getattr(model.corrections.get(model.names[k]), "rank", 0) for k in free}
    for rank in sorted(set(ranks.values())):
        sizes = {k: float(np.linalg.norm(weighted[:, k])) for k in free if ranks[k] == rank and k not in found}
        part = [k for k, size in sizes.items() if size > 0]
        basis = np.linalg.qr(weighted[:, found])[0]
        own = weighted[:, part] * [(1 - ORDER * i) / sizes[k] for i, k in enumerate(part)]
        for _ in range(2):  # twice is enough (Kahan)
            own = own - basis @ (basis.T @ own)
        R, order = qr(own, mode="r", pivoting=True) if part else (np.zeros((0, 0)), ())
        told = [(part[k], left) for k, left in zip(order, np.abs(np.diag(R)), strict=False) if left > TELLS]
        found += [k for k, left in told if rank == 0 or left * sizes[k] * LOOSE > 1]
    return found[len(kept) :]


def _searched(model: GeometricModel, poses: Poses, free: Sequence[int], outliers: bool) -> Calibration:
    """Search, with more parameters as errors fall, and without the poses that no noise explains.

    Raises:
        IdentifyError: too few poses, or ones that tell nothing; no parameters fit.
    """
    values, kept, used = model.values, list[int](), np.ones(len(poses.q), dtype=np.bool_)
    name, seen, regression = model.point.name, poses.seen, None
    missed, J = first = poses.rows(model, values)
    expected = replace(poses, p=poses.p - missed[:, :3]).spread
    if expected > 0 and not 1 / FAR < poses.spread / expected < FAR and seen[:3].any():
        raise _astray(model)
    for _ in range(ROUNDS):
        left, count = missed[used][:, seen], int(used.sum()) * int(seen.sum())
        scatter = float(np.linalg.norm(left)) / np.sqrt(max(1, count - len(kept)))
        weighted = J[used][:, seen].reshape(count, -1) / max(scatter, 1e-15)
        more = _more(model, weighted, free, kept)
        kept = sorted([*kept, *more])
        if not kept:
            raise IdentifyError(
                f"{model.scene.name}: these poses of {name} tell none of {listed(model.names[k] for k in free[:9])}; "
                "measure poses that differ more"
            )
        if count <= len(kept):
            raise IdentifyError(
                f"{model.scene.name}: {int(used.sum())} poses give {count} numbers, too few for {len(free)} "
                f"parameters; measure at least {len(free) // int(seen.sum()) + 2}, some fifty are better, or name fewer"
            )
        values, regression, (missed, J) = _fitted(model, poses, values, kept, used, (missed, J))
        size = np.hstack([poses.p, np.ones_like(poses.p)])
        told = outliers and count - len(kept) >= ENOUGH * seen.sum()
        out = far(missed[:, seen], np.repeat(used[:, None], seen.sum(), axis=1), size[:, seen]).any(axis=1) & told
        used = used & ~out
        if not more and not out.any():
            break
    assert regression is not None, "one round at least"
    if poses.spread and np.nansum(missed[used, :3] ** 2) > (ASTRAY * poses.spread) ** 2 * used.sum():
        raise _astray(model)
    G, weighted = _generic(model, values), J[used][:, seen].reshape(-1, J.shape[2])
    tied = tuple(_tied(model, weighted, (G[:, seen], G), k, kept) for k in free if k not in kept)
    units = tuple(model.units[k] for k in kept)
    return Calibration(model.scene, model, regression, units, model.values[kept], (first[0], missed), used, tied)


def _fitted(
    model: GeometricModel, poses: Poses, values: Array, kept: list[int], used: Flags, there: tuple[Array, Array]
) -> tuple[Array, Regression, tuple[Array, Array]]:
    """Return the values that fit best, by Gauss and Newton's search, its last regression, and the rows there.

    Raises:
        IdentifyError: it does not end.
    """
    missed, J = there
    kind = np.tile(np.repeat([0, 1], 3)[poses.seen], int(used.sum()))
    for _ in range(STEPS):
        Y, left = J[used][:, poses.seen][:, :, kept].reshape(-1, len(kept)), missed[used][:, poses.seen].ravel()
        rows = Rows(Y, left + Y @ values[kept], kind, np.zeros(len(Y)), np.arange(len(Y)))
        found = solve([model.names[k] for k in kept], rows, values[kept], 1.0, 2)
        step = found.estimate - values[kept]
        small = bool(np.all(np.abs(step) <= np.maximum(1e-13 * (1 + np.abs(values[kept])), 1e-7 * found.errors)))
        for _ in range(20):
            trial = values.copy()
            trial[kept] += step
            missed, J = poses.rows(model, trial)
            now = np.linalg.norm(missed[used][:, poses.seen].ravel() * found.weights)
            if small or now <= np.linalg.norm(left * found.weights) * (1 + 1e-9):
                break
            step = step / 2
        values = trial
        if small or np.abs(step).max() < 1e-14:
            return values, found, (missed, J)
    raise _astray(model)


def _astray(model: GeometricModel) -> IdentifyError:
    units = argument("units", {"q*": "deg", "x": "mm"})
    return IdentifyError(
        f"{model.scene.name}: no parameters near the scene's fit these poses; are columns in SI with radians ({units} "
        f"gives others), and is it {model.point.name} that was measured, in the ground frame?"
    )


def _tied(model: GeometricModel, weighted: Array, generic: Sequence[Array], k: int, kept: list[int]) -> NotIdentifiable:
    """Return what a parameter that keeps its value cannot be told from; generic derivatives: measured ones, and all."""
    shared = np.linalg.lstsq(weighted[:, kept], weighted[:, k], rcond=None)[0]
    same = [np.linalg.norm(G[..., k] - G[..., kept] @ shared) < SAME * np.linalg.norm(G[..., k]) for G in generic]
    why, helps = "these poses do not separate them", "poses that differ more would help"
    if same[0]:
        why, helps = NEVER, STANDS if same[1] else "orientations, or all of x, y, z, would help"
    share = np.abs(shared) * np.linalg.norm(weighted[:, kept], axis=0)
    with_it = np.flatnonzero(share > TIED * np.linalg.norm(weighted[:, k]))
    along, columns = np.array([1.0, *-shared[with_it]]), np.array([k, *np.array(kept)[with_it]])
    order = np.argsort(-np.abs(along), kind="stable")
    names = tuple(model.names[j] for j in columns[order])
    return NotIdentifiable(formula(along[order], names), why, helps, names)
