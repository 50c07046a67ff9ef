// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/random_response.h"

#include <algorithm>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// The ends of the band, and where densities bend within it.
std::vector<double> find_corners(const Excitation& excitation, double from, double to) {
    std::vector<double> corners = {from, to};
    for (const double corner : excitation.random_corners())
        if (corner > from && corner < to) corners.push_back(corner);
    std::ranges::sort(corners);
    return corners;
}

}  // namespace

RandomResponse find_random_response(const Excitation& excitation, double from, double to, const std::vector<double>& natural,
                                    const RandomAmplitudes& amplitudes, const std::vector<AdaptivePoints::Kind>& kinds,
                                    size_t most_points, const std::function<bool()>& is_asked_to_stop) {
    const size_t block = kinds.size(), loads = excitation.random_count();
    const auto channels = as_size(std::ranges::count_if(kinds, &AdaptivePoints::Kind::is_curve));
    const std::vector<double> corners = find_corners(excitation, from, to);
    std::vector<AdaptivePoints::Kind> all_kinds;
    for (size_t r = 0; r < loads; ++r) all_kinds.insert(all_kinds.end(), kinds.begin(), kinds.end());

    RandomResponse found;
    std::vector<double> square(channels), rate(channels);
    for (size_t k = 1; k < corners.size(); ++k) {
        const double low = corners[k - 1], high = corners[k], inside = 0.5 * (low + high);
        if (!(high > low)) continue;
        const auto weighted = [&](double f) {  // H √S
            std::vector<std::complex<double>> values = amplitudes(f);
            for (size_t c = 0; c < values.size(); ++c) values[c] *= std::sqrt(excitation.density(c / block, f, inside));
            return values;
        };
        const auto densities = [&](const std::vector<std::complex<double>>& values) {
            std::vector<double> sum(channels);
            for (size_t c = 0; c < values.size(); ++c)
                if (c % block < channels) sum[c % block] += std::norm(values[c]);
            return sum;
        };
        std::vector<double> start = {low};
        std::ranges::copy_if(natural, std::back_inserter(start), [&](double f) { return f > low && f < high; });
        start.push_back(high);
        AdaptivePoints adaptive(weighted, all_kinds);
        if (!adaptive.find(start, most_points, is_asked_to_stop)) return found;
        const RandomResponse::Row* last = nullptr;
        found.rows.reserve(found.rows.size() + adaptive.points().size());
        for (const auto& [f, values] : adaptive.points()) {
            RandomResponse::Row row{f, densities(values)};
            if (last) {
                const double middle = 0.5 * (last->frequency + f), share = (f - last->frequency) / 6;
                const std::vector<double> between = densities(weighted(middle));
                for (size_t c = 0; c < channels; ++c) {
                    const double parts[] = {last->densities[c], 4 * between[c], row.densities[c]};
                    square[c] += share * (parts[0] + parts[1] + parts[2]);
                    rate[c] += share * (last->frequency * last->frequency * parts[0] + middle * middle * parts[1] +
                                        f * f * parts[2]);
                }
            }
            const bool is_repeated = !last && !found.rows.empty() && found.rows.back().frequency == f &&
                                     found.rows.back().densities == row.densities;
            if (!is_repeated) found.rows.push_back(std::move(row));
            last = &found.rows.back();
        }
        found.unbounded.insert(found.unbounded.end(), adaptive.unbounded().begin(), adaptive.unbounded().end());
    }
    for (size_t c = 0; c < channels; ++c) {
        found.rms.push_back(std::sqrt(square[c]));
        found.zero_crossings.push_back(square[c] > 0 ? std::sqrt(rate[c] / square[c]) : 0);
    }
    found.is_done = true;
    return found;
}

}  // namespace dttmm::host
