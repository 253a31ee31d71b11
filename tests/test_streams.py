"""Standard streams that are closed, know few letters or are cut off, and a signal that comes early: no traceback."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from patience import HANG

from symdyn.cli import main

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"


def shell(words: str, redirected: str, folder: Path) -> tuple[int, str, str]:
    """Return exit status, stdout and stderr of a command whose streams a shell has redirected."""
    out, err = folder / "out", folder / "err"
    line = f'exec "{sys.executable}" -m symdyn {words} > out 2> err {redirected}'
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    status = subprocess.run(["sh", "-c", line], cwd=folder, env=environment, timeout=HANG, check=False).returncode
    return status, out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8")


@pytest.mark.mends("2.closed")
@pytest.mark.parametrize("redirected", [">&-", "<&- >&- 2>&-"])
def test_a_closed_stream_is_no_fault(redirected: str, tmp_path: Path) -> None:
    status, _, err = shell("new arm", redirected, tmp_path)

    assert (status, "Traceback" in err) == (0, False)
    assert 'name = "arm"' in (tmp_path / "arm.toml").read_text(encoding="utf-8")


@pytest.mark.mends("2.closed")
def test_a_message_for_nobody_goes_nowhere(tmp_path: Path) -> None:
    status, out, _ = shell("info missing.toml", "2>&-", tmp_path)

    assert (status, out) == (1, "")


ROD = """
name = "rod"
gravity = [0, "-g", 0]
[parameters]
g = { text = "tiaž", unit = "m/s²" }
m = { text = "hmotnosť ťažidla", unit = "kg·1" }
[bodies.b]
mass = "m"
com = [1, 0, 0]
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 0, 1]
"""


@pytest.mark.mends("2.ascii")
@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["check-derivation", "homework.txt", str(EXAMPLES / "two_link.toml"), "--language", "sk"], "k_z12"),
        (["info", "rod.toml"], "tazidla"),
        (["info", "rod.toml", "--json"], '"name": "rod"'),
        (["equations", "rod.toml", "--document"], "\\end{document}"),
    ],
)
def test_letters_that_a_terminal_lacks_end_no_command(
    words: list[str], shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "homework.txt").write_text("k_{z,12} = m_2 h_2^2 + m_1 h_1 h_2 c_2\n", encoding="utf-8")
    (tmp_path / "rod.toml").write_text(ROD, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii", write_through=True))

    status = main(words)

    assert status in (0, 1)
    assert shown in raw.getvalue().decode("ascii")


def test_what_a_terminal_lacks_is_written_as_the_nearest_letters(monkeypatch: pytest.MonkeyPatch) -> None:
    from symdyn.cli.talk import prepare_streams

    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="ascii", write_through=True))

    prepare_streams()
    print("ťažisko · q̇₁ → ω ≤ 3 m² 日")

    assert raw.getvalue().decode("ascii") == "tazisko * q1 -> omega <= 3 m2 ?\n"


INTERRUPTED = """
import os, runpy, signal, sys

class Early:
    def find_spec(self, name, path=None, target=None):
        if name == "symdyn.cli":
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started us with signals ignored
sys.meta_path.insert(0, Early())
sys.argv[1:] = ["--version"]
runpy.run_module("symdyn", run_name="__main__")
"""


@pytest.mark.mends("2.sigint")
@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_a_signal_that_comes_before_a_command_listens_prints_no_traceback() -> None:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    ran = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, timeout=HANG, env=environment, check=False
    )

    assert ran.returncode in (-signal.SIGINT, 130)
    assert "Traceback" not in ran.stderr
