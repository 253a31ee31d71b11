"""The outside door to Jinja: templates hold the shape of a file, everything else comes in as finished text."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from symdyn.resources import template_folder

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, values: Mapping[str, Any]) -> str:
    """Return the text of `template` (a path below `templates/`); a value it misses is an error."""
    return _environment().get_template(template).render(values)


@cache
def _environment() -> Environment:
    """Return the one environment, made when the first file is rendered."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(template_folder()),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters["in_comment"] = in_comment
    environment.filters["in_docstring"] = in_docstring
    return environment


def in_comment(text: str, prefix: str = " * ") -> str:
    """Return `text` as lines of a C comment; nothing in it can end the comment or start another one."""
    harmless = text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")
    return "\n".join(f"{prefix}{_printable(line)}".rstrip() for line in harmless.split("\n"))


def in_docstring(text: str, indent: int = 0) -> str:
    """Return `text` as lines of a docstring in triple quotes; nothing in it can end the docstring."""
    harmless = text.replace("\\", "\\\\").replace('"""', "'''")
    lines = [_printable(line).rstrip() for line in harmless.split("\n")]
    if lines[-1].endswith('"'):
        lines[-1] = f"{lines[-1]} "
    return "\n".join([lines[0], *(f"{' ' * indent}{line}".rstrip() for line in lines[1:-1]), *lines[1:][-1:]])


def _printable(line: str) -> str:
    """Return `line` without control and direction characters, which compilers warn about."""
    return "".join(character if character.isprintable() else " " for character in line)
