"""Our kernels in OpenCL on the processor, by PyOpenCL and pocl: columns that lie there already, one launch a call.

pocl is held to one thread, and what is told is its own processor time.
"""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np
from cases import Case
from harness import Timed
from native import MissingError

from symdyn.emit import emit
from symdyn.runtime.runners import compiled_kernels
from tools.ours import MANY, OUTPUTS, many

os.environ.setdefault("POCL_MAX_PTHREAD_COUNT", "1")


def version() -> str:
    """Return which OpenCL computes."""
    import pyopencl as cl

    return "; ".join(f"{one.name} {one.version.strip()}" for one in cl.get_platforms()) + ", one thread"


def timed(case: Case) -> list[Timed]:
    """Return the kernel of each output over many states."""
    return [_timed(case, output) for output in OUTPUTS]


def _timed(case: Case, output: str) -> Timed:
    sources = emit(case.programs[output], "gpu")
    queue, kernels = compiled_kernels(sources)
    import pyopencl as cl

    if not queue.device.type & cl.device_type.CPU:
        raise MissingError("a graphics card computes here, whose time is not the processor's")
    kernel = getattr(kernels, f"{next(iter(sources)).removesuffix('.cu')}_{output}")
    columns = [np.ascontiguousarray(array.T) for array in many(case, output)]
    flags = cl.mem_flags
    given = [cl.Buffer(queue.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=column) for column in columns]
    known, size = case.references[output].shape
    out = np.empty((size, MANY))
    buffer = cl.Buffer(queue.context, flags.WRITE_ONLY, out.nbytes)

    def sweep(sweeps: int) -> float:
        start = time.process_time()
        for _ in range(sweeps):
            kernel(queue, (MANY,), None, np.uint64(MANY), *given, buffer)
        queue.finish()
        return time.process_time() - start

    def result() -> Any:
        sweep(1)
        cl.enqueue_copy(queue, out, buffer)
        return out[:, :known].T

    return Timed(case.name, output, "opencl, pocl", "batch", MANY, sweep, result, own_clock=True)
