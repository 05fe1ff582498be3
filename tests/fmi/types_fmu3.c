/* An FMU of FMI 3.0 with a variable of every type, arrays and a file of resources: what a runner must pass on unchanged. Outputs are
   the inputs or parameters of the same type, arrays times the time. Everything else answers as the standard says, and `mode`
   makes steps misbehave. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { ROWS = 2, COLUMNS = 3, COUNT = 6 };
enum Mode { WELL, WARNING, DISCARD, ENDING, FAILING, FATAL, UNKNOWN, EARLY };
enum Reference { TIME, F32, F64, I8, U8, I16, U16, I32, U32, I64, U64, FLAG, TEXT, GEAR, MATRIX, FLAGS, TEXTS, MODE, Y, FROM_FILE, SUM, BYTES, LENGTH };

typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    double time_s, f64, matrix[COUNT], from_file, last_tolerance;
    float f32;
    int8_t i8;
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32, mode;
    uint32_t u32;
    int64_t i64, gear;
    uint64_t u64;
    bool flag, flags[2], started, lost;
    char text[64], texts[2][64];
    int matrix_calls;
} Types;

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    (void)name, (void)visible, (void)required, (void)n, (void)update;
    if (strcmp(token, "{types}") != 0 || events || early) {
        log(environment, fmi3Error, "logStatusError", "the token is another one");
        return NULL;
    }
    Types *types = calloc(1, sizeof *types);
    types->environment = environment, types->log = log;
    /* as some FMUs do: the path ends in a separator */
    char path[4096];
    snprintf(path, sizeof path, "%snumbers/value.txt", resources);
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "%lf", &types->from_file) != 1) types->from_file = -1.0;
    if (file) fclose(file);
    if (logging) log(environment, fmi3OK, "logAll", "made");
    return types;
}

void fmi3FreeInstance(fmi3Instance instance) {
    if (((Types *)instance)->lost) {
        fprintf(stderr, "freed after fmi3Fatal\n");
        abort();
    }
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean defined, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stops, fmi3Float64 stop) {
    (void)defined, (void)tolerance, (void)stops, (void)stop;
    ((Types *)instance)->time_s = start;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    ((Types *)instance)->started = true;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    (void)instance;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    (void)keep;
    Types *types = instance;
    *event = *end = *early = false;
    *last = types->time_s = time + step;
    int mode = time + step > 0.25 ? types->mode : WELL;
    switch (mode) {
        case WARNING: return fmi3Warning;
        case DISCARD: return fmi3Discard;
        case ENDING:
            *end = true;
            *last = types->time_s = 0.25;
            return fmi3OK;
        case FAILING:
            types->log(types->environment, fmi3Error, "logStatusError", "it fails");
            return fmi3Error;
        case FATAL: types->lost = true; return fmi3Fatal;
        case UNKNOWN: types->lost = true; return 77;
        case EARLY:
            *early = true;
            *last = time + step / 2;
            return fmi3OK;
        default: return fmi3OK;
    }
}

#define SCALAR(Name, type, REFERENCE, field)                                                                            \
    fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, type values[], size_t m) { \
        for (size_t i = 0; i < n; i++) {                                                                                \
            if (n != m || vr[i] != REFERENCE) return fmi3Error;                                                         \
            values[i] = ((Types *)instance)->field;                                                                     \
        }                                                                                                               \
        return fmi3OK;                                                                                                  \
    }                                                                                                                   \
    fmi3Status fmi3Set##Name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const type values[],       \
                             size_t m) {                                                                                \
        for (size_t i = 0; i < n; i++) {                                                                                \
            if (n != m || vr[i] != REFERENCE) return fmi3Error;                                                         \
            ((Types *)instance)->field = values[i];                                                                     \
        }                                                                                                               \
        return fmi3OK;                                                                                                  \
    }

SCALAR(Float32, fmi3Float32, F32, f32)
SCALAR(Int8, fmi3Int8, I8, i8)
SCALAR(UInt8, fmi3UInt8, U8, u8)
SCALAR(Int16, fmi3Int16, I16, i16)
SCALAR(UInt16, fmi3UInt16, U16, u16)
SCALAR(UInt32, fmi3UInt32, U32, u32)
SCALAR(UInt64, fmi3UInt64, U64, u64)

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t m) {
    Types *types = instance;
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        size_t length = vr[i] == MATRIX || vr[i] == Y ? COUNT : 1;
        if (at + length > m) return fmi3Error;
        for (size_t k = 0; k < length; k++, at++) {
            switch (vr[i]) {
                case TIME: values[at] = types->time_s; break;
                case F64: values[at] = types->f64; break;
                case MATRIX: values[at] = types->matrix[k]; break;
                case Y: values[at] = types->time_s * types->matrix[k]; break;
                case FROM_FILE: values[at] = types->from_file; break;
                case SUM: values[at] = types->matrix_calls; break;
                default: return fmi3Error;
            }
        }
    }
    return at == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t m) {
    Types *types = instance;
    if (n == 1 && m == 1 && vr[0] == F64) {
        if (values[0] > 500.0) return fmi3Discard;
        types->f64 = values[0];
        return fmi3OK;
    }
    if (n != 1 || vr[0] != MATRIX || m != COUNT) return fmi3Error;
    memcpy(types->matrix, values, sizeof types->matrix);
    types->matrix_calls++;
    return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[], size_t m) {
    Types *types = instance;
    for (size_t i = 0; i < n; i++) values[i] = vr[i] == MODE ? types->mode : types->i32;
    return n == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[], size_t m) {
    Types *types = instance;
    for (size_t i = 0; i < n; i++) *(vr[i] == MODE ? &types->mode : &types->i32) = values[i];
    return n == m ? fmi3OK : fmi3Error;
}

/* an enumeration is an Int64 */
fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Int64 values[], size_t m) {
    Types *types = instance;
    for (size_t i = 0; i < n; i++) values[i] = vr[i] == GEAR ? types->gear : types->i64;
    return n == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Int64 values[], size_t m) {
    Types *types = instance;
    for (size_t i = 0; i < n; i++) *(vr[i] == GEAR ? &types->gear : &types->i64) = values[i];
    return n == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t m) {
    Types *types = instance;
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == FLAG) values[at++] = types->flag;
        else for (size_t k = 0; k < 2; k++) values[at++] = types->flags[k];
    }
    return at == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[],
                          size_t m) {
    Types *types = instance;
    if (n == 1 && vr[0] == FLAG && m == 1) types->flag = values[0];
    else if (n == 1 && vr[0] == FLAGS && m == 2) memcpy(types->flags, values, sizeof types->flags);
    else return fmi3Error;
    return fmi3OK;
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3String values[], size_t m) {
    Types *types = instance;
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] == TEXT) values[at++] = types->text;
        else for (size_t k = 0; k < 2; k++) values[at++] = types->texts[k];
    }
    return at == m ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3String values[],
                         size_t m) {
    Types *types = instance;
    if (n == 1 && vr[0] == TEXT && m == 1) snprintf(types->text, sizeof types->text, "%s", values[0]);
    else if (n == 1 && vr[0] == TEXTS && m == 2)
        for (size_t k = 0; k < 2; k++) snprintf(types->texts[k], sizeof types->texts[k], "%s", values[k]);
    else return fmi3Error;
    return fmi3OK;
}
