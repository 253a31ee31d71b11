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
static int wrong(const char *name, int count, const float *found, const float *wanted, const float *allowed)
{
    int off = 0;
    for (int k = 0; k < count; k++) {
        if (!(fabsf(found[k] - wanted[k]) <= allowed[k])) {
            off++;
        }
    }
    printf("%-40s %s (%d of %d numbers)\n", name, off ? "WRONG" : "right", count - off, count);
    return off;
}

int main(void)
{
    static const float q[2] = {1.8942349f, -1.7844061f};
    static const float qd[2] = {1.1900786f, 0.6186312f};
    static const float qdd[2] = {-1.5090139f, -0.8319913f};
    static const float params[5] = {1.0771358f, 0.9665256f, 0.9721402f, 1.1409863f, 0.7606456f};
    static const float tau[2] = {-1.7734517f, 4.433856f};
    int off = 0;
    {
        static const float wanted[2] = {-1.5166917f, -3.9945757f};
        static const float allowed[2] = {1.6e-05f, 5.3e-06f};
        float found[2];
        two_link_inverse_dynamics(q, qd, qdd, params, found);
        off += wrong("inverse_dynamics", 2, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {-5.2982326f, 8.971248f};
        static const float allowed[2] = {2.4e-05f, 3.2e-05f};
        float found[2];
        two_link_forward_dynamics(q, qd, tau, params, found);
        off += wrong("forward_dynamics", 2, found, wanted, allowed);
    }
    {
        static const float wanted[4] = {2.7351131f, 1.0310044f, 1.0310044f, 1.2582712f};
        static const float allowed[4] = {2.5e-06f, 8.2e-07f, 8.2e-07f, 3.9e-07f};
        float found[4];
        two_link_mass_matrix(q, params, found);
        off += wrong("mass_matrix", 4, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {1.94364f, -1.4838482f};
        static const float allowed[2] = {9.2e-06f, 2.5e-06f};
        float found[2];
        two_link_velocity_forces(q, qd, params, found);
        off += wrong("velocity_forces", 2, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {1.5247788f, 0.091943085f};
        static const float allowed[2] = {3.4e-06f, 1.0e-06f};
        float found[2];
        two_link_gravity_forces(q, params, found);
        off += wrong("gravity_forces", 2, found, wanted, allowed);
    }
    {
        static const float wanted[4] = {0.64814174f, 1.8949907f, -1.246849f, 0.0f};
        static const float allowed[4] = {1.0e-06f, 3.2e-06f, 2.0e-06f, 1.2e-38f};
        float found[4];
        two_link_coriolis_matrix(q, qd, params, found);
        off += wrong("coriolis_matrix", 4, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {3.8928113f, 2.005382f};
        static const float allowed[2] = {4.9e-06f, 1.9e-06f};
        float found[2];
        two_link_momentum(q, qd, params, found);
        off += wrong("momentum", 2, found, wanted, allowed);
    }
    {
        static const float wanted[1] = {2.9366717f};
        static const float allowed[1] = {5.0e-06f};
        float found[1];
        two_link_kinetic_energy(q, qd, params, found);
        off += wrong("kinetic_energy", 1, found, wanted, allowed);
    }
    {
        static const float wanted[1] = {-0.3534794f};
        static const float allowed[1] = {2.7e-06f};
        float found[1];
        two_link_potential_energy(q, params, found);
        off += wrong("potential_energy", 1, found, wanted, allowed);
    }
    {
        static const float wanted[4] = {2.7351131f, 1.0310044f, 1.0310044f, 1.2582712f};
        static const float allowed[4] = {2.5e-06f, 8.2e-07f, 8.2e-07f, 3.9e-07f};
        float found[4];
        two_link_k_z(q, params, found);
        off += wrong("k_z", 4, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {2.095406f, 0.0f};
        static const float allowed[2] = {3.5e-06f, 1.2e-38f};
        float found[2];
        two_link_k_C(q, params, found);
        off += wrong("k_C", 2, found, wanted, allowed);
    }
    {
        static const float wanted[4] = {0.0f, 1.047703f, -1.047703f, 0.0f};
        static const float allowed[4] = {1.2e-38f, 1.5e-06f, 1.5e-06f, 1.2e-38f};
        float found[4];
        two_link_k_D(q, params, found);
        off += wrong("k_D", 4, found, wanted, allowed);
    }
    {
        static const float wanted[2] = {1.5247788f, 0.091943085f};
        static const float allowed[2] = {3.4e-06f, 1.0e-06f};
        float found[2];
        two_link_k_G(q, params, found);
        off += wrong("k_G", 2, found, wanted, allowed);
    }
    {
        static const float wanted[12] = {0.99397486f, -0.109608166f, 0.0f, 1.0467943f, 0.109608166f, 0.99397486f, 0.0f, -0.8251377f, 0.0f, 0.0f, 1.0f, 0.0f};
        static const float allowed[12] = {2.3e-06f, 1.1e-06f, 1.2e-38f, 2.5e-06f, 1.1e-06f, 2.3e-06f, 1.2e-38f, 3.2e-06f, 1.2e-38f, 1.2e-38f, 1.9e-07f, 1.2e-38f};
        float found[12];
        two_link_pose_tool(q, params, found);
        off += wrong("pose_tool", 12, found, wanted, allowed);
    }
    {
        static const float wanted[12] = {0.8251377f, 1.1341118f, 1.0467943f, 0.12506142f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f};
        static const float allowed[12] = {3.2e-06f, 3.7e-06f, 2.5e-06f, 3.5e-06f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.9e-07f, 1.9e-07f};
        float found[12];
        two_link_jacobian_tool(q, params, found);
        off += wrong("jacobian_tool", 12, found, wanted, allowed);
    }
    {
        static const float wanted[6] = {-1.7145683f, 3.2725725f, 0.0f, 0.0f, 0.0f, 0.0f};
        static const float allowed[6] = {9.5e-06f, 1.3e-05f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f};
        float found[6];
        two_link_jdot_qdot_tool(q, qd, params, found);
        off += wrong("jdot_qdot_tool", 6, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
