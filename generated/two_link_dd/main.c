/*
 * How the functions of two_link.h are called: every one of them once, at one state, with what must come out beside it.
 *
 * The numbers are those of the equations in 50 digits, as double-doubles: high part, low part. Each has with it how far
 * rounding may move it. The program prints a line a function; its exit status is 0 where all are right.
 * Written by symdyn generate; do not edit.
 */
#include "two_link.h"

#include <math.h>
#include <stdio.h>

/* Print whether `count` numbers are what they must be, and return how many are not; what is no number never is. */
static int wrong(const char *name, int count, const double *found, const double *wanted, const double *allowed)
{
    int off = 0;
    for (int k = 0; k < count; k++) {
        const double high = found[2 * k] - wanted[2 * k], low = found[2 * k + 1] - wanted[2 * k + 1];
        if (!(fabs(high + low) <= allowed[k])) {
            off++;
        }
    }
    printf("%-40s %s (%d of %d numbers)\n", name, off ? "WRONG" : "right", count - off, count);
    return off;
}

int main(void)
{
    static const double q[4] = {1.8942348488091483, 0.0, -1.7844060686319136, 0.0};
    static const double qd[4] = {1.1900786505941334, 0.0, 0.6186311741161856, 0.0};
    static const double qdd[4] = {-1.5090139330826062, 0.0, -0.8319913100426404, 0.0};
    static const double params[10] = {1.0771357864705502, 0.0, 0.9665256295132645, 0.0, 0.9721401655125133, 0.0, 1.1409863456303149, 0.0, 0.7606456264398351, 0.0};
    static const double tau[4] = {-1.773451708248249, 0.0, 4.433856233091829, 0.0};
    int off = 0;
    {
        static const double wanted[4] = {-1.5166918093194068, -1.1041540108374413e-16, -3.994576113466394, 1.667703758644679e-16};
        static const double allowed[2] = {5.7e-29, 1.8e-29};
        double found[4];
        two_link_inverse_dynamics(q, qd, qdd, params, found);
        off += wrong("inverse_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {-5.2982331392697875, -1.5278775013408912e-16, 8.971248111859595, -2.8565471012728054e-16};
        static const double allowed[2] = {8.6e-29, 1.1e-28};
        double found[4];
        two_link_forward_dynamics(q, qd, tau, params, found);
        off += wrong("forward_dynamics", 2, found, wanted, allowed);
    }
    {
        static const double wanted[8] = {2.7351131624042138, 1.4611430324528564e-16, 1.0310044457924044, 6.944915941876571e-17, 1.0310044457924044, 6.944915941876571e-17, 1.25827123702194, -3.9252768573043866e-17};
        static const double allowed[4] = {8.7e-30, 2.9e-30, 2.9e-30, 1.3e-30};
        double found[8];
        two_link_mass_matrix(q, params, found);
        off += wrong("mass_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {1.9436399856191295, -9.726034237427675e-17, -1.4838483535569849, -5.4751596478848307e-17};
        static const double allowed[2] = {3.2e-29, 8.3e-30};
        double found[4];
        two_link_velocity_forces(q, qd, params, found);
        off += wrong("velocity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {1.5247788152016606, -6.642189287691321e-17, 0.09194304874029749, -4.0579780058663944e-18};
        static const double allowed[2] = {1.2e-29, 3.5e-30};
        double found[4];
        two_link_gravity_forces(q, params, found);
        off += wrong("gravity_forces", 2, found, wanted, allowed);
    }
    {
        static const double wanted[8] = {0.6481417417818378, -3.415209547701057e-17, 1.8949907234152703, 6.275271358567638e-17, -1.2468489816334325, -9.690480906268695e-17, 0.0, 0.0};
        static const double allowed[4] = {3.4e-30, 1.1e-29, 6.5e-30, 1.0e-289};
        double found[8];
        two_link_coriolis_matrix(q, qd, params, found);
        off += wrong("coriolis_matrix", 4, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {3.8928112723558224, -1.669663305948043e-16, 2.005382192320685, -1.0788116499380129e-16};
        static const double allowed[2] = {1.7e-29, 6.6e-30};
        double found[4];
        two_link_momentum(q, qd, params, found);
        off += wrong("momentum", 2, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {2.936671763104942, 1.8625837238482733e-16};
        static const double allowed[1] = {1.7e-29};
        double found[2];
        two_link_kinetic_energy(q, qd, params, found);
        off += wrong("kinetic_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[2] = {-0.35347950003900824, -6.172234908068379e-18};
        static const double allowed[1] = {9.3e-30};
        double found[2];
        two_link_potential_energy(q, params, found);
        off += wrong("potential_energy", 1, found, wanted, allowed);
    }
    {
        static const double wanted[8] = {2.7351131624042138, 1.4611430324528564e-16, 1.0310044457924044, 6.944915941876571e-17, 1.0310044457924044, 6.944915941876571e-17, 1.25827123702194, -3.9252768573043866e-17};
        static const double allowed[4] = {8.7e-30, 2.9e-30, 2.9e-30, 1.3e-30};
        double found[8];
        two_link_k_z(q, params, found);
        off += wrong("k_z", 4, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {2.095406015410758, 1.9546069549810383e-16, 0.0, 0.0};
        static const double allowed[2] = {1.2e-29, 1.0e-289};
        double found[4];
        two_link_k_C(q, params, found);
        off += wrong("k_C", 2, found, wanted, allowed);
    }
    {
        static const double wanted[8] = {0.0, 0.0, 1.047703007705379, 9.773034774905192e-17, -1.047703007705379, -9.773034774905192e-17, 0.0, 0.0};
        static const double allowed[4] = {1.0e-289, 5.0e-30, 5.0e-30, 1.0e-289};
        double found[8];
        two_link_k_D(q, params, found);
        off += wrong("k_D", 4, found, wanted, allowed);
    }
    {
        static const double wanted[4] = {1.5247788152016606, -6.642189287691321e-17, 0.09194304874029749, -4.0579780058663944e-18};
        static const double allowed[2] = {1.2e-29, 3.5e-30};
        double found[4];
        two_link_k_G(q, params, found);
        off += wrong("k_G", 2, found, wanted, allowed);
    }
    {
        static const double wanted[24] = {0.9939748796082962, -2.8077576636663746e-18, -0.10960811424193481, 5.246094467495252e-18, 0.0, 0.0, 1.0467942753507573, 7.925698933725176e-18, 0.10960811424193481, -5.246094467495252e-18, 0.9939748796082962, -2.8077576636663746e-18, 0.0, 0.0, -0.8251377579962568, 2.944213027028864e-17, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
        static const double allowed[12] = {7.6e-30, 3.8e-30, 1.0e-289, 8.5e-30, 3.8e-30, 7.6e-30, 1.0e-289, 1.1e-29, 1.0e-289, 1.0e-289, 6.2e-31, 1.0e-289};
        double found[24];
        two_link_pose_tool(q, params, found);
        off += wrong("pose_tool", 12, found, wanted, allowed);
    }
    {
        static const double wanted[24] = {0.8251377579962568, -2.944213027028864e-17, 1.134111765532602, 1.6076677813211584e-17, 1.0467942753507573, 7.925698933725176e-18, 0.12506136172033527, -8.391404242306816e-18, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0};
        static const double allowed[12] = {1.1e-29, 1.3e-29, 8.5e-30, 1.3e-29, 1.0e-289, 1.0e-289, 1.0e-289, 1.0e-289, 1.0e-289, 1.0e-289, 6.2e-31, 6.2e-31};
        double found[24];
        two_link_jacobian_tool(q, params, found);
        off += wrong("jacobian_tool", 12, found, wanted, allowed);
    }
    {
        static const double wanted[12] = {-1.7145681668147574, 7.042196848533231e-17, 3.272572717739957, -1.678511316483951e-16, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[6] = {3.2e-29, 4.4e-29, 1.0e-289, 1.0e-289, 1.0e-289, 1.0e-289};
        double found[12];
        two_link_jdot_qdot_tool(q, qd, params, found);
        off += wrong("jdot_qdot_tool", 6, found, wanted, allowed);
    }
    return off ? 1 : 0;
}
