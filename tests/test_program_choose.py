"""The formulation that becomes code is the one that a row prefers: none takes far fewer operations."""

from __future__ import annotations

import pytest
from arms import EXAMPLES, chain, two_link
from mechanisms import coupled_tree, random_tree

from symdyn.bench.time_and_error import comparable
from symdyn.dynamics import Equations, Workspace, available, derive, derive_one, expected, formulations_of
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError
from symdyn.program import formulate, lower
from symdyn.scene import read
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

SMALL = [two_link(), read(EXAMPLES / "cart_pole.toml"), random_tree(3, 3), coupled_tree(2, 4)]


def cost(scene, output, formulation):
    return lower(derive(scene, (output,), formulation))[output].counts.cost


@pytest.mark.heavy("coupled2")
@pytest.mark.long
@pytest.mark.parametrize("scene", SMALL, ids=lambda scene: scene.name)
def test_no_other_formulation_is_cheaper(scene):
    outputs = ("inverse_dynamics", "mass_matrix", "velocity_forces", "k_D")
    equations = formulate(scene, outputs)
    for function in equations.functions:
        own = cost(scene, function.name, function.formulation)
        assert own == min(
            cost(scene, function.name, formulation) for formulation in formulations_of(function.name, scene)
        )


def test_all_formulations_of_a_choice_are_proved_equal():
    scene = two_link()
    workspace = Workspace(scene)
    claims = [
        Claim(f.name, f.formulation, formulation, f.entries, derive_one(workspace, f.name, formulation).entries)
        for f in formulate(scene, expected(scene)).functions
        for formulation in formulations_of(f.name, scene)
    ]
    _, findings = prove(claims)

    assert findings
    assert [finding.claim for finding in findings if finding.verdict not in (Verdict.PROVED, Verdict.NUMERICAL)] == []


def test_a_formulation_can_be_asked_for_and_others_are_preferred():
    equations = formulate(two_link(), ("inverse_dynamics", "forward_dynamics", "pose:tool"), "aba")

    assert equations["forward_dynamics"].formulation == "aba"
    assert equations["inverse_dynamics"].formulation in formulations_of("inverse_dynamics")


def test_a_formulation_that_no_output_has_is_refused():
    with pytest.raises(
        DerivationError, match="no output that was asked for has the formulation 'aba'; there are rnea, lagrange"
    ):
        formulate(two_link(), ("inverse_dynamics",), "aba")
    with pytest.raises(
        DerivationError, match=r"'rnea_loop' \(parameters have no value\); .* \(there are rnea, lagrange"
    ):
        formulate(two_link(), ("inverse_dynamics",), "rnea_loop")


def test_an_output_that_does_not_exist_is_refused():
    with pytest.raises(DerivationError, match="there is no output 'power'"):
        formulate(two_link(), ("power",))


@pytest.mark.long
def test_preferences_take_hardly_more_operations_than_the_best_of_all():
    """In sum over the examples, as derived; of one function at most half more."""
    preferred, least = 0, 0
    for path in sorted(EXAMPLES.glob("*.toml")):
        scene = read(path)
        workspace = Workspace(scene)
        for output in available(scene)[0]:
            own = derive_one(workspace, output)
            names = comparable(scene, output) or (own.formulation,)
            costs = {name: Counts.of(derive_one(workspace, output, name)).cost for name in names}
            assert costs[own.formulation] <= 1.5 * min(costs.values()), (scene.name, output, costs)
            preferred, least = preferred + costs[own.formulation], least + min(costs.values())

    assert preferred <= 1.003 * least


def test_code_is_made_of_the_formulation_that_derive_takes():
    scene, outputs = chain(6), ("forward_dynamics", "inverse_dynamics", "coriolis_matrix")
    ruled = derive(scene, outputs)

    assert [f.formulation for f in ruled.functions] == ["aba", "rnea", "derivatives"]
    assert [f.formulation for f in formulate(scene, outputs).functions] == ["aba", "rnea", "derivatives"]


def test_what_is_only_counted_leaves_nothing_behind():
    workspace = Workspace(two_link())

    assert derive_one(workspace, "coriolis_matrix").formulation == "crba"
    assert ("coriolis_matrix", "derivatives") not in workspace.derived
    assert len(workspace.graph.nodes) == len(derive(two_link(), ("coriolis_matrix",), "crba").graph.nodes)


def test_choosing_twice_is_choosing_the_same():
    def chosen() -> Equations:
        scene = read(EXAMPLES / "scara.toml")
        return formulate(scene, expected(scene))

    assert [f.formulation for f in chosen().functions] == [f.formulation for f in chosen().functions]
