"""The outputs that a scene has, one row each: what it is, what it takes, and every road that derives it.

One road of a row is preferred, and code is generated from it; the others prove it. A road takes the workspace (and
the name of a body or point for kinematic outputs) and returns the entries of the result, row by row.
"""

from __future__ import annotations

from itertools import combinations

from symdyn.dynamics import kinematics, lagrange
from symdyn.dynamics.coordinate_rates import has_quaternions, rates_of_placements
from symdyn.dynamics.cost import cost
from symdyn.dynamics.loops.outputs import closing
from symdyn.dynamics.output import Output
from symdyn.dynamics.prescribed import accelerations
from symdyn.dynamics.reactions.outputs import REACTIONS
from symdyn.dynamics.recursive.aba import aba
from symdyn.dynamics.recursive.ldl import solve
from symdyn.dynamics.recursive.potential import potential_energy
from symdyn.dynamics.recursive.rnea import rnea
from symdyn.dynamics.workspace import Matrix, Workspace
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene


def _flat(matrix: Matrix) -> list[Expr]:
    return [entry for row in matrix for entry in row]


def _minus(a: list[Expr], b: list[Expr]) -> list[Expr]:
    return [x - y for x, y in zip(a, b, strict=True)]


# Recursive roads


def _inverse(w: Workspace) -> list[Expr]:
    return w.forces(list(w.state.qdd))


def _forward_aba(w: Workspace) -> list[Expr]:
    given = zip(w.state.tau, w.pushes, w.elastic.forces, strict=True)
    return aba(w.lean, w.state.qd, [tau + force - pull for tau, force, pull in given], w.loads)


def _forward_crba(w: Workspace) -> list[Expr]:
    given = w.prescribed
    if given.place:
        parents = w.tree.velocity_parents(given.free)
        return accelerations(given, parents, w.composite_mass, w.state.tau, w.forces(given.entered(w.still)))
    bias = rnea(w.lean, w.state.qd, w.still, acting=w.loads)
    known = zip(w.state.tau, w.pushes, bias, w.elastic.forces, strict=True)
    rest = [tau + force - load - pull for tau, force, load, pull in known]
    return solve(w.tree.velocity_parents(), w.composite_mass, rest)


def _drives_recursive(w: Workspace) -> list[Expr]:
    if not w.prescribed.place:
        return list(w.state.tau)
    forces = w.forces(_forward_crba(w))
    return [forces[k] if k in w.prescribed.place else tau for k, tau in enumerate(w.state.tau)]


SURE = (1.5, 5.5)
"""Pairs of a joint and an ancestor, a joint: up to the first CRBA is cheaper, from the second on ABA."""


def _cheaper_forward(w: Workspace) -> str:
    """Return "aba" for long chains: factoring M costs a term for every pair of a joint and an ancestor, ABA does not.

    The counts cross at 1.5 pairs a joint for parallel axes and at 5 for crossed ones; in between both are counted.
    """
    if w.lean.coupled or w.prescribed.place:
        return "crba"
    depth = [0]
    for i in w.lean.outward():
        depth.append(depth[w.lean.parent[i]] + 1)
    pairs = (sum(depth) - w.lean.n) / max(1, w.lean.n)
    if not SURE[0] < pairs < SURE[1]:
        return "aba" if pairs >= SURE[1] else "crba"
    varying = (*w.state.q, *w.state.qd, *w.state.tau)
    return "aba" if cost(_forward_aba(w), varying) < cost(_forward_crba(w), varying) else "crba"


def _momentum(w: Workspace) -> list[Expr]:
    return rnea(w.lean, w.still, w.state.qd, gravity=False)


def _kinetic(w: Workspace) -> list[Expr]:
    total = w.graph.total(p * qd for p, qd in zip(_momentum(w), w.state.qd, strict=True))
    return [total / 2]


def _unit(w: Workspace, *moving: int) -> list[Expr]:
    return [w.graph.one if i in moving else w.graph.zero for i in range(w.state.n)]


def _polarised_centrifugal(w: Workspace) -> list[Expr]:
    """Return k_D from c(q, q̇): column j is c at q̇ = e_j."""
    columns = [w.velocity_forces(_unit(w, j)) for j in range(w.state.n)]
    return [column[i] for i in range(w.state.n) for column in columns]


def _polarised_coriolis(w: Workspace) -> list[Expr]:
    """Return k_C from c(q, q̇): column jk is c(e_j + e_k) - c(e_j) - c(e_k)."""
    alone = [w.velocity_forces(_unit(w, j)) for j in range(w.state.n)]
    columns = [
        _minus(_minus(w.velocity_forces(_unit(w, j, k)), alone[j]), alone[k])
        for j, k in combinations(range(w.state.n), 2)
    ]
    return [column[i] for i in range(w.state.n) for column in columns]


def _polarised_matrix(w: Workspace) -> list[Expr]:
    """Return C(q, u) from k_D and k_C: C_ij = k_D[i,j] u_j + ½ Σ_k≠j k_C[i,jk] u_k + ½ Σ_kl γ^l_kj M_li u_k."""
    n = range(w.state.n)
    pairs = {pair: position for position, pair in enumerate(combinations(n, 2))}
    k_D, k_C = _polarised_centrifugal(w), _polarised_coriolis(w)
    entries = []
    for i in n:
        for j in n:
            mixed = (k_C[i * len(pairs) + pairs[min(j, k), max(j, k)]] * w.state.qd[k] for k in n if k != j)
            turned = (
                w.state.qd[k] * w.composite_mass[m][i] * value
                for k in n
                for m, value in w.directions.brackets.get((k, j), ())
            )
            half = (w.graph.total(mixed) + w.graph.total(turned)) / 2
            entries.append(k_D[i * w.state.n + j] * w.state.qd[j] + half)
    return entries


# Lagrange roads


def _lagrange_forward(w: Workspace) -> list[Expr]:
    given = w.prescribed
    alone = dict(zip(w.state.qdd, given.entered(w.still), strict=True))
    bias = substitute(lagrange.driving_forces(w.energy), alone)
    chain = range(-1, len(given.free))
    if given.place:
        return accelerations(given, chain, w.lagrange_mass, w.state.tau, bias)
    return solve(chain, w.lagrange_mass, _minus(list(w.state.tau), bias))


def _drives_lagrange(w: Workspace) -> list[Expr]:
    if not w.prescribed.place:
        return list(w.state.tau)
    moving = dict(zip(w.state.qdd, _lagrange_forward(w), strict=True))
    forces = substitute(lagrange.driving_forces(w.energy), moving)
    return [forces[k] if k in w.prescribed.place else tau for k, tau in enumerate(w.state.tau)]


def _motion(w: Workspace) -> list[Expr]:
    return [*w.prescribed.position, *w.prescribed.velocity, *w.prescribed.acceleration]


def _lagrange_velocity_forces(w: Workspace) -> list[Expr]:
    C = w.lagrange_christoffel.coriolis_matrix(w.state.qd)
    return [w.graph.total(c * qd for c, qd in zip(row, w.state.qd, strict=True)) for row in C]


def _has_springs(scene: Scene) -> bool:
    return bool(scene.springs)


def _has_motion(scene: Scene) -> bool:
    return any(joint.motion is not None for joint in scene.joints)


OUTPUTS: dict[str, Output] = {
    "inverse_dynamics": Output(
        "driving forces tau = M(q) qdd + c(q, qd) + g(q){pulls} - Q",
        ("q", "qd", "qdd"),
        "tau",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"rnea": _inverse, "lagrange": lambda w: lagrange.driving_forces(w.energy)},
    ),
    "forward_dynamics": Output(
        "accelerations qdd that solve M(q) qdd = tau + Q - c(q, qd) - g(q){less_pulls}{motion}",
        ("q", "qd", "tau"),
        "qdd",
        lambda n: (n,),
        "rad/s^2 (revolute) or m/s^2 (prismatic)",
        {"crba": _forward_crba, "aba": _forward_aba, "lagrange": _lagrange_forward},
        prefer=_cheaper_forward,
    ),
    "mass_matrix": Output(
        "mass matrix M(q), symmetric, kinetic energy qd.T M qd / 2",
        ("q",),
        "M",
        lambda n: (n, n),
        "kg m^2, kg m or kg",
        {"crba": lambda w: _flat(w.composite_mass), "lagrange": lambda w: _flat(w.lagrange_mass)},
    ),
    "velocity_forces": Output(
        "Coriolis and centrifugal forces c(q, qd) = C(q, qd) qd",
        ("q", "qd"),
        "c",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"rnea": lambda w: w.velocity_forces(list(w.state.qd)), "lagrange": _lagrange_velocity_forces},
    ),
    "gravity_forces": Output(
        "gravity forces g(q) = dP/dq",
        ("q",),
        "g",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"lagrange": lambda w: lagrange.gravity_forces(w.energy), "rnea": lambda w: rnea(w.lean, w.still, w.still)},
    ),
    "elastic_forces": Output(
        "elastic forces of springs, dE/dq",
        ("q",),
        "k_E",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"recursive": lambda w: w.elastic.forces, "lagrange": lambda w: lagrange.elastic_forces(w.energy)},
        exists=_has_springs,
    ),
    "drive_forces": Output(
        "driving forces during forward dynamics: what prescribed motions take, tau elsewhere",
        ("q", "qd", "tau"),
        "tau",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"crba": _drives_recursive, "lagrange": _drives_lagrange},
        exists=_has_motion,
    ),
    "prescribed_motion": Output(
        "position, velocity and acceleration, one row each, of the coordinates whose motion is prescribed, in order",
        (),
        "f",
        lambda n: (3, -1),
        "rad or m, and per s, and per s^2",
        {"formula": _motion},
        exists=_has_motion,
    ),
    "coriolis_matrix": Output(
        "Coriolis matrix C(q, qd) of Christoffel symbols, dM/dt - 2 C skew-symmetric",
        ("q", "qd"),
        "C",
        lambda n: (n, n),
        "N m or N per unit of velocity",
        {
            "crba": lambda w: _flat(w.composite_christoffel.coriolis_matrix(w.state.qd)),
            "rnea": _polarised_matrix,
            "lagrange": lambda w: _flat(w.lagrange_christoffel.coriolis_matrix(w.state.qd)),
        },
    ),
    "momentum": Output(
        "generalized momentum p = M(q) qd",
        ("q", "qd"),
        "p",
        lambda n: (n,),
        "kg m^2/s or kg m/s",
        {"rnea": _momentum, "lagrange": lambda w: lagrange.momenta(w.energy)},
    ),
    "kinetic_energy": Output(
        "kinetic energy K(q, qd)",
        ("q", "qd"),
        "K",
        lambda n: (),
        "J",
        {"rnea": _kinetic, "lagrange": lambda w: [w.energy.K]},
    ),
    "potential_energy": Output(
        "potential energy P(q) = -sum m g.r, zero at the origin of the ground frame{stored}",
        ("q",),
        "P",
        lambda n: (),
        "J",
        {
            "recursive": lambda w: [potential_energy(w.lean) + w.elastic.energy],
            "lagrange": lambda w: [w.energy.P],
        },
    ),
    "k_z": Output(
        "inertia coefficients k_z of qdd_j, which is M(q)",
        ("q",),
        "k_z",
        lambda n: (n, n),
        "kg m^2, kg m or kg",
        {"crba": lambda w: _flat(w.composite_mass), "lagrange": lambda w: _flat(w.lagrange_mass)},
    ),
    "k_C": Output(
        "Coriolis coefficients k_C of qd_j qd_k, columns are the pairs j < k in lexicographic order",
        ("q",),
        "k_C",
        lambda n: (n, n * (n - 1) // 2),
        "N m or N per unit of velocity squared",
        {
            "crba": lambda w: _flat(w.composite_christoffel.coriolis()),
            "rnea": _polarised_coriolis,
            "lagrange": lambda w: _flat(w.lagrange_christoffel.coriolis()),
        },
    ),
    "k_D": Output(
        "centrifugal coefficients k_D of qd_j^2",
        ("q",),
        "k_D",
        lambda n: (n, n),
        "N m or N per unit of velocity squared",
        {
            "crba": lambda w: _flat(w.composite_christoffel.centrifugal()),
            "rnea": _polarised_centrifugal,
            "lagrange": lambda w: _flat(w.lagrange_christoffel.centrifugal()),
        },
    ),
    "k_G": Output(
        "gravity coefficients k_G, which is g(q)",
        ("q",),
        "k_G",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"lagrange": lambda w: lagrange.gravity_forces(w.energy), "rnea": lambda w: rnea(w.lean, w.still, w.still)},
    ),
    "k_E": Output(
        "elastic coefficients k_E of springs",
        ("q",),
        "k_E",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"recursive": lambda w: w.elastic.forces, "lagrange": lambda w: lagrange.elastic_forces(w.energy)},
        exists=_has_springs,
    ),
    "coordinate_rates": Output(
        "rates qdot = H(q) qd of the coordinates; qd itself but for quaternions and positions of free joints",
        ("q", "qd"),
        "qdot",
        lambda n: (-1,),
        "rad/s, m/s, or 1/s for a quaternion",
        {"joints": lambda w: list(w.state.rates), "placements": lambda w: rates_of_placements(w.scene, w.graph)},
        exists=has_quaternions,
    ),
    "pose": Output(
        "placement [R | p] of {name} in the ground frame",
        ("q",),
        "T",
        lambda n: (3, 4),
        "1 and m",
        {
            "recursive": lambda w, name: kinematics.pose(kinematics.tree_placed(w.scene, w.tree, name)),
            "positions": lambda w, name: kinematics.pose(kinematics.placed(w.scene, name, w.graph)),
        },
        place="point",
    ),
    "jacobian": Output(
        "Jacobian J of {name}: [velocity of its origin; angular velocity] = J qd, ground frame",
        ("q",),
        "J",
        lambda n: (6, n),
        "m or 1, and 1",
        {
            "recursive": lambda w, name: kinematics.jacobian(w.scene, w.tree, name),
            "differentiation": lambda w, name: kinematics.differentiated_jacobian(w.scene, name, w.graph),
        },
        place="point",
    ),
    "jdot_qdot": Output(
        "velocity product Jdot qd of {name}: its [acceleration; angular acceleration] at qdd = 0, ground frame",
        ("q", "qd"),
        "a",
        lambda n: (6,),
        "m/s^2 and rad/s^2",
        {
            "recursive": lambda w, name: kinematics.velocity_product(w.scene, w.tree, name, w.state.qd),
            "differentiation": lambda w, name: kinematics.differentiated_velocity_product(w.scene, name, w.graph),
        },
        place="point",
    ),
    "com_acceleration": Output(
        "acceleration of the centre of mass of {name}, ground frame, without gravity",
        ("q", "qd", "qdd"),
        "a",
        lambda n: (3,),
        "m/s^2",
        {
            "recursive": lambda w, name: kinematics.acceleration(w.scene, w.tree, name, w.state.qd, w.state.qdd),
            "differentiation": lambda w, name: kinematics.differentiated_acceleration(w.scene, name, w.graph),
        },
        place="body",
    ),
}

OUTPUTS |= closing(OUTPUTS) | REACTIONS
