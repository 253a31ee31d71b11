"""What can be called in Python, doors and methods of what they return, and what comes of it with a wrong argument."""

from __future__ import annotations

import contextlib
import inspect
import os
import re
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from wrong_values import FAILING, WRONG

import symdyn
from symdyn.draw.pictures import HtmlText, SvgText
from symdyn.dynamics.closed_forms.closed_form import ClosedForm
from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.emit.print.equations_text import EquationsOfMotion
from symdyn.emit.print.sympy_equations import SympyEquations
from symdyn.errors import SymdynError
from symdyn.identification import Identification
from symdyn.linear import FrequencyResponse, Linearization, TimeResponse
from symdyn.program.routine import Program
from symdyn.resources import folder
from symdyn.runtime.loaded import Loaded
from symdyn.runtime.numeric_function import NumericFunction
from symdyn.simulation.error_bars import Uncertainty
from symdyn.simulation.trajectory import Trajectory
from symdyn.simulation.variations import Sensitivity
from symdyn.study import Runs
from symdyn.transcription.transcribed import Collocation
from symdyn.verify.certificate import Certificate

PATIENCE = 30
"""Seconds after which a call with a wrong value is one that hangs."""

LINE = 1600
"""Characters of a line of a message, of which a name of 5,000 would be most."""

T = [0.0, 0.1]
MOTION = {"x": "t", "theta": "0"}
POSES = {"x": [0.0, 0.1, 0.2], "theta": [0.0, 0.1, 0.3], "tip.y": [0.5, 0.4975, 0.4777]}
SERIES = {name: np.linspace(0, 2, 41) ** k for k, name in enumerate(("t", "x", "theta", "F"), 1)}


@cache
def cart() -> symdyn.Scene:
    """Return the scene of most calls."""
    return symdyn.example("cart_pole")


DOORS: dict[str, list[dict[str, Any]]] = {
    "Feedback": [{"law": [[1, 2, 3, 4]], "inputs": "F"}],
    "Scene": [{"name": "made"}],
    "SymdynError": [{}],
    "Problem": [{}],
    "animation": [{"times": T, "positions": [[0, 0], [0, 0.1]]}],
    "calibrate": [{"data": POSES, "point": "tip"}],
    "certify": [{"outputs": ["mass_matrix"], "targets": ["numpy"]}],
    "closed_form": [{}],
    "collocation": [{"until": 1, "intervals": 2}],
    "derive": [{"outputs": ["mass_matrix"]}],
    "ensemble": [{"until": 0.01}, {"scene": "pendulum", "until": 0.01}],
    "equations": [{}],
    "example": [{"name": "cart_pole"}],
    "film": [{"times": T, "positions": [[0, 0], [0, 0.1]], "file": "run.svg"}],
    "gait": [{"period": 1.0, "start": "theta=pi"}],
    "identify": [{"data": SERIES}],
    "inverse": [{"motion": MOTION, "times": T}],
    "inverse_kinematics": [{"scene": "puma560", "path": "tool=0.45, 0.2, 0.1, rpy(0, 0.5, 0.2)"}],
    "lambdify": [{"name": "mass_matrix"}],
    "linearize": [{}],
    "load": [{"functions": ["mass_matrix"]}],
    "lower": [{}],
    "picture": [{}],
    "pid": [{"measures": "theta", "inputs": "F", "kp": 1}],
    "read": [{"path": folder("examples") / "cart_pole.toml"}],
    "sensitivity": [{"until": 0.01}],
    "simulate": [{"until": 0.01}, {"scene": "pendulum", "until": 0.01}],
    "sweep": [
        {"over": {"mc": [1, 2]}, "measure": "max(abs(x))", "until": 0.01},
        {"over": {"mc": [1, 2]}, "measure": "M1_1", "function": "mass_matrix"},
    ],
    "uncertainty": [
        {"over": {"mc": 0.01}, "until": 0.05},
        {"over": {"mc": 0.01}, "motion": MOTION, "times": T},
    ],
}
"""What each door is called with, when all is in order, but for its scene if it is the usual one: a row where it reads
other arguments."""

NOUNS: dict[type, Callable[[], Any]] = {
    symdyn.Scene: cart,
    Certificate: lambda: symdyn.certify(cart(), ["mass_matrix"], targets=["numpy"]),
    ClosedForm: lambda: symdyn.closed_form(cart()),
    Collocation: lambda: symdyn.collocation(cart(), until=1, intervals=2),
    Equations: lambda: symdyn.dynamics.derive(cart(), ["mass_matrix"]),
    EquationsOfMotion: lambda: symdyn.equations(cart()),
    FrequencyResponse: lambda: symdyn.linearize(cart()).bode(),
    HtmlText: lambda: symdyn.animation(cart(), T, [[0, 0], [0, 0.1]]),
    Identification: lambda: symdyn.identify(cart(), symdyn.simulate(cart(), forces="F=sin(5*t)+cos(11*t)", until=2)),
    Linearization: lambda: symdyn.linearize(cart()),
    Loaded: lambda: symdyn.load(cart(), ["mass_matrix"]),
    NumericFunction: lambda: symdyn.lambdify(cart(), "mass_matrix"),
    Program: lambda: symdyn.program.lower(noun(Equations)),
    Runs: lambda: symdyn.sweep(cart(), "mc=uniform(1, 2)", "max(abs(x))", until=0.01, design="saltelli", count=8),
    Sensitivity: lambda: symdyn.sensitivity(cart(), until=0.01),
    SvgText: lambda: symdyn.picture(cart()),
    SympyEquations: lambda: symdyn.equations(cart()).sympy(),
    TimeResponse: lambda: noun(Linearization).step(),
    Trajectory: lambda: symdyn.simulate(cart(), until=0.1),
    Uncertainty: lambda: symdyn.uncertainty(cart(), {"mc": 0.01}, until=0.05),
}
"""What doors return, by class."""

OTHERS: dict[str, Callable[[], dict[str, Any]]] = {
    "Collocation.at": lambda: {"z": noun(Collocation).guess, "where": "node"},
    "Scene.in_shown_unit": lambda: {"number": "1", "unit": "m"},
    "Collocation.column": lambda: {"kind": "q", "k": 0, "points": np.arange(2)},
    "Scene.at_time": lambda: {"graph": noun(Equations).graph, "t": 0.0},
    "Scene.order": lambda: {"names": [one.name for one in cart().joints]},
    "Linearization.without": lambda: {"positions": ()},
    "Linearization.transfer": lambda: {"output": "theta"},
    "Linearization.margins": lambda: {"output": "theta"},
    "Linearization.root_locus": lambda: {"output": "theta"},
    "Linearization.place": lambda: {"poles": [-1, -2, -3, -4]},
    "TimeResponse.info": lambda: {"output": "x"},
    "Trajectory.film": lambda: {"file": "run.svg"},
    "Trajectory.to_npz": lambda: {"file": "run.npz"},
    "Trajectory.save_plot": lambda: {"file": "run.svg"},
    "Runs.save_plot": lambda: {"file": "study.svg"},
    "Runs.indices": lambda: {"measure": "max(abs(x))"},
    "Runs.quantiles": lambda: {"name": "mc"},
}
"""What a method is called with, where it must be given more than what is wrong."""

WORDS: dict[str, str] = {
    "at": r"start|until|file",
    "channel|input": r"(out|in)put: ",
    "every": r"one sample",
    "exact|guess|starts|seed": r"solving needs IPOPT",
    "file": r"written to|folder|system",
    "fps": r"a second",
    "function": r"measure",
    "given|values|parameters": r"q (is|has)|there is no|parameter|give text",
    "key": r"coefficient",
    "kind": r"plot",
    "motion": r"times|file",
    "motion|start|time|values": r"need EAIK",
    "outcomes": r"measure",
    "names?|columns|request|functions": r"column|function|known|derived|routine|example|parameter|output|there is no",
    "outputs": r"name one",
    "passes": r"pass",
    "path|feedback|forces|data|scene": r"folder|file|UTF-8|TOML|extension|read|moves",
    "q": r"positions",
    "size": r"pixels",
    "stops|reports": r"event",
    "until": r"t =",
    "[QRWV]": r"Riccati",
}
"""How messages call what is wrong where it is not by its argument's name."""


INNER: dict[str, Callable[..., Any]] = {"derive": symdyn.dynamics.derive, "lower": symdyn.program.lower}
"""Functions of packages that are called wrongly like those of `symdyn`."""


def door(name: str) -> Callable[..., Any]:
    """Return a public function."""
    found: Callable[..., Any] = INNER[name] if name in INNER else getattr(symdyn, name)
    return found


@cache
def noun(kind: type) -> Any:
    """Return what a door returns."""
    found = NOUNS[kind]()
    assert type(found) is kind
    return found


@dataclass(frozen=True)
class Called:
    """An argument of something that can be called.

    Attributes:
        name: of the door, or `Class.method`.
        argument: of it.
        way: the row of `DOORS` that it is called by.
        starred: whether the argument stands for any number of them.
    """

    name: str
    argument: str
    way: int = 0
    starred: bool = False

    def __str__(self) -> str:
        return f"{self.name}-{self.argument}" + f"-{self.way}" * (self.way > 0)

    @property
    def function(self) -> Callable[..., Any]:
        """What is called."""
        owner, _, name = self.name.rpartition(".")
        kinds = {kind.__name__: kind for kind in NOUNS}
        found: Callable[..., Any] = getattr(noun(kinds[owner]), name) if owner else door(name)
        return found

    @property
    def others(self) -> dict[str, Any]:
        """All other arguments, in order."""
        if "." in self.name:
            return OTHERS.get(self.name, dict)()
        first = {"scene": cart, "equations": lambda: noun(Equations)}
        said = inspect.signature(self.function).parameters
        row = dict(DOORS[self.name][self.way])
        if isinstance(example := row.get("scene"), str):
            row["scene"] = symdyn.example(example)
        return {**{name: make() for name, make in first.items() if name in said}, **row}

    def __call__(self, value: Any) -> Any:
        """Call it with a value, all else in order."""
        if self.starred:
            return self.function(value, **self.others)
        given = {**self.others, self.argument: value}
        said = inspect.signature(self.function).parameters.values()
        positional = [given.pop(one.name) for one in said if one.kind is one.POSITIONAL_ONLY and one.name in given]
        return self.function(*positional, **given)


def every_argument() -> list[Called]:
    """Return each argument of each door and of each method of what doors return, in a fixed order."""
    found = [
        Called(name, *one)
        for name in sorted((*symdyn.__all__, *INNER))
        for way in range(len(DOORS[name]))
        for one in _arguments(door(name), way)
    ]
    for kind in NOUNS:
        for name in sorted(dir(kind)):
            method = inspect.getattr_static(kind, name)
            public = not name.startswith("_") or name in ("__getitem__", "__call__")
            if public and inspect.isfunction(method) and method.__module__.startswith("symdyn"):
                found += [Called(f"{kind.__name__}.{name}", *one) for one in _arguments(method, 0) if one[0] != "self"]
    return found


def _arguments(function: Callable[..., Any], way: int) -> list[tuple[str, int, bool]]:
    said = inspect.signature(function).parameters.values()
    return [(one.name, way, one.kind is one.VAR_POSITIONAL) for one in said if one.kind is not one.VAR_KEYWORD]


@contextlib.contextmanager
def no_longer_than(seconds: float) -> Iterator[None]:
    """Raise `TimeoutError` in what takes longer."""

    def late(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@contextlib.contextmanager
def silently() -> Iterator[None]:
    """Let nothing be printed, and no warning be told."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with np.errstate(all="ignore"):
            yield


def fault(called: Called, wrong: str) -> str:
    """Return what is wrong with what comes of a wrong value, "" where it is taken or refused in words."""
    value = WRONG[wrong]()
    try:
        with silently(), no_longer_than(PATIENCE):
            called(value)
    except SymdynError as refused:
        return _lack(str(refused), called, value)
    except TimeoutError:
        return f"hangs for {PATIENCE} s"
    except BaseException as error:  # whatever comes from inside is the fault that is looked for
        if wrong in FAILING and isinstance(error, FAILING[wrong]):
            return ""
        places = traceback.extract_tb(error.__traceback__)
        place = [one for one in places if "symdyn" in one.filename or one is places[0]][-1]
        return f"{type(error).__name__} at {os.path.basename(place.filename)}:{place.lineno}"
    return ""


def _lack(message: str, called: Called, value: Any) -> str:
    """Return what a message lacks: words, an end, the argument or what was found."""
    longest = max(map(len, message.splitlines()), default=0)
    if not message.strip():
        return "says nothing"
    if longest > LINE:
        return f"says a line of {longest} characters"
    named = any(re.fullmatch(one, called.argument) and re.search(words, message) for one, words in WORDS.items())
    stem = called.argument.rstrip("s").replace("_", ".")
    if named or re.search(stem, message, re.IGNORECASE) or callable(value) or isinstance(value, symdyn.Scene):
        return ""
    return f"names neither {called.argument} nor what it is: {message:.150}"
