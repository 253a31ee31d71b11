"""What the page asks of a scene's text: texts in, what JSON holds out.

One interface, `answer(what, text, how)`, of which whoever carries it knows nothing: a server with a process behind it,
or a worker of the browser. A row of `ANSWERS` is one thing that can be asked. What is wrong with the text comes back
with its places, what does not exist for the scene in words; nothing of a scene is ever run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from symdyn.dynamics import derive
from symdyn.emit import TARGETS, emit
from symdyn.emit.print import EquationsOfMotion
from symdyn.errors import EmitError, SceneError, SymdynError, choice, printable
from symdyn.frozen import dataclass
from symdyn.program import Program, lower, tunable
from symdyn.resources import example_files, folder
from symdyn.scene import example, examples, read_noting, schema, write_text
from symdyn.unlocked import cached_property

LONGEST = 2**20
"""Characters of a text that the page may ask about; what is longer is for the command line."""


@dataclass(frozen=True)
class Settings:
    """How scenes are read and drawn on a page, as the command line said.

    Attributes:
        source: the file that a text is of, or is named like: files beside it, and no others, are read with it.
        allow_invalid_inertia, dimensionless: as `read_noting` takes them.
        at: values of coordinates of the picture.
        view, frames, labels, scheme: as `picture` takes them.
    """

    source: str = str(folder("examples") / "scene.toml")
    allow_invalid_inertia: bool = False
    dimensionless: bool = False
    at: tuple[tuple[str, float], ...] = ()
    view: tuple[float, float] | None = None
    frames: bool = False
    labels: tuple[str, ...] = ("coordinates", "bodies")
    scheme: str = "auto"


class _Text:
    """A text that is read like a file."""

    def __init__(self, text: str, name: str) -> None:
        self._text, self.name = text, name

    def read(self, size: int, /) -> str:
        """Return the text."""
        return self._text[:size]


class Asked:
    """What was asked about a text: its scene, and what is derived of it, once.

    Attributes:
        scene: the scene.
        notes: of its reader.
        settings: of the page.
    """

    def __init__(self, text: str, settings: Settings) -> None:
        reading = read_noting(
            _Text(text or "\n", settings.source),
            allow_invalid_inertia=settings.allow_invalid_inertia,
            dimensionless=settings.dimensionless,
        )
        self.scene, self.notes, self.settings = reading.scene, reading.notes, settings

    @cached_property
    def program(self) -> Program:
        """The functions that code has by default."""
        return lower(derive(self.scene))

    @cached_property
    def equations(self) -> EquationsOfMotion:
        """The equations of motion, whose coefficients are worked out once."""
        return EquationsOfMotion(self.scene)

    def program_for(self, target: str) -> Program:
        """Return the functions that a target is made of."""
        row = TARGETS[target]
        if row.functions is None and not row.tunes:
            return self.program
        names = row.functions(self.scene, "") if row.functions else [one.function.name for one in self.program.routines]
        return tunable(self.scene, names) if row.tunes else lower(derive(self.scene, names))


How = Mapping[str, Any]
"""What else the page says: a language, a target, coordinates that were pulled."""

KINDS: Mapping[str, tuple[type, str]] = {
    "name": (str, "a text"),
    "target": (str, "a text"),
    "language": (str, "a text"),
    "pulled": (dict, "a table"),
    "exercises": (bool, "true or false"),
}
"""What each of it is, where it is said."""


def _scene(asked: Asked, how: How) -> dict[str, Any]:
    """Return what the scene is called, has and is told by its reader."""
    scene = asked.scene
    notes = [note.removeprefix(f"{asked.settings.source}: ") for note in asked.notes]
    counts = {"bodies": len(scene.bodies), "joints": len(scene.joints), "loops": len(scene.loops)}
    return {
        "name": scene.name,
        "text": scene.text or "",
        "freedoms": len(scene.velocities),
        **counts,
        "notes": notes,
    }


def _equations(asked: Asked, how: How) -> dict[str, Any]:
    """Return the equations of motion as HTML, in pieces between which lines may part."""
    from symdyn.notebook import equations_of_motion

    return {"html": _joined(equations_of_motion(asked.equations)[1:])}


def _coefficients(asked: Asked, how: How) -> dict[str, Any]:
    """Return the coefficients that do not vanish, likewise."""
    from symdyn.notebook import closed_form as shown

    return {"html": _joined(shown(asked.equations.closed, lambda _: asked.equations.page)[1:])}


def _joined(parts: list[Any]) -> str:
    return "\n".join(part.html for part in parts)


def _picture(asked: Asked, how: How) -> dict[str, Any]:
    """Return the picture, and sliders that pull coordinates; of what was pulled, what could be."""
    from symdyn.playground.pulling import pulled_picture

    return pulled_picture(asked.scene, asked.settings, how.get("pulled") or {})


def _motion(asked: Asked, how: How) -> dict[str, Any]:
    """Return the page that moves the mechanism."""
    from symdyn.teach import interactive_page

    return {"page": interactive_page(asked.scene, language=_language(how))}


def _lesson(asked: Asked, how: How) -> dict[str, Any]:
    """Return the lesson as a page, with its results to be found where exercises are asked for."""
    from symdyn.teach import Handout, rendered

    lesson = Handout(asked.scene, _language(how), exercises=how.get("exercises", False)).document()
    return {"page": "".join(map(str, rendered(lesson, "html").values()))}


def _code(asked: Asked, how: How) -> dict[str, Any]:
    """Return the files of a target."""
    target = how.get("target", "")
    files = emit(asked.program_for(target), target).texts
    if not files:
        raise EmitError(f"target {target} writes no text; symdyn generate {asked.scene.name}.toml --target {target}")
    return {"files": dict(files)}


def _language(how: How) -> str:
    return "sk" if how.get("language") == "sk" else "en"


ANSWERS: Mapping[str, Callable[[Asked, How], dict[str, Any]]] = {
    "scene": _scene,
    "equations": _equations,
    "coefficients": _coefficients,
    "picture": _picture,
    "motion": _motion,
    "lesson": _lesson,
    "code": _code,
}
"""What can be asked about a text."""


def _example(how: How) -> dict[str, Any]:
    """Return a scene that comes with the package, as its file says it; a robot's file as TOML."""
    name = str(how.get("name"))
    path = example_files().get(name)
    if path is not None and path.suffix == ".toml":
        return {"text": path.read_text(encoding="utf-8")}
    return {"text": write_text(example(name), "toml").text}


OF_NO_TEXT: Mapping[str, Callable[[How], dict[str, Any]]] = {
    "begin": lambda how: {
        "examples": list(examples()),
        "targets": {name: row.title for name, row in TARGETS.items() if str in row.files.values()},
        "words": words(),
    },
    "example": _example,
}
"""What can be asked about no text."""


@lru_cache(maxsize=2)  # the one that is written, and the one before it
def _asked(text: str, settings: Settings) -> Asked:
    return Asked(text, settings)


def answer(what: str, text: str, how: How, settings: Settings = Settings()) -> dict[str, Any]:  # noqa: B008  frozen
    """Return what JSON holds: the answer, or `faults` with their places, or `refused` in words, or `failed`.

    Args:
        what: a key of `ANSWERS` or `OF_NO_TEXT`.
        text: a scene in TOML.
        how: what else it depends on.
        settings: of the page.
    """
    try:
        if len(text) > LONGEST:
            raise SceneError(f"the text has more than {LONGEST} characters; use the command line for it")
        for key, (kind, called) in KINDS.items():
            if not isinstance(how.get(key, kind()), kind):
                raise SymdynError(f"{key} is {called}, not {printable(repr(how[key])[:80])}")
        if what in OF_NO_TEXT:
            return OF_NO_TEXT[what](how)
        if what not in ANSWERS:
            raise SceneError(f"there is no answer to {what!r}; {choice(what, (*ANSWERS, *OF_NO_TEXT))}")
        return ANSWERS[what](_asked(text, settings), how)
    except SceneError as fault:
        return {"faults": faults(fault, settings.source)}
    except SymdynError as fault:
        return {"refused": str(fault).splitlines()}
    except Exception as fault:  # one of ours, after which the page goes on
        told = printable(f"{type(fault).__name__}: {fault}", keep="")
        return {"failed": f"symdyn itself has failed ({told}); please report it with the scene"}


def faults(error: SceneError, source: str) -> list[dict[str, Any]]:
    """Return faults in the order of their places, without their source; those that have no place are about line 1."""
    found = []
    for k, fault in enumerate(error.faults):
        place = error.places[k]._asdict() if error.places else {"line": 1, "column": 1, "length": 1}
        front = f"{source}:{place['line']}: " if error.places else f"{source}: "
        found.append({**place, "text": fault.removeprefix(front)})
    return sorted(found, key=lambda one: (one["line"], one["column"]))


# What can be written where: for an editor that completes


def words() -> dict[str, dict[str, list[Any]]]:
    """Return what keys a table takes, by its name, "" for the top: each with what it is and what it may say."""
    found: dict[str, dict[str, list[Any]]] = {}
    _gather("", schema(), found)
    return found


DEEPEST = 3
"""Names of tables in tables, joints.limits.effort, that are looked into."""


def _gather(place: str, shape: Mapping[str, Any], found: dict[str, dict[str, list[Any]]]) -> None:
    for one in (shape, *shape.get("anyOf", ()), *shape.get("oneOf", ()), *shape.get("allOf", ())):
        for key, inner in one.get("properties", {}).items():
            table = found.setdefault(place, {})
            table.setdefault(key, [inner.get("description", ""), _choices(inner)])
            below = f"{place}.{key}".lstrip(".")
            if below.count(".") < DEEPEST:
                _gather(below, inner, found)
        for inner in (one.get("additionalProperties"), one.get("items")):
            if isinstance(inner, Mapping) and place.count(".") < DEEPEST:
                _gather(place, inner, found)


def _choices(shape: Mapping[str, Any]) -> list[str]:
    """Return the words that a key may say, where it takes words."""
    each = (shape, *shape.get("anyOf", ()))
    return [word for one in each for word in (*one.get("enum", ()), one.get("const")) if isinstance(word, str)]
