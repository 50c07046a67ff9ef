/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "support": fixed nodes that the host moves, dttmm_network.supports. A plugin without it holds all fixed nodes
 * where they are at the start; a host that moves some refuses such a plugin.
 */
#ifndef DTTMM_SUPPORT_H
#define DTTMM_SUPPORT_H

#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_SUPPORT "dttmm.support"

/* Where a support is at an instant, and how it moves then. Zero in directions that are not fixed. */
typedef struct dttmm_support_motion {
    double displacement[3];         /* from its place at the start [m] */
    double rotation[3];             /* rotation vector from its axes at the start [rad] */
    double velocity[3];             /* [m/s] */
    double angular_velocity[3];     /* [rad/s] */
    double acceleration[3];         /* [m/s^2] */
    double angular_acceleration[3]; /* [rad/s^2] */
} dttmm_support_motion;

typedef struct dttmm_support_table {
    uint32_t size; /* sizeof(dttmm_support_table) as the plugin was compiled */

    /* One per support, in the order of dttmm_network.supports: at the instant of the coming start, or at the end of the
     * coming step. Only a start looks at velocities and accelerations. The next iterations of the statics lead the supports
     * there (displacement and rotation only; full turns count); its start leaves them where these have led.
     * Without a call they stay where they are. [after create, no step open] */
    dttmm_status (*move)(dttmm_instance* instance, const dttmm_support_motion* motions, dttmm_error* error);
} dttmm_support_table;

#ifdef __cplusplus
}
#endif
#endif
