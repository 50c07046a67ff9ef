/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "laws": the elements of the plugin take force laws that come from elsewhere; how well laws are known in time.
 */
#ifndef DTTMM_LAWS_H
#define DTTMM_LAWS_H

#include "dttmm_law.h"
#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_LAWS "dttmm.laws"

/* A Maxwell series that stands for measured rows wherever a vibration of one frequency is not what is asked for. */
typedef struct dttmm_fit {
    uint32_t terms;
    double misfit;    /* the largest |series - row| over |row| */
    double frequency; /* of that row [Hz] */
} dttmm_fit;

typedef struct dttmm_laws_table {
    uint32_t size; /* sizeof(dttmm_laws_table) as the plugin was compiled */

    /* Adds a force law to those that the elements may have; the library of the law stays loaded. Afterwards the element
     * types may have more parameters: they are to be read anew. *at_work is the law while it is asked, NULL otherwise: for
     * whoever reports a crash. [before a model is read] */
    dttmm_status (*add_law)(const dttmm_law* law, const dttmm_law* volatile* at_work, dttmm_error* error);

    /* NULL: no element has such a series. Of a direction (0 to 5) of an element of a type with these values: `terms` is 0
     * where it has none. */
    dttmm_status (*fit)(uint32_t type, const double* values, uint32_t direction, dttmm_fit* fit, dttmm_error* error);
} dttmm_laws_table;

#ifdef __cplusplus
}
#endif
#endif
