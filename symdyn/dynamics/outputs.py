"""The outputs that a scene has, one row each: what it is, what it takes, and every road that derives it.

One road of a row is preferred, and code is generated from it; the others prove it. A road takes the workspace (and
the name of a body or point for kinematic outputs) and returns the entries of the result, row by row.
"""

from __future__ import annotations

from symdyn.dynamics import kinematics, lagrange, roads
from symdyn.dynamics.coordinate_rates import has_quaternions, rates_of_placements
from symdyn.dynamics.loops.outputs import closing
from symdyn.dynamics.output import Output
from symdyn.dynamics.reactions.outputs import REACTIONS
from symdyn.dynamics.recursive.potential import potential_energy
from symdyn.scene import Scene


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
        {"rnea": roads.inverse, "lagrange": lambda w: lagrange.driving_forces(w.energy)},
    ),
    "forward_dynamics": Output(
        "accelerations qdd that solve M(q) qdd = tau + Q - c(q, qd) - g(q){less_pulls}{motion}",
        ("q", "qd", "tau"),
        "qdd",
        lambda n: (n,),
        "rad/s^2 (revolute) or m/s^2 (prismatic)",
        {"crba": roads.forward_crba, "aba": roads.forward_aba, "lagrange": roads.lagrange_forward},
        prefer=roads.cheaper_forward,
    ),
    "mass_matrix": Output(
        "mass matrix M(q), symmetric, kinetic energy qd.T M qd / 2",
        ("q",),
        "M",
        lambda n: (n, n),
        "kg m^2, kg m or kg",
        {"crba": lambda w: roads.flat(w.composite_mass), "lagrange": lambda w: roads.flat(w.lagrange_mass)},
    ),
    "velocity_forces": Output(
        "Coriolis and centrifugal forces c(q, qd) = C(q, qd) qd",
        ("q", "qd"),
        "c",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"rnea": lambda w: w.velocity_forces(list(w.state.qd)), "lagrange": roads.lagrange_velocity_forces},
    ),
    "gravity_forces": Output(
        "gravity forces g(q) = dP/dq",
        ("q",),
        "g",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"lagrange": lambda w: lagrange.gravity_forces(w.energy), "rnea": lambda w: w.gravity_forces},
        prefer=roads.quicker_gravity,
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
        {"crba": roads.drives_recursive, "lagrange": roads.drives_lagrange},
        exists=_has_motion,
    ),
    "prescribed_motion": Output(
        "position, velocity and acceleration, one row each, of the coordinates whose motion is prescribed, in order",
        (),
        "f",
        lambda n: (3, -1),
        "rad or m, and per s, and per s^2",
        {"formula": roads.motion},
        exists=_has_motion,
    ),
    "coriolis_matrix": Output(
        "Coriolis matrix C(q, qd) of Christoffel symbols, dM/dt - 2 C skew-symmetric",
        ("q", "qd"),
        "C",
        lambda n: (n, n),
        "N m or N per unit of velocity",
        {
            "crba": lambda w: roads.flat(w.composite_christoffel.coriolis_matrix(w.state.qd)),
            "rnea": roads.polarised_matrix,
            "lagrange": lambda w: roads.flat(w.lagrange_christoffel.coriolis_matrix(w.state.qd)),
        },
    ),
    "momentum": Output(
        "generalized momentum p = M(q) qd",
        ("q", "qd"),
        "p",
        lambda n: (n,),
        "kg m^2/s or kg m/s",
        {"rnea": lambda w: w.momentum, "lagrange": lambda w: lagrange.momenta(w.energy)},
    ),
    "kinetic_energy": Output(
        "kinetic energy K(q, qd)",
        ("q", "qd"),
        "K",
        lambda n: (),
        "J",
        {"rnea": roads.kinetic, "lagrange": lambda w: [w.energy.K]},
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
        {"crba": lambda w: roads.flat(w.composite_mass), "lagrange": lambda w: roads.flat(w.lagrange_mass)},
    ),
    "k_C": Output(
        "Coriolis coefficients k_C of qd_j qd_k, columns are the pairs j < k in lexicographic order",
        ("q",),
        "k_C",
        lambda n: (n, n * (n - 1) // 2),
        "N m or N per unit of velocity squared",
        {
            "crba": lambda w: roads.flat(w.composite_christoffel.coriolis()),
            "rnea": roads.polarised_coriolis,
            "lagrange": lambda w: roads.flat(w.lagrange_christoffel.coriolis()),
        },
    ),
    "k_D": Output(
        "centrifugal coefficients k_D of qd_j^2",
        ("q",),
        "k_D",
        lambda n: (n, n),
        "N m or N per unit of velocity squared",
        {
            "crba": lambda w: roads.flat(w.composite_christoffel.centrifugal()),
            "rnea": roads.polarised_centrifugal,
            "lagrange": lambda w: roads.flat(w.lagrange_christoffel.centrifugal()),
        },
    ),
    "k_G": Output(
        "gravity coefficients k_G, which is g(q)",
        ("q",),
        "k_G",
        lambda n: (n,),
        "N m (revolute) or N (prismatic)",
        {"lagrange": lambda w: lagrange.gravity_forces(w.energy), "rnea": lambda w: w.gravity_forces},
        prefer=roads.quicker_gravity,
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
