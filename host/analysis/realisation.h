// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <vector>

namespace dttmm::host {

/// A vibration sum over the modes of Re(shape e^(rate t)) found in a history, t from the start of the window.
struct IdentifiedMode {
    std::complex<double> rate;  ///< s_h [1/s], positive imaginary part
    Eigen::VectorXcd shape;     ///< amplitude and phase of each channel at the start of the window, in its unit
    double strength = 0;        ///< its share of what the channels do in the window, each by its deviation
};

struct Identification {
    std::vector<IdentifiedMode> modes;  ///< confirmed, by frequency
    std::size_t weaker = 0;             ///< confirmed beyond those asked for
    std::size_t spurious = 0;           ///< vibrations that other orders do not confirm
    std::size_t faint = 0;              ///< confirmed ones that are no stronger than what the realisation leaves out
    std::size_t rates = 0;              ///< real poles: offsets, drifts, decays without vibration
    std::size_t order = 0;              ///< of the realisation
    double unexplained = 0;             ///< RMS of what it leaves, as share
};

/// Most modes that `rows` rows of `channels` channels tell apart.
std::size_t most_modes(std::size_t channels, std::size_t rows);

/// Eigensystem realisation of a free decay: of a Hankel matrix of all channels H0 = U S V' and its shift by one row H1
/// follow A = S^-1/2 U' H1 V S^-1/2, whose eigenvalues are e^(s_h dt), and the shapes. The order is the numerical rank, at
/// most that of the modes asked for and as many again. A mode counts when the realisations of the next three orders have it
/// too, within 1 % of its frequency and 0.01 of damping ratio, and its strength exceeds the square of the share of the
/// largest singular value left out. wanted: at most so many, the strongest. Throws Error(usage)
/// for more than most_modes, Error(numerical_failure) if all is zero. Source: Juang and Pappa (1985), J. Guid. Control Dyn.
/// 8(5), 620-627.
Identification identify_modes(const std::vector<std::vector<double>>& channels, double interval, std::size_t wanted);

}  // namespace dttmm::host
