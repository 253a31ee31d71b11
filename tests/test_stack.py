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
from symdyn.emit import Sources, beside, emit, write
from symdyn.errors import BuildError, EmitError
from symdyn.program import formulate, lower
from symdyn.runtime import build
from symdyn.scene import example
from symdyn.verify.building import read_back

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


PACKED = "inverse_dynamics_second_derivatives_packed"


@cache
def spaced(kind: str, real: str) -> tuple[Sources, Sources]:
    """Return functions of a kind with arrays of their own, and with none: what grows is work space."""
    with pytest.MonkeyPatch.context() as patch:
        if kind == "loops":
            for formulation, row in TABLE_LOOPS.items():
                patch.setitem(TABLE_LOOPS, formulation, replace(row, fewest=10))
            program = lower(formulate(turning_chain(12), LOOPS))
        elif kind == "pairs":
            patch.setattr(sys.modules[lower.__module__], "FEWEST_OF_PAIRS", 1)
            program = lower(formulate(jointed("free", "revolute", "revolute"), (PACKED,)))
        else:
            of = {"rows": "forward", "parts": "inverse"}[kind]
            program = lower(formulate(example("arm7"), (f"{of}_dynamics_derivatives", "gravity_forces")))
        own, given = emit(program, "c", real), emit(program, "c", real, option="stack=600")
        assert all(one.passed for one in read_back(given, {name: text.encode() for name, text in given.texts.items()}))
        return own, given


KINDS = [("parts", "double"), ("rows", "double"), ("rows", "float"), ("pairs", "float"), ("loops", "double")]


@pytest.mark.runs("gcc")
@pytest.mark.wide("rows-double")
@pytest.mark.parametrize(("kind", "real"), KINDS)
def test_work_space_changes_no_bit_and_the_stack_stays_within_its_limit(kind: str, real: str, tmp_path: Path) -> None:
    found = []
    for sources in spaced(kind, real):
        folder = tmp_path / (sources.option or "own")
        folder.mkdir()
        if sources.option:
            assert "_work = " in sources.texts[f"{sources.stem}.h"]
            taken = deepest(sources, folder)
            for name, (one, _) in told(sources).items():
                assert one <= 600
                assert taken[f"{sources.stem}_{name}"] <= 600 + SPILLED
        write({**sources, **beside(sources)}, folder)
        main = (folder / "main.c").read_text()
        shown = main.replace(
            "int off = 0;\n    for", "int off = fwrite(found, sizeof *found, (size_t)count, stderr) == 0;\n    for"
        )
        (folder / "main.c").write_text(shown)
        files = [f"{sources.stem}.c", "main.c"]
        words = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wno-unknown-pragmas", "-Werror"]
        subprocess.run(["gcc", *words, *files, "-o", "main", "-lm"], cwd=folder, check=True)
        ran = subprocess.run([folder / "main"], capture_output=True, check=True)
        assert b"WRONG" not in ran.stdout
        found.append(ran.stderr)

    assert found[0] == found[1]
    assert len(found[0]) > 100


def test_a_stack_that_cannot_be_is_refused_in_words() -> None:
    own, given = spaced("loops", "double")

    with pytest.raises(EmitError, match=r"chain12: forward_dynamics_derivatives keeps 512 bytes .* stack=512 would do"):
        emit(given.program, "c", option="stack=511")
    with pytest.raises(EmitError, match='stack="16kb" is no size; give bytes such as 4096, or 16k'):
        emit(own.program, "c", option="stack=16kb")
    with pytest.raises(EmitError, match="has no option stack=16k; it has batch"):
        emit(own.program, "cpp", option="stack=16k")
    with pytest.raises(EmitError, match="double-doubles keep their arrays on the stack; leave stack out"):
        emit(own.program, "c", "dd", option="stack=16k")
    with pytest.raises(BuildError, match="work space are called from C alone"):
        build(given)


def test_space_that_is_parted_otherwise_is_told() -> None:
    _, sources = spaced("parts", "double")
    text = sources.texts["arm7.c"].replace("*const r = w + ", "*const r = w + 9")

    source, header = read_back(sources, {"arm7.c": text.encode(), "arm7.h": sources.texts["arm7.h"].encode()})

    assert not source.passed
    assert "is no part of the work space" in source.where
    assert header.passed
