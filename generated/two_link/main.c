/*
 * How the functions of two_link.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "two_link.h"

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
    static const double params[5] = {1.0771357864705502, 0.9665256295132645, 0.9721401655125133, 1.1409863456303149, 0.7606456264398351};
    static const double tau[2] = {-1.773451708248249, 4.433856233091829};
    int off = 0;
    {
        static const double wanted[2] = {-1.5166918093194068, -3.994576113466394};
        static const double allowed[2] = {2.9e-14, 9.8e-15};
        double found[2];
        two_link_inverse_dynamics(q, qd, qdd, params, found);
        off += wrong("inverse_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {-5.2982331392697875, 8.971248111859595};
        static const double allowed[2] = {4.5e-14, 5.9e-14};
        double found[2];
        two_link_forward_dynamics(q, qd, tau, params, found);
        off += wrong("forward_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        static const double allowed[4] = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        double found[4];
        two_link_mass_matrix(q, params, found);
        off += wrong("mass_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {1.9436399856191295, -1.4838483535569849};
        static const double allowed[2] = {1.7e-14, 4.7e-15};
        double found[2];
        two_link_velocity_forces(q, qd, params, found);
        off += wrong("velocity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {1.5247788152016606, 0.09194304874029749};
        static const double allowed[2] = {6.4e-15, 1.9e-15};
        double found[2];
        two_link_gravity_forces(q, params, found);
        off += wrong("gravity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {0.6481417417818378, 1.8949907234152703, -1.2468489816334325, 0.0};
        static const double allowed[4] = {1.9e-15, 6.0e-15, 3.6e-15, 2.2e-308};
        double found[4];
        two_link_coriolis_matrix(q, qd, params, found);
        off += wrong("coriolis_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {3.8928112723558224, 2.005382192320685};
        static const double allowed[2] = {9.1e-15, 3.6e-15};
        double found[2];
        two_link_momentum(q, qd, params, found);
        off += wrong("momentum", 2, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {2.936671763104942};
        static const double allowed[1] = {9.3e-15};
        double found[1];
        two_link_kinetic_energy(q, qd, params, found);
        off += wrong("kinetic_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[1] = {-0.35347950003900824};
        static const double allowed[1] = {5.0e-15};
        double found[1];
        two_link_potential_energy(q, params, found);
        off += wrong("potential_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        static const double allowed[4] = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        double found[4];
        two_link_k_z(q, params, found);
        off += wrong("k_z", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {2.095406015410758, 0.0};
        static const double allowed[2] = {6.6e-15, 2.2e-308};
        double found[2];
        two_link_k_C(q, params, found);
        off += wrong("k_C", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {0.0, 1.047703007705379, -1.047703007705379, 0.0};
        static const double allowed[4] = {2.2e-308, 2.8e-15, 2.8e-15, 2.2e-308};
        double found[4];
        two_link_k_D(q, params, found);
        off += wrong("k_D", 4, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {1.5247788152016606, 0.09194304874029749};
        static const double allowed[2] = {6.4e-15, 1.9e-15};
        double found[2];
        two_link_k_G(q, params, found);
        off += wrong("k_G", 2, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {0.9939748796082962, -0.10960811424193481, 0.0, 1.0467942753507573, 0.10960811424193481, 0.9939748796082962, 0.0, -0.8251377579962568, 0.0, 0.0, 1.0, 0.0};
        static const double allowed[12] = {4.3e-15, 2.1e-15, 2.2e-308, 4.7e-15, 2.1e-15, 4.3e-15, 2.2e-308, 6.0e-15, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308};
        double found[12];
        two_link_pose_tool(q, params, found);
        off += wrong("pose_tool", 12, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {0.8251377579962568, 1.134111765532602, 1.0467942753507573, 0.12506136172033527, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0};
        static const double allowed[12] = {6.0e-15, 6.9e-15, 4.7e-15, 6.5e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16, 3.5e-16};
        double found[12];
        two_link_jacobian_tool(q, params, found);
        off += wrong("jacobian_tool", 12, found, wanted, allowed);
    }
    {
        static const double wanted[6] = {-1.7145681668147574, 3.272572717739957, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[6] = {1.8e-14, 2.4e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double found[6];
        two_link_jdot_qdot_tool(q, qd, params, found);
        off += wrong("jdot_qdot_tool", 6, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
