"""What identification returns: base parameters before and after, how sure they are, how well forces are predicted.

Combinations of parameters that are not identifiable are named: what they are, why, and what motion would help.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, check_arguments, native
from symdyn.errors import IdentifyError, UnknownNameError, choice
from symdyn.extras import package
from symdyn.frozen import dataclass
from symdyn.identification.bounds import fits
from symdyn.identification.filtered import Flags, Motion
from symdyn.identification.gains import Fitted, Gain, Gains
from symdyn.identification.linear_model import TERMS, LinearModel, base_frames
from symdyn.identification.log import GAINED, Log
from symdyn.identification.payload import Carried, Fit
from symdyn.identification.regression import Outlier, Regression, echelon
from symdyn.scene import INERTIAL, Scene
from symdyn.shown import Shown
from symdyn.table import Table
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]


SMALL = 1e-3
"""Part of the largest share below which a parameter is no part of a combination."""

STILL = 1e-3
"""rad or m within which a joint stands still, if its noise is smaller."""

STRUCTURE = 1e-9
"""Part of its terms that a combination has at most in random motions, if no motion makes it identifiable."""

NEVER = "no motion separates them"
RICHER = "a richer motion would help"

UNFELT = "nothing of known mass loads its drive"
WEIGH = "a payload of known mass that loads it would help, or a known gain"

MOST = 4
"""Parameters of a combination that are named; others are counted."""


@dataclass(frozen=True)
class NotIdentifiable:
    """A combination of parameters that is not identifiable: the forces do not depend on it, the scene's value stays."""

    combination: str  # that direction, as a formula of their names
    why: str  # what the motion lacks, "" where that is not known
    helps: str  # what would make it identifiable
    parameters: tuple[str, ...]  # the names in it

    @property
    def words(self) -> str:
        """All of it as one line."""
        why = f": {self.why}" if self.why else ""
        return f"{self.combination} is not identifiable{why}; the scene's value stays; {self.helps}"


def not_identifiable(
    model: LinearModel, carried: Carried, shown: Mapping[int, str], fitted: Fitted, places: Sequence[int]
) -> tuple[NotIdentifiable, ...]:
    """Return the combinations that a fit does not identify, with reasons.

    Args:
        model: whose parameters they are.
        carried: payloads by log.
        shown: what drives show that do not show their force, by the number of their velocity.
        fitted: the fit.
        places: of the log of each motion.
    """
    regression = fitted.regression
    if not len(regression.null_space):
        return ()
    found = []
    lacking = _lacking(model.scene, fitted.motions)
    generic = _generic(model, carried, shown, fitted, sorted(set(places)))
    size = np.linalg.norm(generic, axis=(0, 1))
    first_gain = len(regression.names) - len(shown)
    for row in echelon(regression.null_space):
        part = np.flatnonzero(np.abs(row) > SMALL * np.abs(row).max())
        part = part[np.lexsort((-np.abs(row[part]), part < first_gain))]
        names = tuple(regression.names[k] for k in part)
        along = np.zeros(len(row))
        along[part] = row[part] / regression.scale[part]
        written = formula(along[part], names)
        if np.linalg.norm(generic @ along) < STRUCTURE * np.linalg.norm(size * along):
            why, helps = NEVER, "leave a term out, or know one of them"
            if part[0] >= first_gain:
                drive = model.drives[list(shown)[part[0] - first_gain]]
                why, helps = UNFELT, f"{WEIGH}, as in {argument('units', {drive: '0.12*A'})}"
            found.append(NotIdentifiable(written, why, helps, names))
            continue
        joints = [j for j in range(generic.shape[1]) if np.abs(generic[:, j] @ along).max() > 1e-9]
        reasons = [lacking[j] for j in joints if j in lacking]
        why = "; ".join(dict.fromkeys(one[0] for one in reasons))
        helps = "; ".join(dict.fromkeys(one[1] for one in reasons))
        if not why and regression.felt(row):
            why = f"noise of the positions hides it in a band of {fitted.motions[0].band:.3g} Hz"
            helps = f"a narrower band, less noise or {richer(model.scene)}"
        found.append(NotIdentifiable(written, why, helps or richer(model.scene), names))
    return tuple(found)


def richer(scene: Scene) -> str:
    """Return what helps where nothing else is known; --excite only where it finds motions."""
    return RICHER if fits(scene) else f"{RICHER}, as {argument('excite', True, 'symdyn.identification.excite')} finds"


def formula(coefficients: Array, names: Sequence[str]) -> str:
    """Return a combination in words, its largest coefficient one."""
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
        joint = np.tile(np.arange(both.shape[1]), len(both))
        columns.append(gains.columns(both.reshape(len(joint), -1), joint).reshape(*both.shape[:2], -1))
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
                f"move {name} at several speeds, in both directions",
            )
        elif rate.min() > -3 * noise or rate.max() < 3 * noise:
            found[j] = (
                f"{name} moves in one direction only, so that dry friction looks like an offset",
                f"move {name} in both directions",
            )
    return found


_PAYLOAD, _FRAME = re.compile(r"^payload (\d+ )?"), re.compile(r"(R\d+)(_b)*$")
"""What stands before the parameter of a payload, and the link frame behind one of a body."""


@dataclass(frozen=True, eq=False)
class Identification(Shown):
    """Parameters identified from logs.

    Attributes:
        declared: the scene as it was declared; `scene` is the identified one.
        model: what the logs were held against; its scene has a parameter for every term of friction that was added.
        logs: as measured: each has `source`, `t`, `q`, `qd`, `qdd`, `tau` and `notes`.
        motions: filtered, at even times, divided into data that are fitted and validation data.
        band: highest frequency that was used, Hz.
        regression: least squares with all of its rows.
        fits: how well each driving force is predicted.
        outliers: samples that were left out.
        not_identifiable: combinations of parameters that the data do not identify, and why.
        notes: what a user should know, one line each.
        predicted: of each motion, Y β at every sample, shapes (N, nv).
        used: of each motion, which samples were fitted, shapes (N, nv).
        validation: of each motion, which samples are validation data, shapes (N,).
        gains: of drives that show something else than their force, such as currents.
        delay: of driving forces behind the motion, s, and its standard error, NaN where the log does not tell it.
        friction_terms: those that may be added to every drive.
        gain_units: what such drives may show.
    """

    friction_terms: ClassVar[tuple[str, ...]] = tuple(TERMS)
    gain_units: ClassVar[tuple[str, ...]] = tuple(GAINED)

    declared: Scene
    model: LinearModel
    logs: tuple[Log, ...]
    motions: tuple[Motion, ...]
    band: float
    regression: Regression
    fits: tuple[Fit, ...]
    outliers: tuple[Outlier, ...]
    not_identifiable: tuple[NotIdentifiable, ...]
    notes: tuple[str, ...]
    predicted: tuple[Array, ...]
    used: tuple[Flags, ...]
    validation: tuple[Flags, ...]
    gains: tuple[Gain, ...]
    delay: tuple[float, float]
    _identified: Callable[[Identification], Any]

    def __repr__(self) -> str:
        count = len(self.model.names)
        known = f"{int(self.regression.identifiable[:count].sum())} of {count} base parameters identifiable"
        told = f"condition number {self.regression.condition:.3g}; .frames tells what {[*self.frames, 'R1'][0]} is"
        return f"<Identification of {self.declared.name}: {known}, {told}>"

    @cached_property
    def scene(self) -> Scene:
        """The identified scene, as `symdyn.identification.identified` finds it, which tells more; errors as of it."""
        return self._identified(self).scene  # type: ignore[no-any-return]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, of what was not known of payloads, and of gains, shape (p,)."""
        return self.regression.names

    @cached_property
    def frames(self) -> dict[str, tuple[str, str, str]]:
        """Where the frames are that names of base parameters end with: of "R1" the body, the joint, the place.

        z is along the joint's axis; the place is told in the frame of the body. mxR1 is Σ m x, kg m, and JxxR1 is
        Σ m x², kg m², of the body and what joints further out pass on; JxxR1 + JyyR1 is the inertia about z.
        """
        parts = " + ".join(self.model.names[: self.model.base]).split(" + ")
        used = {found[1] for part in parts if (found := _FRAME.search(part))}
        return {name: where for name, where in base_frames(self.model.scene).items() if name in used}

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each of them, shape (p,); "" where the scene gives none."""
        said = {one.name: one.unit for one in self.model.scene.parameters}
        ten = {name: unit for name, unit, _ in INERTIAL} | {name.replace("I", "J"): unit for name, unit, _ in INERTIAL}
        gains = {f"gain {one.drive}": one.unit for one in self.gains}
        firsts = [_PAYLOAD.sub("", name).partition(" ")[0] for name in self.names]
        return tuple(
            gains.get(name) or said.get(one) or ten.get(_FRAME.sub("", one), "")
            for name, one in zip(self.names, firsts, strict=True)
        )

    @property
    def before(self) -> Array:
        """Their values in the scene, shape (p,); NaN where it has no number, and of what is not in it."""
        return np.append(self.model.prior, np.full(len(self.names) - len(self.model.prior), np.nan))

    @property
    def after(self) -> Array:
        """Their estimates, shape (p,)."""
        return self.regression.estimate

    @property
    def values(self) -> dict[str, float]:
        """Their estimates by name."""
        return dict(zip(self.names, self.after.tolist(), strict=True))

    @property
    def errors(self) -> Array:
        """Standard errors, shape (p,); NaN for a parameter that is not identifiable by itself."""
        return self.regression.errors

    @property
    def covariance(self) -> Array:
        """Covariance of the base parameters, shape (p, p)."""
        return self.regression.covariance

    def interval(self, level: float = 0.95) -> Array:
        """Return the interval of each parameter that holds its value with this probability, shape (p, 2).

        Raises:
            IdentifyError: a level that is not between 0 and 1.
        """
        check_arguments(Identification.interval, locals(), IdentifyError)
        (level,) = native(float, level)
        return self.regression.interval(level)

    @property
    def tables(self) -> tuple[Table[str], ...]:
        """Base parameters, their frames, gains of drives where there are some, how driving forces are predicted."""
        from symdyn.identification.report_sections import fit_table, frame_table, gain_table, parameter_table

        more = [table(self) for table in (frame_table, gain_table) if table(self).rows]
        return parameter_table(self), *more, fit_table(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a row a parameter: value, standard error, unit, value in the scene, whether it is identifiable.

        >>> import numpy as np
        >>> import symdyn
        >>> log = symdyn.inverse(symdyn.example("pendulum"), "q1=sin(t)+0.4*sin(2.7*t)", np.linspace(0, 10, 1001))
        >>> symdyn.identify(symdyn.example("pendulum"), log).to_pandas().loc["myR1", "unit"]
        'kg m'

        Rows are named as `names`; what was not known of payloads and gains of drives are among them. `value` is the
        estimate, `standard_error` is NaN where it is not identifiable by itself, `before` where the scene has none.

        Raises:
            IdentifyError: pandas is not installed.
        """
        pandas = package("pandas", IdentifyError, ".as_dict()")
        columns = {"value": self.after, "standard_error": self.errors, "unit": [*self.units], "before": self.before}
        columns["identifiable"] = self.regression.identifiable
        found = pandas.DataFrame(columns, index=pandas.Index(self.names, name="parameter"))
        found.attrs |= {"scene": self.declared.name, "band_hz": self.band, "condition": self.regression.condition}
        return found

    def __getitem__(self, name: str) -> float:
        """Return one parameter by name; UnknownNameError if there is none."""
        check_arguments(Identification.__getitem__, locals(), UnknownNameError)
        if name not in self.names:
            raise UnknownNameError(f"{self.declared.name}: there is no parameter {name}; {choice(name, self.names)}")
        return float(self.after[self.names.index(name)])

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as JSON values; numbers that are none are NaN."""
        columns = zip(self.names, self.before, self.after, self.errors, self.regression.identifiable, strict=True)
        return {
            "scene": self.declared.name,
            "band_hz": self.band,
            "condition": self.regression.condition,
            "rows": len(self.regression.tau),
            "degrees_of_freedom": self.regression.dof,
            "parameters": [
                {"name": n, "before": float(b), "after": float(a), "standard_error": float(e), "identifiable": bool(k)}
                for n, b, a, e, k in columns
            ],
            "frames": self.frames,
            "gains": _rows(self.gains, "drive unit value standard_error=error"),
            "delay": {"value": self.delay[0], "standard_error": self.delay[1]},
            "fits": _rows(self.fits, "drive unit rms=size error percent before validation"),
            "outliers": _rows(self.outliers, "log=source drive from=start to=end samples worst"),
            "not_identifiable": _rows(self.not_identifiable, "combination why what_helps=helps"),
            "notes": list(self.notes),
        }


def _rows(nouns: Sequence[object], keys: str) -> list[dict[str, Any]]:
    """Return what nouns say by key, whose attribute is behind = where it is another."""
    pairs = [(key, attribute or key) for key, _, attribute in (one.partition("=") for one in keys.split())]
    return [{key: getattr(one, attribute) for key, attribute in pairs} for one in nouns]
