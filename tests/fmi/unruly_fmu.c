/* An FMU whose steps answer with each status of the standard, and with one that is none: what a runner must bear. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum Mode { WELL, WARNING, DISCARD, ENDING, FAILING, FATAL, PENDING, UNKNOWN, PICKY };

enum Reference { MODE, Y, U, GEAR, LABEL };

static const double TROUBLE_FROM_S = 0.2;
static const double ENDS_AT_S = 0.25;

typedef struct {
    fmi2CallbackFunctions callbacks;
    char name[64];
    int mode, gear, lost;
    double time_s, u;
    char label[64];
} Unruly;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type, (void)resources, (void)visible;
    if (strcmp(guid, "{unruly}") != 0) {
        callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError",
                          "the GUID is %s, %d%% expected %s", guid, 100, "{unruly}");
        return NULL;
    }
    Unruly *unruly = calloc(1, sizeof *unruly);
    unruly->callbacks = *callbacks;
    snprintf(unruly->name, sizeof unruly->name, "%s", name);
    snprintf(unruly->label, sizeof unruly->label, "none");
    unruly->gear = 1;
    if (logging) callbacks->logger(callbacks->componentEnvironment, name, fmi2OK, "logAll", "made\n");
    return unruly;
}

void fmi2FreeInstance(fmi2Component component) {
    if (((Unruly *)component)->lost) {
        fprintf(stderr, "freed after fmi2Fatal\n");
        abort();
    }
    free(component);
}

static fmi2Status ok(void) { return fmi2OK; }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real start, fmi2Boolean e,
                               fmi2Real stop) {
    (void)d, (void)tolerance, (void)e, (void)stop;
    ((Unruly *)c)->time_s = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, ok(); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, ok(); }

fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, ok(); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
    Unruly *unruly = c;
    for (size_t i = 0; i < n; i++) value[i] = r[i] == U ? unruly->u : unruly->time_s;
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer value[]) {
    Unruly *unruly = c;
    for (size_t i = 0; i < n; i++) value[i] = r[i] == GEAR ? unruly->gear : unruly->mode;
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean value[]) {
    return (void)c, (void)r, (void)n, (void)value, ok();
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String value[]) {
    (void)r;
    for (size_t i = 0; i < n; i++) value[i] = ((Unruly *)c)->label;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
    Unruly *unruly = c;
    (void)r, (void)n;
    if (unruly->mode == PICKY) return fmi2Discard;
    unruly->u = value[0];
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer value[]) {
    Unruly *unruly = c;
    for (size_t i = 0; i < n; i++) *(r[i] == GEAR ? &unruly->gear : &unruly->mode) = value[i];
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean value[]) {
    return (void)c, (void)r, (void)n, (void)value, ok();
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String value[]) {
    Unruly *unruly = c;
    (void)r, (void)n;
    snprintf(unruly->label, sizeof unruly->label, "%s", value[0]);
    return fmi2OK;
}

#ifndef WITHOUT_DO_STEP
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time_s, fmi2Real step_s, fmi2Boolean no_set_state) {
    Unruly *unruly = c;
    const fmi2CallbackFunctions *callbacks = &unruly->callbacks;
    (void)no_set_state;
    if (time_s < TROUBLE_FROM_S - 1e-9) {
        unruly->time_s = time_s + step_s;
        return fmi2OK;
    }
    switch (unruly->mode) {
    case WARNING:
        callbacks->logger(callbacks->componentEnvironment, unruly->name, fmi2Warning, "logStatusWarning",
                          "%s is %.1f s, %d%%", "it", time_s, 50);
        unruly->time_s = time_s + step_s;
        return fmi2Warning;
    case DISCARD:
    case ENDING:
        if (unruly->mode == ENDING) unruly->time_s = ENDS_AT_S;
        return fmi2Discard;
    case FAILING:
        callbacks->logger(callbacks->componentEnvironment, unruly->name, fmi2Error, "logStatusError", "gave up");
        return fmi2Error;
    case FATAL:
        unruly->lost = 1;
        return fmi2Fatal;
    case PENDING:
        unruly->lost = 1;
        return fmi2Pending;
    case UNKNOWN:
        unruly->lost = 1;
        return (fmi2Status)99;
    default:
        unruly->time_s = time_s + step_s;
        return fmi2OK;
    }
}
#endif

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    (void)kind;
    *value = ((Unruly *)c)->time_s;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)kind;
    *value = ((Unruly *)c)->mode == ENDING;
    return fmi2OK;
}
