// SPDX-License-Identifier: BSD-3-Clause
//
// The C interface of the built-in plugin: every function forwards to a Machine or a ModalAnalysis and turns exceptions into
// a status and a text.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <string_view>

#include "core/error.h"
#include "core/index.h"
#include "dttmm_derivative.h"
#include "dttmm_laws.h"
#include "dttmm_modal.h"
#include "dttmm_plugin.h"
#include "dttmm_response.h"
#include "dttmm_shape.h"
#include "dttmm_state.h"
#include "dttmm_static.h"
#include "dttmm_support.h"
#include "element/registry.h"
#include "element/single_joint.h"
#include "law/registry.h"
#include "law/viscoelastic.h"
#include "modal/modal_analysis.h"
#include "time/machine.h"

struct dttmm_instance {
    dttmm::plugin::Machine machine;
};

struct dttmm_modal {
    dttmm::plugin::ModalAnalysis analysis;
};

namespace {

using dttmm::plugin::as_whole;
using dttmm::plugin::Error;

/// What is too long is cut between two characters of the UTF-8 text.
void write_text(dttmm_error* error, int element, const char* text) noexcept {
    const auto continues = [](char c) { return (c & 0xc0) == 0x80; };
    size_t length = strnlen(text, sizeof error->text);
    if (length == sizeof error->text)
        for (--length; length > 0 && continues(text[length]);) --length;
    error->element = element;
    std::memcpy(error->text, text, length);
    error->text[length] = '\0';
}

/// Runs `body`; nothing it throws gets past here.
template <class Body>
dttmm_status guard(dttmm_error* error, Body&& body) noexcept {
    try {
        body();
        return DTTMM_OK;
    } catch (const Error& e) {
        write_text(error, e.element(), e.what());
        return e.status();
    } catch (const std::bad_alloc&) {
        write_text(error, -1, "out of memory");
        return DTTMM_ERROR_MEMORY;
    } catch (const std::exception& e) {
        write_text(error, -1, e.what());
        return DTTMM_ERROR_INTERNAL;
    } catch (...) {
        write_text(error, -1, "unknown failure");
        return DTTMM_ERROR_INTERNAL;
    }
}

dttmm_status create(const dttmm_network* network, dttmm_instance** instance, dttmm_error* error) {
    *instance = nullptr;
    return guard(error, [&] {
        if (network == nullptr || network->nodes == nullptr || network->elements == nullptr ||
            (network->bodies == nullptr && network->body_count > 0))
            throw Error(DTTMM_ERROR_ARGUMENT, "create: no network, or one without bodies, nodes or elements");
        *instance = new dttmm_instance{dttmm::plugin::Machine(*network)};
    });
}

void destroy(dttmm_instance* instance) { delete instance; }

const dttmm_block* blocks(const dttmm_instance* instance, uint32_t* count) {
    const auto list = instance->machine.blocks();
    *count = static_cast<uint32_t>(list.size());
    return list.data();
}

dttmm_status linearise(const dttmm_instance* instance, const dttmm_motion* bodies, double* wrench, double* stiffness,
                       double* damping, dttmm_error* error) {
    return guard(error, [&] { instance->machine.linearise(bodies, wrench, stiffness, damping); });
}

dttmm_status start(dttmm_instance* instance, const dttmm_step* step, const dttmm_motion* bodies, const double* accelerations,
                   const double* loads, dttmm_error* error) {
    return guard(error, [&] { instance->machine.start(*step, bodies, accelerations, loads); });
}

dttmm_status begin_step(dttmm_instance* instance, const dttmm_step* step, const double* loads, dttmm_error* error) {
    return guard(error, [&] { instance->machine.begin_step(*step, loads); });
}

dttmm_status evaluate(const dttmm_instance* instance, const dttmm_motion* trial, double* wrench, double* stiffness,
                      dttmm_error* error) {
    return guard(error, [&] { instance->machine.evaluate(trial, wrench, stiffness); });
}

dttmm_status commit_step(dttmm_instance* instance, const dttmm_motion* accepted, dttmm_error* error) {
    return guard(error, [&] { instance->machine.commit_step(accepted); });
}

dttmm_status discard_step(dttmm_instance* instance, dttmm_error* error) {
    return guard(error, [&] { instance->machine.discard_step(); });
}

int32_t is_implicit(const dttmm_instance* instance) { return instance->machine.is_implicit() ? 1 : 0; }

void load_weights(const dttmm_instance* instance, double weights[3]) { instance->machine.load_weights(weights); }

size_t state_size(const dttmm_instance* instance) { return instance->machine.state_size(); }

dttmm_status save_state(const dttmm_instance* instance, void* buffer, size_t size, dttmm_error* error) {
    return guard(error, [&] { instance->machine.save_state(buffer, size); });
}

dttmm_status centre(dttmm_instance* above, dttmm_instance* below, const dttmm_instance* middle, dttmm_error* error) {
    return guard(error, [&] { dttmm::plugin::Machine::centre(above->machine, below->machine, middle->machine); });
}

dttmm_status frequency_changes(dttmm_modal* middle, uint32_t index, dttmm_modal* above, dttmm_modal* below, double* changes,
                               dttmm_error* error) {
    return guard(error, [&] { middle->analysis.frequency_changes(index, above->analysis, below->analysis, changes); });
}

dttmm_status restore_state(dttmm_instance* instance, const void* buffer, size_t size, dttmm_error* error) {
    return guard(error, [&] { instance->machine.restore_state(buffer, size); });
}

uint32_t channel_count(const dttmm_instance* instance) { return as_whole<uint32_t>(instance->machine.channel_count()); }

const dttmm_channel* channels(const dttmm_instance* instance) { return instance->machine.channels().data(); }

dttmm_status outputs(const dttmm_instance* instance, double* values, dttmm_error* error) {
    return guard(error, [&] { instance->machine.outputs(values); });
}

uint32_t part_count(const dttmm_instance* instance) { return instance->machine.part_count(); }

dttmm_status iterate(dttmm_instance* instance, const dttmm_motion* trial, dttmm_progress* progress, dttmm_error* error) {
    return guard(error, [&] { instance->machine.iterate(trial, progress); });
}

dttmm_status mean_wrench(dttmm_instance* instance, double* wrench, dttmm_error* error) {
    return guard(error, [&] { instance->machine.mean_wrench(wrench); });
}

dttmm_status stand(dttmm_instance* instance, const dttmm_motion* bodies, const double* accelerations, double* wrench,
                   dttmm_error* error) {
    return guard(error, [&] { instance->machine.stand(bodies, accelerations, wrench); });
}

dttmm_status take_up(const dttmm_instance* instance, const double* motion, double* elastic, double* damped,
                     dttmm_error* error) {
    return guard(error, [&] { instance->machine.take_up(motion, elastic, damped); });
}

// ---- Extensions ---------------------------------------------------------------------------------------------------------

dttmm_status create_modal(const dttmm_modal_model* model, dttmm_modal** modal, dttmm_error* error) {
    *modal = nullptr;
    return guard(error, [&] {
        if (model == nullptr || model->network == nullptr) throw Error(DTTMM_ERROR_ARGUMENT, "create_modal: no model");
        if (!model->rest) {
            *modal = new dttmm_modal{dttmm::plugin::ModalAnalysis(*model)};
            return;
        }
        dttmm::plugin::AtRest rest =
            model->rest->instance ? model->rest->instance->machine.at_rest() : dttmm::plugin::AtRest{};
        rest.scale_forces(model->rest->factor);
        *modal = new dttmm_modal{dttmm::plugin::ModalAnalysis(*model, &rest)};
    });
}

void destroy_modal(dttmm_modal* modal) { delete modal; }

dttmm_status find_modes(dttmm_modal* modal, uint32_t count, double below, uint32_t* found, dttmm_error* error) {
    return guard(error, [&] { *found = as_whole<uint32_t>(modal->analysis.find_modes(count, below)); });
}

dttmm_status mode(dttmm_modal* modal, uint32_t index, dttmm_mode* mode, double* bodies, double* nodes, double* shares,
                  dttmm_error* error) {
    return guard(error, [&] { modal->analysis.mode(index, mode, bodies, nodes, shares); });
}

int32_t is_axial(const dttmm_modal* modal, uint32_t element) { return modal->analysis.is_axial(element); }

dttmm_status find_damped(dttmm_modal* modal, double below, uint32_t* found, int32_t* is_proved, dttmm_error* error) {
    return guard(error, [&] {
        const dttmm::plugin::DampedModes::Count count = modal->analysis.find_damped(below);
        *found = as_whole<uint32_t>(count.modes);
        *is_proved = !count.is_proved ? 0 : count.has_left_out ? 2 : 1;
    });
}

dttmm_status damped_mode(dttmm_modal* modal, uint32_t index, dttmm_damped_mode* mode, double* bodies, double* nodes,
                         dttmm_error* error) {
    return guard(error, [&] { modal->analysis.damped_mode(index, mode, bodies, nodes); });
}

dttmm_status set_damping(dttmm_modal* modal, double mass_rate, uint32_t count, const double* ratios, double below,
                         dttmm_error* error) {
    return guard(error, [&] { modal->analysis.set_damping(mass_rate, {ratios, count}, below); });
}

dttmm_status strain_directions(dttmm_modal* modal, uint32_t index, double* shares, dttmm_error* error) {
    return guard(error, [&] { modal->analysis.strain_directions(index, shares); });
}

dttmm_status mode_along(dttmm_modal* modal, uint32_t index, uint32_t element, uint32_t count, double* length, double* shape,
                        dttmm_error* error) {
    return guard(error, [&] { *length = modal->analysis.along(index, element, count, shape); });
}

void copy_text(const std::string& text, char* to, uint32_t size) {
    const size_t length = std::min(text.size(), dttmm::plugin::as_size(size - 1));
    std::memcpy(to, text.data(), length);
    to[length] = '\0';
}

dttmm_status overall_matrix(dttmm_modal* modal, double frequency, uint32_t* rows, uint32_t* columns, double* matrix,
                            char* text, uint32_t size, dttmm_error* error) {
    return guard(error, [&] {
        const auto written = modal->analysis.overall_matrix(frequency);
        *rows = as_whole<uint32_t>(written.U.rows());
        *columns = as_whole<uint32_t>(written.U.cols());
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        if (matrix) Eigen::Map<RowMajor>(matrix, written.U.rows(), written.U.cols()) = written.U;
        if (!text || size == 0) return;
        std::string lines;
        for (const auto* side : {&written.rows, &written.columns})
            for (const auto& line : *side) lines += line.name + "\t" + line.unit + "\n";
        copy_text(lines, text, size);
    });
}

dttmm_status overall(dttmm_modal* modal, double frequency, dttmm_overall* overall, char* layout, uint32_t size,
                     dttmm_error* error) {
    return guard(error, [&] {
        const dttmm::plugin::OverallTransfer& topology = modal->analysis.topology();
        if (layout && size > 0) copy_text(topology.layout(), layout, size);
        *overall = {as_whole<uint32_t>(topology.rows()), as_whole<uint32_t>(topology.columns()), 1, 0, 0};
        const auto check = modal->analysis.overall(frequency);
        overall->smallest = check.smallest;
        overall->sign = check.sign;
        overall->log10_determinant = check.log10_determinant;
    });
}

std::vector<std::span<const dttmm_harmonic>> cases_of(uint32_t count, const uint32_t* ends, const dttmm_harmonic* loads) {
    std::vector<std::span<const dttmm_harmonic>> cases;
    for (uint32_t c = 0, begin = 0; c < count; begin = ends[c++]) cases.emplace_back(loads + begin, ends[c] - begin);
    return cases;
}

dttmm_status respond(dttmm_modal* modal, double frequency, uint32_t case_count, const uint32_t* ends,
                     const dttmm_harmonic* loads, const dttmm_harmonic_result* result, dttmm_error* error) {
    return guard(error, [&] { modal->analysis.respond(frequency, cases_of(case_count, ends, loads), *result); });
}

dttmm_status respond_beside(dttmm_modal* modal, dttmm_modal* middle, double frequency, uint32_t case_count,
                            const uint32_t* ends, const dttmm_harmonic* loads, const dttmm_harmonic_result* result,
                            dttmm_error* error) {
    return guard(error, [&] {
        modal->analysis.respond_beside(middle->analysis, frequency, cases_of(case_count, ends, loads), *result);
    });
}

dttmm_status begin_static(dttmm_instance* instance, dttmm_error* error) {
    return guard(error, [&] { instance->machine.begin_statics(); });
}

dttmm_status keep_static(dttmm_instance* instance, dttmm_error* error) {
    return guard(error, [&] { instance->machine.keep_statics(); });
}

dttmm_status recall_static(dttmm_instance* instance, dttmm_error* error) {
    return guard(error, [&] { instance->machine.recall_statics(); });
}

dttmm_status set_static_loads(dttmm_instance* instance, const double gravity[3], const double* loads, dttmm_error* error) {
    return guard(error, [&] { instance->machine.set_static_loads(gravity, loads); });
}

dttmm_status form_static(dttmm_instance* instance, const dttmm_motion* bodies, double resistance, double* wrench,
                         double* stiffness, dttmm_error* error) {
    return guard(error, [&] { instance->machine.form_static(bodies, resistance, wrench, stiffness); });
}

dttmm_status correct_static(dttmm_instance* instance, const double* change, dttmm_static_measure* measure,
                            dttmm_error* error) {
    return guard(error, [&] { instance->machine.correct_static(change, measure); });
}

dttmm_status move_static(dttmm_instance* instance, const dttmm_motion* bodies, double share, double* wrench,
                         dttmm_static_measure* measure, dttmm_error* error) {
    return guard(error, [&] { instance->machine.move_static(bodies, share, wrench, measure); });
}

dttmm_status start_static(dttmm_instance* instance, const dttmm_step* step, const dttmm_motion* bodies, const double* loads,
                          dttmm_error* error) {
    return guard(error, [&] { instance->machine.start_at_rest(*step, bodies, loads); });
}

dttmm_status move_supports(dttmm_instance* instance, const dttmm_support_motion* motions, dttmm_error* error) {
    return guard(error, [&] { instance->machine.move_supports(motions); });
}

const uint32_t* lines(const dttmm_instance* instance, uint32_t* count) {
    *count = static_cast<uint32_t>(instance->machine.lines().size());
    return instance->machine.lines().data();
}

dttmm_status positions(const dttmm_instance* instance, uint32_t stations, double* positions, dttmm_error* error) {
    return guard(error, [&] { instance->machine.positions(stations, positions); });
}

double force_at_start(const dttmm_modal* modal, uint32_t element) { return modal->analysis.force_at_start(element); }

double bent_at_rest(const dttmm_modal* modal, uint32_t element, int32_t* is_lumped) {
    bool lumped = false;
    const double share = modal->analysis.bent_at_rest(element, lumped);
    *is_lumped = lumped ? 1 : 0;
    return share;
}

dttmm_status count_growing(dttmm_modal* modal, int32_t slack, uint32_t* count, dttmm_error* error) {
    return guard(error, [&] { *count = static_cast<uint32_t>(modal->analysis.count_growing(slack)); });
}

dttmm_status count_free(dttmm_modal* modal, uint32_t* count, dttmm_error* error) {
    return guard(error, [&] { *count = static_cast<uint32_t>(modal->analysis.count_free()); });
}

dttmm_plugin& table();

dttmm_status add_law(const dttmm_law* law, const dttmm_law* volatile* at_work, dttmm_error* error) {
    return guard(error, [&] {
        if (law == nullptr || at_work == nullptr) throw Error(DTTMM_ERROR_ARGUMENT, "no law");
        dttmm::plugin::add_law(*law, at_work);
        const auto types = dttmm::plugin::element_types();
        table().element_type_count = as_whole<uint32_t>(types.size());
        table().element_types = types.data();
    });
}

dttmm_status fit(uint32_t type, const double* values, uint32_t direction, dttmm_fit* fit, dttmm_error* error) {
    return guard(error, [&] {
        if (fit == nullptr || direction > 5) throw Error(DTTMM_ERROR_ARGUMENT, "a direction is one of six");
        *fit = {};
        const auto element = dttmm::plugin::make_element(type, values);
        const auto* joint = dynamic_cast<const dttmm::plugin::SingleJoint*>(element.get());
        const auto law =
            joint ? std::dynamic_pointer_cast<const dttmm::plugin::Viscoelastic>(joint->law().laws[direction]) : nullptr;
        if (!law) return;
        const auto misfit = law->misfit();
        *fit = {as_whole<uint32_t>(law->series().terms.size()), misfit.share, misfit.omega / (2 * M_PI)};
    });
}

const void* extension(const char* name) {
    static constexpr dttmm_modal_table kModal = {sizeof(dttmm_modal_table),
                                                 create_modal,
                                                 destroy_modal,
                                                 find_modes,
                                                 mode,
                                                 mode_along,
                                                 overall,
                                                 force_at_start,
                                                 bent_at_rest,
                                                 count_growing,
                                                 strain_directions,
                                                 overall_matrix,
                                                 count_free};
    static constexpr dttmm_response_table kResponse = {
        sizeof(dttmm_response_table), respond, is_axial, find_damped, damped_mode, set_damping};
    static constexpr dttmm_state_table kState = {sizeof(dttmm_state_table), state_size, save_state, restore_state};
    static constexpr dttmm_derivative_table kDerivative = {sizeof(dttmm_derivative_table), centre, frequency_changes,
                                                           respond_beside};
    static constexpr dttmm_laws_table kLaws = {sizeof(dttmm_laws_table), add_law, fit};
    static constexpr dttmm_static_table kStatic = {sizeof(dttmm_static_table),
                                                   begin_static,
                                                   keep_static,
                                                   recall_static,
                                                   set_static_loads,
                                                   form_static,
                                                   correct_static,
                                                   move_static,
                                                   start_static};
    static constexpr dttmm_support_table kSupport = {sizeof(dttmm_support_table), move_supports};
    static constexpr dttmm_shape_table kShape = {sizeof(dttmm_shape_table), lines, positions};
    const std::string_view wanted = name;
    if (wanted == DTTMM_MODAL) return &kModal;
    if (wanted == DTTMM_RESPONSE) return &kResponse;
    if (wanted == DTTMM_STATE) return &kState;
    if (wanted == DTTMM_DERIVATIVE) return &kDerivative;
    if (wanted == DTTMM_STATIC) return &kStatic;
    if (wanted == DTTMM_SUPPORT) return &kSupport;
    if (wanted == DTTMM_SHAPE) return &kShape;
    if (wanted == DTTMM_LAWS) return &kLaws;
    return nullptr;
}

dttmm_plugin& table() {
    static dttmm_plugin plugin = {
        sizeof(dttmm_plugin),
        DTTMM_PLUGIN_MAJOR,
        DTTMM_PLUGIN_MINOR,
        "dttmm transfer matrices",
        DTTMM_VERSION,
        as_whole<uint32_t>(dttmm::plugin::element_types().size()),
        dttmm::plugin::element_types().data(),
        create,
        destroy,
        blocks,
        linearise,
        start,
        begin_step,
        evaluate,
        commit_step,
        discard_step,
        is_implicit,
        load_weights,
        channel_count,
        channels,
        outputs,
        extension,
        part_count,
        iterate,
        mean_wrench,
        stand,
        take_up,
    };
    return plugin;
}

}  // namespace

const dttmm_plugin* dttmm_plugin_entry(uint32_t host_major) { return host_major == DTTMM_PLUGIN_MAJOR ? &table() : nullptr; }
