"""Eigenvalues by every door: Python, shell, JSON, file and notebook tell the same rows, zeros among them."""

from __future__ import annotations

import html
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "examples"

POINTS = {
    "cart_pole": (EXAMPLES / "cart_pole.toml", {}, {}),
    "furuta": (ROOT / "examples/gallery/furuta.toml", {"theta2": "0"}, {}),
    "free_body": (EXAMPLES / "free_body.toml", {}, {"flight_wx": "0", "flight_wy": "3", "flight_wz": "0"}),
    "rolling_disc": (
        EXAMPLES / "rolling_disc.toml", {"z": "r", "e0": "1", "e1": "0"}, {"flight_wx": "0", "flight_wy": "6"},
    ),
    "double_pendulum": (EXAMPLES / "double_pendulum.toml", {"q1": "pi", "q2": "0"}, {}),
}  # fmt: skip


def option(name: str, values: dict[str, str]) -> list[str]:
    return [name, ",".join(f"{key}={value}" for key, value in values.items())] if values else []


def table_of_shell(text: str) -> list[list[str]]:
    lines = text.splitlines()
    start = next((k for k, line in enumerate(lines) if line.startswith("eigenvalue, 1/s")), len(lines))
    rows = [re.split(r"  +", line) for line in lines[start + 1 :]]
    return rows[: next((k for k, row in enumerate(rows) if len(row) < 4), len(rows))]


def table_of_notebook(page: str) -> list[list[str]]:
    found = next((one for one in re.findall(r"<table.*?</table>", page, re.S) if "damping ratio" in one), "")
    rows = [re.findall(r"<td.*?>(.*?)</td>", row, re.S) for row in re.findall(r"<tr.*?</tr>", found, re.S)]
    return [[html.unescape(re.sub(r"<.*?>", "", cell)) for cell in row] for row in rows if row]


def number(x: float | str) -> float:
    """Return a number that is told; "-" and "" tell none."""
    return math.nan if x in ("-", "") else float(x)


def zeros_of(text: str) -> list[str]:
    return re.findall(r"\d+ eigenvalues? zero [^<\n]*", html.unescape(text))


@pytest.mark.mends("30.control.6")
@pytest.mark.mends("30.class.left_out")
@pytest.mark.parametrize("name", POINTS)
def test_every_door_tells_the_same_eigenvalues(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, at, rates = POINTS[name]
    one = symdyn.linearize(symdyn.read(path), start=at, start_rates=rates)
    words = ["linearize", str(path), *option("--start", at), *option("--start-rates", rates)]
    assert main(words) == 0
    shell = capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["result"]
    assert main([*words, "-o", str(tmp_path / "one.npz")]) == 0
    kept = np.load(tmp_path / "one.npz")
    page = one._repr_mimebundle_()["text/html"]

    rows, shown = table_of_shell(shell), table_of_notebook(page)
    assert len(rows) == len(shown) == len(told["eigenvalues"]) == len(one.modes)
    for mode, row, cells, entry in zip(one.modes, rows, shown, told["eigenvalues"], strict=True):
        assert row[0] == cells[0]
        assert row[3] == cells[3]
        for x in (row[1], cells[1], entry["frequency_hz"], mode.frequency):
            assert number(x) == pytest.approx(abs(mode.value) / (2 * math.pi), rel=1e-4), "as the page defines it"
        for x in (row[2], cells[2], entry["damping"], mode.damping):
            assert number(x) == pytest.approx(-mode.value.real / abs(mode.value), rel=1e-4, abs=1e-9)
    zeros = zeros_of(shell)
    assert zeros == zeros_of(page)
    counts = one.stability.zeros
    assert [int(line.split()[0]) for line in zeros] == list(counts.values())
    assert told["zero"] == counts == json.loads(str(kept["about"]))[0]["zero"]
    pairs = sum(2 if mode.oscillates else 1 for mode in one.modes)
    assert pairs + sum(counts.values()) == len(one.states) == len(one.poles) == len(kept["eigenvalues"])


def test_beside_the_modes_stand_the_zeros() -> None:
    path, at, _ = POINTS["furuta"]
    one = symdyn.linearize(symdyn.read(path), start=at)
    assert one.zero_eigenvalues == one.stability.zeros
    assert len(one.states) == 4
    assert one.zero_eigenvalues == {"cyclic": 1}
