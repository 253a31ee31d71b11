"""Recipe: a target is one row. Import this file, and `symdyn generate --target awk` writes programs for awk.

    echo "mass_matrix 0.1 0.2 1 1 1 1 1" | awk -f two_link.awk

Each line of input is a function and the numbers of its arguments; each line of output, the result. Arrays begin at 1.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from functools import partial
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np

from symdyn import emit
from symdyn.emit import TARGETS, Draft, Sources, Target
from symdyn.emit.code.spelling import ANY, ATOM, OPERATORS, SIGN, SUM, Printer, Spelling, call, digits
from symdyn.emit.code.target import FunctionText
from symdyn.emit.render import in_comment
from symdyn.errors import BuildError, MissingProgram
from symdyn.graph import Op
from symdyn.runtime import RUNNERS, Runner

OWN = {
    Op.ABS: ("abs_of", "return x < 0 ? -x : x"),
    Op.SIGN: ("sign_of", "return (x > 0) - (x < 0)"),
    Op.TANH: ("tanh_of", "for (k = 27; k > 0; k -= 2) y = k + x * x / (k > 25 ? k + 2 : y); return x / y"),
}
"""What awk lacks: name and body of a function of x. The continued fraction of tanh is right for angles below 2."""

SPELLINGS = {
    **OPERATORS,
    **{op: call(name) for op, (name, _) in OWN.items()},
    **{op: call(op.name.lower()) for op in (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG)},
    Op.ATAN2: call("atan2", 2),
    Op.POW: Spelling("{}^{}", SIGN, (ATOM, ATOM)),
    Op.SELECT: Spelling("({0} > 0 ? {1} : {0} <= 0 ? {2} : {0})", ATOM, (SUM, ANY, ANY)),
}

KEYWORDS = """BEGIN END break close continue cos delete do else exit exp for func function getline gsub if in index int
length log match next print printf rand return sin split sprintf sqrt srand sub substr system tolower toupper while
i out params prepared q qd qdd t tau"""
"""Reserved words, and what variables are called, which functions may not be."""


def write(draft: Draft) -> dict[str, str]:
    """Return the program: functions of our own where they are called, those of the scene, a rule for each."""
    used = {op for function in draft.page.functions for op in function.operations}
    own = [f"function {name}(x,    k, y) {{ {body} }}" for op, (name, body) in OWN.items() if op in used]
    parts = [draft.about, *own, *map(definition, draft.page.functions), *map(rule, draft.page.functions)]
    return {f"{draft.stem}.awk": "\n\n".join(parts) + "\n"}


def definition(function: FunctionText) -> str:
    names = ", ".join([*(argument.name for argument in function.arguments), "out"])
    given = [(x, name if name in function.scalars else f"{name}[{k}]") for x, name, k in function.inputs]
    lines = [f"    {name} = {code}" for name, code in given]
    lines += [f"    {line.target} = {line.code}" for line in function.steps]
    lines += [f"    out[{k}] = {line.code}" for k, line in enumerate(function.outputs, 1)]
    return "\n".join([f"function {function.name}({names}) {{", *lines, "}"])


def rule(function: FunctionText) -> str:
    lines, place = [f'$1 == "{function.name}" {{'], 1
    for a in function.arguments:
        lines.append(f"    for (i = 1; i <= {a.length}; i++) {a.name}[i] = $(i + {place})")
        place += a.length
    handed = [f"{a.name}[1]" if a.scalar else a.name for a in function.arguments]
    lines.append(f"    {function.name}({', '.join([*handed, 'out'])})")
    lines.append(f'    for (i = 1; i <= {len(function.outputs)}; i++) printf "%.17g ", out[i]')
    return "\n".join([*lines, '    print ""', "}"])


def run(sources: Sources) -> Any:
    """Return the functions of sources, each call an awk of its own."""
    awk = shutil.which("awk")
    if awk is None:
        raise MissingProgram("no awk found; install mawk or gawk")
    folder = TemporaryDirectory()
    (path,) = emit.write(sources, folder.name)

    def function(name: str, shape: tuple[int, ...]) -> Callable[..., Any]:
        def call(*values: Any) -> Any:
            words = [name, *(repr(float(x)) for value in values for x in np.ravel(value))]
            command = [awk, "-f", str(path)]
            done = subprocess.run(command, input=" ".join(words), capture_output=True, text=True, check=False)
            if done.returncode:
                raise BuildError(f"{awk} refused the code: {done.stderr}")
            return np.array(done.stdout.split(), dtype=float).reshape(shape)[()]

        return call

    shapes = [routine.function.shape for routine in sources.program.routines]
    calls = {name: function(name, shape) for name, shape in zip(sources.functions, shapes, strict=True)}
    return SimpleNamespace(**calls, _folder=folder)


AWK = Target(
    name="awk",
    title="awk",
    text="a program for awk",
    files={"{stem}.awk": str},
    first=1,
    keywords=frozenset(KEYWORDS.split()),
    printer=lambda real: Printer(SPELLINGS, partial(digits, real=real)),
    comment=partial(in_comment, prefix="# "),
    write=write,
)

TARGETS[AWK.name] = AWK
RUNNERS[AWK.name] = Runner(run, batches=False, many="", measured="", usual=False, by_name_only=True, aside=False)
