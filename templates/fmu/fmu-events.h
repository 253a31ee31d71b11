/* Jumps of states, where what the mechanism says passes zero.

Of each such formula the sign that it had last is kept, 0 where it has been zero since the start or a jump. An indicator is
the formula, moved a little to that side: where a tool finds it zero, the formula itself has passed zero. A co-simulation
looks at sixteen places of two steps, and takes steps to where a formula has just passed zero. What jumps at one time sees
what was there before; what jumps pass jumps behind. */

static double sign(double x) { return (x > 0) - (x < 0); }

static double passing(const Model *m, int k) { return m->jumps[k * (1 + NS)]; }

/* Takes signs where there was none: at the start, and at ends of steps. */
static int arm(Model *m)
{
    if (!guards(m))
        return 0;
    for (int k = 0; k < NJ; ++k) {
        if (m->n.side[k] == 0)
            m->n.side[k] = sign(passing(m, k));
        m->n.size[k] = fmax(m->n.size[k], fabs(passing(m, k)));
    }
    return 1;
}

static int passed(const Model *m, int k) { return sign(passing(m, k)) * m->n.side[k] < 0; }

static int any_passed(Model *m, int *some)
{
    *some = 0;
    if (!guards(m))
        return 0;
    for (int k = 0; k < NJ; ++k)
        *some |= passed(m, k);
    return 1;
}

/* Lets states jump for what has passed zero; returns whether that ends, and tells whether one has jumped. */
static int jump(Model *m, int *moved)
{
    double *s = m->n.x + NQ + NU;
    int before[NJ] = {0}, some = 1;

    *moved = 0;
    for (int round = 0; some && round < 100; ++round) {
        double old[NS];
        if (!guards(m))
            return 0;
        memcpy(old, s, sizeof old);
        some = 0;
        for (int k = 0; k < NJ; ++k) {
            const double *behind = m->jumps + k * (1 + NS) + 1;
            if (before[k] || !passed(m, k))
                continue;
            before[k] = 1;
            if (WAYS[k] != 0 && WAYS[k] != sign(passing(m, k)))
                continue;
            some = *moved = 1;
            for (int i = 0; i < NS; ++i)
                if (behind[i] != old[i])
                    s[i] = behind[i];
        }
        stale(m);
    }
    if (some) {
        complain(m, "jumps follow each other without end at t = %.9g", m->n.time);
        return 0;
    }
    for (int k = 0; k < NJ; ++k)
        if (before[k])
            m->n.side[k] = fabs(passing(m, k)) <= 4e-16 * m->n.size[k] ? 0 : sign(passing(m, k));
    return arm(m);
}

static double indicator(const Model *m, int k) { return passing(m, k) + 1e-10 * m->n.side[k] * m->n.size[k]; }

static int indicated(Model *m, double *found)
{
    if (!guards(m))
        return 0;
    for (int k = 0; k < NJ; ++k)
        found[k] = indicator(m, k);
    return 1;
}

/* Gets a value; indicators are behind all other variables. */
static int told(Model *m, unsigned reference, double *value)
{
    const unsigned first = 1 + 2 * NX + NIN + NY + NP;

    if (reference < first || reference >= first + NJ)
        return get_value(m, reference, value);
    if (!guards(m))
        return 0;
    *value = indicator(m, (int)(reference - first));
    return 1;
}

/* Moves the model to where it is a time after a start; tells whether something has passed zero there. */
static int moved_on(Model *m, const Numbers *start, double step, int *some)
{
    m->n = *start;
    stale(m);
    return do_step(m, start->time, step) && any_passed(m, some);
}

/* Returns after what part of a step something has passed zero by a cubic through its ends, 1 where nothing has. */
static double looked(Model *m, const Numbers *start, int *fine)
{
    enum { LOOKS = 16 };
    const Numbers end = m->n;
    const double h = end.time - start->time;
    double before[NX], behind[NX], part = 1;
    int some;

    *fine = evaluate(m);
    memcpy(behind, m->dx, sizeof behind);
    m->n = *start;
    stale(m);
    *fine = *fine && evaluate(m);
    memcpy(before, m->dx, sizeof before);
    for (int j = 1; j < LOOKS && *fine && part == 1; ++j) {
        const double a = (double)j / LOOKS, b = 1 - a;
        m->n.time = start->time + a * h;
        for (int i = 0; i < NX; ++i)
            m->n.x[i] = b * b * ((1 + 2 * a) * start->x[i] + a * h * before[i])
                        + a * a * ((1 + 2 * b) * end.x[i] - b * h * behind[i]);
        stale(m);
        *fine = any_passed(m, &some);
        if (some)
            part = a;
    }
    m->n = end;
    stale(m);
    return part;
}

/* Moves the model one step of the co-simulation on, through jumps; returns whether all of it went. */
static int through_jumps(Model *m, double from, double step)
{
    const double until = from + step, close = 1e-15 * fmax(1, fabs(until));
    double last = -HUGE_VAL;
    int some, fine, moved, often = 0;

    if (!(step > 0) || !isfinite(step) || !isfinite(from))
        return do_step(m, from, step); /* which says what is wrong */
    if (!jump(m, &moved))
        return 0;
    for (int first = 1; first || until - m->n.time > close; first = 0) {
        if (!evaluate(m))
            return 0;
        if (!(m->n.step > 0))
            m->n.step = first_step(m, m->dx);
        const Numbers start = m->n;
        const double begin = first ? from : start.time, h = fmin(until - begin, 2 * m->n.step);
        if (!do_step(m, begin, h))
            return 0;
        const double part = looked(m, &start, &fine);
        if (!fine || !any_passed(m, &some))
            return 0;
        double low = 0, high = m->n.time - start.time;
        if (part < 1) {
            high *= part;
            if (!moved_on(m, &start, high, &some))
                return 0;
        }
        if (!some) { /* the cubic has missed it, too */
            if (!arm(m))
                return 0;
            continue;
        }
        while (high - low > 4e-16 * fmax(fabs(start.time), high)) {
            const double middle = low + (high - low) / 2;
            if (middle <= low || middle >= high)
                break;
            if (!moved_on(m, &start, middle, &some))
                return 0;
            if (some)
                high = middle;
            else
                low = middle;
        }
        if (!moved_on(m, &start, high, &some) || !jump(m, &moved))
            return 0;
        if (moved)
            m->n.step = 0;
        often = m->n.time - last <= 1e-11 * fmax(1, fabs(last)) ? often + 1 : 0;
        last = m->n.time;
        if (often > 10) {
            complain(m, "jumps come closer and closer at t = %.9g", last);
            return 0;
        }
    }
    m->n.time = m->reached = until;
    stale(m);
    return 1;
}
