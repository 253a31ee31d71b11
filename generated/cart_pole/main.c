/*
 * How the functions of cart_pole.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "cart_pole.h"

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
    static const double q[2] = {1.8942348488091483, -1.7844060686319136};
    static const double qd[2] = {1.1900786505941334, 0.6186311741161856};
    static const double qdd[2] = {-1.5090139330826062, -0.8319913100426404};
    static const double tau[2] = {0.771357864705501, -0.33474370486735516};
    int off = 0;
    {
        static const double wanted[2] = {-1.5546669469991068, 0.22474535344322544};
        static const double allowed[2] = {1.8e-15, 8.2e-16};
        double found[2];
        cart_pole_inverse_dynamics(q, qd, qdd, found);
        off += wrong("inverse_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {0.936516869008626, -69.52595499794144};
        static const double allowed[2] = {2.6e-15, 1.4e-13};
        double found[2];
        cart_pole_forward_dynamics(q, qd, tau, found);
        off += wrong("forward_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {1.1, 0.005299724328760498, 0.005299724328760498, 0.008333333333333333};
        static const double allowed[4] = {3.8e-16, 1.3e-17, 1.3e-17, 2.9e-18};
        double found[4];
        cart_pole_mass_matrix(q, found);
        off += wrong("mass_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {-0.009350161080503003, 0.0};
        static const double allowed[2] = {2.7e-17, 2.2e-308};
        double found[2];
        cart_pole_velocity_forces(q, qd, found);
        off += wrong("velocity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {0.0, 0.2396759722138439};
        static const double allowed[2] = {2.2e-308, 5.9e-16};
        double found[2];
        cart_pole_gravity_forces(q, found);
        off += wrong("gravity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {0.0, -0.015114274016115039, 0.0, 0.0};
        static const double allowed[4] = {2.2e-308, 4.1e-17, 2.2e-308, 2.2e-308};
        double found[4];
        cart_pole_coriolis_matrix(q, qd, found);
        off += wrong("coriolis_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {1.31236509033754, 0.01146234856199374};
        static const double allowed[2] = {1.1e-15, 2.3e-17};
        double found[2];
        cart_pole_momentum(q, qd, found);
        off += wrong("momentum", 2, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {0.7844543209723914};
        static const double allowed[1] = {1.4e-15};
        double found[1];
        cart_pole_kinetic_energy(q, qd, found);
        off += wrong("kinetic_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {-0.05199029566514048};
        static const double allowed[1] = {1.3e-16};
        double found[1];
        cart_pole_potential_energy(q, found);
        off += wrong("potential_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {1.1, 0.005299724328760498, 0.005299724328760498, 0.008333333333333333};
        static const double allowed[4] = {3.8e-16, 1.3e-17, 1.3e-17, 2.9e-18};
        double found[4];
        cart_pole_k_z(q, found);
        off += wrong("k_z", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {0.0, 0.0};
        static const double allowed[2] = {2.2e-308, 2.2e-308};
        double found[2];
        cart_pole_k_C(q, found);
        off += wrong("k_C", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {0.0, -0.024431801448913753, 0.0, 0.0};
        static const double allowed[4] = {2.2e-308, 6.0e-17, 2.2e-308, 2.2e-308};
        double found[4];
        cart_pole_k_D(q, found);
        off += wrong("k_D", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {0.0, 0.2396759722138439};
        static const double allowed[2] = {2.2e-308, 5.9e-16};
        double found[2];
        cart_pole_k_G(q, found);
        off += wrong("k_G", 2, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {-0.21198897315041992, 0.97727205795655, 0.0, 2.3828708777874232, -0.97727205795655, -0.21198897315041992, 0.0, -0.10599448657520996, 0.0, 0.0, 1.0, 0.0};
        static const double allowed[12] = {4.2e-16, 1.9e-15, 2.2e-308, 2.0e-15, 1.9e-15, 4.2e-16, 2.2e-308, 2.6e-16, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308};
        double found[12];
        cart_pole_pose_tip(q, found);
        off += wrong("pose_tip", 12, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {1.0, 0.10599448657520996, 0.0, 0.488636028978275, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
        static const double allowed[12] = {3.5e-16, 2.6e-16, 2.2e-308, 1.9e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16};
        double found[12];
        cart_pole_jacobian_tip(q, found);
        off += wrong("jacobian_tip", 12, found, wanted, allowed);
    }
    {
        static const double wanted[6] = {-0.18700322161006006, 0.040564570123726565, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[6] = {5.4e-16, 1.2e-16, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double found[6];
        cart_pole_jdot_qdot_tip(q, qd, found);
        off += wrong("jdot_qdot_tip", 6, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
