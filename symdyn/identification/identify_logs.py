"""The function `identify`: logs of motion and driving forces in, base parameters with standard errors out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from symdyn.arguments import check_arguments, native
from symdyn.errors import IdentifyError
from symdyn.identification.calibrated_gains import doubts
from symdyn.identification.filtered import Motion, choose_band, motions
from symdyn.identification.fitting import Fitted, fitted
from symdyn.identification.gains import estimated_gains
from symdyn.identification.identification import Identification, untold
from symdyn.identification.linear_model import LinearModel, linear_model
from symdyn.identification.log import Log, forces_off, given_gains, read_logs, shown_in
from symdyn.identification.payload import Carried, Payload, carried, check_payloads, evidence
from symdyn.scene import SceneLike, SceneUnits, scene_of
from symdyn.scene.values import listed
from symdyn.simulation.prescribed import drive_names


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
        band: highest frequency that is used, Hz; None takes that where noise begins.
        friction: terms that joints with a drive have beside what the scene declares: "viscous", "coulomb", "offset",
            "armature".
        hold_back: share of every log, in contiguous blocks, that is not fitted and judges the result; 0 to 0.9.
        outliers: whether samples that no noise explains are left out; they are told.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg", "t": "ms"}. Drives
            that show currents, {"tau*": "A"}, have their gains among the unknowns; {"tau1": "0.12*A"} has 0.12 N m/A.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        payloads: bodies of known mass that some logs were measured with: what gains are told by.
        say: takes what a user should know, a line at a time.

    Raises:
        IdentifyError: with every fault of the data, one line each.
        SceneError: the file of the scene has faults.
        DerivationError: the scene has no driving forces.
    """
    check_arguments(identify, locals(), IdentifyError)
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
    band = choose_band(logs) if band is None else band
    parts = [motions(log, band) for log in logs]
    moved = [(place, one) for place, (some, _) in enumerate(parts) for one in some]
    if not moved:
        raise IdentifyError([note for _, told in parts for note in told])
    load = carried(model, payloads, logs)
    held = evidence(model, moved, load, hold_back)
    found = fitted(model, held, load, shown, band, outliers)
    said = given_gains(units or {}, [drive or "" for drive in scene.drives])

    def freed(j: int) -> Fitted:
        unit = said[j].unit if j in said else "force"
        return fitted(model, held, load, {**shown, j: unit}, band, outliers)

    forces = [j for j in model.rows if scene.drives[j] and j not in shown and j not in said]
    alone = not payloads and all(j in shown or j in said for j in model.rows if scene.drives[j]) and len(said) == 1
    doubted = doubts(model, said, forces, shown, found, freed, alone)
    gains = estimated_gains(scene, shown, found.regression, found.gains)
    notes = [note for log, (_, told) in zip(logs, parts, strict=True) for note in (*log.notes, *told)]
    notes += [*_expected(model, logs, moved, load, shown), *found.notes]
    lost = untold(model, load, shown, found, [place for place, _ in moved])
    notes += [one.words for one in lost]
    notes += [one.words for one in gains if one.words]
    notes += doubted
    if say is not None:
        for note in notes:
            say(note)
    return Identification(
        scene, model, logs, found.motions, band, found.regression, found.fits, found.outliers, lost, tuple(notes),
        found.predicted, found.used, found.held, gains,
    )  # fmt: skip


def _check_gains(
    model: LinearModel, shown: Mapping[int, str], payloads: Sequence[Payload], logs: Sequence[Log]
) -> None:
    """Raise IdentifyError where no drive is known as a force and nothing of known size acts in some logs alone."""
    driven = [j for j in model.rows if model.scene.drives[j]]
    if not shown or any(j not in shown for j in driven):
        return
    names = [drive_names(model.scene)[j] for j in driven]
    if payloads and len({tuple(one.carried(k, log) for one in payloads) for k, log in enumerate(logs)}) == 1:
        raise IdentifyError(
            f"{model.scene.name}: {listed(names)}: every log carries the same payload, which no log "
            "tells from the body that it is fixed to; measure the motion without it, too, and give both logs"
        )
    if payloads:
        return
    last = model.scene.bodies[-1].name if model.scene.bodies else "BODY"
    raise IdentifyError(
        f"{model.scene.name}: {listed(names)}: no log tells what one {next(iter(shown.values()))} is worth: twice all "
        "gains with twice all masses and frictions is the same motion. Measure once more with a payload of known mass "
        f"and give both logs, with --payload loaded.csv:{last}:mass=2 (in Python payloads=Payload({last!r}, 2, "
        f'log="loaded.csv")); or say a gain that is known, as in --units {names[0]}=0.12*A'
    )


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


def _expected(
    model: LinearModel,
    logs: Sequence[Log],
    moved: Sequence[tuple[int, Motion]],
    load: Carried,
    shown: Mapping[int, str],
) -> list[str]:
    """Return notes on driving forces that are far from what the scene expects of the motion."""
    driven = [j for j in model.rows if model.scene.drives[j] and j not in shown]
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
