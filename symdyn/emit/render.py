"""What reaches Jinja: templates hold the shape of a file, everything else comes in as finished text."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from symdyn.emit.escape import (
    in_comment,
    in_docstring,
    in_html,
    in_percent_comment,
    in_rustdoc,
    in_script,
    in_script_code,
)
from symdyn.resources import folder

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, values: Mapping[str, Any]) -> str:
    """Return the text of `template` (a path below `templates/`); a value it misses is an error."""
    return _environment().get_template(template).render(values)


@cache
def verbatim(file: str) -> str:
    """Return the text of a file that is no template, such as a script, without its last end of line."""
    return (folder("templates") / file).read_text(encoding="utf-8").removesuffix("\n")


@cache
def script(file: str) -> str:
    """Return the text of a file of JavaScript without indents and without lines that are comments."""
    lines = (line.strip() for line in verbatim(file).splitlines())
    return "\n".join(line for line in lines if line and not line.startswith(("//", "/*", "*")))


@cache
def _environment() -> Environment:
    """Return the one environment, made when the first file is rendered."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    from symdyn.emit.compiled_templates import Beside

    environment = Environment(
        bytecode_cache=Beside(),
        loader=FileSystemLoader(folder("templates")),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters |= {
        "in_comment": in_comment, "in_docstring": in_docstring, "in_html": in_html, "in_rustdoc": in_rustdoc,
        "in_percent_comment": in_percent_comment, "in_script": in_script, "in_script_code": in_script_code,
    }  # fmt: skip
    environment.globals |= {"verbatim": verbatim, "script": script}
    return environment
