// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mechanism/port_bodies.h"

namespace dttmm::plugin {

/// The blocks, 6 × 6 row-major, in which the host has the matrices of a network. Matrices are added to what is there.
class PortBlocks {
public:
    /// All pairs of ports, row by row; or only those that joints join.
    static PortBlocks dense(const PortBodies& bodies);
    static PortBlocks of_joints(const PortBodies& bodies);

    std::span<const dttmm_block> list() const { return list_; }
    /// Where each is in the lists of the host, in their order at first.
    void place(size_t block, size_t at) { places_[block] = at; }

    /// Adds the blocks of one joint; only for blocks of joints.
    void add(size_t joint, const EndBlocks& blocks, double* matrix) const {
        for (int i : {0, 1})
            for (int j : {0, 1})
                if (const int block = of_joints_[joint].at[i][j]; block >= 0)
                    Eigen::Map<RowMajor6>(matrix + 36 * places_[as_size(block)]) += blocks.at[i][j];
    }
    /// Adds a full matrix over all ports, row-major; only for dense blocks. Count of its numbers.
    void add_dense(const double* own, double* matrix) const;
    size_t dense_size() const { return 36 * list_.size(); }

private:
    using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
    struct OfJoint {
        int at[2][2];
    };
    void set_places();

    Eigen::Index ports_ = 0;
    std::vector<dttmm_block> list_;
    std::vector<size_t> places_;
    std::vector<OfJoint> of_joints_;  ///< of each joint in the list, −1: none
};

}  // namespace dttmm::plugin
