"""The only file that runs OpenCL: generated kernels as Python callables, through PyOpenCL, on whatever device there is.

A graphics card is taken where there is one, else the processor, where `pocl-opencl-icd` or another OpenCL for it is
installed. Arrays come and go as rows, one a state; kernels read columns.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symdyn.emit import Sources, budgets
from symdyn.emit.code import REALS
from symdyn.errors import BuildError, MissingProgram
from symdyn.runtime.c_module import Array, CFunction
from symdyn.runtime.warned import check_target

VENDORS, VENDORS_VARIABLE = "/etc/OpenCL/vendors", "OCL_ICD_VENDORS"
"""Where systems say which OpenCL there is, and what tells PyOpenCL's own loader, which looks elsewhere."""

KINDS = ("GPU", "ACCELERATOR", "CPU")
"""Devices, those that are asked first first."""

Launch = Callable[[int, Sequence[Array], Array], None]


def run_opencl(sources: Sources) -> SimpleNamespace:
    """Return the kernels of sources that `emit(program, "gpu")` made as functions of one state or many.

    Raises:
        BuildError: sources of another target, or OpenCL's own words where it refuses them.
        MissingProgram: there is no PyOpenCL, no OpenCL, or no device that computes in the type of the sources.
    """
    check_target(sources, "gpu")
    opening = sources.stem
    queue, kernels = compiled_kernels(sources)
    real = REALS[sources.real]
    functions = {
        name: KernelFunction(
            name=name,
            arguments=tuple((a.name, a.shape) for a in routine.function.arguments),
            shape=routine.function.shape,
            dtype=real.dtype,
            text=routine.function.text,
            _call=_launch(queue, getattr(kernels, f"{opening}_{name}"), len(room.plans)),
            _rows=True,
        )
        for name, routine, room in zip(
            sources.functions, sources.program.routines, budgets(sources.program, real), strict=True
        )
    }
    return SimpleNamespace(**functions)


@dataclass(frozen=True)
class KernelFunction(CFunction):
    """One kernel as a function of rows, (..., n); all states of a call are one launch if they share their params."""

    def _run_rows(self, arrays: Sequence[Array], batch: tuple[int, ...], out: Array) -> None:
        """Launch the kernel once for all states."""
        count, common = prod(batch), self._shared
        columns = [
            array.ravel()
            if name == common
            else np.broadcast_to(array, (*batch, array.shape[-1])).reshape(count, -1).T.ravel()
            for array, (name, _) in zip(arrays, self.arguments, strict=True)
        ]
        found = np.empty((prod(self.shape), count), self.dtype)
        self._call(count, columns, found)
        out.reshape(count, -1)[:] = found.T

    def _run(self, rows: Sequence[Array], out: Array, count: int) -> None:
        """Launch the kernel for every state by itself: each has params of its own."""
        given = [row.reshape(count, -1) for row in rows]
        results = out.reshape(count, -1)
        for state in range(count):
            self._call(1, [row[state] for row in given], results[state])


def _launch(queue: Any, kernel: Any, parts: int) -> Launch:
    """Return a function that copies arguments to the device, runs a kernel on `n` states and copies the result back.

    A kernel in parts gets a row of groups for each.
    """
    import pyopencl as cl

    asked = kernel.get_work_group_info(cl.kernel_work_group_info.COMPILE_WORK_GROUP_SIZE, queue.device)
    group = max(asked[0], 1)  # 0 where any size will do

    def launch(n: int, arrays: Sequence[Array], out: Array) -> None:
        if not out.size:
            return
        flags = cl.mem_flags
        given = [
            cl.Buffer(queue.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(array))
            if array.size
            else cl.Buffer(queue.context, flags.READ_ONLY, 8)  # none may be empty
            for array in arrays
        ]
        result = cl.Buffer(queue.context, flags.WRITE_ONLY, out.nbytes)
        items = (-(-n // group) * group, parts)
        kernel(queue, items, (group, 1) if group > 1 else None, np.uint64(n), *given, result)
        cl.enqueue_copy(queue, out, result)

    return launch


def compiled_kernels(sources: Sources) -> tuple[Any, Any]:
    """Return a queue of the device, and the kernels as PyOpenCL has them, in double or float as the sources are.

    Raises:
        BuildError, MissingProgram: as `run_opencl`.
    """
    if Path(VENDORS).is_dir():
        os.environ.setdefault(VENDORS_VARIABLE, VENDORS)  # read when PyOpenCL is imported
    try:
        import pyopencl as cl
    except ImportError:
        raise MissingProgram("no PyOpenCL; `pip install pyopencl`, and the OpenCL of your device") from None
    context = cl.Context([_device(cl, sources.real)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a compiler had something to say
        try:
            built = cl.Program(context, _opencl(sources)).build()
        except cl.Error as fault:
            raise BuildError(f"OpenCL refused the code: {fault}") from fault
    return cl.CommandQueue(context), built


def _opencl(sources: Sources) -> str:
    """Return the file for OpenCL."""
    return next(text for name, text in sources.texts.items() if name.endswith(".cl"))


def _device(cl: Any, real: str) -> Any:
    """Return the first device that computes in a type, graphics cards first."""
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        platforms = []
    devices = [device for platform in platforms for device in platform.get_devices()]
    able = [device for device in devices if real != "double" or device.double_fp_config]
    for kind in KINDS:
        for device in able:
            if device.type & getattr(cl.device_type, kind):
                return device
    lacking = f"none of {len(devices)} devices computes in doubles" if devices else "there is no device"
    way_out = "install that of your card, or `apt-get install pocl-opencl-icd` for the processor"
    raise MissingProgram(f"no OpenCL for type {real}: {lacking}; {way_out}")
