// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/newton_convergence.h"

#include <algorithm>
#include <limits>

namespace dttmm::host {

namespace {

/// After so many passes a correction that has not halved is rounding, if it is small.
constexpr int kPassesToFall = 4;

/// Of a correction that is more than half of the one before, θ/(1 − θ) > 1, everything may remain.
bool falls(double correction, double previous) { return correction <= 0.5 * previous; }

}  // namespace

double Contraction::left(double correction) const {
    if (correction <= measured_at_) return share_ * correction;
    return measured_at_ == 0 ? correction : std::min(share_ * (correction / measured_at_), 1.0) * correction;
}

void Contraction::measure(double rate, double previous) {
    // A rate of zero would be trusted for ever: doubled it stays zero
    share_ = falls(rate, 1) ? std::max(rate, std::numeric_limits<double>::epsilon()) / (1 - rate) : 1;
    measured_at_ = previous;
}

void Contraction::forget(double least) { share_ = std::clamp(kTrustLost * share_, least, 1.0); }

void NewtonConvergence::open(double least) {
    if (last_.is_new) motion_ = momentum_ = {};
    motion_.forget(least);
    momentum_.forget(least);
    last_ = {};
    noise_ /= kTrustLost;
    first_ = 0;
    passes_ = not_done_ = 0;
    is_done_ = is_slow_ = false;
}

void NewtonConvergence::take(const dttmm_progress& progress) {
    if (progress.is_new && passes_ == 0) motion_ = momentum_ = {};
    measure(progress);
    first_ = passes_ == 0 ? progress.correction : std::max(first_, passes_ == 1 ? progress.previous : 0);
    last_ = progress;
    last_.enough = std::max(progress.enough, noise_);
    ++passes_;
    is_done_ = judge(progress.enough);
    if (!is_done_) not_done_ = passes_;
}

void NewtonConvergence::measure(const dttmm_progress& progress) {
    is_slow_ = false;
    if (progress.previous == 0) return;
    // Of corrections at rounding the first measures something, for it comes after a large one
    if (progress.correction <= progress.enough && passes_ > 1) return;
    const double rate = progress.correction / progress.previous;
    motion_.measure(rate, progress.previous);
    if (last_.residual > 0) momentum_.measure(progress.residual / last_.residual, last_.residual);
    is_slow_ = rate > kSlow && progress.correction > kNearRounding * progress.enough;
}

/// rounding: a correction that is not larger is nothing else.
bool NewtonConvergence::judge(double rounding) {
    if (last_.is_new && passes_ == 1) return false;
    if (last_.correction <= last_.enough) return true;
    const double tolerance = std::max(last_.enough, std::min(limits_.first * first_, limits_.motion * last_.motion)),
                 allowed = limits_.impulse * last_.impulse;
    if (motion_.left(last_.correction) <= tolerance && momentum_.left(last_.residual) <= allowed) return true;
    if (passes_ <= kPassesToFall || falls(last_.correction, last_.previous)) return false;
    // Forces in balance to rounding leave nothing to find, however far a soft direction moves for it
    const bool is_balanced = last_.impulse > 0 && last_.residual == 0;
    const bool is_small = last_.correction <= std::max(kMayBeRounding * last_.motion, kNearRounding * rounding);
    if (!is_balanced && (!is_small || last_.residual > allowed)) return false;
    noise_ = last_.correction;
    return true;
}

}  // namespace dttmm::host
