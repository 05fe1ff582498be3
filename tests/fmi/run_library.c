/* A small importer: loads the library of an FMU, runs it, prints the values of Real variables bit for bit.
 *
 *     run_library LIBRARY RESOURCE_URI GUID STEP_S STEPS < VALUE_REFERENCES
 *
 * One line on standard output after initialisation and after each step: the values as 16 hexadecimal digits. On
 * standard error one line with the milliseconds that starting took, from fmi2Instantiate to the end of
 * fmi2ExitInitializationMode. Knows nothing of the project; test_platforms.py builds it for Windows. */

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
static double now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
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

static void *function(void *library, const char *name) {
    void *found = find(library, name);
    check(found != NULL, name);
    return found;
}

int main(int argc, char **argv) {
    static unsigned references[MOST];
    static double values[MOST];
    size_t count = 0;
    check(argc == 6, "reading five arguments");
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
    void *fmu = instantiate("driver", 1, argv[3], argv[2], &callbacks, 0, 0);
    check(fmu != NULL, "fmi2Instantiate");
    check(setup(fmu, 0, 0.0, 0.0, 0, 0.0) == 0, "fmi2SetupExperiment");
    check(enter(fmu) == 0 && leave(fmu) == 0, "initialising");
    fprintf(stderr, "started in %.3f ms\n", now_ms() - begin_ms);

    double time_s = 0.0;
    for (int i = 0; i <= steps; i++) {
        if (i > 0) {
            check(step(fmu, time_s, step_s, 1) == 0, "fmi2DoStep");
            time_s += step_s;
        }
        check(get(fmu, references, count, values) == 0, "fmi2GetReal");
        for (size_t k = 0; k < count; k++) {
            uint64_t bits;
            memcpy(&bits, &values[k], sizeof bits);
            printf("%016" PRIx64 "%c", bits, k + 1 < count ? ' ' : '\n');
        }
    }
    release(fmu);
    return 0;
}
