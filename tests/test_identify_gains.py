"""Gains of drives: what a current is worth is told by a payload of known mass, and what tells nothing is told."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom
from simulated_logs import DRIVEN, Driven, coverage_of_gains

import symdyn
from symdyn.cli import main
from symdyn.errors import IdentifyError
from symdyn.identification import Payload, identified, identify
from symdyn.identification.report import report, written
from symdyn.scene import Scene

pytestmark = pytest.mark.runs("cc")

Capture = pytest.CaptureFixture[str]
TWO, PUMA = DRIVEN["two_link"], DRIVEN["puma560"]
TERMS = ("viscous", "coulomb")
AMPERE = {"M*": "A"}


def found_of(driven: Driven, logs: Sequence[Any], **more: Any) -> symdyn.identification.Identification:
    given = {"units": driven.units, "payloads": driven.given, "friction": TERMS} | more
    return identify(driven.arm.scene, logs, **given)


def values(found: symdyn.identification.Identification) -> list[float]:
    return [one.value for one in found.gains]


@pytest.mark.parametrize(
    "payload",
    [TWO.load, TWO.given, replace(TWO.given, com=TWO.load.com)],
    ids=["all of it known", "its mass known", "its mass and centre known"],
)
def test_gains_come_out_of_a_log_without_noise(payload: Payload) -> None:
    found = found_of(TWO, TWO.exact(), payloads=payload, band=12.0)

    np.testing.assert_allclose(values(found), TWO.gains, rtol=1e-8)
    np.testing.assert_allclose([found[name] for name in TWO.arm.truth], list(TWO.arm.truth.values()), atol=1e-8)
    assert found.not_identifiable == ()
    assert [one.unit for one in found.gains] == ["N m/A"] * 2
    assert found.names[-2:] == ("gain M1", "gain M2")


@pytest.mark.slow
@pytest.mark.long
def test_gains_and_payload_of_a_spatial_arm_come_out_of_a_log_without_noise() -> None:
    found = found_of(PUMA, PUMA.exact(), band=12.0)

    np.testing.assert_allclose(values(found), PUMA.gains, rtol=1e-8)
    ten = PUMA.load.ten
    for name, value in zip(("mx", "my", "mz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"), ten[1:], strict=True):
        assert abs(found[f"payload {name}"] - value) < 1e-8


@pytest.mark.slow
@pytest.mark.long
def test_intervals_of_gains_hold_the_truth() -> None:
    found = coverage_of_gains(TWO, 20)

    low = binom.ppf(1e-4, 20, 0.95)
    assert np.all(found.held >= low)
    assert found.joint >= low
    assert 0.8 < found.ratio < 1.2, "too narrow or too wide"


def test_a_first_guess_may_be_far_off_and_a_scene_without_numbers_needs_none() -> None:
    heavy = symdyn.scene.bind(TWO.arm.scene, {"m1": 200, "m2": 0.01})

    for scene in (heavy, symdyn.scene.bind(symdyn.example("two_link"), {"h1": 0.5, "h2": 0.4, "g": 9.81})):
        found = identify(scene, TWO.logs(0), units=TWO.units, payloads=TWO.given, friction=TERMS)
        assert np.all(np.abs(np.array(values(found)) - TWO.gains) < 4 * np.array([one.error for one in found.gains]))


def test_gains_of_any_size_are_found_from_afar() -> None:
    """From least squares with smoothed currents, and from random starts, Gauss-Newton went astray."""
    sizes = {"M1": 3e4, "M2": -2e-3}
    logs = [one | {name: one[name] / size for name, size in sizes.items()} for one in TWO.logs(7)]

    found = found_of(TWO, logs)

    plain = found_of(TWO, TWO.logs(7))
    np.testing.assert_allclose(np.array(values(found)) / list(sizes.values()), values(plain), rtol=1e-6)


def test_gains_are_the_same_whatever_the_unit_of_the_column() -> None:
    log, loaded = TWO.logs(1)
    milli = [{name: 1000 * x if name.startswith("M") else x for name, x in one.items()} for one in (log, loaded)]

    plain, other = found_of(TWO, [log, loaded]), found_of(TWO, milli, units={"M*": "mA"})

    np.testing.assert_allclose(values(other), values(plain), rtol=1e-9)
    shown = found_of(TWO, [log, loaded], units={"M1": "%", "M2": "counts"})
    assert [one.unit for one in shown.gains] == ["N m/%", "N m/count"]


def test_a_column_of_the_other_sign_has_a_gain_below_zero_and_is_told() -> None:
    turned = [one | {"M2": -one["M2"]} for one in TWO.logs(2)]

    found = found_of(TWO, turned)

    assert abs(values(found)[1] + TWO.gains[1]) < 0.05
    assert any("gain M2 is below zero: its column has the other sign" in note for note in found.notes)


def test_a_drive_in_newton_metres_tells_the_gain_of_one_beside_it() -> None:
    """They share base parameters, so that no payload is needed (Gautier and Briot 2014)."""
    log = TWO.logs(3)[0]
    mixed = log | {"M1": TWO.gains[0] * log["M1"]}

    found = found_of(TWO, mixed, units={"M2": "A"}, payloads=())
    known = found_of(TWO, log, units={"M*": "A", "M1": f"{TWO.gains[0]} * A"}, payloads=())

    (gain,) = found.gains
    assert gain.drive == "M2"
    assert abs(gain.value - TWO.gains[1]) < 4 * gain.error < 0.3
    np.testing.assert_allclose(values(known), values(found))


@pytest.mark.parametrize(
    ("units", "loaded", "words"),
    [
        (
            {"M1": "0.39*A", "M2": "2*A"}, True,
            r"^gain M1=0.39\*A does not fit: left free, M1 is 0.65\d* N m/A .* 1\d.\d %; .* units={.M1.: .A.}$",
        ),
        ({"M1": "390*mA", "M2": "A"}, True, r"^gain M1=390\*A does not fit: left free, M1 is 65\d.* N m/A"),
        (
            {"M1": "0.39*A", "M2": "2*A"}, False,
            r"^gain M1=0.39\*A and gain M2=2\*A do not fit together: left free, M1 is 0.6\d* .* or M2 is 1.2\d* .*; "
            "the data do not show which one is wrong",
        ),
        ({"M1": "0.39*A", "M2": "A"}, False, r"masses and inertias are all 0.6\d* .* if M1=0.39\*A ought to be 1.6"),
    ],
)  # fmt: skip
def test_a_gain_that_was_said_wrongly_is_told(units: dict[str, str], loaded: bool, words: str) -> None:
    """It was blamed on others: masses, and gains beside it, came out as much too small, and nothing was said."""
    logs, payloads = (TWO.logs(3), TWO.given) if loaded else (TWO.logs(3)[0], ())

    found = found_of(TWO, logs, units=units, payloads=payloads)

    assert [one for one in found.notes if re.search(words, one)], found.notes


@pytest.mark.wide(3)
@pytest.mark.parametrize(("wrong", "right"), [(0, 1), (1, 0)])
@pytest.mark.parametrize("loaded", [True, False])
def test_a_column_of_forces_that_is_off_is_told_and_not_the_gain_beside_it_alone(
    wrong: int, right: int, loaded: bool
) -> None:
    """The gain that was said rightly was blamed."""
    names = list(TWO.units)
    logs = TWO.logs(3) if loaded else TWO.logs(3)[:1]
    off = [one | {names[wrong]: 1.5 * TWO.gains[wrong] * one[names[wrong]]} for one in logs]
    units = {names[right]: f"{TWO.gains[right]}*A"}

    found = found_of(TWO, off, units=units, payloads=TWO.given if loaded else ())

    free = found_of(TWO, off, units=units | {names[wrong]: "A"}, payloads=TWO.given if loaded else ())
    (note,) = (one for one in found.notes if " fit" in one)
    said = re.search(rf"{names[wrong]} is 0.66\d* times as much with a standard error of ([\d.]+)", note)
    assert said, note
    assert float(said[1].rstrip(".,")) == pytest.approx(free.gains[0].error, rel=0.02, abs=5e-5)  # two digits of it
    assert note.startswith(f"{names[wrong]} in N m does not fit: ") is loaded
    assert ("the data do not show which one is wrong" in note and f"gain {names[right]}=" in note) is not loaded


@pytest.mark.parametrize("units", [{"M1": "0.65*A", "M2": "2*A"}, {"M1": "0.65*A", "M2": "A"}])
def test_of_a_gain_that_was_said_rightly_nothing_is_said(units: dict[str, str]) -> None:
    for logs, payloads in ((TWO.logs(3), TWO.given), (TWO.logs(3)[0], ())):
        found = found_of(TWO, logs, units=units, payloads=payloads)
        assert not any("gain" in one or "all" in one for one in found.notes), found.notes


def test_parameters_and_gains_are_a_table_with_units() -> None:
    found = found_of(TWO, TWO.logs(3))

    table = found.to_pandas()

    assert list(table.index) == list(found.names)
    np.testing.assert_array_equal(table["value"], found.after)
    np.testing.assert_array_equal(table["standard_error"], found.errors)
    units = {"mxR1": "kg m", "JxxR1 + JyyR1": "kg m^2", "fv1": "N m s/rad", "fc2": "N m", "gain M2": "N m/A"}
    assert table.loc[list(units), "unit"].to_dict() == units
    assert table.loc["payload mx", "unit"] == "kg m"
    assert table["identifiable"].all()
    assert table.attrs["scene"] == "two_link"


def test_a_payload_is_taken_out_of_forces_that_are_forces() -> None:
    units = dict.fromkeys(TWO.units)
    logs = [one | {name: k * one[name] for name, k in zip(units, TWO.gains, strict=True)} for one in TWO.logs(4)]

    for payload in (TWO.load, TWO.given):
        found = found_of(TWO, logs, units=None, payloads=payload)
        off = [found[name] - x for name, x in TWO.arm.truth.items()]
        assert np.all(np.abs(off) < 4.5 * found.errors[: len(off)])
        assert found.gains == ()
    assert abs(found["payload mx"] - TWO.load.ten[1]) < 4 * found.errors[found.names.index("payload mx")]


def planar() -> tuple[Scene, list[dict[str, Any]]]:
    """Return a SCARA and its logs in A, first without, then with 2 kg in the middle of its second link."""
    scene = symdyn.example("scara")
    motion = {
        "q1": "sin(2*t)+0.4*cos(5*t)",
        "q2": "0.8*sin(3*t)-0.4*cos(1.7*t)",
        "q3": "0.1*sin(3.3*t)",
        "q4": "sin(4*t)",
    }
    run = symdyn.inverse(scene, motion, np.linspace(0, 10, 1001))
    model = symdyn.identification.linear_model.linear_model(scene)
    plain = {name: np.array(run[name]) for name in ("t", *scene.coordinates, *scene.velocities, *scene.drives)}
    q, qd = (np.stack([plain[name] for name in names], axis=1) for names in (scene.coordinates, scene.velocities))
    qdd = np.stack([run[f"{name}_ddot"] for name in scene.coordinates], axis=1)
    plain |= {f"{name}_ddot": x for name, x in zip(scene.coordinates, qdd.T, strict=True)}
    load = model.ten(q, qd, qdd)[:, :, 10:20] @ Payload("link2", 2, (0.1, 0, 0), (0, 0, 0)).ten
    loaded = plain | {name: plain[name] + x for name, x in zip(scene.drives, load.T, strict=True)}
    return scene, [plain, loaded]


@pytest.mark.long
def test_a_drive_that_feels_nothing_of_known_size_is_named() -> None:
    """The third and fourth axis carry nothing of what the second link does."""
    scene, logs = planar()
    second = Payload(scene.bodies[1].name, 2, (0.1, 0, 0), (0, 0, 0), 1)

    found = identify(scene, logs, units={"tau*": "A"}, payloads=second)

    told = {one.drive: np.isfinite(one.error) for one in found.gains}
    assert told["tau1"]
    assert told["tau2"]
    assert not told["tau3"]
    (why,) = [one for one in found.not_identifiable if "gain tau3" in one.parameters]
    assert "nothing of known mass loads its drive" in why.words
    assert 'units={"tau3": "0.12*A"}' in why.words
    assert identified(found).scene.name == scene.name


@pytest.mark.parametrize(
    ("payload", "units", "words"),
    [
        ((), AMPERE, r"twice all gains with twice all masses .* payloads=Payload\(.link2., 2.*.M1.: .0\.12\*A"),
        (Payload("link3", 2, log=1), AMPERE, "has no body link3; did you mean link"),
        (Payload("link2", -2, log=1), AMPERE, "mass = -2: give what it weighs, kg, above zero"),
        (Payload("link2", "2", log=1), AMPERE, "mass = '2': give what it weighs, kg, above zero"),
        ({"body": "link2", "mass": 2}, AMPERE, r"payloads = .*: give a Payload or a list of Payload"),
        (Payload("link2", 2, log=2), AMPERE, "there is no such log; give a number from 0 to 1"),
        (Payload("link2", 2, log="x.csv"), AMPERE, "there is no such log; give one of data"),
        (Payload("link2", 2, (0, 1), log=1), AMPERE, r"com = \[0, 1\]: give a vector of three numbers, m"),
        (Payload("link2", 2, inertia=(0, 0, 0), log=1), AMPERE, "give com, too"),
        (Payload("link2", 2, (0, 0, 0), (1, 0, 0), 1), AMPERE, "is that of no body"),
        (Payload("link2", 2, (0, 0, 0), (1, 1, 2.1), 1), AMPERE, "is that of no body"),
        (replace(TWO.given, log="*"), AMPERE, "same payload, .* measure the motion without it, too"),
        (TWO.given, {"q1": "A"}, "A is what a drive shows, and q1 is none; there are M1, M2"),
        (TWO.given, {"M1": "0*A"}, r"0\*A is no unit of a column"),
        (TWO.given, {"M1": 0.08}, r"M1: 0\.08 is no unit of a column"),
        ((), {"M*": " A "}, "twice all gains with twice all masses"),
        (TWO.given, {"M1": "x*A"}, r"x\*A is no unit of a column"),
    ],
)
def test_what_tells_no_gain_is_refused_in_words(payload: Any, units: dict[str, str], words: str) -> None:
    with pytest.raises(IdentifyError, match=words):
        found_of(TWO, TWO.logs(0), units=units, payloads=payload)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("loaded.csv:link2", "is not of the form FILE:BODY:mass=KG"),
        ("loaded.csv:link2:mas=2", "there is no mas; did you mean mass"),
        ("loaded.csv:link2:mass=two", "give a number, such as mass=3.2"),
        ("loaded.csv:link2:mass=2,com=0.1", r"give numbers, such as com=\[0,0,0.1\]"),
        ("loaded.csv:link2:mass=2,mass=3", "mass is there twice"),
        ("loaded.csv:link2:com=[0,0,0]", "without a mass it has no known size"),
    ],
)
def test_a_payload_that_is_told_wrongly_is_refused(text: str, words: str, capsys: Capture) -> None:
    import re

    assert main(["identify", "two_link.toml", "plain.csv", "--payload", text]) == 1
    said = capsys.readouterr().err
    assert re.search(words, said) or "two_link.toml" in said


def test_the_verb_prints_gains_and_writes_them(tmp_path: Path, capsys: Capture) -> None:
    scene = tmp_path / "arm.toml"
    scene.write_text(symdyn.scene.scene_files.write_text(TWO.arm.scene, "toml").text)
    for name, log in zip(("plain", "loaded"), TWO.logs(0), strict=True):
        table = np.column_stack(list(log.values()))
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=",".join(log), comments="")
    files = [str(tmp_path / f"{name}.csv") for name in ("plain", "loaded")]
    words = ["identify", str(scene), *files, "--units", "M*=A", "--payload", "load*.csv:link2:mass=2"]
    words += ["--friction", "viscous,coulomb"]
    page, table = tmp_path / "page.html", tmp_path / "table.csv"

    assert main([*words, "-o", str(page), "-o", str(table)]) == 0
    out = capsys.readouterr().out
    assert "Gains of drives" in out
    assert "N m/A" in out
    assert "Gains of drives" in page.read_text()
    assert "--payload &#x27;load*.csv:link2:mass=2&#x27;" in page.read_text()
    assert "gain M1," in table.read_text()
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["result"]["gains"]
    assert [one["drive"] for one in told] == ["M1", "M2"]
    for one, gain in zip(told, TWO.gains, strict=True):
        assert abs(one["value"] - gain) < 4 * one["standard_error"]


def test_the_identified_scene_is_that_of_the_forces_and_says_the_gains() -> None:
    arm, driven = TWO.arm, TWO
    found = found_of(driven, driven.logs(5))

    made = identified(found)

    assert made.named is not None
    assert abs(made.values["m2"] - 1) < 4 * made.named.errors[made.named.names.index("m2")]
    assert "# gains of drives, which a scene does not hold: M1 0.6" in written(made, "toml").text
    assert report(found, made) == report(found, made)
    assert arm.scene.name in repr(found)


def test_the_same_logs_give_the_same_bytes() -> None:
    one, other = (found_of(TWO, TWO.logs(6)) for _ in range(2))

    assert one.after.tobytes() == other.after.tobytes()
    assert one.covariance.tobytes() == other.covariance.tobytes()


@pytest.mark.slow
def test_intervals_of_gains_of_a_spatial_arm_hold_the_truth() -> None:
    found = coverage_of_gains(PUMA, 100)

    assert 90 * len(found.held) <= found.held.sum() <= 99 * len(found.held)
    assert np.all(found.held >= binom.ppf(1e-4, 100, 0.95))
    assert 0.95 < found.ratio < 1.05
    assert 90 <= found.joint <= 99
