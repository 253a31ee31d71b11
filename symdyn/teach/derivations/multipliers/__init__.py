"""Lagrange's equations with multipliers: loops cut open and rolling, the conditions and what it takes to keep them."""
