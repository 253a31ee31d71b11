"""generated/ holds what the command line writes for some examples, byte for byte."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.cli import main

ROOT = Path(__file__).parent.parent
CASES = [
    ("pendulum", "numpy", "double"),
    ("pendulum", "c", "double"),
    ("two_link", "numpy", "double"),
    ("two_link", "c", "double"),
    ("two_link", "c", "float"),
    ("two_link", "c", "dd"),
    ("two_link", "js", "double"),
    ("two_link", "cpp", "double"),
    ("two_link", "rust", "double"),
    ("two_link", "matlab", "double"),
    ("two_link", "julia", "double"),
    ("two_link", "heyoka", "double"),
    ("two_link", "gpu", "double"),
    ("two_link", "gpu", "float"),
    ("cart_pole", "numpy", "double"),
    ("cart_pole", "c", "double"),
    ("cart_pole", "js", "double"),
    ("puma560", "numpy", "double"),
    ("puma560", "c", "double"),
]


PREPARED = ["--functions", "inverse_dynamics,forward_dynamics,mass_matrix", "--prepare"]


@pytest.mark.long
@pytest.mark.parametrize(("scene", "target", "real"), CASES)
def test_generated_files_are_what_the_command_line_writes(
    scene: str, target: str, real: str, tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = scene if real == "double" else f"{scene}_{real}"
    compare(scene, folder, ["--target", target, "--real", real], tmp_path, update_golden, capsys)


@pytest.mark.parametrize("target", ["numpy", "c"])
def test_generated_files_that_prepare_are_what_the_command_line_writes(
    target: str, tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--target", target, *PREPARED]
    compare("two_link", "two_link_prepared", words, tmp_path, update_golden, capsys)


@pytest.mark.long(0)
def test_generated_files_for_mex_are_what_the_command_line_writes(
    tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--target", "matlab", "--mex", "--functions", "inverse_dynamics,mass_matrix,coriolis_matrix"]
    compare("two_link", "two_link_mex", words, tmp_path, update_golden, capsys)


def test_generated_files_with_jacobians_are_what_the_command_line_writes(
    tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    functions = "inverse_dynamics,inverse_dynamics_derivatives,inverse_dynamics_by_parameters,mass_matrix"
    words = ["--target", "casadi", "--external", "--functions", functions]
    compare("two_link", "two_link_casadi", words, tmp_path, update_golden, capsys)


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("scene", ["cart_pole", "four_bar"])
def test_generated_reactions_are_what_the_command_line_writes(
    scene: str, target: str, tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--target", target, "--functions", "reactions,forward_reactions:ground"]
    compare(scene, f"{scene}_reactions", words, tmp_path, update_golden, capsys)


def compare(
    scene: str, folder: str, words: list[str], place: Path, update: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """Compare what `symdyn generate` writes with the files in generated/, or rewrite those."""
    golden = ROOT / "generated" / folder
    place = golden if update else place
    status = main(["generate", str(ROOT / "examples" / f"{scene}.toml"), *words, "-o", str(place)])
    names = [Path(line).relative_to(place) for line in capsys.readouterr().out.splitlines()]

    assert status == 0
    assert names
    for name in names:
        assert (place / name).read_bytes() == (golden / name).read_bytes(), f"{name}: run pytest --update-golden"


@pytest.mark.parametrize("scene", ["two_link", "puma560"])
def test_pictures_are_what_the_command_line_draws(
    scene: str, tmp_path: Path, update_golden: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    golden = ROOT / "generated" / scene / f"{scene}.svg"
    path = golden if update_golden else tmp_path / f"{scene}.svg"

    assert main(["draw", str(ROOT / "examples" / f"{scene}.toml"), "-o", str(path)]) == 0
    assert path.read_bytes() == golden.read_bytes(), f"{golden.name}: run pytest --update-golden"
