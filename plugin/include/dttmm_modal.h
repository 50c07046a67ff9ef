/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "modal": small vibrations about the start, their natural frequencies and shapes.
 */
#ifndef DTTMM_MODAL_H
#define DTTMM_MODAL_H

#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_MODAL "dttmm.modal"

/* An ideal joint between two bodies, or a body and the ground. */
typedef struct dttmm_constraint {
    int32_t first, second; /* indices into dttmm_network.bodies; -1: the ground */
    double position[3];    /* the point of both at the start [m] */
    double axes[9];        /* v_world = axes * v_joint */
    uint32_t rigid;        /* bit d set: direction d of x y z rx ry rz (of these axes) does not give */
} dttmm_constraint;

/* A machine at rest that vibrates about its equilibrium. Stiffness: -d(wrench)/d(pose), symmetric, at the centres of mass,
 * world axes, row-major. */
typedef struct dttmm_rest {
    const dttmm_instance* instance; /* of the same elements, where statics have led (dttmm_static.h) */
    const dttmm_motion* bodies;     /* there */
    const double* loads;            /* 36 per body: what loads on it add as their lever arms turn */
    const double* constraints;      /* 144 per constraint: what its forces add, by the motion of [first; second] */
    double factor;                  /* all forces count so many times: 1, or a load factor in the search for buckling */
} dttmm_rest;

typedef struct dttmm_modal_model {
    const dttmm_network* network; /* all elements of the machine; may be without nodes and elements */
    uint32_t constraint_count;
    const dttmm_constraint* constraints;
    uint32_t directions;    /* bit d set: bodies and nodes move in direction d of x y z rx ry rz (world axes) */
    uint32_t lumped_beams;  /* non-zero: beams as the time solver has them, otherwise exact */
    const dttmm_rest* rest; /* NULL: about the start; otherwise in all directions, and constraints are where they are at
                               rest. Lines bent at rest are taken as the time solver has them. */
} dttmm_modal_model;

typedef struct dttmm_modal dttmm_modal;

/* A natural frequency. Equal ones are listed once each, rigid-body modes first. */
typedef struct dttmm_mode {
    double frequency; /* [Hz]; 0 for a rigid-body mode; negative: no vibration, it grows as exp(2 pi |frequency| t) */
    double bracket; /* the count of frequencies changes by the multiplicity within this relative distance, and what rounding
                       of stiff parts may have moved lies within it too. Of a rigid-body mode:
                       how fast it may vibrate or grow at most [Hz]; 0: nothing strains it */
    uint32_t multiplicity;
    double residual; /* last pivot of the overall transfer matrix, full pivoting, as share of what it is 0.1 % beside;
                        where the machine is too large for that, what the quotient leaves by which the frequency was
                        refined */
    double mass;     /* modal mass of the shape as scaled: its largest displacement is 1 m [kg]. Shapes of equal
                        frequencies are at right angles by mass. */
    double participation[6]; /* share of the moved mass or inertia (about the origin) that takes part per direction */
} dttmm_mode;

/* The overall transfer equation U_all Z_all = 0 at a frequency. */
typedef struct dttmm_overall {
    uint32_t rows, columns;         /* before the known boundary entries are struck out */
    double smallest;                /* singular value as share of the largest, in balanced units */
    double sign, log10_determinant; /* of the square matrix that is left */
} dttmm_overall;

/* One thread at a time per dttmm_modal. */
typedef struct dttmm_modal_table {
    uint32_t size; /* sizeof(dttmm_modal_table) as the plugin was compiled */

    /* Builds the linear model; on failure *modal is NULL. Its description may go after the call. */
    dttmm_status (*create)(const dttmm_modal_model* model, dttmm_modal** modal, dttmm_error* error);
    void (*destroy)(dttmm_modal* modal);

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

    /* NULL: no element has one. The force that an element has at the start and whose stiffness is in the modes [N], positive
     * in tension; 0: none. */
    double (*force_at_start)(const dttmm_modal* modal, uint32_t element);
    /* NULL: none is. Of an element that is a line: how far it is bent at rest, as share of its radius of gyration; 0: it is
     * straight. *is_lumped: non-zero where it is therefore taken as the time solver has it. */
    double (*bent_at_rest)(const dttmm_modal* modal, uint32_t element, int32_t* is_lumped);
    /* NULL: not known. How many motions grow. slack: 1: all of them, for a machine without rigid-body modes; n > 1: those
     * whose squared rate of growth is above n times what rounding makes of that of a rigid-body mode; 0: the same, n = 4. */
    dttmm_status (*count_growing)(dttmm_modal* modal, int32_t slack, uint32_t* count, dttmm_error* error);
    /* NULL: not known. Shares of a mode's strain energy by direction, 6 per element: x y z rx ry rz of its axes. Zero of an
     * element whose strain has no such directions, as of a beam. */
    dttmm_status (*strain_directions)(dttmm_modal* modal, uint32_t index, double* shares, dttmm_error* error);
    /* NULL: not known. The matrix of the overall transfer equation at a frequency, what is known at the boundaries struck
     * out, in SI: *rows times *columns numbers, row-major. text: a line for each row, then for each column: its name, a tab,
     * its unit; zero-terminated, at most `size` bytes. matrix and text may be NULL: the sizes only. */
    dttmm_status (*overall_matrix)(dttmm_modal* modal, double frequency, uint32_t* rows, uint32_t* columns, double* matrix,
                                   char* text, uint32_t size, dttmm_error* error);
    /* NULL: not known. How many motions nothing holds, or so little that rounding hides it: rigid-body modes. */
    dttmm_status (*count_free)(dttmm_modal* modal, uint32_t* count, dttmm_error* error);
} dttmm_modal_table;

#ifdef __cplusplus
}
#endif
#endif
