"""Run time against error, work against precision, and hard cases: what the code is worth, measured."""

from symdyn.bench.measurements import Bench, Curve, Errors, Measured, MotionPrecision, Point
from symdyn.bench.time_and_error import bench

__all__ = ["Bench", "Curve", "Errors", "Measured", "MotionPrecision", "Point", "bench"]
