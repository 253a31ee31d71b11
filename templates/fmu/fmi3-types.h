/* The types of FMI 3.0 (www.fmi-standard.org), as far as this FMU has them. */
#ifdef FMI_HEADERS /* a folder of include paths has the standard's own headers: they judge what is declared here */
#include "fmi3Functions.h"
#define SYMDYN_FULL(name) name
#define SYMDYN_EXPORT FMI3_Export
#else
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean set_requested,
                                               fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return,
                                               fmi3Boolean *return_requested, fmi3Float64 *return_time);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

/* With -DFMI3_FUNCTION_PREFIX=pendulum_ the functions have names of their own, for programs that hold several models. */
#ifdef FMI3_FUNCTION_PREFIX
#define SYMDYN_PASTED(a, b) a##b
#define SYMDYN_PASTE(a, b) SYMDYN_PASTED(a, b)
#define SYMDYN_FULL(name) SYMDYN_PASTE(FMI3_FUNCTION_PREFIX, name)
#else
#define SYMDYN_FULL(name) name
#endif
#if defined(_WIN32)
#define SYMDYN_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define SYMDYN_EXPORT __attribute__((__visibility__("default")))
#else
#define SYMDYN_EXPORT
#endif
#endif
