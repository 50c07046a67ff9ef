/* SPDX-License-Identifier: BSD-3-Clause
 *
 * A plugin with one fault, chosen by FAULT when it is compiled. Apart from it, it is in order: its element `faulty` joins
 * two ends and never pulls. To tell whether the library was run at all, it makes the file named by DTTMM_LOADED_MARKER when
 * it is loaded.
 */
#define _GNU_SOURCE
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "dttmm_modal.h"
#include "dttmm_shape.h"

enum fault {
    none,
    no_entry, /* the build renames the entry */
    null_table,
    other_major,
    small_table,
    null_function,
    null_types,
    bad_parameter,
    bad_ends,
    bad_words,
    bad_default,
    bad_key,
    taken_key,
    builtin_name,
    create_error,
    linearise_error,
    create_nothing,
    bad_channel,
    bad_block,
    twice_a_block,
    slash_channel,
    bad_role,
    port_channel,
    energy_in_watts,
    heavy_weights,
    nan_output,
    rounding_mode,
    nan_at_step_1000,
    huge,
    large,
    overrun,
    error_at_step_1000,
    silent_error,
    rough, /* no fault: it wants to iterate twice in a step */
    always_rough,
    nan_progress,
    progress_overrun,
    too_many_parts,
    half_an_iteration,
    small_extension,
    old_extension, /* no fault: its table is that of an earlier minor version */
    nan_position,
    position_overrun,
    bends_twice,
    bends_elsewhere,
    throw_entry,
    throw_create,
    throw_linearise,
    throw_at_step_1000,
    exit_at_step_1000,
    quick_exit_at_step_1000,
    segmentation_at_step_1000,
    abort_at_step_1000,
    stack_at_step_1000,
    division_at_step_1000,
    instruction_at_step_1000,
    bus_at_step_1000,
    endless, /* from step 1000 on */
    traps_at_step_1000,
    weights_overrun,
    many_channels,
    shrinking_channels,
    underrun,
    stiffness_overrun,
    stiffness_underrun,
    damping_overrun,
    output_overrun,
    output_underrun,
    flush_to_zero,
    decimal_comma,
    nan_stiffness,
    infinite_damping,
    uneven_weights,
    root_folder,
    terminal_text,
    model_error_at_step_1000
};

enum { FAILING_STEP = 1000 };

#define BENDS (FAULT == nan_position || FAULT == position_overrun || FAULT == bends_twice || FAULT == bends_elsewhere)

#define ITERATES                                                                                                         \
    (FAULT == rough || FAULT == always_rough || FAULT == nan_progress || FAULT == progress_overrun || FAULT == too_many_parts)

void throw_exception(void);

/* Deeper than any stack. */
static int descend(volatile int* above) {
    volatile int here[1000];
    here[0] = *above + 1;
    return here[0] > 0 ? descend(here) + here[0] : 0;
}

/* What a crash at the failing step does. */
static void crash(void) {
    volatile int zero = 0;
    volatile int* volatile nowhere = (volatile int*)8;
    switch (FAULT) {
        case throw_at_step_1000:
            throw_exception();
            break;
        case exit_at_step_1000:
            exit(0);
        case quick_exit_at_step_1000:
            quick_exit(0);
        case segmentation_at_step_1000:
            *nowhere = 1;
            break;
        case abort_at_step_1000:
            abort();
        case stack_at_step_1000:
            zero = descend(&zero);
            break;
        case division_at_step_1000:
            zero = 12345 / zero;
            break;
        case traps_at_step_1000:
            feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_INEXACT);
            break;
        case instruction_at_step_1000:
            raise(SIGILL);
            break;
        case bus_at_step_1000:
            raise(SIGBUS);
            break;
        case endless:
            while (!zero) {
            }
            break;
        default:
            break;
    }
}

struct dttmm_instance {
    size_t body_count;
    dttmm_block blocks[2]; /* of the ends that are on bodies */
    uint32_t block_count;
    volatile int32_t *at_work;
    uint64_t step;
    int iterated; /* so often in the open step */
};

__attribute__((constructor)) static void make_marker(void) {
    const char *path = getenv("DTTMM_LOADED_MARKER");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (file) fclose(file);
}

static dttmm_status fail(dttmm_error *error, dttmm_status status, int32_t element, const char *text) {
    error->element = element;
    snprintf(error->text, sizeof error->text, "%s", text);
    return status;
}

static dttmm_status create(const dttmm_network *network, dttmm_instance **instance, dttmm_error *error) {
    *instance = NULL;
    if (network->at_work) *network->at_work = 0;
    if (FAULT == throw_create) throw_exception();
    if (FAULT == root_folder && chdir("/") != 0) return DTTMM_ERROR_INTERNAL;
    if (FAULT == terminal_text)
        return fail(error, DTTMM_ERROR_INTERNAL, 0,
                    "\033[2J\033]0;title\007red\033[31m \xc2\x9b"
                    "31m \xff\r\n");
    if (FAULT == create_error)
        return fail(error, (dttmm_status)network->elements[0].values[0], 0, "this spring is made of butter; take steel");
    if (FAULT == create_nothing) return DTTMM_OK;
    *instance = calloc(1, sizeof **instance);
    if (*instance == NULL) return fail(error, DTTMM_ERROR_MEMORY, -1, "out of memory");
    (*instance)->body_count = network->body_count;
    (*instance)->at_work = network->at_work;
    for (uint32_t n = 0; n < network->node_count && (*instance)->block_count < 2; ++n)
        if (network->nodes[n].kind == DTTMM_NODE_ON_BODY) {
            dttmm_block *block = &(*instance)->blocks[(*instance)->block_count];
            block->row = block->column = network->nodes[n].body + (FAULT == bad_block ? 1000 : 0);
            if ((*instance)->block_count == 0 || (block - 1)->row != block->row) ++(*instance)->block_count;
        }
    if (FAULT == twice_a_block) {
        (*instance)->blocks[1] = (*instance)->blocks[0];
        (*instance)->block_count = 2;
    }
    return DTTMM_OK;
}

static void destroy(dttmm_instance *instance) { free(instance); }

static void go_to_work(const dttmm_instance *instance) {
    if (instance->at_work) *instance->at_work = 0;
}

static const dttmm_block *blocks(const dttmm_instance *instance, uint32_t *count) {
    go_to_work(instance);
    *count = instance->block_count;
    return instance->blocks;
}

static void write_zeros(const dttmm_instance *instance, double *wrench, double *matrix) {
    if (wrench) memset(wrench, 0, 6 * instance->body_count * sizeof *wrench);
    if (matrix) memset(matrix, 0, 36 * instance->block_count * sizeof *matrix);
}

static dttmm_status linearise(const dttmm_instance *instance, const dttmm_motion *ports, double *wrench, double *stiffness,
                              double *damping, dttmm_error *error) {
    (void)ports;
    go_to_work(instance);
    if (FAULT == linearise_error) return fail(error, DTTMM_ERROR_INTERNAL, 0, "the spring does not know its stiffness");
    if (FAULT == throw_linearise) throw_exception();
    write_zeros(instance, wrench, stiffness);
    write_zeros(instance, NULL, damping);
    const size_t last = 36 * instance->block_count - 1;
    if (FAULT == nan_stiffness && stiffness) stiffness[last] = NAN;
    if (FAULT == infinite_damping && damping) damping[last] = INFINITY;
    if (FAULT == stiffness_overrun && stiffness) stiffness[last + 1] = 0;
    if (FAULT == stiffness_underrun && stiffness) stiffness[-1] = 0;
    if (FAULT == damping_overrun && damping) damping[last + 1] = 0;
    return DTTMM_OK;
}

static dttmm_status start(dttmm_instance *instance, const dttmm_step *step, const dttmm_motion *ports,
                          const double *accelerations, const double *loads, dttmm_error *error) {
    (void)instance, (void)step, (void)ports, (void)accelerations, (void)loads, (void)error;
    return DTTMM_OK;
}

static dttmm_status begin_step(dttmm_instance *instance, const dttmm_step *step, const double *loads, dttmm_error *error) {
    (void)loads, (void)error;
    instance->step = step->index;
    instance->iterated = 0;
    return DTTMM_OK;
}

static dttmm_status evaluate(const dttmm_instance *instance, const dttmm_motion *trial, double *wrench, double *stiffness,
                             dttmm_error *error) {
    (void)trial;
    go_to_work(instance);
    write_zeros(instance, wrench, stiffness);
    if (FAULT == silent_error) return -99;
    if (FAULT == huge) wrench[2] = 1e300;
    if (FAULT == large) wrench[2] = 1e20;
    if (FAULT == overrun) wrench[6 * instance->body_count] = 0;
    if (FAULT == underrun) wrench[-1] = 0;
    if (instance->step == FAILING_STEP) crash();
    if (FAULT == model_error_at_step_1000 && instance->step == FAILING_STEP)
        return fail(error, DTTMM_ERROR_MODEL, 0, "the spring was never there");
    if (FAULT == nan_at_step_1000 && instance->step == FAILING_STEP) wrench[1] = NAN;
    if (FAULT == error_at_step_1000 && instance->step == FAILING_STEP)
        return fail(error, DTTMM_ERROR_INTERNAL, 0, "the spring has melted");
    return DTTMM_OK;
}

static dttmm_status commit_step(dttmm_instance *instance, const dttmm_motion *accepted, dttmm_error *error) {
    (void)accepted;
    if (FAULT == rough && instance->iterated < 2)
        return fail(error, DTTMM_ERROR_INTERNAL, 0, "it has iterated only once");
    return DTTMM_OK;
}

static dttmm_status discard_step(dttmm_instance *instance, dttmm_error *error) {
    (void)instance, (void)error;
    return DTTMM_OK;
}

static uint32_t part_count(const dttmm_instance *instance) {
    go_to_work(instance);
    return FAULT == too_many_parts ? 4000000000u : 1;
}

static dttmm_status iterate(dttmm_instance *instance, const dttmm_motion *trial, dttmm_progress *progress,
                            dttmm_error *error) {
    (void)trial;
    (void)error;
    go_to_work(instance);
    progress->correction = ++instance->iterated == 1 || FAULT == always_rough ? 1 : 0;
    progress->previous = instance->iterated == 1 ? 0 : 1;
    progress->motion = progress->residual = progress->impulse = 1;
    progress->enough = 0;
    progress->is_new = 0;
    progress->element = 0;
    if (FAULT == nan_progress) progress->residual = NAN;
    if (FAULT == progress_overrun) progress[1].motion = 0;
    return DTTMM_OK;
}

static int32_t is_implicit(const dttmm_instance *instance) {
    (void)instance;
    return ITERATES;
}

static void load_weights(const dttmm_instance *instance, double weights[3]) {
    (void)instance;
    weights[0] = weights[2] = FAULT == uneven_weights ? 5 : 0;
    if (FAULT == weights_overrun) weights[3] = 0;
    weights[1] = FAULT == heavy_weights ? 15 : FAULT == uneven_weights ? -9 : 1;
}

static uint32_t channel_count(const dttmm_instance *instance) {
    static uint32_t asked = 0;
    go_to_work(instance);
    if (FAULT == many_channels) return UINT32_MAX;
    if (FAULT == shrinking_channels) return asked++ == 0 ? 1 : 0;
    return 1;
}

static const dttmm_channel *channels(const dttmm_instance *instance) {
    static const dttmm_channel list[] = {{FAULT == slash_channel ? "force/x" : "force.x", FAULT == bad_channel ? NULL : "N",
                                          FAULT == port_channel ? DTTMM_OF_NODE : DTTMM_OF_ELEMENT, FAULT == port_channel,
                                          FAULT == bad_role          ? DTTMM_ROLE_LIMIT + 1
                                          : FAULT == energy_in_watts ? DTTMM_ROLE_STRAIN_ENERGY
                                                                     : DTTMM_ROLE_RESULT}};
    go_to_work(instance);
    return list;
}

static dttmm_status outputs(const dttmm_instance *instance, double *values, dttmm_error *error) {
    (void)error;
    go_to_work(instance);
    if (FAULT == rounding_mode) fesetround(FE_UPWARD);
    values[0] = FAULT == nan_output ? NAN : 0;
    if (FAULT == output_overrun) values[1] = 0;
    if (FAULT == output_underrun) values[-1] = 0;
#ifdef __SSE2__
    if (FAULT == flush_to_zero) _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
    if (FAULT == decimal_comma && !setlocale(LC_ALL, "de_DE.UTF-8")) setlocale(LC_ALL, "C.UTF-8");
    return DTTMM_OK;
}

static const dttmm_parameter parameters[] = {
    {FAULT == bad_key ? ".number" : FAULT == taken_key ? "to" : "number", "1", 1, 0, FAULT == bad_default ? INFINITY : 0,
     FAULT == bad_parameter ? 200 : -100, 100, NULL, FAULT == bad_words, "any number: the status of a create that fails"},
};
static const dttmm_element_type types[] = {
    {FAULT == builtin_name ? "spring_damper" : "faulty", FAULT == bad_ends ? DTTMM_ENDS_LINE + 1 : DTTMM_ENDS_FROM_TO, 1, parameters, "an element with a fault"},
};

static const uint32_t *lines(const dttmm_instance *instance, uint32_t *count) {
    static const uint32_t elements[] = {FAULT == bends_elsewhere ? 1000 : 0, 0};
    (void)instance;
    *count = FAULT == bends_twice ? 2 : 1;
    return elements;
}

static dttmm_status positions(const dttmm_instance *instance, uint32_t stations, double *at, dttmm_error *error) {
    (void)instance;
    (void)error;
    for (uint32_t i = 0; i < 3 * stations; ++i) at[i] = 0;
    if (FAULT == nan_position) at[7] = NAN;
    if (FAULT == position_overrun) at[3 * stations] = 0;
    return DTTMM_OK;
}

static dttmm_status old_create(const dttmm_modal_model *model, dttmm_modal **modal, dttmm_error *error) {
    (void)model;
    (void)modal;
    (void)error;
    return DTTMM_ERROR_MODEL;
}
static void old_destroy(dttmm_modal *modal) { (void)modal; }
static dttmm_status old_find_modes(dttmm_modal *modal, uint32_t count, double below, uint32_t *found, dttmm_error *error) {
    (void)modal;
    (void)count;
    (void)below;
    (void)found;
    (void)error;
    return DTTMM_ERROR_MODEL;
}
static dttmm_status old_mode(dttmm_modal *modal, uint32_t index, dttmm_mode *mode, double *bodies, double *nodes, double *shares,
                             dttmm_error *error) {
    (void)modal;
    (void)index;
    (void)mode;
    (void)bodies;
    (void)nodes;
    (void)shares;
    (void)error;
    return DTTMM_ERROR_MODEL;
}
static dttmm_status old_mode_along(dttmm_modal *modal, uint32_t index, uint32_t element, uint32_t count, double *length,
                                   double *shape, dttmm_error *error) {
    (void)modal;
    (void)index;
    (void)element;
    (void)count;
    (void)length;
    (void)shape;
    (void)error;
    return DTTMM_ERROR_MODEL;
}
static dttmm_status old_overall(dttmm_modal *modal, double frequency, dttmm_overall *overall, char *layout, uint32_t size,
                                dttmm_error *error) {
    (void)modal;
    (void)frequency;
    (void)overall;
    (void)layout;
    (void)size;
    (void)error;
    return DTTMM_ERROR_MODEL;
}
static double beyond_the_end(const dttmm_modal *modal, uint32_t element) {
    (void)modal;
    (void)element;
    return 0;
}

static const void *extension(const char *name) {
    static const uint32_t small = 8; /* of a table that has nothing but its size */
    /* What stands behind its size is no entry of it. */
    static const dttmm_modal_table old = {offsetof(dttmm_modal_table, force_at_start), old_create, old_destroy, old_find_modes,
                                          old_mode, old_mode_along, old_overall, beyond_the_end, NULL, NULL, NULL, NULL, NULL};
    if (FAULT == old_extension) return strcmp(name, DTTMM_MODAL) == 0 ? &old : NULL;
    static const dttmm_shape_table shape = {sizeof(dttmm_shape_table), lines, positions};
    if (!BENDS) return &small;
    return strcmp(name, DTTMM_SHAPE) == 0 ? &shape : NULL;
}

static const dttmm_plugin table = {
    FAULT == small_table ? offsetof(dttmm_plugin, outputs) : sizeof(dttmm_plugin),
    FAULT == other_major ? DTTMM_PLUGIN_MAJOR + 1 : DTTMM_PLUGIN_MAJOR,
    DTTMM_PLUGIN_MINOR,
    "faulty",
    "1.0",
    1,
    FAULT == null_types ? NULL : types,
    create,
    destroy,
    blocks,
    linearise,
    start,
    begin_step,
    FAULT == null_function ? NULL : evaluate,
    commit_step,
    discard_step,
    is_implicit,
    load_weights,
    channel_count,
    channels,
    outputs,
    FAULT == small_extension || FAULT == old_extension || BENDS ? extension : NULL,
    ITERATES || FAULT == half_an_iteration ? part_count : NULL,
    ITERATES ? iterate : NULL,
    NULL, /* rows by the means over two steps */
    NULL,
    NULL,
};

const dttmm_plugin *dttmm_plugin_entry(uint32_t host_major) {
    if (FAULT == throw_entry) throw_exception();
    return FAULT == null_table || host_major != DTTMM_PLUGIN_MAJOR ? NULL : &table;
}
