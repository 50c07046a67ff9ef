// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/rigid_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "model/index.h"
#include "world/singular_position.h"

namespace dttmm::host {

bool form_rigid_loop(const Model& model, const ElementCatalogue& catalogue) {
    // Nodes are numbered behind the bodies
    const int nodes = as_int(model.bodies.size());
    const auto place_of = [&](const Attachment& end) { return end.node >= 0 ? nodes + end.node : end.body; };
    const auto is_rigid = [](double value) { return std::isinf(value); };
    std::vector<std::pair<int, int>> links;
    for (const Element& element : model.elements) {
        const bool is_body = catalogue.types[as_size(element.type)]->ends == DTTMM_ENDS_AT;
        if (!is_body && std::none_of(element.values.begin(), element.values.end(), is_rigid)) continue;
        for (size_t end = 1; end < element.ends.size(); ++end)
            links.emplace_back(place_of(element.ends[end - 1]), place_of(element.ends[end]));
    }
    for (size_t n = 0; n < model.nodes.size(); ++n)
        if (model.nodes[n].fixed.any()) links.emplace_back(-1, nodes + as_int(n));
    return form_loop(links);
}

}  // namespace dttmm::host
