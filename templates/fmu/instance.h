/* What FMI 2 and FMI 3 have in common: values by reference, states that are kept, steps of a co-simulation. */

enum { INSTANTIATED = 1, INITIALIZING = 2, EVENTS = 4, CONTINUOUS = 8, STEPPING = 16, TERMINATED = 32 };

static const char *phase_name(int phase)
{
    switch (phase) {
    case INSTANTIATED: return "instantiated";
    case INITIALIZING: return "initialization mode";
    case EVENTS: return "event mode";
    case CONTINUOUS: return "continuous-time mode";
    case STEPPING: return "step mode";
    default: return "terminated";
    }
}

static int may(Model *m, const char *function, int phases)
{
    if (!m)
        return 0;
    if (m->n.phase & phases)
        return 1;
    complain(m, "%s may not be called here: the instance is %s", function, phase_name(m->n.phase));
    return 0;
}

static Model *instance(const char *name, const char *token, int moves, void (*logger)(void), void *environment,
                       void (*say)(Model *, const char *))
{
    Model *m = calloc(1, sizeof *m);

    if (!m)
        return 0;
    m->say = say;
    m->logger = logger;
    m->environment = environment;
    m->name = calloc(strlen(name ? name : "") + 1, 1);
    if (!m->name) {
        free(m);
        return 0;
    }
    strcpy(m->name, name ? name : "");
    if (!token || strcmp(token, TOKEN)) {
        complain(m, "the model description belongs to other code: its token is not %s", TOKEN);
        free(m->name);
        free(m);
        return 0;
    }
    restart(m);
    m->n.phase = INSTANTIATED;
    m->n.moves = moves;
    return m;
}

static void release(Model *m)
{
    if (m)
        free(m->name);
    free(m);
}

/* Values by reference */

static int get_value(Model *m, unsigned reference, double *value)
{
    const int v = (int)reference;

    if (v < 0 || v >= VARIABLES) {
        complain(m, "there is no variable of value reference %u", reference);
        return 0;
    }
    if (((v >= RATES && v < INPUTS) || (v >= OUTPUTS && v < PARAMETERS)) && !evaluate(m))
        return 0;
    *value = v < STATES ? m->n.time
           : v < RATES ? m->n.x[v - STATES]
           : v < INPUTS ? m->dx[v - RATES]
           : v < OUTPUTS ? m->n.in[v - INPUTS] + (m->n.time - m->n.since) * m->n.slope[v - INPUTS]
           : v < PARAMETERS ? m->y[v - OUTPUTS]
           : m->n.p[v - PARAMETERS];
    return 1;
}

/* Takes inputs to the time that it is, from where they may turn. */
static void settle(Model *m)
{
    for (int k = 0; k < NIN; ++k)
        m->n.in[k] += (m->n.time - m->n.since) * m->n.slope[k];
    m->n.since = m->n.time;
}

static int set_value(Model *m, unsigned reference, double value)
{
    const int v = (int)reference, before = m->n.phase & (INSTANTIATED | INITIALIZING);

    if (v < 0 || v >= VARIABLES) {
        complain(m, "there is no variable of value reference %u", reference);
        return 0;
    }
    if (v >= STATES && v < RATES && before) {
        m->n.x[v - STATES] = value;
    } else if (v >= INPUTS && v < OUTPUTS) {
        settle(m);
        m->n.in[v - INPUTS] = value;
        m->n.slope[v - INPUTS] = 0;
    } else if (v >= PARAMETERS && m->n.phase != CONTINUOUS) {
        m->n.p[v - PARAMETERS] = value;
        detuned(m);
    } else {
        complain(m, "%s may not be set here: the instance is %s", NAMES[v], phase_name(m->n.phase));
        return 0;
    }
    stale(m);
    return 1;
}

static int set_slope(Model *m, unsigned reference, int order, double value)
{
    const int v = (int)reference;

    if (v < INPUTS || v >= OUTPUTS || order != 1) {
        complain(m, "value reference %u: rates, order 1, are taken of inputs alone", reference);
        return 0;
    }
    settle(m);
    m->n.slope[v - INPUTS] = value;
    stale(m);
    return 1;
}

/* Returns whether parameters have values and the loops close at the start, which is brought there. */
static int begin(Model *m)
{
    for (int k = 0; k < NP; ++k)
        if (!isfinite(m->n.p[k])) {
            complain(m, "the parameter %s has no finite value", NAMES[PARAMETERS + k]);
            return 0;
        }
    if (!evaluate(m))
        return 0;
    memcpy(m->n.x, m->q, sizeof m->q);
    memcpy(m->n.x + NQ, m->u, sizeof m->u);
    stale(m);
    m->n.since = m->n.time;
    m->reached = m->n.time;
    return 1;
}

/* Derivatives along directions */

static int along(Model *m, const unsigned *unknowns, size_t nu, const unsigned *knowns, size_t nk, const double *seed,
                 double *found)
{
#ifdef DIFFERENTIATED
    double dx[NX] = {0}, din[NIN + 1] = {0}, ddx[NX], dy[NY + 1];

    for (size_t i = 0; i < nk; ++i) {
        const int v = (int)knowns[i];
        if (v >= STATES && v < RATES)
            dx[v - STATES] += seed[i];
        else if (v >= INPUTS && v < OUTPUTS)
            din[v - INPUTS] += seed[i];
        else {
            complain(m, "value reference %u: there are derivatives by states and inputs alone", knowns[i]);
            return 0;
        }
    }
    if (!directional(m, dx, din, ddx, dy))
        return 0;
    for (size_t i = 0; i < nu; ++i) {
        const int v = (int)unknowns[i];
        if (v >= STATES && v < RATES)
            found[i] = dx[v - STATES];
        else if (v >= RATES && v < INPUTS)
            found[i] = ddx[v - RATES];
        else if (v >= OUTPUTS && v < PARAMETERS)
            found[i] = dy[v - OUTPUTS];
        else {
            complain(m, "value reference %u: there are derivatives of rates and outputs alone", unknowns[i]);
            return 0;
        }
    }
    return 1;
#else
    (void)unknowns, (void)nu, (void)knowns, (void)nk, (void)seed, (void)found;
    complain(m, "where loops or rows close a mechanism there are no directional derivatives");
    return 0;
#endif
}

/* Kept states */

typedef struct {
    char token[sizeof TOKEN];
    Numbers n;
} Kept;

static int keep(Model *m, void **state)
{
    Kept *kept = *state ? *state : calloc(1, sizeof *kept);

    if (!kept) {
        complain(m, "there is no memory for a state");
        return 0;
    }
    memcpy(kept->token, TOKEN, sizeof TOKEN);
    memcpy(&kept->n, &m->n, sizeof m->n);
    *state = kept;
    return 1;
}

static int restore(Model *m, const void *state)
{
    const Kept *kept = state;

    if (!kept || memcmp(kept->token, TOKEN, sizeof TOKEN)) {
        complain(m, "this is no state of this model");
        return 0;
    }
    memcpy(&m->n, &kept->n, sizeof m->n);
    detuned(m);
    return 1;
}
