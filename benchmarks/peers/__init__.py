"""Who is measured: one file each, with the same small shape.

    NAME                         as in tables
    version() -> str             raises MissingError or ImportError where the peer is not installed
    timed(case, output) -> list  its ways to compute one output of one mechanism, ready to be called; raises
                                 MissingError with the reason where it cannot

A peer compiles what it needs before it returns, and takes the states of the case in its own order and layout.
"""

PEERS = (
    "ours_c",
    "ours_avx2",
    "ours_python",
    "pinocchio_cpp",
    "pinocchio_python",
    "mujoco_c",
    "casadi_c",
    "heyoka_cfunc",
    "sympy_lambdify",
    "pydy_ode",
)
