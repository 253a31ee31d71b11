"""What D'Alembert's method says of one body that is cut free, beside its bivectors: frame j, motion, inertia.

P_0j, r_0j     (5.4), (5.2) direction cosines of frame j, r̃ of the position of its origin O_j; axes of the ground
w_0j, I_jj     angular velocity, (5.15) inertia about O_j; axes of frame j
F_0j           (5.11) inertia force, by differentiating the position of the centre of mass; axes of the ground
F_star         (5.16) F*^D_jj; axes of frame j
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics import Workspace
from symdyn.dynamics.mechanism.kinematics import centre_of_mass
from symdyn.dynamics.reactions.bivectors import frames, inertia_bivector
from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.graph import Expr, tangents
from symdyn.spatial import Mat, Vec, Wrench, apply_transposed, neg, scale, skew, sub


@dataclass(frozen=True)
class Cut:
    """One body, cut free; see the module's legend.

    Attributes:
        m: mass, kg.
        misread: F̄^D_jj as (5.16) of the text would have it, with a position in place of an acceleration.
    """

    m: Expr
    P: Mat
    r: Mat
    w: Vec
    I: Mat  # noqa: E741  the book's name
    F: Vec
    F_star: Vec
    misread: Wrench

    @property
    def nodes(self) -> list[Expr]:
        """Everything that is written of it."""
        return [x for row in (*self.P, *self.r, *self.I) for x in row] + [*self.w, *self.F, *self.F_star]


def cut(workspace: Workspace, system: Equilibrium, j: int) -> Cut | None:
    """Return what there is to say of body j; None for a body without mass."""
    known, T, state = system.bodies[j], frames(system.hanging)[j], workspace.state
    m, motion = known.body.m, known.motion
    if m.is_zero:
        return None
    centre = centre_of_mass(workspace.scene, workspace.scene.bodies[j].name, workspace.graph)
    place = T.point(sub(centre, system.hanging.joints[j].place_on_child))
    x, y, z = tangents(tangents(place, state.velocity), state.acceleration)
    misread = inertia_bivector(known.body, motion.w, motion.dw, apply_transposed(T.R, T.p))
    force, force_star = neg(scale(m, (x, y, z))), neg(scale(m, motion.a))
    return Cut(m, T.R, skew(T.p), motion.w, known.body.I, force, force_star, misread)
