"""Functions for MATLAB, run by Octave: as text, and as C that a MEX gateway calls; timed inside Octave."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from cases import Case
from harness import Timed

from symdyn.emit import emit, write
from symdyn.emit.code import stem
from symdyn.emit.targets.array_languages import FLAGS, MEX
from symdyn.runtime.machine import compile_mex, find_octave
from tools.ours import MANY, OUTPUTS, many

AT_ONCE = {"octave": 5_000, "mex": MANY}
"""States of a call: text costs least with some thousand, whose rows lie in the cache."""

SCRIPT = """
numbers = @(name, rows) reshape(fread(fopen(name), Inf, 'double=>double'), rows, []);
given = cell(1, {count});
for k = 1:{count}, given{{k}} = numbers(sprintf('{folder}/given%d', k), {lengths}(k)); end
first = cellfun(@(a) a(:, 1:min(end, {states})), given, 'UniformOutput', false);
h = fopen('{folder}/found', 'w'); fwrite(h, {name}(first{{:}}), 'double'); fclose(h);
puts("ready\\n"); fflush(stdout);
while ischar(line = fgetl(stdin))
  start = cputime();
  for k = 1:str2double(line), found = {name}(first{{:}}); end
  if ~isempty(line), printf("%.17g\\n", cputime() - start); fflush(stdout); end
end
"""


def version() -> str:
    """Return which Octave, and how C is compiled for it."""
    told = subprocess.run([find_octave(), "--version"], capture_output=True, text=True, check=True).stdout
    return f"{told.splitlines()[0].removeprefix('GNU ')}, mkoctfile {FLAGS}"


def timed(case: Case) -> list[Timed]:
    """Return text and MEX, batches."""
    return [_timed(case, output, peer) for output in OUTPUTS for peer in AT_ONCE]


def _timed(case: Case, output: str, peer: str) -> Timed:
    program, arguments, states = case.programs[output], many(case, output), AT_ONCE[peer]
    folder, package = TemporaryDirectory(), stem(program.scene.name)
    write(emit(program, "matlab", option=MEX if peer == "mex" else ""), folder.name)
    if peer == "mex":
        compile_mex(folder.name, package)
    for k, array in enumerate(arguments, 1):
        (Path(folder.name) / f"given{k}").write_bytes(array.astype("<f8").tobytes())
    lengths = f"[{' '.join(str(array.shape[-1]) for array in arguments)}]"
    values = {"count": len(arguments), "folder": folder.name, "lengths": lengths, "states": states}
    code = SCRIPT.format(name=f"{package}.{output}", **values)
    words = [find_octave(), "--quiet", "--norc", "--path", folder.name, "--eval", code]
    process = subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None, "it was given a pipe"
    assert process.stdout.readline() == "ready\n", "Octave computes the states once before it is timed"
    known, shape = len(case.references[output]), program.routines[0].function.shape
    pages = np.fromfile(Path(folder.name) / "found").reshape(states, *shape[::-1])[:known]
    found = pages.transpose(0, *range(len(shape), 0, -1)).reshape(known, -1)
    return Timed(case.name, output, peer, "batch", states, _sweep(process, folder), lambda: found, own_clock=True)


def _sweep(process: subprocess.Popen[str], folder: TemporaryDirectory[str]) -> Callable[[int], float]:
    """Return what asks Octave for the processor time of so many calls; its files stay as long as that is there."""

    def sweep(sweeps: int, folder: TemporaryDirectory[str] = folder) -> float:
        assert process.stdin is not None and process.stdout is not None, "it was given pipes"  # noqa: PT018
        process.stdin.write(f"{sweeps}\n\n")  # Octave reads a line when something follows it
        process.stdin.flush()
        return float(process.stdout.readline())

    return sweep
