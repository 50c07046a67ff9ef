// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

/// Which mode of a case of a sweep belongs to which curve.
struct CaseCurves {
    static constexpr size_t kNone = static_cast<size_t>(-1);
    std::vector<size_t> mode_of;   ///< of every curve; kNone: no mode of this case goes on with it
    std::vector<double> likeness;  ///< to the shape of the same curve in the case `nearest`; NaN where the curve begins
    size_t nearest = kNone;        ///< the case it was compared with; kNone: the first
};

/// Modal assurance criterion of two shapes: 1 for the same shape, 0 for shapes at right angles.
double compute_likeness(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

/// Joins the modes of all cases to curves by their shapes. Every case is compared with the nearest of those done before it,
/// in the parameters as shares of their ranges in the sweep; the first case begins, then follows the case nearest to any of
/// those done (Prim's tree). There modes and curves are paired, the most alike first. A mode that is left begins a curve; a
/// curve that is left keeps its last shape.
/// parameters: per case, one number per swept parameter. shapes: per case, a column per mode, rows alike in all cases.
std::vector<CaseCurves> follow_curves(const std::vector<std::vector<double>>& parameters,
                                      const std::vector<Eigen::MatrixXd>& shapes);

}  // namespace dttmm::host
