"""The stack that a function of C says it takes, against what gcc gives each function and whom these call."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from arms import turning_chain
from mechanisms import jointed

from symdyn.dynamics.recursive.table_loops import TABLE_LOOPS
from symdyn.emit import Sources, emit
from symdyn.program import formulate, lower
from symdyn.scene import example

SPILLED = 1500
"""Bytes that gcc took besides at -O1, at most: 200 to 1,220 of them, with those of the sines that are called."""

WIDEST = 0.9
"""Share of what is told that many states took at least: it is for vectors of 64 bytes, some of them in registers."""

LOOPS = "inverse_dynamics", "forward_dynamics_derivatives"


def told(sources: Sources) -> dict[str, tuple[int, int]]:
    """Return what the header says of each function: bytes for one state, and for many."""
    header = next(text for name, text in sources.texts.items() if name.endswith(".h"))
    found = re.findall(r"stack: ([0-9,]+) bytes of arrays(?:, ([0-9,]+) of many states)?, and what", header)
    sizes = [tuple(int(x.replace(",", "") or 0) for x in one) for one in found]
    return dict(zip(sources.functions, sizes, strict=True))  # type: ignore[arg-type]


def deepest(sources: Sources, folder: Path) -> dict[str, int]:
    """Return, of each function of the source, the bytes of its frame and of the deepest of those that it calls."""
    for name, text in sources.texts.items():
        (folder / name).write_text(text)
    source = next(name for name in sources if name.endswith(".c"))
    words = ["-std=c99", "-O1", "-fno-math-errno", "-fcallgraph-info=su", "-Wno-unknown-pragmas", "-o", "made.o", "-c"]
    subprocess.run(["gcc", *words, source], cwd=folder, check=True)
    graph = next(folder.glob("*.ci")).read_text()
    own = {a: int(b) for a, b in re.findall(r'node: \{ title: "([^"]*)" label: "[^"]*\\n(\d+) bytes', graph)}
    calls: dict[str, set[str]] = {}
    for a, b in re.findall(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"', graph):
        calls.setdefault(a, set()).add(b)

    @cache
    def of(name: str) -> int:
        return own.get(name, 0) + max(map(of, calls.get(name, ())), default=0)

    return {name.split(":")[-1]: of(name) for name in own}


def check(sources: Sources, folder: Path) -> None:
    sizes, found = told(sources), deepest(sources, folder)
    assert len(sizes) == len(sources.functions)
    for name, (one, many) in sizes.items():
        for ending, size in (("", one), *((way, many) for way in ("_batch", "_rows") if sources.batch)):
            taken = found[f"{sources.stem}_{name}{ending}"]
            assert (WIDEST * size if ending else size) <= taken <= size + SPILLED, (name, ending)


@pytest.mark.runs("gcc")
@pytest.mark.parametrize(
    ("scene", "real", "option"),
    [("puma560", "double", ""), ("puma560", "double", "batch"), ("two_link", "dd", ""), ("two_link", "dd", "batch")],
)
def test_what_lines_take_is_their_arrays_and_spills(scene: str, real: str, option: str, tmp_path: Path) -> None:
    program = lower(formulate(example(scene), ("inverse_dynamics", "mass_matrix")))

    check(emit(program, "c", real, option=option), tmp_path)


@pytest.mark.runs("gcc")
def test_what_parts_and_rows_take_is_their_arrays(tmp_path: Path) -> None:
    program = lower(formulate(example("arm7"), ("forward_dynamics_derivatives",)))

    check(emit(program, "c"), tmp_path)


@pytest.mark.runs("gcc")
def test_what_pairs_of_velocities_take_is_their_arrays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[lower.__module__], "FEWEST_OF_PAIRS", 1)
    packed = "inverse_dynamics_second_derivatives_packed"
    sources = emit(lower(formulate(jointed("free", "revolute", "revolute"), (packed,))), "c")
    assert "_solved(r, out)" in sources.texts[f"{sources.stem}.c"]

    check(sources, tmp_path)


@pytest.mark.runs("gcc")
@pytest.mark.parametrize(("real", "option"), [("double", ""), pytest.param("float", "batch", marks=pytest.mark.slow)])
def test_what_loops_over_tables_take_is_their_arrays(
    real: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for formulation, row in TABLE_LOOPS.items():
        monkeypatch.setitem(TABLE_LOOPS, formulation, replace(row, fewest=10))
    program = lower(formulate(turning_chain(12), LOOPS))
    assert all(routine.function.loop for routine in program.routines)

    check(emit(program, "c", real, option=option), tmp_path)
