/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A complete plugin: one spring f = k d between the ground and a body, d the way of the body's marker from where it started.
 * To be read next to dttmm_plugin.h. Nothing but constants is static: what changes lives in the instance.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dttmm_plugin.h"

static const dttmm_parameter parameters[] = {
    {"stiffness", "N/m", 3, DTTMM_PARAMETER_REQUIRED | DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, NULL, 0,
     "in x, y, z of the world"}};
static const dttmm_element_type types[] = {
    {"c_spring", DTTMM_ENDS_FROM_TO, 1, parameters, "a spring from the ground to a body"}};
static const dttmm_channel force_channels[] = {
    {"force.x", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.y", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.z", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"strain_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_STRAIN_ENERGY}};

struct dttmm_instance {
    double k[3], rest[3];  /* stiffness; where the spring is slack */
    double weights[3];     /* of d at the end of the step, at its start t_n, and one step before */
    double d[3][3];        /* d at t_n, t_n-1, t_n-2 */
    double h;              /* step size; 0 before start */
    int32_t first, open;   /* no step has been committed; a step is open */
};

static dttmm_status fail(dttmm_error *error, dttmm_status status, const char *text) {
    error->element = 0;
    snprintf(error->text, sizeof error->text, "%s", text);
    return status;
}

static dttmm_status create(const dttmm_network *network, dttmm_instance **instance, dttmm_error *error) {
    *instance = NULL;
    const dttmm_element *spring = network->elements;
    if (network->node_count != 2 || network->element_count != 1 || network->nodes[spring->ends[0]].kind != DTTMM_NODE_GROUND ||
        network->nodes[spring->ends[1]].kind != DTTMM_NODE_PORT)
        return fail(error, DTTMM_ERROR_MODEL, "a c_spring leads from the ground to a body");
    dttmm_instance *s = calloc(1, sizeof *s);
    if (s == NULL) return fail(error, DTTMM_ERROR_MEMORY, "out of memory");
    memcpy(s->k, spring->values, sizeof s->k);
    memcpy(s->rest, network->nodes[spring->ends[1]].position, sizeof s->rest);
    const double b = network->beta, g = network->gamma;
    const double centred[3] = {b, 0.5 + g - 2 * b, 0.5 - g + b}, explicit[3] = {0, 1, 0};
    memcpy(s->weights, network->scheme == DTTMM_SCHEME_CENTRED ? centred : explicit, sizeof s->weights);
    *instance = s;
    return DTTMM_OK;
}

static void destroy(dttmm_instance *s) { free(s); }
static int32_t is_implicit(const dttmm_instance *s) { return s->weights[0] > 0; }
static void load_weights(const dttmm_instance *s, double weights[3]) { memcpy(weights, s->weights, sizeof s->weights); }

/* A 6 x 6 stiffness with `factor` times k in its translations, the wrench of the spring with it. */
static void write_stiffness(const dttmm_instance *s, double factor, double *matrix) {
    memset(matrix, 0, 36 * sizeof *matrix);
    for (int i = 0; i < 3; ++i) matrix[7 * i] = factor * s->k[i];
}

static dttmm_status linearise(const dttmm_instance *s, const dttmm_motion *port, double *wrench, double *stiffness,
                              double *damping, dttmm_error *error) {
    (void)error;
    memset(wrench, 0, 6 * sizeof *wrench);
    for (int i = 0; i < 3; ++i) wrench[i] = -s->k[i] * (port->position[i] - s->rest[i]);
    if (stiffness) write_stiffness(s, 1, stiffness);
    if (damping) memset(damping, 0, 36 * sizeof *damping);
    return DTTMM_OK;
}

/* Before the start the spring counts as at the start: the first step of the centred scheme is then Newmark's. */
static dttmm_status start(dttmm_instance *s, const dttmm_step *step, const dttmm_motion *port, const double *accelerations,
                          const double *loads, dttmm_error *error) {
    (void)accelerations, (void)loads; /* loads act on inner nodes, and there are none */
    if (s->open) return fail(error, DTTMM_ERROR_PHASE, "start: a step is open");
    for (int back = 0; back < 3; ++back)
        for (int i = 0; i < 3; ++i) s->d[back][i] = port->position[i] - s->rest[i];
    s->h = step->size;
    s->first = 1;
    return DTTMM_OK;
}

static dttmm_status begin_step(dttmm_instance *s, const dttmm_step *step, const double *loads, dttmm_error *error) {
    (void)loads;
    if (s->h == 0 || s->open) return fail(error, DTTMM_ERROR_PHASE, "begin_step: not started, or a step is open");
    if (step->size != s->h) return fail(error, DTTMM_ERROR_ARGUMENT, "begin_step: a new step size wants a new start");
    s->open = 1;
    return DTTMM_OK;
}

static dttmm_status evaluate(const dttmm_instance *s, const dttmm_motion *trial, double *wrench, double *stiffness,
                             dttmm_error *error) {
    if (!s->open) return fail(error, DTTMM_ERROR_PHASE, "evaluate: no step is open");
    memset(wrench, 0, 6 * sizeof *wrench);
    for (int i = 0; i < 3; ++i) {
        const double end = trial->position[i] - s->rest[i];
        wrench[i] = -s->k[i] * (s->weights[0] * end + s->weights[1] * s->d[0][i] + s->weights[2] * s->d[1][i]);
    }
    if (stiffness) write_stiffness(s, s->weights[0], stiffness);
    return DTTMM_OK;
}

static dttmm_status commit_step(dttmm_instance *s, const dttmm_motion *accepted, dttmm_error *error) {
    if (!s->open) return fail(error, DTTMM_ERROR_PHASE, "commit_step: no step is open");
    memmove(s->d[1], s->d[0], 2 * sizeof s->d[0]);
    for (int i = 0; i < 3; ++i) s->d[0][i] = accepted->position[i] - s->rest[i];
    s->first = s->open = 0;
    return DTTMM_OK;
}

static dttmm_status discard_step(dttmm_instance *s, dttmm_error *error) {
    (void)error;
    s->open = 0;
    return DTTMM_OK;
}

/* For rows of results: the mean force over the step last committed, and that at its start. */
static dttmm_status mean_wrench(dttmm_instance *s, double *wrench, dttmm_error *error) {
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, "mean_wrench: no step has been committed");
    memset(wrench, 0, 6 * sizeof *wrench);
    for (int i = 0; i < 3; ++i) wrench[i] = -0.5 * s->k[i] * (s->d[0][i] + s->d[1][i]);
    return DTTMM_OK;
}

static dttmm_status stand(dttmm_instance *s, const dttmm_motion *port, double *wrench, dttmm_error *error) {
    (void)port; /* of its velocity nothing hangs here */
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, "stand: no step has been committed");
    memset(wrench, 0, 6 * sizeof *wrench);
    for (int i = 0; i < 3; ++i) wrench[i] = -s->k[i] * s->d[1][i];
    return DTTMM_OK;
}

/* The state is the instance itself: plain numbers, the constants among them. */
static size_t state_size(const dttmm_instance *s) { return sizeof *s; }

static dttmm_status save_state(const dttmm_instance *s, void *buffer, size_t size, dttmm_error *error) {
    if (size != sizeof *s) return fail(error, DTTMM_ERROR_ARGUMENT, "save_state: wrong size");
    memcpy(buffer, s, size);
    return DTTMM_OK;
}

static dttmm_status restore_state(dttmm_instance *s, const void *buffer, size_t size, dttmm_error *error) {
    if (size != sizeof *s) return fail(error, DTTMM_ERROR_ARGUMENT, "restore_state: wrong size");
    memcpy(s, buffer, size);
    return DTTMM_OK;
}

static uint32_t channel_count(const dttmm_instance *s) { return (void)s, 4; }
static const dttmm_channel *channels(const dttmm_instance *s) { return (void)s, force_channels; }

/* At t_n, the start of the step last committed. */
static dttmm_status outputs(const dttmm_instance *s, double *values, dttmm_error *error) {
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    values[3] = 0;
    for (int i = 0; i < 3; ++i) {
        values[i] = s->k[i] * s->d[1][i];
        values[3] += 0.5 * values[i] * s->d[1][i];
    }
    return DTTMM_OK;
}

static const dttmm_plugin plugin = {
    sizeof(dttmm_plugin), DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR, "minimal plugin", "1.0", 1, types, create, destroy, linearise,
    start, begin_step, evaluate, commit_step, discard_step, is_implicit, load_weights, state_size, save_state, restore_state,
    channel_count, channels, outputs, NULL, NULL, NULL, NULL, NULL, NULL, NULL, /* histories only, no modes */ NULL, /* nothing to expect */
    mean_wrench, stand, NULL, NULL};

const dttmm_plugin *dttmm_plugin_entry(uint32_t host_major) { return host_major == DTTMM_PLUGIN_MAJOR ? &plugin : NULL; }
