/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "derivative": how a run, and natural frequencies, change with a parameter. Of a run, two instances of one
 * network, the parameter a little larger in one and a little smaller in the other, run beside a third in its middle. After
 * every step their states are moved to equal distances from the middle one's: half of their difference is then the
 * derivative of the state times the distance of the parameter, carried on by the scheme linearised about the run in the
 * middle.
 */
#ifndef DTTMM_DERIVATIVE_H
#define DTTMM_DERIVATIVE_H

#include "dttmm_modal.h"
#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_DERIVATIVE "dttmm.derivative"

typedef struct dttmm_derivative_table {
    uint32_t size; /* sizeof(dttmm_derivative_table) as the plugin was compiled */

    /* Sets the states of `above` and `below` to that of `middle` plus and minus half of their difference. The three are of
     * networks that differ in numbers only, at the same step. DTTMM_ERROR_MODEL names an element whose state has no such
     * middle, as of a law with a memory of its own kind. [after start, no step open in any of them] */
    dttmm_status (*centre)(dttmm_instance* above, dttmm_instance* below, const dttmm_instance* middle, dttmm_error* error);

    /* NULL: not known. How a natural frequency of `middle` changes, exactly to the first order: half of what lies between
     * `below` and `above` [Hz]. The three are of machines that differ in numbers only. index: the first mode of a frequency;
     * changes: as many as its multiplicity, one for each of its branches, ascending; 0 of rigid-body modes. [after
     * find_modes of `middle`, create of the others] */
    dttmm_status (*frequency_changes)(dttmm_modal* middle, uint32_t index, dttmm_modal* above, dttmm_modal* below,
                                      double* changes, dttmm_error* error);
} dttmm_derivative_table;

#ifdef __cplusplus
}
#endif
#endif
