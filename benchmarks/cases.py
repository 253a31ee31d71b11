"""What is timed: mechanisms with numbers, their functions, and the states that every implementation gets.

Each mechanism has rotary joints only and is written as URDF for the peers that read it, so that all compute the same
numbers. States are uniform in ±2 (rad, rad/s, rad/s²); the driving forces are those of inverse dynamics at the state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Batches
from symdyn.graph import evaluate
from symdyn.program import Program, formulate, lower, quaternion_places
from symdyn.scene import Scene, SceneUnits, body, read, revolute, scene, write_text

Array = npt.NDArray[np.float64]
Value = TypeVar("Value")

EXAMPLES = Path(__file__).parent.parent / "examples"

OUTPUTS = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "gravity_forces")

STATES = 64
"""States that scalar functions cycle through: enough that no branch is learnt, few enough for the nearest cache."""

CHAINS = (2, 4, 8, 16, 32, 64)


class OnDemand(dict[str, Value]):
    """Values by the name of an output, made when they are first asked for."""

    def __init__(self, make: Callable[[str], Value]) -> None:
        self.make = make

    def __missing__(self, output: str) -> Value:
        self[output] = self.make(output)
        return self[output]


@dataclass(frozen=True)
class Case:
    """One mechanism and its states.

    Attributes:
        name: as in tables.
        scene: the mechanism, without free parameters.
    """

    name: str
    scene: Scene

    @property
    def n(self) -> int:
        """The number of velocities: of joints, where nothing floats."""
        return len(self.scene.velocities)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the coordinates."""
        return tuple(joint.name for joint in self.scene.moving)

    @cached_property
    def urdf(self) -> str:
        """The mechanism as URDF."""
        return write_text(self.scene, "urdf", lossy=True).text

    @cached_property
    def programs(self) -> dict[str, Program]:
        """The program of every output, each alone."""
        return OnDemand(lambda output: lower(formulate(self.scene, (output,))))

    @cached_property
    def states(self) -> dict[str, Array]:
        """Arguments by name, shape (STATES, entries)."""
        return self.draw(STATES)

    def draw(self, count: int) -> dict[str, Array]:
        """Return `count` states: q, qd, qdd and the tau that goes with them, shape (count, entries)."""
        rng = np.random.default_rng(7)
        q, qd, qdd = rng.uniform(-2, 2, (3, count, self.n))
        more = rng.uniform(-2, 2, (count, len(self.scene.coordinates) - self.n))  # a quaternion has four numbers
        q = np.concatenate([q, more], axis=1)
        for k in quaternion_places(SceneUnits(self.scene).coordinates):
            q[:, k : k + 4] /= np.linalg.norm(q[:, k : k + 4], axis=1, keepdims=True)
        tau = self.evaluate("inverse_dynamics", {"q": q, "qd": qd, "qdd": qdd})
        return {"q": q, "qd": qd, "qdd": qdd, "tau": tau}

    def arguments(self, output: str) -> tuple[str, ...]:
        """Return the names of the arguments of an output, such as ("q", "qd", "tau")."""
        return tuple(a.name for a in self.programs[output].routines[0].function.arguments)

    @cached_property
    def references(self) -> dict[str, Array]:
        """The results at `states`, shape (STATES, size)."""
        return OnDemand(lambda output: self.evaluate(output, self.states))

    def evaluate(self, output: str, states: dict[str, Array]) -> Array:
        """Return the results of an output at states by running its expressions over NumPy arrays."""
        function = self.programs[output].routines[0].function
        values = {
            symbol: np.ascontiguousarray(states[argument.name][:, i])
            for argument in function.arguments
            for i, symbol in enumerate(argument.symbols)
        }
        count = len(states["q"])
        columns = evaluate(function.entries, Batches(), values)
        return np.stack([np.broadcast_to(column, (count,)) for column in columns], axis=1)

    def difference(self, output: str, found: Array) -> float:
        """Return the largest difference from the reference, relative to the largest entry of a state.

        Accelerations are compared by the forces M(q) (q̈ - q̈') that would make the difference, relative to the driving
        forces: no more digits of q̈ are known than the condition of M leaves.
        """
        count = len(found)
        right = self.references[output][:count]
        gap = found - right
        if output == "forward_dynamics":
            M = self.references["mass_matrix"][:count].reshape(count, self.n, self.n)
            gap, right = np.einsum("kij,kj->ki", M, gap), self.states["tau"][:count]
        largest = np.max(np.abs(right), axis=1)
        return float(np.max(np.max(np.abs(gap), axis=1) / np.where(largest > 0, largest, 1.0)))


def cases() -> dict[str, Case]:
    """Return every mechanism by name, small ones first."""
    named = {
        "two_link": two_link(),
        "puma560": read(EXAMPLES / "puma560.toml"),
        "arm7": read(EXAMPLES / "arm7.toml"),
        "tree32": tree(),
        **{f"chain{n}": chain(n) for n in CHAINS},
    }
    return {name: Case(name, one) for name, one in named.items()}


def two_link() -> Scene:
    """Return the planar two-link arm, hanging, with slender rods of 0.5 m and 2 kg, 0.4 m and 1 kg."""
    bodies = [rod("link1", 2, "0.5"), rod("link2", 1, "0.4")]
    joints = [
        revolute("joint1", "ground", "link1", axis=[0, 1, 0]),
        revolute("joint2", "link1", "link2", axis=[0, 1, 0], origin=[0, 0, "-0.5"]),
    ]
    return scene("two_link", bodies=bodies, joints=joints)


def rod(name: str, mass: int, length: str) -> object:
    """Return a rod that hangs down from its joint."""
    size = Fraction(length)
    across = mass * size**2 / 12
    inertia = [across, across, across / 1000]
    return body(name, mass=mass, com=[0, 0, -size / 2], inertia=inertia, about="com")


def link(name: str, k: int) -> object:
    """Return the k-th link of a robot: all ten inertial parameters, none of them like the link before."""
    step = Fraction(k % 7, 100)
    com = [Fraction(1, 100) + step / 10, Fraction(-2, 100), Fraction(6, 100) + step / 5]
    inertia = {"xx": 0.010, "yy": 0.012, "zz": 0.009, "xy": 0.0004, "xz": -0.0003, "yz": 0.0005}
    return body(name, mass=1 + step, com=com, inertia=inertia, about="com")


TURNS = (["-pi/2", 0, 0], ["pi/2", 0, 0])


def chain(n: int) -> Scene:
    """Return a snake of n links of full inertia; each axis is at right angles to the one before."""
    bodies = [link(f"link{k}", k) for k in range(1, n + 1)]
    joints = [
        revolute(
            f"joint{k}",
            "ground" if k == 1 else f"link{k - 1}",
            f"link{k}",
            axis=[0, 0, 1],
            origin={"xyz": [0, 0, "0.1"] if k % 2 else [0, "0.02", "0.15"], "rpy": TURNS[k % 2]},
        )
        for k in range(1, n + 1)
    ]
    return scene(f"chain{n}", bodies=bodies, joints=joints)


LIMBS = (("torso", 3, ""), ("head", 3, "torso3"), ("left", 7, "torso3"), ("right", 7, "torso3"))
LEGS = (("leg", 6, "torso1"), ("limp", 6, "torso1"))


def tree() -> Scene:
    """Return a humanoid of 32 rotary joints that hangs on its torso: head, two arms of seven axes, two legs of six."""
    bodies, joints, k = [], [], 0
    for limb, length, root in LIMBS + LEGS:
        for i in range(1, length + 1):
            k += 1
            name = f"{limb}{i}"
            bodies.append(link(name, k))
            side = Fraction("0.2") if limb in ("left", "leg") else Fraction("-0.2")
            place = [0, side, "0.1"] if i == 1 and root else [0, "0.02", "0.15"]
            parent = (root or "ground") if i == 1 else f"{limb}{i - 1}"
            joints.append(
                revolute(f"{name}_joint", parent, name, axis=[0, 0, 1], origin={"xyz": place, "rpy": TURNS[i % 2]})
            )
    return scene("tree32", bodies=bodies, joints=joints)
