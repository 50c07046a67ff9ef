/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A law with one fault, FAULT, or none: a spring k d beside what is wrong with it. */
#include <stddef.h>
#include <stdint.h>

#include "dttmm_law.h"

enum {
    none,
    wrong_tangent,
    impure,
    force_at_zero,
    negative_dissipation,
    open_loop,
    not_a_number,
    writes_memory,
    segmentation,
    other_major,
    no_name,
    taken_name,
    much_memory,
    other_unit,
    gap
};

static const dttmm_law_parameter parameters[] = {{"stiffness", FAULT == other_unit ? "N*s/m" : "N/m", "N*m/rad", 0, "k"}};

static double beyond(double d) { return d > 1e-4 ? d - 1e-4 : d < -1e-4 ? d + 1e-4 : 0; }

static void along(const double* values, const dttmm_law_path* path, dttmm_law_answer* answer) {
    const double k = values[0], way = path->to - path->from;
    answer->force = k * path->to;
    answer->tangent = k;
    answer->mean = 0.5 * k * (path->from + path->to);
    answer->mean_tangent = 0.5 * k;
    answer->stored = 0.5 * k * path->to * path->to;
    answer->dissipated = 0;
    if (FAULT == gap) { /* no fault: play of 0.1 mm to either side */
        const double a = beyond(path->from), b = beyond(path->to);
        answer->force = k * b;
        answer->tangent = b != 0 ? k : 0;
        answer->stored = 0.5 * k * b * b;
        answer->mean = way != 0 ? 0.5 * k * (b + a) * ((b - a) / way) : k * b;
        answer->mean_tangent = way != 0 ? (k * b - answer->mean) / way : 0.5 * answer->tangent;
    }
    if (FAULT == wrong_tangent) answer->tangent = 1.001 * k;
    if (FAULT == impure) {
        static int calls = 0;
        answer->force += 1e-3 * ++calls * k * path->to;
    }
    if (FAULT == force_at_zero && way == 0 && path->to != 0) answer->force *= 1.01;
    if (FAULT == negative_dissipation) {
        answer->dissipated = -1e-3 * k * way * way;
        answer->mean -= 1e-3 * k * way;
        answer->mean_tangent -= 1e-3 * k;
        path->after[0] = path->to;
    }
    if (FAULT == open_loop && way > 0) {
        answer->dissipated = 1e-3 * k * way * way;
        answer->mean += 1e-3 * k * way;
        answer->mean_tangent += 1e-3 * k;
    }
    if (FAULT == not_a_number && path->to > 1e-4) answer->force = 0.0 / (way - way);
    if (FAULT == writes_memory) *(double*)(uintptr_t)path->memory = 1;
    if (FAULT == segmentation && path->to > 1e-4) *(volatile int*)(uintptr_t)(way - way) = 1;
}

static const dttmm_law law = {sizeof(dttmm_law),
                              FAULT == other_major ? 2 : DTTMM_LAW_MAJOR,
                              FAULT == no_name ? "a law" : FAULT == taken_name ? "cubic" : "faulty",
                              "a spring with a fault",
                              1,
                              parameters,
                              FAULT == much_memory ? 257 : FAULT == negative_dissipation || FAULT == writes_memory ? 1 : 0,
                              along};

const dttmm_law* dttmm_law_entry(uint32_t host_major, uint32_t index) {
    (void)host_major;
    return index == 0 ? &law : NULL;
}
