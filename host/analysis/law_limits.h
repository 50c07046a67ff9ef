// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "record/channels.h"
#include "record/warnings.h"
#include "step/observer.h"

namespace dttmm::host {

/// Warns of elements beyond what their laws hold for. channels: that the limits count by. when: such as
/// "at rest"; empty: the instant of the limit.
void warn_limits(const std::vector<Limit>& limits, const std::vector<Channel>& channels, const std::string& when,
                 Warnings& warnings);

/// The same of one element. channel: the name of the one that says how near it is to its limit.
void warn_limit(const std::string& channel, const std::string& element, double most, const std::string& when,
                Warnings& warnings);

}  // namespace dttmm::host
