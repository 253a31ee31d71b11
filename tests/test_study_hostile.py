"""What a stranger gives a sweep or an identification is told in words: stores, names, numbers beyond doubles."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import IdentifyError, SimulateError, StudyError
from symdyn.scene.values.letters import read_tolerance
from symdyn.scene.values.quantity import FormulaError
from symdyn.study.runs import Runs

pytestmark = [pytest.mark.runs("cc"), pytest.mark.filterwarnings("error::RuntimeWarning")]


def swept(**other: Any) -> Runs:
    """Return a sweep of the pendulum."""
    asked: dict[str, Any] = {
        "until": 0.1,
        "method": "dop853",
        "over": "q1=linspace(0.1,0.3,4)",
        "measure": "max(abs(q1))",
        "block": 2,
    }
    return symdyn.sweep(symdyn.example("pendulum"), **asked | other)


def said(key: str, value: Any) -> Callable[[Path], None]:
    """Return what changes an attribute of a store; None takes it away."""

    def change(store: Path) -> None:
        root = json.loads((store / "zarr.json").read_text())
        root["attributes"][key] = value
        if value is None:
            del root["attributes"][key]
        (store / "zarr.json").write_text(json.dumps(root))

    return change


def array(name: str, **changes: Any) -> Callable[[Path], None]:
    """Return what changes the metadata of an array of a store."""

    def change(store: Path) -> None:
        file = store / name / "zarr.json"
        file.write_text(json.dumps(json.loads(file.read_text()) | changes))

    return change


def chunks(*shape: int) -> dict[str, Any]:
    return {"name": "regular", "configuration": {"chunk_shape": shape}}


CHANGED: Mapping[str, Callable[[Path], None]] = {
    **{f"no {key}": said(key, None) for key in ("reasons", "job", "names", "measures", "units", "scene", "symdyn")},
    "reasons list": said("reasons", [1]),
    "reasons no number": said("reasons", {"x": "y"}),
    "reasons no text": said("reasons", {"1": {}}),
    "names more": said("names", ["a", "b"]),
    "names nested": said("names", [["q1"]]),
    "names escape": said("names", ["\x1b[2J"]),
    "scene escape": said("scene", "\x1b[2J"),
    "units none": said("units", {}),
    "job list": said("job", [1]),
    "another scene": said("scene_toml", 'name = "other"'),
    "codes shorter": array("codes", shape=[2]),
    "codes huge": array("codes", shape=[10**12]),
    "codes without chunks": array("codes", chunk_grid=chunks(0)),
    "codes in one chunk": array("codes", chunk_grid=chunks(10**12)),
    "codes other numbers": array("codes", data_type="float64"),
    "values flat": array("values", shape=[4], chunk_grid=chunks(2)),
    "measures wide": array("measures", shape=[4, 7], chunk_grid=chunks(2, 7)),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("zarr")
    store = tmp_path_factory.mktemp("whole") / "a.zarr"
    swept(output=store)
    return store


@pytest.mark.parametrize("change", CHANGED)
def test_a_store_that_somebody_changed_is_refused(change: str, whole: Path, tmp_path: Path) -> None:
    store = shutil.copytree(whole, tmp_path / "a.zarr")

    CHANGED[change](store)

    with pytest.raises(StudyError, match=r"spoilt"):
        symdyn.study.open(store)
    with pytest.raises(SimulateError, match=r"spoilt"):
        swept(output=store)


@pytest.mark.parametrize("name", ["values", "measures"])
def test_a_block_of_which_a_part_is_spoilt_is_made_again(name: str, tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    store = tmp_path / "a.zarr"
    whole = swept(output=store)

    (store / name / "c" / "1" / "0").write_bytes(b"spoilt")

    with pytest.raises(StudyError, match=r"a block cannot be read .* makes what is spoilt again"):
        symdyn.study.open(store)["max(abs(q1))"]
    assert swept(output=store)["max(abs(q1))"].tolist() == whole["max(abs(q1))"].tolist()


def test_a_store_is_a_folder_here_whatever_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("zarr")
    monkeypatch.chdir(tmp_path)

    swept(output="memory::a.zarr")

    assert symdyn.study.open("memory::a.zarr").complete


@pytest.mark.parametrize(
    ("measure", "told"),
    [
        ("\x1b[2J=max(q1)", "no name of a column"),
        ("=max(q1)", "no name of a column"),
        ("a\nb=max(q1)", "no name of a column"),
        ("<b>=max(q1)", "no name of a column"),
        ("q1=max(abs(q1))", "column of what is varied"),
        ("ended=max(q1)", "column of how a run ended"),
        ("max(q1) + fold_1", "fold_1"),
    ],
)
def test_a_measure_has_a_name_of_its_own(measure: str, told: str) -> None:
    with pytest.raises(SimulateError, match=told):
        swept(measure=measure)


def test_more_runs_than_memory_holds_are_refused() -> None:
    with pytest.raises(StudyError, match=r"do not fit into memory; keep them on disk, -o FILE\.zarr"):
        swept(over="q1=uniform(0,1)", count=10**12)


@pytest.mark.parametrize("over", ["q1=linspace(-1e308,1e308,3)", "q1=logspace(1,400,3)"])
def test_a_list_beyond_doubles_is_refused(over: str) -> None:
    with pytest.raises(SimulateError, match=r"beyond the largest double"):
        swept(over=over)


@pytest.mark.parametrize("kind", ["uniform(-1e308,1e308)", "lognormal(median=1,sigma=1e300)", "normal(0,1e308)"])
def test_a_draw_beyond_doubles_fails_without_a_warning(kind: str) -> None:
    assert swept(over=f"q1={kind}", count=8).failed


def test_a_measure_without_a_value_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", "pendulum", "--until", "0.1", "--over", "q1=[0,0.1]", "--method", "dop853", "--measure"]
    words[1] = str(Path(__file__).parent.parent / "examples" / "pendulum.toml")

    assert main([*words, "1/max(abs(q1))"]) == 0
    assert "1/max(abs(q1)) is no finite number in 1 of 2 runs" in capsys.readouterr().err
    assert main([*words, "log(min(q1)-5)"]) == 1
    assert "no run has measures" in capsys.readouterr().err


def test_digits_of_a_tolerance_are_those_of_a_file() -> None:
    with pytest.raises(FormulaError, match="no tolerance"):
        read_tolerance("\u0665 %", "kg")


@pytest.mark.parametrize(
    ("step", "size", "told"),
    [(1e-300, 1.0, "samples are 1e-300 s apart"), (5e-324, 1.0, "s apart"), (0.01, 1e300, r"q1 goes to 1e\+300")],
)
def test_a_log_beyond_doubles_is_refused(step: float, size: float, told: str) -> None:
    k = np.arange(100)
    log = {"t": step * k, "q1": size * np.cos(k), "tau1": np.sin(k)}

    with pytest.raises(IdentifyError, match=told):
        symdyn.identify(symdyn.example("pendulum"), log)


def test_a_file_of_many_columns_is_told_in_a_line() -> None:
    k = np.arange(100.0)
    log = {"t": k, **{f"x{n}": k for n in range(2000)}}

    with pytest.raises(IdentifyError) as caught:
        symdyn.identify(symdyn.example("pendulum"), log)
    assert len(str(caught.value)) < 1000
