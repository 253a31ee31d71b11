"""Closed-form positions."""


def positions(w):
    raise NotImplementedError
