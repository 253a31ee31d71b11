"""State equations: rates, energies, rows and projection as functions, with named parameters free at run time."""
