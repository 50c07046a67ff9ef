/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "derivative": how a run, natural frequencies and responses change with a parameter. The host makes three
 * machines that differ in numbers only: `middle`, and one with the parameter a little larger, `above`, and a little smaller,
 * `below`. Half of the difference of these two is the derivative times the distance of the parameter.
 *
 * A call may change working memory of all machines that it is given: they count as in use. DTTMM_ERROR_ARGUMENT: they differ
 * in more than numbers. Every member but `size` may be NULL: not known.
 */
#ifndef DTTMM_DERIVATIVE_H
#define DTTMM_DERIVATIVE_H

#include "dttmm_modal.h"
#include "dttmm_plugin.h"
#include "dttmm_response.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_DERIVATIVE "dttmm.derivative"

typedef struct dttmm_derivative_table {
    uint32_t size; /* sizeof(dttmm_derivative_table) as the plugin was compiled */

    /* Of a run, between two steps: the three run side by side. Sets the states of `above` and `below` to that of `middle`
     * plus and minus half of their difference. So the scheme, linearised about `middle`, carries the derivative on, and its
     * error is that of one step. The state is all that decides about the next steps (what dttmm_state_table saves). Sums
     * that only outputs show, and counters, may stay as they are. Matrices of rotations may be combined like other numbers:
     * what they then lack is of the second order and alike in both. Factors of matrices stay. outputs() are those of the
     * step before. DTTMM_ERROR_MODEL names an element whose state has no such middle, as of a law with a memory of its own
     * kind; DTTMM_ERROR_PHASE: a step is open. [after start, no step open in any of them, the same number of steps taken] */
    dttmm_status (*centre)(dttmm_instance* above, dttmm_instance* below, const dttmm_instance* middle, dttmm_error* error);

    /* Half the difference of a natural frequency, (above - below)/2, exact to the first order [Hz]; its sign is that of
     * dttmm_mode.frequency. index: the first mode of a frequency of `middle`; changes: takes as many numbers as its
     * multiplicity, one for each of its branches, ascending; 0 of rigid-body modes. Wants the extension "dttmm.modal".
     * DTTMM_ERROR_ARGUMENT also for another index. [after find_modes of `middle`, create of the others] */
    dttmm_status (*frequency_changes)(dttmm_modal* middle, uint32_t index, dttmm_modal* above, dttmm_modal* below,
                                      double* changes, dttmm_error* error);

    /* As dttmm_response_table.respond, of `above` or `below`, linear about the response of `middle`. Half the difference of
     * the two is -H dZ H + H dF, within a resonance however sharp. DTTMM_ERROR_ARGUMENT also for damping of modes,
     * and at 0 Hz of a machine that is free to move. Wants the extension "dttmm.response". [after create of both] */
    dttmm_status (*respond_beside)(dttmm_modal* modal, dttmm_modal* middle, double frequency, uint32_t case_count,
                                   const uint32_t* ends, const dttmm_harmonic* loads, const dttmm_harmonic_result* result,
                                   dttmm_error* error);
} dttmm_derivative_table;

#ifdef __cplusplus
}
#endif
#endif
