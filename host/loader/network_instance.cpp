// SPDX-License-Identifier: BSD-3-Clause
#include "loader/network_instance.h"

#include <fmt/format.h>

#include <cstring>
#include <set>
#include <tuple>

namespace dttmm {

ExitCode exit_code_of(dttmm_status status) {
    switch (status) {
        case DTTMM_ERROR_MODEL:
            return ExitCode::model_invalid;
        case DTTMM_DISCARD:
        case DTTMM_ERROR_SINGULAR:
        case DTTMM_ERROR_NUMERIC:
            return ExitCode::numerical_failure;
        case DTTMM_ERROR_MEMORY:
            return ExitCode::resource_limit;
        default:
            return ExitCode::plugin_failure;
    }
}

NetworkInstance::NetworkInstance(const PluginLibrary& plugin, const dttmm_network& network)
    : plugin_(plugin), table_(&plugin.table()), expect_(plugin.expect()), instance_(nullptr, table_->destroy) {
    for (uint32_t n = 0; n < network.node_count; ++n) port_count_ += network.nodes[n].kind == DTTMM_NODE_PORT;
    for (uint32_t n = 0; n < network.node_count; ++n) node_names_.emplace_back(network.nodes[n].name);
    for (uint32_t e = 0; e < network.element_count; ++e) element_names_.emplace_back(network.elements[e].name);
    dttmm_error error;
    dttmm_instance* instance = nullptr;
    check(table_->create(&network, &instance, cleared(error)), error);
    if (instance == nullptr) fail(DTTMM_ERROR_INTERNAL, {-1, "create returned no instance"});
    instance_.reset(instance);
    check_channels(network);
}

bool NetworkInstance::is_declared(const dttmm_channel& channel, const dttmm_network& network) const {
    // Names become columns and datasets: no control character, no slash.
    const auto is_plain = [](const char* text) {
        if (!text || !*text) return false;
        for (; *text; ++text)
            if (static_cast<unsigned char>(*text) < ' ' || *text == '/' || *text == 127) return false;
        return true;
    };
    if (!is_plain(channel.name) || !channel.unit || channel.role > DTTMM_ROLE_WORK) return false;
    const bool is_energy = channel.role >= DTTMM_ROLE_STRAIN_ENERGY;
    if (is_energy && std::strcmp(channel.unit, "J") != 0) return false;
    if (channel.of == DTTMM_OF_ELEMENT) return channel.index < network.element_count;
    // A port's motion is its body's, and the ground's is nobody's: their columns are not the plugin's.
    return channel.of == DTTMM_OF_NODE && channel.index < network.node_count &&
           (is_energy || network.nodes[channel.index].kind == DTTMM_NODE_INNER);
}

void NetworkInstance::check_channels(const dttmm_network& network) const {
    const dttmm_channel* channels = table_->channels(instance_.get());
    std::set<std::tuple<uint32_t, uint32_t, std::string>> names;
    for (uint32_t c = 0; c < channel_count(); ++c)
        if (!channels || !is_declared(channels[c], network) ||
            !names.emplace(channels[c].of, channels[c].index, channels[c].name).second)
            fail(DTTMM_ERROR_INTERNAL, {-1, "an output channel is not well declared"});
}

std::vector<unsigned char> NetworkInstance::save_state() const {
    std::vector<unsigned char> state(table_->state_size(instance_.get()));
    dttmm_error error;
    check(table_->save_state(instance_.get(), state.data(), state.size(), cleared(error)), error);
    return state;
}

void NetworkInstance::restore_state(const std::vector<unsigned char>& state) {
    dttmm_error error;
    check(table_->restore_state(instance_.get(), state.data(), state.size(), cleared(error)), error);
}

void NetworkInstance::fail(dttmm_status status, const dttmm_error& error) const {
    const size_t length = ::strnlen(error.text, sizeof error.text);
    const std::string text = length > 0 ? std::string(error.text, length) : fmt::format("status {} without a text", status);
    const bool is_named = error.element >= 0 && static_cast<size_t>(error.element) < element_names_.size();
    const std::string place =
        is_named ? fmt::format("element \"{}\"", element_names_[static_cast<size_t>(error.element)]) : label();
    throw NetworkError(exit_code_of(status), fmt::format("{} (plugin {}): {}", place, plugin_.name(), text),
                       is_named ? error.element : -1);
}

std::string NetworkInstance::label() const {
    if (element_names_.empty()) return "network without elements";
    return fmt::format("{}element \"{}\"", element_names_.size() > 1 ? "network of " : "", element_names_.front());
}

}  // namespace dttmm
