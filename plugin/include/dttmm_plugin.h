/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * The C interface between the dttmm host, which owns the rigid bodies, and a plugin, which solves the elastic network
 * between them. Both halves include this header and nothing else of each other. Plain C11.
 *
 * Conventions, valid for every declaration below
 * ----------------------------------------------
 * - Units: SI: m, kg, s, rad, N, N m.
 * - Frame: world axes, right-handed, unless a comment says otherwise. Matrices are row-major.
 * - Order: a pose change is [translation x y z; rotation x y z], a wrench [force x y z; moment x y z].
 * - Wrench of a port: acts on the host's body, at the port's position at t_n, the start of the step (linearise: at the given
 *   instant). Where the forces of one instant make it up, those on all ports must balance there, or angular momentum is
 *   lost; where those of several do, each must balance at its own.
 * - Memory: whoever calls owns every buffer it passes; what a plugin returns by pointer lives as long as the instance or,
 *   for the table and what it points to, as long as the library stays loaded. No allocated memory crosses.
 * - Errors: every function that can fail returns a dttmm_status; on anything but DTTMM_OK (and DTTMM_AGAIN) it has filled
 *   *error (which the caller owns and which is never NULL) and the instance is as before the call. No exception crosses.
 * - Threads: one thread at a time per instance; different instances may be used by different threads. No statics.
 * - Phases: create -> [linearise] -> start -> { begin_step -> { [expect ->] evaluate }* -> commit_step | discard_step }* ->
 *   destroy; after a commit [mean_wrench, stand ->] outputs. A comment in [brackets] names the phases in which a function
 * may be called.
 * - Versions: the table starts with its size and version. Minor versions append members to it; a host reads only what `size`
 *   covers. The other structures stay as they are within a major version.
 */
#ifndef DTTMM_PLUGIN_H
#define DTTMM_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_PLUGIN_MAJOR 1u
#define DTTMM_PLUGIN_MINOR 5u

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
    DTTMM_AGAIN = 2,           /* only of expect: call it again before the step is committed */
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
    DTTMM_PARAMETER_REQUIRED = 1u,  /* the model must give it; otherwise default_value stands for every number */
    DTTMM_PARAMETER_SPREADS = 2u,   /* a single number in the model stands for all `count` numbers */
    DTTMM_PARAMETER_INTEGER = 4u,   /* whole numbers only */
    DTTMM_PARAMETER_WORDS_ONLY = 8u /* one of `words`, never a number */
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
    DTTMM_ENDS_ALONG = 2    /* since minor 5: the keys `from` and `to`: two nodes apart, and x along the line between them */
};

typedef struct dttmm_element_type {
    const char* name; /* the `type` of the model file */
    uint32_t ends;    /* DTTMM_ENDS_... */
    uint32_t parameter_count;
    const dttmm_parameter* parameters;
    const char* documentation; /* one line */
} dttmm_element_type;

/* ---- The network: a connected set of elements, solved together ---- */

enum {
    DTTMM_NODE_GROUND = 0, /* fixed in the world */
    DTTMM_NODE_PORT = 1,   /* moves with a body of the host */
    DTTMM_NODE_INNER = 2   /* a point of the network: moves as the elements have it */
};

typedef struct dttmm_node {
    const char* name;
    uint32_t kind;      /* DTTMM_NODE_... */
    double position[3]; /* at the start [m] */
    double rotation[9]; /* axes of the node in the world at the start: v_world = rotation * v_node */
    /* Of inner nodes only: */
    uint32_t fixed; /* bit d set: direction d of x y z rx ry rz (world axes) is held where it is at the start */
    int32_t moves;  /* non-zero: it starts with the velocities below; otherwise as straining the network least */
    double velocity[3], angular_velocity[3];
    /* Of ports only: from the centre of mass of the body to the node, in the axes of the node. A scheme that weighs forces
     * of several instants can give each the lever arm of its own; nothing else needs it. */
    double arm[3];
} dttmm_node;

typedef struct dttmm_element {
    const char* name;
    uint32_t type;        /* index into dttmm_plugin.element_types */
    uint32_t end_count;   /* 2 for DTTMM_ENDS_FROM_TO */
    const uint32_t* ends; /* indices into dttmm_network.nodes: from and to, or those of `at` */
    const double* values; /* the numbers of all parameters of the type, in the order declared */
} dttmm_element;

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
    uint32_t node_count;
    const dttmm_node* nodes; /* port p of every call below is the p-th node of kind DTTMM_NODE_PORT */
    uint32_t element_count;
    const dttmm_element* elements;
    uint32_t scheme;    /* DTTMM_SCHEME_... */
    double beta, gamma; /* of the centred scheme */
    double gravity[3];  /* on the masses of the network [m/s^2] */
} dttmm_network;

typedef struct dttmm_instance dttmm_instance;

/* Motion of a port at the end of a step of size h. The velocities are those over the step: `position` has moved by
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

/* What a channel belongs to and what becomes of it: a column of the results, by default or only when asked for; or a part of
 * the host's energy ledger, in joules. */
enum { DTTMM_OF_ELEMENT = 0, DTTMM_OF_NODE = 1 };
enum {
    DTTMM_ROLE_RESULT = 0,
    DTTMM_ROLE_ON_REQUEST = 1,
    DTTMM_ROLE_STRAIN_ENERGY = 2,
    DTTMM_ROLE_KINETIC_ENERGY = 3,
    DTTMM_ROLE_DISSIPATED_ENERGY = 4, /* since the start */
    DTTMM_ROLE_WORK = 5,              /* of gravity and of the loads on inner nodes, since the start */
    DTTMM_ROLE_LIMIT = 6 /* since minor 4: share of what the element's law holds for. Recorded when asked for; the host
                            warns where it exceeds 1 */
};

typedef struct dttmm_channel {
    const char* name; /* e.g. "force.x": the column is called <element or node>.force.x */
    const char* unit;
    uint32_t of;    /* DTTMM_OF_... */
    uint32_t index; /* into dttmm_network.elements or .nodes */
    uint32_t role;  /* DTTMM_ROLE_... */
} dttmm_channel;

/* ---- Small vibrations about the start: natural frequencies, shapes, frequency response (minor 1) ---- */

/* A rigid body of the host at the start. */
typedef struct dttmm_body {
    const char* name;
    double position[3]; /* of the centre of mass [m] */
    double mass;        /* [kg] */
    double inertia[9];  /* about the centre of mass, world axes [kg m^2] */
} dttmm_body;

/* An ideal joint between two bodies, or a body and the ground. */
typedef struct dttmm_constraint {
    int32_t first, second; /* indices into dttmm_modal_model.bodies; -1: the ground */
    double position[3];    /* the point of both at the start [m] */
    double axes[9];        /* v_world = axes * v_joint */
    uint32_t rigid;        /* bit d set: direction d of x y z rx ry rz (of these axes) does not give */
} dttmm_constraint;

typedef struct dttmm_modal_model {
    const dttmm_network* network; /* all elements of the machine; may be without nodes and elements */
    uint32_t body_count;
    const dttmm_body* bodies;
    const uint32_t* port_bodies; /* the body of every port of the network */
    uint32_t constraint_count;
    const dttmm_constraint* constraints;
    uint32_t directions;   /* bit d set: bodies and nodes move in direction d of x y z rx ry rz (world axes) */
    uint32_t lumped_beams; /* non-zero: beams as the time solver has them, otherwise exact */
} dttmm_modal_model;

typedef struct dttmm_modal dttmm_modal;

/* A natural frequency. Equal ones are listed once each, rigid-body modes first. */
typedef struct dttmm_mode {
    double frequency; /* [Hz]; 0 for a rigid-body mode */
    double bracket; /* the count of frequencies changes by the multiplicity within this relative distance, and what rounding
                       of stiff parts may have moved lies within it too */
    uint32_t multiplicity;
    double residual;         /* smallest singular value of the overall transfer matrix as share of what it is 0.1 % beside;
                                where the machine is too large for that, what the quotient leaves by which the frequency was
                                refined */
    double mass;             /* modal mass of the shape as scaled: its largest displacement is 1 m [kg]. Shapes of equal
                                frequencies are at right angles by mass. */
    double participation[6]; /* share of the moved mass or inertia (about the origin) that takes part per direction */
} dttmm_mode;

/* The overall transfer equation U_all Z_all = 0 at a frequency. */
typedef struct dttmm_overall {
    uint32_t rows, columns;         /* before the known boundary entries are struck out */
    double smallest;                /* singular value as share of the largest, in balanced units */
    double sign, log10_determinant; /* of the square matrix that is left */
} dttmm_overall;

struct dttmm_law; /* dttmm_law.h */

typedef struct dttmm_plugin {
    uint32_t size;         /* sizeof(dttmm_plugin) as the plugin was compiled */
    uint32_t major, minor; /* DTTMM_PLUGIN_MAJOR, DTTMM_PLUGIN_MINOR as the plugin was compiled */
    const char* name;
    const char* version;
    uint32_t element_type_count;
    const dttmm_element_type* element_types;

    /* Builds an instance for a network. Copies what it needs: the description may go after the call. Structural faults are
     * found here. On failure *instance is NULL. */
    dttmm_status (*create)(const dttmm_network* network, dttmm_instance** instance, dttmm_error* error);

    /* Frees an instance; NULL is allowed. [any] */
    void (*destroy)(dttmm_instance* instance);

    /* The force law at one instant, no time scheme in it: wrench (6 per port) at the given poses and velocities and, where
     * not NULL, stiffness = -d(wrench)/d(pose) and damping = -d(wrench)/d(velocity), each 6P x 6P row-major for P ports.
     * What stems from a force already acting only changing its direction may be left out. Pure. [after create] */
    dttmm_status (*linearise)(const dttmm_instance* instance, const dttmm_motion* ports, double* wrench, double* stiffness,
                              double* damping, dttmm_error* error);

    /* Sets the memory of the scheme to the initial conditions at step->time: poses, velocities and accelerations of the
     * ports (6 per port: linear, angular) at that instant, and the loads on the inner nodes then. [after create; may be
     * called again to start anew] */
    dttmm_status (*start)(dttmm_instance* instance, const dttmm_step* step, const dttmm_motion* ports,
                          const double* accelerations, const double* loads, dttmm_error* error);

    /* Opens the step from step->time to step->time + step->size. `loads`: 6 per inner node (wrench in world axes, at the
     * node) as they are at the end of the step; NULL: none. [after start, no step open] */
    dttmm_status (*begin_step)(dttmm_instance* instance, const dttmm_step* step, const double* loads, dttmm_error* error);

    /* The wrench on every port (6 per port) that acts over the open step if the ports end it as in `trial`, and, where not
     * NULL, stiffness = -d(wrench)/d(trial pose), 6P x 6P row-major. The host uses it to find the end of the step; an
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

    /* The whole state that changes from step to step, exact to the bit; restored only into an instance of the same network,
     * started with the same step size. [after start, no step open] */
    size_t (*state_size)(const dttmm_instance* instance);
    dttmm_status (*save_state)(const dttmm_instance* instance, void* buffer, size_t size, dttmm_error* error);
    dttmm_status (*restore_state)(dttmm_instance* instance, const void* buffer, size_t size, dttmm_error* error);

    /* Named results. The values stand at the start t_n of the step last committed, the latest instant whose centred
     * velocity is known. An element's force is positive when its `to` end is displaced in the positive direction relative
     * to `from`, in the axes of the `from` end. [channels: after create; outputs: after a commit] */
    uint32_t (*channel_count)(const dttmm_instance* instance);
    const dttmm_channel* (*channels)(const dttmm_instance* instance);
    dttmm_status (*outputs)(const dttmm_instance* instance, double* values, dttmm_error* error);

    /* Since minor 1; NULL: the plugin cannot. Builds the linear model; on failure *modal is NULL. Its description may go
     * after the call. */
    dttmm_status (*create_modal)(const dttmm_modal_model* model, dttmm_modal** modal, dttmm_error* error);
    void (*destroy_modal)(dttmm_modal* modal);

    /* Finds all natural frequencies up to `below` [Hz], or, where `below` is 0, the first `count` (more where the last is
     * multiple); proves by an independent count that none is missing. */
    dttmm_status (*find_modes)(dttmm_modal* modal, uint32_t count, double below, uint32_t* found, dttmm_error* error);
    /* One of them, and its shape: 6 per body (at its centre of mass), 6 per node of the network; shares of its strain
     * energy, one per element. Any pointer may be NULL. */
    dttmm_status (*mode)(dttmm_modal* modal, uint32_t index, dttmm_mode* mode, double* bodies, double* nodes, double* shares,
                         dttmm_error* error);
    /* Displacement [6, world] of a mode at `count` equally spaced stations of a beam, its ends included; *length: of the
     * beam, 0 for an element that is no line. */
    dttmm_status (*mode_along)(dttmm_modal* modal, uint32_t index, uint32_t element, uint32_t count, double* length,
                               double* shape, dttmm_error* error);

    /* The overall transfer equation, and how it is laid out as a zero-terminated text of at most `size` bytes (NULL: not
     * wanted). */
    dttmm_status (*overall)(dttmm_modal* modal, double frequency, dttmm_overall* overall, char* layout, uint32_t size,
                            dttmm_error* error);

    /* Steady motion under unit harmonic wrenches, damping as the elements have it: `force` (6: force and moment, world) at
     * a point of body `on_body`, or of node `on_node` of the network (the other is -1); response: displacement per newton as
     * real and imaginary part, 12 per body and 12 per node. */
    dttmm_status (*respond)(dttmm_modal* modal, double frequency, int32_t on_body, int32_t on_node, const double* point,
                            const double* force, double* bodies, double* nodes, dttmm_error* error);

    /* Since minor 2; NULL: the plugin need not know. The ports will end the open step near `trial`; told before every
     * evaluate of an implicit network, as the host comes to know it. The plugin may move there the point from which it works
     * out its answers, which then differ by what it takes for good enough; evaluate stays pure from one such call to the
     * next. On an error its answers are again those of a step of which it has been told nothing. Returns DTTMM_AGAIN where
     * they are still rough: good enough for a trial, but to be told once more before the step is committed. Who always says
     * so ends the run. [step open] */
    dttmm_status (*expect)(dttmm_instance* instance, const dttmm_motion* trial, dttmm_error* error);

    /* Since minor 3; NULL: the host takes the mean of the velocities over the two steps around an instant as the velocity
     * there, and linearise for the wrench. They serve rows of results only, which are to be in balance: mass times
     * acceleration equals loads plus the forces recorded at that instant.
     *
     * The mean wrench on the ports (6 per port) over the step last committed: the mean of the elastic forces at its two
     * ends, dampers at the mean rate. From it the host finds the velocities at the start t_n of that step,
     * v_n = (velocity over the step) - h/2 (mean wrench)/mass, which are Newmark's own. [after a commit] */
    dttmm_status (*mean_wrench)(dttmm_instance* instance, double* wrench, dttmm_error* error);
    /* What stands at t_n when the ports have the poses and the velocities of `ports` there; wrench: on the ports at that
     * instant. outputs() are then of that instant. [after mean_wrench of the same step; of an explicit scheme after a
     * commit] */
    dttmm_status (*stand)(dttmm_instance* instance, const dttmm_motion* ports, double* wrench, dttmm_error* error);

    /* Since minor 5; NULL: no element does. The force that an element has at the start and whose stiffness is in the modes
     * [N], positive in tension; 0: none. [after create_modal] */
    double (*force_at_start)(const dttmm_modal* modal, uint32_t element);

    /* Since minor 5; NULL: its elements take no laws but their own. Adds a force law (dttmm_law.h) to those that its
     * elements may have; the library of the law stays loaded. Afterwards the element types may have more parameters: they
     * are to be read anew. *at_work is the law while it is asked, NULL otherwise: for whoever reports a crash. [before a
     * model is read] */
    dttmm_status (*add_law)(const struct dttmm_law* law, const struct dttmm_law* volatile* at_work, dttmm_error* error);
} dttmm_plugin;

/* The entry, exported as DTTMM_PLUGIN_ENTRY: the table, or NULL if the plugin does not speak the host's major version. */
typedef const dttmm_plugin* (*dttmm_plugin_entry_function)(uint32_t host_major);
DTTMM_EXPORT const dttmm_plugin* dttmm_plugin_entry(uint32_t host_major);

#ifdef __cplusplus
}
#endif
#endif
