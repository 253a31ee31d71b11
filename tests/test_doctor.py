"""`symdyn doctor`: what is there and what each missing thing costs, whatever is missing; it always ends with 0."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import doctor, main
from symdyn.extras import EXTRAS
from symdyn.runtime.machine import PROGRAMS

pytestmark = pytest.mark.runs("cc")

ROOT = Path(symdyn.__file__).parent.parent

Capture = pytest.CaptureFixture[str]


DISTRIBUTIONS = cache(packages_distributions)


@pytest.fixture(autouse=True)
def distributions_are_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "packages_distributions", DISTRIBUTIONS)


def looked(capsys: Capture) -> dict:
    assert main(["doctor", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == 0
    return told["result"]


def test_what_is_there_is_found(capsys: Capture) -> None:
    found = looked(capsys)
    assert found["symdyn"] == symdyn.__version__
    assert found["python"]["path"] == sys.executable
    assert all(found["packages"].values())
    assert found["compiler"]["works"]
    assert [one["name"] for one in found["extras"]] == list(EXTRAS)
    shell = next(one for one in found["extras"] if one["name"] == "shell")
    assert (shell["there"], shell["without"]) == (True, None)
    assert shell["modules"]["shtab"][0].isdigit()


def test_every_missing_extra_says_what_it_costs_and_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    for one in looked(capsys)["extras"]:
        assert not one["there"]
        assert one["without"] == EXTRAS[one["name"]].without
        assert f'"symdyn[{one["name"]}]"' in one["install"]
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "mujoco missing" in out
    assert 'pip install "symdyn[robots]"' in out


def alone(folder: Path, **environment: str) -> dict:
    """Return what is found in a process that has no program but Python."""
    (folder / "empty").mkdir()
    given = {
        "PATH": str(folder / "empty"),
        "CC": "",
        "PYTHONPATH": str(ROOT),
        "SYMDYN_CACHE_DIR": str(folder / "cache"),
    }
    code = (
        "import sys; sys.modules['ziglang'] = None; from symdyn.cli import main; sys.exit(main(['doctor', '--json']))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | given | environment, capture_output=True, text=True, check=False
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    return json.loads(ran.stdout)["result"]


def test_with_nothing_else_installed_all_is_told(tmp_path: Path) -> None:
    found = alone(tmp_path)
    assert not found["compiler"]["works"]
    assert "no C compiler found" in found["compiler"]["why"]
    assert "NumPy" in found["compiler"]["without"]
    assert [one["path"] for one in found["programs"]] == [None] * len(PROGRAMS)
    assert all(one["without"] for one in found["programs"])
    assert (found["cache"]["safe"], found["cache"]["entries"]) == (True, 0)
    assert not (tmp_path / "cache").exists()  # looking makes nothing


def test_a_compiler_that_does_not_compile_is_no_compiler(tmp_path: Path) -> None:
    (tmp_path / "cc").write_text("#!/bin/sh\necho broken >&2\nexit 1\n")
    (tmp_path / "cc").chmod(0o755)
    found = alone(tmp_path, CC=str(tmp_path / "cc"), TMPDIR=str(tmp_path))
    assert not found["compiler"]["works"]
    assert "could not compile probe.c" in found["compiler"]["why"]


@pytest.mark.wide(2)
@pytest.mark.parametrize("mode", [0o777, 0o770])
def test_a_cache_that_others_may_write_to_is_told(
    mode: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    tmp_path.chmod(mode)
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path))
    cache = looked(capsys)["cache"]
    assert (cache["safe"], cache["why"]) == (False, "others may write to it")
    assert main(["doctor"]) == 0
    assert "NOT SAFE: others may write to it" in capsys.readouterr().out


def test_a_cache_that_is_a_file_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "file"))
    cache = looked(capsys)["cache"]
    assert (cache["safe"], cache["why"]) == (False, "it is no folder")


def test_a_cache_that_cannot_be_made_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("SYMDYN_CACHE_DIR", str(tmp_path / "file" / "cache"))

    cache = looked(capsys)["cache"]
    assert (cache["safe"], cache["why"]) == (False, f"it is not there, and you may not write to {tmp_path / 'file'}")
