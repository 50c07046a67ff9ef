// SPDX-License-Identifier: BSD-3-Clause
#include "loader/network_instance.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string_view>

#include "loader/guarded_array.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// Of one network: 320 MB of declarations. A beam of 100 000 segments has a tenth of them.
constexpr uint32_t kMostChannels = 10'000'000;
constexpr uint32_t kMostParts = 1'000'000;

/// As a plugin declares it: "force.x", "section3.force.x", "turn_to_limit".
Channel channel_of(const dttmm_channel& declared, const dttmm_network& network) {
    const std::string_view name = declared.name;
    const size_t dot = std::min(name.rfind('.'), name.size());
    const bool is_of_element = declared.of == DTTMM_OF_ELEMENT;
    return Channel(is_of_element ? Channel::Of::element : Channel::Of::node,
                   is_of_element ? network.elements[declared.index].name : network.nodes[declared.index].name,
                   name.substr(0, dot), name.substr(std::min(dot + 1, name.size())), declared.unit,
                   declared.role == DTTMM_ROLE_RESULT);
}

/// What is wrong with a channel as it is declared; null: nothing. Names become columns and datasets.
const char* fault_of(const dttmm_channel& channel, const dttmm_network& network) {
    const auto is_text = [](const char* text) { return text && *text && is_printable(text); };
    if (!is_text(channel.name)) return "it has no name, or one that cannot be printed";
    if (std::strchr(channel.name, '/')) return "its name has a slash";
    if (!is_text(channel.unit)) return "it has no unit, or one that cannot be printed";
    if (channel.role > DTTMM_ROLE_LIMIT) return "there is no such role";
    const bool has_energy = NetworkInstance::is_energy(static_cast<uint8_t>(channel.role));
    if (has_energy && std::strcmp(channel.unit, "J") != 0) return "energy has the unit J";
    if (channel.of == DTTMM_OF_ELEMENT)
        return channel.index < network.element_count ? nullptr : "there is no element of that index";
    if (channel.of != DTTMM_OF_NODE) return "it is of neither a node nor an element";
    if (channel.role == DTTMM_ROLE_LIMIT) return "a limit is that of an element";
    if (channel.index >= network.node_count) return "there is no node of that index";
    // A port's motion is its body's, and the ground's is nobody's: their columns are not the plugin's.
    const bool is_own = has_energy || network.nodes[channel.index].kind == DTTMM_NODE_INNER;
    return is_own ? nullptr : "its node is on a body or on the ground, whose motion is not the plugin's";
}

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
    : plugin_(plugin), table_(&plugin.table()), instance_(nullptr, table_->destroy) {
    element_names_.reserve(network.element_count);
    for (uint32_t e = 0; e < network.element_count; ++e) element_names_.emplace_back(network.elements[e].name);
    PluginCall::set_time(std::numeric_limits<double>::quiet_NaN());
    dttmm_network watched = network;
    watched.at_work = at_work_.get();
    dttmm_instance* instance = nullptr;
    ask([&](dttmm_error* error) { return table_->create(&watched, &instance, error); });
    if (instance == nullptr) fail(DTTMM_ERROR_INTERNAL, -1, "create returned no instance");
    instance_.reset(instance);
    read_blocks(network);
    read_channels(network);
    read_parts();
    read_lines();
}

void NetworkInstance::load_weights(double weights[3]) const {
    GuardedArray own(3);
    call([&] { table_->load_weights(instance_.get(), own.data()); });
    if (own.overrun()) blame("it wrote more than three weights of loads");
    std::copy_n(own.data(), 3, weights);
}

NetworkInstance::~NetworkInstance() {
    if (!instance_) return;
    const PluginCall at_work(plugin_.name(), &element_names_, at_work_.get());
    instance_.reset();
}

void NetworkInstance::read_blocks(const dttmm_network& network) {
    uint32_t count = 0;
    const dttmm_block* blocks = call([&] { return table_->blocks(instance_.get(), &count); });
    const int32_t last = *at_work_;
    const PluginCall at_work(plugin_.name(), &element_names_, at_work_.get());  // its list may end too soon
    *at_work_ = last;
    std::set<std::pair<uint32_t, uint32_t>> pairs;
    for (uint32_t b = 0; b < count; ++b) {
        if (!blocks || blocks[b].row >= network.body_count || blocks[b].column >= network.body_count ||
            !pairs.emplace(blocks[b].row, blocks[b].column).second)
            fail(DTTMM_ERROR_INTERNAL, -1,
                 fmt::format("block {} of its matrices is no pair of bodies, or is there twice", b));
        blocks_.push_back(blocks[b]);
    }
    for (const auto& [row, column] : pairs)
        if (!pairs.contains({column, row}))
            fail(DTTMM_ERROR_INTERNAL, -1,
                 fmt::format("its matrices have a block ({}, {}), but none ({}, {})", row, column, column, row));
}

/// Asks once and keeps a copy: a plugin may say something else the next time.
void NetworkInstance::read_channels(const dttmm_network& network) {
    const uint32_t count = call([&] { return table_->channel_count(instance_.get()); });
    if (count > kMostChannels)
        fail(DTTMM_ERROR_INTERNAL, -1,
             fmt::format("it declares {} output channels; at most {} are taken", count, kMostChannels));
    const dttmm_channel* channels = call([&] { return table_->channels(instance_.get()); });
    const int32_t last = *at_work_;
    const PluginCall at_work(plugin_.name(), &element_names_, at_work_.get());  // its list may end too soon
    *at_work_ = last;
    channels_.reserve(count);
    roles_.reserve(count);
    for (uint32_t c = 0; c < count; ++c) {
        const char* const fault = channels ? fault_of(channels[c], network) : "there is no list of channels";
        if (fault) fail(DTTMM_ERROR_INTERNAL, -1, fmt::format("output channel {} is not well declared: {}", c, fault));
        channels_.push_back(channel_of(channels[c], network));
        roles_.push_back(static_cast<uint8_t>(channels[c].role));
    }
    if (!Channel::have_duplicates(channels_)) return;
    std::set<std::string> names;
    for (const Channel& channel : channels_)
        if (const std::string name = channel.name(); !names.insert(name).second)
            fail(DTTMM_ERROR_INTERNAL, -1, fmt::format("two output channels have the name {}", name));
}

Channel NetworkInstance::channel(size_t index) const {
    if (channels_.size() == roles_.size()) return channels_[index];
    const auto energies = as_size(std::ranges::count_if(roles_.begin(), roles_.begin() + as_row(index), is_energy));
    return is_energy(roles_[index]) ? channels_[energies] : shared_[index - energies];
}

std::span<const Channel> NetworkInstance::share_channels(std::span<const Channel> others) {
    std::vector<Channel> energies;
    for (size_t c = 0; c < roles_.size(); ++c)
        if (is_energy(roles_[c])) energies.push_back(channel(c));
    const size_t count = roles_.size() - energies.size();
    channels_.assign(energies.begin(), energies.end());
    channels_.shrink_to_fit();
    shared_ = others.first(count);
    return others.subspan(count);
}

void NetworkInstance::read_parts() {
    if (!table_->part_count) return;
    const uint32_t count = call([&] { return table_->part_count(instance_.get()); });
    if (count > kMostParts)
        fail(DTTMM_ERROR_INTERNAL, -1, fmt::format("it has {} parts that iterate; at most {} are taken", count, kMostParts));
    progress_.resize(count);
    own_progress_.resize(count * sizeof(dttmm_progress) / sizeof(double));
}

void NetworkInstance::read_lines() {
    if (!plugin_.shapes()) return;
    uint32_t count = 0;
    const uint32_t* lines = call([&] { return plugin_.shapes()->lines(instance_.get(), &count); });
    if (count == 0) return;
    if (!lines || count > element_names_.size())
        blame(fmt::format("lines() returns {} of its {} elements", count, element_names_.size()));
    lines_.assign(lines, lines + count);
    std::vector<uint32_t> sorted = lines_;
    std::ranges::sort(sorted);
    if (sorted.back() >= element_names_.size() || std::ranges::adjacent_find(sorted) != sorted.end())
        blame("lines() names an element that does not exist, or one element twice");
}

std::span<const dttmm_progress> NetworkInstance::iterate(const dttmm_motion* trial) {
    if (progress_.empty()) return {};
    auto* const own = reinterpret_cast<dttmm_progress*>(own_progress_.data());
    ask([&](dttmm_error* error) { return table_->iterate(instance_.get(), trial, own, error); });
    if (own_progress_.overrun()) blame("it wrote more of its progress than its parts have");
    std::memcpy(progress_.data(), own_progress_.data(), progress_.size() * sizeof(dttmm_progress));
    for (const dttmm_progress& part : progress_)
        for (const double number : {part.correction, part.previous, part.motion, part.enough, part.residual, part.impulse})
            if (!(number >= 0 && number <= std::numeric_limits<double>::max()))
                blame(fmt::format("the progress of its iteration is {}", number));
    return progress_;
}

dttmm_static_measure NetworkInstance::correct_static(const double* change) {
    dttmm_static_measure measure{};
    ask([&](dttmm_error* error) { return plugin_.statics()->correct(instance_.get(), change, &measure, error); });
    return checked(measure);
}

dttmm_static_measure NetworkInstance::move_static(const dttmm_motion* bodies, double share, double* wrench) {
    dttmm_static_measure measure{};
    ask([&](dttmm_error* error) {
        return plugin_.statics()->move(instance_.get(), bodies, share, wrench, &measure, error);
    });
    return checked(measure);
}

dttmm_static_measure NetworkInstance::checked(const dttmm_static_measure& measure) const {
    for (const double number :
         {measure.work, measure.residual, measure.force, measure.noise, measure.shift, measure.turn, measure.bend})
        if (!std::isfinite(number))
            fail(DTTMM_ERROR_NUMERIC, measure.element, "its forces at rest are not finite: its parts have moved too far");
    return measure;
}

void NetworkInstance::fail_by_exception() const { fail(DTTMM_ERROR_INTERNAL, -1, describe_exception()); }

void NetworkInstance::fail(dttmm_status status, const dttmm_error& error) const {
    const std::string text(error.text, ::strnlen(error.text, sizeof error.text));
    fail(status, error.element, text.empty() ? fmt::format("status {} without a text", status) : printable(text));
}

void NetworkInstance::fail(dttmm_status status, int blamed, const std::string& text) const {
    const int element = culprit(blamed);
    throw NetworkError(exit_code_of(status), fmt::format("{}: {}", whose(element), text), element);
}

void NetworkInstance::blame(const std::string& text) const { fail(DTTMM_ERROR_INTERNAL, -1, text); }

std::string NetworkInstance::whose(int element) const {
    if (element < 0) return fmt::format("plugin {}", plugin_.name());
    return fmt::format("element \"{}\" (plugin {})", element_names_[as_size(element)], plugin_.name());
}

std::string NetworkInstance::name() const {
    return element_names_.size() == 1 ? element_names_.front() : fmt::format("elements of plugin {}", plugin_.name());
}

}  // namespace dttmm::host
