"""Logs of arms as a robot would write them, from equations: exciting motion, friction, encoders, noisy torques.

    q_i(t) = q_0 + Σ_k a_ik sin(k ω t) + b_ik cos(k ω t)      one period of ten seconds, five harmonics

Its derivatives are exact, and so are the forces before noise is added, so that the truth is known to all digits. What a
seed draws: the noise of the torques, and where the marks of each encoder stand. Motions are those with the best
condition number of some that one fixed seed draws; nothing is picked by what identification makes of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

import symdyn
from symdyn.identification import Identification, Payload, identify
from symdyn.identification.linear_model import LinearModel, linear_model, with_terms
from symdyn.scene import Scene, bind, body, revolute, scene, spring
from symdyn.scene.symbolic import INERTIAL
from symdyn.scene.values import acceleration_name
from symdyn.simulation.prescribed.forces import drive_names

Array = npt.NDArray[np.float64]

HARMONICS, PERIOD = 5, 10.0
TERMS = ("viscous", "coulomb")


@dataclass(frozen=True)
class Arm:
    """An arm with friction, and how it is measured.

    Attributes:
        name: of the example.
        amplitude: of a joint's motion, rad, about.
        viscous, coulomb: friction of each joint, N m s/rad and N m.
        step: of the encoders, rad at the joint.
        noise: of the torques, standard deviation of each, N m.
        rate: samples a second.
        values: of parameters that have none.
        tries: motions that are drawn.
    """

    name: str
    amplitude: float
    viscous: tuple[float, ...]
    coulomb: tuple[float, ...]
    step: float
    noise: tuple[float, ...]
    rate: float = 200.0
    values: Mapping[str, float] | None = None
    tries: int = 30

    @cached_property
    def scene(self) -> Scene:
        """What identification is given: no friction is declared."""
        found = symdyn.example(self.name)
        return bind(found, self.values) if self.values else found

    @cached_property
    def true(self) -> Scene:
        """The arm with its friction."""
        open_terms = with_terms(self.scene, TERMS)
        drawn = dict(zip(_letters(open_terms, "fv"), self.viscous, strict=True))
        drawn |= dict(zip(_letters(open_terms, "fc"), self.coulomb, strict=True))
        return bind(open_terms, drawn)

    @cached_property
    def model(self) -> LinearModel:
        """The true arm as base parameters."""
        return linear_model(self.true)

    @property
    def truth(self) -> dict[str, float]:
        """Base parameters by name."""
        return dict(zip(self.model.names, self.model.prior.tolist(), strict=True))

    @cached_property
    def motion(self) -> tuple[Array, Array, Array, Array]:
        """Times, positions, velocities, accelerations of the best motion that was drawn."""
        draw = np.random.default_rng(2017)
        best, found = np.inf, None
        for _ in range(self.tries):
            one = self.fourier(draw)
            Y = np.vstack(list(self.model.regressor(*(x[:: max(1, len(x) // 200)] for x in one[1:]))))
            size = np.linalg.norm(Y, axis=0)
            condition = np.linalg.cond(Y / size) if np.all(size > 0) else np.inf
            if condition < best:
                best, found = condition, one
        assert found is not None
        return found

    def fourier(self, draw: np.random.Generator) -> tuple[Array, Array, Array, Array]:
        """Return one motion."""
        n = len(self.scene.coordinates)
        t = np.arange(0.0, PERIOD, 1 / self.rate)
        k = np.arange(1, HARMONICS + 1)
        w = 2 * np.pi * k / PERIOD
        a, b = draw.normal(size=(2, HARMONICS, n)) * self.amplitude / k[:, None] ** 0.5
        centre = draw.uniform(-1, 1, n)
        s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        return (
            t,
            centre + s @ a + c @ b,
            (c * w) @ a - (s * w) @ b,
            -(s * w**2) @ a - (c * w**2) @ b,
        )

    @cached_property
    def forces(self) -> Array:
        """Of the drives, without noise, shape (N, n)."""
        _, q, qd, qdd = self.motion
        return np.asarray(self.model.regressor(q, qd, qdd) @ self.model.prior)

    def log(self, seed: int) -> dict[str, Array]:
        """Return a log by column: t, coordinates as encoders count them, torques as they are measured."""
        draw = np.random.default_rng(seed)
        t, q, _, _ = self.motion
        marks = draw.uniform(0, self.step, q.shape[1])
        seen = self.step * np.round((q + marks) / self.step) - marks
        tau = self.forces + draw.normal(size=self.forces.shape) * np.array(self.noise)
        columns = {"t": t} | dict(zip(self.scene.coordinates, seen.T, strict=True))
        return columns | dict(zip(drive_names(self.scene), tau.T, strict=True))


def _letters(scene: Scene, letter: str) -> list[str]:
    return [p.name for p in scene.parameters if p.name.startswith(letter) and p.name[2:].isdigit()]


TURN = 2 * np.pi

ARMS: dict[str, Arm] = {
    "two_link": Arm(
        "two_link", 0.5, (0.4, 0.2), (0.8, 0.4), TURN / 2**16, (0.2, 0.1),
        values={"m1": 2.0, "m2": 1.0, "h1": 0.5, "h2": 0.4, "g": 9.81},
    ),
    "puma560": Arm(
        "puma560", 0.5, (4.0, 3.5, 3.5, 0.15, 0.12, 0.08), (6.0, 7.0, 5.0, 0.5, 0.4, 0.35), 1e-4,
        (1.0, 1.0, 0.6, 0.1, 0.1, 0.1),
    ),
    "arm7": Arm(
        "arm7", 0.5, (0.5, 0.5, 0.4, 0.4, 0.3, 0.3, 0.2), (1.0, 1.0, 0.8, 0.8, 0.5, 0.5, 0.3), TURN / 2**17,
        (0.5, 0.5, 0.3, 0.3, 0.15, 0.15, 0.1),
    ),
}  # fmt: skip
"""Friction and noise are of the size that drives of such arms have; none of it was measured."""


@dataclass(frozen=True)
class Coverage:
    """How often intervals held the truth.

    Attributes:
        arm: its name.
        names: of base parameters.
        seeds: how many.
        held: seeds whose 95 % interval holds the truth, by parameter.
        joint: seeds whose 95 % ellipsoid does.
        ratio: root mean square of errors over standard errors.
    """

    arm: str
    names: tuple[str, ...]
    seeds: int
    held: npt.NDArray[np.int64]
    joint: int
    ratio: float


def coverage(arm: Arm, seeds: int) -> Coverage:
    """Return how often the intervals of seeds 0, 1, 2, ... hold the truth; what data do not tell counts as missed."""
    return _counted(arm.name, arm.truth, [identify(arm.scene, arm.log(seed), friction=TERMS) for seed in range(seeds)])


def _counted(name: str, true: Mapping[str, float], found: Sequence[Identification]) -> Coverage:
    names = found[0].names
    truth = np.array([true[one] for one in names])
    held, joint, ratios = np.zeros(len(names), np.int64), 0, []
    for one in found:
        low, high = one.interval(0.95).T
        held += (low <= truth) & (truth <= high)
        off = one.after - truth
        joint += bool(off @ one.regression.information @ off <= one.regression.reach(0.95))
        ratios.append(off / one.errors)
    return Coverage(name, names, len(found), held, joint, float(np.sqrt(np.mean(np.square(ratios)))))


@dataclass(frozen=True)
class Driven:
    """An arm whose drives show currents, measured without and with a payload on its last body.

    Attributes:
        arm: without it.
        gains: N m/A.
        load: the payload, all of it.
        given: what identification is told of it.
    """

    arm: Arm
    gains: tuple[float, ...]
    load: Payload
    given: Payload

    @property
    def units(self) -> dict[str, str]:
        """Every drive is in A."""
        return dict.fromkeys(drive_names(self.arm.scene), "A")

    @cached_property
    def truth(self) -> dict[str, float]:
        """Base parameters, the payload's ten and gains by the names that identification gives."""
        found = self.arm.truth | {f"gain {name}": k for name, k in zip(self.units, self.gains, strict=True)}
        return found | {f"payload {one}": x for (one, _, _), x in zip(INERTIAL, self.load.ten.tolist(), strict=True)}

    @cached_property
    def forces(self) -> tuple[Array, Array]:
        """Without and with the payload, without noise, shape (N, n)."""
        _, q, qd, qdd = self.arm.motion
        return self.arm.forces, self.arm.forces + self.arm.model.ten(q, qd, qdd)[:, :, -10:] @ self.load.ten

    def logs(self, seed: int) -> list[dict[str, Array]]:
        """Return both logs, as those of `Arm.log`, with noise of their own."""
        found = []
        for k, force in enumerate(self.forces):
            log = self.arm.log(2 * seed + k)
            noisy = [log[name] for name in self.units] + (force - self.arm.forces).T
            found.append(log | dict(zip(self.units, (noisy.T / np.array(self.gains)).T, strict=True)))
        return found

    def exact(self) -> list[dict[str, Array]]:
        """Return both logs without noise, velocities and accelerations among the columns."""
        scene, (t, *motion) = self.arm.scene, self.arm.motion
        rates = [acceleration_name(name) for name in scene.velocities]
        names = (*scene.coordinates, *scene.velocities, *rates)
        columns = {"t": t} | dict(zip(names, np.concatenate(motion, axis=1).T, strict=True))
        return [columns | dict(zip(self.units, (f / np.array(self.gains)).T, strict=True)) for f in self.forces]


DRIVEN: dict[str, Driven] = {
    "two_link": Driven(
        ARMS["two_link"], (0.65, 2.0),
        Payload("link2", 2.0, (0.1, 0.02, 0.0), (0.01, 0.012, 0.008), 1), Payload("link2", 2.0, log=1),
    ),
    "puma560": Driven(
        ARMS["puma560"], (0.65, 0.8, 1.43, 1.4, 2.21, 2.0),
        Payload("link6", 2.0, (0.03, -0.02, 0.08), (0.01, 0.012, 0.008), 1), Payload("link6", 2.0, log=1),
    ),
}  # fmt: skip
"""Of the payload nothing but its mass is told."""


def coverage_of_gains(driven: Driven, seeds: int) -> Coverage:
    """Return how often intervals of seeds hold the truth: of base parameters, the payload's and gains."""
    found = [
        identify(driven.arm.scene, driven.logs(seed), friction=TERMS, units=driven.units, payloads=driven.given)
        for seed in range(seeds)
    ]
    return _counted(driven.arm.name, driven.truth, found)


@dataclass(frozen=True)
class Forced:
    """A mechanism that known forces move for ten seconds, 200 samples a second: a simulated run.

    Attributes:
        name: of it.
        scene: with its true values.
        forces, start: of the run.
    """

    name: str
    scene: Scene
    forces: Mapping[str, str]
    start: Mapping[str, float]

    @cached_property
    def run(self) -> symdyn.Trajectory:
        """Without noise."""
        return symdyn.simulate(self.scene, forces=dict(self.forces), start=dict(self.start), until=10, every=0.005)

    def log(self, seed: int, noise: float, force_noise: float) -> dict[str, Array]:
        """Return a log with white noise of positions, rad and m, and of forces, N m and N."""
        draw, run = np.random.default_rng(seed), self.run
        found = {"t": run.t}
        for names, size in ((self.scene.coordinates, noise), (tuple(self.forces), force_noise)):
            found |= {name: run[name] + size * draw.normal(size=len(run.t)) for name in names}
        return found


def _sprung_arm() -> Scene:
    """Return an arm of two links in a vertical plane, held by a spring."""
    return scene(
        "sprung_arm",
        gravity=[0, 0, -9.81],
        parameters={"k": 120, "c": 0.3},
        bodies=[
            body("upper", mass=2, com=[0.2, 0, 0], inertia=[0, 0.03, 0.03], about="com"),
            body("fore", mass=1.5, com=[0.15, 0, 0], inertia=[0, 0.012, 0.012], about="com"),
        ],
        joints=[
            revolute("shoulder", "ground", "upper", axis=[0, -1, 0], coordinate="q1", damping="c"),
            revolute("elbow", "upper", "fore", axis=[0, -1, 0], origin=[0.4, 0, 0], coordinate="q2", damping="c"),
        ],
        springs=[
            spring(
                "balance",
                ends=({"body": "ground", "at": [0, 0, 0.5]}, {"body": "fore", "at": [0.15, 0, 0]}),
                stiffness="k",
                free=0.2,
            ),
        ],
    )


FORCED: dict[str, Forced] = {
    "sprung_arm": Forced(
        "sprung_arm", _sprung_arm(), {"tau1": "2*sin(3*t)+1.5*cos(7*t)", "tau2": "sin(5*t)"}, {"q1": -1.05, "q2": 0.52}
    ),
    "pendulum": Forced("pendulum", symdyn.example("pendulum"), {"tau1": "3*sin(3*t)+2*cos(t)"}, {"q1": 0.1}),
    "cart_pole": Forced("cart_pole", symdyn.example("cart_pole"), {"F": "6*sin(4*t)+4*cos(9*t)"}, {"theta": 3.0}),
}
"""Motions of several Hz, far below half the rate of the samples: wide bands are full of noise."""


def coverage_of_noise(
    forced: Forced, noise: float, force_noise: float, seeds: int, band: float | None = None
) -> Coverage:
    """Return how often intervals of seeds hold the truth, with so much white noise of positions and forces."""
    model = linear_model(forced.scene)
    truth = dict(zip(model.names, model.prior.tolist(), strict=True))
    logs = [forced.log(seed, noise, force_noise) for seed in range(seeds)]
    return _counted(forced.name, truth, [identify(forced.scene, log, band) for log in logs])
