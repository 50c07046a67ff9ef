/* SPDX-License-Identifier: BSD-3-Clause
 *
 * Lumps on springs, a plugin to test what the host does with nodes: springs between bodies, nodes and the ground, and masses
 * at nodes, in translations only. Leap-frog, whatever the scheme asked for: with f the forces at t_n
 *
 *     v+ = v + h f/m,   x+ = x + h v+         v stands half a step behind x
 *
 * which is also what the host does with a body, so that both together are one recurrence. Only constants are static.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dttmm_plugin.h"

static const dttmm_word stiffness_words[] = {{"free", 0}};
static const dttmm_word kinds[] = {{"soft", 1}, {"hard", 2}};
static const dttmm_parameter link_parameters[] = {
    {"law.stiffness", "N/m", 1, DTTMM_PARAMETER_REQUIRED, 0, 0, 1e15, stiffness_words, 1, "of one spring, in x, y, z"},
    {"law.kind", "1", 1, DTTMM_PARAMETER_WORDS_ONLY, 1, 0, 0, kinds, 2, "a hard one is twice as stiff"},
    {"strands", "1", 1, DTTMM_PARAMETER_INTEGER, 1, 1, 100, NULL, 0, "springs side by side"},
    {"slack", "m", 1, 0, NAN, -1, 1, NULL, 0, "length in z that the spring does not feel"},
};
static const dttmm_parameter lump_parameters[] = {
    {"mass", "kg", 1, DTTMM_PARAMETER_REQUIRED, 0, 1e-9, 1e9, NULL, 0, "at every node"},
};
enum { LINK, LUMP };
static const dttmm_element_type types[] = {
    {"link", DTTMM_ENDS_FROM_TO, 4, link_parameters, "springs in three translations"},
    {"lump", DTTMM_ENDS_AT, 1, lump_parameters, "a mass at a node, or several alike"},
};

/* The channels of a link, and of an inner node. */
enum { LINK_CHANNELS = 4, NODE_CHANNELS = 8 };
static const dttmm_channel link_channels[LINK_CHANNELS] = {
    {"force.x", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.y", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"force.z", "N", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_RESULT},
    {"strain_energy", "J", DTTMM_OF_ELEMENT, 0, DTTMM_ROLE_STRAIN_ENERGY},
};
static const dttmm_channel node_channels[NODE_CHANNELS] = {
    {"position.x", "m", DTTMM_OF_NODE, 0, DTTMM_ROLE_RESULT},
    {"position.y", "m", DTTMM_OF_NODE, 0, DTTMM_ROLE_RESULT},
    {"position.z", "m", DTTMM_OF_NODE, 0, DTTMM_ROLE_RESULT},
    {"velocity.x", "m/s", DTTMM_OF_NODE, 0, DTTMM_ROLE_ON_REQUEST},
    {"velocity.y", "m/s", DTTMM_OF_NODE, 0, DTTMM_ROLE_ON_REQUEST},
    {"velocity.z", "m/s", DTTMM_OF_NODE, 0, DTTMM_ROLE_ON_REQUEST},
    {"kinetic_energy", "J", DTTMM_OF_NODE, 0, DTTMM_ROLE_KINETIC_ENERGY},
    {"work", "J", DTTMM_OF_NODE, 0, DTTMM_ROLE_WORK},
};

struct link {
    uint32_t from, to, element;
    double stiffness, slack;
};

struct node {
    uint32_t kind, fixed, index; /* index: among the inner nodes, or that of its body */
    double mass, rest[3], start_velocity[3], arm[3]; /* arm: from the centre of mass of its body, body axes */
    double x[3], v[3];           /* at t_n, and over the step before */
    double load[3];              /* at t_n */
    double f[3];                 /* of the links on it at t_n */
    double work, power;          /* of load and weight, up to and at the start of the step last committed */
};

struct dttmm_instance {
    uint32_t node_count, link_count, inner_count, body_count, channel_count;
    struct node *nodes;
    struct link *links;
    dttmm_channel *channels;
    double *outputs;
    double gravity[3], h;
    double *end_loads; /* at the end of the open step */
    dttmm_block *blocks;
};

static dttmm_status fail(dttmm_error *error, dttmm_status status, int32_t element, const char *text) {
    error->element = element;
    snprintf(error->text, sizeof error->text, "%s", text);
    return status;
}

static void destroy(dttmm_instance *s) {
    if (s == NULL) return;
    free(s->nodes);
    free(s->links);
    free(s->channels);
    free(s->outputs);
    free(s->end_loads);
    free(s->blocks);
    free(s);
}

static dttmm_status add_elements(dttmm_instance *s, const dttmm_network *network, dttmm_error *error) {
    for (uint32_t e = 0; e < network->element_count; ++e) {
        const dttmm_element *element = &network->elements[e];
        if (element->type == LINK) {
            const double *v = element->values;
            s->links[s->link_count++] = (struct link){element->ends[0], element->ends[1], e, v[0] * v[1] * v[2],
                                                      isnan(v[3]) ? 0 : v[3]};
            continue;
        }
        if (element->values[0] == 13) return fail(error, DTTMM_ERROR_MODEL, (int32_t)e, "13 kg bring bad luck; take 12");
        for (uint32_t i = 0; i < element->end_count; ++i) s->nodes[element->ends[i]].mass += element->values[0];
    }
    for (uint32_t n = 0; n < s->node_count; ++n)
        if (s->nodes[n].kind == DTTMM_NODE_INNER && s->nodes[n].mass == 0)
            return fail(error, DTTMM_ERROR_MODEL, -1, "a node has no mass; put a lump there");
    return DTTMM_OK;
}

static void list_channels(dttmm_instance *s) {
    dttmm_channel *out = s->channels;
    for (uint32_t l = 0; l < s->link_count; ++l, out += LINK_CHANNELS) {
        memcpy(out, link_channels, sizeof link_channels);
        for (int c = 0; c < LINK_CHANNELS; ++c) out[c].index = s->links[l].element;
    }
    for (uint32_t n = 0; n < s->node_count; ++n) {
        if (s->nodes[n].kind != DTTMM_NODE_INNER) continue;
        memcpy(out, node_channels, sizeof node_channels);
        for (int c = 0; c < NODE_CHANNELS; ++c) (out++)->index = n;
    }
    s->channel_count = (uint32_t)(out - s->channels);
}

static dttmm_status create(const dttmm_network *network, dttmm_instance **instance, dttmm_error *error) {
    *instance = NULL;
    const size_t nodes = network->node_count, elements = network->element_count;
    const size_t channels = LINK_CHANNELS * elements + NODE_CHANNELS * nodes;
    dttmm_instance *s = calloc(1, sizeof *s);
    if (s == NULL) return fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    s->nodes = calloc(nodes, sizeof *s->nodes);
    s->links = calloc(elements, sizeof *s->links);
    s->channels = calloc(channels, sizeof *s->channels);
    s->outputs = calloc(channels, sizeof *s->outputs);
    s->end_loads = calloc(6 * nodes, sizeof *s->end_loads);
    s->blocks = calloc((size_t)network->body_count * network->body_count + 1, sizeof *s->blocks);
    if (!s->nodes || !s->links || !s->channels || !s->outputs || !s->end_loads || !s->blocks) {
        destroy(s);
        return fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    }
    s->node_count = network->node_count;
    s->body_count = network->body_count;
    for (uint32_t b = 0; b < s->body_count * s->body_count; ++b)
        s->blocks[b] = (dttmm_block){b / s->body_count, b % s->body_count};
    memcpy(s->gravity, network->gravity, sizeof s->gravity);
    for (uint32_t n = 0; n < s->node_count; ++n) {
        const dttmm_node *from = &network->nodes[n];
        struct node *node = &s->nodes[n];
        node->kind = from->kind;
        node->fixed = from->fixed;
        if (from->kind == DTTMM_NODE_ON_BODY) {
            const dttmm_body *body = &network->bodies[from->body];
            node->index = from->body;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) node->arm[i] += body->rotation[3 * j + i] * (from->position[j] - body->position[j]);
        }
        if (from->kind == DTTMM_NODE_INNER) node->index = s->inner_count++;
        memcpy(node->rest, from->position, sizeof node->rest);
        memcpy(node->x, from->position, sizeof node->x);
        if (from->moves) memcpy(node->start_velocity, from->velocity, sizeof node->start_velocity);
    }
    const dttmm_status status = add_elements(s, network, error);
    if (status != DTTMM_OK) {
        destroy(s);
        return status;
    }
    list_channels(s);
    *instance = s;
    return DTTMM_OK;
}

/* The point of a body where a node is. */
static double place(const struct node *node, const dttmm_motion *bodies, int i) {
    const double *R = bodies[node->index].rotation + 3 * i;
    return bodies[node->index].position[i] + R[0] * node->arm[0] + R[1] * node->arm[1] + R[2] * node->arm[2];
}

/* Way of a node from its start; of one on a body at `bodies`, where not NULL. */
static double way(const struct node *node, const dttmm_motion *bodies, int i) {
    return (bodies && node->kind == DTTMM_NODE_ON_BODY ? place(node, bodies, i) : node->x[i]) - node->rest[i];
}

static double link_force(const dttmm_instance *s, const struct link *link, const dttmm_motion *bodies, int i) {
    return link->stiffness * (way(&s->nodes[link->to], bodies, i) - way(&s->nodes[link->from], bodies, i) -
                              (i == 2 ? link->slack : 0));
}

/* Adds a force at a node to the wrench on its body, with the lever arm of where the body is, or at t_n where that is NULL. */
static void push_body(const struct node *node, const dttmm_motion *bodies, double sign, const double f[3], double *wrenches) {
    double *wrench = wrenches + 6 * node->index, arm[3];
    if (node->kind != DTTMM_NODE_ON_BODY) return;
    for (int i = 0; i < 3; ++i) arm[i] = bodies ? place(node, bodies, i) - bodies[node->index].position[i] : node->v[i];
    for (int i = 0; i < 3; ++i) {
        wrench[i] += sign * f[i];
        wrench[3 + i] += sign * (arm[(i + 1) % 3] * f[(i + 2) % 3] - arm[(i + 2) % 3] * f[(i + 1) % 3]);
    }
}

static void write_wrenches(const dttmm_instance *s, const dttmm_motion *bodies, double *wrench) {
    memset(wrench, 0, 6 * s->body_count * sizeof *wrench);
    for (uint32_t l = 0; l < s->link_count; ++l) {
        double f[3];
        for (int i = 0; i < 3; ++i) f[i] = link_force(s, &s->links[l], bodies, i);
        push_body(&s->nodes[s->links[l].from], bodies, 1, f, wrench);
        push_body(&s->nodes[s->links[l].to], bodies, -1, f, wrench);
    }
}

/* Every pair of bodies may hang on each other. */
static const dttmm_block *blocks(const dttmm_instance *s, uint32_t *count) {
    *count = s->body_count * s->body_count;
    return s->blocks;
}

/* Stiffness with the inner nodes held: they have masses, and the law is that of one instant. */
static dttmm_status linearise(const dttmm_instance *s, const dttmm_motion *bodies, double *wrench, double *stiffness,
                              double *damping, dttmm_error *error) {
    (void)error;
    const size_t size = 36 * (size_t)s->body_count * s->body_count;
    write_wrenches(s, bodies, wrench);
    if (damping) memset(damping, 0, size * sizeof *damping);
    if (!stiffness) return DTTMM_OK;
    memset(stiffness, 0, size * sizeof *stiffness);
    for (uint32_t l = 0; l < s->link_count; ++l) {
        const struct node *ends[2] = {&s->nodes[s->links[l].from], &s->nodes[s->links[l].to]};
        double G[2][3][6] = {{{0}}}; /* motion of an end by that of its body: x' + w x arm */
        for (int a = 0; a < 2; ++a)
            for (int i = 0; i < 3 && ends[a]->kind == DTTMM_NODE_ON_BODY; ++i) {
                const int j = (i + 1) % 3, k = (i + 2) % 3;
                const double *x = bodies[ends[a]->index].position;
                G[a][i][i] = 1;
                G[a][i][3 + j] = place(ends[a], bodies, k) - x[k];
                G[a][i][3 + k] = -(place(ends[a], bodies, j) - x[j]);
            }
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b) {
                if (ends[a]->kind != DTTMM_NODE_ON_BODY || ends[b]->kind != DTTMM_NODE_ON_BODY) continue;
                double *block = stiffness + 36 * ((size_t)ends[a]->index * s->body_count + ends[b]->index);
                for (int i = 0; i < 3; ++i)
                    for (int m = 0; m < 6; ++m)
                        for (int n = 0; n < 6; ++n)
                            block[6 * m + n] += (a == b ? 1 : -1) * s->links[l].stiffness * G[a][i][m] * G[b][i][n];
            }
    }
    return DTTMM_OK;
}

/* The forces of the links on the inner nodes at t_n. */
static void gather_forces(dttmm_instance *s) {
    for (uint32_t n = 0; n < s->node_count; ++n) memset(s->nodes[n].f, 0, sizeof s->nodes[n].f);
    for (uint32_t l = 0; l < s->link_count; ++l)
        for (int i = 0; i < 3; ++i) {
            const double f = link_force(s, &s->links[l], NULL, i);
            s->nodes[s->links[l].from].f[i] += f;
            s->nodes[s->links[l].to].f[i] -= f;
        }
}

static double acceleration(const dttmm_instance *s, const struct node *node, int i) {
    return node->fixed >> i & 1 ? 0 : s->gravity[i] + (node->f[i] + node->load[i]) / node->mass;
}

/* Nodes on bodies: where they are at t_n, and in place of a velocity their arms there. */
static void take_bodies(dttmm_instance *s, const dttmm_motion *bodies) {
    for (uint32_t n = 0; n < s->node_count; ++n) {
        struct node *node = &s->nodes[n];
        for (int i = 0; i < 3 && node->kind == DTTMM_NODE_ON_BODY; ++i) {
            node->x[i] = place(node, bodies, i);
            node->v[i] = node->x[i] - bodies[node->index].position[i];
        }
    }
}

static dttmm_status start(dttmm_instance *s, const dttmm_step *step, const dttmm_motion *bodies, const double *accelerations,
                          const double *loads, dttmm_error *error) {
    (void)accelerations, (void)error;
    s->h = step->size;
    for (uint32_t n = 0; n < s->node_count; ++n) {
        struct node *node = &s->nodes[n];
        memcpy(node->x, node->rest, sizeof node->x);
        for (int i = 0; i < 3; ++i)
            node->load[i] = loads && node->kind == DTTMM_NODE_INNER ? loads[6 * node->index + (size_t)i] : 0;
        node->work = 0;
        node->power = NAN; /* none before the first instant */
    }
    take_bodies(s, bodies);
    gather_forces(s);
    for (uint32_t n = 0; n < s->node_count; ++n)
        for (int i = 0; i < 3 && s->nodes[n].kind == DTTMM_NODE_INNER; ++i)
            s->nodes[n].v[i] = s->nodes[n].start_velocity[i] - 0.5 * s->h * acceleration(s, &s->nodes[n], i);
    return DTTMM_OK;
}

static dttmm_status begin_step(dttmm_instance *s, const dttmm_step *step, const double *loads, dttmm_error *error) {
    (void)step, (void)error;
    memset(s->end_loads, 0, 6 * s->inner_count * sizeof *s->end_loads);
    if (loads) memcpy(s->end_loads, loads, 6 * s->inner_count * sizeof *loads);
    return DTTMM_OK;
}

static dttmm_status evaluate(const dttmm_instance *s, const dttmm_motion *trial, double *wrench, double *stiffness,
                             dttmm_error *error) {
    (void)trial, (void)error;
    write_wrenches(s, NULL, wrench);
    if (stiffness) memset(stiffness, 0, 36 * (size_t)s->body_count * s->body_count * sizeof *stiffness);
    return DTTMM_OK;
}

static void write_link_outputs(dttmm_instance *s) {
    for (uint32_t l = 0; l < s->link_count; ++l) {
        double *out = s->outputs + LINK_CHANNELS * l;
        out[3] = 0;
        for (int i = 0; i < 3; ++i) {
            out[i] = link_force(s, &s->links[l], NULL, i);
            if (out[i] != 0) out[3] += 0.5 * out[i] * out[i] / s->links[l].stiffness;
        }
    }
}

static dttmm_status commit_step(dttmm_instance *s, const dttmm_motion *accepted, dttmm_error *error) {
    (void)error;
    gather_forces(s);
    write_link_outputs(s);
    double *out = s->outputs + LINK_CHANNELS * s->link_count;
    for (uint32_t n = 0; n < s->node_count; ++n) {
        struct node *node = &s->nodes[n];
        if (node->kind != DTTMM_NODE_INNER) continue;
        double power = 0;
        out[6] = 0;
        for (int i = 0; i < 3; ++i) {
            const double v = node->v[i] + s->h * acceleration(s, node, i), now = 0.5 * (node->v[i] + v);
            power += (node->load[i] + node->mass * s->gravity[i]) * now;
            out[i] = node->x[i];
            out[3 + i] = now;
            out[6] += 0.5 * node->mass * now * now;
            node->v[i] = v;
            node->x[i] += s->h * v;
            node->load[i] = s->end_loads[6 * node->index + (size_t)i];
        }
        if (!isnan(node->power)) node->work += 0.5 * s->h * (node->power + power);
        node->power = power;
        out[7] = node->work;
        out += NODE_CHANNELS;
    }
    take_bodies(s, accepted);
    return DTTMM_OK;
}

static dttmm_status discard_step(dttmm_instance *s, dttmm_error *error) { return (void)s, (void)error, DTTMM_OK; }
static int32_t is_implicit(const dttmm_instance *s) { return (void)s, 0; }

static void load_weights(const dttmm_instance *s, double weights[3]) {
    (void)s;
    weights[0] = weights[2] = 0;
    weights[1] = 1;
}

static uint32_t channel_count(const dttmm_instance *s) { return s->channel_count; }
static const dttmm_channel *channels(const dttmm_instance *s) { return s->channels; }

static dttmm_status outputs(const dttmm_instance *s, double *values, dttmm_error *error) {
    (void)error;
    memcpy(values, s->outputs, s->channel_count * sizeof *values);
    return DTTMM_OK;
}

static const dttmm_plugin plugin = {
    sizeof(dttmm_plugin), DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR, "lumps on springs", "1.0", 2, types, create, destroy, blocks,
    linearise, start, begin_step, evaluate, commit_step, discard_step, is_implicit, load_weights, channel_count, channels,
    outputs, NULL, NULL, NULL, NULL, NULL, NULL};

const dttmm_plugin *dttmm_plugin_entry(uint32_t host_major) { return host_major == DTTMM_PLUGIN_MAJOR ? &plugin : NULL; }
