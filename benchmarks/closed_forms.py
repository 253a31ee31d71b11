"""Time and memory of closed forms: all of k_z, k_C, k_D, k_G in normal form, and as compact forms.

    python benchmarks/closed_forms.py [two_link | puma | iiwa]

Each case runs in its own process; imports are not counted. Targets: two-link 50 ms, PUMA 560 with ten symbolic
inertial parameters a link 1 s, a 7-axis arm 2 s and 500 MB.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from fractions import Fraction

from symdyn.graph import Op
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import Body, Joint, Parameter, Pose
from symdyn.scene.values.body import Particle

QUARTER = Quantity(Op.MUL, (Quantity.number(Fraction(1, 2)), Quantity.PI))
ENTRIES = ("xx", "yy", "zz", "xy", "xz", "yz")

PUMA = [  # standard Denavit-Hartenberg: d, a, alpha in quarter turns
    ("0", "0", 1),
    ("0", "0.4318", 0),
    ("0.15005", "0.0203", -1),
    ("0.4318", "0", 1),
    ("0", "0", -1),
    ("0", "0", 0),
]
IIWA = [
    ("0.36", "0", -1),
    ("0", "0", 1),
    ("0.42", "0", 1),
    ("0", "0", -1),
    ("0.4", "0", -1),
    ("0", "0", 1),
    ("0.126", "0", 0),
]


def arm(name: str, table: list[tuple[str, str, int]]) -> Scene:
    """Return a revolute arm with ten symbolic inertial parameters a link."""
    bodies, joints, parameters = [], [], []
    for i, (d, a, alpha) in enumerate(table, 1):
        names = [f"m{i}", *(f"m{axis}{i}" for axis in "xyz"), *(f"I{i}{entry}" for entry in ENTRIES)]
        parameters += [Parameter(text) for text in names]
        m, mx, my, mz, *inertia = map(Quantity.symbol, names)
        bodies.append(Body(f"link{i}", m, None, (mx, my, mz), tuple(inertia), "frame"))  # type: ignore[arg-type]
        tip = [("Tz", Quantity.number(Fraction(d))), ("Tx", Quantity.number(Fraction(a)))]
        tip += [("Rx", Quantity(Op.MUL, (Quantity.number(alpha), QUARTER)))]
        parent = f"link{i - 1}" if i > 1 else "ground"
        joints.append(
            Joint(
                f"joint{i}",
                "revolute",
                parent,
                f"link{i}",
                tip=Pose(tuple(tip)),
                coordinates=(f"q{i}",),
                drives=(f"tau{i}",),
            )
        )
    return Scene(
        name,
        (*parameters, Parameter("g")),
        (Quantity.ZERO, Quantity.ZERO, -Quantity.symbol("g")),
        tuple(bodies),
        tuple(joints),
    )


def two_link() -> Scene:
    """Return the textbook's example 5.28: point masses at the ends of two links."""
    h1, h2 = Quantity.symbol("h1"), Quantity.symbol("h2")
    bodies = (
        Body("link1", particles=(Particle(Quantity.symbol("m1"), (Quantity.ZERO, -h1, Quantity.ZERO)),)),
        Body("link2", particles=(Particle(Quantity.symbol("m2"), (Quantity.ZERO, -h2, Quantity.ZERO)),)),
    )
    joints = (
        Joint("joint1", "revolute", "ground", "link1", coordinates=("q1",), drives=("M1",)),
        Joint("joint2", "revolute", "link1", "link2", origin=Pose((("Ty", -h1),)), coordinates=("q2",), drives=("M2",)),
    )
    parameters = tuple(Parameter(name, positive=True) for name in ("m1", "m2", "g", "h1", "h2"))
    return Scene("two_link", parameters, (Quantity.ZERO, -Quantity.symbol("g"), Quantity.ZERO), bodies, joints)


CASES = {"two_link": two_link, "puma": lambda: arm("puma", PUMA), "iiwa": lambda: arm("iiwa", IIWA)}


def measure(name: str) -> None:
    """Print one line for one case."""
    from symdyn.dynamics import closed_form

    scene = CASES[name]()
    start = time.perf_counter()
    closed = closed_form(scene)
    derived = time.perf_counter()
    names = closed.coefficient_names()
    forms = [closed.form(*key) for key in names]
    done = time.perf_counter()
    energy = len(closed.K)
    terms = sum(len(closed[key]) for key in names if key[0] in ("k_C", "k_D"))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{name:9} closed forms {derived - start:6.3f} s, compact {done - derived:6.3f} s "
        f"for {len(forms)} coefficients; {energy} terms in K, {terms} in k_C and k_D; {memory:.0f} MB"
    )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure(sys.argv[1])
    else:
        for case in CASES:
            subprocess.run([sys.executable, __file__, case], check=True)
