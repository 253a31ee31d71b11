"""How long tests wait for what is sure to come: only what hangs takes longer."""

HANG = 900.0
"""Seconds: a machine ten times slower than most, with one core and others at work on it, is done by then."""
