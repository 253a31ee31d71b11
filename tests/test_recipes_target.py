"""The recipe for a target, followed: one file, loaded in a fresh process, is a target like all others."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.cli import main

TESTS = Path(__file__).parent


@pytest.mark.runs
def test_a_target_of_one_file_keeps_every_law_of_targets() -> None:
    words = ["-p", "recipes.awk_target", "-p", "no:cacheprovider", "-q", str(TESTS / "test_targets.py"), "-k", "awk"]
    environment = {**os.environ, "PYTHONPATH": str(TESTS)}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        timeout=300,
    )

    assert done.returncode == 0, done.stdout
    assert "passed" in done.stdout or "[100%]" in done.stdout
    assert "s" not in done.stdout.split()[0], f"something was skipped: {done.stdout}"


def test_nobody_else_knows_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["generate", "pendulum.toml", "--target", "awk"])
    assert "invalid choice: 'awk'" in capsys.readouterr().err

    ours = [path for folder in ("symdyn", "templates") for path in (TESTS.parent / folder).rglob("*.*")]
    assert [path for path in ours if path.suffix != ".pyc" and "awk" in path.read_text(encoding="utf-8").split()] == []
