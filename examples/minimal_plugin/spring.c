/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A complete plugin: springs f = k d between the ground and bodies, d the displacement of a body's marker since the start.
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
enum { CHANNELS = 4 };
static const dttmm_channel channels_of_spring[CHANNELS] = {
    {"force.x", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.y", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.z", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"strain_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_STRAIN_ENERGY}};

/* The marker at an instant: its way, and the lever from the body's centre of mass to it (world). */
struct look {
    double d[3], lever[3];
};

struct spring {
    uint32_t body, block;          /* the body it holds, and the block of its stiffness */
    double k[3], start[3], arm[3]; /* stiffness; where the marker started; from the centre of mass to it, body axes */
    struct look past[2];           /* at t_n and t_n-1 */
};

struct dttmm_instance {
    uint32_t body_count, count, block_count;
    struct spring *springs;
    dttmm_block *blocks;
    dttmm_channel *channels;
    double weights[3]; /* of the forces at the end of the step, at its start t_n, and one step before */
    double h;          /* step size; 0 before start */
    int32_t first, open; /* no step has been committed; a step is open */
};

static dttmm_status fail(dttmm_error *error, dttmm_status status, int32_t element, const char *text) {
    error->element = element;
    snprintf(error->text, sizeof error->text, "%s", text);
    return status;
}

static void destroy(dttmm_instance *s) {
    if (s == NULL) return;
    free(s->springs);
    free(s->blocks);
    free(s->channels);
    free(s);
}

/* The block of a body; a new one if no spring before has it. */
static uint32_t block_of(dttmm_instance *s, uint32_t body) {
    for (uint32_t b = 0; b < s->block_count; ++b)
        if (s->blocks[b].row == body) return b;
    s->blocks[s->block_count] = (dttmm_block){body, body};
    return s->block_count++;
}

static dttmm_status create(const dttmm_network *network, dttmm_instance **instance, dttmm_error *error) {
    const uint32_t count = network->element_count;
    *instance = NULL;
    dttmm_instance *s = calloc(1, sizeof *s);
    if (s == NULL) return fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    s->springs = calloc(count, sizeof *s->springs);
    s->blocks = calloc(count, sizeof *s->blocks);
    s->channels = calloc(count, sizeof channels_of_spring);
    if (!s->springs || !s->blocks || !s->channels) return destroy(s), fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    s->body_count = network->body_count;
    s->count = count;
    for (uint32_t e = 0; e < count; ++e) {
        const dttmm_element *element = &network->elements[e];
        const dttmm_node *from = &network->nodes[element->ends[0]], *to = &network->nodes[element->ends[1]];
        if (from->kind != DTTMM_NODE_GROUND || to->kind != DTTMM_NODE_ON_BODY)
            return destroy(s), fail(error, DTTMM_ERROR_MODEL, (int32_t)e, "a c_spring leads from the ground to a body");
        const dttmm_body *body = &network->bodies[to->body];
        struct spring *spring = &s->springs[e];
        spring->body = to->body;
        spring->block = block_of(s, to->body);
        memcpy(spring->k, element->values, sizeof spring->k);
        memcpy(spring->start, to->position, sizeof spring->start);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) spring->arm[i] += body->rotation[3 * j + i] * (to->position[j] - body->position[j]);
        for (int c = 0; c < CHANNELS; ++c) {
            s->channels[CHANNELS * e + (uint32_t)c] = channels_of_spring[c];
            s->channels[CHANNELS * e + (uint32_t)c].index = e;
        }
    }
    const double b = network->beta, g = network->gamma;
    const double centred[3] = {b, 0.5 + g - 2 * b, 0.5 - g + b}, explicit[3] = {0, 1, 0};
    memcpy(s->weights, network->scheme == DTTMM_SCHEME_CENTRED ? centred : explicit, sizeof s->weights);
    *instance = s;
    return DTTMM_OK;
}

static const dttmm_block *blocks(const dttmm_instance *s, uint32_t *count) { return *count = s->block_count, s->blocks; }
static int32_t is_implicit(const dttmm_instance *s) { return s->weights[0] > 0; }
static void load_weights(const dttmm_instance *s, double weights[3]) { memcpy(weights, s->weights, sizeof s->weights); }

static struct look look_at(const struct spring *spring, const dttmm_motion *bodies) {
    const dttmm_motion *body = &bodies[spring->body];
    struct look look;
    for (int i = 0; i < 3; ++i) {
        look.lever[i] = 0;
        for (int j = 0; j < 3; ++j) look.lever[i] += body->rotation[3 * i + j] * spring->arm[j];
        look.d[i] = body->position[i] + look.lever[i] - spring->start[i];
    }
    return look;
}

/* Adds the wrench of a force -k d at the marker, times a factor. */
static void add_wrench(const struct spring *spring, const struct look *look, double factor, double *wrenches) {
    double *wrench = wrenches + 6 * spring->body, f[3];
    const double *l = look->lever;
    for (int i = 0; i < 3; ++i) wrench[i] += f[i] = -factor * spring->k[i] * look->d[i];
    for (int i = 0; i < 3; ++i) wrench[3 + i] += l[(i + 1) % 3] * f[(i + 2) % 3] - l[(i + 2) % 3] * f[(i + 1) % 3];
}

/* Adds factor G' k G, G the motion of the marker by that of the body: d' = x' + w x lever. */
static void add_stiffness(const struct spring *spring, const struct look *look, double factor, double *matrix) {
    double *block = matrix + 36 * spring->block;
    const double *l = look->lever, G[3][6] = {{1, 0, 0, 0, l[2], -l[1]}, {0, 1, 0, -l[2], 0, l[0]}, {0, 0, 1, l[1], -l[0], 0}};
    for (int i = 0; i < 3; ++i)
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) block[6 * a + b] += factor * G[i][a] * spring->k[i] * G[i][b];
}

static void clear(const dttmm_instance *s, double *wrenches, double *stiffness) {
    memset(wrenches, 0, 6 * s->body_count * sizeof *wrenches);
    if (stiffness) memset(stiffness, 0, 36 * s->block_count * sizeof *stiffness);
}

static dttmm_status linearise(const dttmm_instance *s, const dttmm_motion *bodies, double *wrenches, double *stiffness,
                              double *damping, dttmm_error *error) {
    (void)error;
    clear(s, wrenches, stiffness);
    if (damping) memset(damping, 0, 36 * s->block_count * sizeof *damping);
    for (uint32_t e = 0; e < s->count; ++e) {
        const struct look now = look_at(&s->springs[e], bodies);
        add_wrench(&s->springs[e], &now, 1, wrenches);
        if (stiffness) add_stiffness(&s->springs[e], &now, 1, stiffness);
    }
    return DTTMM_OK;
}

/* Before the start the spring counts as at the start: the first step of the centred scheme is then Newmark's. */
static dttmm_status start(dttmm_instance *s, const dttmm_step *step, const dttmm_motion *bodies, const double *accelerations,
                          const double *loads, dttmm_error *error) {
    (void)accelerations, (void)loads; /* loads act on inner nodes, and there are none */
    if (s->open) return fail(error, DTTMM_ERROR_PHASE, -1, "start: a step is open");
    for (uint32_t e = 0; e < s->count; ++e) s->springs[e].past[0] = s->springs[e].past[1] = look_at(&s->springs[e], bodies);
    s->h = step->size;
    s->first = 1;
    return DTTMM_OK;
}

static dttmm_status begin_step(dttmm_instance *s, const dttmm_step *step, const double *loads, dttmm_error *error) {
    (void)loads;
    if (s->h == 0 || s->open) return fail(error, DTTMM_ERROR_PHASE, -1, "begin_step: not started, or a step is open");
    if (step->size != s->h) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "begin_step: a new step size wants a new start");
    s->open = 1;
    return DTTMM_OK;
}

static dttmm_status evaluate(const dttmm_instance *s, const dttmm_motion *trial, double *wrenches, double *stiffness,
                             dttmm_error *error) {
    if (!s->open) return fail(error, DTTMM_ERROR_PHASE, -1, "evaluate: no step is open");
    clear(s, wrenches, stiffness);
    for (uint32_t e = 0; e < s->count; ++e) {
        const struct spring *spring = &s->springs[e];
        const struct look end = look_at(spring, trial);
        add_wrench(spring, &end, s->weights[0], wrenches);
        add_wrench(spring, &spring->past[0], s->weights[1], wrenches);
        add_wrench(spring, &spring->past[1], s->weights[2], wrenches);
        if (stiffness) add_stiffness(spring, &end, s->weights[0], stiffness);
    }
    return DTTMM_OK;
}

static dttmm_status commit_step(dttmm_instance *s, const dttmm_motion *accepted, dttmm_error *error) {
    if (!s->open) return fail(error, DTTMM_ERROR_PHASE, -1, "commit_step: no step is open");
    for (uint32_t e = 0; e < s->count; ++e) {
        s->springs[e].past[1] = s->springs[e].past[0];
        s->springs[e].past[0] = look_at(&s->springs[e], accepted);
    }
    s->first = s->open = 0;
    return DTTMM_OK;
}

static dttmm_status discard_step(dttmm_instance *s, dttmm_error *error) {
    (void)error;
    s->open = 0;
    return DTTMM_OK;
}

/* For rows of results: the mean force over the step last committed, and that at its start. */
static dttmm_status mean_wrench(dttmm_instance *s, double *wrenches, dttmm_error *error) {
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, -1, "mean_wrench: no step has been committed");
    clear(s, wrenches, NULL);
    for (uint32_t e = 0; e < s->count; ++e)
        for (int back = 0; back < 2; ++back) add_wrench(&s->springs[e], &s->springs[e].past[back], 0.5, wrenches);
    return DTTMM_OK;
}

static dttmm_status stand(dttmm_instance *s, const dttmm_motion *bodies, const double *accelerations, double *wrenches,
                          dttmm_error *error) {
    (void)accelerations;
    (void)bodies; /* nothing hangs on velocities here */
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, -1, "stand: no step has been committed");
    clear(s, wrenches, NULL);
    for (uint32_t e = 0; e < s->count; ++e) add_wrench(&s->springs[e], &s->springs[e].past[1], 1, wrenches);
    return DTTMM_OK;
}

static uint32_t channel_count(const dttmm_instance *s) { return CHANNELS * s->count; }
static const dttmm_channel *channels(const dttmm_instance *s) { return s->channels; }

/* At t_n, the start of the step last committed. */
static dttmm_status outputs(const dttmm_instance *s, double *values, dttmm_error *error) {
    if (s->first) return fail(error, DTTMM_ERROR_PHASE, -1, "outputs: no step has been committed");
    for (uint32_t e = 0; e < s->count; ++e, values += CHANNELS) {
        const struct spring *spring = &s->springs[e];
        values[3] = 0;
        for (int i = 0; i < 3; ++i) {
            values[i] = spring->k[i] * spring->past[1].d[i];
            values[3] += 0.5 * values[i] * spring->past[1].d[i];
        }
    }
    return DTTMM_OK;
}

static const dttmm_plugin plugin = {
    sizeof(dttmm_plugin), DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR, "minimal plugin", "1.0", 1, types, create, destroy, blocks,
    linearise, start, begin_step, evaluate, commit_step, discard_step, is_implicit, load_weights, channel_count, channels,
    outputs, NULL, /* no extensions: histories only, no modes */ NULL, NULL, /* nothing inside that iterates */ mean_wrench, stand, NULL};

const dttmm_plugin *dttmm_plugin_entry(uint32_t host_major) { return host_major == DTTMM_PLUGIN_MAJOR ? &plugin : NULL; }
