// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/law_limits.h"

#include <fmt/format.h>

namespace dttmm::host {

void warn_limit(const std::string& channel, const std::string& element, double most, const std::string& when,
                Warnings& warnings) {
    warnings.add("beyond-limit", fmt::format("\"{}\" is {:.3g} {}: beyond 1 the law of element \"{}\" does not hold and its "
                                             "results are wrong; \"dttmm elements\" says what limits it",
                                             channel, most, when, element));
}

void warn_limits(const std::vector<Limit>& limits, const std::vector<Channel>& channels, const std::string& when,
                 Warnings& warnings) {
    for (const Limit& limit : limits)
        if (limit.most > 1)
            warn_limit(channels[limit.channel].name(), limit.element, limit.most,
                       when.empty() ? fmt::format("at t = {:g} s", limit.time) : when, warnings);
}

}  // namespace dttmm::host
