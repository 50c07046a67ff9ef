/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "state": everything of an instance that changes from step to step, saved and restored.
 */
#ifndef DTTMM_STATE_H
#define DTTMM_STATE_H

#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_STATE "dttmm.state"

typedef struct dttmm_state_table {
    uint32_t size; /* sizeof(dttmm_state_table) as the plugin was compiled */

    /* Exact to the bit; restored only into an instance of the same network, started with the same step size. [after start,
     * no step open] */
    size_t (*state_size)(const dttmm_instance* instance);
    dttmm_status (*save)(const dttmm_instance* instance, void* buffer, size_t size, dttmm_error* error);
    dttmm_status (*restore)(dttmm_instance* instance, const void* buffer, size_t size, dttmm_error* error);
} dttmm_state_table;

#ifdef __cplusplus
}
#endif
#endif
