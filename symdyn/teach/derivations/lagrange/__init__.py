"""Lagrange's method (5.21)-(5.23): positions, velocities, energies, the equations term by term, what they mean."""
