/* What both programs of benchmarks/gpu.py have: a clock, the states at which results are compared, and how they are told.
 * REAL is the type. */
#pragma once
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
const size_t KNOWN = 64; /* states in given.bin: q, qd, qdd, tau, a block of doubles each, a row a state */
const int NUMBERS = 4;

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

/* The known states, a block after another. */
static double *known(size_t axes)
{
    const size_t count = NUMBERS * KNOWN * axes;
    double *x = (double *)malloc(count * sizeof(double));
    FILE *file = fopen("given.bin", "rb");
    if (!x || !file || fread(x, sizeof(double), count, file) != count) {
        fprintf(stderr, "given.bin cannot be read\n");
        exit(2);
    }
    fclose(file);
    return x;
}

/* Print what lies on the card: "result name numbers". */
static void tell(const char *name, const REAL *out, size_t count)
{
    REAL *x = (REAL *)malloc(count * sizeof(REAL));
    CHECK(cudaGetLastError());
    CHECK(cudaMemcpy(x, out, count * sizeof(REAL), cudaMemcpyDeviceToHost));
    printf("result %s", name);
    for (size_t i = 0; i < count; i++) {
        printf(" %.17g", (double)x[i]);
    }
    printf("\n");
    free(x);
}

/* Print which card it is; end where there is none. */
static cudaDeviceProp card()
{
    int devices = 0;
    const cudaError_t status = cudaGetDeviceCount(&devices);
    if (status != cudaSuccess || !devices) {
        fprintf(stderr, "%s", status == cudaSuccess ? "no device" : cudaGetErrorString(status));
        exit(3);
    }
    cudaDeviceProp found;
    CHECK(cudaGetDeviceProperties(&found, 0));
    printf("card %s\n", found.name);
    return found;
}
