"""After the equations: what they say about rests, their stability, motions and limits."""
