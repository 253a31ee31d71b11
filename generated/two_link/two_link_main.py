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
REAL = numpy.dtype("float64")

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


q = copied(N, [1.8942348488091483, -1.7844060686319136])
qd = copied(N, [1.1900786505941334, 0.6186311741161856])
qdd = copied(N, [-1.5090139330826062, -0.8319913100426404])
params = copied(1, [1.0771357864705502, 0.9665256295132645, 0.9721401655125133, 1.1409863456303149, 0.7606456264398351])
tau = copied(N, [-1.773451708248249, 4.433856233091829])
off = 0

out = on_device(N, 2)
kernels.two_link_inverse_dynamics(queue, (N,), None, numpy.uint64(N), q, qd, qdd, params, out)
wanted = [-1.5166918093194068, -3.994576113466394]
allowed = [2.9e-14, 9.8e-15]
off += wrong("inverse_dynamics", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_forward_dynamics(queue, (N,), None, numpy.uint64(N), q, qd, tau, params, out)
wanted = [-5.2982331392697875, 8.971248111859595]
allowed = [4.5e-14, 5.9e-14]
off += wrong("forward_dynamics", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_mass_matrix(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194]
allowed = [4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16]
off += wrong("mass_matrix", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_velocity_forces(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [1.9436399856191295, -1.4838483535569849]
allowed = [1.7e-14, 4.7e-15]
off += wrong("velocity_forces", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_gravity_forces(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [1.5247788152016606, 0.09194304874029749]
allowed = [6.4e-15, 1.9e-15]
off += wrong("gravity_forces", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_coriolis_matrix(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [0.6481417417818378, 1.8949907234152703, -1.2468489816334325, 0.0]
allowed = [1.9e-15, 6.0e-15, 3.6e-15, 2.2e-308]
off += wrong("coriolis_matrix", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_momentum(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [3.8928112723558224, 2.005382192320685]
allowed = [9.1e-15, 3.6e-15]
off += wrong("momentum", N, out, wanted, allowed)

out = on_device(N, 1)
kernels.two_link_kinetic_energy(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [2.936671763104942]
allowed = [9.3e-15]
off += wrong("kinetic_energy", N, out, wanted, allowed)

out = on_device(N, 1)
kernels.two_link_potential_energy(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [-0.35347950003900824]
allowed = [5.0e-15]
off += wrong("potential_energy", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_k_z(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194]
allowed = [4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16]
off += wrong("k_z", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_k_C(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [2.095406015410758, 0.0]
allowed = [6.6e-15, 2.2e-308]
off += wrong("k_C", N, out, wanted, allowed)

out = on_device(N, 4)
kernels.two_link_k_D(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.0, 1.047703007705379, -1.047703007705379, 0.0]
allowed = [2.2e-308, 2.8e-15, 2.8e-15, 2.2e-308]
off += wrong("k_D", N, out, wanted, allowed)

out = on_device(N, 2)
kernels.two_link_k_G(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [1.5247788152016606, 0.09194304874029749]
allowed = [6.4e-15, 1.9e-15]
off += wrong("k_G", N, out, wanted, allowed)

out = on_device(N, 12)
kernels.two_link_pose_tool(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.9939748796082962, -0.10960811424193481, 0.0, 1.0467942753507573, 0.10960811424193481, 0.9939748796082962, 0.0, -0.8251377579962568, 0.0, 0.0, 1.0, 0.0]
allowed = [4.3e-15, 2.1e-15, 2.2e-308, 4.7e-15, 2.1e-15, 4.3e-15, 2.2e-308, 6.0e-15, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308]
off += wrong("pose_tool", N, out, wanted, allowed)

out = on_device(N, 12)
kernels.two_link_jacobian_tool(queue, (N,), None, numpy.uint64(N), q, params, out)
wanted = [0.8251377579962568, 1.134111765532602, 1.0467942753507573, 0.12506136172033527, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]
allowed = [6.0e-15, 6.9e-15, 4.7e-15, 6.5e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16, 3.5e-16]
off += wrong("jacobian_tool", N, out, wanted, allowed)

out = on_device(N, 6)
kernels.two_link_jdot_qdot_tool(queue, (N,), None, numpy.uint64(N), q, qd, params, out)
wanted = [-1.7145681668147574, 3.272572717739957, 0.0, 0.0, 0.0, 0.0]
allowed = [1.8e-14, 2.4e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308]
off += wrong("jdot_qdot_tool", N, out, wanted, allowed)
sys.exit(1 if off else 0)
