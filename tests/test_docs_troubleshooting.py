"""docs/troubleshooting.md names messages that really come: each is made to come by what stands below it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pages
import pytest

from symdyn.cli import main
from symdyn.errors import SymdynError
from symdyn.scene import Starter

PAGE = pages.DOCS / "troubleshooting.md"

ENTRIES = re.findall(
    r"^### `([^\n]*)`\n(.*?)(?=^##|\Z)", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
)


def blocks(text: str, language: str) -> list[str]:
    """Return the fenced blocks of one language."""
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def pattern(message: str) -> str:
    """Return what a message matches: … stands for anything in its line."""
    return ".*".join(re.escape(part.strip()) for part in message.split("…"))


def test_the_page_has_messages() -> None:
    assert len(ENTRIES) > 15
    assert len(ENTRIES) == PAGE.read_text(encoding="utf-8").count("\n### ")


@pytest.mark.long(0)
@pytest.mark.runs("cc")
@pytest.mark.parametrize(("message", "below"), ENTRIES, ids=lambda text: text[:50] if "\n" not in text else "")
def test_a_message_that_is_told_comes(
    message: str, below: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for python in blocks(below, "python"):
        with pytest.raises((SymdynError, TypeError, ValueError), match=pattern(message)):
            exec(compile(python, "page", "exec"), {})
        return
    Path("robot.sdf").write_text('<sdf><model name="a"><link name="b"/><model name="c"/></model></sdf>')
    for scene in blocks(below, "toml"):
        Path("scene.toml").write_text(scene, encoding="utf-8")
    commands = re.findall(r"^    \$ symdyn (.*)$", below, flags=re.MULTILINE) or ["info scene.toml"]
    for command in commands:
        for name in re.findall(r"(\w+)\.toml", command):
            if name not in ("scene", "nowhere"):
                Path(f"{name}.toml").write_text(Starter(name).from_example(name)[1], encoding="utf-8")
        status = main(shlex.split(command))
        told = capsys.readouterr().err
        assert re.search(pattern(message), told), told
        assert status or "limit" in message
