"""Every argument that takes values of parameters reads them alike: a new one joins `DOORS`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.draw.stage import values_of
from symdyn.errors import SymdynError
from symdyn.scene import Scene, read_noting, read_text, write_text


def pendulum(m: str, letters: str = "", top: str = "") -> Scene:
    """Return a pendulum of 2 m, damped, with a mass as it is written."""
    return read_text(
        f"""
name = "pendulum"
{top}
[parameters]
m = "{m}"
c = "0.1 N*m*s/rad"
{letters}
[bodies.bob]
mass = "m"
com = [0, 0, -2]
[joints.pin]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 1, 0]
coordinate = "phi"
drive = "tau"
damping = "c"
start = "30 deg"
"""
    )


def _varied(x: object) -> object:
    return f"[{x}]" if isinstance(x, str) else np.array([x])


def _symbols(s: Scene) -> Any:
    return symdyn.equations(s).sympy()


DOORS: dict[str, Callable[[Scene, Any], Any]] = {
    "equations": lambda s, x: symdyn.equations(s, values={"m": x}).sympy().M[0, 0],
    "subs": lambda s, x: symdyn.equations(s).subs(m=x).M[0, 0],
    "subs of a symbol": lambda s, x: _symbols(s).subs({_symbols(s)["m"]: x}).M[0, 0],
    "lambdify": lambda s, x: symdyn.equations(s).lambdify({"m": x})(0, [0.1, 1])[1],
    "linearize": lambda s, x: symdyn.linearize(s, start={"phi": 0}, values={"m": x}).B[1, 0],
    "inverse": lambda s, x: symdyn.inverse(s, motion="phi=t", times=[0.5], values={"m": x})["tau"][0],
    "load": lambda s, x: symdyn.load(s, "mass_matrix", parameters={"m": x}).mass_matrix([0.0])[0, 0],
    "sweep": lambda s, x: symdyn.sweep(s, {"m": _varied(x)}, "end(phi)", until=0.1)["end(phi)"][0],
    "sweep of a function": lambda s, x: symdyn.sweep(
        s, {"m": _varied(x)}, "max(tau)", function="inverse_dynamics", at={"phi": 1}
    )["max(tau)"][0],
    "ensemble": lambda s, x: symdyn.ensemble(s, values={"m": x if isinstance(x, str) else [x]}, until=0.1)["end(phi)"],
    "uncertainty": lambda s, x: symdyn.uncertainty(s, {"m": x}, until=0.1)["sd_phi"][-1],
    "bounds": lambda s, x: symdyn.collocation(s, 1, 2, free="m", bounds={"m": (None, x)}).upper[-1],
    "bind": lambda s, x: float(symdyn.scene.bind(s, {"m": x}).parameters["m"].value.at({})),
    "systems": lambda s, x: symdyn.linear.systems(symdyn.Problem(s, start={"phi": 0}), "m")(x).B[1, 0],
    "with_parameters": lambda s, x: float(
        symdyn.identification.with_parameters(s, {"m": x}).parameters["m"].value.at({})
    ),
    "picture": lambda s, x: values_of(s, {"m": x})["m"],
}
"""What comes of a value of m, by the argument that takes it."""


@pytest.mark.wide(3)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", DOORS)
def test_a_value_says_its_unit_or_is_asked(name: str) -> None:
    """A length and a bare number of a mass in grams are told; 85 g is 0.085 kg, and no question where all is in SI."""
    grams, kilograms, door = pendulum("85 g"), pendulum("0.085 kg"), DOORS[name]
    with pytest.raises(SymdynError, match=r"in mm, and kg is asked for|'85 mm': give a finite number"):
        door(grams, "85 mm")
    with pytest.raises(SymdynError, match="m is given in g: write m=85g or m=85kg, whichever is meant"):
        door(grams, 85)
    found, right = np.asarray(door(grams, "85 g"), float), np.asarray(door(kilograms, 0.085), float)
    assert np.all(found != 0)
    assert found == pytest.approx(right, rel=1e-9)


@pytest.mark.runs("cc")
def test_a_mean_in_kilograms_is_taken_at_its_word() -> None:
    """A distribution that says kg for a mass in grams is not asked again, and one number of a deviation is."""
    heavy = symdyn.uncertainty(pendulum("85 g"), "m=normal(85kg, 1kg)", until=0.1)["sd_phi"][-1]
    assert heavy == pytest.approx(symdyn.uncertainty(pendulum("85 kg"), {"m": 1}, until=0.1)["sd_phi"][-1], rel=1e-6)
    with pytest.raises(SymdynError, match="over m: m is given in g: write m=1g or m=1kg"):
        symdyn.uncertainty(pendulum("85 g"), {"m": 1}, until=0.1)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("own", "said", "wrong", "told"),
    [
        ({"limits": {"tau": 0.5}}, {"limits": {"tau": "500 N*mm"}}, {"limits": {"tau": "5 mm"}}, "N m is asked for"),
        ({"limits": (-0.5, 0.1)}, {"limits": ("-500 N*mm", 0.1)}, {"limits": "5 N"}, "N m is asked for"),
        (
            {"limits": (-0.5, 0.1)},
            {"limits": ("-500 N*mm", 0.1)},
            {"limits": (-1, "m")},
            "m is in kg, and N m is asked",
        ),
        ({"period": 0.01}, {"period": "10 ms"}, {"period": "10 mm"}, "s is asked for"),
        (
            {"period": 0.01, "delay": 0.002, "noise": {"phi": np.radians(0.1)}},
            {"period": "10 ms", "delay": "2 ms", "noise": {"phi": "0.1 deg"}},
            {"period": 0.01, "noise": {"phi": "0.1 mm"}},
            "rad is asked for",
        ),
    ],
)
def test_a_controller_says_its_units(own: Any, said: Any, wrong: Any, told: str) -> None:
    """Limits, times and noise with units are those in SI."""

    def driven(settings: Any) -> Any:
        law = symdyn.Feedback(lambda t, q, u: -9 * q, **settings)
        return symdyn.simulate(pendulum("85 g"), until=0.2, feedback=law)["phi"]

    assert driven(said).tolist() == driven(own).tolist()
    with pytest.raises(SymdynError, match=told):
        driven(wrong)


@pytest.mark.runs("cc")
def test_ranges_of_collocation_say_their_units() -> None:
    """Bounds, formulas of the path and times with units are those in SI, and others are refused."""
    one = pendulum("85 g")

    def found(until: Any, size: Any, path: Any) -> list[list[float]]:
        problem = symdyn.collocation(one, until, 2, bounds={"phi": size}, path={"2*phi": path})
        return [x.tolist() for x in (problem.lower, problem.upper, problem.rows_lower, problem.rows_upper)]

    said = found(("100 ms", "1 s"), "45 deg", (None, "0.5 rev"))
    assert said == found((0.1, 1), np.pi / 4, (None, np.pi))
    for wrong in (("1 m", 1, 1), (1, "1 m", 1), (1, 1, ("-1 m", 1))):
        with pytest.raises(SymdynError, match=r"is in m, and (s|rad|1) is asked for"):
            found(*wrong)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("door", "right", "wrong", "told"),
    [
        ("forces", "m*g*l*sin(phi) - phi_dot", "m*g*l + m*l", "forces: tau: m.l is in kg m, and N m is asked for"),
        ("forces", "2*m*l*cos(t)", "m*l*cos(t)", "forces: tau: .* is in kg m, and N m is asked for"),
        ("motion", "t + w*t", "m*t", "motion: phi: m.t is in kg s, and rad is asked for"),
        ("start", "l/h", "l", "start: phi: l is in m, and rad is asked for"),
        ("start_rates", "w", "c", "start rates: phi: c is in .*, and rad/s is asked for"),
        ("subs", "3*l", "2*l", "given: m: 2.l is in m, and kg is asked for"),
    ],
)
def test_a_formula_measures_what_is_asked_for(door: str, right: str, wrong: str, told: str) -> None:
    """A term of symbols that say their units is looked at; a factor of 1 beside t and phi is left out."""
    letters = 'l = "2 m"\nh = "4 m"\ng = "9.81 m/s^2"\nw = "3 rad/s"'

    def given(s: Scene, formula: str) -> object:
        if door == "subs":
            return symdyn.equations(s).subs(m=formula)
        if door == "motion":
            return symdyn.inverse(s, motion={"phi": formula}, times=[0, 0.1])
        return symdyn.simulate(s, until=0.1, **{door: {"tau" if door == "forces" else "phi": formula}})

    given(pendulum("85 g", letters), right)
    given(pendulum("85 g", letters, 'units = "none"'), wrong)
    with pytest.raises(SymdynError, match=told):
        given(pendulum("85 g", letters), wrong)


def _linear(s: Scene) -> Any:
    return symdyn.linearize(s, start={"phi": 0})


TIMED: dict[str, Callable[[Scene, Any], Any]] = {
    "simulate": lambda s, t: symdyn.simulate(s, until=t, every=t)["phi"],
    "inverse": lambda s, t: symdyn.inverse(s, motion="phi=t", until=t)["tau"],
    "uncertainty": lambda s, t: symdyn.uncertainty(s, {"phi": 0.1}, until=t)["sd_phi"],
    "sensitivity": lambda s, t: symdyn.sensitivity(s, until=t).matrix,
    "sweep": lambda s, t: symdyn.sweep(s, "phi=[1, 2]", "end(phi)", until=t)["end(phi)"],
    "ensemble": lambda s, t: symdyn.ensemble(s, start={"phi": [1, 2]}, until=t)["end(phi)"],
    "collocation": lambda s, t: symdyn.collocation(s, (t, 1), 2).lower,
    "gait": lambda s, t: symdyn.gait(s, forces="tau=sin(4*pi*t)", period=t).multipliers,
    "lqr": lambda s, t: _linear(s).lqr(1, 1, t).K,
    "lqg": lambda s, t: _linear(s).lqg(period=t).A,
    "discretize": lambda s, t: _linear(s).discretize(t).A,
    "step": lambda s, t: _linear(s).step("phi", "tau", until=t).values,
    "pid": lambda s, t: symdyn.pid("phi", "tau", 1, period=t).period,
}
"""Every argument that takes a span of time."""


@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", TIMED)
def test_a_time_says_its_unit(name: str) -> None:
    """Half a second is "500 ms" wherever a time is taken, and a length is none."""
    found = [np.asarray(TIMED[name](pendulum("85 g"), t)).tolist() for t in ("500 ms", 0.5)]
    assert found[0] == found[1]
    with pytest.raises(SymdynError, match="5 m is in m, and s is asked for"):
        TIMED[name](pendulum("85 g"), "5 m")


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (lambda: symdyn.Feedback([[1, 2]], limits={"tau": -0.5}), "limits: tau: -0.5 is neither a size"),
        (lambda: symdyn.Feedback(np.eye(2), limits=(3, -3)), "nothing lies between 3 and -3"),
        (lambda: symdyn.pid("phi", "tau", 1, limits=-3), "-3 is neither a size above 0"),
        (lambda: symdyn.Feedback([[1, 2]], period=0), "0 s is no period"),
        (lambda: symdyn.Feedback(np.eye(2), delay=0.1), "without a period"),
        (lambda: _linear(pendulum("85 g")).bode("phi", "tau")(1j), r'lin.transfer\("phi", "tau"\)\(1j\)'),
        (lambda: symdyn.simulate(pendulum("85 g"), until=1, start=[0, 1]), "names are phi"),
        (lambda: symdyn.film(pendulum("85 g"), speed=0.5), "2.run.t, run.q"),  # type: ignore[call-arg]
    ],
)
def test_what_cannot_be_is_told_where_it_is_written(made: Callable[[], object], told: str) -> None:
    """Limits and times of controllers, calls of what is no function: in words, and not first by a run."""
    with pytest.raises(SymdynError, match=told):
        made()


@pytest.mark.runs("cc")
def test_degrees_that_are_taken_for_radians_are_warned_of() -> None:
    """As the shell says it."""
    with pytest.warns(RuntimeWarning, match='start: phi = 90 is in rad; write "90 deg" for degrees'):
        symdyn.simulate(pendulum("85 g"), until=0.1, start={"phi": 90})


def test_a_start_beyond_a_limit_is_noted(tmp_path: Path) -> None:
    """Of the scene as it is read; a start within is not."""
    for limits, told in (('{ lower = "60 deg" }', "below limits.lower"), ('{ lower = 0, upper = "1 rad" }', "")):
        (tmp_path / "one.toml").write_text(write_text(pendulum("85 g"), "toml").text + f"limits = {limits}\n")
        notes = read_noting(tmp_path / "one.toml").notes
        assert [told in one for one in notes] == [True] * bool(told)
