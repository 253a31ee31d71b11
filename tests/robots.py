"""Robot files of the package example-robot-data, and the same robots in Pinocchio, joint by joint."""

from __future__ import annotations

import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from symdyn.errors import DerivationError
from symdyn.runtime import lambdify
from symdyn.scene import Quantity, Scene
from symdyn.scene.formats.placing import printable_names

FOLDER = "cmeel.prefix/share/example-robot-data/robots"

NUMBERS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def robot_folder() -> Path | None:
    """Return where the installed package keeps its robots, None where it is not installed."""
    return next((Path(entry) / FOLDER for entry in sys.path if (Path(entry) / FOLDER).is_dir()), None)


def robot_files() -> list[Path]:
    """Return its URDF files, and the ones that xacro has yet to make URDF of."""
    folder = robot_folder()
    return [] if folder is None else sorted(folder.rglob("*.urdf*"))


class Peer:
    """One robot as Pinocchio reads it, driven by our coordinates.

    Pinocchio sorts joints its own way and keeps a continuous joint as cos and sin. A joint that follows another one
    (mimic) is a free one to it unless asked otherwise; then q = A q' + b with the rows of A for its joints and the
    columns for our coordinates, and M' = Aᵀ M A, tau' = Aᵀ tau. Its recursions leave damping out; here it is added.
    """

    def __init__(self, path: Path, scene: Scene, mimic: bool = False) -> None:
        import pinocchio

        self.pin = pinocchio
        self.independent = not any(joint.coupling for joint in scene.joints)
        self.model = pinocchio.buildModelFromUrdf(str(path), mimic)
        self.data = self.model.createData()
        names = [element.attrib["name"] for element in ElementTree.parse(path).getroot().findall("joint")]
        original = {better: name for name, better in printable_names(names, "joint").items()}
        columns = {name: k for k, name in enumerate(scene.coordinates)}
        self.A, self.b = np.zeros((self.model.nv, len(columns))), np.zeros(self.model.nv)
        self.places: list[tuple[int, int, int]] = []
        self.damping = np.zeros((len(columns), len(columns)))
        for joint in scene.joints:
            if not joint.moves:
                continue
            ((led, slope),) = joint.coupling.ratios if joint.coupling else ((joint.coordinate, Quantity.ONE),)
            k, ratio = columns[led], float(slope.value)
            self.damping[k, k] += float(joint.damping.value) * ratio**2
            if mimic and joint.coupling:
                continue
            found = self.model.joints[self.model.getJointId(original[joint.name])]
            self.places.append((found.idx_v, found.idx_q, found.nq))
            self.A[found.idx_v, k] = ratio
            self.b[found.idx_v] = number(joint.coupling.offset) if joint.coupling else 0.0
        assert sorted(place[0] for place in self.places) == list(range(self.model.nv))

    def q(self, q: np.ndarray) -> np.ndarray:
        result, positions = np.zeros(self.model.nq), self.A @ q + self.b
        for row, start, nq in self.places:
            x = positions[row]
            result[start : start + nq] = [x] if nq == 1 else [np.cos(x), np.sin(x)]
        return result

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        tau = self.pin.rnea(self.model, self.data, self.q(q), self.A @ qd, self.A @ qdd)
        return self.A.T @ tau + self.damping @ qd

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        M = self.pin.crba(self.model, self.data, self.q(q))
        return self.A.T @ (np.triu(M) + np.triu(M, 1).T) @ self.A

    def forward_dynamics(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        if self.independent:  # aba knows no joint that follows another one
            driving = self.A @ (tau - self.damping @ qd)
            return self.A.T @ self.pin.aba(self.model, self.data, self.q(q), self.A @ qd, driving)
        return np.linalg.solve(self.mass_matrix(q), tau - self.inverse_dynamics(q, qd, np.zeros_like(q)))


class FloatingPeer:
    """The same robot behind Pinocchio's free flyer, whose velocities are ours, and whose quaternion is x, y, z, w.

    The joints come in the order of the robot that stands still, after the six velocities of the base.
    """

    def __init__(self, path: Path, still: Scene) -> None:
        import pinocchio

        self.pin, self.peer = pinocchio, Peer(path, still)
        self.model = pinocchio.buildModelFromUrdf(str(path), pinocchio.JointModelFreeFlyer())
        assert list(self.model.names)[2:] == list(self.peer.model.names)[1:]
        self.data = self.model.createData()
        n = len(still.velocities)
        self.A, self.damping = np.zeros((self.peer.model.nv + 6, n + 6)), np.zeros((n + 6, n + 6))
        self.A[:6, :6], self.A[6:, 6:] = np.eye(6), self.peer.A
        self.damping[6:, 6:] = self.peer.damping
        self.independent = self.peer.independent

    def q(self, q: np.ndarray) -> np.ndarray:
        x, y, z, w, i, j, k = q[:7]
        return np.concatenate([[x, y, z, i, j, k, w], self.peer.q(q[7:])])

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        tau = self.pin.rnea(self.model, self.data, self.q(q), self.A @ qd, self.A @ qdd)
        return self.A.T @ tau + self.damping @ qd

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        M = self.pin.crba(self.model, self.data, self.q(q))
        return self.A.T @ (np.triu(M) + np.triu(M, 1).T) @ self.A

    def forward_dynamics(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        if self.independent:
            driving = self.A @ (tau - self.damping @ qd)
            return self.A.T @ self.pin.aba(self.model, self.data, self.q(q), self.A @ qd, driving)
        bias = self.inverse_dynamics(q, qd, np.zeros_like(qd))
        return np.linalg.solve(self.mass_matrix(q), tau - bias)


def number(quantity: object) -> float:

    return float(quantity.at({}))  # type: ignore[arg-type]


def differences(scene: Scene, peer: Peer | FloatingPeer, states: int = 3, seed: int = 1) -> dict[str, float]:
    """Return the largest differences at random states, relative to the largest entry of what Pinocchio says.

    For forward dynamics this is the difference of the forces that would give the two accelerations, M (q̈ - q̈'),
    relative to the largest force: both solve with M, and no more digits of q̈ are known than its condition leaves. NaN
    where forward dynamics does not exist.
    """
    n, free = len(scene.velocities), any(joint.type == "free" for joint in scene.joints)
    inverse, mass = lambdify(scene, ("inverse_dynamics", "mass_matrix"))
    try:
        forward = lambdify(scene, "forward_dynamics")
    except DerivationError:
        forward = None
    worst = {"inverse_dynamics": 0.0, "mass_matrix": 0.0, "forward_dynamics": 0.0 if forward else float("nan")}
    rng = np.random.default_rng(seed)
    for _ in range(states):
        q, qd, qdd = rng.uniform(-2, 2, (3, n))
        if free:  # one more coordinate, and a quaternion of length one
            q = np.append(q, rng.uniform(-2, 2))
            q[3:7] /= np.linalg.norm(q[3:7])
        tau, M = peer.inverse_dynamics(q, qd, qdd), peer.mass_matrix(q)
        found = {"inverse_dynamics": relative(inverse(q, qd, qdd), tau), "mass_matrix": relative(mass(q), M)}
        if forward is not None:
            gap = M @ (forward(q, qd, tau) - peer.forward_dynamics(q, qd, tau))
            found["forward_dynamics"] = float(np.max(np.abs(gap)) / np.max(np.abs(tau)))
        worst.update({key: max(worst[key], value) for key, value in found.items()})
    return worst


def relative(ours: np.ndarray, theirs: np.ndarray) -> float:
    return float(np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs)))
