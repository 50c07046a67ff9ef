/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "laws": the elements of the plugin take force laws that come from elsewhere.
 */
#ifndef DTTMM_LAWS_H
#define DTTMM_LAWS_H

#include "dttmm_law.h"
#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_LAWS "dttmm.laws"

typedef struct dttmm_laws_table {
    uint32_t size; /* sizeof(dttmm_laws_table) as the plugin was compiled */

    /* Adds a force law to those that the elements may have; the library of the law stays loaded. Afterwards the element
     * types may have more parameters: they are to be read anew. *at_work is the law while it is asked, NULL otherwise: for
     * whoever reports a crash. [before a model is read] */
    dttmm_status (*add_law)(const dttmm_law* law, const dttmm_law* volatile* at_work, dttmm_error* error);
} dttmm_laws_table;

#ifdef __cplusplus
}
#endif
#endif
