"""The GPU target: `cuda_opencl.py` is its row, `kernels.py` says in which order a kernel computes."""

from symdyn.emit.targets.gpu.cuda_opencl import GPU

__all__ = ["GPU"]
