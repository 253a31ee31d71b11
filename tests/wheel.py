"""What a user gets: the sdist, the wheel that it builds, and that wheel alone in an empty environment; `make wheel`.

Nothing of the checkout is read but to build from it: commands run in an empty folder, and Python is the environment's.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parent.parent
SCRIPTS = "Scripts" if os.name == "nt" else "bin"

FURUTA = """
gravity = [0, 0, "-9.81"]
[bodies.arm]
mass = 0.2
com = [0.1, 0, 0]
inertia = [0.0001, 0.0007, 0.0007]
inertia_about = "com"
[bodies.rod]
particles = [{ mass = 0.1, at = [0, 0, -0.3] }]
[joints.motor]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 0, 1]
[joints.hinge]
type = "revolute"
parent = "arm"
child = "rod"
origin = [0.2, 0, 0]
axis = [1, 0, 0]
"""

PYTHON = """
import symdyn, sys
assert "numpy" not in sys.modules, "importing symdyn imports NumPy"
scene = symdyn.example("two_link")
M = symdyn.lambdify(scene, "mass_matrix")([0, 0], [1, 1, 1, 1, 9.81])
assert M.tolist() == [[5.0, 2.0], [2.0, 1.0]], M
assert symdyn.example("furuta").coordinates == ("theta1", "theta2")
assert len(symdyn.example("humanoid", floating_base="trunk_flight").velocities) == 21
run = symdyn.simulate("furuta.toml", until=0.5, start={"q2": 0.3})
assert run.complete and run["q2"].shape == run.t.shape
print("python: fine")
"""

VERBS: tuple[tuple[Sequence[str], str], ...] = (
    (("--version",), "symdyn"),
    (("new", "--example", "four_bar"), "four_bar.toml"),
    (("equations", "furuta.toml", "--format", "text"), "q1"),
    (("info", "four_bar.toml"), "mobility"),
    (("generate", "four_bar.toml", "--target", "c", "-o", "out"), "four_bar.c"),
    (("generate", "four_bar.toml", "--target", "numpy", "-o", "out"), "four_bar.py"),
    (("simulate", "furuta.toml", "--start", "q2=0.3", "--until", "1", "-o", "run.csv"), ""),
    (("linearize", "furuta.toml"), "A"),
    (("draw", "furuta.toml", "-o", "furuta.svg"), "furuta.svg"),
    (("verify", "furuta.toml"), "proved"),
)
"""Words of a command, and what its output names."""


def main() -> int:
    """Build, install, run; return 0 if all of it holds."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="symdyn-wheel-") as made:
        folder = Path(made)
        sdist = _built("--sdist", ROOT, folder)
        with tarfile.open(sdist) as archive:
            archive.extractall(folder / "unpacked", filter="data")
        (source,) = (folder / "unpacked").iterdir()
        wheel = _built("--wheel", source, folder)
        _same(wheel, _built("--wheel", ROOT, folder / "direct"))
        environment = folder / "environment"
        _run([sys.executable, "-m", "venv", str(environment)], folder)
        python = str(environment / SCRIPTS / "python")
        _run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel)], folder)
        empty = folder / "empty"
        empty.mkdir()
        (empty / "furuta.toml").write_text(FURUTA, encoding="utf-8")
        for words, named in VERBS:
            printed = _run([str(environment / SCRIPTS / "symdyn"), *words], empty)
            assert named in printed, f"symdyn {' '.join(words)} does not name {named}:\n{printed}"
        refused = _run([str(environment / SCRIPTS / "symdyn"), *_plot()], empty, fails=True)
        assert 'pip install "symdyn[plot]"' in refused, refused
        print(_run([python, "-c", PYTHON], empty), end="")
    print(f"wheel: {wheel.name} works in an empty environment, {time.monotonic() - begin:.0f} s")
    return 0


def _plot() -> Sequence[str]:
    return ("simulate", "furuta.toml", "--until", "1", "-o", "again.csv", "--plot", "run.svg")


def _built(kind: str, source: Path, folder: Path) -> Path:
    """Return the one file that building makes of a source tree."""
    before = set(folder.glob("symdyn-*"))
    words = [sys.executable, "-m", "build", kind, "--no-isolation", "--outdir", str(folder), str(source)]
    _run(words, ROOT)
    (made,) = set(folder.glob("symdyn-*")) - before
    return made


def _same(one: Path, other: Path) -> None:
    """Raise where two wheels hold different files."""
    left, right = ({entry.filename: entry.CRC for entry in zipfile.ZipFile(wheel).infolist()} for wheel in (one, other))
    differ = {name for name in {*left, *right} if left.get(name) != right.get(name)}
    assert not differ, f"the wheel of the sdist is not the wheel of the checkout: {sorted(differ)}"


def _run(words: Sequence[str], folder: Path, fails: bool = False) -> str:
    """Return what a command prints; its end is as expected, or this raises with all that it said."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(words, cwd=folder, env=kept, capture_output=True, text=True, check=False)
    said = done.stdout + done.stderr
    as_expected = (done.returncode != 0) == fails
    assert as_expected, f"{' '.join(words)}: {done.returncode}\n{said}"
    assert "Traceback" not in said, f"{' '.join(words)}:\n{said}"
    return said


if __name__ == "__main__":
    sys.exit(main())
