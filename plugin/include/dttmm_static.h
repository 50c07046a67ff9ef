/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * Extension "static": the network at rest under lasting loads. The host looks for poses of the bodies at which all forces
 * balance; what is inside the network follows in the same iteration.
 *
 * One iteration: form -> correct -> move, move again with a smaller share where the first went too far. The next form goes
 * on from where the last move has led.
 */
#ifndef DTTMM_STATIC_H
#define DTTMM_STATIC_H

#include "dttmm_plugin.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_STATIC "dttmm.static"

/* How a correction of the inside looks, or the place that it leads to. */
typedef struct dttmm_static_measure {
    double work; /* along the whole correction u of bodies and inside, of the network's forces and of its loads [J]; after
                    correct u K u, K their derivative, where bodies and loads of the host are none: negative uphill */
    double residual; /* the largest force that lacks inside [N]; moments by the lever arms of their frame */
    double force;    /* the largest of an element or load [N]; moments divided by the span of the network */
    double noise;    /* what of the residual may be rounding [N] */
    double shift;    /* the largest of a point inside by the whole correction [m] */
    double turn; /* the largest of an element or node inside [rad]: after correct by the whole correction; after move from
                    the assembled machine, at most half a turn */
    double bend; /* the largest turn or shift of the ends of a joint against each other, as share of that up to which its
                    law holds: after correct what the whole correction changes, after move what it is */
    int32_t element; /* of the largest shift; -1: none */
    int32_t falling; /* after correct: negative eigenvalues of the stiffness inside, bodies held; 0: not known, or none */
} dttmm_static_measure;

/* Wrenches and motions are 6 per body, matrices 36 numbers per block, as in dttmm_plugin.h. */
typedef struct dttmm_static_table {
    uint32_t size; /* sizeof(dttmm_static_table) as the plugin was compiled */

    /* Back to the places of the assembled machine, without loads. [after create] */
    dttmm_status (*begin)(dttmm_instance* instance, dttmm_error* error);
    /* Keeps where everything is; goes back there, at first to the assembled machine. [after begin] */
    dttmm_status (*keep)(dttmm_instance* instance, dttmm_error* error);
    dttmm_status (*recall)(dttmm_instance* instance, dttmm_error* error);
    /* Lasting loads: gravity on the masses of the network [m/s^2], and `loads` as dttmm_plugin.begin_step has them; NULL:
     * none. [after begin] */
    dttmm_status (*set_loads)(dttmm_instance* instance, const double gravity[3], const double* loads, dttmm_error* error);
    /* Forms the equations with the bodies at these poses (velocities are not looked at). wrench: on the bodies, less what
     * the inside takes of it by coming to rest; stiffness = -d(wrench)/d(pose), what stems from forces that turn included,
     * symmetric but for what loads on the inside without a potential do to it. resistance s [1/s^2]: s times the mass
     * matrix is added to the stiffness inside. [after begin] */
    dttmm_status (*form)(dttmm_instance* instance, const dttmm_motion* bodies, double resistance, double* wrench,
                         double* stiffness, dttmm_error* error);
    /* Finds the correction of the inside to that of the bodies, `change`: shifts and small turns. [after form] */
    dttmm_status (*correct)(dttmm_instance* instance, const double* change, dttmm_static_measure* measure,
                            dttmm_error* error);
    /* Takes `share` of it from where the equations were formed, the bodies at these poses; wrench: on them. [after correct]
     */
    dttmm_status (*move)(dttmm_instance* instance, const dttmm_motion* bodies, double share, double* wrench,
                         dttmm_static_measure* measure, dttmm_error* error);
    /* Like dttmm_plugin.start, but all at rest and in balance where the last move has led, under its loads. [after form] */
    dttmm_status (*start)(dttmm_instance* instance, const dttmm_step* step, const dttmm_motion* bodies, const double* loads,
                          dttmm_error* error);
} dttmm_static_table;

#ifdef __cplusplus
}
#endif
#endif
