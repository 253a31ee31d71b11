"""What was proved, in a notebook: the verdict, and behind it every claim."""

from __future__ import annotations

from collections import Counter

from symdyn.notebook.page import Markup, folded, head, note, notes, table, verdict
from symdyn.verdict import Claims, Verdict
from symdyn.verify import Certificate, Finding, Rigorous


def certificate(result: Certificate) -> list[Markup]:
    """Return the verdict of a certificate, what failed, and the rest folded."""
    counts = ", ".join(f"{n} {name}" for name, n in Counter(one.verdict for one in result.findings).items())
    likely = max((one.error_log10 for one in result.findings if one.verdict == Verdict.PROVED), default=0.0)
    sure = f"; the chance that a false one passed is below 1e{likely:.0f}" if likely else ""
    fields = result.fields
    primes = " and ".join(map(str, fields.primes))
    return [
        head(result.scene, "certificate"),
        verdict(result.passed, result.word),
        note(f"claims: {counts or 'none'}{sure}"),
        *_claims(result),
        folded(
            f"{len(result.findings)} claims",
            table(("claim", "verdict", "degree", "chance of error"), map(_finding, result.findings)),
            note(f"at {fields.points} random points each over the primes {primes}, seed {fields.seed}"),
        ),
        *([_files(result)] if result.written else []),
        folded(
            "error of the built code against 50 digits",
            table(
                ("function", "module", "states", "median, ulp", "largest, ulp", "of its bound"),
                (
                    (a.function, a.module, a.states, *((a.median_ulp, a.max_ulp, a.worst) if a.states else ("",) * 3))
                    for a in result.accuracy
                ),
            ),
            note("ulp of the largest entry of the result"),
        ),
        *notes(result.notes),
    ]


def _claims(claims: Claims) -> list[Markup]:
    """Return what does not hold and why, and what is no claim: tables, of which those without rows are nothing."""
    return [table((word, "why"), rows) for word, rows in claims.apart.items()]


def _files(result: Certificate) -> Markup:
    return folded(
        "files read back",
        table(
            ("target", "option", "file", "SHA-256", "arithmetic", "functions", "bytes of fixed text"),
            (
                (w.target, w.option, w.file, w.sha256[:12], w.verdict or "none", len(w.functions), w.compared)
                for w in result.written
            ),
        ),
        note("the same functions, constants rounded correctly; fixed text is that of the templates, and measured"),
    )


def _finding(one: Finding) -> tuple[str, str, str, str]:
    sure = f"1e{one.error_log10:.0f}" if one.verdict == Verdict.PROVED else ""
    return one.claim, one.verdict, str(one.degree or ""), sure


def rigorous(result: Rigorous) -> list[Markup]:
    """Return whether every error is bounded, and the largest bound of every function and module."""
    worst: dict[tuple[str, str], tuple[float, float]] = {}
    for one in result.bounds:
        error, ulps = worst.get((one.function, one.module), (0.0, 0.0))
        worst[one.function, one.module] = max(error, one.error), max(ulps, one.ulps)
    states = max((len(some) for some in result.states.values()), default=0)
    return [
        head(result.scene, f"guaranteed bounds of the error, {result.real}"),
        verdict(result.passed, "every error is bounded" if result.passed else result.verdict),
        *_claims(result),
        table(
            ("function", "module", "error, at most", "ulps, at most"), ((*key, *most) for key, most in worst.items())
        ),
        note(f"at {states} state{'s' * (states != 1)}; balls of up to {result.bits} bits"),
        *notes(result.notes),
    ]
