"""What `symdyn/cli/options.json` holds, made of `verbs.toml` and of the functions behind the verbs.

The help of an option is the first sentence on its parameter in the docstring of its function. "; None for 200 of them"
at the end of that becomes "(default: 200 of them)", and what the signature has as default is told likewise.
"""

from __future__ import annotations

import inspect
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any

import symdyn.cli
from symdyn.cli.identify import FORM
from symdyn.dynamics import OUTPUTS
from symdyn.emit import TARGETS
from symdyn.emit.targets.emit_program import SIZED
from symdyn.identification import Identification
from symdyn.scene import Starter, examples
from symdyn.study import DESIGNS, FORMS, PLOTS

CLI = Path(symdyn.cli.__file__).parent
TABLE = CLI / "options.json"

Words = dict[str, Any]
"""Arguments of `add_argument`."""

KINDS: dict[str, Words] = {
    "bool": {"action": "store_true"},
    "float": {"type": "float"},
    "int": {"type": "int", "metavar": "N"},
}
"""What is known of an option by the annotation of its parameter."""

TEXTS: Mapping[str, Callable[[], str]] = {
    "designs": lambda: "; ".join(f"{name}: {design.description}" for name, design in DESIGNS.items()),
    "examples": lambda: ", ".join(examples()),
    "forms": lambda: FORMS,
    "gains": lambda: ", ".join(Identification.gain_units),
    "payload": lambda: FORM,
    "plots": lambda: "; ".join(f"{name}: {plot.description}" for name, plot in PLOTS.items()),
    "targets": lambda: "; ".join(f"{name}: {target.text}" for name, target in TARGETS.items()),
    "templates": lambda: ", ".join(Starter.TEMPLATES),
}
"""What stands in words of `verbs.toml` for a table of the product."""


def made() -> dict[str, Words]:
    """Return groups of options by name; a verb is the group of its name."""
    rows = tomllib.loads((CLI / "verbs.toml").read_text(encoding="utf-8"))
    found = {name: _group(row) for name, row in rows.pop("shared").items()}
    for verb, row in rows.items():
        inside = {f"{verb}: {title}": options for title, options in row.get("groups", {}).items()}
        module = import_module(f"symdyn.cli.{verb.replace('-', '_')}")
        found[verb] = {"description": module.__doc__, "options": [*_options(row["options"]), *inside, "talk"]}
        for name, options in inside.items():
            found[name] = {"title": name.removeprefix(f"{verb}: "), "options": [*_options(options)]}
    return found


def text(groups: Mapping[str, Words]) -> str:
    """Return the file, an option a line."""
    lines = []
    for name, group in groups.items():
        head = [f"{_json(key)}: {_json(value)}" for key, value in group.items() if key != "options"]
        options = ",\n  ".join(map(_json, group["options"]))
        lines.append(f"{_json(name)}: {{{', '.join([*head, _json('options')])}: [\n  {options}\n ]}}")
    return "{\n " + ",\n ".join(lines) + "\n}\n"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _group(row: Words) -> Words:
    return {**row, "options": [*_options(row["options"])]}


def _options(rows: Mapping[str, Any]) -> Iterator[Any]:
    """Yield flags and arguments of options, and names of groups."""
    options = {name: row for name, row in rows.items() if isinstance(row, dict)}
    flags = {row.get("of", name.replace("-", "_")): f"--{name}" for name, row in options.items()}
    for name, row in rows.items():
        if row == "shared":
            yield name
        elif isinstance(row, dict) and "each" in row:
            yield from _target_options()
        elif name != "of":
            yield _option(name, dict(row), rows.get("of"), flags)


def _target_options() -> Iterator[Any]:
    """Yield a flag for everything that can be asked of a target beside its files."""
    for name in dict.fromkeys(name for target in TARGETS.values() for name in target.options):
        does = "; ".join(f"{one.title}: {one.options[name]}" for one in TARGETS.values() if name in one.options)
        words = {"dest": "option", "action": "store_const", "const": name, "default": "", "help": _shown(does)}
        words = {"metavar": "SIZE", "nargs": "?", "const": "0", "help": _shown(does)} if name in SIZED else words
        yield [[f"--{name}"], words]


def _option(name: str, row: Words, of: str | None, flags: Mapping[str, str]) -> list[Any]:
    """Return flags and arguments of an option: those of its row, and what its parameter says beside them."""
    said, own, more, usual = (row.pop(key, None) for key in ("of", "help", "more", "usual"))
    short, positional = row.pop("short", None), row.pop("positional", False)
    function, parameter = (said, None) if said and "." in said else (of, said)
    known = _parameters(function).get(parameter or name.replace("-", "_"))
    words = dict(KINDS.get(known.annotation.removesuffix(" | None"), {})) if known is not None else {}
    if "choices" in row:
        words.pop("metavar", None)
        row["choices"] = _choices(row["choices"])
    if own is None or usual:
        assert known is not None, f"--{name}: {function} has no such parameter"
        words |= {"default": known.default} if usual else {}
        own = own or _sentence(str(function), known, flags, more or "", "required" in row)
    words |= {**row, "help": _shown(own)}
    return [[name] if positional else [*([short] if short else []), f"--{name}"], words]


def _function(path: str) -> Any:
    module, _, name = path.rpartition(".")
    return getattr(import_module(f"symdyn.{module}"), name)


def _parameters(path: str | None) -> Mapping[str, inspect.Parameter]:
    return inspect.signature(_function(path)).parameters if path else {}


def _choices(said: Any) -> list[Any]:
    """Return choices: those that are written, or those of a table or function of the product."""
    if not isinstance(said, str):
        return list(said)
    if "+" in said:
        return [one for part in said.split("+") for one in _choices(part)]
    if said == "formulations":
        return _formulations()
    module, _, names = said.partition(":")
    found: Any = import_module(f"symdyn.{module}")
    for name in names.split("."):
        found = found[name] if isinstance(found, Mapping) else getattr(found, name)
    return list(found() if callable(found) else found)


def _formulations() -> list[str]:
    """Return the derivations that a first look at a scene can be had by, those that grow fast last."""
    looked_at = [row.formulations.items() for row in OUTPUTS.values() if row.default_in == "overview"]
    all_of_them = [pair for some in looked_at for pair in some]
    growing = {name for name, formulation in all_of_them if formulation.up_to < inf}
    return sorted(dict.fromkeys(name for name, _ in all_of_them), key=growing.__contains__)


def _sentence(function: str, known: inspect.Parameter, flags: Mapping[str, str], more: str, required: bool) -> str:
    """Return what the docstring of a function says of a parameter, in words of the command line."""
    entry = re.search(rf"(?m)^    {known.name}: (.*\n?(?:     .*\n?)*)", inspect.getdoc(_function(function)) or "")
    assert entry, f"{function}: its docstring has no line of {known.name}"
    first = re.split(r"(?<!e\.g)\. (?=[A-Z`\"])|\.$", " ".join(entry[1].split()), maxsplit=1)[0]
    first = re.sub(r"`(\w+)`", lambda name: flags.get(name[1], f"--{name[1]}"), first)
    first = re.sub(r'"([\w-]+)"', r"\1", first)
    first, _, usual = re.sub(r'; (?:None|nothing|"") (?:for|takes) ', "\0", first).partition("\0")
    usual = usual or _usual(known)
    told = f" (default: {usual})" if usual and not required else ""
    return f"{first}{'; ' * bool(more)}{more}{told}"


def _usual(known: inspect.Parameter) -> str:
    """Return the default of a number or a word; "" of what has none, and of a real number zero, which does nothing."""
    if isinstance(known.default, tuple):
        return ",".join(known.default)
    if isinstance(known.default, str | int) and not isinstance(known.default, bool):
        return str(known.default)
    return f"{known.default:g}" if isinstance(known.default, float) and known.default else ""


def _shown(words: str) -> str:
    """Return words as `argparse` takes them, with what tables of the product say."""
    return re.sub(rf"\{{({'|'.join(TEXTS)})\}}", lambda name: TEXTS[name[1]](), words).replace("%", "%%")
