"""docs/walkthroughs/ holds what the command line writes, byte for byte."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.cli import main

ROOT = Path(__file__).parent.parent
HOME = ROOT / "docs" / "walkthroughs"
CASES = [
    ("examples/two_link.toml", "two_link.md", ()),
    ("examples/two_link.toml", "two_link-sk.md", ("--language", "sk")),
    ("examples/cart_pole.toml", "cart_pole.md", ()),
    ("examples/spatial_3r.toml", "spatial_3r.md", ()),
    ("examples/four_bar.toml", "four_bar-dalembert.md", ("--formulation", "dalembert")),
    ("examples/four_bar.toml", "four_bar-multipliers.md", ("--formulation", "multipliers")),
    ("examples/heavy_top.toml", "heavy_top-quaternions.md", ("--formulation", "quaternions")),
    ("examples/pendulum.toml", "pendulum-hamilton.md", ("--formulation", "hamilton")),
    ("examples/pendulum.toml", "pendulum-kane-sk.md", ("--formulation", "kane", "--language", "sk")),
    ("examples/four_bar.toml", "four_bar-udwadia-kalaba.md", ("--formulation", "udwadia-kalaba")),
    ("tests/data/impacts/scenes/bouncing_ball.toml", "bouncing_ball.md", ()),
    ("tests/data/impacts/scenes/bouncing_ball.toml", "bouncing_ball-sk.md", ("--language", "sk")),
    ("examples/two_link.toml", "two_link.html", ("--format", "html")),
    ("examples/two_link.toml", "two_link-sk.html", ("--format", "html", "--language", "sk")),
    ("examples/two_link.toml", "two_link-exercises.html", ("--format", "html", "--exercises")),
    ("examples/four_bar.toml", "four_bar.html", ("--format", "sliders")),
    ("examples/two_link.toml", "two_link.ipynb", ("--format", "notebook")),
]


@pytest.mark.heavy("spatial_3r.md", "two_link-sk.html")
@pytest.mark.long
@pytest.mark.runs
@pytest.mark.parametrize(("scene", "name", "words"), CASES, ids=[name for _, name, _ in CASES])
def test_walkthroughs_are_what_the_command_line_writes(
    scene: str,
    name: str,
    words: tuple[str, ...],
    tmp_path: Path,
    update_golden: bool,
    capsys: pytest.CaptureFixture[str],
) -> None:
    place = HOME if update_golden else tmp_path
    assert main(["walkthrough", str(ROOT / scene), *words, "-o", str(place / name)]) == 0
    for line in capsys.readouterr().out.splitlines():
        path = Path(line)
        assert path.read_bytes() == (HOME / path.name).read_bytes(), f"{path.name}: run pytest --update-golden"
