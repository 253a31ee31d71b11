"""A page about an identification: what was found, how sure it is, what is not identifiable, how forces fit.

One file of HTML without anything from elsewhere; the same identification and command give the same bytes.

The identified scene is written too: what it was made of stands on top, where a format has comments.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.algebra import Array
from symdyn.arguments import argument, checked
from symdyn.emit import render
from symdyn.errors import IdentifyError, printable
from symdyn.frozen import dataclass, replace
from symdyn.identification.filtered import Motion
from symdyn.identification.identification import Identification
from symdyn.identification.identified_scene import Identified, identified
from symdyn.identification.linear_model import ten_of_body
from symdyn.identification.physical import Physical
from symdyn.identification.report_sections import (
    Curve,
    Picture,
    Section,
    bars,
    curves,
    ellipses,
    figure,
    fit_table,
    frame_table,
    gain_table,
    parameter_table,
)
from symdyn.scene import Written, write_text
from symdyn.table import Table
from symdyn.unlocked import cached_property

LAGS = 40
"""Of autocorrelations, each half a period of the band."""

MOST_BINS = 41
"""Of histograms, from -5 to 5 standard deviations."""

MOST_BODIES = 24
"""Bodies whose ellipsoids are drawn."""


@checked(IdentifyError)
def report(identification: Identification, made: Identified | None = None, command: str = "") -> str:
    """Return the page.

    Args:
        identification: what `identify` returned.
        made: the identified scene, shown too where it is given.
        command: what made it, shown on top.
    """
    sections = [
        _parameters(identification),
        _gains(identification),
        _not_identifiable(identification),
        _fits(identification),
        *_plots(identification),
        *_residuals(identification),
        _outliers(identification),
    ]
    if made is not None:
        sections.append(_scene(made))
    parts = [one for one in sections if one is not None]
    facts = {
        "title": printable(f"Identification of {identification.declared.name}", keep=""),
        "command": printable(command, keep=""),
        "facts": Table(("", ""), list(_facts(identification)), title="What it rests on"),
        "notes": [printable(note, keep="") for note in identification.notes],
        "sections": parts,
    }
    return render("identify/report.html.jinja", facts)


def _facts(identification: Identification) -> Iterator[tuple[str, str]]:
    regression = identification.regression
    yield "logs", ", ".join(printable(log.source, keep="") for log in identification.logs)
    yield "samples", f"{sum(len(log.t) for log in identification.logs)}"
    yield "band", f"{figure(identification.band, 3)} Hz"
    yield "rows of the regressor", f"{len(regression.tau)}"
    yield "degrees of freedom", f"{regression.dof}"
    yield "condition number of the weighted rows, columns scaled", figure(regression.condition, 3)
    count = len(identification.model.names)
    yield "base parameters identifiable", f"{int(regression.identifiable[:count].sum())} of {count}"


# Tables


def _parameters(identification: Identification) -> Section:
    words = (
        "Base parameters: the combinations of masses and inertias that a motion can identify. Before is the value in "
        "the scene, after the estimate; SI units. An interval holds the true value in 95 of 100 logs, if the model is "
        "right.",
    )
    tables = (parameter_table(identification), frame_table(identification))
    return Section("Parameters", words, tuple(one for one in tables if one.rows))


def _gains(identification: Identification) -> Section | None:
    if not identification.gains:
        return None
    words = (
        "What the column of a drive is multiplied by to become its force. Their errors go with those of the other "
        "parameters: in the covariance they are one with them.",
    )
    return Section("Gains", words, (gain_table(identification),))


def _not_identifiable(identification: Identification) -> Section:
    title = "Not identifiable from these data"
    if not identification.not_identifiable:
        return Section(title, ("Every base parameter is identifiable.",))
    rows = tuple((one.combination, one.why or "not known", one.helps) for one in identification.not_identifiable)
    heads = ("combination", "why", "what would help")
    return Section(title, (), (Table(heads, rows, title="Combinations that keep the value of the scene"),))


def _fits(identification: Identification) -> Section:
    way = argument("hold_back", 0.25)
    validated = any(isfinite(one.validation) for one in identification.fits)
    words = (
        "Root mean squares; errors are those in the band.",
        "Validation data were not fitted: an error much larger there means overfitting."
        if validated
        else f"No validation data: {way} judges the parameters by data that they were not fitted to.",
    )
    return Section("Driving forces", words, (fit_table(identification),))


def _outliers(identification: Identification) -> Section:
    title = "Outliers"
    if not identification.outliers:
        return Section(title, ("No sample was left out.",))
    rows = tuple(
        (printable(x.source, keep=""), x.drive, figure(x.start), figure(x.end), f"{x.samples}", figure(x.worst, 3))
        for x in identification.outliers
    )
    heads = ("log", "drive", "from, s", "to, s", "samples", "largest error")
    words = ("Samples that no noise of their drive explains; they were not fitted.",)
    return Section(title, words, (Table(heads, rows, range(2, 6), "Samples left out"),))


# Pictures


def _plots(identification: Identification) -> Iterator[Section]:
    names = identification.model.drives
    units = {one.drive: one.unit for one in identification.fits}
    time = _axis("t", identification.model.scene.shown_unit("s"))
    for motion, predicted, used, held in zip(
        identification.motions, identification.predicted, identification.used, identification.validation, strict=True
    ):
        pictures = []
        t = motion.t
        shaded = _ranges(t, held)
        for j in identification.model.rows:
            name, unit = names[j], units.get(names[j], "")
            both = (Curve("c0", t, motion.tau[:, j]), Curve("c1", t, predicted[:, j]))
            left = motion.tau[:, j] - predicted[:, j]
            gaps = np.where(used[:, j], left, np.nan)
            out = np.where(used[:, j], np.nan, left)
            told = f"{name} of {printable(motion.source, keep='')}, measured and predicted, over time"
            pictures.append(Picture(curves(told, time, _axis(name, unit), both, shaded), ""))
            shown = (Curve("c2", t, gaps), Curve("c3", t, out, True))
            told = f"{name} of {printable(motion.source, keep='')}: measured less predicted, over time"
            pictures.append(Picture(curves(told, time, _axis("error", unit), shown, shaded), ""))
        legend = (("c0", "measured"), ("c1", "predicted"), ("c2", "measured less predicted"), ("c3", "not fitted"))
        words = ("Validation data are shaded.",) if shaded else ()
        yield Section(f"Over time: {printable(motion.source, keep='')}", words, (), tuple(pictures), legend)


def _axis(name: str, unit: str) -> str:
    return f"{name}, {unit}" if unit else name


def _ranges(t: Array, mask: NDArray[Any]) -> list[tuple[float, float]]:
    """Return the ranges of time where a mask is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(float(t[a]), float(t[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _residuals(identification: Identification) -> Iterator[Section]:
    regression, names = identification.regression, identification.model.drives
    pictures = []
    x = np.linspace(-5, 5, 101)
    normal = Curve("c1", x, np.exp(-(x**2) / 2) / np.sqrt(2 * pi))
    for j in identification.model.rows:
        of = regression.joint == j
        if not of.any():
            continue
        scaled = (regression.residuals * regression.weights)[of]
        bins = int(np.clip(2 * np.sqrt(len(scaled)), 9, MOST_BINS))
        edges = np.array([10 * k / bins - 5 for k in range(bins + 1)])
        count: Array = np.histogram(np.clip(scaled, -5, 5), edges, density=True)[0]
        told = f"{names[j]}: histogram of {len(scaled)} weighted residuals, and the normal distribution"
        pictures.append(Picture(bars(told, "residual, standard deviations", "share", edges, count, normal), names[j]))
        lags, limit = autocorrelation(identification.motions, identification.predicted, identification.used, j)
        told = f"{names[j]}: autocorrelation of the error over {len(lags)} lags"
        at = np.array([k + 0.5 for k in range(len(lags) + 1)])
        pictures.append(
            Picture(bars(told, "lag, half periods of the band", "correlation", at, lags, None, limit), names[j])
        )
    words = (
        "Of each drive, first residuals of the fit by their standard deviation, beside a normal distribution; then "
        "the autocorrelation of the error over lags of half a period of the band. What exceeds the dashed lines (95 %) "
        "is no chance: the model lacks something.",
    )
    if pictures:
        legend = (("c1", "normal distribution, limits of chance"),)
        yield Section("Residuals", words, (), tuple(pictures), legend)


def autocorrelation(
    motions: Sequence[Motion], predicted: Sequence[Array], used: Sequence[NDArray[Any]], j: int
) -> tuple[Array, float]:
    """Return the autocorrelation of the error of a drive, shape (lags,), and what chance stays below at 95 %.

    Errors are averaged over half a period of the band, as far as the fit looks; what was not fitted counts as zero.
    """
    products, power, count = np.zeros(LAGS), 0.0, 0
    for motion, model, mask in zip(motions, predicted, used, strict=True):
        step = float(motion.t[1] - motion.t[0])
        size = max(1, round(1 / (2 * motion.band * step)))
        left = np.where(mask[:, j], motion.tau[:, j] - model[:, j], 0.0)
        whole = len(left) // size * size
        mean = left[:whole].reshape(-1, size).mean(axis=1)
        mean = mean - mean.mean() if len(mean) else mean
        power += float(mean @ mean)
        count += len(mean)
        for lag in range(1, min(LAGS, len(mean) - 1) + 1):
            products[lag - 1] += float(mean[:-lag] @ mean[lag:])
    lags = products[: max(1, min(LAGS, count // 4))] / (power or 1.0)
    return lags, 1.96 / np.sqrt(max(count, 1))


# The identified scene


def _scene(made: Identified) -> Section:
    tables, pictures = [], list[Picture]()
    if made.named is not None:
        one = made.named
        rows = tuple(
            (name, figure(before), figure(value), figure(error, 2) if isfinite(error) else "not identifiable")
            for name, before, value, error in zip(one.names, one.before, one.values, one.errors, strict=True)
        )
        heads = ("parameter", "before", "after", "standard error")
        tables.append(Table(heads, rows, range(1, 4), "Parameters with names"))
    legend: tuple[tuple[str, str], ...] = ()
    if made.physical is not None:
        tables.append(_bodies(made.physical))
        acting = _acting(made.physical)
        tables += [acting] if acting.rows else []
        pictures = list(_ellipsoids(made.physical))
        legend = (("c0 dash", "as declared"), ("c1", "identified"))
    words = tuple(printable(note, keep="") for note in made.notes)
    if pictures:
        words += (
            "Ellipsoids are solid ones of even density with the same mass, centre of mass and inertia, in the frame "
            "of the body.",
        )
    return Section("The identified scene", words, tuple(tables), tuple(pictures), legend, small=True)


def _bodies(physical: Physical) -> Table[str]:
    rows = []
    before, after = physical.unknowns.ten(physical.unknowns.values), physical.unknowns.ten(physical.values)
    margins = zip(physical.before, physical.margins, strict=True)
    for name, was, now, (old, new) in zip(physical.unknowns.bodies, before, after, margins, strict=True):
        for label, ten, margin in (("before", was, old), ("after", now, new)):
            mass, centre, moments, _ = ten_of_body(ten)
            rows.append((name, label, figure(mass), *map(figure, centre), *map(figure, moments), figure(margin, 2)))
    heads = ("body", "", "mass, kg", "x, m", "y, m", "z, m", "I1, kg m\u00b2", "I2", "I3", "margin")
    caption = (
        "Masses, centres of mass and principal moments about them; margin: smallest eigenvalue of the pseudo-inertia "
        "by its trace, above zero for what a body can be"
    )
    return Table(heads, rows, range(2, 10), caption)


def _acting(physical: Physical) -> Table[str]:
    count = 10 * len(physical.unknowns.bodies)
    known = physical.unknowns
    rows = tuple(
        (name, figure(before), figure(after))
        for name, before, after in zip(known.names[count:], known.values[count:], physical.values[count:], strict=True)
    )
    return Table(("parameter", "before", "after"), rows, (1, 2), "Friction, armatures and what else acts")


def _ellipsoids(physical: Physical) -> Iterator[Picture]:
    before, after = physical.unknowns.ten(physical.unknowns.values), physical.unknowns.ten(physical.values)
    for name, was, now in list(zip(physical.unknowns.bodies, before, after, strict=True))[:MOST_BODIES]:
        for i, j, words in ((0, 1, "xy"), (0, 2, "xz")):
            shown = []
            for kind, ten in (("c0 dash", was), ("c1", now)):
                mass, centre, _, spread = ten_of_body(ten)
                if mass > 0 and np.isfinite(spread).all():
                    shown.append((kind, centre[[i, j]], 5 * spread[np.ix_([i, j], [i, j])]))
            if shown:
                told = f"{name}: inertia ellipsoid before and after, seen along {'zy'[words == 'xz']}"
                yield Picture(ellipses(told, f"{words[0]}, m", f"{words[1]}, m", shown), name)


def written(identified: Identified, format: str, about: Sequence[str] = ()) -> Written:
    """Return the identified scene as text, and what the format cannot hold.

    Args:
        identified: the scene.
        format: "toml" or "urdf", a key of the table of formats.
        about: lines of a comment on top, where the format has comments, before what is written as what.

    Raises:
        SceneError: the format is not written, or cannot hold a joint.
    """
    scene = identified.scene
    if format != "toml":  # which have one number for dry friction, and no letters
        joints = tuple(
            replace(j, friction=getattr(j.dry, "coulomb", j.friction), dry=None) if j.dry is not None else j
            for j in scene.joints
        )
        scene = replace(scene, joints=joints)
    made = write_text(scene, format, lossy=True)
    lines = [printable(line, keep="") for line in (*about, *identified.notes)]
    return Written(COMMENTED.get(format, lambda text, _: text)(made.text, lines), made.lost)


def _hashes(text: str, lines: Sequence[str]) -> str:
    return "".join(f"# {line}\n" for line in lines) + ("\n" if lines else "") + text


def _xml(text: str, lines: Sequence[str]) -> str:
    head, rest = text.split("\n", 1)
    plain = [line.replace("--", "- -") for line in lines]
    return "\n".join([head, *(f"<!-- {line} -->" for line in plain), rest])


COMMENTED = {"toml": _hashes, "urdf": _xml}
"""How a comment on top of a file is written, by format."""


@dataclass(frozen=True)
class Outcome:
    """What is to be written about."""

    identification: Identification  # the identification
    total_mass: float | None  # of all bodies, kg; None leaves it to the data
    command: str  # that made it

    @cached_property
    def made(self) -> Identified:
        return identified(self.identification, self.total_mass)

    def page(self) -> tuple[str, str]:
        """Return the page, and why it has no identified scene; "" where it has one."""
        try:
            made, why = self.made, ""
        except IdentifyError as fault:  # the page shows what was identified all the same
            made, why = None, str(fault)
        return report(self.identification, made, self.command), why

    def text(self, format: str) -> Written:
        """Return the identified scene, and what the format cannot hold; errors as of `identified`."""
        return written(self.made, format, [f"identified by: {self.command}"] if self.command else [])
