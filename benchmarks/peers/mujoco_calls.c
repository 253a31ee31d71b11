/*
 * MuJoCo's pipeline stages that each output needs and no others, in a timing loop of their own. Kinematics are part of
 * every output, as they are of everybody else's functions. The joint order is MuJoCo's own.
 */
#define _GNU_SOURCE
#include <mujoco/mujoco.h>
#include <string.h>
#include <time.h>

static void call(const mjModel *m, mjData *d, int output, const double *q, const double *qd, const double *x)
{
    const size_t bytes = (size_t)m->nv * sizeof(double);
    memcpy(d->qpos, q, bytes);
    mj_kinematics(m, d);
    mj_comPos(m, d);
    if (output == 1 || output == 2) mj_makeM(m, d);
    if (output == 1) return;
    if (output == 3) memset(d->qvel, 0, bytes);
    else memcpy(d->qvel, qd, bytes);
    mj_comVel(m, d);
    if (output == 0) memcpy(d->qacc, x, bytes);
    mj_rne(m, d, output == 0, d->qfrc_bias);
    if (output != 2) return;
    mj_factorM(m, d);
    for (int i = 0; i < m->nv; ++i) d->qfrc_smooth[i] = x[i] - d->qfrc_bias[i];
    mj_solveM(m, d, d->qacc, d->qfrc_smooth, 1);
}

static void copy(const mjModel *m, mjData *d, int output, double *out)
{
    if (output == 1) mj_fullM(m, d, out);
    else memcpy(out, output == 2 ? d->qacc : d->qfrc_bias, (size_t)m->nv * sizeof(double));
}

double peer_time(const void *model, void *data, int output, long states, long sweeps, const double *q, const double *qd,
                 const double *x, double *out)
{
    const mjModel *m = model;
    mjData *d = data;
    const long n = m->nv, size = output == 1 ? n * n : n;
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long sweep = 0; sweep < sweeps; ++sweep)
        for (long k = 0; k < states; ++k)
        {
            call(m, d, output, q + k * n, qd + k * n, x + k * n);
            if (out) copy(m, d, output, out + k * size);
        }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}
