// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "analysis/request.h"
#include "identify/figure_function.h"
#include "model/error.h"

namespace dttmm::host {

/// Derivatives of figures by the logarithms of parameters.
struct LocalSensitivity {
    Eigen::VectorXd figures;  ///< at the file's values
    Eigen::MatrixXd slopes;   ///< d figure/d ln p: a row per figure, a column per parameter
    Eigen::MatrixXd errors;   ///< of the slopes
    /// Of direct differentiation: slopes of the extreme that comes next (see FigureSlopes), or of the next frequency, and
    /// the changes of ln p by which they come to be the same; of extremes their instants [s], of peaks of responses their
    /// frequencies [Hz]. Empty of differences.
    Eigen::VectorXd competing_at;
    Eigen::MatrixXd competing, reach;
};

/// By central differences at three distances, extrapolated to none; their errors are those of the last extrapolation. A
/// multiple natural frequency has a derivative for each of its branches: their slopes distinguish them. Throws
/// Error(numerical_failure) where the model has no answer at one of the points. Source: Ridders (1982), Advances in
/// Engineering Software 4, 75-76.
LocalSensitivity differentiate_figures(const FigureFunction& function, int jobs);

/// `dttmm sensitivity`: how figures change with parameters, in % per %, and with --vary how far they scatter. Prints the
/// table and writes sensitivity.csv and sensitivity.json. Throws Error as FigureFunction does.
ExitCode find_sensitivities(const Request& request);

}  // namespace dttmm::host
