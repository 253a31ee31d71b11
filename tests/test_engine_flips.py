"""The reference sees a sign: ten of them turned round in copies of symdyn, each found within the trials of every run.

`verify` proves two derivations equal; where both share a law, such as that of friction, only a third can tell.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from engine.trials.options import PAIRED

ROOT = Path(__file__).resolve().parent.parent

FLIPS = (  # file seen from dynamics/, what stands there, what is planted
    ("recursive/links.py", "a = (a[0] + w[1] * twice,", "a = (a[0] - w[1] * twice,"),
    ("recursive/tree_dynamics.py", "f[i] = (sub(f[i][0], moment),", "f[i] = (add(f[i][0], moment),"),
    ("recursive/crba.py", "return (y, -x, zero),", "return (y, x, zero),"),
    ("recursive/tree_dynamics.py", "(add(n, cross(p, f)), f)", "(sub(n, cross(p, f)), f)"),
    ("mechanism/lagrange.py", "forces[i] = forces[i] - value *", "forces[i] = forces[i] + value *"),
    ("recursive/wrenches.py", "return b[2] - a[2]", "return b[2] + a[2]"),
    (
        "recursive/wrenches.py",
        "force = joint_resistance(joint, graph.total(",
        "force = -joint_resistance(joint, graph.total(",
    ),
    (
        "../scene/forces/applied_forces.py",
        "size = size + (dry.static.express(graph) - size)",
        "size = size - (dry.static.express(graph) - size)",
    ),
    ("mechanism/kinematics.py", "sub(scale(dot(omega, d), omega),", "add(scale(dot(omega, d), omega),"),
    ("../spatial.py", "add(self[1], cross(way, self[0]))", "sub(self[1], cross(way, self[0]))"),
)


@pytest.mark.parametrize(("file", "right"), [flip[:2] for flip in FLIPS])
def test_a_sign_stands_once_where_it_will_be_turned(file: str, right: str) -> None:
    assert (ROOT / "symdyn" / "dynamics" / file).read_text(encoding="utf-8").count(right) == 1


@pytest.mark.runs
@pytest.mark.slow
@pytest.mark.parametrize(("file", "right", "wrong"), FLIPS, ids=[f"{file}: {wrong}" for file, _, wrong in FLIPS])
def test_a_sign_turned_round_is_found(tmp_path: Path, file: str, right: str, wrong: str) -> None:
    for folder in ("symdyn", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    path = tmp_path / "symdyn" / "dynamics" / file
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(right, wrong), encoding="utf-8")

    run = subprocess.run(
        [sys.executable, "-m", "engine", "--until", str(PAIRED)],
        cwd=ROOT / "tests",
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )

    assert run.returncode == 1, run.stderr
    assert "error" in run.stdout
