"""Every numbered equation (5.1)-(5.20) of the textbook, on a single-loop spatial mechanism and on trees.

What symdyn builds for D'Alembert's method is compared with the equation written out from positions, which the other
formulation differentiates; equality is proved over finite fields.
"""

from __future__ import annotations

import random

import pytest
from arms import puma560, two_link
from figure_5_39 import Loop, matrix_times, single_loop, vector as exact
from mechanisms import coupled_tree, jointed, random_tree
from oracles import BIG
from running import solved_at

from symdyn.dynamics import derive_one
from symdyn.dynamics.mechanism.state import vector
from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.dynamics.reactions.dalembert import DRIVE, REACTION, Equilibrium
from symdyn.dynamics.reactions.free_bodies import inertia_bivector, shift, turned
from symdyn.errors import DerivationError
from symdyn.graph import Graph, evaluate, tangents
from symdyn.scene import Quantity
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Body
from symdyn.scene.values.body import Particle
from symdyn.spatial import Mat, add, cross, neg, scale, sub
from symdyn.verdict import Verdict
from symdyn.verify import Claim
from symdyn.verify.equality import prove

SCENES = [single_loop(), two_link(), random_tree(2, 4)]


@pytest.fixture(scope="module", params=SCENES, ids=lambda one: one.name)
def loop(request):
    return Loop(request.param)


@pytest.fixture
def graph(loop):
    return loop.graph


def symbols(graph, *names):
    return tuple(graph.symbol(name) for name in names)


def flat(*parts):
    """Return the entries of vectors, one after the other."""
    return [x for part in parts for x in part]


def bodies(loop):
    return range(len(loop.scene.bodies))


def resultant(loop, j):
    """Return [force; moment about O_j] of weight and loads in frame 1, from positions."""
    one, T = loop.scene.bodies[j], loop.placed[loop.scene.bodies[j].name]
    origin, gravity = loop.place(j).p, vector(loop.scene.gravity, loop.graph)
    masses = [(particle.mass, particle.at) for particle in one.particles] + [(one.mass, one.com)]
    force, moment = (loop.graph.zero,) * 3, (loop.graph.zero,) * 3
    pulls = [(T.point(vector(at, loop.graph)), scale(mass.express(loop.graph), gravity)) for mass, at in masses]
    for load in loop.scene.loads:
        if load.place.body == one.name:
            F, M = vector(load.force, loop.graph), vector(load.couple, loop.graph)
            F, M = (T.R @ F, T.R @ M) if load.frame == "body" else (F, M)
            pulls.append((T.point(vector(load.place.at, loop.graph)), F))
            moment = add(moment, M)
    for point, pull in pulls:
        force, moment = add(force, pull), add(moment, cross(sub(point, origin), pull))
    return force, moment


def test_equation_5_1_resultant_action_on_every_body(loop):
    for j in bodies(loop):
        force, moment = resultant(loop, j)
        R = loop.place(j).R

        assert loop.agrees(flat(*loop.system.bodies[j].action), flat(R.T @ force, R.T @ moment))


def test_equation_5_2_skew_matrix_of_a_position_vector(loop, graph):
    r, b = symbols(graph, "rx", "ry", "rz"), symbols(graph, "bx", "by", "bz")

    assert loop.agrees(matrix_times(Mat.skew(r), b), cross(r, b))
    assert loop.verdict(matrix_times(Mat.skew(r), b), cross(b, r)) == Verdict.DIFFERENT


def test_equation_5_3_shift_of_a_bivector(loop, graph):
    r, F, M = symbols(graph, "rx", "ry", "rz"), symbols(graph, "a", "b", "c"), symbols(graph, "d", "e", "f")

    assert loop.agrees(matrix_times(shift(r), flat(F, M)), flat(F, add(M, cross(r, F))))


def test_equation_5_4_direction_cosines_of_every_frame(loop):
    for j in bodies(loop):
        P = loop.place(j).R
        built = loop.hanging.frames[j].R

        assert loop.agrees(flat(*built), flat(*P))
        assert loop.agrees(flat(*P.T @ P), flat(*Mat.identity(loop.graph)))  # so P̄ is orthogonal too
        assert loop.agrees(cross(P[0], P[1]), P[2])  # and right-handed


def test_equation_5_5_bivector_of_a_body_in_the_ground_frame(loop, graph):
    F, M = symbols(graph, "a", "b", "c"), symbols(graph, "d", "e", "f")
    for j in bodies(loop):
        P = loop.place(j)
        both = matrix_times(shift(P.p), flat(P.R @ F, P.R @ M))  # R̄ P̄ F̄

        assert loop.agrees(flat(*turned(loop.hanging.frames[j], (F, M))), both)


def columns(loop, joint, kind):
    """Return the numbers of the unknowns of a joint."""
    return [u for u, one in enumerate(loop.system.unknowns) if one.joint == joint and one.kind == kind]


def test_equation_5_6_reaction_in_the_reference_joint_acts_at_its_point(loop):
    """Turned into the ground frame it is the joint's own wrench: no arm, since O_j lies on the joint."""
    for j, joint in enumerate(loop.scene.joints):
        hinge = loop.hanging.joints[j]
        J = loop.placed[joint.parent] if joint.parent != "ground" else None
        for u in columns(loop, joint.name, REACTION):
            force, moment = loop.system.blocks[j, u]
            ((h, (F, M)),) = loop.system.unknowns[u].acts
            R = hinge.origin.R if J is None else J.R @ hinge.origin.R
            P = loop.place(j).R

            assert h == j
            assert loop.agrees(flat(P @ force, P @ moment), flat(R @ F, R @ M))


def test_equation_5_7_a_joint_of_class_t_has_t_components_and_the_drive_takes_the_free_place():
    loop = Loop(single_loop())
    blocks = [loop.system.blocks[0, u] for kind in (REACTION, DRIVE) for u in columns(loop, "R", kind)]
    c, s = loop.graph.cos(loop.state.q[0]), loop.graph.sin(loop.state.q[0])
    one, zero = loop.graph.one, loop.graph.zero
    # the joint frame is the ground's; in the axes of the crank its x and y are turned back by q1
    x, y, z, no = (c, -s, zero), (s, c, zero), (zero, zero, one), (zero,) * 3
    expected = [(x, no), (y, no), (z, no), (no, x), (no, y), (no, z)]

    assert len(columns(loop, "R", REACTION)) == JOINTS["revolute"].class_t(loop.scene.joints[0]) == 5
    assert len(columns(loop, "R", DRIVE)) == 1
    assert loop.agrees([x for pair in blocks for x in flat(*pair)], [x for pair in expected for x in flat(*pair)])


@pytest.mark.long
@pytest.mark.parametrize("part", ["5.8", "5.9", "5.10"])
def test_equations_5_8_to_5_10_reaction_in_another_joint_is_moved_and_changes_sign(loop, part):
    """F*_je = -P_je F_ee and M*_je = -r̃_je P_je F_ee - P_je M_ee for every joint e that body j carries."""
    found = 0
    for e, joint in enumerate(loop.scene.joints):
        j = loop.hanging.joints[e].parent
        if j < 0:
            continue
        Tj, Te = loop.place(j), loop.place(e)
        P = Tj.R.T @ Te.R
        r = Tj.R.T @ sub(Te.p, Tj.p)
        for u in columns(loop, joint.name, REACTION):
            F, M = loop.system.blocks[e, u]
            force, moment = loop.system.blocks[j, u]
            moved = neg(P @ F), sub(neg(cross(r, P @ F)), P @ M)
            found += 1
            if part == "5.8":
                assert loop.agrees(force, moved[0])
            elif part == "5.9":
                assert loop.agrees(moment, moved[1])
            else:  # both as one bivector: -R̄_je P̄_je F̄_ee
                both = matrix_times(shift(r), flat(P @ F, P @ M))
                assert loop.agrees(flat(force, moment), [-x for x in both])
    assert found


def test_equation_5_11_inertia_force_is_against_the_acceleration_of_the_centre_of_mass(loop):
    for j in bodies(loop):
        a = loop.acceleration(loop.centre(j))
        m = body_inertia(loop.scene.bodies[j], loop.graph).m

        assert loop.agrees(loop.place(j).R @ loop.system.bodies[j].inertia[0], [-m * x for x in a])


def test_equations_5_12_and_5_13_inertia_force_in_frame_j_by_the_transposed_cosines(loop):
    for j in bodies(loop):
        P = loop.place(j).R
        in_ground = P @ loop.system.bodies[j].inertia[0]

        assert loop.agrees(P.T @ in_ground, loop.system.bodies[j].inertia[0])


def moment_of_inertia_forces(loop, j):
    """Return -∫ (r - O_j) × r̈ dm in frame 1: point by point, with the second moments of the body."""
    graph, one = loop.graph, loop.scene.bodies[j]
    about = body_inertia(one, graph)
    T, origin = loop.placed[one.name], loop.place(j).p
    I, h, m = about.I, about.h, about.m  # noqa: E741
    trace = (I[0][0] + I[1][1] + I[2][2]) / 2
    spread = [[(trace if a == b else graph.zero) - I[a][b] for b in range(3)] for a in range(3)]
    bent = loop.acceleration(flat(*T.R, T.p))
    A = [[graph.zero] * 3 for _ in range(3)]  # ∫ (r - O) r̈ᵀ dm, with r - O = R x + p - O and r̈ = R̈ x + p̈
    for a in range(3):
        for b in range(3):
            rest = T.p[a] - origin[a]
            turning, moving = [bent[3 * b + i] for i in range(3)], bent[9 + b]
            first = graph.total(T.R[a][i] * h[i] for i in range(3))
            second = graph.total(T.R[a][i] * spread[i][k] * turning[k] for i in range(3) for k in range(3))
            lever = rest * graph.total(turning[i] * h[i] for i in range(3))
            A[a][b] = second + first * moving + lever + m * rest * moving
    return [A[2][1] - A[1][2], A[0][2] - A[2][0], A[1][0] - A[0][1]]


def test_equation_5_14_inertia_moment_about_a_point_that_is_not_the_centre_of_mass(loop):
    for j in bodies(loop):
        moment = loop.place(j).R @ loop.system.bodies[j].inertia[1]

        assert loop.agrees(moment, moment_of_inertia_forces(loop, j))


def test_equation_5_15_products_of_inertia_enter_with_a_minus():
    """D = ∫ xy dm, hand-made: two particles; the matrix has -D off its diagonal."""
    pair = Body(
        "pair", particles=(Particle(Quantity.number(2), exact(1, 3, 0)), Particle(Quantity.number(5), exact(0, 2, -1)))
    )
    I = body_inertia(pair, Graph()).I  # noqa: E741
    Dxy, Dyz, Dxz = 2 * 1 * 3, 5 * 2 * -1, 0
    expected = [[2 * 9 + 5 * 5, -Dxy, -Dxz], [-Dxy, 2 * 1 + 5 * 1, -Dyz], [-Dxz, -Dyz, 2 * 10 + 5 * 4]]

    assert [[entry.value for entry in row] for row in I] == expected


def test_equations_5_15_and_5_16_moment_without_spin_is_that_of_the_acceleration_of_the_origin(loop, graph):
    """With ω = 0: M^D = -I ω̇ + r̃_jT F*, F* = -m a, I about O_j."""
    dw, a, still = symbols(graph, "dx", "dy", "dz"), symbols(graph, "ax", "ay", "az"), (graph.zero,) * 3
    for j in bodies(loop):
        one = body_inertia(loop.scene.bodies[j], graph)
        F_star = scale(-one.m, a)
        r = scale(1 / one.m, one.h)
        expected = add(neg(one.I @ dw), cross(r, F_star))

        assert loop.agrees(inertia_bivector(one, still, dw, a)[1], expected)


def test_equation_5_17_inertia_bivector_stacks_force_and_moment(loop):
    for j in bodies(loop):
        force, moment = loop.system.bodies[j].inertia
        right = loop.system.right()[6 * j : 6 * j + 6]

        assert loop.agrees(
            [x - y for x, y in zip(right, flat(*loop.system.bodies[j].action), strict=True)], flat(force, moment)
        )


@pytest.mark.parametrize(
    "one", [single_loop(), puma560(), coupled_tree(1, 4), jointed("spherical", "rod")], ids=lambda one: one.name
)
def test_equation_5_18_every_body_is_in_equilibrium(one):
    """F^A + F^D + F^R + Σ F*^R = 0, all bivectors of a body moved to the ground frame and added up there."""
    loop, rng = Loop(one), random.Random(one.name)
    symbols = [*loop.state.q, *loop.state.qd, *loop.state.qdd, *loop.state.tau]
    symbols += [loop.graph.symbol(parameter.name) for parameter in one.free_parameters]
    state = {node: BIG.number(rng.uniform(-1, 1)) for node in symbols}
    valued = {p.name: p.value.express(loop.graph) for p in one.parameters if p.value is not None}
    state |= {loop.graph.symbol(name): evaluate([node], BIG, {})[0] for name, node in valued.items()}
    x = solved_at(loop.system, BIG, state)
    for j in bodies(loop):
        known = loop.system.bodies[j]
        force, moment = add(known.action[0], known.inertia[0]), add(known.action[1], known.inertia[1])
        total = evaluate(flat(force, moment), BIG, state)
        largest = max(map(abs, total))
        for (body_, u), (F, M) in loop.system.blocks.items():
            if body_ == j:
                total = [a + x[u] * b for a, b in zip(total, evaluate(flat(F, M), BIG, state), strict=True)]

        assert max(map(abs, total)) < 1e-50 * (1 + largest)


def test_equation_5_19_counts_the_unknown_reactions():
    """m_R = Σ t s_t = 5·(R, P) + 4·U + 3·S."""
    loop = Loop(single_loop())
    classes = [JOINTS[joint.type].class_t(joint) for joint in (*loop.scene.joints, *loop.scene.loops)]
    s = {t: classes.count(t) for t in range(1, 6)}

    assert s == {1: 0, 2: 0, 3: 1, 4: 1, 5: 2}
    assert loop.system.reactions == sum(t * number for t, number in s.items()) == 17


@pytest.mark.parametrize(
    "one", [single_loop(), two_link(), puma560(), random_tree(3), jointed("free", "universal", "helical")],
    ids=lambda one: one.name,
)  # fmt: skip
def test_equation_5_20_as_many_equations_as_unknowns(one):
    """6(u - 1) = n + Σ t s_t."""
    loop = Loop(one)

    assert loop.system.equations == 6 * len(one.bodies)
    assert loop.system.equations == loop.system.drives + loop.system.reactions


def test_bivectors_are_in_motion_at_all():
    """The proofs above would hold of nothing: an acceleration turns up in every inertia bivector."""
    loop = Loop(single_loop())
    for known in loop.system.bodies:
        slopes = tangents(flat(*known.inertia), dict.fromkeys(loop.state.qdd, loop.graph.one))
        assert any(not slope.is_zero for slope in slopes)


def test_a_planar_mechanism_needs_three_equations_a_body():
    loop = Loop(two_link())
    flat_system = Equilibrium.of(loop.hanging, planar=True)

    assert (flat_system.equations, flat_system.reactions, flat_system.drives) == (6, 4, 2)
    assert flat_system.kept == (0, 1, 5)
    drives = [u for u, one in enumerate(flat_system.unknowns) if one.kind == DRIVE]
    tau = derive_one(loop.w, "inverse_dynamics").entries
    given = [{u: loop.graph.one, len(flat_system.unknowns): force} for u, force in zip(drives, tau, strict=True)]
    claim = Claim.solvable("drives", "tau", "(5.18)", [*flat_system.rows(), *given], len(flat_system.unknowns))
    assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_a_spatial_mechanism_has_no_planar_equations():
    with pytest.raises(DerivationError, match="no plane of coordinates of all frames"):
        Equilibrium.of(Loop(single_loop()).hanging, planar=True)
