"""Motions, many runs and proofs in a notebook.

A motion has its plots, and how it ended; many runs have quantiles, plots, Sobol's indices, error bars; a certificate
has the verdict, and behind it every claim.
"""

from __future__ import annotations

from collections import Counter

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.identification import Excitation
from symdyn.notebook.page import Cell, Markup, folded, head, note, notes, plotted, table, verdict
from symdyn.simulation import Feedback, Trajectory, Uncertainty
from symdyn.study import Indices, Runs
from symdyn.transcription import Collocation, Solution
from symdyn.verdict import Claims, Verdict
from symdyn.verify import Certificate, Finding, Rigorous


def trajectory(result: Trajectory) -> list[Markup]:
    """Return the plots of a motion, how it ended, and how well the laws of mechanics were kept."""
    count = len(result.t)
    span = f"t = {result.t[0]:g} to {result.t[-1]:g} s, {count} samples" if count else "no samples"
    method = f", {result.method}" if result.method else ""
    ended = [] if result.complete else [verdict(False, f"ended by: {result.stopped}")]
    monitors = [(words, float(value)) for words, value in result.monitor_rows]
    lines = result.cut_lines
    events = [(event.formula, event.t, "ended the run" if event.stops else "") for event in result.events]
    return [
        head(result.scene.name, span + method),
        *ended,
        _plots(result),
        table(("event", "t, s", ""), events),
        folded("saturation", table(("",), [(line,) for line in lines])) if lines else Markup(""),
        folded("how well the laws of mechanics were kept", table(("", ""), monitors)) if monitors else Markup(""),
        *notes(result.notes),
    ]


def feedback(result: Feedback) -> list[Markup]:
    """Return what a controller measures and drives, and how."""
    first, *_ = repr(result)[1:-1].split(",")
    return [head(first), table(("", ""), [(name, str(value)) for name, value in result.given.items()])]


def excitation(result: Excitation) -> list[Markup]:
    """Return how well an exciting motion identifies base parameters, its plots, and how near it comes to its limits."""
    rows: list[tuple[str, Cell]] = [
        ("condition number", result.condition),
        ("condition number of columns of length 1", result.scaled_condition),
        ("-ln det", result.determinant),
        ("least distance to a limit, of half its room", result.margin),
    ]
    limits = [
        (one.bound.name, one.bound.low, one.low, one.high, one.bound.high, one.bound.unit, "reached" * one.active)
        for one in result.reached
    ]
    starts = [(f"{k + 1}", one.before, one.after, "" if one.keeps else "leaves limits")
              for k, one in enumerate(result.starts)]  # fmt: skip
    return [
        head(result.scene.name, f"exciting motion, {result.family}, {result.terms} terms, {result.period:g} s"),
        table(("", ""), rows),
        _plots(result.run),
        folded("limits", table(("", "lower", "least", "largest", "upper", "unit", ""), limits)),
        folded("starts of the search", table(("", f"{result.criterion} as drawn", "as found", ""), starts)),
        *notes(result.notes),
    ]


def _plots(result: Trajectory) -> Markup:
    if not len(result.t):
        return Markup("")
    return plotted(result.drawn, len(result.t) * len(result.names), f"plots of {result.scene.name}")


def collocation(result: Collocation) -> list[Markup]:
    """Return what is looked for, and how large a problem it is."""
    rows: list[tuple[str, Cell]] = [
        ("intervals", len(result.grid.widths)), ("method", result.method.text), ("unknowns", result.size),
        ("equations", result.rows), ("forces", ", ".join(result.drives) or "none"),
        ("parameters", ", ".join(result.free) or "none"),
    ]  # fmt: skip
    return [head(result.scene.name, "optimal control problem"), table(("", ""), rows), *notes(result.notes)]


def solution(result: Solution) -> list[Markup]:
    """Return the motion that was found, and what the solver says."""
    rows: list[tuple[str, Cell]] = [
        ("objective", result.objective), ("largest miss of a bound or an equation", result.violation),
        ("iterations", result.iterations), ("duration, s", result.duration), *result.parameters.items(),
    ]  # fmt: skip
    return [
        head(result.problem.scene.name, "a motion that a solver found"),
        verdict(result.success, result.status),
        table(("", ""), rows),
        table(("optima", "objective"), [(k, one.objective) for k, one in enumerate(result.optima, 1)])
        if result.others
        else Markup(""),
        *notes(result.notes),
        _plots(result.run),
    ]


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


SHARES = (0.05, 0.5, 0.95)
"""Quantiles that are shown."""

ROWS = 12
"""Columns of a run whose error bars at the end are shown."""


def runs(result: Runs) -> list[Markup]:
    """Return how many runs there are, how they ended, quantiles of their measures, and a plot."""
    body: list[list[Cell]] = [
        [name, result.units.get(name, ""), *(float(x) for x in result.quantiles(name, SHARES))]
        for name in result.measures or result.outcomes
    ]
    failed = [verdict(False, f"{result.failed} of {len(result)} runs failed")] if result.failed else []
    left = [verdict(False, f"{result.left} of {len(result)} runs are not made")] if result.left else []
    names = ", ".join(result.names)
    whole = len(result.reasons) == result.failed + result.stopped  # of a sweep the first few are told
    ended = list(Counter(result.reasons.values()).items()) if whole else []
    return [
        head(result.scene, f"{len(result)} runs over {names}, design {result.about.get('design', '')}"),
        *failed,
        *left,
        table(("measure", "unit", *(f"{100 * share:g} %" for share in SHARES)), body),
        *([table(("ended by", "runs"), ended)] if ended else []),
        _picture(result),
        *notes(result.notes),
    ]


def _picture(result: Runs) -> Markup:
    if not any(result.known(name).size for name in result.measures or result.outcomes):
        return note("no run has a value")
    try:
        return plotted(result.drawn, 2 * len(result), f"plots of {result.scene}")
    except SimulateError as fault:  # too few groups for indices
        return note(str(fault))


def indices(result: Indices) -> list[Markup]:
    """Return Sobol's indices with their intervals."""
    each = zip(result.names, result.first, result.first_interval, result.total, result.total_interval, strict=True)
    body: list[list[Cell]] = [
        [name, float(first), _between(near), float(total), _between(far)] for name, first, near, total, far in each
    ]
    level = f"{100 * result.level:g} % interval"
    return [
        head(result.measure, f"parts of its variance, from {result.groups} groups of runs"),
        table(("name", "first order", level, "total order", level), body),
        *notes(result.notes),
    ]


def _between(interval: Array) -> str:
    return f"{interval[0]:.3g} … {interval[1]:.3g}"


def uncertainty(result: Uncertainty) -> list[Markup]:
    """Return error bars at the end of a run, what they are due to, and a plot."""
    body: list[list[Cell]] = []
    for one in result.columns[:ROWS]:
        shares = zip(result.varied, result.shares(one.name)[-1], strict=True)
        due = ", ".join(f"{name} {100 * part:.3g} %" for name, part in shares)
        body.append([one.name, one.unit, float(result.run[one.name][-1]), float(result[one.name][-1]), due])
    points = 2 * len(result.t) * len(result.names)  # curves, and the edges of bands
    return [
        head(result.run.scene.name, f"error bars to first order, by {', '.join(result.varied)}"),
        table(("column", "unit", f"at t = {result.t[-1]:g} s", "standard deviation", "variance is due to"), body),
        plotted(result.drawn, points, f"error bars of {result.run.scene.name}"),
        *notes(result.notes),
    ]
