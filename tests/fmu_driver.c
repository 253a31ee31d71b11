/* Goes through the life of two instances of an FMU of FMI 2 at once; prints numbers that a test looks at. */
#include "fmi2-functions.c"

static void log_it(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    va_list rest;

    (void)environment;
    printf("%s %d %s ", name, (int)status, category);
    va_start(rest, text);
    vprintf(text, rest);
    va_end(rest);
    printf("\n");
}

static fmi2Component made(const char *name, fmi2Type type)
{
    fmi2CallbackFunctions functions = {log_it, 0, 0, 0, 0};

    return fmi2Instantiate(name, type, SYMDYN_TOKEN, "", &functions, fmi2False, fmi2False);
}

static void begun(fmi2Component c)
{
    fmi2SetupExperiment(c, fmi2True, 1e-10, 0, fmi2False, 0);
    fmi2EnterInitializationMode(c);
    if (fmi2ExitInitializationMode(c) != fmi2OK)
        printf("no start\n");
}

static double ran(fmi2Component c, double from, double to)
{
    const unsigned state = 1;
    double value = 0;

    for (int k = 0; k < 10; ++k)
        if (fmi2DoStep(c, from + k * (to - from) / 10, (to - from) / 10, fmi2True) != fmi2OK)
            printf("no step\n");
    fmi2GetReal(c, &state, 1, &value);
    return value;
}

int main(void)
{
    const unsigned first = 1, rate = 1 + NX, parameter = 1 + 2 * NX + NIN + NY, nothing = 9999;
    const double half = 0.5, heavy = 2, one = 1;
    fmi2Component a = made("a", fmi2CoSimulation), b = made("b", fmi2CoSimulation);
    fmi2FMUstate kept = 0, read = 0;
    fmi2Byte bytes[sizeof(Kept)];
    fmi2CallbackFunctions functions = {log_it, 0, 0, 0, 0};
    double value, again;
    size_t size;

    fmi2SetReal(a, &first, 1, &half);
    fmi2SetReal(b, &first, 1, &half);
    fmi2SetReal(b, &parameter, 1, &heavy);
    begun(a);
    begun(b);
    value = ran(a, 0, 1);
    printf("apart %d\n", value != ran(b, 0, 1));

    fmi2GetFMUstate(a, &kept);
    fmi2SerializedFMUstateSize(a, kept, &size);
    fmi2SerializeFMUstate(a, kept, bytes, size);
    value = ran(a, 1, 2);
    fmi2SetFMUstate(a, kept);
    again = ran(a, 1, 2);
    printf("restored %d\n", value == again);
    fmi2DeSerializeFMUstate(b, bytes, size, &read);
    fmi2SetFMUstate(b, read);
    printf("read %d\n", value == ran(b, 1, 2));
    fmi2FreeFMUstate(a, &kept);
    fmi2FreeFMUstate(b, &read);
    printf("freed %d\n", !kept && !read);

    printf("refused %d\n", fmi2GetReal(a, &nothing, 1, &value) != fmi2OK);
    printf("refused %d\n", fmi2SetReal(a, &first, 1, &half) == fmi2Error);
    printf("refused %d\n", fmi2EnterEventMode(a) == fmi2Error);
    printf("refused %d\n", fmi2DoStep(a, 2, -1, fmi2True) != fmi2OK);
    printf("refused %d\n", fmi2Instantiate("c", fmi2ModelExchange, "other", "", &functions, 0, 0) == 0);
    fmi2GetDirectionalDerivative(a, &rate, 1, &first, 1, &one, &value);
    fmi2Terminate(a);
    fmi2Reset(a);
    fmi2SetReal(a, &first, 1, &half);
    begun(a);
    fmi2Reset(b);
    fmi2SetReal(b, &first, 1, &half);
    begun(b);
    printf("fresh %d\n", ran(a, 0, 1) == ran(b, 0, 1));
    fmi2FreeInstance(a);
    fmi2FreeInstance(b);
    return 0;
}
