/* A small importer: loads the library of an FMU, runs it, prints the values of Real variables bit for bit.
 *
 *     run_library LIBRARY RESOURCE_URI GUID STEP_S STEPS [again | rates] < VALUE_REFERENCES
 *
 * One line on standard output after initialisation and after each step: the values as 16 hexadecimal digits. On
 * standard error one line with the milliseconds that starting took, from fmi2Instantiate to the end of
 * fmi2ExitInitializationMode. Knows nothing of the project; test_platforms.py builds it for Windows, test_cross_built.py
 * for other platforms.
 *
 * With `again`, the state after half of the steps is saved as bytes; after the last step it is restored from them and the
 * second half repeated, with its lines. With `rates`, the FMU is used in Model Exchange, the value references are those of
 * the states' derivatives, and each line after the first has the derivatives at other states, within 1e-3 of the start. */

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static double now_ms(void) {
    LARGE_INTEGER ticks, rate;
    QueryPerformanceCounter(&ticks);
    QueryPerformanceFrequency(&rate);
    return 1e3 * (double)ticks.QuadPart / (double)rate.QuadPart;
}
#else
#include <dlfcn.h>
#include <time.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
/* processor time, which the load of the computer changes little */
static double now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}
#endif

enum { MOST = 4096 };

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void logger(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s: %s (%d): ", name, category, status);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void check(int ok, const char *what) {
    if (!ok) {
        fprintf(stderr, "run_library: %s failed\n", what);
        exit(1);
    }
}

static void print(const double *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        printf("%016" PRIx64 "%c", bits, k + 1 < count ? ' ' : '\n');
    }
}

static void *function(void *library, const char *name) {
    void *found = find(library, name);
    check(found != NULL, name);
    return found;
}

/* A state as bytes, which another instance could restore. */
typedef struct {
    char *bytes;
    size_t size;
} Saved;

static void save(void *library, void *fmu, Saved *saved) {
    int (*get)(void *, void **) = function(library, "fmi2GetFMUstate");
    int (*size)(void *, void *, size_t *) = function(library, "fmi2SerializedFMUstateSize");
    int (*serialize)(void *, void *, char *, size_t) = function(library, "fmi2SerializeFMUstate");
    int (*drop)(void *, void **) = function(library, "fmi2FreeFMUstate");
    void *state = NULL;
    check(get(fmu, &state) == 0, "fmi2GetFMUstate");
    check(size(fmu, state, &saved->size) == 0, "fmi2SerializedFMUstateSize");
    saved->bytes = malloc(saved->size);
    check(saved->bytes != NULL, "malloc");
    check(serialize(fmu, state, saved->bytes, saved->size) == 0, "fmi2SerializeFMUstate");
    check(drop(fmu, &state) == 0, "fmi2FreeFMUstate");
}

static void restore(void *library, void *fmu, Saved *saved) {
    int (*read)(void *, const char *, size_t, void **) = function(library, "fmi2DeSerializeFMUstate");
    int (*set)(void *, void *) = function(library, "fmi2SetFMUstate");
    int (*drop)(void *, void **) = function(library, "fmi2FreeFMUstate");
    void *state = NULL;
    check(read(fmu, saved->bytes, saved->size, &state) == 0, "fmi2DeSerializeFMUstate");
    check(set(fmu, state) == 0, "fmi2SetFMUstate");
    check(drop(fmu, &state) == 0, "fmi2FreeFMUstate");
    free(saved->bytes);
}

/* Derivatives at the start and at states beside it, whose deviations are exact multiples of powers of two. */
static void print_rates(void *library, void *fmu, size_t count, double step_s, int rows) {
    typedef struct {
        int discrete_states_needed, terminate, nominals_changed, values_changed, next_event_defined;
        double next_event_s;
    } Events;
    int (*discrete)(void *, Events *) = function(library, "fmi2NewDiscreteStates");
    int (*enter)(void *) = function(library, "fmi2EnterContinuousTimeMode");
    int (*set_time)(void *, double) = function(library, "fmi2SetTime");
    int (*get_states)(void *, double *, size_t) = function(library, "fmi2GetContinuousStates");
    int (*set_states)(void *, const double *, size_t) = function(library, "fmi2SetContinuousStates");
    int (*get_rates)(void *, double *, size_t) = function(library, "fmi2GetDerivatives");
    static double start[MOST], states[MOST], found[MOST];
    Events events = {1, 0, 0, 0, 0, 0.0};
    while (events.discrete_states_needed) check(discrete(fmu, &events) == 0, "fmi2NewDiscreteStates");
    check(enter(fmu) == 0, "fmi2EnterContinuousTimeMode");
    check(get_states(fmu, start, count) == 0, "fmi2GetContinuousStates");
    for (int i = 0; i <= rows; i++) {
        for (size_t k = 0; k < count; k++) /* -1023 to 1024 times 2^-20, different in each row and state */
            states[k] = start[k] + (i > 0) * ((double)((k * 7919 + (size_t)i * 104729) % 2048) - 1023.0) / 1048576.0;
        check(set_time(fmu, i * step_s) == 0, "fmi2SetTime");
        check(set_states(fmu, states, count) == 0, "fmi2SetContinuousStates");
        check(get_rates(fmu, found, count) == 0, "fmi2GetDerivatives");
        print(found, count);
    }
}

int main(int argc, char **argv) {
    static unsigned references[MOST];
    static double values[MOST];
    size_t count = 0;
    check(argc == 6 || argc == 7, "reading five or six arguments");
    const int again = argc == 7 && strcmp(argv[6], "again") == 0, rates = argc == 7 && strcmp(argv[6], "rates") == 0;
    check(argc == 6 || again || rates, argv[argc - 1]);
    while (count < MOST && scanf("%u", &references[count]) == 1) count++;

    void *library = load(argv[1]);
    check(library != NULL, argv[1]);
    void *(*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) =
        function(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = function(library, "fmi2SetupExperiment");
    int (*enter)(void *) = function(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = function(library, "fmi2ExitInitializationMode");
    int (*get)(void *, const unsigned *, size_t, double *) = function(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = function(library, "fmi2DoStep");
    void (*release)(void *) = function(library, "fmi2FreeInstance");

    const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    const double step_s = atof(argv[4]), begin_ms = now_ms();
    const int steps = atoi(argv[5]);
    void *fmu = instantiate("driver", rates ? 0 : 1, argv[3], argv[2], &callbacks, 0, 0);
    check(fmu != NULL, "fmi2Instantiate");
    check(setup(fmu, 0, 0.0, 0.0, 0, 0.0) == 0, "fmi2SetupExperiment");
    check(enter(fmu) == 0 && leave(fmu) == 0, "initialising");
    fprintf(stderr, "started in %.3f ms\n", now_ms() - begin_ms);

    if (rates) {
        print_rates(library, fmu, count, step_s, steps);
        release(fmu);
        return 0;
    }
    Saved saved = {NULL, 0};
    double time_s = 0.0, saved_s = 0.0;
    for (int i = 0, repeated = 0; i <= steps; i++) {
        if (i > 0) {
            check(step(fmu, time_s, step_s, 1) == 0, "fmi2DoStep");
            time_s += step_s;
        }
        check(get(fmu, references, count, values) == 0, "fmi2GetReal");
        print(values, count);
        if (again && i == steps / 2 && !repeated) {
            save(library, fmu, &saved);
            saved_s = time_s;
        }
        if (again && i == steps && !repeated) {
            restore(library, fmu, &saved);
            time_s = saved_s;
            i = steps / 2;
            repeated = 1;
        }
    }
    release(fmu);
    return 0;
}
