"""The page on MATLAB: its commands write the files that stand there, its lines of compiling are those of files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from symdyn.cli import main
from symdyn.emit.targets.array_languages import FLAGS

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "matlab.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("command", "files"), re.findall(r"    \$ symdyn (.*)\n((?:    .*\n)+)", PAGE))
def test_a_command_of_the_page_writes_the_files_that_stand_there(
    command: str, files: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = command.replace("two_link.toml", str(ROOT / "examples" / "two_link.toml")).split(" ")
    assert main([*words, "-o", str(tmp_path)]) == 0
    made = [str(Path(line).relative_to(tmp_path)) for line in capsys.readouterr().out.splitlines()]
    assert made == [line.strip() for line in files.splitlines()]
    if "--mex" in words:
        contents = (tmp_path / "+two_link" / "Contents.m").read_text(encoding="utf-8")
        told = [line.strip("% ") for line in contents.splitlines() if "_mex.c" in line]
        assert all(f"\n    {line}\n" in PAGE for line in told)
        assert len(told) == PAGE.count(FLAGS) == 2
