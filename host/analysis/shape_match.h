// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <filesystem>
#include <string>
#include <vector>

#include "record/column.h"

namespace dttmm::host {

/// |aᵀb|²/(aᵀa bᵀb) of a shape and the nearest mixture of others, one per column, which are 1 where they are largest; 0 if
/// these do not move.
double mac_of(const Eigen::MatrixXd& shapes, const Eigen::VectorXcd& shape);
/// Weights of that mixture; 0 if the shapes do not move.
Eigen::VectorXd nearest_mixture(const Eigen::MatrixXd& shapes, const Eigen::VectorXd& shape);

/// The mode of `dttmm modes` that a shape resembles most.
struct ModeMatch {
    std::size_t mode = 0;  ///< counted from 1, as modes.csv does
    double frequency = 0;  ///< [Hz]
    double mac = 0;        ///< |a' b|^2 / (a' a b' b); of a multiple mode with the nearest of its shapes
};

/// Shapes of `dttmm modes` where the channels of a history stand.
class ShapeMatch {
public:
    /// folder: results of `dttmm modes`. Throws Error(input_output) for another, Error(usage) if no channel is a position,
    /// velocity or acceleration of one of its places.
    ShapeMatch(const std::filesystem::path& folder, const std::vector<Column>& channels);

    /// shape: amplitudes of the channels at the rate s; velocities count as s times, accelerations as s^2 times a
    /// displacement. Of matches within 0.01 of the best MAC the one nearest in frequency.
    ModeMatch match(const Eigen::VectorXcd& shape, std::complex<double> rate) const;
    /// Channels that count: displacements, or rotations where there is no displacement.
    std::size_t size() const { return used_.size(); }

private:
    struct Used {
        int channel;
        int derivative;  ///< of the displacement
    };
    std::vector<Used> used_;
    std::vector<double> frequencies_;
    Eigen::MatrixXd shapes_;  ///< a column per mode
};

}  // namespace dttmm::host
