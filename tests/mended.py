"""Show that tests of mended faults fail where the faults were found: `python tests/mended.py [ITEM ..] [--at COMMIT]`.

Each test marked `@pytest.mark.mends("3.1")` is run on a checkout of that commit, as it was written when the faults were
mended and files had the names of then, and as it is today on what is here. A test that ends there by an import or a
name that it lacks shows nothing, and is told so.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

FOUND_AT = "9263f8b"
WRITTEN_AT = "082f7c6"
ROOT = Path(__file__).resolve().parent.parent

LACKS = ("ImportError:", "ModuleNotFoundError:", "AttributeError: module 'symdyn", "NameError:", "fixture '")
"""What a test ends with that shows a missing name, not a fault."""

RENAMED = {"simulation": "simulate"}
"""Rooms by the names that those tests know, and what they were called where the faults were found."""

PLUGIN = """
import json, os, pytest
def pytest_addoption(parser):
    parser.addoption("--items", default="")
def pytest_collection_modifyitems(config, items):
    wanted = set(filter(None, config.getoption("--items").split(",")))
    kept = [one for one in items if any(not wanted or m.args[0] in wanted for m in one.iter_markers("mends"))]
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
    parser.add_argument("items", nargs="*")
    parser.add_argument("--at", default=FOUND_AT, help="the commit on which the items were found")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        old = Path(folder) / "old"
        subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(old)], check=True)
        subprocess.run(["git", "-C", str(old), "checkout", "--quiet", given.at], check=True)
        read = ("tests", "examples", "pyproject.toml")  # by tests, beside the code of then
        subprocess.run(["git", "-C", str(old), "checkout", "--quiet", WRITTEN_AT, "--", *read], check=True)
        for name, was in RENAMED.items():
            (old / "symdyn" / name).symlink_to(was)
        then, now = _run(old, Path(folder) / "then", given.items), _run(ROOT, Path(folder) / "now", given.items)
    return _table(then, now)


def _run(root: Path, out: Path, items: list[str]) -> dict[tuple[str, str], tuple[str, str]]:
    """Return outcome and exception of every marked test of a tree, by item and test."""
    plugin = out.parent / "plugin"
    plugin.mkdir(exist_ok=True)
    (plugin / "mended_plugin.py").write_text(PLUGIN, encoding="utf-8")
    path = os.pathsep.join([str(root), str(plugin)])
    out.write_text("", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "mended_plugin", "-p", "no:cacheprovider"]
    command += ["--items", ",".join(items), "-m", "mends", "--continue-on-collection-errors", "tests"]
    subprocess.run(
        command,
        cwd=root,
        env=os.environ | {"PYTHONPATH": path, "MENDED": str(out)},
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
        print(f"{item:12} {verdict if outcome == 'passed' else 'FAILS NOW':32} {test}")
    missing = [item for item, held in sorted(shown.items()) if not held]
    print(f"{sum(shown.values())} of {len(shown)} items shown" + (f"; not: {', '.join(missing)}" if missing else ""))
    return len(missing)


if __name__ == "__main__":
    sys.exit(main())
