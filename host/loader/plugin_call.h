// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "model/index.h"

namespace dttmm::host {

/// Lives while a plugin is at work: what ends the process meanwhile (a crash, exit) is the plugin's, and the last message
/// names it. Costs a handful of stores. Read by signal handlers: nothing here allocates.
class PluginCall {
public:
    /// elements: those of the instance at work, and where the plugin writes the index of the one it works on; null: none.
    /// All must outlive the call.
    explicit PluginCall(const std::string& plugin, const std::vector<std::string>* elements = nullptr,
                        volatile int32_t* element = nullptr) noexcept
        : plugin_(plugin), elements_(elements), element_(element), before_(current_) {
        if (element) *element = -1;
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
    /// The element at work; null where the plugin has several and does not say which.
    const char* element() const noexcept {
        if (!elements_ || elements_->empty()) return nullptr;
        if (elements_->size() == 1) return elements_->front().c_str();
        const int32_t element = element_ ? *element_ : -1;
        if (element < 0 || as_size(element) >= elements_->size()) return nullptr;
        return (*elements_)[as_size(element)].c_str();
    }

private:
    const std::string& plugin_;
    const std::vector<std::string>* elements_;
    volatile int32_t* element_;
    const PluginCall* before_;

    static inline const PluginCall* volatile current_ = nullptr;
    static inline volatile double time_ = std::numeric_limits<double>::quiet_NaN();
};

/// As changed_mode(), where something may have changed.
const char* restore_mode();

/// The text of the exception being handled, as a failure of a plugin.
std::string describe_exception();

/// What a plugin has changed of the processor's arithmetic, which is put right again: "the rounding mode of the processor",
/// ..; NULL: nothing. Quick enough to be asked after every call.
inline const char* changed_mode() {
#ifdef __SSE2__
    // MXCSR without its six flags: all exceptions masked, round to nearest, no flush to zero, no denormals as zero
    if ((_mm_getcsr() & ~0x3fu) == 0x1f80u) [[likely]]
        return nullptr;
#endif
    return restore_mode();
}

/// Throws Error(plugin_failure) if a plugin has changed how the process computes or writes numbers: rounding mode, numbers
/// below 2.2e-308 taken for zero (FTZ, DAZ), floating-point traps, decimal point of the locale. No call must return so.
void refuse_changed_arithmetic(const std::string& who = "a plugin");

}  // namespace dttmm::host
