"""Errors of generated code and of the textbook's algorithms in plain double, both against 50 digits.

    python benchmarks/accuracy.py            writes docs/accuracy-of-code.md; --quick prints a rough table

The textbook's side, the reference for both included, is `plain_textbook.py`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
from plain_textbook import DIGITS, Array, textbooks

from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.runtime import build, run_python
from symdyn.scene import Quantity, Scene, dh_table, read, scene
from symdyn.scene.values import Body
from symdyn.table import Table

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "accuracy-of-code.md"

STATES, QUICK = 2000, 60
BAR = 2.0

OUTPUTS: dict[str, tuple[str, ...]] = {
    "inverse_dynamics": ("q", "qd", "qdd"),
    "mass_matrix": ("q",),
    "forward_dynamics": ("q", "qd", "tau"),
    "gravity_forces": ("q",),
    "velocity_forces": ("q", "qd"),
    "momentum": ("q", "qd"),
    "kinetic_energy": ("q", "qd"),
}
"""What is measured, and its arguments."""


# Cases


def heavier(scene: Scene, factors: Sequence[Fraction | int]) -> Scene:
    """Return a scene whose bodies are so many times as heavy, density by density."""

    def scaled(body: Body, factor: Quantity) -> Body:
        return replace(body, mass=body.mass * factor, inertia=tuple(x * factor for x in body.inertia))

    bodies = tuple(scaled(body, Quantity.number(factor)) for body, factor in zip(scene.bodies, factors, strict=True))
    return replace(scene, bodies=bodies)


@dataclass(frozen=True)
class Case:
    """One mechanism.

    Attributes:
        text: its name in the table.
        scene: without free parameters.
        times: how many times the usual number of states it takes for a 99th percentile that stands still: with a great
            load, errors of accelerations grow without bound near singular postures.
    """

    text: str
    scene: Scene
    times: int = 1


def cases() -> tuple[Case, ...]:
    """Return what is measured."""
    puma, arm, scara = (read(ROOT / "examples" / f"{name}.toml") for name in ("puma560", "arm7", "scara"))
    big, small = 10**12, Fraction(1, 10**12)
    return (
        Case("PUMA 560", puma),
        Case("7-axis arm", arm),
        Case("SCARA", scara),
        Case("6 axes, each leaning by 10 deg", leaning("10 deg")),
        Case("6 axes, each leaning by 50 deg", leaning("50 deg")),
        Case("7-axis arm, last link 1e12 times as heavy", heavier(arm, (1,) * 6 + (big,))),
        Case("7-axis arm, last link 1e-12 times as heavy", heavier(arm, (1,) * 6 + (small,))),
        Case("7-axis arm, links 1 and 1e-12 by turns", heavier(arm, (1, small) * 3 + (1,))),
        Case("PUMA 560, last link 1e12 times as heavy", heavier(puma, (1,) * 5 + (big,)), times=10),
        Case("SCARA, last link 1e12 times as heavy", heavier(scara, (1,) * 3 + (big,)), times=10),
    )


def leaning(alpha: str) -> Scene:
    """Return an arm of six links of full inertia, each axis turned by alpha against the one before it."""
    links = [
        {
            "name": f"link{k}",
            "alpha": alpha,
            "a": "0.3",
            "d": "0.2",
            "mass": 7 - k,
            "com": ["0.1", "-0.02", "0.05"],
            "inertia": {"xx": 0.03, "yy": 0.04, "zz": 0.02, "xy": 0.002, "xz": -0.003, "yz": 0.001},
            "inertia_about": "com",
        }
        for k in range(1, 7)
    ]
    return scene("leaning", dh=dh_table("modified", links))


ANGLES = ("within ±π", "10³ … 10⁶ rad")


def draw(scene: Scene, angles: str, count: int, seed: int) -> dict[str, Array]:
    """Return q, qd and qdd, shape (count, n); positions of slides stay within a metre."""
    rng, n = np.random.default_rng(seed), len(scene.coordinates)
    q = rng.uniform(-np.pi, np.pi, (count, n))
    if angles != ANGLES[0]:
        q = np.sign(q) * 10 ** rng.uniform(3, 6, (count, n))
    for k, joint in enumerate(scene.moving):
        if joint.type == "prismatic":
            q[:, k] = rng.uniform(-1, 1, count)
    return {"q": q, "qd": rng.uniform(-2, 2, (count, n)), "qdd": rng.uniform(-2, 2, (count, n))}


# Errors


@dataclass(frozen=True)
class Row:
    """99th percentiles of the errors of one output, relative to the largest entry of the result."""

    case: str
    angles: str
    output: str
    textbook: float
    C: float
    numpy: float

    @property
    def ratio(self) -> float:
        """The greater error of ours over the textbook's."""
        return max(self.C, self.numpy) / self.textbook


def measure(case: Case, count: int) -> list[Row]:
    """Return a row for every range of angles and output."""
    with localcontext(prec=DIGITS):
        return list(_rows(case.text, case.scene, count * case.times))


def _rows(text: str, scene: Scene, count: int) -> Iterator[Row]:
    big, plain = textbooks(scene)
    program = lower(formulate(scene, tuple(OUTPUTS)))
    ours = {"C": build(program), "numpy": run_python(emit(program, "numpy"))}
    for angles in ANGLES:
        states = draw(scene, angles, count, seed=11)
        states["tau"] = plain.inverse_dynamics(states["q"], states["qd"], states["qdd"])
        exact = big.reference(**{name: to_big(values) for name, values in states.items()})
        for output, arguments in OUTPUTS.items():
            given = [states[name] for name in arguments]
            calls = {"textbook": plain, **ours}
            found = {name: percentile(getattr(one, output)(*given), exact[output]) for name, one in calls.items()}
            yield Row(text, angles, output, **found)


def to_big(values: Array) -> Array:
    """Return floats exactly."""
    return np.vectorize(Decimal, otypes=[object])(values)


def percentile(found: Array, reference: Array) -> float:
    """Return the 99th percentile over states of the largest error, relative to the largest entry."""
    reference = reference.reshape(len(reference), -1)
    gap = np.max(np.abs(to_big(np.reshape(found, reference.shape)) - reference), axis=1)
    largest = np.max(np.abs(reference), axis=1)
    return float(np.percentile((gap / np.where(largest == 0, 1, largest)).astype(float), 99))


HEAD = """# Accuracy of generated code

Made by `python benchmarks/accuracy.py`. 99th percentiles over {count:,} random states of the largest error of a
result's entries, relative to its largest entry, against mpmath's sines and 50 digits; over ten times as many for the
PUMA and the SCARA with a great load, whose accelerations have errors without bound near singular postures. *Textbook*:
Newton-Euler recursion, composite rigid bodies and LᵀDL in plain double over the declared frames, as written in
`benchmarks/plain_textbook.py`. *C* is the batch code as it is built by default, without `-ffast-math`. *Ratio*: the
greater one of C and NumPy over the textbook; the bar is {bar:g}, the largest here {worst:.2f}.

Velocities and accelerations are within ±2; the driving forces of forward dynamics are those of such accelerations. A
link that is 1e12 times as heavy has as many times the mass and the inertia.

"""

HEADS = ("robot", "angles", "output", "textbook", "C", "NumPy", "ratio")


def main() -> int:
    """Measure, print, write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} states in place of {STATES}, no page")
    quick = parser.parse_args().quick
    count, rows = QUICK if quick else STATES, []
    for case in cases():
        for row in measure(case, count):
            rows.append(row)
            print(" | ".join(cells(row)), flush=True)
    worst = max(rows, key=lambda row: row.ratio)
    print(f"\nlargest ratio {worst.ratio:.2f}: {worst.case}, {worst.output}, angles {worst.angles}")
    if not quick:
        table = Table(HEADS, list(map(cells, rows)), range(3, 7))
        PAGE.write_text(f"{HEAD.format(count=count, bar=BAR, worst=worst.ratio)}{table.markdown(str)}\n", "utf-8")
        print(f"wrote {PAGE.relative_to(ROOT)}")
    return int(not quick and worst.ratio > BAR)  # a few states say little about the last percent


def cells(row: Row) -> tuple[str, ...]:
    """Return a row of the table."""
    figures = (f"{x:.1e}" for x in (row.textbook, row.C, row.numpy))
    return str(row.case), row.angles, row.output, *figures, f"{row.ratio:.2f}"


if __name__ == "__main__":
    sys.exit(main())
