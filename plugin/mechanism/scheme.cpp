// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/scheme.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/error.h"

namespace dttmm::plugin {

namespace {

/// Velocity formula of an explicit scheme at t_n as weights of x at t_n, t_{n−1}, t_{n−2}, t_{n−3}: one unit history each.
/// The previous velocity that Fox-Euler wants is the host's, read as everywhere as the mean of those over the two steps
/// around t_{n−1}: (x_n − x_{n−2})/2h. With it the formula coincides with BDF2's. Its own recursion would be driven unstable
/// by a leap-frog host.
std::array<double, 4> velocity_weights(uint32_t scheme, double h) {
    const auto rule = [&](const History& past) {
        switch (scheme) {
            case DTTMM_SCHEME_BDF1:
                return bdf1(past, h);
            case DTTMM_SCHEME_BDF2:
                return bdf2(past, h);
            case DTTMM_SCHEME_HOUBOLT:
                return houbolt(past, h);
            case DTTMM_SCHEME_PARK:
                return park(past, h);
            default:
                return fox_euler(past, h);
        }
    };
    std::array<double, 4> weights{};
    for (size_t instant = 0; instant < 4; ++instant) {
        Vector6 x[4];
        for (size_t i = 0; i < 4; ++i) x[i] = Vector6::Constant(i == instant ? 1 : 0);
        History past;
        past.x = {x[1], x[2], x[3]};
        past.v = {(x[0] - x[2]) / (2 * h), (x[1] - x[3]) / (2 * h), Vector6::Zero()};
        past.a = {Vector6::Zero(), Vector6::Zero(), Vector6::Zero()};
        weights[instant] = rule(past).velocity(x[0])(0);
    }
    return weights;
}

}  // namespace

Scheme::Scheme(uint32_t id, Centred centred) : id_(id), centred_(centred), weights_{0, 1, 0} {
    if (id > DTTMM_SCHEME_PARK) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no scheme {}", id));
    if (!is_implicit()) return;
    if (!(centred.beta > 0 && std::isfinite(centred.beta) && std::isfinite(centred.gamma)))
        throw Error(DTTMM_ERROR_ARGUMENT, "the centred scheme wants a finite beta > 0 and a finite gamma");
    weights_[0] = centred.weight_after();
    weights_[1] = centred.weight_now();
    weights_[2] = centred.weight_before();
    elastic_[0] = elastic_[2] = 0.5 * (weights_[0] + weights_[2]);
    elastic_[1] = 1 - 2 * elastic_[0];
    lag_ = 0.5 * (weights_[0] - weights_[2]);
}

void Scheme::set_step_size(double h) {
    h_ = h;
    if (is_implicit()) {
        // (γ d₊ + (1 − 2γ) d + (γ − 1) d₋)/h = (γ δ₊ + (1 − γ) δ)/h
        rate_[0] = centred_.gamma / h;
        rate_[1] = (1 - centred_.gamma) / h;
        return;
    }
    // Σ w_i x_{n−i} with Σ w_i = 0, in increments
    const std::array<double, 4> w = velocity_weights(id_, h);
    rate_[1] = w[0];
    rate_[2] = w[0] + w[1];
    rate_[3] = w[0] + w[1] + w[2];
}

}  // namespace dttmm::plugin
