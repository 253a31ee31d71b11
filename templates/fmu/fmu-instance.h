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
    if (!token || strcmp(token, SYMDYN_TOKEN)) {
        complain(m, "the model description belongs to other code: its token is not %s", SYMDYN_TOKEN);
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

/* Returns of which kind a variable is, KINDS for none, and its place among those. */
static int kind_of(unsigned reference, int *place)
{
    int kind = TIME, rest = reference < 1u << 30 ? (int)reference : 1 << 30;

    while (kind < KINDS && rest >= COUNTS[kind])
        rest -= COUNTS[kind++];
    *place = rest;
    return kind;
}

static int get_value(Model *m, unsigned reference, double *value)
{
    int k;
    const int kind = kind_of(reference, &k);

    if ((kind == RATE || kind == OUTPUT) && !evaluate(m))
        return 0;
    switch (kind) {
    case TIME: *value = m->n.time; return 1;
    case STATE: *value = m->n.x[k]; return 1;
    case RATE: *value = m->dx[k]; return 1;
    case INPUT: *value = m->n.in[k] + (m->n.time - m->n.since) * m->n.slope[k]; return 1;
    case OUTPUT: *value = m->y[k]; return 1;
    case PARAMETER: *value = m->n.p[k]; return 1;
    default: complain(m, "there is no variable of value reference %u", reference); return 0;
    }
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
    int k;
    const int kind = kind_of(reference, &k);

    if (kind == STATE && m->n.phase & (INSTANTIATED | INITIALIZING)) {
        m->n.x[k] = value;
    } else if (kind == INPUT) {
        settle(m);
        m->n.in[k] = value;
        m->n.slope[k] = 0;
    } else if (kind == PARAMETER && m->n.phase != CONTINUOUS) {
        m->n.p[k] = value;
        detuned(m);
    } else {
        complain(m, "%s may not be set here: the instance is %s", kind < KINDS ? NAMES[reference] : "what is not there",
                 phase_name(m->n.phase));
        return 0;
    }
    stale(m);
    return 1;
}

/* Returns whether parameters have values and the loops close at the start, which is brought there. */
static int begin(Model *m)
{
    for (int k = 0; k < NP; ++k)
        if (!isfinite(m->n.p[k])) {
            complain(m, "the parameter %s has no finite value", NAMES[1 + 2 * NX + NIN + NY + k]);
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
#ifdef SYMDYN_DIFFERENTIATED
    double dx[NX] = {0}, din[NIN + 1] = {0}, ddx[NX], dy[NY + 1] = {0};

    for (size_t i = 0; i < nk; ++i) {
        int k;
        const int kind = kind_of(knowns[i], &k);
        if (kind == STATE)
            dx[k] += seed[i];
        else if (kind == INPUT)
            din[k] += seed[i];
        else {
            complain(m, "value reference %u: there are derivatives by states and inputs alone", knowns[i]);
            return 0;
        }
    }
    if (!directional(m, dx, din, ddx, dy))
        return 0;
    for (size_t i = 0; i < nu; ++i) {
        int k;
        const int kind = kind_of(unknowns[i], &k);
        if (kind == STATE)
            found[i] = dx[k];
        else if (kind == RATE)
            found[i] = ddx[k];
        else if (kind == OUTPUT)
            found[i] = dy[k];
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
    char token[sizeof SYMDYN_TOKEN];
    Numbers n;
} Kept;

static int keep(Model *m, void **state)
{
    Kept *kept = *state ? *state : calloc(1, sizeof *kept);

    if (!kept) {
        complain(m, "there is no memory for a state");
        return 0;
    }
    memcpy(kept->token, SYMDYN_TOKEN, sizeof SYMDYN_TOKEN);
    memcpy(&kept->n, &m->n, sizeof m->n);
    *state = kept;
    return 1;
}

static int restore(Model *m, const void *state)
{
    const Kept *kept = state;

    if (!kept || memcmp(kept->token, SYMDYN_TOKEN, sizeof SYMDYN_TOKEN)) {
        complain(m, "this is no state of this model");
        return 0;
    }
    memcpy(&m->n, &kept->n, sizeof m->n);
    detuned(m);
    return 1;
}
