// SPDX-License-Identifier: BSD-3-Clause
#include "law/viscoelastic.h"

#include <algorithm>
#include <cmath>

namespace dttmm::plugin {

namespace {

/// Below it series have more digits than closed forms, and 16 of their terms all of them.
constexpr double kShort = 0.5;

/// (x − d)/x² with d = 1 − e^(−x): Σ (−x)^n/(n + 2)!
double mean_share(double x) {
    if (x >= kShort) return (x + std::expm1(-x)) / (x * x);
    double sum = 0, term = 0.5;
    for (int n = 0; n < 16; ++n, term *= -x / (n + 2)) sum += term;
    return sum;
}

/// (x − d − d²/2)/x², the integral of (1 − e^(−s))² over it: Σ (−1)^n (2^n − 2) x^(n − 1)/(n! (n + 1)), n from 2.
double lost_share(double x) {
    const double d = -std::expm1(-x);
    if (x >= kShort) return (x - d - 0.5 * d * d) / (x * x);
    double sum = 0, term = 0.5 * x, power = 4;  // (−1)^n x^(n − 1)/n!, 2^n
    for (int n = 2; n < 18; ++n, term *= -x / n, power *= 2) sum += term * (power - 2) / (n + 1);
    return sum;
}

}  // namespace

Viscoelastic::Viscoelastic(std::vector<DynamicStiffnessRow> rows) : rows_(std::move(rows)), series_(fit_maxwell(rows_)) {}

LawOnPath Viscoelastic::along(const LawPath& path) const {
    const double k = series_.spring, a = path.from, b = path.to, h = path.time;
    LawOnPath on{k * b, k, 0.5 * k * (a + b), 0.5 * k, 0.5 * k * b * b, 0};
    const bool is_slow = h == 0 && a != b;
    double relaxed = 0;  // stored before, and lost
    for (size_t j = 0; j < series_.terms.size(); ++j) {
        const auto& [stiffness, time] = series_.terms[j];
        const double before = path.memory ? path.memory[j] : 0;
        double after = before;
        if (is_slow) {
            after = 0;
            relaxed += 0.5 * before * before / stiffness;
        } else if (h > 0) {
            // With u = k (b − a) and x = h/τ, at a share s/x of the path q = q₀ e^(−s) + u (1 − e^(−s))/x; lost is ∫ q² ds/k
            const double x = h / time, decay = -std::expm1(-x), u = stiffness * (b - a);
            after = before * (1 - decay) + u * decay / x;
            on.tangent += stiffness * decay / x;
            on.mean += before * decay / x + u * mean_share(x);
            on.mean_tangent += stiffness * mean_share(x);
            on.dissipated +=
                (before * before * 0.5 * decay * (2 - decay) + before * u * decay * decay / x + u * u * lost_share(x)) /
                stiffness;
        } else {
            on.mean += before;
        }
        on.force += after;
        on.stored += 0.5 * after * after / stiffness;
        if (path.after) path.after[j] = after;
    }
    on.dissipated += relaxed;  // the mean along a slow path is that of the spring alone
    return on;
}

std::complex<double> Viscoelastic::stiffness_at(double omega) const {
    const DynamicStiffnessRow& first = rows_.front();
    if (omega <= first.omega) return std::polar(first.stiffness, first.angle * omega / first.omega);
    const auto next = std::ranges::find_if(rows_, [&](const auto& row) { return row.omega >= omega; });
    const DynamicStiffnessRow& high = next == rows_.end() ? rows_.back() : *next;
    const DynamicStiffnessRow& low = *(next == rows_.end() ? rows_.end() - 2 : next - 1);
    const double share = (omega - low.omega) / (high.omega - low.omega);
    return std::polar(low.stiffness + share * (high.stiffness - low.stiffness),
                      low.angle + share * (high.angle - low.angle));
}

}  // namespace dttmm::plugin
