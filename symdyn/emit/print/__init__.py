"""Equations in print: LaTeX, plain text, SymPy."""
