"""How the kernels of two_link.cl are called: every one of them once, with what must come out beside it.

    pip install pyopencl
    python two_link_main.py

All 1000 states are the same one, which has one result. Its numbers are those of the equations in 50 digits, and each has
with it how far rounding may move it. The program prints a line a kernel; its exit status is 0 where all are right.
Written by symdyn generate; do not edit.
"""

import sys
from pathlib import Path

import numpy
import pyopencl

N = 1000
REAL = numpy.dtype("float32")

context = pyopencl.create_some_context(interactive=False)
queue = pyopencl.CommandQueue(context)
text = Path(__file__).with_name("two_link.cl").read_text(encoding="utf-8")
kernels = pyopencl.Program(context, text).build()


def on_device(n, length):
    """Return memory of the device for so many numbers of n states."""
    return pyopencl.Buffer(context, pyopencl.mem_flags.READ_WRITE, max(n * length, 1) * REAL.itemsize)


def copied(n, values):
    """Return columns of the device that hold values for every one of n states: entry i of state k is x[i * n + k]."""
    x = on_device(n, len(values))
    if values:
        pyopencl.enqueue_copy(queue, x, numpy.repeat(numpy.array(values, REAL), n))
    return x


def wrong(name, n, out, wanted, allowed):
    """Print how many numbers of a result are what they must be, and return how many are not."""
    found = numpy.empty((len(wanted), n), REAL)
    pyopencl.enqueue_copy(queue, found, out)
    right = numpy.abs(found - numpy.array(wanted, REAL)[:, None]) <= numpy.array(allowed, REAL)[:, None]
    print(f"{name:40} {'right' if right.all() else 'WRONG'} ({right.sum()} of {right.size} numbers)")
    return int(right.size - right.sum())


q = copied(N, [1.8942349, -1.7844061])
qd = copied(N, [1.1900786, 0.6186312])
qdd = copied(N, [-1.5090139, -0.8319913])
params = copied(1, [1.0771358, 0.9665256, 0.9721402, 1.1409863, 0.7606456])
tau = copied(N, [-1.7734517, 4.433856])
off = 0

out = on_device(N, 2)
kernels.two_link_inverse_dynamics(queue, (N,), None, numpy.uint64(N), q, qd, qdd, params, out)
wanted = [-1.5166917, -3.9945757]
allowed = [1.6e-05, 5.3e-06]
off += wrong("inverse_dynamics", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_forward_dynamics(queue, (N,), None, numpy.uint64(N), q, qd, tau, params, out)
wanted = [-5.2982326, 8.971248]
allowed = [2.4e-05, 3.2e-05]
off += wrong("forward_dynamics", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_mass_matrix(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.7351131, 1.0310044, 1.0310044, 1.2582712]
allowed = [2.5e-06, 8.2e-07, 8.2e-07, 3.9e-07]
off += wrong("mass_matrix", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_velocity_forces(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [1.94364, -1.4838482]
allowed = [9.2e-06, 2.5e-06]
off += wrong("velocity_forces", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_gravity_forces(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [1.5247788, 0.091943085]
allowed = [3.4e-06, 1.0e-06]
off += wrong("gravity_forces", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_coriolis_matrix(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [0.64814174, 1.8949907, -1.246849, 0.0]
allowed = [1.0e-06, 3.2e-06, 2.0e-06, 1.2e-38]
off += wrong("coriolis_matrix", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_momentum(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [3.8928113, 2.005382]
allowed = [4.9e-06, 1.9e-06]
off += wrong("momentum", N, out, wanted, allowed)

out = on_device(N, 1)
kernels.two_link_kinetic_energy(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [2.9366717]
allowed = [5.0e-06]
off += wrong("kinetic_energy", N, out, wanted, allowed)

out = on_device(N, 1)
kernels.two_link_potential_energy(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [-0.3534794]
allowed = [2.7e-06]
off += wrong("potential_energy", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_k_z(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.7351131, 1.0310044, 1.0310044, 1.2582712]
allowed = [2.5e-06, 8.2e-07, 8.2e-07, 3.9e-07]
off += wrong("k_z", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_k_C(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.095406, 0.0]
allowed = [3.5e-06, 1.2e-38]
off += wrong("k_C", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_k_D(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.0, 1.047703, -1.047703, 0.0]
allowed = [1.2e-38, 1.5e-06, 1.5e-06, 1.2e-38]
off += wrong("k_D", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_k_G(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [1.5247788, 0.091943085]
allowed = [3.4e-06, 1.0e-06]
off += wrong("k_G", N, out, wanted, allowed)

out = on_device(N, 12)
kernels.two_link_pose_tool(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.99397486, -0.109608166, 0.0, 1.0467943, 0.109608166, 0.99397486, 0.0, -0.8251377, 0.0, 0.0, 1.0, 0.0]
allowed = [2.3e-06, 1.1e-06, 1.2e-38, 2.5e-06, 1.1e-06, 2.3e-06, 1.2e-38, 3.2e-06, 1.2e-38, 1.2e-38, 1.9e-07, 1.2e-38]
off += wrong("pose_tool", N, out, wanted, allowed)

out = on_device(N, 12)
kernels.two_link_jacobian_tool(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.8251377, 1.1341118, 1.0467943, 0.12506142, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]
allowed = [3.2e-06, 3.7e-06, 2.5e-06, 3.5e-06, 1.2e-38, 1.2e-38, 1.2e-38, 1.2e-38, 1.2e-38, 1.2e-38, 1.9e-07, 1.9e-07]
off += wrong("jacobian_tool", N, out, wanted, allowed)

out = on_device(N, 6)
kernels.two_link_jdot_qdot_tool(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [-1.7145683, 3.2725725, 0.0, 0.0, 0.0, 0.0]
allowed = [9.5e-06, 1.3e-05, 1.2e-38, 1.2e-38, 1.2e-38, 1.2e-38]
off += wrong("jdot_qdot_tool", N, out, wanted, allowed)
sys.exit(1 if off else 0)
