/*
 * How the functions of pendulum.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "pendulum.h"

#include <math.h>
#include <stdio.h>

/* Print whether `count` numbers are what they must be, and return how many are not; what is no number never is. */
static int wrong(const char *name, int count, const double *found, const double *wanted, const double *allowed)
{
    int off = 0;
    for (int k = 0; k < count; k++) {
        if (!(fabs(found[k] - wanted[k]) <= allowed[k])) {
            off++;
        }
    }
    printf("%-40s %s (%d of %d numbers)\n", name, off ? "WRONG" : "right", count - off, count);
    return off;
}

int main(void)
{
    static const double q[1] = {1.8942348488091483};
    static const double qd[1] = {-1.189604045754609};
    static const double qdd[1] = {1.1900786505941334};
    static const double tau[1] = {1.5465779352904638};
    int off = 0;
    {
        static const double wanted[1] = {4.93629036938139};
        static const double allowed[1] = {1.4e-14};
        double found[1];
        pendulum_inverse_dynamics(q, qd, qdd, found);
        off += wrong("inverse_dynamics", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {-12.368771085769573};
        static const double allowed[1] = {5.5e-14};
        double found[1];
        pendulum_forward_dynamics(q, qd, tau, found);
        off += wrong("forward_dynamics", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.25};
        static const double allowed[1] = {8.7e-17};
        double found[1];
        pendulum_mass_matrix(q, found);
        off += wrong("mass_matrix", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.0};
        static const double allowed[1] = {2.2e-308};
        double found[1];
        pendulum_velocity_forces(q, qd, found);
        off += wrong("velocity_forces", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {4.650666747190403};
        static const double allowed[1] = {1.1e-14};
        double found[1];
        pendulum_gravity_forces(q, found);
        off += wrong("gravity_forces", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.0};
        static const double allowed[1] = {2.2e-308};
        double found[1];
        pendulum_coriolis_matrix(q, qd, found);
        off += wrong("coriolis_matrix", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {-0.2974010114386523};
        static const double allowed[1] = {1.7e-16};
        double found[1];
        pendulum_momentum(q, qd, found);
        off += wrong("momentum", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.17689472320946675};
        static const double allowed[1] = {1.4e-16};
        double found[1];
        pendulum_kinetic_energy(q, qd, found);
        off += wrong("kinetic_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {1.5589495843603907};
        static const double allowed[1] = {3.8e-15};
        double found[1];
        pendulum_potential_energy(q, found);
        off += wrong("potential_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.25};
        static const double allowed[1] = {8.7e-17};
        double found[1];
        pendulum_k_z(q, found);
        off += wrong("k_z", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.0};
        static const double allowed[1] = {2.2e-308};
        double found[1];
        pendulum_k_D(q, found);
        off += wrong("k_D", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {4.650666747190403};
        static const double allowed[1] = {1.1e-14};
        double found[1];
        pendulum_k_G(q, found);
        off += wrong("k_G", 1, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {-0.31782866143942723, -0.9481481645648121, 0.0, 0.47407408228240605, 0.9481481645648121, -0.31782866143942723, 0.0, 0.15891433071971361, 0.0, 0.0, 1.0, 0.0};
        static const double allowed[12] = {6.3e-16, 1.9e-15, 2.2e-308, 1.2e-15, 1.9e-15, 6.3e-16, 2.2e-308, 3.9e-16, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308};
        double found[12];
        pendulum_pose_tip(q, found);
        off += wrong("pose_tip", 12, found, wanted, allowed);
    }
    {
        static const double wanted[6] = {-0.15891433071971361, 0.47407408228240605, 0.0, 0.0, 0.0, 1.0};
        static const double allowed[6] = {3.9e-16, 1.2e-15, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16};
        double found[6];
        pendulum_jacobian_tip(q, found);
        off += wrong("jacobian_tip", 6, found, wanted, allowed);
    }
    {
        static const double wanted[6] = {-0.6708896285290255, -0.22488885237345121, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[6] = {2.0e-15, 6.6e-16, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double found[6];
        pendulum_jdot_qdot_tip(q, qd, found);
        off += wrong("jdot_qdot_tip", 6, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
