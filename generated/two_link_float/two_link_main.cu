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

static float *on_host(size_t n, int length)
{
    float *x = (float *)malloc((n * length + 1) * sizeof *x);
    if (!x) {
        fprintf(stderr, "no memory\n");
        exit(2);
    }
    return x;
}

static float *on_device(size_t n, int length)
{
    void *x = 0;
    check(cudaMalloc(&x, (n * length + 1) * sizeof(float)));
    return (float *)x;
}

/* Return columns of the device that hold `values` for every one of n states: entry i of state k is x[i * n + k]. */
static float *copied(size_t n, int length, const float *values)
{
    float *columns = on_host(n, length), *x = on_device(n, length);
    for (size_t place = 0; place < n * length; place++) {
        columns[place] = values[place / n];
    }
    check(cudaMemcpy(x, columns, n * length * sizeof *x, cudaMemcpyHostToDevice));
    free(columns);
    return x;
}

/* Print how many numbers of a result are what they must be, and return how many are not; what is no number never is. */
static size_t wrong(const char *name, size_t n, int length, const float *out, const float *wanted, const float *allowed)
{
    float *found = on_host(n, length);
    size_t off = 0;
    check(cudaGetLastError());
    check(cudaMemcpy(found, out, n * length * sizeof *found, cudaMemcpyDeviceToHost));
    for (size_t place = 0; place < n * length; place++) {
        if (!(fabsf(found[place] - wanted[place / n]) <= allowed[place / n])) {
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
    static const float given_q[2] = {1.8942349f, -1.7844061f};
    float *q = copied(n, 2, given_q);
    static const float given_qd[2] = {1.1900786f, 0.6186312f};
    float *qd = copied(n, 2, given_qd);
    static const float given_qdd[2] = {-1.5090139f, -0.8319913f};
    float *qdd = copied(n, 2, given_qdd);
    static const float given_params[5] = {1.0771358f, 0.9665256f, 0.9721402f, 1.1409863f, 0.7606456f};
    float *params = copied(1, 5, given_params);
    static const float given_tau[2] = {-1.7734517f, 4.433856f};
    float *tau = copied(n, 2, given_tau);
    size_t off = 0;
    {
        static const float wanted[2] = {-1.5166917f, -3.9945757f};
        static const float allowed[2] = {1.6e-05f, 5.3e-06f};
        float *out = on_device(n, 2);
        two_link_inverse_dynamics<<<(n + 127) / 128, 128>>>(n, q, qd, qdd, params, out);
        off += wrong("inverse_dynamics", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {-5.2982326f, 8.971248f};
        static const float allowed[2] = {2.4e-05f, 3.2e-05f};
        float *out = on_device(n, 2);
        two_link_forward_dynamics<<<(n + 127) / 128, 128>>>(n, q, qd, tau, params, out);
        off += wrong("forward_dynamics", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[4] = {2.7351131f, 1.0310044f, 1.0310044f, 1.2582712f};
        static const float allowed[4] = {2.5e-06f, 8.2e-07f, 8.2e-07f, 3.9e-07f};
        float *out = on_device(n, 4);
        two_link_mass_matrix<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("mass_matrix", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {1.94364f, -1.4838482f};
        static const float allowed[2] = {9.2e-06f, 2.5e-06f};
        float *out = on_device(n, 2);
        two_link_velocity_forces<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("velocity_forces", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {1.5247788f, 0.091943085f};
        static const float allowed[2] = {3.4e-06f, 1.0e-06f};
        float *out = on_device(n, 2);
        two_link_gravity_forces<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("gravity_forces", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[4] = {0.64814174f, 1.8949907f, -1.246849f, 0.0f};
        static const float allowed[4] = {1.0e-06f, 3.2e-06f, 2.0e-06f, 1.2e-38f};
        float *out = on_device(n, 4);
        two_link_coriolis_matrix<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("coriolis_matrix", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {3.8928113f, 2.005382f};
        static const float allowed[2] = {4.9e-06f, 1.9e-06f};
        float *out = on_device(n, 2);
        two_link_momentum<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("momentum", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[1] = {2.9366717f};
        static const float allowed[1] = {5.0e-06f};
        float *out = on_device(n, 1);
        two_link_kinetic_energy<<<(n + 127) / 128, 128>>>(n, q, qd, params, out);
        off += wrong("kinetic_energy", n, 1, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[1] = {-0.3534794f};
        static const float allowed[1] = {2.7e-06f};
        float *out = on_device(n, 1);
        two_link_potential_energy<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("potential_energy", n, 1, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[4] = {2.7351131f, 1.0310044f, 1.0310044f, 1.2582712f};
        static const float allowed[4] = {2.5e-06f, 8.2e-07f, 8.2e-07f, 3.9e-07f};
        float *out = on_device(n, 4);
        two_link_k_z<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_z", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {2.095406f, 0.0f};
        static const float allowed[2] = {3.5e-06f, 1.2e-38f};
        float *out = on_device(n, 2);
        two_link_k_C<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_C", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[4] = {0.0f, 1.047703f, -1.047703f, 0.0f};
        static const float allowed[4] = {1.2e-38f, 1.5e-06f, 1.5e-06f, 1.2e-38f};
        float *out = on_device(n, 4);
        two_link_k_D<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_D", n, 4, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[2] = {1.5247788f, 0.091943085f};
        static const float allowed[2] = {3.4e-06f, 1.0e-06f};
        float *out = on_device(n, 2);
        two_link_k_G<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("k_G", n, 2, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[12] = {0.99397486f, -0.109608166f, 0.0f, 1.0467943f, 0.109608166f, 0.99397486f, 0.0f, -0.8251377f, 0.0f, 0.0f, 1.0f, 0.0f};
        static const float allowed[12] = {2.3e-06f, 1.1e-06f, 1.2e-38f, 2.5e-06f, 1.1e-06f, 2.3e-06f, 1.2e-38f, 3.2e-06f, 1.2e-38f, 1.2e-38f, 1.9e-07f, 1.2e-38f};
        float *out = on_device(n, 12);
        two_link_pose_tool<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("pose_tool", n, 12, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[12] = {0.8251377f, 1.1341118f, 1.0467943f, 0.12506142f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f};
        static const float allowed[12] = {3.2e-06f, 3.7e-06f, 2.5e-06f, 3.5e-06f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.9e-07f, 1.9e-07f};
        float *out = on_device(n, 12);
        two_link_jacobian_tool<<<(n + 127) / 128, 128>>>(n, q, params, out);
        off += wrong("jacobian_tool", n, 12, out, wanted, allowed);
        check(cudaFree(out));
    }
    {
        static const float wanted[6] = {-1.7145683f, 3.2725725f, 0.0f, 0.0f, 0.0f, 0.0f};
        static const float allowed[6] = {9.5e-06f, 1.3e-05f, 1.2e-38f, 1.2e-38f, 1.2e-38f, 1.2e-38f};
        float *out = on_device(n, 6);
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
