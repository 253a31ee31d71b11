/*
 * How the kernels of two_link.cu are called: every one of them once, with what must come out beside it.
 *
 *     nvcc -O3 two_link_main.cu -o two_link_main
 *
 * All 1000 states are the same one, so that they fill several blocks and have one result. Its numbers are those of the
 * equations in 50 digits, and each has with it how far rounding may move it. The program prints a line a kernel; its
 * exit status is 0 where all are right. Written by symdyn generate; do not edit.
 */
#include "two_link.cu"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* End the program where CUDA has a fault. */
static void check(cudaError_t status)
{
    if (status != cudaSuccess) {
        fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(status));
        exit(2);
    }
}

static double *on_host(size_t n, int length)
{
    double *x = (double *)malloc((n * length + 1) * sizeof *x);
    if (!x) {
        fprintf(stderr, "no memory\n");
        exit(2);
    }
    return x;
}

static double *on_device(size_t n, int length)
{
    void *x = 0;
    check(cudaMalloc(&x, (n * length + 1) * sizeof(double)));
    return (double *)x;
}

/* Return columns of the device that hold `values` for every one of n states: entry i of state k is x[i * n + k]. */
static double *copied(size_t n, int length, const double *values)
{
    double *columns = on_host(n, length), *x = on_device(n, length);
    for (size_t place = 0; place < n * length; place++) {
        columns[place] = values[place / n];
    }
    check(cudaMemcpy(x, columns, n * length * sizeof *x, cudaMemcpyHostToDevice));
    free(columns);
    return x;
}

/* Print how many numbers of a result are what they must be, and return how many are not; what is no number never is. */
static size_t wrong(const char *name, size_t n, int length, const double *out, const double *wanted, const double *allowed)
{
    double *found = on_host(n, length);
    size_t off = 0;
    check(cudaGetLastError());
    check(cudaMemcpy(found, out, n * length * sizeof *found, cudaMemcpyDeviceToHost));
    for (size_t place = 0; place < n * length; place++) {
        if (!(fabs(found[place] - wanted[place / n]) <= allowed[place / n])) {
            off++;
        }
    }
    printf("%-40s %s (%lu of %lu numbers)\n", name, off ? "WRONG" : "right", (unsigned long)(n * length - off), (unsigned long)(n * length));
    free(found);
    return off;
}

int main(void)
{
    const size_t n = 1000;
    static const double given_q[2] = {1.8942348488091483, -1.7844060686319136};
    double *q = copied(n, 2, given_q);
    static const double given_qd[2] = {1.1900786505941334, 0.6186311741161856};
    double *qd = copied(n, 2, given_qd);
    static const double given_qdd[2] = {-1.5090139330826062, -0.8319913100426404};
    double *qdd = copied(n, 2, given_qdd);
    static const double given_params[5] = {1.0771357864705502, 0.9665256295132645, 0.9721401655125133, 1.1409863456303149, 0.7606456264398351};
    double *params = copied(1, 5, given_params);
    static const double given_tau[2] = {-1.773451708248249, 4.433856233091829};
    double *tau = copied(n, 2, given_tau);
    size_t off = 0;
    {
        static const double wanted[2] = {-1.5166918093194068, -3.994576113466394};
        static const double allowed[2] = {2.9e-14, 9.8e-15};
        double *out = on_device(n, 2);
        two_link_inverse_dynamics<<<(n + 127) / 128, 128>>>(n, q, qd, qdd, params, out);
        off += wrong("inverse_dynamics", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {-5.2982331392697875, 8.971248111859595};
        static const double allowed[2] = {4.5e-14, 5.9e-14};
        double *out = on_device(n, 2);
        two_link_forward_dynamics<<<(n + 127) / 128, 128>>>(n, q, qd, tau, params, out);
        off += wrong("forward_dynamics", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[4] = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        static const double allowed[4] = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        double *out = on_device(n, 4);
        two_link_mass_matrix<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("mass_matrix", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {1.9436399856191295, -1.4838483535569849};
        static const double allowed[2] = {1.7e-14, 4.7e-15};
        double *out = on_device(n, 2);
        two_link_velocity_forces<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("velocity_forces", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {1.5247788152016606, 0.09194304874029749};
        static const double allowed[2] = {6.4e-15, 1.9e-15};
        double *out = on_device(n, 2);
        two_link_gravity_forces<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("gravity_forces", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[4] = {0.6481417417818378, 1.8949907234152703, -1.2468489816334325, 0.0};
        static const double allowed[4] = {1.9e-15, 6.0e-15, 3.6e-15, 2.2e-308};
        double *out = on_device(n, 4);
        two_link_coriolis_matrix<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("coriolis_matrix", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {3.8928112723558224, 2.005382192320685};
        static const double allowed[2] = {9.1e-15, 3.6e-15};
        double *out = on_device(n, 2);
        two_link_momentum<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("momentum", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[1] = {2.936671763104942};
        static const double allowed[1] = {9.3e-15};
        double *out = on_device(n, 1);
        two_link_kinetic_energy<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("kinetic_energy", n, 1, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[1] = {-0.35347950003900824};
        static const double allowed[1] = {5.0e-15};
        double *out = on_device(n, 1);
        two_link_potential_energy<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("potential_energy", n, 1, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[4] = {2.7351131624042138, 1.0310044457924044, 1.0310044457924044, 1.25827123702194};
        static const double allowed[4] = {4.7e-15, 1.5e-15, 1.5e-15, 7.3e-16};
        double *out = on_device(n, 4);
        two_link_k_z<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_z", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {2.095406015410758, 0.0};
        static const double allowed[2] = {6.6e-15, 2.2e-308};
        double *out = on_device(n, 2);
        two_link_k_C<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_C", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[4] = {0.0, 1.047703007705379, -1.047703007705379, 0.0};
        static const double allowed[4] = {2.2e-308, 2.8e-15, 2.8e-15, 2.2e-308};
        double *out = on_device(n, 4);
        two_link_k_D<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_D", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[2] = {1.5247788152016606, 0.09194304874029749};
        static const double allowed[2] = {6.4e-15, 1.9e-15};
        double *out = on_device(n, 2);
        two_link_k_G<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_G", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[12] = {0.9939748796082962, -0.10960811424193481, 0.0, 1.0467942753507573, 0.10960811424193481, 0.9939748796082962, 0.0, -0.8251377579962568, 0.0, 0.0, 1.0, 0.0};
        static const double allowed[12] = {4.3e-15, 2.1e-15, 2.2e-308, 4.7e-15, 2.1e-15, 4.3e-15, 2.2e-308, 6.0e-15, 2.2e-308, 2.2e-308, 3.5e-16, 2.2e-308};
        double *out = on_device(n, 12);
        two_link_pose_tool<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("pose_tool", n, 12, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[12] = {0.8251377579962568, 1.134111765532602, 1.0467942753507573, 0.12506136172033527, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0};
        static const double allowed[12] = {6.0e-15, 6.9e-15, 4.7e-15, 6.5e-15, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308, 3.5e-16, 3.5e-16};
        double *out = on_device(n, 12);
        two_link_jacobian_tool<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("jacobian_tool", n, 12, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const double wanted[6] = {-1.7145681668147574, 3.272572717739957, 0.0, 0.0, 0.0, 0.0};
        static const double allowed[6] = {1.8e-14, 2.4e-14, 2.2e-308, 2.2e-308, 2.2e-308, 2.2e-308};
        double *out = on_device(n, 6);
        two_link_jdot_qdot_tool<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("jdot_qdot_tool", n, 6, out, wanted, allowed);
        check(cudaFree(out));
    }
    check(cudaFree(q));
    check(cudaFree(qd));
    check(cudaFree(qdd));
    check(cudaFree(params));
    check(cudaFree(tau));
    return off ? 1 : 0;
}
