"""`symdyn identify SCENE DATA.csv`: base parameters from measured motion and forces, with standard errors."""

from __future__ import annotations

import argparse

from symdyn.cli.excite_options import EXCITING, add_exciting, run_exciting
from symdyn.cli.identify_files import add_file_options, check_files, write_files
from symdyn.cli.identify_runs import OUTPUT_ERROR, RUNS, add_run_options, run_output_error
from symdyn.cli.payload_options import FORM, payloads
from symdyn.cli.scene_options import add_reading_options, again, read_scene, say_values_alone
from symdyn.cli.talk import Waiting, give, print_table, print_text, say
from symdyn.cli.trajectory_options import pairs
from symdyn.errors import IdentifyError
from symdyn.identification import Identification, identify
from symdyn.rounding import finite, in_digits
from symdyn.scene.values import split_commas

EXCITE, REGRESSION = "--excite", "--by regression"

WAYS = {
    REGRESSION: ("band", "friction", "hold_back", "units", "payload", "keep_outliers", "output", "total_mass", "force"),
    f"--by {OUTPUT_ERROR}": RUNS,
    EXCITE: (*EXCITING, "output"),
}
"""What the verb can do, and the options that are of it; one that would do nothing is refused."""


def add_options(verb: argparse.ArgumentParser) -> None:
    """Add what the verb takes."""
    gained = ", ".join(Identification.gain_units).replace("%", "%%")
    add_reading_options(verb)
    verb.add_argument(
        "data",
        nargs="*",
        metavar="DATA.csv",
        help="columns t, coordinates and driving forces, as simulate writes them; several files are several logs",
    )
    verb.add_argument("--band", type=float, metavar="HZ", help="highest frequency used; else from where noise begins")
    verb.add_argument(
        "--friction",
        metavar="LIST",
        help=f"terms of every drive beside what the scene declares: {', '.join(Identification.friction_terms)}, or all",
    )
    verb.add_argument("--hold-back", type=float, metavar="SHARE", help="part of every log that judges the result: 0.25")
    verb.add_argument(
        "--units",
        metavar="LIST",
        help="columns that are not in SI with radians, e.g. t=ms,q*=deg,tau1=Ncm; "
        f"drives whose gain is not known, e.g. tau*=A: {gained}; and those whose gain is, tau1=0.12*A",
    )
    verb.add_argument(
        "--payload",
        action="append",
        default=[],
        metavar="P",
        help=f"what a log was measured with, {FORM}, which tells "
        "gains; com in the frame of the body, m, and inertia about com, kg m^2, are found where they are not given",
    )
    verb.add_argument("--keep-outliers", action="store_true", help="fit samples too that no noise explains")
    add_file_options(verb)
    add_run_options(verb)
    add_exciting(verb)


def run(options: argparse.Namespace) -> int:
    """Identify, print, write."""
    way = EXCITE if options.excite else f"--by {options.by}"
    _check_way(options, way)
    if options.excite:
        return run_exciting(options)
    scene = read_scene(options)
    if not options.data:
        raise IdentifyError(
            f"{scene.name}: no data; give a CSV file, as in `symdyn identify {options.scene} log.csv`, with the "
            "columns t, coordinates and driving forces"
        )
    if options.by == OUTPUT_ERROR:
        return run_output_error(scene, options)
    if not options.output:
        say_values_alone(options, scene, "identify without -o")
    check_files(options)
    carried = payloads(options.payload)
    terms = [one.strip() for one in split_commas(options.friction or "")]
    with Waiting() as progress:
        progress("identifying")
        found = identify(
            scene,
            options.data,
            options.band,
            Identification.friction_terms if terms == ["all"] else [one for one in terms if one],
            options.hold_back or 0.0,
            not options.keep_outliers,
            pairs(options.units, "--units"),
            payloads=carried,
        )
    for note in found.notes:
        say(note)
    write_files(found, options.output, options.total_mass, again(options))
    if options.json:
        give(finite(found.as_dict()))
    else:
        show(found)
    return 0


def _check_way(options: argparse.Namespace, way: str) -> None:
    """Raise IdentifyError for options of another way."""
    faults = []
    if options.excite and options.by == OUTPUT_ERROR:
        faults.append(f"--by {OUTPUT_ERROR}: {EXCITE} fits nothing; leave one of the two out")
    for other, names in WAYS.items():
        for name in names:
            value = getattr(options, name)
            if name not in WAYS[way] and not (value is None or value is False or value == []):
                option = "-o" if name == "output" else f"--{name.replace('_', '-')}"
                faults.append(f"{option}: of {other}, which is not given")
    if faults:
        raise IdentifyError(list(dict.fromkeys(faults)))


def show(identification: Identification) -> None:
    """Print the tables."""
    for table in identification.tables:
        print_table(table)
    regression = identification.regression
    print_text(
        f"condition number {in_digits(regression.condition, 3)}, band {in_digits(identification.band, 3)} Hz, "
        f"{len(regression.tau)} rows, {regression.dof} degrees of freedom"
    )
