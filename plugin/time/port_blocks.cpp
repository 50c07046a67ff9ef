// SPDX-License-Identifier: BSD-3-Clause
#include "time/port_blocks.h"

#include <map>
#include <numeric>
#include <utility>

namespace dttmm::plugin {

PortBlocks PortBlocks::dense(const PortBodies& bodies) {
    PortBlocks blocks;
    blocks.ports_ = bodies.count();
    for (uint32_t row : bodies.bodies)
        for (uint32_t column : bodies.bodies) blocks.list_.push_back({row, column});
    blocks.set_places();
    return blocks;
}

PortBlocks PortBlocks::of_joints(const PortBodies& bodies) {
    PortBlocks blocks;
    std::map<std::pair<int, int>, int> found;
    for (const Joint& joint : bodies.mechanism.joints) {
        OfJoint& own = blocks.of_joints_.emplace_back();
        for (int i : {0, 1})
            for (int j : {0, 1}) {
                const int row = joint.frame(i), column = joint.frame(j);
                own.at[i][j] = -1;
                if (row >= bodies.count() || column >= bodies.count()) continue;
                const auto [entry, is_new] = found.try_emplace({row, column}, as_int(blocks.list_.size()));
                if (is_new) blocks.list_.push_back({bodies.bodies[as_size(row)], bodies.bodies[as_size(column)]});
                own.at[i][j] = entry->second;
            }
    }
    blocks.set_places();
    return blocks;
}

void PortBlocks::set_places() {
    places_.resize(list_.size());
    std::iota(places_.begin(), places_.end(), size_t{0});
}

void PortBlocks::add_dense(const double* own, double* matrix) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Map<const RowMajor> S(own, 6 * ports_, 6 * ports_);
    for (Eigen::Index b = 0; b < ports_ * ports_; ++b)
        Eigen::Map<RowMajor6>(matrix + 36 * places_[as_size(b)]) += S.block<6, 6>(6 * (b / ports_), 6 * (b % ports_));
}

}  // namespace dttmm::plugin
