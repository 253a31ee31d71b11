"""Stores on disk that were damaged: the same command again gives what an undamaged run gives, or refuses in words."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError, StudyError
from symdyn.study.runs import Runs

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

PENDULUM = str(Path(__file__).parent.parent / "examples" / "pendulum.toml")


def swept(store: Path) -> Runs:
    """Return runs some of which fail, so that a store has words of runs too."""
    return symdyn.sweep(
        symdyn.example("pendulum"), "l=[-1,0.4,0.5,0.6,0.7,0.8]", ["max(abs(q1))", "end(q1)"], until=0.1,
        start="q1=0.3", method="dop853", block=2, output=store,
    )  # fmt: skip


def hashed(study: Runs) -> str:
    """Return a hash of all numbers and words of a study."""
    numbers = [study.values, study.codes, *(study[name] for name in study)]
    parts = [np.ascontiguousarray(one).tobytes() for one in numbers] + [repr(sorted(study.reasons.items())).encode()]
    return sha256(b"".join(parts)).hexdigest()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("zarr")
    store = tmp_path_factory.mktemp("whole") / "a.zarr"
    swept(store)
    return store


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def emptied(file: Path) -> None:
    file.write_bytes(b"")


def folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


def bit(at: float) -> Callable[[Path], None]:
    """Return what flips a bit at a share of a file's length."""

    def flip(file: Path) -> None:
        data = bytearray(file.read_bytes())
        data[min(int(at * len(data)), len(data) - 1)] ^= 1 << (len(data) % 7)
        file.write_bytes(data)

    return flip


DAMAGES: Mapping[str, Callable[[Path], None]] = {
    "deleted": Path.unlink,
    "cut": cut,
    "empty": emptied,
    "folder": folder,
    **{f"bit at {at}": bit(at) for at in (0.0, 0.2, 0.5, 0.8, 1.0)},
}

FILES = tuple(f"{name}/{file}" for name in ("values", "measures") for file in ("zarr.json", "c/1/0", "c/2/0"))
FILES += ("zarr.json", "measures/c/0/0", "codes/zarr.json", "codes/c/0", "codes/c/1")
FILES += ("hashes/zarr.json", "hashes/c/1/0")


UNSEEN = ("deleted", "folder", "bit at 0.5", "bit at 0.8", "bit at 1.0")
"""Damages that were once believed; readers of Zarr see the others."""


@pytest.mark.wide("deleted", "bit at 0.5")
@pytest.mark.parametrize(
    "damage",
    [pytest.param(name, marks=[pytest.mark.mends("30.attacks.3")] if name in UNSEEN else []) for name in DAMAGES],
)
def test_a_damaged_store_gives_the_same_numbers_or_is_refused(damage: str, whole: Path, tmp_path: Path) -> None:
    wrong, right = [], hashed(symdyn.study.open(whole))
    for number, file in enumerate(name for name in FILES if (whole / name).is_file()):
        store = tmp_path / f"{number}.zarr"
        shutil.copytree(whole, store)
        DAMAGES[damage](store / file)
        for again in (symdyn.study.open, swept):
            try:
                study = again(store)
            except SimulateError as fault:
                if str(store) not in str(fault):
                    wrong.append(f"{file}, {again.__name__}: {fault}")
                continue
            if again is swept or study.complete:
                found = hashed(study)
            else:  # a block that counts as not made has no numbers
                assert study.left == 2
                found = right if np.isnan(study["end(q1)"]).sum() == 2 + study.failed else "numbers that are not there"
            if found != right:
                wrong.append(f"{file}, {again.__name__}")

    assert not wrong


def test_every_kind_of_file_of_a_store_is_damaged_above(whole: Path) -> None:
    there = {str(file.relative_to(whole)) for file in whole.rglob("*") if file.is_file()}

    assert set(FILES) <= there
    assert {file.split("/c/")[0] for file in there} == {file.split("/c/")[0] for file in FILES}


@pytest.mark.mends("30.attacks.3")
@pytest.mark.parametrize("name", ["measures", "values"])
def test_a_chunk_that_is_missing_is_called_missing(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("zarr")
    words = ["sweep", PENDULUM, "--over", "q1=linspace(0.1,0.3,8)", "--until", "0.1", "--measure", "max(abs(q1))"]
    words += ["--method", "dop853", "--block", "2", "--json", "-o", str(tmp_path / "a.zarr")]
    assert main(words) == 0
    first = json.loads(capsys.readouterr().out)["result"]
    (tmp_path / "a.zarr" / name / "c" / "1" / "0").unlink()

    assert main(words) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["result"] == first
    assert "finite number" not in err
    assert "3 of 4 blocks are there already" in err
    assert f"{name}/c/1/0 is missing; its block is made again" in err
    assert (tmp_path / "a.zarr" / name / "c" / "1" / "0").is_file()


def test_blocks_of_which_no_run_has_a_measure_are_kept_as_files(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    said: list[str] = []
    for _ in range(2):
        said.clear()
        study = symdyn.sweep(
            symdyn.example("pendulum"), "l=[-1,-2,0.5,0.6]", "max(abs(q1))", until=0.1, method="dop853", block=2,
            output=tmp_path / "a.zarr", say=said.append,
        )  # fmt: skip
        assert study.failed == 2
    assert any("2 of 2 blocks are there already" in line for line in said)


@pytest.mark.mends("30.attacks.3")
def test_a_store_without_checksums_is_refused_in_words(tmp_path: Path) -> None:
    import zarr

    store = tmp_path / "a.zarr"
    swept(store)
    group = zarr.open_group(str(store), mode="r+")
    group.attrs["version"] = 1

    with pytest.raises(SimulateError, match=r"another version of symdyn.*delete this one"):
        swept(store)


def test_a_large_store_is_read_column_by_column_and_says_what_is_spoilt(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symdyn.study.store.LARGEST", 1)
    shutil.copytree(whole, tmp_path / "a.zarr")
    study = symdyn.study.open(tmp_path / "a.zarr")
    assert hashed(study) == hashed(symdyn.study.open(whole))

    bit(0.5)(tmp_path / "a.zarr" / "measures" / "c" / "1" / "0")
    with pytest.raises(StudyError, match=r"a block cannot be read .* makes what is spoilt again"):
        study["end(q1)"]


@pytest.mark.wide(3)
@pytest.mark.mends("30.attacks.3")
@pytest.mark.mends("30.class.believed")
@pytest.mark.parametrize("name", ["values", "measures", "codes", "all"])
@pytest.mark.parametrize("other", [False, True])
def test_a_block_in_the_place_of_another_is_made_again(name: str, other: bool, whole: Path, tmp_path: Path) -> None:
    """Blocks are whole wherever they are copied to, from their own store or from that of another sweep."""
    store, source = tmp_path / "a.zarr", whole
    shutil.copytree(whole, store)
    if other:
        source = tmp_path / "b.zarr"
        symdyn.sweep(
            symdyn.example("pendulum"), "l=[-1,0.3,0.2,-0.6,0.1,-0.9]", ["max(abs(q1))", "end(q1)"], until=0.1,
            start="q1=0.3", method="dop853", block=2, output=source,
        )  # fmt: skip
    for one in sorted(file.name for file in store.iterdir() if file.is_dir()) if name == "all" else [name]:
        chunk = "{}" if one == "codes" else "{}/0"
        shutil.copyfile(
            source / one / "c" / chunk.format(2 if other else 1), store / one / "c" / chunk.format(2 if other else 0)
        )

    with pytest.raises(StudyError, match=r"a block cannot be read .* makes what is spoilt again"):
        symdyn.study.open(store)
    assert hashed(swept(store)) == hashed(symdyn.study.open(whole))


def test_a_pipe_in_a_store_is_refused_in_words(whole: Path, tmp_path: Path) -> None:
    for number, file in enumerate(("zarr.json", "codes/zarr.json", "codes/c/1", "measures/c/1/0", "hashes/c/1/0")):
        store = tmp_path / f"{number}.zarr"
        shutil.copytree(whole, store)
        (store / file).unlink()
        os.mkfifo(store / file)
        for again in (swept, symdyn.study.open):
            with pytest.raises(SimulateError, match=r"no file|is missing"):
                again(store)


def test_a_chunk_of_gigabytes_is_called_spoilt_unread(whole: Path, tmp_path: Path) -> None:
    store = tmp_path / "a.zarr"
    shutil.copytree(whole, store)
    os.truncate(store / "codes" / "c" / "1", 1 << 40)  # more than any memory holds

    with pytest.raises(StudyError, match=r"codes/c/1 is spoilt: it has 1099511627776 bytes"):
        symdyn.study.open(store)
    assert hashed(swept(store)) == hashed(symdyn.study.open(whole))
