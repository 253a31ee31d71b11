"""Code for ARM's vectors: built by a cross compiler, run under an emulator, the same bits as on this machine."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from patience import HANG
from programs import path_of

import symdyn
from symdyn.emit import emit

pytestmark = [pytest.mark.runs("cc", "aarch64-gcc", "qemu-aarch64"), pytest.mark.long]

FLAGS = ["-O3", "-fopenmp-simd", "-fno-math-errno", "-ffp-contract=off"]
"""Products and sums rounded one by one: which of them a compiler joins is its own choice on each machine."""

COUNT = 131
"""Two blocks and three states."""

DRIVER = """
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include "arm7.h"
#define N {count}
static {real} q[7 * N], qd[7 * N], qdd[7 * N], out[49 * N];
static void drawn({real} *x, uint64_t seed)
{{
    for (int k = 0; k < 7 * N; k++) {{
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        x[k] = ({real})((double)(int64_t)seed / 2147483648.0 / 1073741824.0);
    }}
}}
static void say(const char *name, int count)
{{
    unsigned char bytes[sizeof *out];
    printf("%s", name);
    for (int k = 0; k < count; k++) {{
        memcpy(bytes, out + k, sizeof *out);
        printf(" ");
        for (size_t i = 0; i < sizeof *out; i++) printf("%02x", bytes[i]);
    }}
    printf("\\n");
}}
int main(void)
{{
    drawn(q, 1), drawn(qd, 2), drawn(qdd, 3);
    for (int k = 0; k < N; k++) arm7_inverse_dynamics(q + 7 * k, qd + 7 * k, qdd + 7 * k, out + 7 * k);
    say("one", 7 * N);
    arm7_inverse_dynamics_rows(N, q, qd, qdd, out), say("rows", 7 * N);
    arm7_inverse_dynamics_batch(N, q, qd, qdd, out), say("columns", 7 * N);
    arm7_mass_matrix_rows(N, q, out), say("rows of M", 49 * N);
    arm7_mass_matrix_batch(N, q, out), say("columns of M", 49 * N);
    return 0;
}}
"""


def ran(compiler: str, flags: list[str], before: list[str], folder: Path) -> str:
    """Return what the driver prints, compiled and run."""
    program = folder / Path(compiler).name
    subprocess.run(
        [compiler, *FLAGS, *flags, "driver.c", "arm7.c", "-o", program, "-lm"], cwd=folder, check=True, timeout=HANG
    )
    return subprocess.run([*before, program], capture_output=True, text=True, check=True, timeout=HANG).stdout


@pytest.mark.wide("double")
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_same_bits_on_arm_as_here(real: str, tmp_path: Path) -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("arm7"), ["inverse_dynamics", "mass_matrix"]))
    for name, text in emit(program, "c", real, option="batch").files:
        (tmp_path / name).write_text(str(text), "utf-8")
    (tmp_path / "driver.c").write_text(DRIVER.format(count=COUNT, real=real), "utf-8")
    here, cross, emulator = (path_of(name) or "" for name in ("cc", "aarch64-gcc", "qemu-aarch64"))

    native = ran(here, [], [], tmp_path)
    arm = ran(cross, ["-static"], [emulator], tmp_path)

    assert native.count("\n") == 5
    assert arm == native


def test_loops_over_states_become_vectors_of_arm(tmp_path: Path) -> None:
    program = symdyn.program.lower(symdyn.dynamics.derive(symdyn.example("arm7"), ["inverse_dynamics"]))
    for name, text in emit(program, "c", option="batch").files:
        (tmp_path / name).write_text(str(text), "utf-8")
    command = [path_of("aarch64-gcc") or "", *FLAGS, "-S", "arm7.c", "-o", "arm7.s"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=HANG)
    text = (tmp_path / "arm7.s").read_text("utf-8")
    loops = re.findall(r"^inverse_dynamics_pass[0-9]+[.\w]*:.*?\.size", text, re.DOTALL | re.MULTILINE)

    products = [line for loop in loops for line in loop.splitlines() if line.split()[:1] == ["fmul"]]
    assert len(products) > 200
    assert all(".2d" in line for line in products)
