"""Trials of symdyn against the reference, drawn by a seed.

scenes, families    random mechanisms as TOML         options    what is exploited, pair by pair
cases               drives, loads, locks, states      code       symdyn's side         compare    both, side by side
"""
