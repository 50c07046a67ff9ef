// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "time/network.h"

namespace dttmm::test {

/// A network of all bodies that writes its wrenches, and its matrices as 6P × 6P row-major for P bodies.
class DenseNetwork : public plugin::Network {
public:
    using Network::Network;

    void linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const {
        std::vector<double> K(36 * blocks().list().size()), C(K.size());
        Network::linearise(bodies, cleared(wrench), K.data(), C.data());
        spread(K, stiffness);
        spread(C, damping);
    }
    /// Iterates until it has converged for this trial.
    void settle(const dttmm_motion* trial) {
        dttmm_progress progress{};
        for (int n = 0; iterates() && n < 50; ++n) {
            iterate(trial, progress);
            if (n > 0 && (progress.correction <= progress.enough ||
                          (progress.correction <= 1e-9 * progress.motion && progress.residual <= 1e-9 * progress.impulse)))
                return;
        }
    }
    /// Where it has converged.
    void commit_settled(const dttmm_motion* accepted) {
        settle(accepted);
        commit_step(accepted);
    }
    /// The answer where it has converged.
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) {
        settle(trial);
        answer(trial, wrench, stiffness);
    }
    /// The answer from where it has come to.
    void answer(const dttmm_motion* trial, double* wrench, double* stiffness) const {
        std::vector<double> K(36 * blocks().list().size());
        Network::evaluate(trial, cleared(wrench), stiffness ? K.data() : nullptr);
        spread(K, stiffness);
    }
    void mean_wrench(double* wrench) const { Network::mean_wrench(cleared(wrench)); }
    void stand(const dttmm_motion* bodies, double* wrench) const { Network::stand(bodies, nullptr, cleared(wrench)); }

private:
    double* cleared(double* wrench) const { return std::fill_n(wrench, 6 * port_count(), 0.0), wrench; }
    void spread(const std::vector<double>& list, double* matrix) const {
        if (!matrix) return;
        using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        Eigen::Map<RowMajor> M(matrix, 6 * port_count(), 6 * port_count());
        M.setZero();
        for (size_t b = 0; b < blocks().list().size(); ++b)
            M.block<6, 6>(6 * blocks().list()[b].row, 6 * blocks().list()[b].column) =
                Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(&list[36 * b]);
    }
};

}  // namespace dttmm::test
