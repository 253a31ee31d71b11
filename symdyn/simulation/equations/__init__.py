"""State equations: rates, energies, rows, projection and controllers; named parameters are free at run time."""
