// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "support/models.h"
#include "support/paths.h"

namespace dttmm::test {

/// The plugins of a run with that of tests/loader/chain/chain.c, lumps on springs.
inline Plugins chain_plugins() { return Plugins({test::paths::chain()}); }

/// A spring of that plugin, the same stiffness k in every translation.
inline Element link(const std::string& name, const Plugins& plugins, const Attachment& from, const Attachment& to,
                    double k) {
    Element element;
    element.name = name;
    element.type = plugins.catalogue().find("link");
    element.ends = {from, to};
    element.values = {k, 1, 1, NAN};
    element.place = name;
    return element;
}

/// A mass at each of `nodes`.
inline Element lump(const std::string& name, const Plugins& plugins, const std::vector<int>& nodes, double mass) {
    Element element;
    element.name = name;
    element.type = plugins.catalogue().find("lump");
    for (int node : nodes) element.ends.push_back({-1, -1, node});
    element.values = {mass};
    element.place = name;
    return element;
}

inline Node node(const std::string& name, const Eigen::Vector3d& position) {
    Node result;
    result.name = name;
    result.position = position;
    return result;
}

}  // namespace dttmm::test
