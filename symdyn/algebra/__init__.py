"""What a graph can be run over: numbers, batches, big floats, finite fields, polynomials, degrees, SymPy."""
