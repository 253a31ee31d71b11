"""The page docs/accuracy.md and its pictures: run time against error of examples, hard cases, each with its command.

python benchmarks/accuracy_page.py
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from symdyn.bench import bench, stress
from symdyn.bench.report import curve_tables, measured_table, pictures, remarks
from symdyn.scene import read

ROOT = Path(__file__).parent.parent
PAGE, FOLDER = ROOT / "docs" / "accuracy.md", ROOT / "docs" / "accuracy"

FUNCTIONS = ("inverse_dynamics", "forward_dynamics", "mass_matrix")
TOLD = ("1e-06", "1e-09", "1e-12")
EXAMPLES = ("double_pendulum", "puma560", "heavy_top", "four_bar")

HEAD = """# Run time against error

Made by `make accuracy`; the command under each picture makes the numbers of that picture again, as a page, as Markdown
and as JSON. Errors are the 99th percentile over sampled states of the largest error of an entry, relative to the
largest entry, against the same graph at 50 digits, in the worst of four regions: near zero, the whole range, near
singular positions, turns of 1e3 to 1e6 rad. Times are ns a state. A ring marks what no other implementation beats in
both; hollow points are float. Motions are judged at their end, against Taylor's method with more digits than a double,
and over a long time by their energy.

{about}
"""


def main() -> int:
    """Measure, draw, write."""
    FOLDER.mkdir(exist_ok=True)
    lines: list[str] = []
    about = ""
    for name in EXAMPLES:
        command = f"symdyn bench examples/{name}.toml --functions {','.join(FUNCTIONS)} -o {name}"
        found = bench(read(ROOT / "examples" / f"{name}.toml"), FUNCTIONS, command=command, progress=print)
        about = ", ".join(f"{key}: {value}" for key, value in found.about) + "."
        lines += [f"## {name}", ""]
        for title, picture in pictures(found).items():
            path = FOLDER / f"{name}_{title}.svg"
            path.write_text(picture + "\n", "utf-8")
            lines += [f"![{name}: {title}](accuracy/{path.name})", "", f"    {command}", ""]
        for function in found.functions:
            table = measured_table(found, function)
            best = replace(table, columns=table.columns[:-1], rows=[row[:-1] for row in table.rows if row[-1]])
            lines += [f"Best choices of `{function}`:", "", best.markdown(str), ""]
        if found.motion is not None:
            lines += [f"{line}\n" for line in remarks(found.motion)]
            for table in curve_tables(found.motion):
                lines += [replace(table, rows=[row for row in table.rows if row[1] in TOLD]).markdown(str), ""]
        lines += [f"Note: {note}\n" for note in found.notes]
    hard = stress(progress=print)
    lines += ["## Hard cases", "", "    symdyn stress -o stress", ""]
    lines += [replace(hard.table, title="").markdown(str)]
    PAGE.write_text(HEAD.format(about=about) + "\n" + "\n".join(lines).rstrip("\n") + "\n", "utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return int(not hard.passed)


if __name__ == "__main__":
    sys.exit(main())
