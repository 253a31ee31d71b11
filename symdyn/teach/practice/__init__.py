"""Exercises: what of a lesson is asked for, what is hidden until then, variants and sheets."""
