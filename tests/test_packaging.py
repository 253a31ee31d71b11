"""The wheel is complete: it runs where there is no checkout."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from symdyn.extras import EXTRAS

pytestmark = pytest.mark.runs()

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds the unpacked wheel and nothing else."""
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = folder.glob("symdyn-*.whl")
    zipfile.ZipFile(wheel).extractall(folder / "site")
    return folder / "site"


def test_the_wheel_carries_templates_and_types_and_every_room(installed: Path) -> None:
    expected = {p.relative_to(ROOT) for p in (ROOT / "symdyn").rglob("*.py")}
    templates = (p for p in (ROOT / "templates").rglob("*.*") if p.suffix != ".pyc")
    expected |= {Path("symdyn") / p.relative_to(ROOT) for p in templates}
    expected |= {Path("symdyn") / p.relative_to(ROOT) for p in (ROOT / "examples").glob("*.toml")}
    expected |= {Path("symdyn/py.typed")}

    assert {p for p in expected if not (installed / p).exists()} == set()
    assert not list(installed.rglob("*.pyc"))


@pytest.mark.wide("c")
@pytest.mark.parametrize("target", ["numpy", "c"])
def test_the_wheel_does_the_main_job_without_a_checkout(installed: Path, target: str, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1"}

    def symdyn(*words: str) -> str:
        code = "import sys; sys.path.insert(0, sys.argv.pop(1)); from symdyn.cli import main; sys.exit(main())"
        command = [sys.executable, "-c", code, str(installed), *words]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert symdyn("new", "arm", "--template", "rrp") == "arm.toml\n"
    assert "arm." in symdyn("generate", "arm.toml", "--target", target)
    assert r"\ddot q_1" in symdyn("equations", "arm.toml")
    assert symdyn("new", "--example", "four_bar") == "four_bar.toml\n"


def test_every_extra_is_one_that_pip_knows_and_brings_what_is_imported() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]

    brought = packages_distributions()
    for name, extra in EXTRAS.items():
        packages = {re.split(r"[<>=]", entry)[0] for entry in declared[name]}
        assert all(packages & set(brought.get(module, packages)) for module in extra.modules), name
    assert set(declared) - set(EXTRAS) == {"all", "docs", "bench", "targets", "dev"}


def test_the_table_of_dependencies_is_that_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [
        *project["dependencies"],
        *(entry for extra in project["optional-dependencies"].values() for entry in extra),
    ]
    packages = {re.split(r"[\[<>=]", entry)[0] for entry in needed} - {"symdyn"}
    text = (
        (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Dependencies")[2].partition("## Style")[0]
    )
    listed = {name for row in re.findall(r"^\| ([^|]+) \|", text, re.MULTILINE) for name in re.findall(r"[\w-]+", row)}

    assert {name for name in packages if name not in listed and not name.startswith("tree-sitter-")} == set()
    firsts = re.findall(r"^\| ([\w, -]+?)(?: and its grammars)? ?[(|]", text, re.MULTILINE)
    assert {name for first in firsts for name in first.split(", ")} - packages == {"package"}


def test_no_message_names_an_extra_that_is_not_there() -> None:
    named = {
        (file.name, extra)
        for folder in ("symdyn", "docs", "benchmarks", "templates")
        for file in (ROOT / folder).rglob("*.*")
        if file.suffix in (".py", ".md", ".jinja")
        for words in re.findall(r"symdyn\[([a-z,]+)\]", file.read_text(encoding="utf-8"))
        for extra in words.split(",")
    }

    assert {(file, extra) for file, extra in named if extra not in {*EXTRAS, "bench", "all", "docs", "dev"}} == set()


def test_the_workflow_covers_every_python_and_system_that_the_wheel_names() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    named = re.findall(r"Python :: (3\.\d+)$", "\n".join(project["classifiers"]), re.MULTILINE)

    assert named == ["3.11", "3.12", "3.13", "3.14"]
    assert f"python: [{', '.join(f'{chr(34)}{version}{chr(34)}' for version in named)}]" in workflow
    assert "os: [ubuntu-latest, macos-latest, windows-latest]" in workflow
    assert "bash .ci/run" in workflow
    for command in re.findall(r"python (tests/\S+|-m \w+)", workflow):
        assert command.startswith("-m ") or (ROOT / command).is_file(), command


def test_the_sdist_brings_what_its_tests_read() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    kept = set(project["tool"]["hatch"]["build"]["targets"]["sdist"]["include"])
    text = Path(__file__).read_text(encoding="utf-8")
    read = set(re.findall(r'ROOT / "([.\w]+)"', text))

    assert {".github", "templates", "README.md"} <= read
    assert {name for name in read if f"/{name}" not in kept} == {"pyproject.toml"}  # which is always there


def imported(path: Path) -> set[str]:
    """Return the modules that a file imports as soon as it is read."""
    lines = ast.parse(path.read_text(encoding="utf-8")).body
    names = [name.name for line in lines if isinstance(line, ast.Import) for name in line.names]
    names += [line.module or "" for line in lines if isinstance(line, ast.ImportFrom)]
    return {name.partition(".")[0] for name in names}


def test_tests_are_collected_where_there_is_no_more_than_the_workflow_installs() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    extras, more = re.search(r'pip install -e "\.\[(.*)\]" (.*)', workflow).groups()
    wanted = [*project["dependencies"], *more.split()]
    wanted += [package for extra in extras.split(",") for package in project["optional-dependencies"][extra]]
    there = {re.split(r"[<>=]", package)[0] for package in wanted} | {"symdyn"}
    brought = packages_distributions()

    for path in sorted((ROOT / "tests").glob("test_*.py")):
        assert not {name for name in imported(path) if there.isdisjoint(brought.get(name, there))}, path.name


def test_every_link_of_the_readme_is_absolute_and_leads_to_a_file_that_is_there() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    home = project["urls"]["Source"]
    shown = home.replace("github.com", "raw.githubusercontent.com")
    links = re.findall(r"\]\(([^)]+)\)", (ROOT / "README.md").read_text(encoding="utf-8"))

    assert links
    for link in links:
        kept = re.fullmatch(rf"(?:{re.escape(home)}/(?:blob|tree)|{re.escape(shown)})/main/([^#]+)(?:#.*)?", link)
        assert kept, link
        assert (ROOT / kept[1]).exists(), link


def test_the_version_is_the_same_wherever_it_stands() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    assert f"version: {project['version']}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
