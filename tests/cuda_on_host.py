"""CUDA without a GPU: kernels compiled as C++, where a launch is a loop over threads, on whatever stream."""

from __future__ import annotations

import ctypes
import itertools
import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from symdyn.runtime.library import SUFFIX

HEADER = """
#include <math.h>
#include <stdlib.h>
#include <string.h>
#define __global__
#define __device__
#define __forceinline__ inline
#define __shared__ static thread_local
#define __launch_bounds__(threads)
struct dim3 { unsigned x, y; dim3(unsigned a = 1, unsigned b = 1) : x(a), y(b) {} };
static thread_local dim3 blockIdx, blockDim, threadIdx, gridDim;
extern "C" { void *last_stream; }
static inline void on() {}
static inline void on(void *stream) { last_stream = stream; }
enum cudaError_t { cudaSuccess };
enum direction { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost };
typedef void *cudaStream_t;
static inline const char *cudaGetErrorString(cudaError_t) { return ""; }
static inline cudaError_t cudaGetLastError() { return cudaSuccess; }
static inline cudaError_t cudaMalloc(void **x, size_t n) { *x = malloc(n); return cudaSuccess; }
static inline cudaError_t cudaFree(void *x) { free(x); return cudaSuccess; }
static inline cudaError_t cudaMemcpy(void *to, const void *from, size_t n, direction)
{
    memcpy(to, from, n);
    return cudaSuccess;
}
"""

LAUNCH = re.compile(r"(\w+)<<<(.+?), (\d+)(?:, 0, \(cudaStream_t\)(\w+))?>>>\((.*?)\);")

STRICT = ["-Wall", "-Wextra", "-Wdouble-promotion", "-Wfloat-conversion", "-Wshadow", "-Werror", "-Wno-unused-function"]


def compiled(text: str, folder: Path, *flags: str, made: str = "made") -> Path:
    """Return what g++ makes of CUDA text in which every launch stands as a loop."""
    looped = (
        "{ on(\\4); blockDim.x = \\3; gridDim = \\2; for (blockIdx.y = 0; blockIdx.y < gridDim.y; ++blockIdx.y)"
        " for (blockIdx.x = 0; blockIdx.x < gridDim.x; ++blockIdx.x)"
        " for (threadIdx.x = 0; threadIdx.x < \\3; ++threadIdx.x) \\1(\\5); }"
    )
    (folder / "host.h").write_text(HEADER, encoding="utf-8")
    (folder / "host.cpp").write_text(LAUNCH.sub(looped, text), encoding="utf-8")
    command = ["g++", "-std=c++17", *STRICT, "-include", "host.h", *flags, "host.cpp", "-o", made]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / made


class Host:
    """A card whose kernels are compiled as C++, without products that are fused; what it compiled."""

    libraries = itertools.count()

    def __init__(self, folder: Path, *flags: str) -> None:
        self.folder, self.flags, self.texts = folder, flags, list[str]()

    def build(self, files: Mapping[str, str], machine: str) -> tuple[Path, ctypes.CDLL]:
        """Return the library of one file, which no other one of this process is called like, and its path."""
        assert machine == "host"
        (text,) = files.values()
        self.texts.append(text)
        made = f"host{next(self.libraries)}{SUFFIX}"
        folder = self.folder / made.partition(".")[0]
        folder.mkdir()
        path = compiled(text, folder, "-O1", "-ffp-contract=off", "-shared", "-fPIC", *self.flags, made=made)
        return path, ctypes.CDLL(str(path))


def launcher(
    text: str, folder: Path, names: Sequence[str], arities: Sequence[int], threads: int | None = None
) -> ctypes.CDLL:
    """Return a library with `run_<kernel>(blocks, n, arguments, out)` for every kernel; no products are fused.

    Blocks have so many threads, or as many as a kernel takes.
    """
    calls = []
    for name, arity in zip(names, arities, strict=True):
        given = "".join(f"a{i}, " for i in range(arity))
        head = given.replace("a", "REAL *a")
        calls.append(f'extern "C" void run_{name}(unsigned blocks, size_t n, {head}REAL *out)')
        calls.append(f"{{ {name}<<<blocks, {threads or block_of(text, name)}>>>(n, {given}out); }}")
    real = "float" if "const float" in text else "double"
    whole = "\n".join([text, *calls]).replace("REAL", real)
    return ctypes.CDLL(str(compiled(whole, folder, "-O1", "-ffp-contract=off", "-shared", "-fPIC", made="kernels.so")))


def run(library: ctypes.CDLL, name: str, n: int, given: Sequence[np.ndarray], out: np.ndarray) -> np.ndarray:
    """Run a kernel on columns, with more threads than states, and return `out`, columns too."""
    places = [ctypes.c_void_p(array.ctypes.data) for array in (*given, out)]
    getattr(library, f"run_{name}")(ctypes.c_uint(n // 24 + 2), ctypes.c_size_t(n), *places)
    return out


def block_of(text: str, name: str) -> int:
    """Return how many threads a block of a kernel has at most."""
    found = re.search(rf"__launch_bounds__\((\d+)\) {name}\(", text)
    assert found, f"no kernel {name}"
    return int(found[1])
