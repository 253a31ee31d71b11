"""Files: the same bytes every time, all of a file or nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from formulas import every_op

from symdyn.emit import emit, write
from symdyn.errors import EmitError
from symdyn.program import lower

PRINT_ALL = """
from formulas import every_op
from mechanisms import random_tree
from symdyn.dynamics.outputs.derive import derive
from symdyn.emit import emit
from symdyn.program import lower
for equations in (every_op(), derive(random_tree(3, 4), ("inverse_dynamics", "mass_matrix", "k_C"))):
    for target in ("numpy", "c"):
        for name, text in emit(lower(equations), target).items():
            print(name, text)
"""


@pytest.mark.runs
def test_the_same_scene_gives_the_same_bytes_under_any_hash_seed():
    outputs = []
    for seed in ("1", "20240601"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(Path(__file__).parent)}
        ran = subprocess.run([sys.executable, "-c", PRINT_ALL], env=environment, capture_output=True, check=True)
        outputs.append(ran.stdout)
    assert len(outputs[0]) > 10_000
    assert outputs[0] == outputs[1]


def test_emitting_twice_from_one_graph_gives_the_same_bytes():
    equations = every_op()
    first = emit(lower(equations), "c")
    equations.graph.symbol("later") + 7
    assert emit(lower(equations), "c").files == first.files


def test_files_are_written_into_a_new_folder(tmp_path):
    sources = emit(lower(every_op()), "c")
    paths = write(sources, tmp_path / "deep" / "er")
    assert [path.name for path in paths] == ["every_op.c", "every_op.h"]
    assert sorted(os.listdir(tmp_path / "deep" / "er")) == ["every_op.c", "every_op.h"]
    assert all(path.read_bytes().decode() == sources[path.name] for path in paths)


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(EmitError, match=r"file: cannot write every_op\.py there .* give a folder"):
        write(emit(lower(every_op())), tmp_path / "file")
    assert (tmp_path / "file").read_text() == "mine"


def test_nothing_stays_behind_when_writing_fails(tmp_path):
    (tmp_path / "every_op.py").mkdir()
    with pytest.raises(EmitError, match=r"cannot write every_op\.py there"):
        write(emit(lower(every_op())), tmp_path)
    assert os.listdir(tmp_path) == ["every_op.py"]


def test_generated_text_ends_with_one_line_end_and_has_no_trailing_blanks():
    for target in ("numpy", "c"):
        for text in emit(lower(every_op()), target).values():
            assert text.endswith("\n")
            assert not text.endswith("\n\n")
            assert all(line == line.rstrip() for line in text.splitlines())
