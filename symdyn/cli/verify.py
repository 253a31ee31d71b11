"""`symdyn verify SCENE`: prove the derivations equal and measure the built code; exit status 1 if anything fails."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from symdyn.cli.reading import add_formulation, add_prepare, add_reading_options, read_scene

if TYPE_CHECKING:
    from symdyn.verify import Certificate


def register(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the verb."""
    verb = verbs.add_parser("verify", help="prove the equations, measure the code", description=__doc__)
    add_reading_options(verb)
    verb.add_argument("--functions", metavar="LIST", help="comma-separated; default: all")
    add_formulation(verb)
    add_prepare(verb)
    verb.add_argument("--real", choices=("double", "float"), default="double", help="number type of the measured code")
    verb.add_argument("--seed", type=int, default=1, help="of primes, points and states (default: 1)")
    verb.add_argument("--json", action="store_true", help="print the certificate as JSON")
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the certificate."""
    from symdyn.cli.generate import split
    from symdyn.cli.talk import Waiting, print_json
    from symdyn.verify import certify

    scene = read_scene(options)
    outputs = split(options.functions) if options.functions is not None else None
    with Waiting() as progress:
        certificate = certify(
            scene, outputs, options.seed, progress, options.real, options.formulation, options.prepare
        )
    if options.json:
        print_json(certificate.as_dict())
    else:
        show(certificate)
    return 0 if certificate.passed else 1


def show(certificate: Certificate) -> None:
    """Print the certificate for people."""
    from symdyn.cli.talk import print_table
    from symdyn.verify import DIFFERENT, PROVED

    rows = []
    for finding in certificate.findings:
        sure = f"1e{finding.error_log10:.0f}" if finding.verdict == PROVED else ""
        verdict = f"{finding.verdict} at entry {finding.where}" if finding.verdict == DIFFERENT else finding.verdict
        rows.append((finding.claim, verdict, str(finding.degree or ""), sure))
    print_table(f"{certificate.scene}: equations", ("claim", "verdict", "degree ", "chance of error "), rows)
    fields = certificate.fields
    primes = " and ".join(map(str, fields.primes))
    print(f"Proved at {fields.points} random points each over the primes {primes} (seed {fields.seed}).\n")
    measured = [
        (a.function, a.module, f"{a.median_ulp:.2g}", f"{a.max_ulp:.2g}", f"{a.worst:.2g}", _word(a.passed))
        for a in certificate.accuracy
    ]
    columns = ("function", "module", "median ", "max ", "of bound ", "")
    states = certificate.accuracy[0].states if certificate.accuracy else 0
    title = f"Error of the built code against 50 digits, {states} states, ulp of the largest entry"
    print_table(title, columns, measured)
    print("Errors are in ulps of the largest entry; 'of bound' is the worst entry's share of its own error bound.\n")
    if certificate.refused:
        print(f"The C code was refused: {certificate.refused}")
    for note in certificate.notes:
        print(f"Note: {note}")
    print(f"{certificate.scene}: {_word(certificate.passed)}")


def _word(passed: bool) -> str:
    return "passed" if passed else "FAILED"
