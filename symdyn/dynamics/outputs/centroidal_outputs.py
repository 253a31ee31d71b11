"""The outputs about the centre of mass of the whole scene: rows of OUTPUTS that it has when it is asked for them."""

from __future__ import annotations

from functools import partial

from symdyn.dynamics.mechanism import centroidal
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.output import Formulation, Output, by_differentiation

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
