"""The pages to begin with: their commands print what stands there, and their examples run."""

from __future__ import annotations

import ast
import doctest
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path

import pages
import pytest

from symdyn.cli import main
from symdyn.scene import read

FILTERS: dict[str, Callable[[list[str], str], list[str]]] = {
    "grep": lambda lines, word: [line for line in lines if word in line],
    "head": lambda lines, count: lines[: -int(count)],
    "tail": lambda lines, count: lines[int(count) :],
}
"""What the pages' commands are piped into."""


def printed(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return what a command prints where it is run, its pipes included; a redirection prints nothing."""
    command, _, file = command.partition(" > ")
    verb, *pipes = command.split(" | ")
    assert main(shlex.split(verb)[1:]) in (None, 0), command
    lines = capsys.readouterr().out.splitlines()
    for program, argument in map(shlex.split, pipes):
        lines = FILTERS[program](lines, argument)
    if file:
        Path(file).write_text("\n".join(lines), encoding="utf-8")
        return ""
    return "\n".join(line.rstrip() for line in lines)


@pytest.mark.heavy("howto")
@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", ["start", "howto", "shell"])
def test_commands_and_examples_of_a_page_do_what_stands_there(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = pages.DOCS / f"{name}.md"
    for toml in re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL):
        (tmp_path / "pendulum.toml").write_text(toml, encoding="utf-8")
        assert read("pendulum.toml").coordinates == ("phi",)
    commands = pages.commands(page)
    assert len(commands) >= 3
    for command, shown in commands:
        found = printed(command, capsys)
        assert found == shown if shown else True, command
    assert doctest.testfile(str(page), module_relative=False).failed == 0


def test_the_examples_of_every_page_are_run() -> None:
    """Those that `make doctest` leaves out are run by tests of their own."""
    makefile = (pages.ROOT / "Makefile").read_text(encoding="utf-8")
    tests = "".join(path.read_text(encoding="utf-8") for path in (pages.ROOT / "tests").glob("test_docs_*.py"))
    asked = [page for page in pages.DOCS.glob("*.md") if re.search(r"(?m)^ *>>> ", page.read_text(encoding="utf-8"))]

    assert len(asked) > 10
    for page in asked:
        assert f"docs/{page.name}" in makefile or f'"{page.stem}' in tests, page.name


def test_examples_of_pages_stand_in_blocks_of_code() -> None:
    for page in pages.DOCS.glob("*.md"):
        outside = re.sub(r"(?ms)^```.*?^```$", "", page.read_text(encoding="utf-8"))
        assert re.findall(r"(?m)^>>> .*", outside) == [], page.name


def test_one_line_installs_it_wherever_that_is_told() -> None:
    """That of docs/site/conf.py is the first code of each page to begin with; links lead to source and issues."""
    tree = ast.parse((pages.DOCS / "site" / "conf.py").read_text(encoding="utf-8"))
    lines = {ast.unparse(one.targets[0]): one.value for one in tree.body if isinstance(one, ast.Assign)}
    line = ast.literal_eval(lines["INSTALL"])
    urls = tomllib.loads((pages.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]
    for page in (pages.ROOT / "README.md", pages.DOCS / "index.md", pages.DOCS / "start.md"):
        assert next(iter(re.findall(r"(?m)^    (\S.*)$", page.read_text(encoding="utf-8")))) == line, page
    front = (pages.DOCS / "index.md").read_text(encoding="utf-8")
    assert f"]({urls['Source']})" in front
    assert f"]({urls['Issues']})" in front
