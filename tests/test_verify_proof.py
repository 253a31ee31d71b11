"""What the prover proves, what it refuses, and that no single mistake in a derivation slips through."""

from __future__ import annotations

from fractions import Fraction
from math import lcm, prod

import pytest
from arms import spatial_arm, two_link

from symdyn.algebra.finite_field import Needs
from symdyn.dynamics import Workspace, derive_one
from symdyn.graph import Graph, Op, reachable, substitute, tangents
from symdyn.scene import Quantity
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove


def finding(formulas, **how):
    """Return the finding for formulas(graph, x, y) = (left, right)."""
    graph = Graph()
    left, right = formulas(graph, graph.symbol("x"), graph.symbol("y"))
    return prove([Claim("claim", "left", "right", (left,), (right,))], **how)[1][0]


IDENTITIES = {
    "sin^2 + cos^2 = 1": lambda g, x, y: (g.sin(x) ** 2 + g.cos(x) ** 2, g.one),
    "sin 2x": lambda g, x, y: (g.sin(2 * x), 2 * g.sin(x) * g.cos(x)),
    "half angle": lambda g, x, y: (2 * g.sin(x / 2) ** 2, 1 - g.cos(x)),
    "sum of angles": lambda g, x, y: (g.cos(x + y), g.cos(x) * g.cos(y) - g.sin(x) * g.sin(y)),
    "angle and number": lambda g, x, y: (x * g.sin(x + g.pi / 6) * 2, x * (g.sqrt(3) * g.sin(x) + g.cos(x))),
    "0.6 rad": lambda g, x, y: (g.sin(Fraction(3, 5)), 2 * g.sin(Fraction(3, 10)) * g.cos(Fraction(3, 10))),
    "pi in and outside": lambda g, x, y: (g.sin(g.pi * x) * g.pi, g.pi * g.sin(x * g.pi)),
    "golden section": lambda g, x, y: (4 * g.cos(g.pi / 5), 1 + g.sqrt(5)),
    "tan 22.5 deg": lambda g, x, y: (g.sin(g.pi / 8) / g.cos(g.pi / 8), g.sqrt(2) - 1),
    "heptagon": lambda g, x, y: (2 * (g.sin(g.pi * 2 / 7) + g.sin(g.pi * 4 / 7) - g.sin(g.pi / 7)), g.sqrt(7)),
    "radicals": lambda g, x, y: (g.sqrt(2) * g.sqrt(3) / 6, 1 / g.sqrt(6)),
    "division": lambda g, x, y: ((x**2 - y**2) / (x - y), x + y),
    "continued fraction": lambda g, x, y: (1 / (1 + 1 / (1 + 1 / x)), (x + 1) / (2 * x + 1)),
    "function of equal arguments": lambda g, x, y: (
        g.function(Op.EXP, (x + 1) ** 2) * g.function(Op.TANH, x * y),
        g.function(Op.TANH, y * x) * g.function(Op.EXP, x**2 + 2 * x + 1),
    ),
}


@pytest.mark.parametrize("name", IDENTITIES)
def test_identity_is_proved_with_a_stated_error(name):
    found = finding(IDENTITIES[name])

    assert found.verdict == Verdict.PROVED
    assert found.error_log10 < -30
    assert found.where == -1


MISTAKES = {
    "sin q = q": lambda g, x, y: (g.sin(x), x),
    "sine of another variable": lambda g, x, y: (g.sin(x), g.sin(y)),
    "sign in a sum of angles": lambda g, x, y: (g.cos(x + y), g.cos(x) * g.cos(y) + g.sin(x) * g.sin(y)),
    "pi = 22/7": lambda g, x, y: (g.pi, g.constant(Fraction(22, 7))),
    "sin 1 to 18 digits": lambda g, x, y: (g.sin(1), g.constant(Fraction("0.841470984807896506"))),
    "wrong root": lambda g, x, y: (4 * g.cos(g.pi / 5), 1 - g.sqrt(5)),
    "heptagon with the other sign": lambda g, x, y: (
        2 * (g.sin(g.pi * 2 / 7) + g.sin(g.pi * 4 / 7) - g.sin(g.pi / 7)),
        -g.sqrt(7),
    ),
    "30 deg for 60 deg": lambda g, x, y: (g.cos(x + g.pi / 6), g.cos(x + g.pi / 3)),
    "a term of 1e-40": lambda g, x, y: (g.sin(x) + y * Fraction(1, 10**40), g.sin(x)),
    "sqrt(x^2) = x": lambda g, x, y: (g.sqrt(x**2), x),
    "|x| = x": lambda g, x, y: (g.function(Op.ABS, x), x),
    "sign x = 1": lambda g, x, y: (g.function(Op.SIGN, x), g.one),
    "exp of a product": lambda g, x, y: (g.function(Op.EXP, x * y), g.function(Op.EXP, x) * g.function(Op.EXP, y)),
}


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", MISTAKES)
def test_wrong_identity_is_called_different(name, seed):
    assert finding(MISTAKES[name], seed=seed).verdict == Verdict.DIFFERENT


BEYOND_THE_FIELDS = {
    "root of a square": lambda g, x, y: (g.sqrt((x**2 + 1) ** 2), x**2 + 1),
    "a factor under a root": lambda g, x, y: (g.sqrt(4 * x + 4 * y), 2 * g.sqrt(x + y)),
    "twice a number under roots": lambda g, x, y: (g.sqrt(2 * x) * g.sqrt(2), 2 * g.sqrt(x)),
    "nested radical": lambda g, x, y: (g.sqrt(3 + 2 * g.sqrt(2)), 1 + g.sqrt(2)),
    "|x|^2 = x^2": lambda g, x, y: (g.function(Op.ABS, x) ** 2, x**2),
    "exp of a sum": lambda g, x, y: (g.function(Op.EXP, x + y), g.function(Op.EXP, x) * g.function(Op.EXP, y)),
    "log exp": lambda g, x, y: (g.function(Op.LOG, g.function(Op.EXP, x)), x),
    "product under roots, where both exist": lambda g, x, y: (g.sqrt(x) * g.sqrt(y), g.sqrt(x * y)),
    "equal angles of another form": lambda g, x, y: (g.sin(x * (x + 1)), g.sin(x**2 + x)),
}


@pytest.mark.parametrize("name", BEYOND_THE_FIELDS)
def test_what_a_field_cannot_decide_is_checked_numerically_and_says_so(name):
    found = finding(BEYOND_THE_FIELDS[name])

    assert found.verdict == Verdict.NUMERICAL
    assert found.error_log10 == 0.0


def test_an_assumption_that_a_symbol_is_positive_settles_a_branch():
    def root(g, x, y):
        return g.sqrt(x**2 * y**4), x * y**2

    assert finding(root).verdict == Verdict.DIFFERENT
    assert finding(root, positive=("x",)).verdict == Verdict.NUMERICAL


def test_many_roots_of_symbols_of_unknown_sign_still_find_a_point():
    graph = Graph()
    roots = [graph.sqrt(graph.symbol(f"k{i}")) for i in range(12)]
    claim = Claim("stiffness", "left", "right", (graph.total(roots) * 2,), (graph.total(root * 2 for root in roots),))

    assert prove([claim])[1][0].verdict == Verdict.NUMERICAL


def test_a_claim_about_nothing_real_is_defined_nowhere():
    assert finding(lambda g, x, y: (g.sqrt(-1 - x**2), g.sqrt(-1 - x * x) * 2)).verdict == "not shown"
    assert finding(lambda g, x, y: (g.sqrt(-2) * g.sqrt(-3), -g.sqrt(6))).verdict == "not shown"


ROOTS = {
    "one radicand written twice": lambda g, x, y: (g.sqrt((x + 1) ** 2 + y**2), g.sqrt(x**2 + 2 * x + 1 + y**2)),
    "a length and its reciprocal": lambda g, x, y: (x / g.sqrt(x**2 + y**2), x * g.sqrt(x**2 + y**2) / (y**2 + x**2)),
    "two roots": lambda g, x, y: ((g.sqrt(x) + g.sqrt(y)) ** 2 - x - y, 2 * g.sqrt(x) * g.sqrt(y)),
    "the root of a square": lambda g, x, y: (
        (g.sqrt((x - y) ** 2) + g.sqrt(x)) ** 2 - (x - y) ** 2 - x,
        2 * g.sqrt(x) * g.sqrt((y - x) ** 2),
    ),
    "root under a root": lambda g, x, y: (g.sqrt(1 + g.sqrt(x + y)), g.sqrt(g.sqrt(y + x) + 1)),
    "a root of what roots make": lambda g, x, y: (
        (g.sqrt(x + y) + g.sqrt(1 + g.sqrt(x + y))) ** 2 - x - y - 1 - g.sqrt(y + x),
        2 * g.sqrt(x + y) * g.sqrt(g.sqrt(y + x) + 1),
    ),
    "a rate": lambda g, x, y: (tangents([g.sqrt(x**2 + y)], {x: g.one})[0], x / g.sqrt(y + x * x)),
    "under a function": lambda g, x, y: (g.function(Op.TANH, g.sqrt(x**2 + y)), g.function(Op.TANH, g.sqrt(y + x * x))),
}


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", ROOTS)
def test_what_holds_for_either_sign_of_a_root_is_proved(name, seed):
    found = finding(ROOTS[name], seed=seed, positive=("x", "y"))

    assert found.verdict == Verdict.PROVED
    assert found.error_log10 < -30


WRONG_ROOTS = {
    "sign": lambda g, x, y: (g.sqrt(x + y), -g.sqrt(y + x)),
    "a sign within a root": lambda g, x, y: (g.sqrt(1 + g.sqrt(x)), g.sqrt(1 - g.sqrt(x))),
    "a root of another root": lambda g, x, y: (g.sqrt(2 + g.sqrt(x)) ** 2 - 2, -g.sqrt(x)),
    "another radicand": lambda g, x, y: (g.sqrt(x + y) * g.sqrt(x), g.sqrt(x + 2 * y) * g.sqrt(x)),
    "a sum of roots": lambda g, x, y: (g.sqrt(x) + g.sqrt(y), g.sqrt(x + y)),
    "the larger of two": lambda g, x, y: (g.sqrt((x - y) ** 2), x - y),
}


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", WRONG_ROOTS)
def test_a_wrong_root_is_different_whatever_the_points(name, seed):
    assert finding(WRONG_ROOTS[name], seed=seed, positive=("x", "y")).verdict == Verdict.DIFFERENT


@pytest.mark.heavy("product under roots, where both exist")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["root of a square", "a factor under a root", "product under roots, where both exist"])
def test_roots_that_are_not_independent_are_never_proved_by_luck(name):
    verdicts = {finding(BEYOND_THE_FIELDS[name], seed=seed).verdict for seed in range(50)}  # luck is 1 in 16

    assert verdicts == {Verdict.NUMERICAL}


def test_more_roots_than_there_are_points_for_are_checked_numerically():
    def roots(g, x, y):
        total = g.total(g.sqrt(x + k * y) for k in range(9))
        return total * 2, g.total(g.sqrt(x + k * y) * 2 for k in range(9))

    assert finding(roots, positive=("x", "y")).verdict == Verdict.NUMERICAL


def test_a_divisor_that_is_always_zero_leaves_its_claim_undefined_and_the_others_proved():
    graph = Graph()
    x = graph.symbol("x")
    nothing = Claim("nothing", "left", "right", (x / (graph.sin(x) ** 2 + graph.cos(x) ** 2 - 1),), (x,))
    fine = Claim("fine", "left", "right", (graph.sin(2 * x),), (2 * graph.sin(x) * graph.cos(x),))

    assert [found.verdict for found in prove([nothing, fine])[1]] == ["not shown", Verdict.PROVED]


PRIMES = prove([])[0].primes
ORDERS = lcm(*(p - 1 for p in PRIMES))

TRAPS = {  # true over every field that the default seed draws, or would be with careless roots, degrees or heights
    "a number under a root that is not squarefree": lambda g, x, y: (g.sqrt(3 * 1009**2), -1009 * g.sqrt(3)),
    "a product of large primes under a root": lambda g, x, y: (g.sqrt(1009) * g.sqrt(1013), -g.sqrt(1009 * 1013)),
    "a root among the sines of its angle": lambda g, x, y: (
        g.sin(g.pi * 3 / 11) / g.cos(g.pi * 3 / 11) + 4 * g.sin(g.pi * 2 / 11),
        -g.sqrt(11),
    ),
    "a function of a power of order p - 1": lambda g, x, y: (
        g.function(Op.TANH, g.power(x, ORDERS)),
        g.function(Op.TANH, 1),
    ),
    "a sine of a power of order p - 1": lambda g, x, y: (g.sin(g.power(x, ORDERS)), g.sin(g.power(x, 2 * ORDERS))),
    "a power of order p - 1": lambda g, x, y: (g.power(x, ORDERS), g.one),
    "a multiple of the primes": lambda g, x, y: (x * prod(PRIMES), g.zero),
    "a fraction of a prime": lambda g, x, y: (x / PRIMES[0], x),
    "small beside a large entry": lambda g, x, y: (g.sqrt(x) + g.sqrt(y) * 10, g.sqrt(x) + g.sqrt(y) * 11),
}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("name", TRAPS)
def test_traps_laid_for_the_fields_catch_nothing(name, seed):
    assert finding(TRAPS[name], seed=seed).verdict not in (Verdict.PROVED, "not shown")


@pytest.mark.parametrize("name", [name for name in TRAPS if "of order p - 1" not in name])
def test_traps_that_numbers_can_see_are_called_different(name):
    assert finding(TRAPS[name]).verdict == Verdict.DIFFERENT


def test_the_true_root_among_sines_is_proved():
    def hendecagon(g, x, y):
        return g.sin(g.pi * 3 / 11) / g.cos(g.pi * 3 / 11) + 4 * g.sin(g.pi * 2 / 11), g.sqrt(11)

    assert all(finding(hendecagon, seed=seed).verdict == Verdict.PROVED for seed in range(1, 6))


def test_first_differing_entry_is_named():
    graph = Graph()
    x = graph.symbol("x")
    claim = Claim("claim", "left", "right", (x, x * x, x), (x, x * 2, x * 3))

    assert prove([claim])[1][0].where == 1


# Fields and points


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "wanted", [Needs(1, 1, 1, (), 1), Needs(180, 10, 2, (3, 5, 11, 101), 7)], ids=["plain", "rich"]
)
def test_primes_have_127_bits_or_more_and_every_root_that_is_needed(seed, wanted):
    p = wanted.prime(seed)

    assert p.bit_length() == (127 if wanted.radian == 1 else 131)
    assert p % 5040 == 1
    assert p % (2 * wanted.turn) == 1
    assert all(pow(a, p - 1, p) == 1 for a in (2, 3, 5, 7, 11, 13))
    assert all(pow(n, (p - 1) // 2, p) == 1 for n in (-1 % p, 2, 3, 5, 7, *wanted.radicands))
    assert wanted.prime(seed) == p


def test_needs_are_read_off_the_angles_and_roots():
    graph = Graph()
    x = graph.symbol("x")
    outputs = [graph.sin(x / 3 + graph.pi * Fraction(37, 180)), graph.cos(x + Fraction(3, 10)), graph.sqrt(33)]

    assert Needs.of(reachable(outputs)) == Needs(turn=180, radian=10, atom=3, radicands=(3, 11), denominator=180)


def certificate(seed):
    w = Workspace(spatial_arm())
    claims = [
        Claim(name, "first", "lagrange", derive_one(w, name).entries, derive_one(w, name, "lagrange").entries)
        for name in ("inverse_dynamics", "mass_matrix")
    ]
    return prove(claims, seed=seed)


def test_a_seed_gives_one_certificate_and_another_seed_other_fields():
    fields, findings = certificate(7)

    assert certificate(7) == (fields, findings)
    assert [found.verdict for found in findings] == [Verdict.PROVED, Verdict.PROVED]
    assert certificate(8)[0].primes != fields.primes
    assert len(set(fields.primes)) == 2


# A mistake anywhere in a derivation

SWAP = {Op.ADD: "sub", Op.SUB: "add"}


def mutants(entries):
    """Yield (what, node, wrong node) for every single mistake: a wrong sign, a dropped term, a wrong operand."""
    graph = entries[0].graph
    nodes = [node for node in reachable(entries) if node.args]
    for node in nodes:
        if node.op in SWAP:
            yield "wrong sign", node, getattr(graph, SWAP[node.op])(*node.args)
            yield "dropped term", node, node.args[0]
            yield "dropped term", node, node.args[1]
        elif node.op is Op.NEG:
            yield "wrong sign", node, node.args[0]
        elif node.op is Op.MUL:
            yield "dropped factor", node, node.args[1]
        elif node.op in (Op.SIN, Op.COS):
            yield "sine for cosine", node, graph.function(Op.COS if node.op is Op.SIN else Op.SIN, *node.args)


def leaning():
    """Return the arm with gravity along no axis, so that no part of its gravity forces is zero."""
    return spatial_arm().with_gravity((Quantity.number(1), Quantity.number(-2), Quantity.number(Fraction("-9.81"))))


@pytest.mark.parametrize(
    ("scene", "output"),
    [(two_link(), "inverse_dynamics"), (two_link(), "forward_dynamics"), (leaning(), "gravity_forces")],
    ids=["two_link ID", "two_link FD", "spatial_arm g"],
)
def test_every_single_mistake_in_a_graph_is_caught(scene, output):
    w = Workspace(scene)
    right = derive_one(w, output, "crba" if output == "forward_dynamics" else "rnea").entries
    witness = derive_one(w, output, "lagrange").entries
    wrong = [(what, substitute(right, {node: bad})) for what, node, bad in mutants(list(right))]
    assert len(wrong) > 40
    claims = [Claim(f"{k} {what}", "wrong", "right", tuple(bad), witness) for k, (what, bad) in enumerate(wrong)]

    findings = prove([Claim("right", "derived", "witness", right, witness), *claims], primes=1, points=1)[1]

    assert findings[0].verdict == Verdict.PROVED
    assert [found.claim for found in findings[1:] if found.verdict != Verdict.DIFFERENT] == []


def test_swapped_indices_are_caught():
    w = Workspace(spatial_arm())
    for name, formulation in [("coriolis_matrix", "rnea"), ("k_D", "rnea"), ("k_C", "crba"), ("mass_matrix", "crba")]:
        entries, witness = derive_one(w, name, formulation).entries, derive_one(w, name, "lagrange").entries
        n = w.state.n
        transposed = tuple(entries[j * n + i] for i in range(n) for j in range(n))
        shifted = (*entries[1:], entries[0])
        claims = [Claim(name, "swapped", "witness", bad, witness) for bad in (transposed, shifted)]

        verdicts = [found.verdict for found in prove(claims)[1]]

        assert verdicts == [
            Verdict.PROVED if name == "mass_matrix" else Verdict.DIFFERENT,
            Verdict.DIFFERENT,
        ]  # only M is symmetric
