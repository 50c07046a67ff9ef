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

typedef struct dttmm_response_table {
    uint32_t size; /* sizeof(dttmm_response_table) as the plugin was compiled */

    /* Steady motion under unit harmonic wrenches, damping as the elements have it: `force` (6: force and moment, world) at
     * a point of body `on_body`, or of node `on_node` of the network (the other is -1); displacement per newton as real and
     * imaginary part, 12 per body and 12 per node. */
    dttmm_status (*respond)(dttmm_modal* modal, double frequency, int32_t on_body, int32_t on_node, const double* point,
                            const double* force, double* bodies, double* nodes, dttmm_error* error);
} dttmm_response_table;

#ifdef __cplusplus
}
#endif
#endif
