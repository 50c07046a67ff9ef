/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * The C interface between the dttmm host, which owns the rigid bodies, and a plugin, which solves the elastic network
 * between them. Both halves include this header, those of its extensions (dttmm_modal.h, dttmm_response.h, dttmm_shape.h,
 * dttmm_state.h, dttmm_derivative.h, dttmm_static.h, dttmm_support.h, dttmm_laws.h) and nothing else of each other. Plain
 * C11.
 *
 * Conventions, valid for every declaration below
 * ----------------------------------------------
 * - Units: SI: m, kg, s, rad, N, N m.
 * - Frame: world axes, right-handed, unless a comment says otherwise. Matrices are row-major.
 * - Order: a pose change is [translation x y z; rotation x y z], a wrench [force x y z; moment x y z].
 * - Bodies: poses and velocities are those of their centres of mass. A wrench on a body is about its centre of mass, with
 * the lever arms of the instant at which its forces act: where forces of several instants make up a wrench, each has its
 * own. At every instant they must balance, or angular momentum is lost.
 * - Matrices over the bodies are lists of 6x6 blocks, those that the instance declares (blocks).
 * - Memory: whoever calls owns every buffer it passes; what a plugin returns by pointer lives as long as the instance,
 * unless its comment says less, or, for tables and what they point to, as long as the library stays loaded. No allocated
 * memory crosses.
 * - Errors: every function that can fail returns a dttmm_status; on anything but DTTMM_OK it has filled
 *   *error (which the caller owns and which is never NULL) and the instance is as before the call. No exception crosses.
 * - Threads: one thread at a time per instance; different instances may be used by different threads. No statics.
 * - Phases: create -> [linearise] -> start -> { begin_step -> { [iterate ->] evaluate }* -> commit_step | discard_step }* ->
 *   destroy; after a commit [mean_wrench, stand ->] outputs. A comment in [brackets] names the phases in which a function
 * may be called.
 * - Versions: the tables start with their size. Minor versions append members to them; a host reads only what `size` covers.
 *   The other structures stay as they are within a major version.
 * - Extensions: tables of their own, asked for by name. A plugin has those that it can serve.
 */
#ifndef DTTMM_PLUGIN_H
#define DTTMM_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_PLUGIN_MAJOR 2u
#define DTTMM_PLUGIN_MINOR 2u

/* The one symbol a plugin exports; declared at the end. */
#define DTTMM_PLUGIN_ENTRY "dttmm_plugin_entry"

#if defined(__GNUC__)
#define DTTMM_EXPORT __attribute__((visibility("default")))
#else
#define DTTMM_EXPORT
#endif

typedef int32_t dttmm_status;
enum {
    DTTMM_OK = 0,
    DTTMM_DISCARD = 1,         /* this step cannot be done; the instance is unchanged, the host may discard and retry */
    DTTMM_ERROR_ARGUMENT = -1, /* a null pointer, a size or a value outside its range */
    DTTMM_ERROR_PHASE = -2,    /* called out of order */
    DTTMM_ERROR_MODEL = -3,    /* the network cannot be solved as described: error->element names the element */
    DTTMM_ERROR_SINGULAR = -4, /* a system of transfer equations is singular or badly conditioned */
    DTTMM_ERROR_NUMERIC = -5,  /* a result is not finite */
    DTTMM_ERROR_MEMORY = -6,   /* out of memory */
    DTTMM_ERROR_INTERNAL = -7  /* a fault of the plugin */
};

typedef struct dttmm_error {
    int32_t element; /* index into dttmm_network.elements, or -1 */
    char text[508];  /* UTF-8, zero-terminated: place, fault, cure */
} dttmm_error;

/* ---- Element types, declared as data: the host checks the model file against them and converts the units ---- */

enum {
    DTTMM_PARAMETER_REQUIRED = 1u,   /* the model must give it; otherwise default_value stands for every number */
    DTTMM_PARAMETER_SPREADS = 2u,    /* a single number in the model stands for all `count` numbers */
    DTTMM_PARAMETER_INTEGER = 4u,    /* whole numbers only */
    DTTMM_PARAMETER_WORDS_ONLY = 8u, /* one of `words`, never a number */
    /* Rows of numbers, the first column ascending, from a file or the model: one row after the other, two at least, then not
     * a number up to `count`. `unit` names the columns: "frequency [Hz]; force [N]". */
    DTTMM_PARAMETER_TABLE = 16u
};

/* A text that stands for a number: "free" for 0, "rigid" for infinity. The only way to a value that is not finite. */
typedef struct dttmm_word {
    const char* name;
    double value;
} dttmm_word;

typedef struct dttmm_parameter {
    const char* name;        /* the key in the model file; "section.tube" is the key tube of the table section = { ... } */
    const char* unit;        /* as UDUNITS-2 reads it, e.g. "N/m"; "1" for a pure number */
    uint32_t count;          /* how many numbers, at least 1; 1 where there are words */
    uint32_t flags;          /* DTTMM_PARAMETER_... */
    double default_value;    /* SI; not a number tells the plugin that the model does not give it */
    double minimum, maximum; /* SI, both included, for numbers; these are finite whatever the bounds. A minimum of DBL_MIN
                                is told to the user as "more than zero" */
    const dttmm_word* words; /* that the model may write in place of a number; NULL: none */
    uint32_t word_count;
    const char* documentation; /* one line */
} dttmm_parameter;

/* How an element hangs on its nodes. */
enum {
    DTTMM_ENDS_FROM_TO = 0, /* the keys `from` and `to`: two nodes */
    DTTMM_ENDS_AT = 1,      /* the key `at`: one node, or a list of them */
    DTTMM_ENDS_ALONG = 2,   /* the keys `from` and `to`: two nodes apart, and x along the line between them */
    DTTMM_ENDS_LINE = 3     /* the same, and forces per length may act on the line (dttmm_line_load) */
};

typedef struct dttmm_element_type {
    const char* name; /* the `type` of the model file */
    uint32_t ends;    /* DTTMM_ENDS_... */
    uint32_t parameter_count;
    const dttmm_parameter* parameters;
    const char* documentation; /* one line */
} dttmm_element_type;

/* ---- The network: all elements of the model that are of this plugin, and the bodies between them ---- */

/* A rigid body of the host at the start. */
typedef struct dttmm_body {
    const char* name;
    double position[3]; /* of the centre of mass [m] */
    double rotation[9]; /* of the body's axes: v_world = rotation * v_body */
    double mass;        /* [kg] */
    double inertia[9];  /* about the centre of mass, world axes [kg m^2] */
} dttmm_body;

enum {
    DTTMM_NODE_GROUND = 0,  /* fixed in the world */
    DTTMM_NODE_ON_BODY = 1, /* a point of a body */
    DTTMM_NODE_INNER = 2    /* a point of the network: moves as the elements have it */
};

typedef struct dttmm_node {
    const char* name;
    uint32_t kind;      /* DTTMM_NODE_... */
    uint32_t body;      /* of DTTMM_NODE_ON_BODY: index into dttmm_network.bodies */
    double position[3]; /* at the start [m] */
    double rotation[9]; /* axes of the node in the world at the start: v_world = rotation * v_node */
    /* Of inner nodes only: */
    uint32_t fixed; /* bit d set: direction d of x y z rx ry rz (world axes) is held where it is at the start */
    int32_t moves;  /* non-zero: it starts with the velocities below; otherwise as straining the network least */
    double velocity[3], angular_velocity[3];
} dttmm_node;

typedef struct dttmm_element {
    const char* name;
    uint32_t type;        /* index into dttmm_plugin.element_types */
    uint32_t end_count;   /* 2 for DTTMM_ENDS_FROM_TO */
    const uint32_t* ends; /* indices into dttmm_network.nodes: from and to, or those of `at` */
    const double* values; /* the numbers of all parameters of the type, in the order declared */
} dttmm_element;

/* In which axes a force per length is given. */
enum {
    DTTMM_AXES_WORLD = 0,
    DTTMM_AXES_ELEMENT = 1 /* local axes of the element at the start; they turn with each of its parts: a follower load */
};

/* A force per length on an element of DTTMM_ENDS_LINE. It acts on the axis of the element. It is linear between the values
 * at the two ends, over the length at the start: its resultant does not change when the element stretches. */
typedef struct dttmm_line_load {
    uint32_t element; /* index into dttmm_network.elements */
    uint32_t axes;    /* DTTMM_AXES_... */
} dttmm_line_load;

/* The time scheme. Centred: every quantity of the network stands at t_n, the middle of three instants,
 *     x'' = (x+ - 2x + x-)/h^2,   x' = (gamma x+ + (1 - 2 gamma) x + (gamma - 1) x-)/h,
 *     elastic forces weighted  beta (.)+ + (1/2 + gamma - 2 beta) (.) + (1/2 - gamma + beta) (.)-,
 * and of these weights the even part, 1/4 + beta - gamma/2 at either side, goes with the directions that each force had at
 * its instant and its lever arm about the centre of mass then. Dampers, and the odd part, (gamma - 1/2)/2, act by the
 * increments of the deformation over the two steps around t_n: gamma (x+ - x)/h with the directions and lever arms of
 * t_(n+1), (1 - gamma) (x - x-)/h with those of t_(n-1). The derivative by the end of the step is then symmetric. Its first
 * step after start is Newmark's from x, x', x'': the elastic force before the start counts as that at the start, and x' =
 * gamma (x+ - x)/h + (1 - gamma) x'(0) + (beta - gamma/2) h x''(0). The others are explicit: the wrench over the step is the
 * force law at t_n, the velocity in it from the named formula; the past before the start is the parabola x(0) + t x'(0) +
 * t^2/2 x''(0). Where a formula wants the previous velocity (Fox-Euler), it is the host's, the mean of those over the two
 * steps around t_(n-1): never the formula's own last result, which a leap-frog host would drive unstable.
 */
enum {
    DTTMM_SCHEME_CENTRED = 0,
    DTTMM_SCHEME_FOX_EULER = 1,
    DTTMM_SCHEME_BDF1 = 2,
    DTTMM_SCHEME_BDF2 = 3,
    DTTMM_SCHEME_HOUBOLT = 4,
    DTTMM_SCHEME_PARK = 5
};

typedef struct dttmm_network {
    uint32_t body_count;
    const dttmm_body* bodies; /* all bodies of the model */
    uint32_t node_count;
    const dttmm_node* nodes;
    uint32_t element_count;
    const dttmm_element* elements;
    uint32_t scheme;    /* DTTMM_SCHEME_... */
    double beta, gamma; /* of the centred scheme */
    double gravity[3];  /* on the masses of the network [m/s^2] */
    uint32_t line_load_count;
    const dttmm_line_load* line_loads; /* their values come with those on the inner nodes. No part of linearise, take_up, the
                                          modes or the response */
    uint32_t support_count;
    const uint32_t* supports; /* inner nodes that the host moves in their fixed directions, ascending (dttmm_support.h). To
                                 the modes and the response they are at rest */
    /* Where the plugin may write the index of the element it works on, for whoever reports a crash. It lives as long as the
     * instance; NULL: not wanted. */
    volatile int32_t* at_work;
    uint32_t mean_velocities; /* 1: in some rows or in all the velocities that the host gives `stand` are the means of those
                                 over the two steps around the instant, in every scheme. What depends on velocities
                                 between bodies and inner nodes must be computed from means too */
} dttmm_network;

typedef struct dttmm_instance dttmm_instance;

/* A block of the matrices over the bodies: what of the wrench on body `row` hangs on the pose of body `column`. */
typedef struct dttmm_block {
    uint32_t row, column;
} dttmm_block;

/* Motion of a body at the end of a step of size h. The velocities are those over the step: `position` has moved by
 * h * velocity, `rotation` has turned by the rotation vector h * angular_velocity (world axes).
 * In linearise and start, which have no step before them: the velocities at that instant. */
typedef struct dttmm_motion {
    double position[3];
    double rotation[9];
    double velocity[3];
    double angular_velocity[3];
} dttmm_motion;

typedef struct dttmm_step {
    uint64_t index; /* n */
    double time;    /* t_n, the start of the step [s] */
    double size;    /* h [s], the same from start to the next start */
} dttmm_step;

/* How far an iteration has brought a part of a plugin: the host judges by it. */
typedef struct dttmm_progress {
    double correction; /* the largest speed of a point that this iteration changes [m/s] */
    double previous;   /* that of the iteration before with the move of the bodies since; 0: the first of the step [m/s] */
    double motion;     /* the largest speed of a point over the step [m/s] */
    double enough;     /* a correction that is not larger is rounding [m/s] */
    double residual;   /* the largest momentum that lacked before this iteration, but for what is rounding [N s] */
    double impulse;    /* the largest of an element over the step [N s] */
    int32_t is_new;    /* non-zero: rates of convergence of other steps do not apply to this step, nor its rates to them;
                          if positive: number of matrices formed in this step so far */
    int32_t element;   /* which is worst; -1: unknown */
} dttmm_progress;

/* What a channel belongs to and what becomes of it: a column of the results, by default or only when asked for; or a part of
 * the host's energy ledger, in joules. */
enum { DTTMM_OF_ELEMENT = 0, DTTMM_OF_NODE = 1 };
enum {
    DTTMM_ROLE_RESULT = 0,
    DTTMM_ROLE_ON_REQUEST = 1,
    DTTMM_ROLE_STRAIN_ENERGY = 2,
    DTTMM_ROLE_KINETIC_ENERGY = 3,
    DTTMM_ROLE_DISSIPATED_ENERGY = 4, /* since the start */
    DTTMM_ROLE_WORK = 5,              /* of gravity and of the loads on the network, since the start */
    DTTMM_ROLE_LIMIT = 6 /* share of what the element's law holds for. Recorded when asked for; the host warns where it
                            exceeds 1 */
};

typedef struct dttmm_channel {
    const char* name; /* e.g. "force.x": the column is called <element or node>.force.x */
    const char* unit;
    uint32_t of;    /* DTTMM_OF_... */
    uint32_t index; /* into dttmm_network.elements or .nodes */
    uint32_t role;  /* DTTMM_ROLE_... */
} dttmm_channel;

typedef struct dttmm_plugin {
    uint32_t size;         /* sizeof(dttmm_plugin) as the plugin was compiled */
    uint32_t major, minor; /* DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR as the plugin was compiled */
    const char* name;
    const char* version;
    uint32_t element_type_count;
    const dttmm_element_type* element_types;

    /* Builds the instance for a network. Copies what it needs: the description may go after the call. Structural faults are
     * found here; motions that nothing determines at the latest by the first step. On failure *instance is NULL. */
    dttmm_status (*create)(const dttmm_network* network, dttmm_instance** instance, dttmm_error* error);

    /* Frees an instance; NULL is allowed. [any] */
    void (*destroy)(dttmm_instance* instance);

    /* The blocks of all matrices over the bodies, each pair once: the pairs of bodies, and bodies with themselves, whose
     * forces hang on each other; with (i, j) also (j, i). *count: how many. [after create] */
    const dttmm_block* (*blocks)(const dttmm_instance* instance, uint32_t* count);

    /* The force law at one instant, no time scheme in it: wrench (6 per body) at the given poses and velocities and, where
     * not NULL, stiffness = -d(wrench)/d(pose) and damping = -d(wrench)/d(velocity), 36 numbers per block, row-major.
     * What stems from a force already acting only changing its direction may be left out. Pure. [after create] */
    dttmm_status (*linearise)(const dttmm_instance* instance, const dttmm_motion* bodies, double* wrench, double* stiffness,
                              double* damping, dttmm_error* error);

    /* Sets the memory of the scheme to the initial conditions at step->time: poses, velocities and accelerations of the
     * bodies (6 per body: linear, angular) at that instant, and the loads on the network then. [after create; may be
     * called again to start anew] */
    dttmm_status (*start)(dttmm_instance* instance, const dttmm_step* step, const dttmm_motion* bodies,
                          const double* accelerations, const double* loads, dttmm_error* error);

    /* Opens the step from step->time to step->time + step->size. `loads`: 6 per inner node (wrench in world axes, at the
     * node), then 6 per line load (force per length at the `from` end, at the `to` end [N/m]), as they are at the end of the
     * step; NULL: none. [after start, no step open] */
    dttmm_status (*begin_step)(dttmm_instance* instance, const dttmm_step* step, const double* loads, dttmm_error* error);

    /* The wrench on every body (6 per body) that acts over the open step if the bodies end it as in `trial`, and, where not
     * NULL, stiffness = -d(wrench)/d(trial pose), 36 numbers per block. The host uses it to find the end of the step; an
     * approximation costs passes, not accuracy. Pure: any number of calls in any order. [step open] */
    dttmm_status (*evaluate)(const dttmm_instance* instance, const dttmm_motion* trial, double* wrench, double* stiffness,
                             dttmm_error* error);

    /* Ends the open step with the motion the host accepted: the only call that moves time. [step open] */
    dttmm_status (*commit_step)(dttmm_instance* instance, const dttmm_motion* accepted, dttmm_error* error);

    /* Ends the open step as if it had not been begun. [step open] */
    dttmm_status (*discard_step)(dttmm_instance* instance, dttmm_error* error);

    /* Non-zero when evaluate depends on its trial: the host has to solve for the end of the step. [after create] */
    int32_t (*is_implicit)(const dttmm_instance* instance);

    /* How external loads are to be weighted over a step, so that they stand at the instant the network's forces stand at:
     * weights[0] at the end of the step, [1] at its start, [2] one step before. [after create] */
    void (*load_weights)(const dttmm_instance* instance, double weights[3]);

    /* Named results. The values stand at the start t_n of the step last committed, the latest instant whose centred
     * velocity is known. An element's force is positive when its `to` end is displaced in the positive direction relative
     * to `from`, in the axes of the `from` end. The host reads the list once: the plugin may drop it, with its texts, when
     * it has started, and returns NULL then. [channel_count: after create; channels: after create, before start; outputs:
     * after a commit] */
    uint32_t (*channel_count)(const dttmm_instance* instance);
    const dttmm_channel* (*channels)(const dttmm_instance* instance);
    dttmm_status (*outputs)(const dttmm_instance* instance, double* values, dttmm_error* error);

    /* The table of an extension, by the name in its header; NULL: the plugin has it not. The member itself may be NULL. */
    const void* (*extension)(const char* name);

    /* Both NULL: what the plugin answers hangs on the trial alone. Otherwise it has parts that find a motion of their own
     * inside, together with the host: how many. [after create] */
    uint32_t (*part_count)(const dttmm_instance* instance);
    /* One iteration of every part towards the end of the open step, the bodies ending it as in `trial`; progress: takes how
     * far each has come. The host says so before every evaluate of an implicit network, and goes on until bodies and parts
     * have converged. evaluate then answers from where the parts have come to: the wrench that the iteration leads to, for
     * other trials as far as a linear answer reaches, with the stiffness of the bodies on the parts that follow. It is pure
     * from one iteration to the next. commit_step takes the motion that the last one leads to. After an error the step can
     * only be discarded. [step open] */
    dttmm_status (*iterate)(dttmm_instance* instance, const dttmm_motion* trial, dttmm_progress* progress,
                            dttmm_error* error);

    /* NULL: the host takes the mean of the velocities over the two steps around an instant as the velocity there, and
     * linearise for the wrench. They serve rows of results only, which are to be in balance: mass times acceleration equals
     * loads plus the forces recorded at that instant.
     *
     * The mean wrench on the bodies (6 per body) over the step last committed: the mean of the elastic forces at its two
     * ends, dampers at the mean rate. From it the host finds the velocities at its start, v_n = (velocity over the step)
     * - h/2 (mean wrench)/mass, Newmark's for beta = 1/4, gamma = 1/2. For others it takes means. [after a commit] */
    dttmm_status (*mean_wrench)(dttmm_instance* instance, double* wrench, dttmm_error* error);
    /* What stands at t_n when the bodies have the poses and the velocities of `bodies` there; wrench: on them at that
     * instant. outputs() are then of that instant. accelerations: of the bodies there (6 per body), in the first row; else
     * NULL. The host asks until they are those that follow from the wrench. The wrench may depend on them where masses
     * inside are joined rigidly to bodies: linearly, by a symmetric matrix, as inertia. [after mean_wrench of the same step;
     * of an explicit scheme after a commit] */
    dttmm_status (*stand)(dttmm_instance* instance, const dttmm_motion* bodies, const double* accelerations, double* wrench,
                          dttmm_error* error);

    /* NULL: unknown. What every element takes up in a small motion of the bodies from where they start (6 per body): u K u
     * and u C u of its stiffness and its damping, inner nodes following without inertia. Tells the user which elements make
     * a motion. [after create] */
    dttmm_status (*take_up)(const dttmm_instance* instance, const double* motion, double* elastic, double* damped,
                            dttmm_error* error);
} dttmm_plugin;

/* The entry, exported as DTTMM_PLUGIN_ENTRY: the table, or NULL if the plugin does not speak the host's major version. */
typedef const dttmm_plugin* (*dttmm_plugin_entry_function)(uint32_t host_major);
DTTMM_EXPORT const dttmm_plugin* dttmm_plugin_entry(uint32_t host_major);

#ifdef __cplusplus
}
#endif
#endif
