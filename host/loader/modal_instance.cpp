// SPDX-License-Identifier: BSD-3-Clause
#include "loader/modal_instance.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "loader/plugin_call.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

dttmm_error cleared() {
    dttmm_error error;
    error.element = -1;
    error.text[0] = '\0';
    return error;
}

void no_destroy(dttmm_modal*) {}

}  // namespace

template <class Action>
void ModalInstance::ask(Action&& action) const {
    const PluginCall at_work(plugin_.name(), &element_names_, &at_work_);
    dttmm_error error = cleared();
    dttmm_status status = DTTMM_OK;
    try {
        status = action(&error);
    } catch (...) {
        throw NetworkError(ExitCode::plugin_failure, fmt::format("plugin {}: {}", plugin_.name(), describe_exception()), -1);
    }
    refuse_changed_arithmetic("plugin " + plugin_.name());
    check(status, error);
}

ModalInstance::~ModalInstance() {
    if (!modal_) return;
    const PluginCall at_work(plugin_.name());
    modal_.reset();
}

ModalInstance::ModalInstance(const PluginLibrary& plugin, const dttmm_modal_model& model)
    : plugin_(plugin),
      table_(plugin.modal()),
      modal_(nullptr, no_destroy),
      body_count_(model.network->body_count),
      node_count_(model.network->node_count),
      constraint_count_(model.constraint_count) {
    if (!table_)
        throw Error(ExitCode::plugin_failure,
                    fmt::format("plugin {} knows histories only, no natural frequencies", plugin.name()));
    for (uint32_t e = 0; e < model.network->element_count; ++e) element_names_.emplace_back(model.network->elements[e].name);
    dttmm_network network = *model.network;
    network.at_work = &at_work_;
    dttmm_modal_model watched = model;
    watched.network = &network;
    dttmm_modal* modal = nullptr;
    ask([&](dttmm_error* error) { return table_->create(&watched, &modal, error); });
    if (!modal) blame("create returned no model");
    modal_ = {modal, table_->destroy};
}

void ModalInstance::blame(const std::string& text) const {
    throw NetworkError(ExitCode::plugin_failure, fmt::format("plugin {}: {}", plugin_.name(), text), -1);
}

/// What the plugin has written must be whole and finite.
void ModalInstance::check(const GuardedArray& array, const char* name) const {
    if (const char* end = array.overrun()) blame(fmt::format("it wrote past the {} of the {} array", end, name));
    for (size_t i = 0; i < array.size(); ++i)
        if (!std::isfinite(array[i])) blame(fmt::format("a number of the {} array is {}", name, array[i]));
}

uint32_t ModalInstance::find_modes(uint32_t count, double below) {
    constexpr uint32_t kMostModes = 1'000'000;
    uint32_t found = 0;
    ask([&](dttmm_error* error) { return table_->find_modes(modal_.get(), count, below, &found, error); });
    if (found > kMostModes)
        blame(fmt::format("it says that it has found {} modes; at most {} are taken", found, kMostModes));
    return found;
}

ModalInstance::Mode ModalInstance::mode(uint32_t index) {
    Mode mode;
    GuardedArray bodies(6 * body_count_), nodes(6 * node_count_), shares(element_names_.size());
    ask([&](dttmm_error* error) {
        return table_->mode(modal_.get(), index, &mode.numbers, bodies.data(), nodes.data(), shares.data(), error);
    });
    check(bodies, "shape of bodies");
    check(nodes, "shape of nodes");
    check(shares, "shares of energy");
    const dttmm_mode& m = mode.numbers;
    if (!std::isfinite(m.frequency + m.bracket + m.mass) || m.mass < 0)
        blame(fmt::format("mode {}: frequency {}, modal mass {}: not finite, or less than nothing", index + 1, m.frequency,
                          m.mass));
    const auto list = [](const GuardedArray& from) {
        std::vector<Vector6> to(from.size() / 6);
        for (size_t i = 0; i < to.size(); ++i) to[i] = Eigen::Map<const Vector6>(from.data() + 6 * i);
        return to;
    };
    mode.bodies = list(bodies);
    mode.nodes = list(nodes);
    mode.shares.assign(shares.data(), shares.data() + shares.size());
    return mode;
}

std::vector<double> ModalInstance::frequency_changes(uint32_t first, uint32_t multiplicity, ModalInstance& above,
                                                     ModalInstance& below) {
    const dttmm_derivative_table* derivative = plugin_.derivative();
    if (!derivative || !derivative->frequency_changes)
        throw Error(ExitCode::plugin_failure, fmt::format("plugin {} is without the derivatives of frequencies, extension "
                                                          "{}",
                                                          plugin_.name(), DTTMM_DERIVATIVE));
    GuardedArray changes(multiplicity);
    ask([&](dttmm_error* error) {
        return derivative->frequency_changes(modal_.get(), first, above.modal_.get(), below.modal_.get(), changes.data(),
                                             error);
    });
    check(changes, "changes of a frequency");
    return {changes.data(), changes.data() + multiplicity};
}

std::vector<ModalInstance::Vector6> ModalInstance::along(uint32_t index, uint32_t element, uint32_t count, double& length) {
    GuardedArray own(6 * size_t{count});
    ask([&](dttmm_error* error) {
        return table_->mode_along(modal_.get(), index, element, count, &length, own.data(), error);
    });
    check(own, "shape along an element");
    if (!std::isfinite(length)) blame(fmt::format("an element has the length {}", length));
    std::vector<Vector6> shape;
    for (uint32_t i = 0; length > 0 && i < count; ++i) shape.emplace_back(Eigen::Map<const Vector6>(own.data() + 6 * i));
    return shape;
}

std::string ModalInstance::layout() {
    dttmm_overall overall{};
    std::string text(1 << 20, '\0');
    ask([&](dttmm_error* error) {
        table_->overall(modal_.get(), 0, &overall, text.data(), as_whole<uint32_t>(text.size()), error);
        return DTTMM_OK;
    });
    text.resize(::strnlen(text.data(), text.size()));
    std::string lines;
    for (size_t end; !text.empty(); text.erase(0, end == text.npos ? end : end + 1)) {
        end = text.find('\n');
        lines += printable(std::string_view(text).substr(0, end)) + '\n';
    }
    return lines;
}

dttmm_overall ModalInstance::overall(double frequency) {
    dttmm_overall overall{};
    ask([&](dttmm_error* error) { return table_->overall(modal_.get(), frequency, &overall, nullptr, 0, error); });
    return overall;
}

ModalInstance::OverallMatrix ModalInstance::overall_matrix(double frequency) {
    constexpr uint32_t kMostLines = 4096, kMostText = 1 << 20;  // OverallTransfer writes out 400 rows at most
    if (!table_->overall_matrix)
        throw Error(ExitCode::plugin_failure,
                    fmt::format("plugin {} does not write its overall transfer matrix out", plugin_.name()));
    uint32_t rows = 0, columns = 0;
    const auto call = [&](double* matrix, char* text) {
        ask([&](dttmm_error* error) {
            return table_->overall_matrix(modal_.get(), frequency, &rows, &columns, matrix, text, text ? kMostText : 0,
                                          error);
        });
    };
    call(nullptr, nullptr);
    if (rows > kMostLines || columns > kMostLines)
        blame(fmt::format("its overall matrix has {} x {} entries", rows, columns));
    GuardedArray matrix(size_t{rows} * columns);
    std::string text(kMostText, '\0');
    const uint32_t first_rows = rows, first_columns = columns;
    call(matrix.data(), text.data());
    if (rows != first_rows || columns != first_columns) blame("its overall matrix has another size when asked again");
    check(matrix, "overall matrix");
    text.resize(::strnlen(text.data(), text.size()));
    OverallMatrix found;
    found.U = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(matrix.data(), rows,
                                                                                                       columns);
    size_t begin = 0;
    for (uint32_t i = 0; i < rows + columns; ++i) {
        const size_t end = std::min(text.find('\n', begin), text.size()), tab = text.find('\t', begin);
        if (tab == text.npos || tab > end) blame("its overall matrix has rows or columns without a name");
        (i < rows ? found.rows : found.columns)
            .emplace_back(printable(std::string_view(text).substr(begin, tab - begin)),
                          printable(std::string_view(text).substr(tab + 1, end - tab - 1)));
        begin = std::min(end + 1, text.size());
    }
    return found;
}

std::vector<ModalInstance::Response> ModalInstance::respond(double frequency, const std::vector<Loads>& cases,
                                                            bool with_forces) {
    if (!plugin_.response())
        throw Error(ExitCode::plugin_failure,
                    fmt::format("plugin {} knows natural frequencies only, no response", plugin_.name()));
    std::vector<dttmm_harmonic> loads;
    std::vector<uint32_t> ends;
    for (const Loads& own : cases) {
        loads.insert(loads.end(), own.begin(), own.end());
        ends.push_back(as_whole<uint32_t>(loads.size()));
    }
    const size_t element_count = with_forces ? element_names_.size() : 0,
                 constraint_count = with_forces ? constraint_count_ : 0;
    GuardedArray bodies(12 * cases.size() * body_count_), nodes(12 * cases.size() * node_count_),
        elements(24 * cases.size() * element_count), constraints(12 * cases.size() * constraint_count);
    const dttmm_harmonic_result result = {bodies.data(), nodes.data(), with_forces ? elements.data() : nullptr,
                                          with_forces ? constraints.data() : nullptr};
    ask([&](dttmm_error* error) {
        const auto count = as_whole<uint32_t>(cases.size());
        if (middle_)
            return plugin_.derivative()->respond_beside(modal_.get(), middle_->modal_.get(), frequency, count, ends.data(),
                                                        loads.data(), &result, error);
        return plugin_.response()->respond(modal_.get(), frequency, count, ends.data(), loads.data(), &result, error);
    });
    check(bodies, "response of bodies");
    check(nodes, "response of nodes");
    check(elements, "response of elements");
    check(constraints, "response of constraints");
    std::vector<Response> responses(cases.size());
    for (size_t c = 0; c < cases.size(); ++c) {
        const auto list = [&](const GuardedArray& from, size_t count, size_t half = 0, size_t halves = 1) {
            std::vector<Complex6> to(count);
            for (size_t k = 0; k < count; ++k)
                for (size_t d = 0; d < 6; ++d) {
                    const size_t at = 12 * (halves * (c * count + k) + half) + 2 * d;
                    to[k](as_row(d)) = {from[at], from[at + 1]};
                }
            return to;
        };
        responses[c] = {list(bodies, body_count_), list(nodes, node_count_), list(elements, element_count, 0, 2),
                        list(elements, element_count, 1, 2), list(constraints, constraint_count)};
    }
    return responses;
}

void ModalInstance::respond_beside(ModalInstance& middle) {
    const dttmm_derivative_table* derivative = plugin_.derivative();
    if (!derivative || !derivative->respond_beside)
        throw Error(ExitCode::plugin_failure, fmt::format("plugin {} is without the derivatives of responses, extension {}",
                                                          plugin_.name(), DTTMM_DERIVATIVE));
    middle_ = &middle;
}

bool ModalInstance::is_axial(uint32_t element) const {
    const dttmm_response_table* table = plugin_.response();
    return table && table->is_axial && table->is_axial(modal_.get(), element) != 0;
}

void ModalInstance::set_damping(double mass_rate, const std::vector<double>& ratios, double below) {
    const dttmm_response_table* table = plugin_.response();
    if (!table || !table->set_damping)
        throw Error(ExitCode::plugin_failure, fmt::format("plugin {} knows no damping of modes", plugin_.name()));
    ask([&](dttmm_error* error) {
        return table->set_damping(modal_.get(), mass_rate, as_whole<uint32_t>(ratios.size()), ratios.data(), below, error);
    });
}

std::vector<ModalInstance::Damped> ModalInstance::find_damped(double below, int32_t& is_proved) {
    const dttmm_response_table* table = plugin_.response();
    if (!table || !table->find_damped || !table->damped_mode)
        throw Error(ExitCode::plugin_failure, fmt::format("plugin {} knows no modes with damping", plugin_.name()));
    uint32_t count = 0;
    ask([&](dttmm_error* error) { return table->find_damped(modal_.get(), below, &count, &is_proved, error); });
    std::vector<Damped> modes(count);
    for (uint32_t m = 0; m < count; ++m) {
        GuardedArray bodies(12 * body_count_), nodes(12 * node_count_);
        dttmm_damped_mode numbers{};
        ask([&](dttmm_error* error) {
            return table->damped_mode(modal_.get(), m, &numbers, bodies.data(), nodes.data(), error);
        });
        check(bodies, "damped shape of bodies");
        check(nodes, "damped shape of nodes");
        modes[m].s = {numbers.s[0], numbers.s[1]};
        modes[m].correction = numbers.correction;
        for (const auto& [from, to] : {std::pair(&bodies, &modes[m].bodies), {&nodes, &modes[m].nodes}})
            for (size_t k = 0; k + 12 <= from->size(); k += 12) {
                Complex6& u = to->emplace_back();
                for (size_t d = 0; d < 6; ++d) u(as_row(d)) = {(*from)[k + 2 * d], (*from)[k + 2 * d + 1]};
            }
    }
    return modes;
}

std::vector<ModalInstance::Vector6> ModalInstance::strain_directions(uint32_t index) {
    if (!table_->strain_directions) return {};
    GuardedArray shares(6 * element_names_.size());
    ask([&](dttmm_error* error) { return table_->strain_directions(modal_.get(), index, shares.data(), error); });
    check(shares, "strain energy by direction");
    std::vector<Vector6> list(element_names_.size());
    for (size_t e = 0; e < list.size(); ++e) list[e] = Eigen::Map<const Vector6>(shares.data() + 6 * e);
    return list;
}

uint32_t ModalInstance::count_growing(int slack) {
    if (!table_->count_growing) blame("it does not count motions that grow");
    uint32_t count = 0;
    ask([&](dttmm_error* error) { return table_->count_growing(modal_.get(), slack, &count, error); });
    return count;
}

std::optional<uint32_t> ModalInstance::count_free() {
    if (!table_->count_free) return std::nullopt;
    uint32_t count = 0;
    ask([&](dttmm_error* error) { return table_->count_free(modal_.get(), &count, error); });
    return count;
}

double ModalInstance::bent_at_rest(uint32_t element, bool& is_lumped) const {
    double share = 0;
    int32_t lumped = 0;
    if (table_->bent_at_rest)
        ask([&](dttmm_error*) {
            share = table_->bent_at_rest(modal_.get(), element, &lumped);
            return DTTMM_OK;
        });
    is_lumped = lumped != 0;
    return share;
}

double ModalInstance::force_at_start(uint32_t element) const {
    double force = 0;
    if (table_->force_at_start)
        ask([&](dttmm_error*) {
            force = table_->force_at_start(modal_.get(), element);
            return DTTMM_OK;
        });
    return force;
}

void ModalInstance::check(dttmm_status status, const dttmm_error& error) const {
    if (status == DTTMM_OK) return;
    const size_t length = ::strnlen(error.text, sizeof error.text);
    const std::string text = length > 0 ? printable({error.text, length}) : fmt::format("status {} without a text", status);
    const bool is_named = error.element >= 0 && as_size(error.element) < element_names_.size();
    throw NetworkError(exit_code_of(status),
                       is_named ? fmt::format("element \"{}\": {}", element_names_[as_size(error.element)], text) : text,
                       is_named ? error.element : -1);
}

}  // namespace dttmm::host
