"""One scene that has all that most lack (time, quaternions, a wheel, a prescribed motion), through every verb."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.cli import VERBS, main
from symdyn.scene import read
from symdyn.verify import certify

SCENE = Path(__file__).parent / "data" / "every_kind.toml"

WORDS = {  # verb: command lines behind the scene, each with its exit status
    "equations": [("--formulation dalembert", 0), ("--as base-parameters", 0), ("--format text", 0)],
    "walkthrough": [("-o lesson.md", 0), ("-o lesson.html --formulation dalembert", 1)],
    "check-derivation": [],  # a result comes first; there is none of a quaternion
    "generate": [(f"--target {target} -o out", 0) for target in ("numpy", "c", "ufunc", "js")],
    "verify": [],  # below
    "simulate": [
        ("--until 0.1 --bind F=1 -o run.csv --plot run.svg --animate run.html", 0),
        ("--until 0.1 --bind F=1 --method dop853 --reactions -o run.npz --animate run.glb", 0),
    ],
    "inverse": [
        ("--until 0.1 --bind F=1 --motion swing=sin(t)", 1),  # leaves freedoms open
        ("--until 0.1 --bind F=1 --motion run.csv", 0),
    ],
    "identify": [("run.csv --bind F=1 -o page.html -o found.toml", 0), ("--bind F=1", 1)],
    "calibrate": [("run.csv --bind F=1", 1)],  # a run has no poses
    "sweep": [("--bind F=1 --until 0.02 --over swing_dot=[0,1] --measure max(abs(swing))", 0)],
    "gait": [("--bind F=1 --section swing --until 1", 1)],  # it starts beyond, or does not return
    "linearize": [("--bind F=1", 1), ("--bind F=1 --anywhere", 0), ("--bind F=1 --anywhere --json", 0)],  # it moves
    "bench": [("--quick", 0)],
    "stress": [("", 1)],  # F has no value: what needs one is not shown
    "info": [("", 0), ("--json", 0), ("--frames", 0), ("--base-parameters", 0)],
    "draw": [
        ("-o whole.svg", 0),
        ("-o whole.pdf", 0),
        ("-o disc.svg --body disc", 0),
        ("-o pendulum.svg --body pendulum", 0),
    ],
    "play": [],  # ends with Ctrl-C alone
    "convert": [("copy.toml", 0), ("copy.urdf", 1)],  # F has no value
    "new": [],  # takes no scene, nor do these two
    "completion": [],
    "doctor": [],
}


def test_every_verb_is_tried() -> None:
    assert set(WORDS) == set(VERBS)


@pytest.mark.heavy("bench", "stress", "info", "generate", "equations")  # on many scenes in tests of their own
@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("verb", [verb for verb, lines in WORDS.items() if lines])
def test_a_verb_takes_what_scenes_may_hold(
    verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if verb in ("inverse", "identify"):
        assert main(["simulate", str(SCENE), "--until", "0.1", "--bind", "F=1", "-o", "run.csv"]) == 0
    for line, status in WORDS[verb]:
        assert main([verb, str(SCENE), *line.split()]) == status, f"{line}: {capsys.readouterr().err}"


@pytest.mark.long
@pytest.mark.usefixtures("numpy_alone")
def test_its_equations_are_proved_with_the_drive_that_a_prescribed_motion_takes() -> None:
    assert certify(read(SCENE)).passed
