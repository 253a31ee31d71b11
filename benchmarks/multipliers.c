/* How many products of the widest vectors a core begins in a cycle, and how long a cycle is. */
#include <stddef.h>
#include <time.h>

#if defined(__AVX512F__)
enum { BYTES = 64 };
#elif defined(__AVX__)
enum { BYTES = 32 };
#else
enum { BYTES = 16 };
#endif
typedef double vector __attribute__((vector_size(BYTES)));

#if defined(__aarch64__)
#define VECTOR "+w"
#else
#define VECTOR "+v"
#endif
/* The compiler has to take a value for one that it does not know. */
#define UNKNOWN(kind, x) __asm__ volatile("" : kind(x))

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int width(void) { return 8 * BYTES; }

/* Seconds of one operation on an integer that waits for the one before. */
double cycle(long turns) {
    unsigned long x = 1;
    const double begun = seconds();
    for (long turn = 0; turn < turns; ++turn) {
#define STEP x ^= (unsigned long)turn; UNKNOWN("+r", x); x += 7; UNKNOWN("+r", x);
        STEP STEP STEP STEP STEP STEP STEP STEP
#undef STEP
    }
    return (seconds() - begun) / (16.0 * (double)turns);
}

/* Seconds of one product of vectors, each of twelve waiting for its own last. */
double product(long turns) {
    vector one;
    for (size_t k = 0; k < BYTES / sizeof(double); ++k) one[k] = 1.0;
    UNKNOWN(VECTOR, one);
    vector a = one, b = one, c = one, d = one, e = one, f = one, g = one, h = one, i = one, j = one, k = one, l = one;
    const double begun = seconds();
    for (long turn = 0; turn < turns; ++turn) {
#define STEP(x) x *= one; UNKNOWN(VECTOR, x);
        STEP(a) STEP(b) STEP(c) STEP(d) STEP(e) STEP(f) STEP(g) STEP(h) STEP(i) STEP(j) STEP(k) STEP(l)
#undef STEP
    }
    return (seconds() - begun) / (12.0 * (double)turns);
}
