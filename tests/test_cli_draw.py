"""`symdyn draw` writes a picture, and every mistake is one line."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from arms import EXAMPLES, two_link

from symdyn.cli import main
from symdyn.draw import picture
from symdyn.simulation.integrate import importable

Capture = pytest.CaptureFixture[str]
TWO_LINK = str(EXAMPLES / "two_link.toml")


def test_a_picture_goes_to_a_file_or_to_standard_output(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "arm.svg"

    assert main(["draw", TWO_LINK, "--at", "q1=30 deg, q2=-1/4", "-o", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    assert main(["draw", TWO_LINK, "--at", "q1=30 deg, q2=-1/4"]) == 0
    assert capsys.readouterr().out == path.read_text() == picture(two_link(), [3.141592653589793 / 6, -0.25])


def test_a_view_frames_labels_and_a_free_body(capsys: Capture) -> None:
    assert main(["draw", str(EXAMPLES / "scara.toml"), "--view=-30,20", "--frames", "--labels", "joints"]) == 0
    root = ElementTree.fromstring(capsys.readouterr().out)
    ids = {element.get("id") for element in root.iter()}

    assert {"frame-ground", "frame-wrist", "label-joint-wrist"} <= ids
    assert "label-body-quill" not in ids
    assert main(["draw", str(EXAMPLES / "scara.toml"), "--body", "forearm", "--scheme", "light"]) == 0
    assert 'id="cut-elbow"' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--at", "q9=1"], '"q9" is not a coordinate; known are q1, q2'),
        (["--at", "q1"], "gives no coordinate a value; write --at q1=0.3"),
        (["--at", "q1=1,q1=2"], "q1 gets two values"),
        (["--at", "q1=1/0"], "divides by zero"),
        (["--at", "q1=h1"], "give a number"),
        (["--view", "20"], "is not two numbers"),
        (["--view", "0,nan"], "azimuth and elevation are degrees"),
        (["--labels", "names"], "there are coordinates, bodies, joints, points"),
        (["--body", "link"], "did you mean link"),
        (["-o", "arm.jpg"], "pictures are written to .svg, .pdf, .png files"),
        (["-o", "arm"], "pictures are written to .svg, .pdf, .png files"),
        (["-o", "/dev/null/arm.svg"], "there is no folder /dev/null"),
        pytest.param(
            ["-o", "/dev/null/arm.png"],
            "there is no folder /dev/null",
            marks=pytest.mark.skipif(not importable("matplotlib"), reason="needs matplotlib, the extra plot"),
        ),
    ],
)
def test_a_mistake_is_one_line(words: list[str], message: str, capsys: Capture) -> None:
    assert main(["draw", TWO_LINK, *words]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.startswith("symdyn: ")
    assert said.count("\n") == 1
