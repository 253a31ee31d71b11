"""The formulation that becomes code is the one with the fewest operations."""

from __future__ import annotations

import pytest
from arms import EXAMPLES, chain, two_link
from mechanisms import coupled_tree, random_tree

from symdyn.dynamics import Equations, Workspace, derive, derive_one, expected, formulations_of
from symdyn.errors import DerivationError
from symdyn.program import Candidates, formulate, lower
from symdyn.program.formulation import LONGEST
from symdyn.scene import read
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

SMALL = [two_link(), read(EXAMPLES / "cart_pole.toml"), random_tree(3, 3), coupled_tree(2, 4)]


def cost(scene, output, formulation):
    return lower(derive(scene, (output,), formulation))[output].counts.cost


@pytest.mark.long
@pytest.mark.parametrize("scene", SMALL, ids=lambda scene: scene.name)
def test_no_other_formulation_is_cheaper(scene):
    outputs = ("inverse_dynamics", "mass_matrix", "velocity_forces", "gravity_forces", "k_D")
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


def test_a_formulation_can_be_asked_for_and_others_are_counted():
    equations = formulate(two_link(), ("inverse_dynamics", "forward_dynamics", "pose:tool"), "aba")

    assert equations["forward_dynamics"].formulation == "aba"
    assert equations["inverse_dynamics"].formulation in formulations_of("inverse_dynamics")


def test_a_formulation_that_no_output_has_is_refused():
    with pytest.raises(
        DerivationError, match="no output that was asked for has the formulation 'aba'; there are rnea, lagrange"
    ):
        formulate(two_link(), ("inverse_dynamics",), "aba")
    with pytest.raises(DerivationError, match=r"'rnea_loop' \(parameters have no value\); there are rnea, lagrange"):
        formulate(two_link(), ("inverse_dynamics",), "rnea_loop")


def test_an_output_that_does_not_exist_is_refused():
    with pytest.raises(DerivationError, match="there is no output 'power'"):
        formulate(two_link(), ("power",))


def test_large_formulations_are_not_tried_for_many_joints():
    assert "lagrange" not in Candidates(Workspace(read(EXAMPLES / "puma560.toml")), "inverse_dynamics").names
    assert "lagrange" in Candidates(Workspace(two_link()), "inverse_dynamics").names
    assert "lagrange" in Candidates(Workspace(read(EXAMPLES / "puma560.toml")), "gravity_forces").names


def test_long_chains_follow_the_rule_of_the_table():
    scene = chain(LONGEST + 1)
    ruled = derive(scene, ("forward_dynamics", "inverse_dynamics"))

    assert [f.formulation for f in formulate(scene, ("forward_dynamics", "inverse_dynamics")).functions] == [
        f.formulation for f in ruled.functions
    ]


def test_choosing_twice_is_choosing_the_same():
    def chosen() -> Equations:
        scene = read(EXAMPLES / "scara.toml")
        return formulate(scene, expected(scene))

    assert [f.formulation for f in chosen().functions] == [f.formulation for f in chosen().functions]
