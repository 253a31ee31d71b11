"""Compiled templates are kept beside their files as compiled modules are, and made again where they are not whole."""

from __future__ import annotations

import sys
from inspect import signature
from pathlib import Path

import pytest

from symdyn.emit.compiled_templates import OPTIONS, Beside, jinja2
from symdyn.emit.render import _environment
from symdyn.resources import folder


@pytest.fixture(autouse=True)
def kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)


def rendered(folder: Path, trim_blocks: bool = False, **values: str) -> str:
    """Return what a template says in an environment that has seen nothing."""
    loader = jinja2.FileSystemLoader(folder)
    environment = jinja2.Environment(loader=loader, bytecode_cache=Beside(), trim_blocks=trim_blocks)
    return environment.get_template("a.txt.jinja").render(values)


def write(folder: Path, text: str = "Hello, {{ who }}!") -> None:
    (folder / "a.txt.jinja").write_text(text, encoding="utf-8")


def kept_of(folder: Path) -> list[Path]:
    return list((folder / "__pycache__").glob("a.txt.*.pyc"))


def test_a_template_is_compiled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path)
    assert rendered(tmp_path, who="arm") == "Hello, arm!"
    assert len(kept_of(tmp_path)) == 1

    monkeypatch.setattr(jinja2.Environment, "compile", lambda *_: pytest.fail("it is compiled again"))
    assert rendered(tmp_path, who="cart") == "Hello, cart!"


def test_another_text_is_compiled_again(tmp_path: Path) -> None:
    write(tmp_path)
    rendered(tmp_path, who="arm")
    write(tmp_path, "Good bye, {{ who }}.")
    assert rendered(tmp_path, who="arm") == "Good bye, arm."


def test_another_environment_compiles_again(tmp_path: Path) -> None:
    write(tmp_path, "{% if who %}\nHello{% endif %}")
    assert rendered(tmp_path, who="arm") == "\nHello"
    assert rendered(tmp_path, trim_blocks=True, who="arm") == "Hello"


def test_every_option_of_an_environment_is_thought_of() -> None:
    at_work = {"undefined", "loader", "cache_size", "auto_reload", "bytecode_cache", "enable_async"}
    assert {*OPTIONS} | at_work == {*signature(jinja2.Environment).parameters}


def test_no_template_is_compiled_to_what_a_filter_of_ours_has_said() -> None:
    """What a filter makes of a constant would be kept, whatever the filter says tomorrow."""
    environment = _environment()
    own = set(environment.filters) - set(jinja2.Environment().filters)
    seen = set()
    for path in folder("templates").rglob("*.jinja"):
        for node in environment.parse(path.read_text(encoding="utf-8")).find_all(jinja2.nodes.Filter):
            if node.name in own:
                seen.add(node.name)
                with pytest.raises(jinja2.nodes.Impossible):
                    node.as_const()
    assert seen == own


@pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b[:40], lambda b: b[:-9], lambda _: b"\xff" * 300])
def test_what_is_damaged_is_compiled_again(tmp_path: Path, damage) -> None:
    write(tmp_path)
    rendered(tmp_path, who="arm")
    (path,) = kept_of(tmp_path)
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert rendered(tmp_path, who="arm") == "Hello, arm!"
    assert path.read_bytes() == whole


def test_nothing_is_kept_where_python_keeps_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    write(tmp_path)
    assert rendered(tmp_path, who="arm") == "Hello, arm!"
    assert not (tmp_path / "__pycache__").exists()


def test_a_folder_that_cannot_be_made_hinders_nothing(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "__pycache__").write_text("a file")
    assert rendered(tmp_path, who="arm") == "Hello, arm!"
