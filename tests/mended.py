"""Show that tests of mended faults fail where the faults were found: `python tests/mended.py [ITEM ..]`.

Each test marked `@pytest.mark.mends("30.numbers.1")` is run on a checkout of the commit on which the fault was found,
and as it is today on what is here. Tests of the first reading run there as they were written when its faults were
mended and files had the names of then; those of the second as they are now. A test that ends there by an import, a
name, a flag or a file that it lacks shows nothing, and that is reported. Beside each stands what it failed with there.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

LACKS = (
    *("ImportError:", "ModuleNotFoundError:", "AttributeError: module 'symdyn", "NameError:", "fixture '"),
    *("unexpected keyword argument", "unrecognized arguments", "invalid choice", "FileNotFoundError:"),
    *("has no attribute '", "is no key"),
)
"""What a test ends with that shows a missing name, flag or file, not a fault."""


@dataclass(frozen=True)
class Reading:
    """One reading of the tool, and where its faults can still be seen.

    Attributes:
        found_at: the commit on which they were found.
        written_at: the commit whose tests are run there; "" takes those that are here.
        read: what of that commit, or of what is here, stands beside the code of then.
        renamed: packages by the names that those tests know, and what they were called where the faults were found.
        prefix: how marks of its items begin.
    """

    found_at: str
    written_at: str
    read: tuple[str, ...]
    renamed: Mapping[str, str]
    prefix: str


READINGS = {
    "first": Reading("9263f8b", "082f7c6", ("tests", "examples", "pyproject.toml"), {"simulation": "simulate"}, ""),
    "second": Reading("0a445b81", "", ("tests", "pyproject.toml"), {}, "30."),
}

PLUGIN = """
import json, os, pytest
def pytest_addoption(parser):
    parser.addoption("--items", default="")
def pytest_collection_modifyitems(config, items):
    wanted = tuple(filter(None, config.getoption("--items").split(",")))
    prefix, others = os.environ["PREFIX"], tuple(filter(None, os.environ["OTHERS"].split(",")))
    def taken(item):
        mine = item.startswith(prefix) and not item.startswith(others)
        return mine and (not wanted or item.startswith(wanted))
    kept = [one for one in items if any(taken(m.args[0]) for m in one.iter_markers("mends"))]
    config.hook.pytest_deselected(items=[one for one in items if one not in kept])
    items[:] = kept
@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    report = (yield).get_result()
    if report.when == "call" or report.failed:
        kind = call.excinfo.typename if call.excinfo else ""
        with open(os.environ["MENDED"], "a", encoding="utf-8") as out:
            for mark in item.iter_markers("mends"):
                line = [mark.args[0], item.nodeid, report.outcome, kind, str(call.excinfo and call.excinfo.value)[:300]]
                out.write(json.dumps(line) + chr(10))
"""


def main() -> int:
    """Run the marked tests at both commits and print item, test, verdict."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("items", nargs="*", help="items, or how they begin")
    parser.add_argument("--reading", choices=READINGS, default="second")
    given = parser.parse_args()
    reading = READINGS[given.reading]
    with tempfile.TemporaryDirectory() as folder:
        old = Path(folder) / "old"
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(old)], check=True)
        subprocess.run(["git", "-C", str(old), "checkout", "--quiet", reading.found_at], check=True)
        if reading.written_at:
            checkout = ["git", "-C", str(old), "checkout", "--quiet", reading.written_at, "--", *reading.read]
            subprocess.run(checkout, check=True)
        else:
            _copy(reading.read, old)
        for name, was in reading.renamed.items():
            (old / "symdyn" / name).symlink_to(was)
        then = _run(old, Path(folder) / "then", reading, given.items)
        now = _run(ROOT, Path(folder) / "now", reading, given.items)
    return _table(then, now)


def _copy(names: tuple[str, ...], old: Path) -> None:
    """Put files and folders that are here into an older tree, in place of its own."""
    for name in names:
        here, there = ROOT / name, old / name
        if here.is_dir():
            shutil.rmtree(there)
            shutil.copytree(here, there, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(here, there)


def _run(root: Path, out: Path, reading: Reading, items: list[str]) -> dict[tuple[str, str], tuple[str, str]]:
    """Return outcome and exception of every marked test of a tree, by item and test."""
    plugin = out.parent / "plugin"
    plugin.mkdir(exist_ok=True)
    (plugin / "mended_plugin.py").write_text(PLUGIN, encoding="utf-8")
    path = os.pathsep.join([str(root), str(plugin)])
    out.write_text("", encoding="utf-8")
    others = ",".join(one.prefix for one in READINGS.values() if one.prefix and one != reading)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "mended_plugin", "-p", "no:cacheprovider"]
    command += ["--items", ",".join(items), "-m", "mends", "--continue-on-collection-errors", "tests"]
    subprocess.run(
        command,
        cwd=root,
        env=os.environ | {"PYTHONPATH": path, "MENDED": str(out), "PREFIX": reading.prefix, "OTHERS": others},
        stdout=subprocess.DEVNULL,
        check=False,
    )
    lines = [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()]
    return {(item, test): (outcome, f"{kind}: {text}") for item, test, outcome, kind, text in lines}


def _table(then: dict[tuple[str, str], tuple[str, str]], now: dict[tuple[str, str], tuple[str, str]]) -> int:
    """Print one line a test; return how many items have no test that failed then and passes now."""
    shown: dict[str, bool] = defaultdict(bool)
    for (item, test), (outcome, _) in sorted(now.items()):
        before, why = then.get((item, test), ("not collected", ""))
        lacks = before == "failed" and any(word in why for word in LACKS)
        held = before == "failed" and not lacks and outcome == "passed"
        verdict = "mended" if held else "not shown: lacks a name there" if lacks else f"not shown: {before} there"
        shown[item] |= held
        print(f"{item:20} {verdict if outcome == 'passed' else 'FAILS NOW':32} {test}")
        if why:
            print(f"{'':20} then: {' '.join(why.split())[:150]}")
    missing = [item for item, held in sorted(shown.items()) if not held]
    print(f"{sum(shown.values())} of {len(shown)} items shown" + (f"; not: {', '.join(missing)}" if missing else ""))
    return len(missing)


if __name__ == "__main__":
    sys.exit(main())
