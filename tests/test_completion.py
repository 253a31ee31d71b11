"""Completion of verbs, options, choices and files, in the shells themselves."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from patience import HANG

from symdyn.cli import main

CASES = [  # a line as it is typed, and what completes its last word
    ("symdyn lin", {"linearize"}),
    ("symdyn simulate ar", {"arm.toml"}),
    ("symdyn generate arm.toml --tar", {"--target"}),
    ("symdyn generate arm.toml --target u", {"ufunc"}),
    ("symdyn convert arm.toml out/n", {"out/new.urdf"}),
    ("symdyn new --template slider", {"slider_crank"}),
    ("symdyn completion z", {"zsh"}),
    ("symdyn draw arm.toml --scheme d", {"dark"}),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "arm.toml").write_text("")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "new.urdf").write_text("")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "symdyn").write_text("#!/bin/sh\n")
    (tmp_path / "bin" / "symdyn").chmod(0o755)
    return tmp_path


def script(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


def told(words: list[str], folder: Path) -> str:
    environment = os.environ | {"HOME": str(folder), "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
    ran = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=HANG, check=False)
    assert ran.stderr == ""
    return ran.stdout


def in_bash(line: str, folder: Path) -> set[str]:
    words = line.split(" ")
    ask = (
        f"source symdyn.bash; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; "
        f'COMP_LINE="{line}"; COMP_POINT={len(line)}; _shtab_symdyn symdyn {words[-1]} {words[-2]}; '
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    return {word.strip() for word in told(["bash", "--norc", "-c", ask], folder).splitlines()}


def in_fish(line: str, folder: Path) -> set[str]:
    answer = told(["fish", "--no-config", "-c", f"source symdyn.fish; complete -C '{line}'"], folder)
    return {part.split("\t")[0] for part in answer.splitlines()}


def in_zsh(line: str, folder: Path) -> set[str]:
    """Return the last word of a line after a tab, which completes it where only one word does."""
    (folder / "_symdyn").write_text((folder / "symdyn.zsh").read_text())
    ours, theirs = pty.openpty()
    environment = os.environ | {"HOME": str(folder), "PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "TERM": "dumb"}
    shell = subprocess.Popen(
        ["zsh", "-f", "-i"], cwd=folder, env=environment, stdin=theirs, stdout=theirs, stderr=theirs, close_fds=True
    )

    def until(mark: str) -> str:
        """Return the line behind a mark, once it is there."""
        text, end = "", time.monotonic() + HANG
        while "\n" not in text.partition(mark)[2] and time.monotonic() < end:
            if select.select([ours], [], [], 0.2)[0]:
                text += os.read(ours, 4096).decode(errors="replace")
        assert mark in text, text
        return text.partition(mark)[2].partition("\r")[0]

    try:
        os.write(ours, b"PS1=; fpath=($PWD $fpath); autoload -Uz compinit; compinit -u; print rea''dy\n")
        until("ready")
        os.write(ours, line.encode() + b"\t\x01print -r -- do''ne \n")  # completed, then printed
        return {until("done ").split()[-1]}
    finally:
        shell.kill()
        shell.wait()
        os.close(ours)
        os.close(theirs)


ASKED: dict[str, Callable[[str, Path], set[str]]] = {"bash": in_bash, "zsh": in_zsh, "fish": in_fish}


@pytest.mark.wide(3)
@pytest.mark.long(0)
@pytest.mark.parametrize(
    ("shell", "line", "words"),
    [
        pytest.param(shell, *case, marks=pytest.mark.runs(shell), id=f"{shell}: {case[0]}")
        for shell in ASKED
        for case in CASES
    ],
)
def test_a_shell_completes(
    shell: str, line: str, words: set[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / f"symdyn.{shell}").write_text(script(shell, capsys))
    assert ASKED[shell](line, folder) == words


def test_without_shtab_one_is_told_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 1
    assert capsys.readouterr().err == 'symdyn: completion needs shtab: pip install "symdyn[shell]"\n'


def test_a_shtab_that_is_too_old_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("shtab.SUPPORTED_SHELLS", ["bash"])
    assert main(["completion", "fish"]) == 1
    assert 'knows no fish: pip install "symdyn[shell]" --upgrade' in capsys.readouterr().err
