"""What a person sees of the package before calling anything: names, TAB, types, the version, and how soon."""

from __future__ import annotations

import ast
import doctest
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import symdyn

ROOT = Path(__file__).parent.parent

ALL_DOORS = "import symdyn\n" + "".join(f"symdyn.{name}\n" for name in (*symdyn.__all__, *symdyn._packages))


def python(code: str) -> str:
    """Return what a fresh process prints."""
    ran = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.mark.runs
def test_dir_lists_doors_and_rooms_and_nothing_else():
    seen = ast.literal_eval(python("import symdyn; print(dir(symdyn))"))
    hidden = [name for name in seen if name.startswith("_")]

    assert set(seen) - set(hidden) == {*symdyn.__all__, *symdyn._packages}
    assert "__version__" in hidden
    assert all(name.startswith("__") for name in hidden)


@pytest.mark.runs
@pytest.mark.parametrize(("begun", "found"), [("sim", "symdyn.simulate("), ("sce", "symdyn.scene"), ("__v", "symdyn.")])
def test_tab_completes_doors_and_rooms(begun, found):
    code = "import rlcompleter, symdyn; complete = rlcompleter.Completer({'symdyn': symdyn}).complete\n"
    told = python(f"{code}print([complete('symdyn.{begun}', k) for k in range(9)])")

    assert any((one or "").startswith(found) for one in ast.literal_eval(told))


@pytest.mark.runs
def test_rooms_are_there_without_being_imported():
    assert python("import symdyn; print(symdyn.scene.revolute.__name__)") == "revolute\n"
    assert set(symdyn._packages) <= {path.name.removesuffix(".py") for path in (ROOT / "symdyn").iterdir()}


def test_the_version_is_that_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    assert symdyn.__version__ == project["version"]


@pytest.mark.runs
def test_what_is_not_there_is_told_with_what_is_meant():
    ran = subprocess.run(
        [sys.executable, "-c", "import symdyn; symdyn.simulat"], capture_output=True, text=True, check=False
    )

    last = ran.stderr.strip().splitlines()[-1]
    assert "symdyn has no 'simulat'; did you mean simulate?" in last
    assert last.endswith("Did you mean: 'simulate'?")


@pytest.mark.runs
def test_importing_reads_the_root_and_what_it_fills_and_none_of_others():
    code = "import sys; before = set(sys.modules); import symdyn; print(sorted(set(sys.modules) - before))"
    found = ast.literal_eval(python(code))

    assert [name for name in found if name.startswith("symdyn")] == ["symdyn", "symdyn.shown"]  # which the root fills
    assert {name.partition(".")[0] for name in found} - sys.stdlib_module_names == {"symdyn", "lazy_loader"}


def pyright(path: Path) -> list[tuple[int, str, str]]:
    """Return what pyright says of a file: line, rule or kind, message."""
    pytest.importorskip("pyright")
    words = [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable, str(path)]
    ran = subprocess.run(words, cwd=path.parent, capture_output=True, text=True, check=False)
    told = json.loads(ran.stdout)["generalDiagnostics"]
    return [(one["range"]["start"]["line"] + 1, one.get("rule", one["severity"]), one["message"]) for one in told]


@pytest.mark.slow
@pytest.mark.runs("node")
@pytest.mark.long(0)
def test_pyright_knows_every_door_and_refuses_the_rest(tmp_path):
    path = tmp_path / "seen.py"
    shown = [f"reveal_type(symdyn.{name})" for name in symdyn.__all__]
    path.write_text("\n".join(["import symdyn", *shown, "symdyn.nothing", "symdyn.scene.box", "symdyn.__version__"]))
    said = pyright(path)

    wrong = [(line, rule) for line, rule, _ in said if rule != "information"]
    assert wrong == [(len(shown) + k, "reportAttributeAccessIssue") for k in (2, 3)]
    assert len(said) == len(shown) + 2
    assert not [text for _, _, text in said if re.search(r'is "(Unknown|Any)"', text)]


WORK = """# pyright: strict
import numpy as np
import symdyn
cart = symdyn.example("cart_pole")
run = symdyn.simulate(cart, until=np.float64(3), start={"x": 0, "theta": 0.1}, values={"mc": 1, "l": "1/2"}, every=0.1)
run = symdyn.simulate(cart, until=3, start="x=1", forces={"F": "-x"}, stops=["x - 1"], reports="x")
lin = symdyn.linearize(cart, start={"theta": 3, "x": 1.0}, forces={"F": 0}, values={"mc": 2}, outputs=["x"])
symdyn.picture(cart, q=[0, 1], parameters={"mc": np.float64(1)})
symdyn.animation(cart, run.t, run.q)
symdyn.sweep(cart, {"mc": np.linspace(1, 2, 5)}, ["max(x)", "end(x)"], until=2)
symdyn.ensemble(cart, until=2, start={"x": [0, 1]}, measures="max(x)")
symdyn.inverse(cart, {"x": "t", "theta": 0}, times=[0, 1, 2])
symdyn.collocation(cart, until=2, cost="F**2", start={"x": 0}, end={"x": 1}, bounds={"F": (-1, 1), "x": (-2.0, None)})
symdyn.identify(cart, {"t": [0, 1], "x": np.zeros(2)}, units={"t": "ms"}, values={"g": 9.81})
print(symdyn.load(cart, parameters={"mc": 1, "l": "1/2"}, free=["mc"]).mass_matrix([0, 1], mc=2))
"""


@pytest.mark.slow
@pytest.mark.runs("node")
@pytest.mark.long(0)
def test_pyright_takes_what_works(tmp_path):
    """`linearize` wanted texts where everyone writes numbers."""
    path = tmp_path / "work.py"
    path.write_text(WORK)

    assert pyright(path) == []


@pytest.mark.runs
@pytest.mark.long(0)
def test_mypy_knows_every_name_and_refuses_the_rest(tmp_path):
    """Only the front page is followed, which takes a second; `make types` looks at all behind it."""
    pytest.importorskip("mypy")
    path = tmp_path / "seen.py"
    path.write_text(ALL_DOORS + "symdyn.__version__\nsymdyn.nothing\n")
    words = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=skip", f"--cache-dir={tmp_path}"]
    words += [str(ROOT / "symdyn" / "__init__.pyi"), str(path)]
    ran = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)

    said = [line for line in ran.stdout.splitlines() if "error:" in line]
    assert len(said) == 1, ran.stdout
    assert 'Module has no attribute "nothing"' in said[0]


@pytest.mark.parametrize("name", [name for name in symdyn.__all__ if name != "SymdynError"])
def test_every_door_has_an_example(name):
    """`make doctest`, a part of the gate, runs them."""
    assert doctest.DocTestParser().get_examples(getattr(symdyn, name).__doc__)
