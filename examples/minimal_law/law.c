/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A friction damper with an elastic seat (Jenkins' element), as in a bolted joint that begins to slip: a spring k in series
 * with a slider that gives way at the force `slip`. It remembers where the slider stands. */
#include <math.h>
#include <stddef.h>

#include "dttmm_law.h"

static const dttmm_law_parameter parameters[] = {
    {"stiffness", "N/m", "N*m/rad", 0, "k of f = k d before it slips"},
    {"slip", "N", "N*m", 0, "force at which it slips"},
};

static void along(const double* values, const dttmm_law_path* path, dttmm_law_answer* answer) {
    const double k = values[0], slip = values[1], slider = path->memory[0];
    const double start = k * (path->from - slider), way = path->to - path->from, elastic = start + k * way;
    const int slips = way != 0 && fabs(elastic) > slip;
    const double force = slips ? copysign(slip, elastic) : elastic;

    answer->force = force;
    answer->tangent = slips ? 0 : k;
    answer->stored = k > 0 ? force * force / (2 * k) : 0;
    if (slips) { /* first elastic, then at the force `slip` */
        const double slid = (elastic - force) / k, stuck = way - slid;
        const double work = 0.5 * (start + force) * stuck + force * slid;
        answer->mean = work / way;
        answer->mean_tangent = (force - answer->mean) / way;
        answer->dissipated = force * slid;
    } else {
        answer->mean = 0.5 * (start + force);
        answer->mean_tangent = 0.5 * k;
        answer->dissipated = 0;
    }
    path->after[0] = k > 0 ? path->to - force / k : path->to;
}

static const dttmm_law law = {
    sizeof(dttmm_law), DTTMM_LAW_MAJOR, "jenkins", "a spring and a dry slider in series", 2, parameters, 1, along};

const dttmm_law* dttmm_law_entry(uint32_t host_major, uint32_t index) {
    return host_major == DTTMM_LAW_MAJOR && index == 0 ? &law : NULL;
}
