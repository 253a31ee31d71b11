"""Lagrange's equations of the second kind, by differentiation of L = K - P."""
