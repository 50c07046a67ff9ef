// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "solve/elimination.h"
#include "time/inside.h"

namespace dttmm::plugin {

/// K + s C + s² M of what is inside a network, in the frames' axes, s a rate [1/s], with all frames where they are in `at`:
/// springs, dampers and masses under motions that grow like exp(s t). Forces that act already have no stiffness in it.
void form_dynamic_stiffness(const Inside& inside, const std::vector<Frame>& at, double rate, Elimination& matrix);

/// How the inside follows very slow motions of its ports: by its springs; where there are none, by dampers or masses.
class SlowMotion {
public:
    /// With all frames where they are in `at`. pattern: an elimination of the same frames. hold(matrix): adds to it before
    /// it is factored. Where a motion is resisted by nothing, inertias are made heavier. Throws Error(DTTMM_ERROR_SINGULAR)
    /// where that does not help. Keeps the inside and `at`.
    SlowMotion(
        const Inside& inside, const Elimination& pattern, const std::vector<Frame>& at,
        const std::function<void(Elimination&)>& hold = [](Elimination&) {});

    /// motion: 6 per frame in its own axes, of the ports given; of the inner frames a load on them, in whose place it takes
    /// their motion. q: takes the forces of rigid directions.
    void follow(std::span<Vector6> motion, std::span<double> q) const;
    /// −∂(wrench)/∂(pose of the ports), world: 6P × 6P row-major.
    void write_stiffness(double* stiffness) const;

private:
    const Inside& inside_;
    const std::vector<Frame>& at_;
    Elimination matrix_;
    std::vector<EndBlocks> at_ports_;  ///< of Inside::port_joints: what couples the ports to the inside
};

}  // namespace dttmm::plugin
