"""Equations to be read: coefficients as polynomials of sines and cosines, in normal form."""
