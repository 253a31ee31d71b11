"""docs/walkthroughs/ holds what the command line writes, byte for byte."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import pytest

from symdyn.cli import main
from symdyn.emit.render import script, verbatim

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


def test_no_page_and_no_picture_is_left_over() -> None:
    written = {name for _, name, _ in CASES}
    linked = {x for path in HOME.glob("*.md") for x in re.findall(r"\]\(([^)/]+)\)", path.read_text(encoding="utf-8"))}
    assert {path.name for path in HOME.iterdir()} - written - linked == {"README.md"}


def test_the_slovak_page_is_no_older_than_the_english_one_and_the_slovak_text() -> None:
    """Of pages that `make slow` alone makes anew: the same styles and scripts, and every sentence without a formula."""
    english, slovak = ((HOME / f"two_link{code}.html").read_text(encoding="utf-8") for code in ("", "-sk"))
    for path in sorted((ROOT / "templates/teach").glob("*.*s")):
        part = (script if path.suffix == ".js" else verbatim)(f"teach/{path.name}")
        assert (part in english) == (part in slovak), path.name
    said = unescape(slovak)
    lines = (HOME / "two_link-sk.md").read_text(encoding="utf-8").splitlines()
    prose = [line for line in lines if line.endswith(".") and not set(line) & set("$|*[\\<>#")]
    assert len(prose) > 30
    assert [line for line in prose if line not in said] == []
