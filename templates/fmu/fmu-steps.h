/* Steps of a co-simulation: the pair of orders 5 and 4 of Dormand and Prince, with control of the step's size.

Errors of a step are measured against tolerance (1 + |x|), and a step is as long as they allow, however long those of the
co-simulation are; what is over is taken up by the next. After each, quaternions have unit length and loops are closed.

Reference: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), section II.4 and table II.5.2. */

static int rates_at(Model *m, double time, const double *x, double *dx)
{
    m->n.time = time;
    memcpy(m->n.x, x, sizeof m->n.x);
    stale(m);
    if (!evaluate(m))
        return 0;
    memcpy(dx, m->dx, sizeof m->dx);
    return 1;
}

static double measured(const double *error, const double *x, const double *y, double tolerance)
{
    double sum = 0;

    for (int i = 0; i < NX; ++i) {
        const double part = error[i] / (tolerance * (1 + fmax(fabs(x[i]), fabs(y[i]))));
        sum += part * part;
    }
    return sqrt(sum / NX);
}

/* Returns a first step: one that Euler's method would not take far. */
static double first_step(const Model *m, const double *dx)
{
    double size = 0, speed = 0;

    for (int i = 0; i < NX; ++i) {
        const double scale = 1 + fabs(m->n.x[i]);
        size += m->n.x[i] / scale * m->n.x[i] / scale;
        speed += dx[i] / scale * dx[i] / scale;
    }
    return speed > 0 ? fmax(1e-6, 0.01 * sqrt((size + 1e-4) / speed)) : 1e-3;
}

/* Moves the model to a time; returns whether it got there, and leaves it where the last good step ended. */
static int advance(Model *m, double until)
{
    static const double C[7] = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1};
    static const double A[7][6] = {
        {0},
        {1. / 5},
        {3. / 40, 9. / 40},
        {44. / 45, -56. / 15, 32. / 9},
        {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
        {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
        {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}};
    static const double E[7] = {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40};
    double k[7][NX], x[NX], y[NX], error[NX], before = 1e-4;
    double time = m->n.time, step;

    memcpy(x, m->n.x, sizeof x);
    if (!rates_at(m, time, x, k[0]))
        return 0;
    if (!(m->n.step > 0))
        m->n.step = first_step(m, k[0]);
    step = m->n.step;
    while (time < until) {
        const double rest = until - time;
        const int last = step >= rest * (1 - 1e-12);
        const double h = last ? rest : step;
        int fine = 1;

        for (int s = 1; s < 7 && fine; ++s) {
            for (int i = 0; i < NX; ++i) {
                double sum = 0;
                for (int j = 0; j < s; ++j)
                    sum += A[s][j] * k[j][i];
                y[i] = x[i] + h * sum;
            }
            fine = rates_at(m, last && s == 6 ? until : time + C[s] * h, y, k[s]);
        }
        for (int i = 0; i < NX && fine; ++i) {
            error[i] = 0;
            for (int j = 0; j < 7; ++j)
                error[i] += h * E[j] * k[j][i];
        }
        const double off = fine ? measured(error, x, y, m->n.tolerance) : HUGE_VAL;
        if (off <= 1) {
            time = last ? until : time + h;
            memcpy(x, y, sizeof x);
            memcpy(x, m->q, sizeof m->q);
            memcpy(x + NQ, m->u, sizeof m->u);
            if (!memcmp(x, y, sizeof x))
                memcpy(k[0], k[6], sizeof x);
            else if (!rates_at(m, time, x, k[0]))
                break;
            const double wider = 0.9 * pow(fmax(off, 1e-10), -0.17) * pow(before, 0.04);
            before = fmax(off, 1e-4);
            if (!last || wider < 1)
                step = h * fmin(5, fmax(0.2, wider));
            m->n.step = step;
        } else {
            step = h * (fine ? fmax(0.2, 0.9 * pow(off, -0.2)) : 0.1);
            if (!(step > 1e-13 * fmax(1, fabs(time)))) {
                complain(m, "t = %.9g: no step is short enough for a tolerance of %.3g", time, m->n.tolerance);
                break;
            }
        }
    }
    m->n.time = m->reached = time;
    memcpy(m->n.x, x, sizeof x);
    stale(m);
    return time >= until;
}

/* Moves the model one step of the co-simulation on; returns whether all of it went. */
static int do_step(Model *m, double from, double step)
{
    if (!(step > 0) || !isfinite(step) || !isfinite(from)) {
        complain(m, "a step of %.9g s from t = %.9g s leads nowhere", step, from);
        return 0;
    }
    if (fabs(from - m->n.time) > 1e-9 * fmax(1, fabs(from)) + 1e-3 * step) {
        complain(m, "the step begins at t = %.17g s, and the model is at %.17g s", from, m->n.time);
        return 0;
    }
    settle(m);
    return advance(m, from + step);
}
