"""Run time against error, work against precision, and hard cases: what the code is worth, measured."""

from symdyn.bench.accuracy import bench
from symdyn.bench.model import Bench, Curve, Errors, Measured, Motion, Point

__all__ = ["Bench", "Curve", "Errors", "Measured", "Motion", "Point", "bench"]
