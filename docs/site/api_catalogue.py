"""What the API reference lists, by what one wants; read from the fronts of the packages, so that nothing is forgotten.

`symdyn` offers most names itself; each stands in the group of its package. A group adds what else of its packages is
for users, and what those functions and the methods of their results return.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import symdyn

SCENE_WORDS = (
    "scene", "parameter", "body", "point", "dh_table", "joint", "revolute", "prismatic", "helical", "cylindrical",
    "universal", "spherical", "planar", "point_on_line", "point_on_plane", "rod", "free", "fixed", "custom", "loop",
    "spring", "damper", "load", "rolling", "knife_edge", "constraint", "input_signal", "output",
    "read_text", "write_text", "bind", "lock", "limits",
    "with_symbols", "with_symbolic_inertia", "scene_of",
)  # fmt: skip

IDENTIFICATION = (
    "Regression", "Payload", "Gain", "identified", "Identified", "with_parameters", "report.report", "output_error",
    "OutputFit", "excite", "Excitation", "Calibration",
)  # fmt: skip


CONSTRUCTED = ("Problem", "Feedback", "Payload", "Gain")
"""Classes that users call; the others are what functions return."""


@dataclass(frozen=True)
class Group:
    """Functions and classes that are looked for together.

    Attributes:
        title: its heading in docs/api.md.
        packages: of `symdyn`, whose names stand here where `symdyn` offers them itself.
        more: what else is for users, below `symdyn`.
        follows: whether classes that methods of its classes return stand here too, where a front of its offers them.
    """

    title: str
    packages: tuple[str, ...] = ()
    more: tuple[str, ...] = ()
    follows: bool = False

    def names(self) -> list[str]:
        """Return the names of the group, functions first, each as a user imports it."""
        found = [f"symdyn.{name}" for name in symdyn.__all__ if package_of(getattr(symdyn, name)) in self.packages]
        found += [f"symdyn.{name}" for name in self.more]
        known = [object_of(name) for name in found]
        todo = [one for one in known if callable(one)]
        while todo:
            for one in self._returned_by(todo.pop(0)):
                if one not in known and one.__module__.startswith("symdyn.") and is_offered(one):
                    known.append(one)
                    todo.append(one)
                    found.append(public_name(one))
        return sorted(dict.fromkeys(found), key=lambda name: inspect.isclass(object_of(name)))

    def _returned_by(self, one: object) -> Iterator[type]:
        """Yield the classes that a function returns; of a class, those of its public methods that a front offers."""
        if not inspect.isclass(one):
            fronts = [import_module(f"symdyn.{package}") for package in self.packages]  # what types alone import
            names = {name: getattr(front, name) for front in fronts[:1] for name in front.__all__}
            yield from classes(get_type_hints(one, localns=names)["return"])
        elif self.follows:
            for package in self.packages:
                yield from offered_by(package, " ".join(annotations(one)))


GROUPS = (
    Group("Scenes", ("scene",)),
    Group("Equations", ("dynamics", "emit")),
    Group("Compiled functions", ("runtime", "program"), ("dynamics.singular_values", "dynamics.manipulability")),
    Group("Simulation", ("simulation",), ("simulation.linear_law",)),
    Group("Linear systems and control", ("linear",), ("linear.root_locus", "linear.systems"), follows=True),
    Group("Optimal control", ("transcription",), follows=True),
    Group("Identification", ("identification",), tuple(f"identification.{one}" for one in IDENTIFICATION)),
    Group("Many runs", ("study",), ("study.open", "study.Indices")),
    Group("Pictures", ("draw",)),
    Group("Proofs", ("verify",)),
    Group("Declaring a scene", (), tuple(f"scene.{one}" for one in SCENE_WORDS)),
    Group("Tables", (), ("table.Table",)),
)


@cache
def catalogue() -> dict[str, list[str]]:
    """Return the names of every group by its title; each name stands in the first group that has it."""
    found: dict[str, list[str]] = {}
    seen: set[object] = set()
    for group in GROUPS:
        found[group.title] = [name for name in group.names() if object_of(name) not in seen]
        seen.update(map(object_of, found[group.title]))
    return found


def object_of(name: str) -> object:
    """Return what a dotted name means: `symdyn.identification.report.report` is a function of a module."""
    module, _, last = name.rpartition(".")
    return getattr(import_module(module), last)


def package_of(one: object) -> str:
    """Return the package below `symdyn` that something is from, "" for none."""
    return getattr(one, "__module__", "").partition(".")[2].partition(".")[0]


def is_offered(one: type) -> bool:
    """Return whether a class is for users by name: a front offers it, and it is no text."""
    return not issubclass(one, str) and hasattr(import_module(public_name(one).rpartition(".")[0]), "__path__")


def public_name(one: type) -> str:
    """Return the shortest name that imports a class: of `symdyn`, of a front, else of its module."""
    parts = one.__module__.split(".")
    modules = (".".join(parts[:count]) for count in range(1, len(parts) + 1))
    return next(f"{module}.{one.__name__}" for module in modules if hasattr(import_module(module), one.__name__))


def classes(annotation: object) -> set[type]:
    """Return the classes that an annotation is made of."""
    inside = get_args(annotation)
    return set().union(*map(classes, inside)) if inside else {annotation} if isinstance(annotation, type) else set()


def members(one: type) -> dict[str, object]:
    """Return the public methods and properties that a class says something of, in the order of the source."""
    names = [name for base in reversed(one.__mro__) if base.__module__.startswith("symdyn.") for name in vars(base)]
    found = {name: inspect.getattr_static(one, name) for name in names if not name.startswith("_")}
    return {name: member for name, member in found.items() if getattr(method_of(member), "__doc__", None)}


def method_of(member: object) -> object:
    """Return the function behind a method or a property, None where there is none."""
    inside = (getattr(member, name, None) for name in ("fget", "func", "__func__"))
    found = next(filter(None, inside), member)
    return found if inspect.isfunction(found) else None


def annotations(one: type) -> Iterator[str]:
    """Yield what the methods of a class are said to return, as it is written."""
    for member in members(one).values():
        yield str(getattr(method_of(member), "__annotations__", {}).get("return", ""))


def offered_by(package: str, text: str) -> Iterator[type]:
    """Yield the classes that a text names and the front of a package offers."""
    front = import_module(f"symdyn.{package}")
    for name in dict.fromkeys(re.findall(r"\b[A-Z]\w*", text)):
        if name in dir(front) and inspect.isclass(one := getattr(front, name)):
            yield one


@cache
def examples() -> dict[str, str]:
    """Return the examples of api_examples.txt by name; several names may share one."""
    sections = (Path(__file__).parent / "api_examples.txt").read_text(encoding="utf-8").split("\n## ")[1:]
    return {
        name: text.partition("```python\n")[2].partition("\n```")[0].rstrip()
        for head, _, text in (one.partition("\n") for one in sections)
        for name in head.split(", ")
    }


def first_line(one: object) -> str:
    """Return the first sentence of a docstring in one line."""
    paragraph = (inspect.getdoc(one) or "").partition("\n\n")[0]
    return " ".join(paragraph.split())
