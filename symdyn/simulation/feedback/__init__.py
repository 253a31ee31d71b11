"""Driving forces that a controller finds from the state: all the time, or at sample times."""
