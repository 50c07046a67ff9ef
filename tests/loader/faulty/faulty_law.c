/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A law with one fault, FAULT, or none: a spring k d beside what is wrong with it. */
#include <fenv.h>
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
    gap,
    overrun,
    forgets,
    tangent_of_slip,
    not_at_rest,
    tangent_in_mm,
    unit_of_nothing,
    documentation_of_escapes,
    key_of_elements,
    digit_first,
    own_minimum,
    rounds_up
};

static const dttmm_law_parameter parameters[] = {
    {FAULT == key_of_elements   ? "motion"
     : FAULT == digit_first     ? "2x"
     : FAULT == unit_of_nothing ? "k"
                                : "stiffness",
     FAULT == other_unit        ? "N*s/m"
     : FAULT == unit_of_nothing ? "parrots"
                                : "N/m",
     "N*m/rad", FAULT == own_minimum ? 1000 : 0, FAULT == documentation_of_escapes ? "k \033[31m" : "k"},
    {"reach", FAULT == tangent_in_mm ? "mm" : "m", "rad", 0, "where it begins"}};

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
    if (FAULT ==
        tangent_of_slip) { /* a slider that gives way at 10 N behind the spring: all of it but the tangent at rest */
        const double slider = path->memory[0], start = k * (path->from - slider), elastic = start + k * way,
                     force = elastic > 10    ? 10
                             : elastic < -10 ? -10
                                             : elastic,
                     slid = k > 0 ? (elastic - force) / k : 0;
        answer->force = force;
        answer->tangent = elastic == force && (force < 9.999999 && force > -9.999999) ? k : 0;
        answer->stored = k > 0 ? force * force / (2 * k) : 0;
        answer->dissipated = force * slid;
        answer->mean = way == 0 ? force : (0.5 * (start + force) * (way - slid) + force * slid) / way;
        answer->mean_tangent = slid == 0 ? 0.5 * k : (force - answer->mean) / way;
        path->after[0] = k > 0 ? path->to - force / k : path->to;
    }
    if (FAULT == tangent_in_mm) { /* three times the tangent beyond the reach, which a wrong unit puts out of sight */
        const double b = path->to > values[1] ? path->to - values[1] : 0,
                     a = path->from > values[1] ? path->from - values[1] : 0;
        answer->force = k * b;
        answer->tangent = b > 0 ? 3 * k : 0;
        answer->stored = 0.5 * k * b * b;
        answer->mean = way != 0 ? 0.5 * k * (b + a) * ((b - a) / way) : k * b;
        answer->mean_tangent = way != 0 ? (k * b - answer->mean) / way : (b > 0 ? 0.5 * k : 0);
    }
    if (FAULT == overrun) path->after[0] = path->after[1] = path->to;
    if (FAULT == not_at_rest && path->time == 0 && way != 0) answer->force /= path->time;
    if (FAULT == not_a_number && path->to > 1e-4) answer->force = 0.0 / (way - way);
    if (FAULT == writes_memory) *(double*)(uintptr_t)path->memory = 1;
    if (FAULT == rounds_up && path->to > 1e-4) fesetround(FE_UPWARD);
    if (FAULT == segmentation && path->to > 1e-4) *(volatile int*)(uintptr_t)(way - way) = 1;
}

static const dttmm_law law = {sizeof(dttmm_law),
                              FAULT == other_major ? 2 : DTTMM_LAW_MAJOR,
                              FAULT == no_name      ? "a law"
                              : FAULT == taken_name ? "cubic"
                                                    : "faulty",
                              "a spring with a fault",
                              FAULT == tangent_in_mm ? 2 : 1,
                              parameters,
                              FAULT == much_memory ? 257
                              : FAULT == negative_dissipation || FAULT == writes_memory || FAULT == overrun ||
                                      FAULT == forgets || FAULT == tangent_of_slip
                                  ? 1
                                  : 0,
                              along};

const dttmm_law* dttmm_law_entry(uint32_t host_major, uint32_t index) {
    (void)host_major;
    return index == 0 ? &law : NULL;
}
