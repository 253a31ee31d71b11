"""Sines of less accuracy than doubles allow: the bound that files tell of them is proved, and met by compiled code."""

from __future__ import annotations

import subprocess
from fractions import Fraction
from math import factorial

import mpmath
import numpy as np
import pytest
from flint import arb, fmpq
from formulas import one
from test_emit_c_batch import FLAGS_PROGRAM, GCC, LINT, near_multiples, sine_and_cosine

from symdyn.algebra.big import Balls
from symdyn.dynamics import Equations
from symdyn.emit import TARGETS, beside, emit, write
from symdyn.emit.code.spelling import SHORT_SINES, ShortSines
from symdyn.emit.targets.c.writer import TWO_OVER_PI
from symdyn.errors import EmitError
from symdyn.graph import Graph
from symdyn.program import formulate, lower
from symdyn.runtime import build
from symdyn.runtime.library import build_extension
from symdyn.scene import example
from symdyn.verify.accuracy import measure

pytestmark = pytest.mark.usefixtures("optimised")

ROWS = pytest.mark.parametrize("row", SHORT_SINES.values(), ids=list(SHORT_SINES))

# The bound, proved


def exact(value: float | Fraction) -> arb:
    """Return a number as a ball without a radius but that of 200 bits."""
    fraction = Fraction(value)
    return arb(fmpq(fraction.numerator, fraction.denominator))


ROUNDOFF = Fraction(1, 2**53)


class Kept:
    """A double of which size and error are bounded: each operation adds one rounding, and fused ones have fewer."""

    def __init__(self, size: arb, error: arb) -> None:
        self.size, self.error = arb(size.upper()), arb(error.upper())

    def rounded(self, size: arb, error: arb) -> Kept:
        mine = exact(ROUNDOFF) * (size + error)
        return Kept(size + mine + error, error + mine)

    def __add__(self, other: Kept) -> Kept:
        return self.rounded(self.size + other.size, self.error + other.error)

    def __mul__(self, other: Kept) -> Kept:
        return self.rounded(
            self.size * other.size,
            self.error * other.size + self.size * other.error + self.error * other.error,
        )


def known(value: float) -> Kept:
    return Kept(abs(exact(value)), exact(0))


def horner(coefficients: tuple[float, ...], z: Kept) -> Kept:
    """Return a polynomial as C computes it."""
    *low, top = coefficients
    found = known(top)
    for coefficient in reversed(low):
        found = known(coefficient) + z * found
    return found


def largest(polynomial: list[Fraction], edge: arb, boxes: int = 12_000) -> arb:
    """Return a bound of |polynomial| on [0, edge], coefficients lowest power first."""
    balls, half = [exact(c) for c in polynomial], edge / (2 * boxes)
    bound = arb(0)
    for box in range(boxes):
        y = half * (2 * box + 1) + arb(0, half.upper())
        value = arb(0)
        for coefficient in reversed(balls):
            value = value * y + coefficient
        bound = bound.max(arb(abs(value).upper()))
    return bound


def gap(terms: dict[int, float], first: int, edge: arb) -> arb:
    """Return a bound of |polynomial - sine| (`first` 1) or cosine (0) on [0, edge]; `terms` by power of y."""
    last = 31 + first
    difference = [Fraction(0)] * last
    for power, coefficient in terms.items():
        difference[power] += Fraction(coefficient)
    for power in range(first, last, 2):
        difference[power] -= Fraction((-1) ** (power // 2), factorial(power))
    return largest(difference, edge) + edge**last / exact(factorial(last))


def proved_bound(row: ShortSines) -> arb:
    """Return a bound of the error of sine and cosine for every angle below 2^limit_exponent."""
    limit = exact(2**row.limit_exponent)
    u, pi = exact(ROUNDOFF), arb.pi()
    quarters = limit * 2 / pi + 1
    # n is next to 2x/pi but for the roundings of 2/pi, of the product and of the sum, whose unit is 1
    off = exact(Fraction(1, 2)) + limit * abs(exact(TWO_OVER_PI) - 2 / pi) + u * (limit + 1)
    edge = off * pi / 2
    assert edge < pi / 4 + exact(Fraction(1, 10**9)), "polynomials were made for a quarter of pi"
    product = limit + 1
    reduced = quarters * abs(exact(row.half_pi) - pi / 2) + u * product + u
    edge = arb((edge + reduced).upper())
    # w differs from y by less than one rounding at 2, z by twice that
    y = Kept(edge, exact(0))
    z = Kept(edge, 4 * u) * Kept(edge, 4 * u)
    one_ = known(1.0)
    sine = y * (one_ + z * horner(row.sine, z))
    cosine = one_ + z * horner(row.cosine, z)
    odd = {1: 1.0, **{2 * k + 3: c for k, c in enumerate(row.sine)}}
    even = {0: 1.0, **{2 * k + 2: c for k, c in enumerate(row.cosine)}}
    return reduced + (gap(odd, 1, edge) + sine.error).max(gap(even, 0, edge) + cosine.error)


@ROWS
def test_the_bound_that_files_tell_is_proved_by_balls(row):
    with Balls(200):
        bound = proved_bound(row)
        assert bound < exact(row.bound)
        assert bound > exact(row.bound) / 2, "a bound that says twice too much would be of little use"


# The bound, met

LIMIT = 2.0**15


@pytest.fixture(scope="module", params=["native", "portable"])
def sincos(request):
    """Sines and cosines of an array by the generated routine, shape (n, 2)."""
    call = build(sources(), machine=request.param).f
    return lambda angles: call(np.reshape(np.asarray(angles, float), (-1, 1)))


def sources(**options):
    return emit(lower(sine_and_cosine()), "c", **{"option": "batch", "accuracy": "1e-10", **options})


def three_sines() -> Equations:
    """What one state takes a row of sines for."""
    g = Graph()
    q = [g.symbol(f"q{k}") for k in (1, 2, 3)]
    return one([f(x) for x in q for f in (g.sin, g.cos)], q)


def worst(found: np.ndarray, angles: np.ndarray) -> float:
    with mpmath.workprec(120):
        wanted = [(mpmath.sin(x), mpmath.cos(x)) for x in map(mpmath.mpf, angles.tolist())]
        pairs = zip(found.tolist(), wanted, strict=True)
        return max(float(abs(mpmath.mpf(a) - b)) for pair in pairs for a, b in zip(*pair, strict=True))


@pytest.mark.wide(2)
@pytest.mark.runs("cc")
@pytest.mark.parametrize("span", [1e-3, 0.8, 3.2, 1e3, LIMIT])
def test_no_sine_is_off_by_more_than_is_told(sincos, span):
    (row,) = SHORT_SINES.values()
    angles = np.random.default_rng(1).uniform(-span, span, 2500)
    found = worst(sincos(angles), angles)
    assert found <= row.bound
    assert found > (1e-18 if span < 0.1 else row.bound / 5), "the bound is no guess"


@pytest.mark.runs("cc")
def test_no_sine_next_to_multiples_of_a_quarter_turn_is_off_by_more(sincos):
    angles = near_multiples(500, LIMIT, np.float64)
    angles = angles[np.abs(angles) < LIMIT]
    assert worst(sincos(angles), angles) <= 8e-12


@pytest.mark.runs("cc")
def test_compilers_have_nothing_to_say_about_it(tmp_path):
    source, _ = write(sources(), tmp_path)
    done = subprocess.run([GCC, *LINT, source.name], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.runs("cc")
def test_larger_angles_are_those_of_the_c_library(sincos):
    angles = np.linspace(-3, 3, 192)
    angles[[5, 70, 180]] = [LIMIT, 1e22, -3e30]
    found = sincos(angles)
    assert worst(found, angles) <= 8e-12
    assert worst(found[[5, 70, 180]], angles[[5, 70, 180]]) <= 2e-16


@pytest.mark.runs("cc")
def test_small_angles_keep_their_digits_zero_its_sign_and_what_is_not_finite_its_name(sincos):
    tiny = float(np.finfo(float).smallest_subnormal)
    angles = np.array([0.0, -0.0, tiny, -tiny, 1e-300, -1e-200, 1e-30, -1e-20, 1e-12] * 8)
    found = sincos(angles)
    assert np.array_equal(found[:, 0], angles)
    assert np.array_equal(np.signbit(found[:, 0]), np.signbit(angles))
    assert (found[:, 1] == 1).all()
    angles[[1, 50]] = [np.nan, np.inf]
    with np.errstate(all="ignore"):
        assert np.isnan(sincos(angles)).all(axis=1).nonzero()[0].tolist() == [1, 50]


@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("flags", [["-march=native"], []])
def test_no_floating_point_flag_is_raised_that_the_numbers_do_not_deserve(flags, tmp_path):
    source, _ = write(sources(), tmp_path)
    (tmp_path / "main.c").write_text(FLAGS_PROGRAM)
    command = [GCC, "-O3", "-fopenmp-simd", *flags, "main.c", source.name, "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout == "0 0 0 0"


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.runs("cc")
def test_one_state_of_three_angles_takes_them_too_and_an_extension_in_double_alone():
    program = lower(three_sines())
    angles = np.random.default_rng(2).uniform(-3, 3, (300, 3))
    exact_ = np.stack([np.sin(angles), np.cos(angles)], -1).reshape(-1, 6)
    for call in (
        build(emit(program, "c", option="batch", accuracy="1e-10")).f,
        build_extension(emit(program, "ufunc", accuracy="1e-10"))[1].f,
    ):
        each, many = np.array([call(x) for x in angles]), call(angles)
        for found in (each, many):
            assert 1e-12 < np.abs(found - exact_).max() < 8e-12
    single = angles.astype(np.float32)
    ours = build_extension(emit(program, "ufunc", accuracy="1e-10"))[1].f(single)
    assert ours.dtype == np.float32
    assert np.array_equal(ours, build_extension(emit(program, "ufunc"))[1].f(single))


# What is said of it


@ROWS
def test_the_files_tell_the_accuracy_and_the_command_that_made_them(row):
    for name, text in sources().texts.items():
        assert f"Accuracy {row.accuracy}: " in text, name
        assert "within 8e-12 of the true one, below 32768 rad" in text, name
        assert f"--accuracy {row.accuracy} --batch" in text, name
    assert all("Accuracy" not in text for text in sources(accuracy="").texts.values())


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"accuracy": "1e-9"}, "accuracy '1e-9' is not known; give '1e-10', or leave it out"),
        ({"accuracy": 1e-10}, "accuracy 1e-10 is not known; give '1e-10', or"),
        ({"real": "float"}, "accuracy 1e-10 is one of double, not of float"),
        (
            {"option": ""},
            "has accuracy 1e-10 with option batch, not as it was asked for: there sines are the C lib",
        ),
        ({"option": "header-only"}, "has accuracy 1e-10 with option batch, not"),
    ],
)
def test_what_has_no_such_accuracy_is_refused_in_words(asked, words):
    with pytest.raises(EmitError, match=words):
        sources(**asked)


def test_targets_with_sines_of_their_language_refuse_it():
    program = lower(formulate(example("pendulum"), ("mass_matrix",)))
    words = "takes the sines of its language; accuracy 1e-10 is for targets c and ufunc"
    for name, target in TARGETS.items():
        if not target.shortens and target.functions is None:
            with pytest.raises(EmitError, match=words):
                emit(program, name, accuracy="1e-10")


# Whole functions


@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", ["arm7", "puma560"])
def test_whole_functions_are_right_to_about_the_accuracy_and_within_their_bounds(name):
    program = lower(formulate(example(name), ("inverse_dynamics",)))
    module = build(emit(program, "c", option="batch", accuracy="1e-10"))
    (found,) = measure(program, {"c": module}, accuracy="1e-10")
    assert found.passed
    assert 1e-13 < found.max_ulp * 2.0**-52 < 1e-10
    (strict,) = measure(program, {"c": module})
    assert not strict.passed


@pytest.mark.long
@pytest.mark.runs("cc")
def test_the_example_beside_the_files_knows_what_they_are_off_by(tmp_path):
    made = emit(lower(formulate(example("puma560"), ("inverse_dynamics",))), "c", option="batch", accuracy="1e-10")
    write({**made, **beside(made)}, tmp_path)
    command = [GCC, "-O2", "main.c", "puma560.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    subprocess.run(["./main"], cwd=tmp_path, check=True, capture_output=True)
