// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/discretisation.h"
#include "dttmm_plugin.h"

namespace dttmm::plugin {

/// The time scheme of a network at its present step size: how it weighs the elastic wrenches W of the joints at the end of a
/// step, at its start and one step before, and increments δ of a deformation,
///     s W₊ + (1 − 2s) W + s W₋ + (a k + c r₀) ∘ δ₊ + (a k + c r₁) ∘ δ + c ∘ (r₂ δ₋ + r₃ δ₋₋),
/// δ₊ over the open step (implicit schemes only), δ, δ₋, δ₋₋ over the three before, r the rates. In one direction that is
/// w₊, w₀, w₋ of the centred scheme with s = (w₊ + w₋)/2 and a = (w₊ − w₋)/2: its numerical damping acts on deformations
/// like a damper, not on the turning of a force with the machine.
class Scheme {
public:
    /// id: DTTMM_SCHEME_…; beta, gamma of the centred one. Throws Error(DTTMM_ERROR_ARGUMENT).
    Scheme(uint32_t id, Centred centred);

    bool is_implicit() const { return id_ == DTTMM_SCHEME_CENTRED; }
    const Centred& centred() const { return centred_; }
    /// No numerical damping: the elastic weights are those of (z + 1)², of which the damper's z² − 1 shares a factor.
    bool is_trapezoidal() const { return is_implicit() && centred_.beta == 0.25 && centred_.gamma == 0.5; }
    double step_size() const { return h_; }
    void set_step_size(double h);

    /// w₊, w₀, w₋, by the number of steps back from the end: of external loads.
    double weight(int back) const { return weights_[back]; }
    /// Of elastic wrenches: s, 1 − 2s, s.
    double elastic_weight(int back) const { return elastic_[back]; }
    /// a, 0 without numerical damping.
    double lag() const { return lag_; }
    /// Of increments of a deformation, by the number of steps back from the open one [1/s].
    double rate(int back) const { return rate_[back]; }

private:
    uint32_t id_;
    Centred centred_;
    double weights_[3];
    double elastic_[3] = {0, 1, 0}, lag_ = 0;
    double rate_[4] = {0, 0, 0, 0};
    double h_ = 0;
};

}  // namespace dttmm::plugin
