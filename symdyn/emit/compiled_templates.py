"""Compiled templates, kept where Python keeps its compiled modules: in `__pycache__` beside their files.

Compiling the templates of four targets takes longer than filling them. What holds for modules holds here: who may write
there may write the modules as well, nothing is written where the user may not or does not want it
(PYTHONDONTWRITEBYTECODE, PYTHONPYCACHEPREFIX), and what is kept serves one version of Python and of Jinja, one text and
one way to read it.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from hashlib import sha256
from importlib.util import cache_from_source
from pathlib import Path

import jinja2
from jinja2 import BytecodeCache, Environment
from jinja2.bccache import Bucket

from symdyn.emit.writing import write
from symdyn.errors import EmitError

OPTIONS = (
    *("block_start_string", "block_end_string", "variable_start_string", "variable_end_string"),
    *("comment_start_string", "comment_end_string", "line_statement_prefix", "line_comment_prefix"),
    *("trim_blocks", "lstrip_blocks", "newline_sequence", "keep_trailing_newline"),
    *("optimized", "autoescape", "finalize", "extensions"),
)
"""What of an environment decides what a template is compiled to."""


class Beside(BytecodeCache):
    """Compiled templates by the paths of their files."""

    def get_cache_key(self, name: str, filename: str | None = None) -> str:
        """Return the path of what is kept of a template."""
        assert filename is not None, "templates are files"
        return cache_from_source(filename)

    def get_bucket(self, environment: Environment, name: str, filename: str | None, source: str) -> Bucket:
        """Return what is kept of a template, empty where that is of another text or another environment."""
        bucket = Bucket(environment, self.get_cache_key(name, filename), checksum(environment, source))
        self.load_bytecode(bucket)
        return bucket

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill a bucket, if there is something whole to fill it with."""
        with suppress(OSError):
            content = Path(bucket.key).read_bytes()
            try:
                bucket.bytecode_from_string(content)
            except Exception:  # whatever damaged bytes raise: the template is compiled again
                bucket.reset()

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep what is in a bucket, where files may be made."""
        if not sys.dont_write_bytecode:
            path = Path(bucket.key)
            with suppress(EmitError):
                write({path.name: bucket.bytecode_to_string()}, path.parent)


def checksum(environment: Environment, source: str) -> str:
    """Return a hash of a template and of what compiles it."""
    options = {name: getattr(environment, name) for name in OPTIONS} | {"extensions": sorted(environment.extensions)}
    return sha256(f"{jinja2.__version__}\n{sys.version}\n{options}\n{source}".encode()).hexdigest()
