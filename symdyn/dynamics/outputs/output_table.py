"""The outputs that a scene has, one row each: what it is, what it takes, and every formulation that derives it.

One formulation of a row is preferred, and code is generated from it; the others prove it. A formulation takes the
workspace (and the name of a body or point for kinematic outputs) and returns the entries of the result, row by row.

The outputs about the centre of mass of the whole scene: rows of OUTPUTS that it has when it is asked for them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from symdyn.dynamics.mechanism import centroidal, kinematics
from symdyn.dynamics.mechanism.kinematics import has_quaternions, rates_of_placements
from symdyn.dynamics.mechanism.state import has_motion
from symdyn.dynamics.outputs import recursive_derivatives, result_labels as labels, tree_formulations as formulations
from symdyn.dynamics.outputs.arm_outputs import ARMS
from symdyn.dynamics.outputs.canonical_outputs import CANONICAL
from symdyn.dynamics.outputs.configuration_outputs import CONFIGURATIONS
from symdyn.dynamics.outputs.constrained_outputs import (
    CONSTRAINED_DRIVES,
    CONSTRAINED_FORWARD,
    CONSTRAINED_INVERSE,
    OF_LOOPS,
    REACTIONS,
)
from symdyn.dynamics.outputs.contact_outputs import CONTACTS
from symdyn.dynamics.outputs.frame_outputs import MOVING
from symdyn.dynamics.outputs.held_outputs import HELD
from symdyn.dynamics.outputs.linearizing_outputs import LINEARIZING, SHAPING
from symdyn.dynamics.outputs.operator_outputs import OPERATORS
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, Size, by_differentiation, by_lagrange, by_loop
from symdyn.dynamics.outputs.regressor_outputs import PASSIVITY, REGRESSORS
from symdyn.dynamics.outputs.signal_outputs import SIGNALS
from symdyn.dynamics.recursive.reduced_tree import potential_energy
from symdyn.dynamics.recursive.table_loops import aba_loop, rnea_loop
from symdyn.scene.forces import elastic

MOMENTUM = ("px", "py", "pz", "Lx", "Ly", "Lz")
"""Entries of momentum, and of angular momentum about the centre of mass."""

_row = partial(Output, when_constrained="same", default_in="request")

CENTROIDAL: dict[str, Output] = {
    "centre_of_mass": _row(
        "centre of mass C of all bodies that move, ground frame",
        ("q",),
        "C",
        (labels.fixed(*"xyz"),),
        "m",
        formulations={
            "recursive": Formulation(lambda w: list(centroidal.centre(w.scene, w.tree))),
            "positions": by_differentiation(lambda w: list(centroidal.differentiated_centre(w.scene, w.graph))),
        },
    ),
    "centre_of_mass_jacobian": _row(
        "Jacobian J of the centre of mass of all bodies that move: its velocity = J qd, ground frame",
        ("q",),
        "J",
        (labels.fixed("vx", "vy", "vz"), labels.velocities),
        "m or 1",
        formulations={
            "recursive": Formulation(lambda w: centroidal.centre_jacobian(w.scene, w.tree)),
            "differentiation": by_differentiation(
                lambda w: centroidal.differentiated_centre_jacobian(w.scene, w.graph)
            ),
        },
    ),
    "centroidal_momentum_matrix": _row(
        "matrix A of [momentum; angular momentum about the centre of mass] = A qd, ground axes, without rotors",
        ("q",),
        "A",
        (labels.fixed(*MOMENTUM), labels.velocities),
        "kg m or kg, and kg m^2 or kg m",
        formulations={
            "recursive": Formulation(lambda w: centroidal.momentum_matrix(w.scene, w.tree)),
            "differentiation": by_differentiation(
                lambda w: centroidal.differentiated_momentum_matrix(w.scene, w.graph)
            ),
        },
    ),
    "centroidal_momentum_bias": _row(
        "rate Adot qd of [momentum; angular momentum about the centre of mass] at qdd = 0, ground axes, without rotors",
        ("q", "qd"),
        "b",
        (labels.fixed(*MOMENTUM),),
        "N, and N m",
        formulations={
            "recursive": Formulation(lambda w: centroidal.momentum_bias(w.scene, w.tree, w.state)),
            "differentiation": by_differentiation(lambda w: centroidal.differentiated_momentum_bias(w.scene, w.graph)),
        },
    ),
}


VECTOR, SQUARE, PAIRS = (labels.velocities,), (labels.velocities,) * 2, (labels.velocities, labels.pairs)

_MASS = Output(
    "mass matrix M(q), symmetric, kinetic energy qd.T M qd / 2",
    ("q",),
    "M",
    SQUARE,
    "kg m^2, kg m or kg",
    "tree",
    {
        "crba": Formulation(lambda w: formulations.flat(w.composite_mass)),
        "lagrange": by_lagrange(lambda w: formulations.flat(w.lagrange_mass)),
    },
    default_in="overview",
    size=Size((0, 27)),
)
_GRAVITY = Output(
    "gravity forces g(q) = dP/dq",
    ("q",),
    "g",
    VECTOR,
    FORCES,
    "tree",
    {
        "rnea": Formulation(lambda w: w.gravity_forces),
        "lagrange": Formulation(lambda w: w.energy.gravity_forces()),  # never large
    },
    default_in="overview",
    size=Size((70,)),
)
_ELASTIC = Output(
    "elastic forces of springs, dE/dq",
    ("q",),
    "k_E",
    VECTOR,
    FORCES,
    "tree",
    {
        "recursive": Formulation(lambda w: w.elastic.forces),
        "lagrange": by_lagrange(lambda w: w.energy.elastic_forces()),
    },
    exists=lambda scene: bool(elastic(scene)),
)

OUTPUTS: dict[str, Output] = {
    "inverse_dynamics": Output(
        "driving forces tau = M(q) qdd + c(q, qd) + g(q){pulls} - Q",
        ("q", "qd", "qdd"),
        "tau",
        VECTOR,
        FORCES,
        CONSTRAINED_INVERSE,
        {
            "rnea": Formulation(lambda w: w.forces(list(w.state.qdd))),
            "lagrange": by_lagrange(lambda w: w.energy.driving_forces()),
            "kane": by_lagrange(lambda w: w.kane.driving_forces()),
            "rnea_loop": by_loop(rnea_loop),
        },
        default_in="overview",
        may_fail="reported",
        depends=("independent",),
    ),
    "forward_dynamics": Output(
        "accelerations qdd that solve M(q) qdd = tau + Q - c(q, qd) - g(q){less_pulls}{motion}",
        ("q", "qd", "tau"),
        "qdd",
        VECTOR,
        "rad/s^2 (revolute) or m/s^2 (prismatic)",
        CONSTRAINED_FORWARD,
        {
            "crba": Formulation(formulations.forward_crba),
            "aba": Formulation(formulations.forward_aba, trees_only=True),
            "lagrange": by_lagrange(formulations.lagrange_forward),
            "aba_loop": Formulation(formulations.forward_loop, up_to=0, loop=aba_loop),
        },
        default_in="overview",
        may_fail="reported",
        depends=("independent", "alpha", "beta"),
        prefer=formulations.cheaper_forward,
        size=Size((550,)),
        solves=("mass_matrix", "inverse_dynamics"),
    ),
    "mass_matrix": _MASS,
    "velocity_forces": Output(
        "Coriolis and centrifugal forces c(q, qd) = C(q, qd) qd",
        ("q", "qd"),
        "c",
        VECTOR,
        FORCES,
        "tree",
        {
            "rnea": Formulation(lambda w: w.velocity_forces(list(w.state.qd))),
            "lagrange": by_lagrange(formulations.lagrange_velocity_forces),
        },
    ),
    "gravity_forces": _GRAVITY,
    "elastic_forces": _ELASTIC,
    "drive_forces": Output(
        "driving forces during forward dynamics: what prescribed motions take, tau elsewhere",
        ("q", "qd", "tau"),
        "tau",
        VECTOR,
        FORCES,
        CONSTRAINED_DRIVES,
        {"crba": Formulation(formulations.drives_recursive), "lagrange": by_lagrange(formulations.drives_lagrange)},
        exists=has_motion,
        may_fail="reported",
        depends=("independent", "alpha", "beta"),
    ),
    "prescribed_motion": Output(
        "position, velocity and acceleration, one row each, of the coordinates whose motion is prescribed, in order",
        (),
        "f",
        (labels.fixed("position", "velocity", "acceleration"), labels.prescribed),
        "rad or m, and per s, and per s^2",
        "same",
        {
            "formula": Formulation(
                lambda w: [*w.prescribed.position, *w.prescribed.velocity, *w.prescribed.acceleration]
            )
        },
        exists=has_motion,
    ),
    "coriolis_matrix": Output(
        "Coriolis matrix C(q, qd) of Christoffel symbols, dM/dt - 2 C skew-symmetric",
        ("q", "qd"),
        "C",
        SQUARE,
        "N m or N per unit of velocity",
        "tree",
        {
            "crba": Formulation(formulations.christoffel_matrix),
            "rnea": Formulation(formulations.polarised_matrix),
            "derivatives": Formulation(recursive_derivatives.coriolis_matrix),
            "lagrange": by_lagrange(lambda w: formulations.flat(w.lagrange_christoffel.coriolis_matrix(w.state.qd))),
        },
        default_in="generate",
        cubic=True,
        prefer=formulations.cheaper_coriolis,
        size=Size((0, 83)),
    ),
    "momentum": Output(
        "generalized momentum p = M(q) qd",
        ("q", "qd"),
        "p",
        VECTOR,
        "kg m^2/s or kg m/s",
        "same",
        {"rnea": Formulation(lambda w: w.momentum), "lagrange": by_lagrange(lambda w: w.energy.momenta())},
    ),
    "kinetic_energy": Output(
        "kinetic energy K(q, qd)",
        ("q", "qd"),
        "K",
        (),
        "J",
        "same",
        {
            "rnea": Formulation(lambda w: [w.graph.dot(w.momentum, w.state.qd) / 2]),
            "lagrange": Formulation(lambda w: [w.energy.K]),
        },
    ),
    "potential_energy": Output(
        "potential energy P(q) = -sum m g.r, zero at the origin of the ground frame{stored}",
        ("q",),
        "P",
        (),
        "J",
        "same",
        {
            "recursive": Formulation(lambda w: [potential_energy(w.reduced) + w.elastic.energy]),
            "lagrange": Formulation(lambda w: [w.energy.P]),
        },
        size=Size((42,)),
    ),
    "k_z": replace(_MASS, text="inertia coefficients k_z of qdd_j, which is M(q)", result="k_z", default_in="generate"),
    "k_C": Output(
        "Coriolis coefficients k_C of qd_j qd_k, columns are the pairs j < k in lexicographic order",
        ("q",),
        "k_C",
        PAIRS,
        "N m or N per unit of velocity squared",
        "tree",
        {
            "crba": Formulation(lambda w: formulations.flat(w.composite_christoffel.coriolis())),
            "rnea": Formulation(formulations.polarised_coriolis),
            "lagrange": by_lagrange(lambda w: formulations.flat(w.lagrange_christoffel.coriolis())),
        },
        default_in="generate",
        cubic=True,
        size=Size((0, 0, 13)),
    ),
    "k_D": Output(
        "centrifugal coefficients k_D of qd_j^2",
        ("q",),
        "k_D",
        SQUARE,
        "N m or N per unit of velocity squared",
        "tree",
        {
            "crba": Formulation(lambda w: formulations.flat(w.composite_christoffel.centrifugal())),
            "rnea": Formulation(formulations.polarised_centrifugal),
            "lagrange": by_lagrange(lambda w: formulations.flat(w.lagrange_christoffel.centrifugal())),
        },
        default_in="generate",
        cubic=True,
        prefer=formulations.shorter_centrifugal,
        size=Size((0, 83)),
    ),
    "k_G": replace(_GRAVITY, text="gravity coefficients k_G, which is g(q)", result="k_G", default_in="generate"),
    "k_E": replace(_ELASTIC, text="elastic coefficients k_E of springs", default_in="generate"),
    "coordinate_rates": Output(
        "rates qdot = H(q) qd of the coordinates; qd itself but for quaternions and positions of free joints",
        ("q", "qd"),
        "qdot",
        (labels.coordinates,),
        "rad/s, m/s, or 1/s for a quaternion",
        "same",
        {
            "joints": Formulation(lambda w: list(w.state.rates)),
            "placements": Formulation(
                lambda w: rates_of_placements(w.scene, w.graph), up_to=0
            ),  # divides by w, never code
        },
        exists=has_quaternions,
    ),
    "pose": Output(
        "placement [R | p] of {name} in the ground frame",
        ("q",),
        "T",
        (labels.fixed(*"xyz"), labels.fixed("x axis", "y axis", "z axis", "origin")),
        "1 and m",
        "same",
        {
            "recursive": Formulation(lambda w, name: kinematics.pose(kinematics.tree_placed(w.scene, w.tree, name))),
            "positions": by_differentiation(lambda w, name: kinematics.pose(kinematics.placed(w.scene, name, w.graph))),
        },
        place="point",
    ),
    **MOVING,
    "com_acceleration": Output(
        "acceleration of the centre of mass of {name}, ground frame, without gravity",
        ("q", "qd", "qdd"),
        "a",
        (labels.fixed(*"xyz"),),
        "m/s^2",
        "same",
        {
            "recursive": Formulation(lambda w, name: kinematics.acceleration(w.scene, w.tree, w.state, name)),
            "differentiation": by_differentiation(
                lambda w, name: kinematics.differentiated_acceleration(w.scene, name, w.graph)
            ),
        },
        place="body",
        default_in="verify",
        may_fail="silently",
    ),
    **OF_LOOPS,
    **REACTIONS,
    **CENTROIDAL,
    **OPERATORS,
    **CONFIGURATIONS,
    **ARMS,
    **SIGNALS,
    **CONTACTS,
    **HELD,
    **REGRESSORS,
    **PASSIVITY,
    **CANONICAL,
    **LINEARIZING,
    **SHAPING,
}
