// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>

namespace dttmm::host {

/// Lives while a plugin is at work: what ends the process meanwhile (a crash, exit) is the plugin's, and the last message
/// names it. Costs a handful of stores. Read by signal handlers: nothing here allocates.
class PluginCall {
public:
    /// element: the first of the network at work, which may have several; null: none. Both texts must outlive the call.
    explicit PluginCall(const std::string& plugin, const std::string* element = nullptr, bool is_network = false) noexcept
        : plugin_(plugin), element_(element), is_network_(is_network), before_(current_) {
        current_ = this;
    }
    ~PluginCall() { current_ = before_; }
    PluginCall(const PluginCall&) = delete;
    PluginCall& operator=(const PluginCall&) = delete;

    /// The call at work; null: none is.
    static const PluginCall* current() noexcept { return current_; }
    /// Start of the open step [s]; not a number before the first.
    static double time() noexcept { return time_; }
    static void set_time(double time) noexcept { time_ = time; }

    const char* plugin() const noexcept { return plugin_.c_str(); }
    const char* element() const noexcept { return element_ ? element_->c_str() : nullptr; }
    bool is_network() const noexcept { return is_network_; }

private:
    const std::string& plugin_;
    const std::string* element_;
    bool is_network_;
    const PluginCall* before_;

    static inline const PluginCall* volatile current_ = nullptr;
    static inline volatile double time_ = std::numeric_limits<double>::quiet_NaN();
};

/// The text of the exception being handled, as a failure of a plugin.
std::string describe_exception();

/// Throws Error(plugin_failure) if a plugin has changed how the process computes or writes numbers: rounding mode, numbers
/// below 2.2e-308 taken for zero (FTZ, DAZ), floating-point traps, decimal point of the locale. No call must return so.
void refuse_changed_arithmetic();

}  // namespace dttmm::host
