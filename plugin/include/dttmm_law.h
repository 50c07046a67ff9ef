/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright (c) 2026 the dttmm authors
 *
 * A force law of your own, in C: data and one function. It may stand wherever the model names a law, under the name and with
 * the parameters that it declares, in runs, modes, frequency responses and sweeps. A shared library with laws is loaded by
 * --plugin FILE. `dttmm check-law FILE` tests it.
 *
 * A law is the force of one direction of an element by its deformation: SI units (m, N; rad, N m in a rotation), positive in
 * tension, zero undeformed. It is elastic, or it remembers its past: friction, hysteresis.
 */
#ifndef DTTMM_LAW_H
#define DTTMM_LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DTTMM_LAW_MAJOR 1u

/* The one symbol that a library of laws exports; declared at the end. */
#define DTTMM_LAW_ENTRY "dttmm_law_entry"

/* A number that the model gives. */
typedef struct dttmm_law_parameter {
    const char* name;          /* its key: letters, digits, underscore, no digit first; no key of elements, as "damping" */
    const char* unit;          /* SI, in a translation, as UDUNITS-2 reads it: "N/m"; the same in all laws with this key */
    const char* rotation_unit; /* SI, in a rotation: "N*m/rad"; likewise */
    double minimum;            /* SI, included; -1e300 where every number will do */
    const char* documentation; /* one line */
} dttmm_law_parameter;

/* A straight path of the deformation. */
typedef struct dttmm_law_path {
    double from, to;
    double time;          /* that the path takes [s]. 0 where from = to: a look at an instant, which changes nothing. 0 where
                             they differ: a path so slow that all has relaxed at its end, as from the undeformed state to
                             where a machine starts */
    const double* memory; /* what is left of the paths before; all zero at first */
    double* after;        /* takes the memory at the end of the path, all of it */
} dttmm_law_path;

typedef struct dttmm_law_answer {
    double force;        /* at the end of the path */
    double tangent;      /* d(force)/d(to), never infinite; of a path of no length and no time that of going back */
    double mean;         /* of the force along the path: (stored at its end - at its start + dissipated)/(to - from); of a
                            path of no length the force */
    double mean_tangent; /* d(mean)/d(to); of an elastic law on a path of no length half the tangent */
    double stored;       /* energy at the end of the path */
    double dissipated;   /* energy lost along the path, at least 0 */
} dttmm_law_answer;

typedef struct dttmm_law {
    uint32_t size;  /* sizeof(dttmm_law) as the library was compiled */
    uint32_t major; /* DTTMM_LAW_MAJOR as the library was compiled */
    const char* name;
    const char* documentation; /* one line */
    uint32_t parameter_count;
    const dttmm_law_parameter* parameters;
    uint32_t
        memory_count; /* numbers that it remembers, at most 256; 0: it is elastic, and its force depends on `to` alone */

    /* What the law does on a path. Pure: the same answer to the same question, nothing kept but in path->after. A path of no
     * length and no time changes neither force nor memory. The host tries deformations that may be far off: up to 1e100 N
     * are taken there, so that an exponential law wants a straight end; where a step ends, 1e15 N. values: of the
     * parameters, SI, in the order declared. Called in every iteration of every step: it must not allocate, and any number
     * of threads may call it at once. */
    void (*along)(const double* values, const dttmm_law_path* path, dttmm_law_answer* answer);
} dttmm_law;

/* The entry: the laws of the library by index 0, 1, ..., then NULL; NULL if it does not speak the host's major version. */
typedef const dttmm_law* (*dttmm_law_entry_function)(uint32_t host_major, uint32_t index);
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const dttmm_law*
dttmm_law_entry(uint32_t host_major, uint32_t index);

#ifdef __cplusplus
}
#endif
#endif
