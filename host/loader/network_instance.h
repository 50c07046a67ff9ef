// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "loader/guarded_array.h"
#include "loader/plugin_call.h"
#include "loader/plugin_library.h"
#include "model/channel.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

/// A failure of a plugin that may blame one element.
class NetworkError : public Error {
public:
    NetworkError(ExitCode code, const std::string& text, int element) : Error(code, text), element_(element) {}
    int element() const { return element_; }  ///< of the network; -1: none is blamed

private:
    int element_;
};

/// The exit code of a plugin's failure: numerical_failure for DTTMM_DISCARD, _SINGULAR and _NUMERIC, model_invalid for what
/// create refuses, resource_limit for memory, plugin_failure for the rest.
ExitCode exit_code_of(dttmm_status status);

/// The elements of a model that are of one plugin, inside that: the C interface as a C++ object. Arguments, units and phases
/// are those of dttmm_plugin.h. A failure becomes NetworkError with its exit code. Its text begins with the plugin's and,
/// where known, the element's name. The calls of a step are inline: an indirect call, one compare and a handful of stores
/// each. An exception that a plugin throws across the interface is a failure of the plugin.
class NetworkInstance {
public:
    NetworkInstance(const PluginLibrary& plugin, const dttmm_network& network);
    NetworkInstance(NetworkInstance&&) noexcept = default;  // no assignment: an instance must go before its library
    ~NetworkInstance();

    /// As it was when the instance was made: the plugin is not asked again.
    std::span<const dttmm_block> blocks() const { return blocks_; }
    bool is_implicit() const {
        return call([&] { return table_->is_implicit(instance_.get()); }) != 0;
    }
    void load_weights(double weights[3]) const;

    void linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
        ask([&](dttmm_error* error) {
            return table_->linearise(instance_.get(), bodies, wrench, stiffness, damping, error);
        });
    }
    void start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads) {
        PluginCall::set_time(step.time);
        ask([&](dttmm_error* error) { return table_->start(instance_.get(), &step, bodies, accelerations, loads, error); });
    }
    void begin_step(const dttmm_step& step, const double* loads) {
        PluginCall::set_time(step.time);
        ask([&](dttmm_error* error) { return table_->begin_step(instance_.get(), &step, loads, error); });
    }
    /// How many parts of it find a motion of their own.
    size_t part_count() const { return progress_.size(); }
    /// One iteration of them. Throws NetworkError(plugin_failure) where it tells no finite numbers of their progress.
    std::span<const dttmm_progress> iterate(const dttmm_motion* trial);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const {
        ask([&](dttmm_error* error) { return table_->evaluate(instance_.get(), trial, wrench, stiffness, error); });
    }
    void commit_step(const dttmm_motion* accepted) {
        ask([&](dttmm_error* error) { return table_->commit_step(instance_.get(), accepted, error); });
    }
    void discard_step() {
        ask([&](dttmm_error* error) { return table_->discard_step(instance_.get(), error); });
    }

    /// Whether the plugin has the two that follow.
    bool stands() const { return table_->mean_wrench && table_->stand; }
    void mean_wrench(double* wrench) {
        ask([&](dttmm_error* error) { return table_->mean_wrench(instance_.get(), wrench, error); });
    }
    void stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) {
        ask([&](dttmm_error* error) { return table_->stand(instance_.get(), bodies, accelerations, wrench, error); });
    }
    /// Whether the plugin tells elements apart.
    bool takes_up() const { return table_->take_up; }
    void take_up(const double* motion, double* elastic, double* damped) const {
        ask([&](dttmm_error* error) { return table_->take_up(instance_.get(), motion, elastic, damped, error); });
    }

    /// Elements that bend, by their indices; none: the plugin tells nothing of them. See dttmm_shape.h.
    std::span<const uint32_t> lines() const { return lines_; }
    void positions(uint32_t stations, double* positions) const {
        ask([&](dttmm_error* error) { return plugin_.shapes()->positions(instance_.get(), stations, positions, error); });
    }

    /// See dttmm_support.h; only if has_supports().
    bool has_supports() const { return plugin_.supports() != nullptr; }
    void move_supports(const dttmm_support_motion* motions) {
        ask([&](dttmm_error* error) { return plugin_.supports()->move(instance_.get(), motions, error); });
    }

    /// See dttmm_derivative.h; only if has_derivative().
    bool has_derivative() const { return plugin_.derivative() && plugin_.derivative()->centre; }
    void centre(NetworkInstance& above, NetworkInstance& below) const {
        ask([&](dttmm_error* error) {
            return plugin_.derivative()->centre(above.instance_.get(), below.instance_.get(), instance_.get(), error);
        });
    }

    // At rest, see dttmm_static.h; only if has_statics().
    const dttmm_instance* at_rest() const { return instance_.get(); }
    bool has_statics() const { return plugin_.statics() != nullptr; }
    void begin_statics() {
        ask([&](dttmm_error* error) { return plugin_.statics()->begin(instance_.get(), error); });
    }
    void keep_statics() {
        ask([&](dttmm_error* error) { return plugin_.statics()->keep(instance_.get(), error); });
    }
    void recall_statics() {
        ask([&](dttmm_error* error) { return plugin_.statics()->recall(instance_.get(), error); });
    }
    void set_static_loads(const double gravity[3], const double* loads) {
        ask([&](dttmm_error* error) { return plugin_.statics()->set_loads(instance_.get(), gravity, loads, error); });
    }
    void form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness) {
        ask([&](dttmm_error* error) {
            return plugin_.statics()->form(instance_.get(), bodies, resistance, wrench, stiffness, error);
        });
    }
    dttmm_static_measure correct_static(const double* change);
    dttmm_static_measure move_static(const dttmm_motion* bodies, double share, double* wrench);
    void start_at_rest(const dttmm_step& step, const dttmm_motion* bodies, const double* loads) {
        PluginCall::set_time(step.time);
        ask([&](dttmm_error* error) { return plugin_.statics()->start(instance_.get(), &step, bodies, loads, error); });
    }

    /// As they were when the instance was made: the plugin is not asked again.
    size_t channel_count() const { return roles_.size(); }
    Channel channel(size_t index) const;
    /// One per channel: a DTTMM_ROLE.
    const std::vector<uint8_t>& roles() const { return roles_; }
    static bool is_energy(uint8_t role) { return role >= DTTMM_ROLE_STRAIN_ENERGY && role <= DTTMM_ROLE_WORK; }
    /// Channels that are not energies stand first among `others` too, in the same order, and these stay there as long as
    /// channels are asked for: the own ones are dropped. Returns the rest of the others.
    std::span<const Channel> share_channels(std::span<const Channel> others);
    void outputs(double* values) const {
        ask([&](dttmm_error* error) { return table_->outputs(instance_.get(), values, error); });
    }
    const std::string& plugin_name() const { return plugin_.name(); }
    /// The element that the plugin blames, or else works on, or its only one; −1: that is not known.
    int culprit(int blamed) const {
        if (is_named(blamed)) return blamed;
        return element_names_.size() == 1 ? 0 : is_named(*at_work_) ? *at_work_ : -1;
    }
    size_t element_count() const { return element_names_.size(); }
    const std::string& element_name(uint32_t element) const { return element_names_[element]; }
    /// How messages call all of it: `bolt1`, or `elements of plugin spring.so`.
    std::string name() const;
    /// Throws NetworkError(plugin_failure) of what the plugin has done in its last call, naming the element if it is known.
    /// `element "bolt1" (plugin ..)`, or the plugin alone where the element is none.
    std::string whose(int element) const;
    [[noreturn]] void blame(const std::string& text) const;

private:
    static dttmm_error* cleared(dttmm_error& error) {
        error.element = -1;
        error.text[0] = '\0';
        return &error;
    }
    void check(dttmm_status status, const dttmm_error& error) const {
        if (status != DTTMM_OK) [[unlikely]]
            fail(status, error);
    }
    /// What `action`, one call of the plugin, returns.
    template <class Action>
    std::invoke_result_t<Action> call(Action&& action) const {
        const PluginCall at_work(plugin_.name(), &element_names_, at_work_.get());
        try {
            if constexpr (std::is_void_v<std::invoke_result_t<Action>>) {
                action();
                refuse_changed_mode();
            } else {
                const auto answer = action();
                refuse_changed_mode();
                return answer;
            }
        } catch (const NetworkError&) {
            throw;
        } catch (...) {
            fail_by_exception();
        }
    }
    /// The same, and throws what the call says of a failure.
    template <class Action>
    void ask(Action&& action) const {
        dttmm_error error;
        check(call([&] { return action(cleared(error)); }), error);
    }
    void refuse_changed_mode() const {
        if (const char* what = changed_mode()) [[unlikely]]
            blame(fmt::format("it has changed {}", what));
    }
    [[noreturn]] void fail_by_exception() const;
    [[noreturn]] void fail(dttmm_status status, const dttmm_error& error) const;
    [[noreturn]] void fail(dttmm_status status, int element, const std::string& text) const;
    dttmm_static_measure checked(const dttmm_static_measure& measure) const;
    bool is_named(int element) const { return element >= 0 && as_size(element) < element_names_.size(); }
    void read_blocks(const dttmm_network& network);
    void read_channels(const dttmm_network& network);
    void read_parts();
    void read_lines();

    PluginLibrary plugin_;
    const dttmm_plugin* table_;
    std::unique_ptr<volatile int32_t> at_work_ = std::make_unique<volatile int32_t>(-1);  ///< the element it works on
    std::unique_ptr<dttmm_instance, void (*)(dttmm_instance*)> instance_;
    std::vector<std::string> element_names_;
    std::vector<dttmm_progress> progress_;
    GuardedArray own_progress_;
    std::vector<dttmm_block> blocks_;
    std::vector<Channel> channels_;    ///< of energies alone once the others are shared
    std::span<const Channel> shared_;  ///< those that are not energies
    std::vector<uint8_t> roles_;
    std::vector<uint32_t> lines_;
};

}  // namespace dttmm::host
