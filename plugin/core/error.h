// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "dttmm_plugin.h"

namespace dttmm::plugin {

/// A failure inside the plugin: the status that crosses the C interface, its text, and the element it is about (or -1).
class Error : public std::runtime_error {
public:
    Error(dttmm_status status, const std::string& text, int element = -1)
        : std::runtime_error(text), status_(status), element_(element) {}
    dttmm_status status() const { return status_; }
    int element() const { return element_; }

private:
    dttmm_status status_;
    int element_;
};

}  // namespace dttmm::plugin
