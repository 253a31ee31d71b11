"""What pyright, strict, says of the code that stands in README and on the pages of docs: `python tests/typed_pages.py`.

All code of a page is one file, but for what it shows to be refused. What libraries without types return is unknown, and
a page may use a name that its text explains; all else is an error, of the page or of our annotations. Pages "Coming
from" are left out: half of their code is of libraries whose annotations are wrong, or hidden in compiled modules.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from doctest import DocTestParser
from pathlib import Path

import pages

UNTYPED = (
    "UnknownMemberType",
    "UnknownVariableType",
    "UnknownArgumentType",
    "UnknownParameterType",
    "UnknownLambdaType",
)
LOOSE = ("MissingParameterType", "MissingTypeStubs", "MissingImports", "UndefinedVariable", "DuplicateImport")
SHOWN = ("UnusedExpression", "ConstantRedefinition")
"""What is not looked at: what has no types, what a page leaves to its reader, what a session does."""


def code(text: str) -> str:
    """Return the code of a page: examples, and blocks that are none."""
    blocks = [block for block in re.findall(r"(?m)^```python\n((?:.*\n)*?)```", text) if ">>> " not in block]
    return "\n".join([*blocks, *(one.source for one in DocTestParser().get_examples(text) if not one.exc_msg)])


def main() -> int:
    """Return 1 where pyright finds an error, which it prints."""
    strict = "# pyright: strict, " + ", ".join(f"report{rule}=false" for rule in (*UNTYPED, *LOOSE, *SHOWN))
    with tempfile.TemporaryDirectory() as folder:
        for page in (pages.ROOT / "README.md", *sorted(pages.DOCS.glob("*.md"))):
            if not page.stem.startswith("from-") and (found := code(page.read_text(encoding="utf-8"))):
                Path(folder, f"{page.stem}.py").write_text(f"{strict}\n{found}", encoding="utf-8")
        words = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, folder]
        return subprocess.run(words, cwd=pages.ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
