/*
 * Timing loops in C, so that no Python is on the clock. A function takes one to three arrays of arguments and one of
 * results; `sweeps` passes over all states are timed, in seconds of the processor for the calling thread.
 */
#define _GNU_SOURCE
#include <pthread.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

typedef void one(const double *, double *);
typedef void two(const double *, const double *, double *);
typedef void three(const double *, const double *, const double *, double *);
typedef void many1(size_t, const double *, double *);
typedef void many2(size_t, const double *, const double *, double *);
typedef void many3(size_t, const double *, const double *, const double *, double *);
typedef int casadi(const double **, double **, long long *, double *, void *);

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* One state a call; the arguments have n[0], n[1], n[2] entries, the result `size`. */
double time_states(void *f, int arguments, long states, long sweeps, const long *n, long size, const double *a,
                   const double *b, const double *c, double *out)
{
    const double start = now();
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
            switch (arguments)
            {
            case 1: ((one *)f)(a + k * n[0], out + k * size); break;
            case 2: ((two *)f)(a + k * n[0], b + k * n[1], out + k * size); break;
            default: ((three *)f)(a + k * n[0], b + k * n[1], c + k * n[2], out + k * size);
            }
    return now() - start;
}

/* All states in one call; the layout is the function's own affair. */
double time_batch(void *f, int arguments, long states, long sweeps, const double *a, const double *b, const double *c,
                  double *out)
{
    const size_t count = (size_t)states;
    const double start = now();
    for (long sweep = 0; sweep < sweeps; ++sweep)
        switch (arguments)
        {
        case 1: ((many1 *)f)(count, a, out); break;
        case 2: ((many2 *)f)(count, a, b, out); break;
        default: ((many3 *)f)(count, a, b, c, out);
        }
    return now() - start;
}

/* `count` numbers written over and over, each time others: what any function costs that has so many results. */
double time_filling(long count, long sweeps, double *out)
{
    const double start = now();
    for (long sweep = 0; sweep < sweeps; ++sweep)
    {
        memset(out, (int)(sweep & 31), (size_t)count * sizeof *out);
        __asm__ volatile("" : : "r"(out) : "memory"); /* each of them is written */
    }
    return now() - start;
}

/* CasADi's calling convention: one array of addresses for arguments, one for results. */
double time_casadi(void *f, int arguments, long states, long sweeps, const long *n, long size, const double *a,
                   const double *b, const double *c, double *out, long long *iw, double *w)
{
    const double start = now();
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
        {
            const double *in[3] = {a + k * n[0], arguments > 1 ? b + k * n[1] : 0, arguments > 2 ? c + k * n[2] : 0};
            double *results[1] = {out + k * size};
            ((casadi *)f)(in, results, iw, w, 0);
        }
    return now() - start;
}

struct share
{
    void *f;
    int arguments;
    long states, sweeps;
    const double *a, *b, *c;
    double *out;
    pthread_barrier_t *ready;
    double seconds;
};

static void *work(void *given)
{
    struct share *s = given;
    time_batch(s->f, s->arguments, s->states, 1, s->a, s->b, s->c, s->out); /* fills the caches of this core */
    pthread_barrier_wait(s->ready);
    const double start = now();
    time_batch(s->f, s->arguments, s->states, s->sweeps, s->a, s->b, s->c, s->out);
    s->seconds = now() - start;
    return 0;
}

/*
 * Array-of-structures batches on two threads, half of the states each: processor time of the one that takes longer, so
 * that waiting for a core is no part of it, but waiting for memory that both want is.
 */
double time_threads(void *f, int arguments, long states, long sweeps, const long *n, long size, const double *a,
                    const double *b, const double *c, double *out)
{
    const long half = states / 2;
    pthread_t threads[2];
    pthread_barrier_t ready;
    struct share shares[2];
    pthread_barrier_init(&ready, 0, 2);
    for (long t = 0; t < 2; ++t)
    {
        const long first = t * half;
        const struct share one = {f, arguments, t ? states - half : half, sweeps, a + first * n[0],
                                  b + first * n[1], c + first * n[2], out + first * size, &ready, 0};
        shares[t] = one;
        pthread_create(&threads[t], 0, work, &shares[t]);
    }
    for (long t = 0; t < 2; ++t) pthread_join(threads[t], 0);
    pthread_barrier_destroy(&ready);
    return shares[0].seconds > shares[1].seconds ? shares[0].seconds : shares[1].seconds;
}
