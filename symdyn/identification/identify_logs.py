"""The function `identify`: logs of motion and driving forces in, base parameters with standard errors out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.arguments import argument, checked, native
from symdyn.errors import IdentifyError, listed
from symdyn.frozen import dataclass
from symdyn.identification.delay import delay, words as delay_words
from symdyn.identification.filtered import Motion, motions, usual_bands
from symdyn.identification.gain_doubts import doubts
from symdyn.identification.gains import Fitted, estimated_gains, fitted
from symdyn.identification.identification import Identification, not_identifiable
from symdyn.identification.identified_scene import identified
from symdyn.identification.linear_model import LinearModel, linear_model
from symdyn.identification.log import Log, forces_off, given_gains, read_logs, shown_in
from symdyn.identification.payload import Carried, Evidence, Payload, carried, check_payloads, evidence
from symdyn.scene import SceneLike, SceneUnits, scene_of
from symdyn.simulation.prescribed import drive_names


@checked(IdentifyError)
def identify(
    scene: SceneLike,
    data: Any,
    band: float | None = None,
    friction: str | Sequence[str] = (),
    hold_back: float = 0.0,
    outliers: bool = True,
    units: Mapping[str, str] | None = None,
    values: Mapping[str, object] | None = None,
    payloads: Payload | Sequence[Payload] = (),
    say: Callable[[str], None] | None = None,
) -> Identification:
    """Identify the base parameters of a scene from measured motion and driving forces, with standard errors.

    >>> import numpy as np
    >>> import symdyn
    >>> scene = symdyn.example("pendulum")
    >>> motion, values = "q1=sin(t)+0.4*sin(2.7*t)", {"m": 1.2, "b": 0.03}
    >>> log = symdyn.inverse(scene, motion, times=np.linspace(0, 10, 1001), values=values)
    >>> found = symdyn.identify(scene, {"t": log.t, "q1": log["q1"], "tau1": log["tau1"]})
    >>> [f"{name} = {value:.3f}" for name, value in zip(found.names, found.after, strict=True)]
    ['mxR1 = 0.000', 'myR1 = -0.600', 'JxxR1 + JyyR1 = 0.300', 'b = 0.030']

    Args:
        scene: the mechanism; parameters that are not identifiable keep its values.
        data: path of a CSV file with the columns t, coordinates, driving forces, inputs and states, as `simulate`
            writes them; arrays by name, a data frame or a run; or a list of such, a log each. Velocities and
            accelerations may be among them, else they are differentiated.
        band: highest frequency that is used, Hz; None takes that where noise begins.
        friction: terms that joints with a drive have beside what the scene declares: "viscous", "coulomb", "offset",
            "armature".
        hold_back: share of every log, in contiguous blocks, that is not fitted and judges the result; 0 to 0.9.
        outliers: whether samples that no noise explains are left out; they are reported.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg", "t": "ms"}. Drives
            that show currents, {"tau*": "A"}, have their gains among the unknowns; {"tau1": "0.12*A"} has 0.12 N m/A.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        payloads: bodies of known mass that some logs were measured with: they make gains identifiable.
        say: takes notes, a line at a time.

    Raises:
        IdentifyError: with every fault of the data, one line each.
        SceneError: the file of the scene has faults.
        DerivationError: the scene has no driving forces.
    """
    band, hold_back = native(float, band, hold_back)
    scene = scene_of(scene, values)
    if not scene.velocities:
        raise IdentifyError(f"{scene.name}: nothing moves: no joint has a coordinate")
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
    payloads = (payloads,) if isinstance(payloads, Payload) else tuple(payloads)
    check_payloads(model, payloads, logs)
    shown = shown_in(units or {}, [drive or "" for drive in scene.drives])
    _check_gains(model, shown, payloads, logs)
    load = carried(model, payloads, logs)

    def seen_in(band: float) -> _InBand:
        parts = [motions(log, band) for log in logs]
        moved = [(place, model.beside(one)) for place, (some, _) in enumerate(parts) for one in some]
        if not moved:
            raise IdentifyError([note for _, told in parts for note in told])
        held = evidence(model, moved, load, hold_back)
        return _InBand(band, parts, moved, held, fitted(model, held, load, shown, band, outliers))

    chosen = seen_in(band) if band is not None else _least_pulled(usual_bands(logs), seen_in)
    band, parts, moved, held, found = chosen.band, chosen.parts, chosen.moved, chosen.held, chosen.found
    said = given_gains(units or {}, [drive or "" for drive in scene.drives])

    def freed(j: int) -> Fitted:
        unit = said[j].unit if j in said else "force"
        return fitted(model, held, load, {**shown, j: unit}, band, outliers)

    forces = [j for j in model.driven if j not in shown and j not in said]
    alone = not payloads and all(j in shown or j in said for j in model.driven) and len(said) == 1
    doubted = doubts(model, said, forces, shown, found, freed, alone)
    gains = estimated_gains(scene, shown, found.regression, found.gains)
    notes = [note for log, (_, told) in zip(logs, parts, strict=True) for note in (*log.notes, *told)]
    notes += [*_expected(model, logs, moved, load, shown), *found.notes, *_pull_notes(chosen)]
    lost = not_identifiable(model, load, shown, found, [place for place, _ in moved])
    notes += [one.words for one in lost]
    notes += [one.words for one in gains if one.words]
    notes += doubted
    late = delay(model, held, found, band)
    for k, log in enumerate(logs):
        own = [i for i, (place, _) in enumerate(moved) if place == k]
        of_log = late if len(logs) == 1 else delay(model, held, found, band, own) if own else (0.0, np.nan)
        notes += delay_words(of_log, float(np.median(np.diff(log.t))), log.source)
    if say is not None:
        for note in notes:
            say(note)
    return Identification(
        scene, model, logs, found.motions, band, found.regression, found.fits, found.outliers, lost, tuple(notes),
        found.predicted, found.used, found.validation, gains, late, identified,
    )  # fmt: skip


PULLED, TOLD = 0.3, 1.0
"""Standard errors by which noise of the motion pulls a parameter at most in the band that is chosen, if it can be, and
from which on a note tells it."""


@dataclass(frozen=True)
class _InBand:
    """Logs up to one frequency, `band` in Hz, and their fit; motions with notes a log, and with the place of theirs."""

    band: float
    parts: list[tuple[tuple[Motion, ...], tuple[str, ...]]]
    moved: list[tuple[int, Motion]]
    held: Evidence
    found: Fitted

    @property
    def lost(self) -> int:
        """Directions that are not identifiable."""
        return len(self.found.regression.null_space)

    @property
    def pull(self) -> float:
        """Standard errors by which noise of the motion pulls a parameter at most."""
        regression = self.found.regression
        return float(np.abs(regression.pull[regression.identifiable]).max(initial=0.0))


def _least_pulled(bands: Sequence[float], seen_in: Callable[[float], _InBand]) -> _InBand:
    """Return the widest band, of those given widest first, in which noise of the motion pulls and hides nothing.

    Without one, that which hides and then pulls least; none that leaves out more of the logs than the widest.
    """
    best = seen_in(bands[0])
    moved = len(best.moved)
    for band in bands[1:]:
        if not best.lost and best.pull <= PULLED:
            break
        try:
            other = seen_in(band)
        except IdentifyError:  # too short for it
            break
        if len(other.moved) < moved:
            break
        if (other.lost, max(other.pull, PULLED)) < (best.lost, max(best.pull, PULLED)):
            best = other
    return best


def _pull_notes(chosen: _InBand) -> list[str]:
    """Return a note where noise of the motion pulls parameters by more than their standard errors."""
    if chosen.pull < TOLD:
        return []
    regression = chosen.found.regression
    sizes = np.where(regression.identifiable, np.abs(regression.pull), 0.0)
    name = regression.names[int(sizes.argmax())]
    return [
        f"noise of the positions is large for a band of {chosen.band:.3g} Hz: it pulled {name} by {chosen.pull:.2g} "
        "standard errors, which were taken out as far as the noise is known; a narrower band or less noise would help"
    ]


def _check_gains(
    model: LinearModel, shown: Mapping[int, str], payloads: Sequence[Payload], logs: Sequence[Log]
) -> None:
    """Raise IdentifyError where no drive is known as a force and nothing of known size acts in some logs alone."""
    driven = model.driven
    if not shown or any(j not in shown for j in driven):
        return
    names = [drive_names(model.scene)[j] for j in driven]
    if payloads and len({tuple(one.carried(k, log) for one in payloads) for k, log in enumerate(logs)}) == 1:
        raise IdentifyError(
            f"{model.scene.name}: {listed(names)}: every log carries the same payload, which cannot "
            "be separated from the body that it is fixed to; measure the motion without it, too, and give both logs"
        )
    if payloads:
        return
    last = model.scene.bodies[-1].name if model.scene.bodies else "BODY"
    python = f'payloads=Payload("{last}", 2, log="loaded.csv")'
    carried = argument("payload", f"loaded.csv:{last}:mass=2", python)
    known = argument("units", {names[0]: "0.12*A"})
    raise IdentifyError(
        f"{model.scene.name}: {listed(names)}: the gain of one {next(iter(shown.values()))} is not identifiable: twice "
        "all gains with twice all masses and frictions is the same motion. Measure again with a payload of known mass "
        f"and give both logs, with {carried}; or give a known gain, as in {known}"
    )


def _check_logs(logs: Sequence[Log], band: float | None) -> None:
    """Raise IdentifyError for a log that counts twice, and for a band that samples cannot show."""
    faults = []
    for k, log in enumerate(logs):
        if any(np.array_equal(log.t, one.t) and np.array_equal(log.tau, one.tau) for one in logs[:k]):
            faults.append(f"{log.source}: is a log that is given already; leave it out")
        half = 0.5 / float(np.median(np.diff(log.t)))
        if band is not None and band > half:
            faults.append(
                f"{log.source}: band = {band:.6g} Hz: samples show no more than {half:.6g} Hz, half of their rate; "
                "give less, or leave it out"
            )
    if faults:
        raise IdentifyError(faults)


def _expected(
    model: LinearModel,
    logs: Sequence[Log],
    moved: Sequence[tuple[int, Motion]],
    load: Carried,
    shown: Mapping[int, str],
) -> list[str]:
    """Return notes on driving forces that are far from what the scene expects of the motion."""
    driven = [j for j in model.driven if j not in shown]
    if not np.isfinite(model.prior).all() or not driven:
        return []
    tau = np.concatenate([one.tau for _, one in moved])
    before = [
        model.regressor(one.q, one.qd, one.qdd) @ model.prior
        + load.columns(model, place, one.q, one.qd, one.qdd)[..., -1]
        for place, one in moved
    ]
    names = [drive_names(model.scene)[j] for j in driven]
    kinds = [SceneUnits(model.scene).velocities[j] for j in driven]
    return forces_off(logs[0].source, names, kinds, tau[:, driven], np.concatenate(before)[:, driven])
