"""Binding times: when an operation's arguments are known."""

from __future__ import annotations

import pytest
from arms import EXAMPLES, two_link
from formulas import argument, function, one

from symdyn.dynamics import Equations, derive
from symdyn.dynamics.outputs import Counts
from symdyn.dynamics.outputs.named_functions import BINDING
from symdyn.graph import Graph, Op, reachable
from symdyn.program import lower
from symdyn.scene import Scene, read
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove


def test_an_operation_is_bound_when_its_last_argument_is_known():
    g = Graph()
    q, qd, tau, m = (g.symbol(name) for name in ("q", "qd", "tau", "m"))
    arguments = [argument(name, [x]) for name, x in (("q", q), ("qd", qd), ("tau", tau), ("params", m))]
    entry = (m * m) * g.sin(q) * qd + tau / (1 + m)
    counts = Counts.by_binding(function("f", arguments, (1,), [entry]))

    assert counts == {
        "params": Counts(1, 1),
        "q": Counts(1, 0, 0, 1),
        "q, qd": Counts(1),
        "all": Counts(0, 1, 1),
    }


def test_binding_times_add_up_to_one_call():
    program = lower(derive(two_link(), ("inverse_dynamics", "forward_dynamics", "mass_matrix")))

    for routine in program.routines:
        assert tuple(routine.binding) == tuple(name for name, _ in BINDING)
        assert routine.counts == Counts.of(routine.function)
        assert routine.prepare + routine.state_counts == routine.counts


def test_without_free_parameters_nothing_is_to_prepare():
    program = lower(derive(read(EXAMPLES / "puma560.toml"), ("inverse_dynamics",)))

    assert program["inverse_dynamics"].prepare == Counts()
    assert lower(derive(two_link(), ("mass_matrix",)))["mass_matrix"].prepare != Counts()


def test_a_mass_matrix_knows_no_velocity():
    counts = lower(derive(two_link(), ("mass_matrix",)))["mass_matrix"].binding

    assert counts["q, qd"] == counts["all"] == Counts()


def test_an_argument_of_another_name_is_known_last():
    g = Graph()
    (f,) = one([g.symbol("x") * g.symbol("y")], [g.symbol("x")]).functions

    assert Counts.by_binding(f)["all"] == Counts(1)


def test_cost_weighs_what_is_slow():
    assert Counts(1, 2, 3, 4, 5).cost == 1 + 2 + 4 * 3 + 20 * 4 + 20 * 5


# At rest


def test_at_rest_velocities_are_zero_and_no_argument():
    equations = derive(two_link(), ("inverse_dynamics", "velocity_forces", "mass_matrix"))
    still = equations.at_rest()

    assert [a.name for a in still["inverse_dynamics"].arguments] == ["q", "qdd", "params"]
    assert all(entry.is_zero for entry in still["velocity_forces"].entries)
    assert still["mass_matrix"] == equations["mass_matrix"]
    symbols = {str(n.value) for n in reachable(still["inverse_dynamics"].entries) if n.op is Op.SYMBOL}
    assert not {name for name in symbols if name.endswith("_dot")}


def test_at_rest_inverse_dynamics_is_inertia_and_gravity():
    equations = derive(two_link(), ("inverse_dynamics", "mass_matrix", "gravity_forces"))
    qdd = [equations.graph.symbol(f"{name}_ddot") for name in two_link().coordinates]
    M, g = equations["mass_matrix"].entries, equations["gravity_forces"].entries
    law = tuple(M[2 * i] * qdd[0] + M[2 * i + 1] * qdd[1] + g[i] for i in range(2))
    _, (finding,) = prove([Claim("rest", "at rest", "M qdd + g", equations.at_rest()["inverse_dynamics"].entries, law)])

    assert finding.verdict in (Verdict.PROVED, Verdict.NUMERICAL)


def test_nothing_at_all_is_at_rest():
    assert Equations(Scene("empty"), Graph(), ()).at_rest().functions == ()


@pytest.mark.parametrize("output", ["inverse_dynamics", "forward_dynamics"])
def test_rest_is_cheaper_than_motion(output):
    equations = derive(read(EXAMPLES / "puma560.toml"), (output,))

    assert lower(equations.at_rest())[output].counts.cost < lower(equations)[output].counts.cost
