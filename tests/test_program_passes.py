"""Passes keep the function and never raise a count."""

from __future__ import annotations

import pytest
from arms import EXAMPLES, two_link
from formulas import argument, every_op, function, one
from mechanisms import coupled_tree, random_tree

from symdyn.dynamics import available, derive
from symdyn.dynamics.outputs import Counts
from symdyn.errors import DerivationError
from symdyn.graph import Graph, Op
from symdyn.program import lower
from symdyn.program.passes import PASSES, factor, optimise
from symdyn.scene import read
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

SCENES = [
    two_link(),
    read(EXAMPLES / "scara.toml"),
    random_tree(1, 4),
    random_tree(5, 3),
    random_tree(4, 4, free=False),
    coupled_tree(3, 4),
]


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_every_pass_is_proved_to_change_nothing_and_costs_no_more(scene):
    functions = lower(derive(scene, available(scene)[0]), ()).routines
    claims = []
    for routine in functions:
        before = routine.function
        for name in PASSES:
            after = optimise(before, (name,))
            assert Counts.of(after).cost <= Counts.of(before).cost, f"{before.name}: {name}"
            if before.entries or after.entries:  # k_C of one coordinate has none
                claims.append(Claim(f"{before.name}: {name}", "after", "before", after.entries, before.entries))
    positive = [parameter.name for parameter in scene.parameters if parameter.positive]
    _, findings = prove(claims, 1, positive=positive)

    assert findings
    assert [finding.claim for finding in findings if finding.verdict not in (Verdict.PROVED, Verdict.NUMERICAL)] == []


def test_passes_keep_every_operation():
    equations = every_op()
    program = lower(equations)
    plain = lower(equations, ())
    claims = [
        Claim(a.function.name, "passes", "none", a.function.entries, b.function.entries)
        for a, b in zip(program.routines, plain.routines, strict=True)
        if a.function.entries or b.function.entries
    ]
    _, findings = prove(claims, positive=["mass", "q1", "q2", "qd1", "qd2"])

    assert findings
    assert [finding.claim for finding in findings if finding.verdict not in (Verdict.PROVED, Verdict.NUMERICAL)] == []


def test_lowering_costs_no_more_with_passes_than_without():
    equations = derive(read(EXAMPLES / "puma560.toml"), ("inverse_dynamics", "mass_matrix", "forward_dynamics"))
    with_passes, without = lower(equations), lower(equations, ())

    assert all(a.counts.cost < b.counts.cost for a, b in zip(with_passes.routines, without.routines, strict=True))


def test_an_unknown_pass_is_refused():
    with pytest.raises(DerivationError, match="there is no pass 'inline'; there are factor"):
        lower(every_op(), ("inline",))


def rewritten(rule, build, names="abxyz"):
    """Return a rule's result for one expression of symbols, and what it costs."""
    g = Graph()
    result = rule([build(g, *(g.symbol(name) for name in names))], Graph())
    (f,) = one(result, [g.symbol(names[0])]).functions
    return result, Counts.of(f)


@pytest.mark.parametrize(
    ("build", "counts"),
    [
        (lambda g, a, b, x, y, z: (x * a + x * b, x * (a + b)), (1, 1)),
        (lambda g, a, b, x, y, z: (x * a - x * b, x * (a - b)), (1, 1)),
        (lambda g, a, b, x, y, z: (x * b - y - x * a, x * (b - a) - y), (1, 2)),
        (lambda g, a, b, x, y, z: (3 * a + y + 3 * b, 3 * (a + b) + y), (1, 2)),
        (lambda g, a, b, x, y, z: (a * y * x + b * z * x + a * z * x, x * (a * (y + z) + b * z)), (3, 2)),
        (lambda g, a, b, x, y, z: (x * a * y + x * y * b, x * y * (a + b)), (2, 1)),
        (lambda g, a, b, x, y, z: (-(x * a) - x * b - z, -(x * (a + b)) - z), (1, 2)),
        (lambda g, a, b, x, y, z: (x / a + x / b, x / a + x / b), (0, 1)),
    ],
)
def test_factors_come_out(build, counts):
    result, counted = rewritten(factor, lambda *args: build(*args)[0])
    g = Graph()
    _, (finding,) = prove([Claim("f", "found", "meant", tuple(result), (build(g, *map(g.symbol, "abxyz"))[1],))])

    assert (counted.multiplications, counted.additions) == counts
    assert finding.verdict in (Verdict.PROVED, Verdict.NUMERICAL)


def test_a_product_that_is_used_twice_keeps_its_factor():
    g = Graph()
    a, b, x = (g.symbol(name) for name in "abx")
    entries = [x * a + x * b, x * a, x * b]
    (f,) = one(factor(entries, Graph()), [x]).functions

    assert Counts.of(f) == Counts(multiplications=2, additions=1)


def test_what_is_known_early_is_put_together():
    g = Graph()
    m, n, x, y = (g.symbol(name) for name in "mnxy")
    entries = [m + x + n, m * (y * n) + x, (x * m + y) + (n + x * n)]
    before = function("f", [argument("q", [x, y]), argument("params", [m, n])], (3,), entries)
    after = optimise(before, ("factor",))

    assert Counts.by_binding(after)["params"] == Counts(1, 1)
    assert Counts.by_binding(before)["params"] == Counts()
    assert Counts.of(after).cost < Counts.of(before).cost
    _, (finding,) = prove([Claim("early", "after", "before", after.entries, before.entries)])
    assert finding.verdict in (Verdict.PROVED, Verdict.NUMERICAL)


def test_no_line_of_a_program_is_an_alias_or_a_negation():
    program = lower(derive(read(EXAMPLES / "puma560.toml"), ("inverse_dynamics", "k_C", "coriolis_matrix")))
    lines = [step.node for routine in program.routines for step in routine.steps]

    assert not [node for node in lines if node.op in (Op.NEG, Op.SYMBOL, Op.CONSTANT)]


def test_the_same_equations_give_the_same_program():
    def text():
        program = lower(derive(two_link(), ("inverse_dynamics", "forward_dynamics")))
        return [(step.name, repr(step.node)) for routine in program.routines for step in routine.steps]

    assert text() == text()
