r"""`symdyn check-derivation FILE SCENE`: a student's own result, compared with the scene's.

FILE holds one formula or several, LaTeX or plain text: `k_{z,12} = ...`, `M_1 = ...`, `... = F - b \dot x`, `L = ...`.
Exit status 0: all right; 1: something differs; 2: something cannot be read.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from symdyn.bounds import BOUNDS
from symdyn.cli.scene_options import STDIN, read_scene
from symdyn.cli.talk import Waiting, fail, give, print_text
from symdyn.errors import SymdynError, TeachError, beside, printable
from symdyn.teach import check_derivation

LARGEST = BOUNDS["bytes of a student's file"]


def run(options: argparse.Namespace) -> int:
    """Print an answer to every statement."""
    try:
        if options.file == options.scene == STDIN:
            raise TeachError("FILE and SCENE are both -, and standard input is read once; give one of them as a file")
        scene = read_scene(options)
        text, name = _text(options.file)
        with Waiting("comparing"):
            answers = check_derivation(text, scene, name, options.what or None, options.book)
    except SymdynError as fault:
        fail(fault)
        return 2
    words = [[printable(line) for line in answer.in_words(options.language)] for answer in answers]
    if options.json:
        give([answer.as_dict() | {"words": lines} for answer, lines in zip(answers, words, strict=True)])
    else:
        read = [[printable(line) for line in answer.as_read(options.language)] for answer in answers]
        print_text("\n".join(line for pair in zip(words, read, strict=True) for lines in pair for line in lines))
    return 0 if all(answer.right for answer in answers) else 1


def _text(file: str) -> tuple[str, str]:
    """Return the student's text and its name for messages."""
    name = "standard input" if file == STDIN else Path(file).name
    try:
        if file == STDIN:
            data = sys.stdin.buffer.read(LARGEST + 1)
        else:
            with Path(file).open("rb") as opened:
                data = opened.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise TeachError(f"{name}: more than {LARGEST} bytes; give the formulas alone")
        return data.decode("utf-8-sig"), name
    except UnicodeDecodeError as fault:
        raise TeachError(f"{name}: is no text in UTF-8; save it as UTF-8") from fault
    except OSError as fault:
        raise TeachError(f"{name}: {fault.strerror}; {beside(Path(file))}") from fault
