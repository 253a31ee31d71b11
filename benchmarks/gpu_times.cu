/* Times of kernels, included before: a line each, "name states seconds". KERNELS(T) is a T(name, block, inputs, entries,
 * arguments) for each of them, where arguments are a[0], a[1], ...; REAL is their type. */
#include <cstdio>
#include <cstdlib>

#define CHECK(call)                                                                 \
    do {                                                                            \
        cudaError_t status = (call);                                                \
        if (status != cudaSuccess) {                                                \
            fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(status));              \
            exit(2);                                                                \
        }                                                                           \
    } while (0)

const size_t MOST = 1000000;
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

/* Seconds of one launch: the median of 7 rounds of so many that a round takes 20 ms. */
template <class Launch> static double seconds(Launch launch)
{
    cudaEvent_t begin, end;
    CHECK(cudaEventCreate(&begin));
    CHECK(cudaEventCreate(&end));
    double found[7];
    int count = 1;
    for (int round = -1; round < 7;) {
        CHECK(cudaEventRecord(begin));
        for (int i = 0; i < count; i++) {
            launch();
        }
        CHECK(cudaEventRecord(end));
        CHECK(cudaEventSynchronize(end));
        CHECK(cudaGetLastError());
        float ms = 0;
        CHECK(cudaEventElapsedTime(&ms, begin, end));
        if (round < 0 && ms < 20) {
            count *= 2;
            continue;
        }
        if (round >= 0) {
            found[round] = ms / 1e3 / count;
        }
        round++;
    }
    for (int i = 1; i < 7; i++) {
        for (int j = i; j > 0 && found[j] < found[j - 1]; j--) {
            double x = found[j];
            found[j] = found[j - 1];
            found[j - 1] = x;
        }
    }
    return found[3];
}

int main()
{
    int devices = 0;
    const cudaError_t status = cudaGetDeviceCount(&devices);
    if (status != cudaSuccess || !devices) {
        fprintf(stderr, "%s", status == cudaSuccess ? "no device" : cudaGetErrorString(status));
        return 3;
    }
    cudaDeviceProp card;
    CHECK(cudaGetDeviceProperties(&card, 0));
    printf("card %s\n", card.name);
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
    const size_t threads = (size_t)card.multiProcessorCount * 2048;
    printf("fused %zu %.9g\n", threads * CHAINS * TURNS, seconds([&] { fused<<<threads / 256, 256>>>(many, in, out); }));
    CHECK(cudaFree(out));
#define T(name, block, entries, ...)                                                                         \
    CHECK(cudaMalloc(&out, MOST *(entries) * sizeof(REAL)));                                                 \
    for (size_t n = 16; n <= MOST; n = n == 262144 ? MOST : n * 4) {                                         \
        for (int i = 0; i < 4; i++) {                                                                        \
            a[i] = in + i * 16 * MOST;                                                                       \
        }                                                                                                    \
        printf(#name " %zu %.9g\n", n, seconds([&] { name<<<(n + block - 1) / block, block>>>(n, __VA_ARGS__, out); })); \
    }                                                                                                        \
    CHECK(cudaFree(out));
    KERNELS(T)
    return 0;
}
