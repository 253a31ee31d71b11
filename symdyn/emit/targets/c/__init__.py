"""Targets C and C++: rows in `c_and_cpp.py`, lines in `writer.py`; the others say how batches are computed."""
