"""What identification returns: base parameters before and after, how sure they are, how well forces are predicted."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import check_arguments, native
from symdyn.errors import IdentifyError, UnknownNameError
from symdyn.identification.filtered import Flags, Motion
from symdyn.identification.gains import Gain
from symdyn.identification.identifiability import Untold
from symdyn.identification.linear_model import TERMS, LinearModel
from symdyn.identification.log import Log
from symdyn.identification.outliers import Outlier
from symdyn.identification.regression import Regression
from symdyn.identification.units import GAINED
from symdyn.identification.validation import Fit
from symdyn.scene import INERTIAL, Scene
from symdyn.scene.values import choice
from symdyn.shown import Shown
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]

_PAYLOAD, _FRAME = re.compile(r"^payload (\d+ )?"), re.compile(r"R\d+(_b)*$")
"""What stands before the parameter of a payload, and the link frame behind one of a body."""


@dataclass(frozen=True, eq=False)
class Identification(Shown):
    """Parameters told from logs.

    Attributes:
        scene: as it was declared.
        model: what the logs were held against; its scene has a parameter for every term of friction that was added.
        logs: as measured.
        motions: filtered, at even times, with what was fitted and what was held back.
        band: highest frequency that was used, Hz.
        regression: least squares with all of its rows.
        fits: how well each driving force is predicted.
        outliers: samples that were left out.
        untold: combinations of parameters that the data do not tell, and why.
        notes: what a user should know, one line each.
        predicted: of each motion, Y β at every sample, shapes (N, nv).
        used: of each motion, which samples were fitted, shapes (N, nv).
        held: of each motion, which samples were held back, shapes (N,).
        gains: of drives that show something else than their force, such as currents.
        friction_terms: those that may be added to every drive.
        gain_units: what such drives may show.
    """

    friction_terms: ClassVar[tuple[str, ...]] = tuple(TERMS)
    gain_units: ClassVar[tuple[str, ...]] = tuple(GAINED)

    scene: Scene
    model: LinearModel
    logs: tuple[Log, ...]
    motions: tuple[Motion, ...]
    band: float
    regression: Regression
    fits: tuple[Fit, ...]
    outliers: tuple[Outlier, ...]
    untold: tuple[Untold, ...]
    notes: tuple[str, ...]
    predicted: tuple[Array, ...]
    used: tuple[Flags, ...]
    held: tuple[Flags, ...]
    gains: tuple[Gain, ...] = ()

    def __repr__(self) -> str:
        count = len(self.model.names)
        told = f"{int(self.regression.identifiable[:count].sum())} of {count} base parameters told"
        return f"<Identification of {self.scene.name}: {told}, condition number {self.regression.condition:.3g}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters, of what was not known of payloads, and of gains, shape (p,)."""
        return self.regression.names

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
        """What the scene says of them, shape (p,); NaN where it has no number, and of what is not in it."""
        return np.append(self.model.prior, np.full(len(self.names) - len(self.model.prior), np.nan))

    @property
    def after(self) -> Array:
        """What the data say, shape (p,)."""
        return self.regression.estimate

    @property
    def errors(self) -> Array:
        """Standard errors, shape (p,); NaN for what the data do not tell by itself."""
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
        if not 0 < level < 1:
            raise IdentifyError(f"level = {level:g} is no probability; give one between 0 and 1, such as 0.95")
        from scipy.stats import t

        wide = float(t.ppf(0.5 + level / 2, self.regression.freedom)) * self.errors
        return np.stack([self.after - wide, self.after + wide], axis=1)

    @property
    def tables(self) -> tuple[Table[str], ...]:
        """Base parameters before and after, gains of drives where there are some, how driving forces are predicted."""
        from symdyn.identification.report_sections import fit_table, gain_table, parameter_table

        return parameter_table(self), *([gain_table(self)] if self.gains else []), fit_table(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a row a parameter: its value, its standard error, its unit, what the scene says, whether data tell it.

        >>> import numpy as np
        >>> import symdyn
        >>> log = symdyn.inverse(symdyn.example("pendulum"), "q1=sin(t)+0.4*sin(2.7*t)", np.linspace(0, 10, 1001))
        >>> symdyn.identify(symdyn.example("pendulum"), log).to_pandas().loc["myR1", "unit"]
        'kg m'

        Rows are named as `names`; what was not known of payloads and gains of drives are among them. `value` is what
        the data say, `standard_error` is NaN where they do not tell it by itself, `before` where the scene has no
        number.

        Raises:
            IdentifyError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise IdentifyError(
                "to_pandas() needs pandas, which is not installed; pip install pandas, or take .as_dict()"
            ) from None
        columns = {
            "value": self.after,
            "standard_error": self.errors,
            "unit": list(self.units),
            "before": self.before,
            "told": self.regression.identifiable,
        }
        found = pandas.DataFrame(columns, index=pandas.Index(self.names, name="parameter"))
        found.attrs |= {"scene": self.scene.name, "band_hz": self.band, "condition": self.regression.condition}
        return found

    def __getitem__(self, name: str) -> float:
        """Return one parameter by name; UnknownNameError if there is none."""
        check_arguments(Identification.__getitem__, locals(), UnknownNameError)
        if name not in self.names:
            raise UnknownNameError(f"{self.scene.name}: there is no parameter {name}; {choice(name, self.names)}")
        return float(self.after[self.names.index(name)])

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as JSON values; numbers that are none are NaN."""
        columns = zip(self.names, self.before, self.after, self.errors, self.regression.identifiable, strict=True)
        return {
            "scene": self.scene.name,
            "band_hz": self.band,
            "condition": self.regression.condition,
            "rows": len(self.regression.tau),
            "degrees_of_freedom": self.regression.dof,
            "parameters": [
                {"name": n, "before": float(b), "after": float(a), "standard_error": float(e), "told": bool(k)}
                for n, b, a, e, k in columns
            ],
            "gains": [
                {"drive": one.drive, "unit": one.unit, "value": one.value, "standard_error": one.error}
                for one in self.gains
            ],
            "fits": [
                {
                    "drive": one.drive,
                    "unit": one.unit,
                    "rms": one.size,
                    "error": one.error,
                    "percent": one.percent,
                    "before": one.before,
                    "held_back": one.held_back,
                }
                for one in self.fits
            ],
            "outliers": [
                {
                    "log": one.source,
                    "drive": one.drive,
                    "from": one.start,
                    "to": one.end,
                    "samples": one.samples,
                    "worst": one.worst,
                }
                for one in self.outliers
            ],
            "untold": [
                {"combination": one.combination, "why": one.why, "what_helps": one.helps} for one in self.untold
            ],
            "notes": list(self.notes),
        }
