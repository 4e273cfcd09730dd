/* Co-simulation FMU (FMI 2.0): transmission error and stiffness of a pair of flanks over the angle of
   body 1 and the torque, from a table.

   The table (table.c) repeats with its period in the angle, in both directions. Between its angles and
   torques rotation and stiffness are interpolated bilinearly. Beyond the smallest and the largest
   torque the rotation goes on with the tangent stiffness of that torque, which is constant there.

   Nothing but the C library is needed. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "table.h"

#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#define NAME(function) JOIN(FMI2_FUNCTION_PREFIX, function)
#else
#define NAME(function) function
#endif

#if defined(_WIN32)
#define EXPORT(type) __declspec(dllexport) type
#elif defined(__GNUC__)
#define EXPORT(type) __attribute__((visibility("default"))) type
#else
#define EXPORT(type) type
#endif

/* Types of the interface FMI 2.0. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef unsigned int Reference;
typedef int Flag;
typedef struct {
    void (*logger)(void *, const char *, Status, const char *, const char *, ...);
    void *(*allocate_memory)(size_t, size_t);
    void (*free_memory)(void *);
    void (*step_finished)(void *, Status);
    void *environment;
} Callbacks;

/* Value references. */
enum { ANGLE, TORQUE, ROTATION, ERROR_UM, STIFFNESS, OFFSET, PERIOD, RADIUS, N_REALS };

typedef struct {
    double angle, torque, offset;
} Instance;

/* Number of the interval of ascending places that contains x, and the part of it before x. */
static int interval(const double *places, int count, double x, double *part)
{
    int low = 0, high = count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (places[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    *part = count > 1 ? (x - places[low]) / (places[low + 1] - places[low]) : 0.0;
    return low;
}

/* Bilinear value of a table of angles (rows) and torques (columns). */
static double value(const double *table, int row, double along, int column, double up)
{
    int next = n_torques > 1 ? 1 : 0;
    const double *one = table + row * n_torques + column, *two = one + n_torques;
    double here = (1.0 - up) * one[0] + up * one[next], there = (1.0 - up) * two[0] + up * two[next];
    return (1.0 - along) * here + along * there;
}

static void solve(const Instance *self, double *rotation, double *stiffness)
{
    double angle = self->angle + self->offset - angles_rad[0], along, up, torque = self->torque;
    int row, column;
    angle -= period_rad * floor(angle / period_rad);
    angle += angles_rad[0];
    if (angle > angles_rad[n_angles - 1])
        angle = angles_rad[n_angles - 1];
    row = interval(angles_rad, n_angles, angle, &along);
    if (torque < torques_Nm[0])
        torque = torques_Nm[0];
    if (torque > torques_Nm[n_torques - 1])
        torque = torques_Nm[n_torques - 1];
    column = interval(torques_Nm, n_torques, torque, &up);
    *stiffness = value(table_stiffness_Nm_per_rad, row, along, column, up);
    *rotation = value(table_rotation_rad, row, along, column, up);
    *rotation += (self->torque - torque) / *stiffness;
}

EXPORT(const char *) NAME(fmi2GetTypesPlatform)(void) { return "default"; }
EXPORT(const char *) NAME(fmi2GetVersion)(void) { return "2.0"; }

EXPORT(Status) NAME(fmi2SetDebugLogging)(void *c, Flag on, size_t n, const char *const categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

static void set_start(Instance *self)
{
    self->angle = 0.0;
    self->torque = start_torque_Nm;
    self->offset = 0.0;
}

EXPORT(void *) NAME(fmi2Instantiate)(const char *name, int type, const char *guid, const char *resources,
                                     const Callbacks *callbacks, Flag visible, Flag logging)
{
    Instance *self;
    (void)resources, (void)visible, (void)logging;
    if (type != 1 || guid == NULL || strcmp(guid, table_guid) != 0) {
        if (callbacks != NULL && callbacks->logger != NULL)
            callbacks->logger(callbacks->environment, name, ERROR, "error",
                              "expected co-simulation and the guid of this FMU");
        return NULL;
    }
    self = malloc(sizeof *self);
    if (self != NULL)
        set_start(self);
    return self;
}

EXPORT(void) NAME(fmi2FreeInstance)(void *c) { free(c); }

EXPORT(Status) NAME(fmi2SetupExperiment)(void *c, Flag with_tolerance, double tolerance, double start,
                                         Flag with_stop, double stop)
{
    (void)c, (void)with_tolerance, (void)tolerance, (void)start, (void)with_stop, (void)stop;
    return OK;
}

EXPORT(Status) NAME(fmi2EnterInitializationMode)(void *c) { return c != NULL ? OK : ERROR; }
EXPORT(Status) NAME(fmi2ExitInitializationMode)(void *c) { return c != NULL ? OK : ERROR; }
EXPORT(Status) NAME(fmi2Terminate)(void *c) { return c != NULL ? OK : ERROR; }

EXPORT(Status) NAME(fmi2Reset)(void *c)
{
    set_start(c);
    return OK;
}

EXPORT(Status) NAME(fmi2GetReal)(void *c, const Reference references[], size_t n, double values[])
{
    const Instance *self = c;
    double rotation, stiffness;
    size_t k;
    solve(self, &rotation, &stiffness);
    for (k = 0; k < n; k++) {
        switch (references[k]) {
        case ANGLE: values[k] = self->angle; break;
        case TORQUE: values[k] = self->torque; break;
        case ROTATION: values[k] = rotation; break;
        case ERROR_UM: values[k] = 1000.0 * rotation * reference_radius_mm; break;
        case STIFFNESS: values[k] = stiffness; break;
        case OFFSET: values[k] = self->offset; break;
        case PERIOD: values[k] = period_rad; break;
        case RADIUS: values[k] = reference_radius_mm; break;
        default: return ERROR;
        }
    }
    return OK;
}

EXPORT(Status) NAME(fmi2SetReal)(void *c, const Reference references[], size_t n, const double values[])
{
    Instance *self = c;
    size_t k;
    for (k = 0; k < n; k++) {
        if (!isfinite(values[k]))
            return DISCARD;
        switch (references[k]) {
        case ANGLE: self->angle = values[k]; break;
        case TORQUE: self->torque = values[k]; break;
        case OFFSET: self->offset = values[k]; break;
        default: return ERROR;
        }
    }
    return OK;
}

EXPORT(Status) NAME(fmi2DoStep)(void *c, double time, double step, Flag no_earlier)
{
    (void)time, (void)no_earlier;
    return c != NULL && step >= 0.0 ? OK : ERROR;
}

EXPORT(Status) NAME(fmi2CancelStep)(void *c)
{
    (void)c;
    return ERROR;
}

/* There are no variables of other types, no states to keep and no derivatives. */
#define NO_VARIABLES(function, type)                                                              \
    EXPORT(Status) NAME(function)(void *c, const Reference references[], size_t n, type values[]) \
    {                                                                                             \
        (void)c, (void)references, (void)values;                                                  \
        return n == 0 ? OK : ERROR;                                                               \
    }

NO_VARIABLES(fmi2GetInteger, int)
NO_VARIABLES(fmi2SetInteger, const int)
NO_VARIABLES(fmi2GetBoolean, Flag)
NO_VARIABLES(fmi2SetBoolean, const Flag)
NO_VARIABLES(fmi2GetString, const char *)
NO_VARIABLES(fmi2SetString, const char *const)

EXPORT(Status) NAME(fmi2GetFMUstate)(void *c, void **state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT(Status) NAME(fmi2SetFMUstate)(void *c, void *state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT(Status) NAME(fmi2FreeFMUstate)(void *c, void **state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT(Status) NAME(fmi2SerializedFMUstateSize)(void *c, void *state, size_t *size)
{
    (void)c, (void)state, (void)size;
    return ERROR;
}

EXPORT(Status) NAME(fmi2SerializeFMUstate)(void *c, void *state, char bytes[], size_t size)
{
    (void)c, (void)state, (void)bytes, (void)size;
    return ERROR;
}

EXPORT(Status) NAME(fmi2DeSerializeFMUstate)(void *c, const char bytes[], size_t size, void **state)
{
    (void)c, (void)bytes, (void)size, (void)state;
    return ERROR;
}

EXPORT(Status) NAME(fmi2GetDirectionalDerivative)(void *c, const Reference unknown[], size_t n_unknown,
                                                  const Reference known[], size_t n_known,
                                                  const double seed[], double found[])
{
    (void)c, (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)found;
    return ERROR;
}

EXPORT(Status) NAME(fmi2SetRealInputDerivatives)(void *c, const Reference references[], size_t n,
                                                 const int order[], const double values[])
{
    (void)c, (void)references, (void)order, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT(Status) NAME(fmi2GetRealOutputDerivatives)(void *c, const Reference references[], size_t n,
                                                  const int order[], double values[])
{
    (void)c, (void)references, (void)order, (void)values;
    return n == 0 ? OK : ERROR;
}

#define NO_STATUS(function, type)                                   \
    EXPORT(Status) NAME(function)(void *c, int kind, type *found)   \
    {                                                               \
        (void)c, (void)kind, (void)found;                           \
        return DISCARD;                                             \
    }

NO_STATUS(fmi2GetStatus, Status)
NO_STATUS(fmi2GetRealStatus, double)
NO_STATUS(fmi2GetIntegerStatus, int)
NO_STATUS(fmi2GetBooleanStatus, Flag)
NO_STATUS(fmi2GetStringStatus, const char *)
