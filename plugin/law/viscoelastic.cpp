// SPDX-License-Identifier: BSD-3-Clause
#include "law/viscoelastic.h"

#include <algorithm>
#include <cmath>

namespace dttmm::plugin {

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
            // With a constant rate q tends to k τ (b − a)/h; lost is ∫ q²/(k τ) dt
            const double x = h / time, decay = -std::expm1(-x), limit = stiffness * (b - a) / x, away = before - limit;
            const double slope = stiffness * decay / x;
            after = limit + away * (1 - decay);
            on.tangent += slope;
            on.mean += limit + away * decay / x;
            on.mean_tangent += stiffness / x * (1 - decay / x);
            on.dissipated +=
                (limit * limit * x + 2 * limit * away * decay + 0.5 * away * away * decay * (2 - decay)) / stiffness;
        } else {
            on.mean += before;
        }
        on.force += after;
        on.stored += 0.5 * after * after / stiffness;
        if (path.after) path.after[j] = after;
    }
    if (is_slow) {
        on.dissipated += relaxed;
        // The mean force of (stored at the end − at the start + lost)/(b − a) is that of the spring alone
    }
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
