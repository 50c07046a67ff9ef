// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/channel_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "loader/plugins.h"
#include "model/index.h"
#include "model/read_simulation.h"
#include "record/channels.h"
#include "step/simulation.h"

namespace dttmm::host {

void print_channels(const Request& request) {
    const Plugins plugins(request.plugins);
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::statics;  // which wants no duration
    Model model = read_model(request.model, plugins.catalogue(), overrides);
    if (model.simulation.step == 0) model.simulation.step = kShortestStep;  // the channels are the same at any
    const Simulation simulation(model, plugins);
    const std::vector<Channel>& all = simulation.channels();
    std::vector<int> listed(all.size());
    std::iota(listed.begin(), listed.end(), 0);
    if (!request.patterns.empty()) {
        listed = select_channels(all, request.patterns);
        listed.erase(listed.begin());  // the time, which is always selected
    }
    size_t width = 0;
    for (const int c : listed) width = std::max(width, all[as_size(c)].name().size());
    for (const int c : listed) {
        const Channel& channel = all[as_size(c)];
        fmt::print("{:<{}}  {}{}\n", channel.name(), width, channel.unit(), channel.by_default() ? "" : "  (on request)");
    }
}

}  // namespace dttmm::host
