// SPDX-License-Identifier: BSD-3-Clause
#include "loader/network_instance.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>
#include <set>
#include <string_view>
#include <tuple>

#include "model/wording.h"

namespace dttmm::host {

namespace {

/// Of one network: 320 MB of declarations. A beam of 100 000 segments has a tenth of them.
constexpr uint32_t kMostChannels = 10'000'000;
constexpr const char* kBadChannel = "an output channel is not well declared";

}  // namespace

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
    PluginCall::set_time(std::numeric_limits<double>::quiet_NaN());
    dttmm_instance* instance = nullptr;
    ask([&](dttmm_error* error) { return table_->create(&network, &instance, error); });
    if (instance == nullptr) fail(DTTMM_ERROR_INTERNAL, -1, "create returned no instance");
    instance_.reset(instance);
    read_channels(network);
}

NetworkInstance::~NetworkInstance() {
    if (!instance_) return;
    const PluginCall at_work(plugin_.name(), element_names_.empty() ? nullptr : &element_names_.front(),
                             element_names_.size() > 1);
    instance_.reset();
}

bool NetworkInstance::is_declared(const dttmm_channel& channel, const dttmm_network& network) const {
    // Names become columns and datasets: no control character, no slash.
    const auto is_plain = [](const char* text) {
        if (!text || !*text) return false;
        for (; *text; ++text)
            if (static_cast<unsigned char>(*text) < ' ' || *text == '/' || *text == 127) return false;
        return true;
    };
    if (!is_plain(channel.name) || !channel.unit || channel.role > DTTMM_ROLE_LIMIT) return false;
    const bool is_energy = channel.role >= DTTMM_ROLE_STRAIN_ENERGY && channel.role <= DTTMM_ROLE_WORK;
    if (is_energy && std::strcmp(channel.unit, "J") != 0) return false;
    if (channel.role == DTTMM_ROLE_LIMIT && channel.of != DTTMM_OF_ELEMENT) return false;
    if (channel.of == DTTMM_OF_ELEMENT) return channel.index < network.element_count;
    // A port's motion is its body's, and the ground's is nobody's: their columns are not the plugin's.
    return channel.of == DTTMM_OF_NODE && channel.index < network.node_count &&
           (is_energy || network.nodes[channel.index].kind == DTTMM_NODE_INNER);
}

/// Asks once and keeps a copy: a plugin may say something else the next time.
void NetworkInstance::read_channels(const dttmm_network& network) {
    const uint32_t count = call([&] { return table_->channel_count(instance_.get()); });
    if (count > kMostChannels)
        fail(DTTMM_ERROR_INTERNAL, -1,
             fmt::format("it declares {} output channels; at most {} are taken", count, kMostChannels));
    const dttmm_channel* channels = call([&] { return table_->channels(instance_.get()); });
    const PluginCall at_work(plugin_.name(), element_names_.empty() ? nullptr : &element_names_.front(),
                             element_names_.size() > 1);  // its list may end too soon
    std::vector<dttmm_channel> list;
    std::set<std::tuple<uint32_t, uint32_t, std::string_view>> names;
    for (uint32_t c = 0; c < count; ++c) {
        if (!channels || !is_declared(channels[c], network)) fail(DTTMM_ERROR_INTERNAL, -1, kBadChannel);
        list.push_back(channels[c]);
        list.back().name = plugin_.keep(channels[c].name);
        list.back().unit = plugin_.keep(channels[c].unit);
        if (!names.emplace(list.back().of, list.back().index, list.back().name).second)
            fail(DTTMM_ERROR_INTERNAL, -1, kBadChannel);
    }
    channels_ = plugin_.keep(std::move(list));
}

std::vector<unsigned char> NetworkInstance::save_state() const {
    std::vector<unsigned char> state(call([&] { return table_->state_size(instance_.get()); }));
    ask([&](dttmm_error* error) { return table_->save_state(instance_.get(), state.data(), state.size(), error); });
    return state;
}

void NetworkInstance::restore_state(const std::vector<unsigned char>& state) {
    ask([&](dttmm_error* error) { return table_->restore_state(instance_.get(), state.data(), state.size(), error); });
}

void NetworkInstance::fail_by_exception() const { fail(DTTMM_ERROR_INTERNAL, -1, describe_exception()); }

void NetworkInstance::fail(dttmm_status status, const dttmm_error& error) const {
    const std::string text(error.text, ::strnlen(error.text, sizeof error.text));
    fail(status, error.element, text.empty() ? fmt::format("status {} without a text", status) : printable(text));
}

void NetworkInstance::fail(dttmm_status status, int element, const std::string& text) const {
    const bool is_named = element >= 0 && static_cast<size_t>(element) < element_names_.size();
    const std::string place =
        is_named ? fmt::format("element \"{}\"", element_names_[static_cast<size_t>(element)]) : label();
    throw NetworkError(exit_code_of(status), fmt::format("{} (plugin {}): {}", place, plugin_.name(), text),
                       is_named ? element : -1);
}

std::string NetworkInstance::label() const {
    if (element_names_.empty()) return "network without elements";
    return fmt::format("{}element \"{}\"", element_names_.size() > 1 ? "network of " : "", element_names_.front());
}

}  // namespace dttmm::host
