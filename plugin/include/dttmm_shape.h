/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "shape": where elements that bend between their ends are, for pictures of a run. A host without it draws them by
 * their ends.
 */
#ifndef DTTMM_SHAPE_H
#define DTTMM_SHAPE_H

#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_SHAPE "dttmm.shape"

typedef struct dttmm_shape_table {
    uint32_t size; /* sizeof(dttmm_shape_table) as the plugin was compiled */

    /* The elements that bend, by their indices in dttmm_network.elements, each once. *count: how many; the array lives as
     * long as the instance, and is not read where *count is 0. [after create] */
    const uint32_t* (*lines)(const dttmm_instance* instance, uint32_t* count);

    /* Where `stations` equally spaced points of each of them are, ends included, at the instant of outputs(): 3 numbers per
     * point [m, world], element after element, each from its `from` end; positions: 3 * stations * count numbers. A plugin
     * may interpolate linearly between the points that it knows. Pure. DTTMM_ERROR_ARGUMENT for fewer than 2 stations,
     * DTTMM_ERROR_PHASE before the first commit. [after a commit] */
    dttmm_status (*positions)(const dttmm_instance* instance, uint32_t stations, double* positions, dttmm_error* error);
} dttmm_shape_table;

#ifdef __cplusplus
}
#endif
#endif
