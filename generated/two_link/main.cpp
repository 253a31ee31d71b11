/*
 * How the functions of two_link.hpp are called: every one of them once, at one state, with what must come out beside it.
 *
 *     g++ -std=c++17 -O2 main.cpp && ./a.out
 *
 * The numbers are those of the equations in 50 digits, and each has with it how far rounding may move it. The program
 * prints a line a function; its exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "two_link.hpp"

#include <array>
#include <cmath>
#include <cstdio>

/* Print whether numbers are what they must be, and return how many are not; what is no number never is. */
template <std::size_t N>
int wrong(const char *name, const std::array<double, N> &found, const std::array<double, N> &wanted, const std::array<double, N> &allowed)
{
    int off = 0;
    for (std::size_t k = 0; k < N; k++) {
        off += std::abs(found[k] - wanted[k]) <= allowed[k] ? 0 : 1;
    }
    std::printf("%-40s %s (%d of %d numbers)\n", name, off ? "WRONG" : "right", int(N) - off, int(N));
    return off;
}

int main()
{
    const std::array<double, 2> q = {1.8942348488091483, -1.7844060686319136};
    const std::array<double, 2> qd = {1.1900786505941334, 0.6186311741161856};
    const std::array<double, 2> qdd = {-1.5090139330826062, -0.8319913100426404};
    const std::array<double, 5> params = {1.0771357864705502, 0.9665256295132645, 0.9721401655125133, 1.1409863456303149, 0.7606456264398351};
    const std::array<double, 2> tau = {-1.773451708248249, 4.433856233091829};
    int off = 0;
    {
        const std::array<double, 2> found = two_link::inverse_dynamics(q, qd, qdd, params);
        const std::array<double, 2> wanted = {-1.5166918093194068, -3.994576113466394};
        const std::array<double, 2> allowed = {2.9e-14, 9.8e-15};
        off += wrong("inverse_dynamics", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::forward_dynamics(q, qd, tau, params);
        const std::array<double, 2> wanted = {-5.2982331392697875, 8.971248111859595};
        const std::array<double, 2> allowed = {4.5e-14, 5.9e-14};
        off += wrong("forward_dynamics", found, wanted, allowed);
    }
    {
        const std::array<double, 4> found = two_link::mass_matrix(q, params);
        const std::array<double, 4> wanted = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        const std::array<double, 4> allowed = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        off += wrong("mass_matrix", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::velocity_forces(q, qd, params);
        const std::array<double, 2> wanted = {1.9436399856191295, -1.4838483535569849};
        const std::array<double, 2> allowed = {1.7e-14, 4.7e-15};
        off += wrong("velocity_forces", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::gravity_forces(q, params);
        const std::array<double, 2> wanted = {1.5247788152016606, 0.09194304874029749};
        const std::array<double, 2> allowed = {6.4e-15, 1.9e-15};
        off += wrong("gravity_forces", found, wanted, allowed);
    }
    {
        const std::array<double, 4> found = two_link::coriolis_matrix(q, qd, params);
        const std::array<double, 4> wanted = {0.6481417417818378, 1.8949907234152703, -1.2468489816334325, 0.0};
        const std::array<double, 4> allowed = {1.9e-15, 6.0e-15, 3.6e-15, 2.2e-308};
        off += wrong("coriolis_matrix", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::momentum(q, qd, params);
        const std::array<double, 2> wanted = {3.8928112723558224, 2.005382192320685};
        const std::array<double, 2> allowed = {9.1e-15, 3.6e-15};
        off += wrong("momentum", found, wanted, allowed);
    }
    {
        const std::array<double, 1> found = {two_link::kinetic_energy(q, qd, params)};
        const std::array<double, 1> wanted = {2.936671763104942};
        const std::array<double, 1> allowed = {9.3e-15};
        off += wrong("kinetic_energy", found, wanted, allowed);
    }
    {
        const std::array<double, 1> found = {two_link::potential_energy(q, params)};
        const std::array<double, 1> wanted = {-0.35347950003900824};
        const std::array<double, 1> allowed = {5.0e-15};
        off += wrong("potential_energy", found, wanted, allowed);
    }
    {
        const std::array<double, 4> found = two_link::k_z(q, params);
        const std::array<double, 4> wanted = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        const std::array<double, 4> allowed = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        off += wrong("k_z", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::k_C(q, params);
        const std::array<double, 2> wanted = {2.095406015410758, 0.0};
        const std::array<double, 2> allowed = {6.6e-15, 2.2e-308};
        off += wrong("k_C", found, wanted, allowed);
    }
    {
        const std::array<double, 4> found = two_link::k_D(q, params);
        const std::array<double, 4> wanted = {0.0, 1.047703007705379, -1.047703007705379, 0.0};
        const std::array<double, 4> allowed = {2.2e-308, 2.8e-15, 2.8e-15, 2.2e-308};
        off += wrong("k_D", found, wanted, allowed);
    }
    {
        const std::array<double, 2> found = two_link::k_G(q, params);
        const std::array<double, 2> wanted = {1.5247788152016606, 0.09194304874029749};
        const std::array<double, 2> allowed = {6.4e-15, 1.9e-15};
        off += wrong("k_G", found, wanted, allowed);
    }
    {
        const std::array<double, 12> found = two_link::pose_tool(q, params);
        const std::array<double, 12> wanted = {0.9939748796082962, -0.10960811424193481, 0.0, 1.0467942753507573, 0.10960811424193481, 0.9939748796082962, 0.0, -0.8251377579962568, 0.0, 0.0, 1.0, 0.0};
        const std::array<double, 12> allowed = {4.3e-15, 2.1e-15, 2.2e-308, 4.7e-15, 2.1e-15, 4.3e-15, 2.2e-308, 6.0e-15, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308};
        off += wrong("pose_tool", found, wanted, allowed);
    }
    {
        const std::array<double, 12> found = two_link::jacobian_tool(q, params);
        const std::array<double, 12> wanted = {0.8251377579962568, 1.134111765532602, 1.0467942753507573, 0.12506136172033527, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0};
        const std::array<double, 12> allowed = {6.0e-15, 6.9e-15, 4.7e-15, 6.5e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16, 3.5e-16};
        off += wrong("jacobian_tool", found, wanted, allowed);
    }
    {
        const std::array<double, 6> found = two_link::jdot_qdot_tool(q, qd, params);
        const std::array<double, 6> wanted = {-1.7145681668147574, 3.272572717739957, 0.0, 0.0, 0.0, 0.0};
        const std::array<double, 6> allowed = {1.8e-14, 2.4e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        off += wrong("jdot_qdot_tool", found, wanted, allowed);
    }
    return off ? 1 : 0;
}
