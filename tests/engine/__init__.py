"""A reference that knows nothing of how symdyn computes: maximal coordinates, Newton and Euler, one matrix.

    jets         numbers that move, and formulas over them      joints      how joints move, and what they forbid
    mechanism    bodies, joints, contacts and what acts         balance     the equations, solved at once
    states       closed positions, velocities that are allowed

It reads a scene's declared data only, and conventions from docs/; no derivation, no graph, no spatial algebra of
symdyn. `trials` draws mechanisms and options, and compares symdyn with it.
"""
