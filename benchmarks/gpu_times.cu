/* Times of kernels, included before: a line each, "name states seconds", and what comes out at known states. KERNELS(T)
 * is a T(name, block, parts, entries, arguments) for each of them, where arguments are among a[0], ..., a[3]: q, qd,
 * qdd, tau; REAL is their type, AXES the length of an argument. */
#include "gpu_clock.cuh"

const int CHAINS = 8, TURNS = 4096;

__global__ void copy(size_t n, const REAL *__restrict__ from, REAL *__restrict__ to)
{
    const size_t k = (size_t)blockIdx.x * blockDim.x + threadIdx.x;
    if (k < n) {
        to[k] = from[k];
    }
}

__global__ void fused(size_t n, const REAL *__restrict__ from, REAL *__restrict__ to)
{
    const size_t k = (size_t)blockIdx.x * blockDim.x + threadIdx.x;
    REAL x[CHAINS], factor = from[k % n], more = from[0];
    for (int i = 0; i < CHAINS; i++) {
        x[i] = factor + i;
    }
    for (int turn = 0; turn < TURNS; turn++) {
#pragma unroll
        for (int i = 0; i < CHAINS; i++) {
            x[i] = x[i] * factor + more;
        }
    }
    for (int i = 1; i < CHAINS; i++) {
        x[0] += x[i];
    }
    to[k % n] = x[0];
}

__global__ void nothing() {}

int main()
{
    const cudaDeviceProp found = card();
    const size_t many = 64 * MOST;
    REAL *out, *in, *a[4];
    CHECK(cudaMalloc(&out, many * sizeof(REAL)));
    CHECK(cudaMalloc(&in, many * sizeof(REAL)));
    REAL *host = (REAL *)malloc(many * sizeof(REAL));
    for (size_t i = 0; i < many; i++) {
        host[i] = (REAL)((double)rand() / RAND_MAX);
    }
    CHECK(cudaMemcpy(in, host, many * sizeof(REAL), cudaMemcpyHostToDevice));
    printf("nothing 1 %.9g\n", seconds([&] { nothing<<<1, 32>>>(); }));
    printf("copy %zu %.9g\n", many, seconds([&] { copy<<<(many + 255) / 256, 256>>>(many, in, out); }));
    const size_t threads = (size_t)found.multiProcessorCount * 2048;
    printf("fused %zu %.9g\n", threads * CHAINS * TURNS, seconds([&] { fused<<<threads / 256, 256>>>(many, in, out); }));
    CHECK(cudaFree(out));
    for (int i = 0; i < 4; i++) {
        a[i] = in + i * 16 * MOST;
    }
    const double *given = known(AXES);
    for (int i = 0; i < NUMBERS; i++) { /* columns of the known states, where the arguments begin */
        for (size_t k = 0; k < KNOWN; k++) {
            for (size_t j = 0; j < AXES; j++) {
                host[j * KNOWN + k] = (REAL)given[(i * KNOWN + k) * AXES + j];
            }
        }
        CHECK(cudaMemcpy(a[i], host, KNOWN * AXES * sizeof(REAL), cudaMemcpyHostToDevice));
    }
    CHECK(cudaMalloc(&out, MOST * sizeof(REAL)));
#define T(name, block, parts, entries, ...)                                             \
    name<<<dim3((KNOWN + block - 1) / block, parts), block>>>(KNOWN, __VA_ARGS__, out); \
    tell(#name, out, KNOWN * (entries));
    KERNELS(T)
#undef T
    CHECK(cudaFree(out));
#define T(name, block, parts, entries, ...)                                                                      \
    CHECK(cudaMalloc(&out, MOST *(entries) * sizeof(REAL)));                                                     \
    for (size_t n = 16; n <= MOST; n = n == 262144 ? MOST : n * 4) {                                             \
        const dim3 grid((n + block - 1) / block, parts);                                                         \
        printf(#name " %zu %.9g\n", n, seconds([&] { name<<<grid, block>>>(n, __VA_ARGS__, out); }));            \
    }                                                                                                            \
    CHECK(cudaFree(out));
    KERNELS(T)
    return 0;
}
