"""The LaTeX of a document, run through pdflatex."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from symdyn.errors import EmitError
from symdyn.teach.document import Document
from symdyn.teach.render.latex import latex

SECONDS = 120
TAIL = 15


def pdf(document: Document) -> dict[str, bytes]:
    """Return the one file by name; the same document, the same bytes.

    Raises:
        EmitError: pdflatex is absent or stops.
    """
    program = shutil.which("pdflatex")
    if program is None:
        raise EmitError("pdflatex is not installed, so there is no PDF; --format latex writes the source")
    ((name, source),) = latex(document).items()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "lesson.tex").write_text(source, encoding="utf-8")
        command = [program, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "lesson.tex"]
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "0", "FORCE_SOURCE_DATE": "1", "openin_any": "p"}
        try:
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, timeout=SECONDS, check=False, text=True,
                errors="replace",
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise EmitError(f"pdflatex takes more than {SECONDS} s; --format latex writes the source") from None
        if done.returncode:
            said = "\n".join(done.stdout.splitlines()[-TAIL:])
            raise EmitError(f"pdflatex stops; --format latex writes the source. Its last words:\n{said}")
        return {f"{Path(name).stem}.pdf": Path(folder, "lesson.pdf").read_bytes()}
