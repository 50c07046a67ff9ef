/* SPDX-License-Identifier: BSD-3-Clause
 *
 * The spring-damper's three translations written anew, in C, for every scheme and any ends: what the built-in plugin is
 * compared with. The example for plugin authors is examples/minimal_plugin.
 *
 *     f = k d + c d'       d: how far the `to` end has moved against the `from` end since the start, in the axes of `from`
 *
 * -f acts on the `to` end, +f on the `from` end together with the moment arm x f, so that the two balance about any point.
 * The centred scheme weighs the spring's forces at three instants: the even part of the weights with the directions and the
 * arm of each instant; the odd part, which is its numerical damping, and the damper, by increments of d over the two steps
 * around t_n, with those of t_{n+1} and t_{n-1}.
 * Only constants are static: what changes lives in the instance, so that two springs, or a step tried twice, never mix.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dttmm_plugin.h"
#include "dttmm_state.h"

/* ---- What the model file may say ---- */

static const dttmm_parameter parameters[] = {
    {"stiffness", "N/m", 3, DTTMM_PARAMETER_REQUIRED | DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, NULL, 0, "in x, y, z of the from end"},
    {"damping", "N*s/m", 3, DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, NULL, 0, "in x, y, z of the from end"},
};
static const dttmm_element_type types[] = {
    {"independent_spring", DTTMM_ENDS_FROM_TO, 2, parameters, "a spring and a damper in three translations"}};

enum { CHANNELS = 8 };
static const dttmm_channel channel_table[CHANNELS] = {
    {"force.x", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.y", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.z", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"deflection.x", "m", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"deflection.y", "m", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"deflection.z", "m", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"strain_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_STRAIN_ENERGY},
    {"dissipated_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_DISSIPATED_ENERGY},
};

/* ---- Memory ---- */

enum { FROM, TO };
enum { CREATED, BETWEEN_STEPS, IN_STEP };

/* The to end as the from end sees it. */
struct view {
    double axes[9];             /* of the from end */
    double arm[3], velocity[3]; /* of the to end, seen from these axes, in world directions */
    double d[3];                /* in their own directions */
    double arms[2][3];          /* from the centres of mass of their bodies to the ends, world */
    double lever[2][3];         /* from there to the to end, where the force acts */
};

/* What the spring does: the force on the from end (the to end gets the opposite), and the moments of these about the centres
 * of mass of the bodies on the from and the to end. */
struct push {
    double force[3], moment[2][3];
};

/* All that changes from step to step: plain numbers, so that saving is copying. */
struct memory {
    double h;                 /* step size */
    double past[4][3];        /* d at t_n, t_{n-1}, t_{n-2}, t_{n-3} */
    struct push elastic[2];   /* of the spring at t_n and t_{n-1} */
    struct push known;        /* of the damper and the odd part, what does not depend on the end of the coming step */
    struct view now, before;  /* at t_n and t_{n-1} */
    double rate[3];           /* d' at t_{n-1}: centred, at the start the initial one */
    double dissipated;        /* lost to damping up to t_{n-1} */
    double last_loss;         /* over the step from there; NAN before the first one */
    int committed;
};

struct dttmm_instance {
    double k[3], c[3];
    double rest[3];             /* the to end seen from the from end at the start */
    double elastic[5], rate[5]; /* weights of d at t_{n+1}, t_n, ... t_{n-3}: of the spring in d, of the damper in h d' */
    double even[3], odd;        /* parts of the spring's weights: even[0], even[1], even[0] and odd, 0, -odd */
    int port[2];                /* of the from and the to end: number among those on bodies, -1 on the ground */
    uint32_t body[2];           /* on which they are */
    double arm[2][3];           /* from the centre of mass of its body to either end, in the body's axes */
    double axes[2][9];          /* of either end in those of its body */
    dttmm_motion ground[2];     /* where an end on the ground stays */
    uint32_t body_count, block_count;
    dttmm_block blocks[4];
    int phase;
    struct memory memory;
};

static dttmm_status fail(dttmm_error *error, dttmm_status status, int32_t element, const char *text) {
    error->element = element;
    snprintf(error->text, sizeof error->text, "%s", text);
    return status;
}

/* ---- Geometry ---- */

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void to_local(const double R[9], const double v[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

static void to_world(const double R[9], const double v[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

/* Motion of an end, and its arm. */
static dttmm_motion motion_of(const dttmm_instance *s, int end, const dttmm_motion *bodies, double arm[3]) {
    dttmm_motion motion;
    double turning[3];
    memset(arm, 0, 3 * sizeof *arm);
    if (s->port[end] < 0) return s->ground[end];
    motion = bodies[s->body[end]];
    to_world(motion.rotation, s->arm[end], arm);
    cross(motion.angular_velocity, arm, turning);
    for (int i = 0; i < 3; ++i) {
        motion.position[i] += arm[i];
        motion.velocity[i] += turning[i];
        for (int j = 0; j < 3; ++j) {
            motion.rotation[3 * i + j] = 0;
            for (int k = 0; k < 3; ++k)
                motion.rotation[3 * i + j] += bodies[s->body[end]].rotation[3 * i + k] * s->axes[end][3 * k + j];
        }
    }
    return motion;
}

static struct view look(const dttmm_instance *s, const dttmm_motion *bodies) {
    struct view v;
    const dttmm_motion ends[2] = {motion_of(s, FROM, bodies, v.arms[FROM]), motion_of(s, TO, bodies, v.arms[TO])};
    const dttmm_motion *from = &ends[FROM], *to = &ends[TO];
    double carried[3]; /* velocity of a point at the to end that turns with the from end */
    memcpy(v.axes, from->rotation, sizeof v.axes);
    for (int i = 0; i < 3; ++i) v.arm[i] = to->position[i] - from->position[i];
    cross(from->angular_velocity, v.arm, carried);
    for (int i = 0; i < 3; ++i) v.velocity[i] = to->velocity[i] - from->velocity[i] - carried[i];
    to_local(v.axes, v.arm, v.d);
    for (int i = 0; i < 3; ++i) v.d[i] -= s->rest[i];
    for (int i = 0; i < 3; ++i) {
        v.lever[FROM][i] = v.arms[FROM][i] + v.arm[i];
        v.lever[TO][i] = v.arms[TO][i];
    }
    return v;
}

/* The push of the force f (local). */
static struct push push_of(const struct view *v, const double f[3]) {
    struct push push;
    to_world(v->axes, f, push.force);
    for (int end = FROM; end <= TO; ++end) cross(v->lever[end], push.force, push.moment[end]);
    return push;
}

static void add_push(struct push *sum, double weight, const struct push *push) {
    for (int i = 0; i < 3; ++i) {
        sum->force[i] += weight * push->force[i];
        for (int end = FROM; end <= TO; ++end) sum->moment[end][i] += weight * push->moment[end][i];
    }
}

/* Adds a push to the wrenches on the ends' bodies, those of one behind those of the other; neighbouring numbers of `out` are
 * `stride` apart. */
static void add_wrenches(const dttmm_instance *s, const struct push *push, double *out, size_t stride) {
    for (int end = FROM; end <= TO; ++end) {
        if (s->port[end] < 0) continue;
        double *wrench = out + 6 * (size_t)s->port[end] * stride;
        const double sign = end == FROM ? 1 : -1;
        for (size_t i = 0; i < 3; ++i) {
            wrench[i * stride] += sign * push->force[i];
            wrench[(3 + i) * stride] += sign * push->moment[end][i];
        }
    }
}

/* 6 per end on a body. */
static size_t wrench_size(const dttmm_instance *s) { return (s->port[FROM] >= 0 ? 6u : 0u) + (s->port[TO] >= 0 ? 6u : 0u); }

/* The wrenches of a push on all bodies. */
static void write_wrenches(const dttmm_instance *s, const struct push *push, double *wrench) {
    double own[12] = {0};
    add_wrenches(s, push, own, 1);
    memset(wrench, 0, 6 * s->body_count * sizeof *wrench);
    for (int end = FROM; end <= TO; ++end)
        if (s->port[end] >= 0) memcpy(wrench + 6 * s->body[end], own + 6 * s->port[end], 6 * sizeof *wrench);
}

/* Adds to a column of S, for the body of `end` moving or turning by `unit`, what stems from the force F that acts already. Of
 * what it does when turned this is the symmetric part about the centres of mass; with a and l from these to its point
 *     K_from,from = [0 F~; -F~ sym(a~ F~)],   K_from,to = [0 0; F~ -F~ l~],   K_to,from its transpose,   K_to,to = [0 0; 0 sym(l~ F~)] */
static void add_turning(const dttmm_instance *s, const struct view *v, const double F[3], int end,
                        int turns, const double unit[3], double *column, size_t stride) {
    struct push from = {{0}, {{0}}}, to = {{0}, {{0}}}; /* the rows of the one and the other */
    double half[3], swept[3];
    if (!turns) cross(F, unit, from.moment[FROM]);
    if (end == FROM)
        for (int i = 0; i < 3; ++i) from.moment[FROM][i] *= -1;
    if (turns) {
        const double *lever = v->lever[end];
        double f_unit[3], both[3];
        cross(F, unit, f_unit);
        cross(lever, f_unit, half); /* l~ F~ */
        cross(lever, unit, swept);
        cross(F, swept, both); /* F~ l~ */
        for (int i = 0; i < 3; ++i) (end == FROM ? from.moment[FROM] : to.moment[TO])[i] += 0.5 * (half[i] + both[i]);
        if (end == TO)
            for (int i = 0; i < 3; ++i) from.moment[FROM][i] -= both[i];
        if (end == FROM) {
            cross(v->lever[TO], f_unit, half);
            for (int i = 0; i < 3; ++i) {
                from.force[i] = f_unit[i];
                to.force[i] = -f_unit[i];
                to.moment[TO][i] = -half[i];
            }
        }
    }
    for (int row = FROM; row <= TO; ++row) {
        const struct push *push = row == FROM ? &from : &to;
        if (s->port[row] < 0) continue;
        for (size_t i = 0; i < 3; ++i) {
            column[(6 * (size_t)s->port[row] + i) * stride] += push->force[i];
            column[(6 * (size_t)s->port[row] + 3 + i) * stride] += push->moment[row][i];
        }
    }
}

/* -d(wrench)/d(pose), column by column, for a force that grows by gain d and the force F that acts already; then block by
 * block. */
static void write_stiffness(const dttmm_instance *s, const struct view *v, const double gain[3], const double F[3],
                            double *blocks) {
    const size_t n = wrench_size(s);
    double S[12 * 12] = {0};
    for (int end = FROM; end <= TO; ++end)
        for (int i = 0; i < 6 && s->port[end] >= 0; ++i) {
            const int turns = i >= 3;
            double unit[3] = {0}, moved[3] = {0}, f[3], *column = S + 6 * s->port[end] + i;
            unit[i % 3] = 1;
            if (!turns && end == TO) memcpy(moved, unit, sizeof moved);
            if (!turns && end == FROM) moved[i] = -1;
            if (turns && end == FROM) cross(v->lever[FROM], unit, moved); /* it turns the to end's point about its centre */
            if (turns && end == TO) cross(unit, v->lever[TO], moved);
            to_local(v->axes, moved, f);
            for (int a = 0; a < 3; ++a) f[a] *= -gain[a];
            const struct push push = push_of(v, f);
            add_wrenches(s, &push, column, n);
            add_turning(s, v, F, end, turns, unit, column, n);
        }
    for (size_t b = 0; b < s->block_count; ++b) {
        const size_t row = n == 6 ? 0 : b / 2, column = n == 6 ? 0 : b % 2;
        for (size_t i = 0; i < 6; ++i) memcpy(blocks + 36 * b + 6 * i, S + (6 * row + i) * n + 6 * column, 6 * sizeof *S);
    }
}

/* ---- From the network to an instance ---- */

/* The explicit schemes take the spring's d at t_n and differ in h d'. Fox-Euler's is 2 (d_n - d_{n-1}) - h d'_{n-1} with the
 * old velocity from the host's motion, d'_{n-1} = (d_n - d_{n-2})/2h: its own recursion would be unstable. */
static dttmm_status set_scheme(dttmm_instance *s, const dttmm_network *network, dttmm_error *error) {
    static const double explicit_rates[][5] = {
        [DTTMM_SCHEME_FOX_EULER] = {0, 3. / 2, -2, 1. / 2, 0},
        [DTTMM_SCHEME_BDF1] = {0, 1, -1, 0, 0},
        [DTTMM_SCHEME_BDF2] = {0, 3. / 2, -2, 1. / 2, 0},
        [DTTMM_SCHEME_HOUBOLT] = {0, 11. / 6, -3, 3. / 2, -1. / 3},
        [DTTMM_SCHEME_PARK] = {0, 5. / 3, -5. / 2, 1, -1. / 6},
    };
    const double b = network->beta, g = network->gamma;
    if (network->scheme > DTTMM_SCHEME_PARK) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "unknown time scheme");
    if (network->scheme == DTTMM_SCHEME_CENTRED) {
        memcpy(s->elastic, (const double[5]){b, 0.5 + g - 2 * b, 0.5 - g + b}, sizeof s->elastic);
        memcpy(s->rate, (const double[5]){g, 1 - 2 * g, g - 1}, sizeof s->rate);
    } else {
        memcpy(s->elastic, (const double[5]){0, 1}, sizeof s->elastic);
        memcpy(s->rate, explicit_rates[network->scheme], sizeof s->rate);
    }
    s->even[0] = s->even[2] = (s->elastic[0] + s->elastic[2]) / 2;
    s->even[1] = s->elastic[1];
    s->odd = (s->elastic[0] - s->elastic[2]) / 2;
    return DTTMM_OK;
}

static void place_ends(dttmm_instance *s, const dttmm_network *network) {
    const uint32_t *nodes = network->elements->ends;
    s->port[FROM] = s->port[TO] = -1; /* for now both are where they start */
    for (int end = FROM; end <= TO; ++end) {
        memcpy(s->ground[end].position, network->nodes[nodes[end]].position, sizeof s->ground[end].position);
        memcpy(s->ground[end].rotation, network->nodes[nodes[end]].rotation, sizeof s->ground[end].rotation);
    }
    memcpy(s->rest, look(s, NULL).d, sizeof s->rest);
    int count = 0;
    uint32_t bodies[2];
    for (int end = FROM; end <= TO; ++end) {
        const dttmm_node *node = &network->nodes[nodes[end]];
        if (node->kind != DTTMM_NODE_ON_BODY) continue;
        const dttmm_body *body = &network->bodies[node->body];
        double way[3];
        for (int i = 0; i < 3; ++i) way[i] = node->position[i] - body->position[i];
        to_local(body->rotation, way, s->arm[end]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k)
                    s->axes[end][3 * i + j] += body->rotation[3 * k + i] * node->rotation[3 * k + j];
        s->body[end] = node->body;
        s->port[end] = count;
        bodies[count++] = node->body;
    }
    s->body_count = network->body_count;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) s->blocks[s->block_count++] = (dttmm_block){bodies[i], bodies[j]};
}

static dttmm_status create(const dttmm_network *network, dttmm_instance **instance, dttmm_error *error) {
    *instance = NULL;
    if (network == NULL) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "create: no network");
    if (network->element_count != 1 || network->node_count != 2)
        return fail(error, DTTMM_ERROR_MODEL, -1, "independent_spring joins two bodies, or a body and the ground, and nothing else");
    const dttmm_element *element = network->elements;
    if (element->type != 0 || element->values == NULL) return fail(error, DTTMM_ERROR_ARGUMENT, 0, "this is no independent_spring");
    if (element->end_count != 2 || element->ends[FROM] > 1 || element->ends[TO] > 1)
        return fail(error, DTTMM_ERROR_MODEL, 0, "an end is no node of the network");
    if (element->ends[FROM] == element->ends[TO]) return fail(error, DTTMM_ERROR_MODEL, 0, "both ends are the same node");
    for (int end = FROM; end <= TO; ++end)
        if (network->nodes[end].kind > DTTMM_NODE_ON_BODY) return fail(error, DTTMM_ERROR_MODEL, 0, "it joins bodies, and no node");
    if (network->nodes[0].kind == DTTMM_NODE_GROUND && network->nodes[1].kind == DTTMM_NODE_GROUND)
        return fail(error, DTTMM_ERROR_MODEL, 0, "both ends are on the ground; attach one of them to a body");
    if (network->nodes[0].kind == network->nodes[1].kind && network->nodes[0].body == network->nodes[1].body)
        return fail(error, DTTMM_ERROR_MODEL, 0, "both ends are on one body");

    dttmm_instance *s = calloc(1, sizeof *s);
    if (s == NULL) return fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    memcpy(s->k, element->values, sizeof s->k);
    memcpy(s->c, element->values + 3, sizeof s->c);
    place_ends(s, network);
    const dttmm_status status = set_scheme(s, network, error);
    if (status == DTTMM_OK)
        *instance = s;
    else
        free(s);
    return status;
}

static void destroy(dttmm_instance *s) { free(s); }

/* ---- The force law, and steps in time ---- */

static dttmm_status linearise(const dttmm_instance *s, const dttmm_motion *bodies, double *wrench, double *stiffness,
                              double *damping, dttmm_error *error) {
    (void)error;
    const struct view v = look(s, bodies);
    double f[3], rate[3];
    to_local(v.axes, v.velocity, rate);
    for (int i = 0; i < 3; ++i) f[i] = s->k[i] * v.d[i] + s->c[i] * rate[i];
    const double nothing[3] = {0};
    const struct push push = push_of(&v, f);
    write_wrenches(s, &push, wrench);
    if (stiffness) write_stiffness(s, &v, s->k, nothing, stiffness);
    if (damping) write_stiffness(s, &v, s->c, nothing, damping);
    return DTTMM_OK;
}

/* d'' = R^T (a - alpha x arm - w x (w x arm + 2 velocity)), all relative to the from end, whose w and alpha these are. */
static void deformation_acceleration(const dttmm_instance *s, const struct view *v, const dttmm_motion *bodies,
                                     const double *accelerations, double out[3]) {
    double ends[2][6] = {{0}}, none[3], euler[3], turning[3], apparent[3], a[3];
    for (int end = FROM; end <= TO; ++end) { /* a + alpha x arm + w x (w x arm) */
        if (s->port[end] < 0) continue;
        const double *w = bodies[s->body[end]].angular_velocity;
        memcpy(ends[end], accelerations + 6 * s->body[end], sizeof ends[end]);
        cross(ends[end] + 3, v->arms[end], euler);
        cross(w, v->arms[end], turning);
        cross(w, turning, apparent);
        for (int i = 0; i < 3; ++i) ends[end][i] += euler[i] + apparent[i];
    }
    const double *from = ends[FROM], *to = ends[TO];
    const dttmm_motion motion = motion_of(s, FROM, bodies, none);
    const double *w = motion.angular_velocity;
    cross(from + 3, v->arm, euler);
    cross(w, v->arm, turning);
    for (int i = 0; i < 3; ++i) turning[i] += 2 * v->velocity[i];
    cross(w, turning, apparent);
    for (int i = 0; i < 3; ++i) a[i] = to[i] - from[i] - euler[i] - apparent[i];
    to_local(v->axes, a, out);
}

static int32_t is_implicit(const dttmm_instance *s) { return s->elastic[0] > 0; }

static struct push elastic_push(const dttmm_instance *s, const struct view *v) {
    double f[3];
    for (int i = 0; i < 3; ++i) f[i] = s->k[i] * v->d[i];
    return push_of(v, f);
}

/* t_n is now: what the coming step needs of it. */
static void settle(dttmm_instance *s, const struct view *now) {
    struct memory *m = &s->memory;
    double f[3] = {0};
    if (is_implicit(s)) { /* of the step that ends now, with the axes and levers of its start */
        for (int i = 0; i < 3; ++i)
            f[i] = (s->c[i] * (1 - s->rate[0]) / m->h + s->odd * s->k[i]) * (m->past[0][i] - m->past[1][i]);
        m->known = push_of(&m->now, f);
    } else {
        for (int back = 0; back < 4; ++back)
            for (int i = 0; i < 3; ++i) f[i] += s->c[i] * s->rate[1 + back] / m->h * m->past[back][i];
        m->known = push_of(now, f);
    }
    m->before = m->now;
    m->now = *now;
    m->elastic[1] = m->elastic[0];
    m->elastic[0] = elastic_push(s, now);
    s->phase = BETWEEN_STEPS;
}

static dttmm_status start(dttmm_instance *s, const dttmm_step *step, const dttmm_motion *bodies, const double *accelerations,
                          const double *loads, dttmm_error *error) {
    (void)loads;
    if (s->phase == IN_STEP) return fail(error, DTTMM_ERROR_PHASE, -1, "start: a step is open");
    if (!(step->size > 0) || isinf(step->size)) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "start: no positive step");
    const double h = step->size, b = s->elastic[0], g = s->rate[0];
    const struct view v = look(s, bodies);
    double rate[3], acceleration[3];
    to_local(v.axes, v.velocity, rate);
    deformation_acceleration(s, &v, bodies, accelerations, acceleration);
    s->memory = (struct memory){.h = h, .last_loss = NAN};
    memcpy(s->memory.rate, rate, sizeof rate);
    for (int back = 0; back < 4; ++back)               /* the past before the start is the parabola through it */
        for (int i = 0; i < 3; ++i)
            s->memory.past[back][i] = v.d[i] - back * h * rate[i] + 0.5 * back * back * h * h * acceleration[i];
    settle(s, &v);
    s->memory.elastic[1] = s->memory.elastic[0];
    if (is_implicit(s)) { /* the first centred step is Newmark's from d, d', d'' */
        double f[3];
        for (int i = 0; i < 3; ++i) f[i] = s->c[i] * ((1 - g) * rate[i] + (b - 0.5 * g) * h * acceleration[i]);
        s->memory.known = push_of(&v, f);
    }
    return DTTMM_OK;
}

static dttmm_status begin_step(dttmm_instance *s, const dttmm_step *step, const double *loads, dttmm_error *error) {
    (void)loads;
    if (s->phase != BETWEEN_STEPS) return fail(error, DTTMM_ERROR_PHASE, -1, "begin_step: not started, or a step is open");
    if (step->size != s->memory.h) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "begin_step: a new size wants a new start");
    s->phase = IN_STEP;
    return DTTMM_OK;
}

static dttmm_status evaluate(const dttmm_instance *s, const dttmm_motion *trial, double *wrench, double *stiffness,
                             dttmm_error *error) {
    if (s->phase != IN_STEP) return fail(error, DTTMM_ERROR_PHASE, -1, "evaluate: no step is open");
    const struct memory *m = &s->memory;
    struct push push = m->known;
    if (is_implicit(s)) {
        const struct view next = look(s, trial);
        const struct push end = elastic_push(s, &next);
        double f[3], gain[3], acting[3];
        for (int i = 0; i < 3; ++i) {
            f[i] = (s->c[i] * s->rate[0] / m->h + s->odd * s->k[i]) * (next.d[i] - m->past[0][i]);
            gain[i] = s->k[i] * s->elastic[0] + s->c[i] * s->rate[0] / m->h;
            acting[i] = s->even[0] * m->elastic[0].force[i];
        }
        const struct push rates = push_of(&next, f);
        add_push(&push, 1, &rates);
        add_push(&push, s->even[0], &end);
        if (stiffness) write_stiffness(s, &next, gain, acting, stiffness);
    } else if (stiffness) { /* the trial is not looked at */
        memset(stiffness, 0, 36 * s->block_count * sizeof *stiffness);
    }
    add_push(&push, s->even[1], &m->elastic[0]);
    add_push(&push, s->even[2], &m->elastic[1]);
    write_wrenches(s, &push, wrench);
    return DTTMM_OK;
}

/* d' at t_n, the middle of the last two steps. */
static double centred_rate(const struct memory *m, int axis) { return (m->past[0][axis] - m->past[2][axis]) / (2 * m->h); }

static dttmm_status commit_step(dttmm_instance *s, const dttmm_motion *accepted, dttmm_error *error) {
    if (s->phase != IN_STEP) return fail(error, DTTMM_ERROR_PHASE, -1, "commit_step: no step is open");
    struct memory *m = &s->memory;
    const struct view v = look(s, accepted);
    memmove(m->past[1], m->past[0], sizeof m->past - sizeof m->past[0]);
    memcpy(m->past[0], v.d, sizeof v.d);
    settle(s, &v);
    if (isnan(m->last_loss)) m->last_loss = 0;
    m->dissipated += m->last_loss;
    m->last_loss = 0;
    for (int i = 0; i < 3; ++i) { /* mean force times displacement */
        const double way = m->past[0][i] - m->past[1][i];
        if (m->committed > 0) m->rate[i] = centred_rate(m, i);
        m->last_loss += s->c[i] * way * way / m->h;
    }
    ++m->committed;
    return DTTMM_OK;
}

static dttmm_status discard_step(dttmm_instance *s, dttmm_error *error) {
    if (s->phase != IN_STEP) return fail(error, DTTMM_ERROR_PHASE, -1, "discard_step: no step is open");
    s->phase = BETWEEN_STEPS;
    return DTTMM_OK;
}

static void load_weights(const dttmm_instance *s, double weights[3]) { memcpy(weights, s->elastic, 3 * sizeof *weights); }

/* ---- State and results ---- */

static size_t state_size(const dttmm_instance *s) { return sizeof s->memory; }

static dttmm_status save_state(const dttmm_instance *s, void *buffer, size_t size, dttmm_error *error) {
    if (s->phase != BETWEEN_STEPS) return fail(error, DTTMM_ERROR_PHASE, -1, "save_state: only between steps");
    if (size != sizeof s->memory) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "save_state: wrong size of the buffer");
    memcpy(buffer, &s->memory, size);
    return DTTMM_OK;
}

static dttmm_status restore_state(dttmm_instance *s, const void *buffer, size_t size, dttmm_error *error) {
    struct memory saved;
    if (s->phase != BETWEEN_STEPS) return fail(error, DTTMM_ERROR_PHASE, -1, "restore_state: only between steps");
    if (size != sizeof saved) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "restore_state: wrong size of the buffer");
    memcpy(&saved, buffer, size);
    if (saved.h != s->memory.h) return fail(error, DTTMM_ERROR_ARGUMENT, -1, "restore_state: saved at another step size");
    s->memory = saved;
    return DTTMM_OK;
}

static dttmm_status mean_wrench(dttmm_instance *s, double *wrench, dttmm_error *error) {
    const struct memory *m = &s->memory;
    if (isnan(m->last_loss)) return fail(error, DTTMM_ERROR_PHASE, -1, "mean_wrench: no step has been committed");
    double f[3];
    for (int i = 0; i < 3; ++i) f[i] = s->c[i] * (m->past[0][i] - m->past[1][i]) / m->h;
    struct push push = push_of(&m->before, f);
    add_push(&push, 0.5, &m->elastic[0]);
    add_push(&push, 0.5, &m->elastic[1]);
    write_wrenches(s, &push, wrench);
    return DTTMM_OK;
}

static dttmm_status stand(dttmm_instance *s, const dttmm_motion *bodies, const double *accelerations, double *wrench,
                          dttmm_error *error) {
    (void)accelerations;
    if (isnan(s->memory.last_loss)) return fail(error, DTTMM_ERROR_PHASE, -1, "stand: no step has been committed");
    const struct view v = look(s, bodies);
    to_local(v.axes, v.velocity, s->memory.rate);
    double f[3];
    for (int i = 0; i < 3; ++i) f[i] = s->k[i] * v.d[i] + s->c[i] * s->memory.rate[i];
    const struct push push = push_of(&v, f);
    write_wrenches(s, &push, wrench);
    return DTTMM_OK;
}

static uint32_t channel_count(const dttmm_instance *s) {
    (void)s;
    return CHANNELS;
}

static const dttmm_channel *channels(const dttmm_instance *s) {
    (void)s;
    return channel_table;
}

static dttmm_status outputs(const dttmm_instance *s, double *values, dttmm_error *error) {
    if (isnan(s->memory.last_loss)) return fail(error, DTTMM_ERROR_PHASE, -1, "outputs: no step has been committed");
    const double *d = s->memory.past[1];
    values[6] = 0;
    for (int i = 0; i < 3; ++i) {
        values[i] = s->k[i] * d[i] + s->c[i] * s->memory.rate[i];
        values[3 + i] = d[i];
        values[6] += 0.5 * s->k[i] * d[i] * d[i];
    }
    values[7] = s->memory.dissipated;
    return DTTMM_OK;
}

/* ---- The table and the one exported symbol ---- */

static const dttmm_block *blocks(const dttmm_instance *s, uint32_t *count) {
    *count = s->block_count;
    return s->blocks;
}

static const void *extension(const char *name) {
    static const dttmm_state_table state = {sizeof(dttmm_state_table), state_size, save_state, restore_state};
    return strcmp(name, DTTMM_STATE) == 0 ? &state : NULL;
}

static const dttmm_plugin table = {
    sizeof(dttmm_plugin), DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR,
    "independent spring",     "1.0",              1,
    types,                create,             destroy,
    blocks,               linearise,          start,
    begin_step,           evaluate,           commit_step,
    discard_step,         is_implicit,        load_weights,
    channel_count,        channels,           outputs,
    extension,            NULL,               NULL, /* nothing inside that iterates */
    mean_wrench,          stand,              NULL,
};

const dttmm_plugin *dttmm_plugin_entry(uint32_t host_major) { return host_major == DTTMM_PLUGIN_MAJOR ? &table : NULL; }
