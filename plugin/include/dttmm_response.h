/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "response": steady vibration under harmonic loads, of the linear model of extension "modal".
 */
#ifndef DTTMM_RESPONSE_H
#define DTTMM_RESPONSE_H

#include "dttmm_modal.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_RESPONSE "dttmm.response"

/* Complex amplitudes are pairs, real and imaginary part: the motion is the real part of amplitude * exp(2 pi i f t). */

/* A harmonic wrench on a body, or on a node of the network (the other is -1); or a support that moves. */
typedef struct dttmm_harmonic {
    int32_t on_body, on_node;
    double point[3];   /* of a body [m, world] */
    double wrench[12]; /* amplitudes of force and moment [N, N m, world] */
    /* Other than 0: on_node moves in its fixed directions. `wrench` has its displacement and rotation [m, rad, world], which
     * count in these directions only. */
    uint32_t is_motion;
} dttmm_harmonic;

/* What one wants of a response, per case in the order of the cases; any pointer may be NULL. */
typedef struct dttmm_harmonic_result {
    double* bodies; /* 12 per body: displacement and rotation at its centre of mass [m, rad, world] */
    double* nodes;  /* 12 per node */
    /* 24 per element, in its axes, signs as of the channels of a run: force and moment [N, N m]; of its `to` end against its
     * `from` end, deflection and rotation [m, rad]. Of a line force and moment at its `from` end. The axes turn with the
     * `from` end: forces of a machine at rest change in them with that. In rigid directions they are the reactions; where
     * these are redundant, one set that balances. */
    double* elements;
    double* constraints; /* 12 per constraint: force and moment on its first body at its point [N, N m, world] */
} dttmm_harmonic_result;

/* A mode with damping, x exp(s t). */
typedef struct dttmm_damped_mode {
    double s[2];       /* real and imaginary part [1/s]; the imaginary part is zero or positive */
    double correction; /* what another step of Newton's method changes, as share of |s|; s = 0: a rigid-body mode */
} dttmm_damped_mode;

typedef struct dttmm_response_table {
    uint32_t size; /* sizeof(dttmm_response_table) as the plugin was compiled */

    /* Steady motion, damping as the elements have it, in several cases of loads at one frequency [Hz]. The loads of case c
     * are those from ends[c - 1] (0 for the first) to before ends[c]; they act together. */
    dttmm_status (*respond)(dttmm_modal* modal, double frequency, uint32_t case_count, const uint32_t* ends,
                            const dttmm_harmonic* loads, const dttmm_harmonic_result* result, dttmm_error* error);
    /* NULL: none is. Non-zero for an element that carries a force along the line between its ends and nothing else: its
     * force and its deflection are their x. */
    int32_t (*is_axial)(const dttmm_modal* modal, uint32_t element);

    /* NULL: not known. All modes with damping whose |s| is at most 2 pi `below` [Hz], by |s|: their number. *is_proved:
     * 1 where all are there, counted by a complete set of eigenvalues, and solve the equations; 2 where all are there but
     * those within 2 % of -1/stiffness_damping of a beam or rod, of which there are infinitely many, and those without
     * vibration in which a material relaxes; else 0. */
    dttmm_status (*find_damped)(dttmm_modal* modal, double below, uint32_t* found, int32_t* is_proved, dttmm_error* error);
    /* One of them, and its shape: 12 numbers per body, at its centre of mass, and per node. Pointers may be NULL. */
    dttmm_status (*damped_mode)(dttmm_modal* modal, uint32_t index, dttmm_damped_mode* mode, double* bodies, double* nodes,
                                dttmm_error* error);

    /* NULL: not known. Damping beside that of the elements, from now on. mass_rate: force on every mass per momentum, the
     * world at rest [1/s]. ratios: damping ratios of the first `count` vibrations by frequency, rigid-body modes left out;
     * or, where `below` [Hz] is not 0, one number for all vibrations up to there. Refused, by respond, of supports that
     * move. */
    dttmm_status (*set_damping)(dttmm_modal* modal, double mass_rate, uint32_t count, const double* ratios, double below,
                                dttmm_error* error);
} dttmm_response_table;

#ifdef __cplusplus
}
#endif
#endif
