"""Optimal control as equations in numbers: what solvers of nonlinear programs ask for, and what they find."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
