// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <vector>

#include "law/law.h"
#include "law/maxwell_series.h"

namespace dttmm::plugin {

/// A material whose stiffness depends on the frequency, as rubber, from measured rows. In vibration at one frequency it has
/// its rows; in time, at rest and in damped modes it is the Maxwell series that fits them best. Each term remembers its
/// force q:
///     q' + q/τ = k d'
/// A path that takes no time is slow: at its end all terms have relaxed, and what they stored is lost.
class Viscoelastic final : public Law {
public:
    /// rows: as fit_maxwell() wants them. Throws what that does.
    explicit Viscoelastic(std::vector<DynamicStiffnessRow> rows);

    LawOnPath along(const LawPath& path) const override;
    size_t memory_size() const override { return series_.terms.size(); }
    bool remembers_smoothly() const override { return true; }

    /// By its rows, straight lines of magnitude and angle between them. Below the first row the stiffness is that of the
    /// first, and the angle falls in proportion to the frequency; omega: up to highest() [rad/s].
    std::complex<double> stiffness_at(double omega) const;
    double highest() const { return rows_.back().omega; }
    const MaxwellSeries& series() const { return series_; }
    MaxwellSeries::Misfit misfit() const { return series_.misfit(rows_); }

private:
    std::vector<DynamicStiffnessRow> rows_;
    MaxwellSeries series_;
};

}  // namespace dttmm::plugin
