"""Rotations by quaternions: their kinematics, momenta in turning axes, Euler's equations."""
