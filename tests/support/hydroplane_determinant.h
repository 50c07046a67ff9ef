// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/oracle.h"

namespace dttmm::test {

/// The hydroplane as the paper has it: products of 8 × 8 transfer matrices along the branches, eqs. (1) to (34), and the
/// determinant of the 24 × 24 matrix (36) under its boundary conditions (37), with the data of examples/hydroplane. State
/// [X Y Θz Mz Qx Qy Θx Mx], signs of the paper. Beams, whose D of (9) it does not print, by the exponential of their
/// differential equations. It shares nothing with the tree. Source: Chen, Xiao, Xie, Zhu, Rui (2020), J. Harbin Eng. Univ.
/// 41(2), 184–193.
class DTTMM_ORACLE HydroplaneDeterminant {
public:
    /// Eq. (10): the moments of inertia moved to the input end as they are printed, or as they must be.
    enum class Equation10 { corrected, printed };

    explicit HydroplaneDeterminant(double kh, Equation10 equation10 = Equation10::corrected)
        : kh_(kh), equation10_(equation10) {}

    /// Its value at a frequency [Hz], up to a positive factor; zero at the natural frequencies.
    double operator()(double frequency) const;

private:
    double kh_;
    Equation10 equation10_;
};

}  // namespace dttmm::test
