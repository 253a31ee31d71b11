"""Every door that the page of doors lists says in words what it does not take, whichever argument it is."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from reference import catalogue, object_of

import symdyn
from symdyn.arguments import _read, check_arguments
from symdyn.errors import ArgumentError, DrawError, IdentifyError, SimulateError, SymdynError, VerifyError
from symdyn.scene import bind

CART = symdyn.example("cart_pole")

T = [0.0, 0.1]
CALLS: dict[str, dict[str, Any]] = {
    "animation": {"scene": CART, "times": T, "positions": [[0, 0], [0, 0.1]]},
    "film": {"scene": CART, "times": T, "positions": [[0, 0], [0, 0.1]], "file": "run.svg"},
    "picture": {"scene": CART},
    "simulate": {"scene": CART, "until": 0.01},
    "ensemble": {"scene": CART, "until": 0.01},
    "sensitivity": {"scene": CART, "until": 0.01},
    "gait": {"scene": CART, "period": 1.0, "start": "theta=pi"},
    "inverse": {"scene": CART, "motion": "x=t,theta=0", "times": T},
    "sweep": {"scene": CART, "over": "mc=[1, 2]", "measure": "max(abs(x))", "until": 0.01},
    "uncertainty": {"scene": CART, "over": {"mc": 0.01}, "motion": "x=t,theta=0", "times": T},
    "linearize": {"scene": CART},
    "identify": {"scene": CART, "data": {}},
    "calibrate": {"scene": CART, "data": {"x": T, "theta": T, "tip.y": T}, "point": "tip"},
    "output_error": {"scene": CART, "data": {"t": [0, 0.1, 0.2], "x": [0, 0, 0]}, "parameters": "mc"},
    "excite": {"scene": CART, "box": {"x": (-1, 1)}, "terms": 1, "starts": 1},
    "collocation": {"scene": CART, "until": 1, "intervals": 2},
    "scene": {"name": "car"},
}
"""What is in order but for the argument that a test is about."""

SILENT = {("certify", "progress"), ("sweep", "say"), ("sweep", "scheduler"), ("film", "told"), ("lock", "faults")}
"""What is called later, or is nothing that a user gives."""


def doors() -> dict[str, Callable[..., object]]:
    """Return the functions of the reference, but those that declare: the scene tells their faults with places."""
    listed = [name for names in catalogue().values() for name in names]
    found = {name.rpartition(".")[2]: door for name in listed if inspect.isfunction(door := object_of(name))}
    return {name: door for name, door in found.items() if inspect.signature(door).return_annotation != "Entry"}


def single(door: Callable[..., object]) -> list[str]:
    said = inspect.signature(door).parameters.values()
    return [one.name for one in said if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]


JUDGED = [
    (name, argument)
    for name, door in doors().items()
    for argument in single(door)
    if argument in _read(door)
    and (name, argument) not in SILENT
    and "[Entry]" not in door.__annotations__.get(argument, "")
]


def kind_of(name: str, argument: str) -> str:
    return _read(doors()[name])[argument].words[0]


READ = [
    (name, argument)
    for name in CALLS
    for argument in single(doors()[name])
    if (name, argument) not in {*JUDGED, *SILENT}
]


@pytest.mark.parametrize(("name", "argument"), JUDGED)
def test_a_door_tells_an_argument_of_another_kind(name: str, argument: str) -> None:
    given = {one: CART if one in ("scene", "source") else object() for one in single(doors()[name])}
    with pytest.raises(SymdynError, match=rf"(?m)^{argument} = <object object at .*>: give "):
        doors()[name](**{**given, argument: object()})


@pytest.mark.parametrize(("name", "argument"), READ)
def test_a_door_tells_what_it_cannot_read(name: str, argument: str) -> None:
    with pytest.raises(SymdynError):
        doors()[name](**{**CALLS[name], argument: object()})


ODD: tuple[Any, ...] = (
    *(Decimal("1.5"), Decimal("NaN"), Decimal("sNaN"), Decimal("1e400"), Fraction(3, 2), 10**400, Fraction(10**400)),
    *(sympy.Rational(3, 2), sympy.Integer(2), sympy.Symbol("z"), np.float32(1.5), np.int64(2), np.bool_(True)),
    *(np.array(2), np.array(1.5), np.array([1.5]), np.ma.masked, np.timedelta64(3, "s"), np.datetime64("2026")),
    *(True, "1.5", 1 + 0j, math.nan, math.inf, -1, [], {}, int),
)

AMONG: list[tuple[str, str, Callable[[Any], Any]]] = [
    *((name, "start", lambda odd: {"x": odd}) for name in ("simulate", "ensemble", "sweep", "collocation")),
    *((name, "values", lambda odd: {"mc": odd}) for name in ("simulate", "sensitivity", "linearize", "identify")),
    ("ensemble", "values", lambda odd: {"mc": [odd, odd]}),
    ("simulate", "forces", lambda odd: {"F": odd}),
    ("inverse", "times", lambda odd: [0, odd]),
    ("sweep", "over", lambda odd: {"mc": [odd, 2]}),
    ("uncertainty", "over", lambda odd: {"mc": odd}),
    ("collocation", "bounds", lambda odd: {"x": (odd, None)}),
    ("collocation", "intervals", lambda odd: [0, odd, 1]),
    ("collocation", "until", lambda odd: (0.5, odd)),
    ("excite", "box", lambda odd: {"x": (odd, 3)}),
    ("picture", "parameters", lambda odd: {"mc": odd}),
    ("animation", "times", lambda odd: [0, odd]),
    ("film", "size", lambda odd: (odd, 300)),
]
"""Where numbers stand among others: door, argument, and what holds one."""

NUMBERS = [
    *((name, at, lambda odd: odd) for name, at in JUDGED if name in CALLS and "number" in kind_of(name, at)),
    *AMONG,
]


@pytest.mark.wide(6)
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.filterwarnings("ignore")  # NumPy's, on what it makes a number of
@pytest.mark.parametrize(("name", "argument", "holding"), NUMBERS, ids=[f"{name}-{at}" for name, at, _ in NUMBERS])
def test_a_number_of_any_library_is_taken_or_told(
    name: str, argument: str, holding: Callable[[Any], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`film(fps=Decimal(24))` and some forty others raised what Python or NumPy raise."""
    monkeypatch.chdir(tmp_path)
    for odd in ODD:
        with suppress(SymdynError):
            doors()[name](**{**CALLS[name], argument: holding(odd)})


def _flown(
    height: float,
    crew: str | tuple[str, ...] = (),
    seats: int = 1,
    steep: bool = False,
    view: tuple[float, float] | None = None,
    winds: list[Any] | None = None,
) -> None:
    check_arguments(_flown, locals())


@pytest.mark.parametrize(
    "given",
    [{"height": one} for one in (1, 0.5, np.float32(2), np.int64(3), Fraction(1, 3), Decimal("0.1"), np.array(2.0))]
    + [{"crew": one} for one in ("a", ["a", "b"], ("a",), {"a"}, (x for x in "ab"), np.array(["a"]))]
    + [{"seats": np.int32(4)}, {"steep": np.bool_(1)}, {"steep": 1}, {"view": [1, 0.5]}, {"view": np.zeros(2)}],
)
def test_numbers_and_lists_of_any_library_are_taken(given: dict[str, Any]) -> None:
    _flown(**{"height": 1, **given})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"height": "1e-28"}, "height = '1e-28': give a number"),
        ({"height": True}, "height = True: give a number"),
        ({"height": None}, "height = None: give a number"),
        ({"height": np.array("1")}, r"height = array\('1', .*: give a number"),
        ({"height": np.complex128(1)}, "height = .*: give a number"),
        ({"height": sympy.Symbol("h")}, "height = h: give a number"),
        ({"height": 10**400}, "height = 1000.*: give a number"),
        ({"height": np.ma.masked}, "height = masked: give a number"),
        ({"seats": np.array(2.0)}, r"seats = array\(2.\): give a whole number"),
        ({"steep": Decimal("sNaN")}, r"steep = Decimal\('sNaN'\): give True or False"),
        ({"view": np.array(2.0)}, r"view = array\(2.\): give 2 values or None"),
        ({"crew": np.ones(2)}, r"crew = array\(\[1., 1.\]\): give text or a list of texts"),
        ({"height": np.zeros(3)}, r"height = array\(\[0., 0., 0.\]\): give a number"),
        ({"crew": np.array(["a", 3], dtype=object)}, "crew = .*: give text or a list of texts"),
        ({"crew": 3}, "crew = 3: give text or a list of texts"),
        ({"crew": ["a", 3]}, "crew = .*: give text or a list of texts"),
        ({"crew": b"ab"}, "crew = b'ab': give text or a list of texts"),
        ({"seats": 1.0}, "seats = 1.0: give a whole number"),
        ({"steep": "no"}, "steep = 'no': give True or False"),
        ({"view": "ab"}, "view = 'ab': give 2 values or None"),
        ({"view": [1, 2, 3]}, "view = .*: give 2 values or None"),
        ({"height": "x" * 1000, "crew": 3}, "(?s)^.{1,140}$"),
    ],
)
def test_others_are_told_with_what_would_be_taken(given: dict[str, Any], words: str) -> None:
    with pytest.raises(ArgumentError, match=words):
        _flown(**{"height": 1, **given})


@pytest.mark.runs("cc")
@pytest.mark.parametrize("tenth", [Fraction(1, 10), Decimal("0.1"), sympy.Rational(1, 10)])
def test_runs_take_numbers_of_any_library(tenth: Any) -> None:
    run = symdyn.simulate(CART, until=tenth, every=tenth / 10, rtol=tenth**9, method="dop853")
    assert (len(run.t), run.t[-1]) == (11, 0.1)
    assert symdyn.ensemble(CART, until=tenth, start={"theta": [0.1, 0.2]}, measures="max(x)")["max(x)"].shape == (2,)
    assert symdyn.sensitivity(CART, until=tenth, of="x").t == 0.1


@pytest.mark.runs("cc")
def test_a_series_of_pandas_holds_values_by_name() -> None:
    pandas = pytest.importorskip("pandas")
    values = {"mc": 2.0, "mp": 1.0}
    found = [symdyn.linearize(CART, values=one).A for one in (values, pandas.Series(values))]
    np.testing.assert_array_equal(found[1], found[0])
    assert (found[0] != symdyn.linearize(CART, values=pandas.Series(dtype=float)).A).any()
    assert symdyn.load(CART, ["mass_matrix"], parameters=pandas.Series(values)).scene == bind(CART, values)
    over, motion = {"mc": 0.01}, {"x": "t**2", "theta": "0"}
    spreads = [symdyn.uncertainty(CART, one, motion=motion, times=T) for one in (over, pandas.Series(over))]
    np.testing.assert_array_equal(spreads[1]["F"], spreads[0]["F"])


def test_a_picture_that_moves_takes_numbers_of_any_library(tmp_path: Path) -> None:
    given = {"scene": CART, "times": (x for x in (0, 1)), "positions": [[0, 0], [Fraction(1, 5), 1]]}
    path = symdyn.film(**given, file=tmp_path / "cart.svg", fps=Decimal(24), size=[np.int64(400), 300])
    assert ' width="400" height="300">' in path.read_text(encoding="utf-8")
    with pytest.raises(DrawError, match=r"^cart_pole: nan moments a second; give a number above 0, such as 30$"):
        symdyn.animation(CART, T, [[0, 0], [0, 0]], fps=math.nan)
    with pytest.raises(DrawError, match=r"^cart_pole: times or positions are no numbers: "):
        symdyn.animation(CART, np.array(["a", "b"]), [[0, 0], [0, 0]])
    with pytest.raises(DrawError, match=r"^cart_pole: mc = nan: give a finite number$"):
        symdyn.picture(CART, parameters={"mc": math.nan})
    with pytest.raises(DrawError, match=r'^colour scheme "1" is unknown; there are auto, light, dark$'):
        symdyn.film(CART, T, [[0, 0], [0, 0]], tmp_path / "cart.gif", scheme="1")


def test_all_are_told_at_once() -> None:
    with pytest.raises(SimulateError) as caught:
        symdyn.simulate(CART, rtol="1e-28", stops=3, until="ten")  # type: ignore[arg-type]
    assert caught.value.faults == (
        "until = 'ten': give a number",
        "rtol = '1e-28': give a number or None",
        "stops = 3: give text or a list of texts or SymPy expressions",
    )
    with pytest.raises(IdentifyError, match=r"^units = 'M.=A': give values by name, as in .* or None$"):
        symdyn.identify(CART, {}, units="M*=A")  # type: ignore[arg-type]


@pytest.mark.parametrize("real", ["x", "dd"])
def test_a_type_that_no_certificate_measures_is_told(real: str) -> None:
    with pytest.raises(VerifyError, match=f"^real type '{real}' is not measured; give double or float$"):
        symdyn.certify(CART, real=real)
