// SPDX-License-Identifier: BSD-3-Clause
#include "loader/modal_instance.h"

#include <fmt/format.h>

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
    check(status, error);
    refuse_changed_arithmetic();
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
      node_count_(model.network->node_count) {
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
    modal_ = {modal, table_->destroy};
}

uint32_t ModalInstance::find_modes(uint32_t count, double below) {
    uint32_t found = 0;
    ask([&](dttmm_error* error) { return table_->find_modes(modal_.get(), count, below, &found, error); });
    return found;
}

ModalInstance::Mode ModalInstance::mode(uint32_t index) {
    Mode mode;
    mode.bodies.resize(body_count_);
    mode.nodes.resize(node_count_);
    mode.shares.resize(element_names_.size());
    const auto data = [](std::vector<Vector6>& list) { return list.empty() ? nullptr : list.front().data(); };
    ask([&](dttmm_error* error) {
        return table_->mode(modal_.get(), index, &mode.numbers, data(mode.bodies), data(mode.nodes), mode.shares.data(),
                            error);
    });
    return mode;
}

std::vector<ModalInstance::Vector6> ModalInstance::along(uint32_t index, uint32_t element, uint32_t count, double& length) {
    std::vector<Vector6> shape(count, Vector6::Zero());
    ask([&](dttmm_error* error) {
        return table_->mode_along(modal_.get(), index, element, count, &length, shape.front().data(), error);
    });
    if (!(length > 0)) shape.clear();
    return shape;
}

std::string ModalInstance::layout() {
    dttmm_overall overall{};
    std::string text(1 << 20, '\0');
    ask([&](dttmm_error* error) {
        table_->overall(modal_.get(), 0, &overall, text.data(), static_cast<uint32_t>(text.size()), error);
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

ModalInstance::Response ModalInstance::respond(double frequency, int body, int node, const Eigen::Vector3d& point,
                                               const Vector6& wrench) {
    if (!plugin_.response())
        throw Error(ExitCode::plugin_failure,
                    fmt::format("plugin {} knows natural frequencies only, no response", plugin_.name()));
    Response response;
    response.bodies.resize(body_count_);
    response.nodes.resize(node_count_);
    // A complex number is its two parts in a row
    const auto data = [](std::vector<Complex6>& list) {
        return list.empty() ? nullptr : reinterpret_cast<double*>(list.front().data());
    };
    ask([&](dttmm_error* error) {
        return plugin_.response()->respond(modal_.get(), frequency, body, node, point.data(), wrench.data(),
                                           data(response.bodies), data(response.nodes), error);
    });
    return response;
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
