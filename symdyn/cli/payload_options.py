"""`--payload FILE:BODY:mass=KG`: bodies of known mass that some logs were measured with."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.errors import IdentifyError
from symdyn.identification import Payload
from symdyn.scene import parse
from symdyn.scene.values import FormulaError, Unit, UnitError, choice, fits, split_commas

FORM = "FILE:BODY:mass=KG[,com=[X,Y,Z][,inertia=[XX,YY,ZZ]]]"

KEYS = {"mass": "kg", "com": "m", "inertia": "kg m^2"}
"""What is said of one, and its unit where none is said."""


def payloads(texts: Sequence[str]) -> tuple[Payload, ...]:
    """Return what `--payload` says, once for each payload.

    >>> payloads(["loaded.csv:tool:mass=3.2,com=[0,0,0.1]"])
    (Payload(body='tool', mass=3.2, com=(0.0, 0.0, 0.1), inertia=None, log='loaded.csv'),)
    >>> payloads(["loaded.csv:tool:mass=3200 g,com=[0,0,100 mm]"])[0].com
    (0.0, 0.0, 0.1)

    Raises:
        IdentifyError: with every fault, one line each.
    """
    faults, found = list[str](), list[Payload]()
    for text in texts:
        log, *rest = text.rsplit(":", 2)
        if len(rest) < 2 or not log or not rest[0]:
            faults.append(f"--payload: {text} is not of the form {FORM}")
            continue
        given = dict[str, tuple[float, ...]]()
        before = len(faults)
        for part in split_commas(rest[1]):
            key, _, value = (one.strip() for one in part.partition("="))
            if key not in KEYS:
                faults.append(f"--payload {text}: there is no {key}; {choice(key, KEYS)}")
                continue
            try:
                numbers = _numbers(value, KEYS[key])
            except UnitError as error:
                faults.append(f"--payload {text}: {key} = {value} {error}")
                continue
            if key in given:
                faults.append(f"--payload {text}: {key} is there twice")
            elif numbers is None or (key == "mass") is value.startswith("["):
                shown = "3.2" if key == "mass" else "[0,0,0.1]"
                faults.append(f"--payload {text}: {key} = {value}: give {'a number' if key == 'mass' else 'numbers'}, "
                              f"such as {key}={shown}")  # fmt: skip
            else:
                given[key] = numbers
        if "mass" not in given and len(faults) == before:
            faults.append(f"--payload {text}: without a mass it has no known size; give it, kg, as in mass=3.2")
        if len(faults) == before:
            found.append(Payload(rest[0], given["mass"][0], given.get("com"), given.get("inertia"), log))
    if faults:
        raise IdentifyError(faults)
    return tuple(found)


def _numbers(text: str, unit: str) -> tuple[float, ...] | None:
    """Return a number, or several in brackets, in a unit of SI; None where it is none.

    Raises:
        UnitError: one says a unit of another kind.
    """
    inside = split_commas(text[1:-1]) if text.startswith("[") and text.endswith("]") else [text]
    try:
        quantities = [parse(one) for one in inside]
        for one in quantities:
            fits(one, Unit.read(unit))
        values = [one.at({}) for one in quantities]
    except UnitError:
        raise
    except FormulaError:
        return None
    known = [float(one) for one in values if one is not None]
    return tuple(known) if len(known) == len(values) else None
