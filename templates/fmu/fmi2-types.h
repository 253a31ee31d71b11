/* The types of FMI 2.0 (www.fmi-standard.org), as far as this FMU has them. */
#ifdef FMI_HEADERS /* a folder of include paths has the standard's own headers: they judge what is declared here */
#include "fmi2Functions.h"
#define SYMDYN_FULL(name) name
#define SYMDYN_EXPORT FMI2_Export
#else
#include <stddef.h>

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String name, fmi2Status, fmi2String category,
                                   fmi2String message, ...);
typedef struct {
    fmi2CallbackLogger logger;
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged;
    fmi2Boolean valuesOfContinuousStatesChanged, nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;
enum { fmi2False, fmi2True };

/* With -DFMI2_FUNCTION_PREFIX=pendulum_ the functions have names of their own, for programs that hold several models. */
#ifdef FMI2_FUNCTION_PREFIX
#define SYMDYN_PASTED(a, b) a##b
#define SYMDYN_PASTE(a, b) SYMDYN_PASTED(a, b)
#define SYMDYN_FULL(name) SYMDYN_PASTE(FMI2_FUNCTION_PREFIX, name)
#else
#define SYMDYN_FULL(name) name
#endif
#if defined(_WIN32) && !defined(FMI2_FUNCTION_PREFIX)
#define SYMDYN_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define SYMDYN_EXPORT __attribute__((__visibility__("default")))
#else
#define SYMDYN_EXPORT
#endif
#endif
