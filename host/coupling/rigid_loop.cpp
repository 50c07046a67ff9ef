// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/rigid_loop.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

bool form_rigid_loop(const Model& model, const ElementCatalogue& catalogue) {
    // The ground, then bodies, then nodes: each with the root of its tree
    const size_t nodes = 1 + model.bodies.size();
    std::vector<size_t> tree(nodes + model.nodes.size());
    std::iota(tree.begin(), tree.end(), size_t{0});
    const auto root = [&](size_t of) {
        while (tree[of] != of) of = tree[of] = tree[tree[of]];
        return of;
    };
    const auto closes = [&](size_t first, size_t second) {
        const size_t one = root(first), other = root(second);
        tree[one] = other;
        return one == other;
    };
    const auto place_of = [&](const Attachment& end) {
        return end.node >= 0 ? nodes + as_size(end.node) : as_size(end.body + 1);
    };
    const auto is_rigid = [](double value) { return std::isinf(value); };
    for (const Element& element : model.elements) {
        const bool is_body = catalogue.types[as_size(element.type)]->ends == DTTMM_ENDS_AT;
        if (!is_body && std::none_of(element.values.begin(), element.values.end(), is_rigid)) continue;
        for (size_t end = 1; end < element.ends.size(); ++end)
            if (closes(place_of(element.ends[end - 1]), place_of(element.ends[end]))) return true;
    }
    for (size_t n = 0; n < model.nodes.size(); ++n)
        if (model.nodes[n].fixed.any() && closes(0, nodes + n)) return true;
    return false;
}

}  // namespace dttmm::host
