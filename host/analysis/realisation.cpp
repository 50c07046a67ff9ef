// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/realisation.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/spectra.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using Complex = std::complex<double>;

constexpr std::size_t kMostHankelRows = 160,
                      kMostHankelColumns = 400;  // of the Hankel matrix: its decomposition takes 0.2 s
constexpr std::size_t kNeighbours = 3;           // orders that must confirm a mode
constexpr std::size_t kFreeOrder = 24;           // beside two per mode asked for: offsets, drifts, other modes
constexpr double kConfirmedFrequency = 0.01, kConfirmedDamping = 0.01;  // usual limits of a stabilisation diagram
constexpr double kUnsquare = 1.5;  // delays grow with this power: irregular, so that none is blind to an alias

/// `count` different delays from 0 to at most `span`, denser at first.
std::vector<std::size_t> delays(std::size_t count, std::size_t span) {
    std::vector<std::size_t> out(1, 0);
    for (std::size_t i = 1; i < count; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(count - 1);
        const auto wished = static_cast<std::size_t>(std::lround(static_cast<double>(span) * std::pow(share, kUnsquare)));
        out.push_back(std::max(out.back() + 1, wished));
    }
    return out;
}

struct Layout {
    std::vector<std::size_t> rows, columns;  ///< delays
};

Layout layout_of(std::size_t channels, std::size_t samples) {
    // The last row of the shifted matrix: rows.back() + columns.back() + 1 <= samples - 1
    const std::size_t free = samples < 2 ? 0 : samples - 2;
    // As many independent rows as columns: channels * rows = columns = free - rows
    const std::size_t blocks = std::clamp<std::size_t>(kMostHankelRows / channels, 2, kMostHankelRows);
    const std::size_t half = free < 4 * blocks ? (free + 1) / (channels + 1) : free / 2;
    const std::size_t row_span = std::max<std::size_t>(half, 1);
    const std::size_t column_span = free > row_span ? free - row_span : 0;
    return {delays(std::min(blocks, row_span + 1), row_span),
            delays(std::min(kMostHankelColumns, column_span + 1), column_span)};
}

std::size_t largest_order(const Layout& layout, std::size_t channels) {
    const std::size_t smaller = std::min(channels * layout.rows.size(), layout.columns.size());
    return smaller > kNeighbours ? smaller - kNeighbours : 0;
}

/// The decomposition of H0 and what the realisations of all orders share.
class Realisation {
public:
    Realisation(const std::vector<std::vector<double>>& channels, const Eigen::VectorXd& scales, const Layout& layout)
        : channels_(channels), scales_(scales), svd_(hankel(layout, 0), Eigen::ComputeThinU | Eigen::ComputeThinV) {
        shifted_ = svd_.matrixU().transpose() * hankel(layout, 1) * svd_.matrixV();
    }

    const Eigen::VectorXd& singular_values() const { return svd_.singularValues(); }

    struct Poles {
        Eigen::VectorXcd values;  ///< z
        Eigen::MatrixXcd shapes;  ///< a column each: the channels at the start, scaled back
    };
    Poles poles(std::size_t order) const {
        const Eigen::Index n = as_row(order);
        const Eigen::VectorXd root = singular_values().head(n).cwiseSqrt();
        const Eigen::MatrixXd A =
            root.cwiseInverse().asDiagonal() * shifted_.topLeftCorner(n, n) * root.cwiseInverse().asDiagonal();
        const Eigen::EigenSolver<Eigen::MatrixXd> solver(A);
        const Eigen::VectorXd start = root.asDiagonal() * svd_.matrixV().row(0).head(n).transpose();
        const Eigen::VectorXcd shares = solver.eigenvectors().fullPivLu().solve(start.cast<Complex>());
        const Eigen::MatrixXd output =
            scales_.asDiagonal() * svd_.matrixU().topLeftCorner(scales_.size(), n) * root.asDiagonal();
        return {solver.eigenvalues(), output.cast<Complex>() * solver.eigenvectors() * shares.asDiagonal()};
    }

private:
    Eigen::MatrixXd hankel(const Layout& layout, std::size_t shift) const {
        const auto count = channels_.size();
        Eigen::MatrixXd H(as_row(count * layout.rows.size()), as_row(layout.columns.size()));
        for (std::size_t j = 0; j < layout.columns.size(); ++j)
            for (std::size_t i = 0; i < layout.rows.size(); ++i)
                for (std::size_t c = 0; c < count; ++c)
                    H(as_row(i * count + c), as_row(j)) =
                        channels_[c][layout.rows[i] + layout.columns[j] + shift] / scales_(as_row(c));
        return H;
    }

    const std::vector<std::vector<double>>& channels_;
    Eigen::VectorXd scales_;
    Eigen::BDCSVD<Eigen::MatrixXd> svd_;
    Eigen::MatrixXd shifted_;  ///< U' H1 V
};

bool is_same(Complex a, Complex b) {
    return std::abs(a.imag() - b.imag()) <= kConfirmedFrequency * std::abs(a) &&
           std::abs(a.real() - b.real()) <= kConfirmedDamping * std::abs(a);
}

/// s_h of the poles that vibrate, once each.
std::vector<Complex> rates_of(const Eigen::VectorXcd& values, double interval) {
    std::vector<Complex> rates;
    for (const Complex z : values)
        if (z.imag() > 0) rates.push_back(std::log(z) / interval);
    return rates;
}

/// Sum over the rows of |e^(s t)|^2.
double duration_of(Complex rate, double interval, std::size_t samples) {
    const double decay = 2 * rate.real() * interval;
    return std::abs(decay) * static_cast<double>(samples) < 1e-9
               ? static_cast<double>(samples)
               : std::expm1(decay * static_cast<double>(samples)) / std::expm1(decay);
}

/// Numbers above rounding of the largest.
std::size_t rank_of(const Eigen::VectorXd& singular, std::size_t size) {
    const double least = singular(0) * std::numeric_limits<double>::epsilon() * static_cast<double>(size);
    return as_size((singular.array() > least).count());
}

}  // namespace

std::size_t most_modes(std::size_t channels, std::size_t rows) {
    return largest_order(layout_of(channels, rows), channels) / 2;
}

Identification identify_modes(const std::vector<std::vector<double>>& channels, double interval, std::size_t wanted) {
    const std::size_t samples = channels.front().size(), most = most_modes(channels.size(), samples);
    if (wanted > most)
        throw Error(ExitCode::usage,
                    fmt::format("--identify {}: {} rows of {} channels tell at most {} modes apart; take a longer "
                                "window or more channels",
                                wanted, samples, channels.size(), most));
    std::vector<std::vector<double>> about_mean = channels;  // an offset many times the vibration would hide it in rounding
    Eigen::VectorXd scales(as_row(channels.size()));
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Levels levels = levels_of(channels[c]);
        for (double& value : about_mean[c]) value -= levels.mean;
        scales(as_row(c)) = levels.deviation;
    }
    const Layout layout = layout_of(channels.size(), samples);
    const Realisation realisation(about_mean, scales, layout);
    const Eigen::VectorXd& singular = realisation.singular_values();
    if (!(singular(0) > 0)) throw Error(ExitCode::numerical_failure, "--identify: nothing moves in the window");

    Identification out;
    const std::size_t size = std::max(as_size(channels.size() * layout.rows.size()), layout.columns.size());
    out.order = std::min({rank_of(singular, size), 2 * wanted + kFreeOrder, largest_order(layout, channels.size())});
    out.unexplained = singular.tail(singular.size() - as_row(out.order)).norm() / singular.norm();
    const double left_out =
        as_row(out.order) < singular.size() ? std::pow(singular(as_row(out.order)) / singular.norm(), 2) : 0;
    std::vector<std::vector<Complex>> others;
    for (std::size_t order = out.order + 1; order <= out.order + kNeighbours; ++order)
        if (singular(as_row(order) - 1) > 0) others.push_back(rates_of(realisation.poles(order).values, interval));
    const Realisation::Poles poles = realisation.poles(out.order);
    for (Eigen::Index i = 0; i < poles.values.size(); ++i) {
        const Complex z = poles.values(i);
        if (z.imag() == 0) ++out.rates;
        if (!(z.imag() > 0)) continue;
        const Complex rate = std::log(z) / interval;
        const bool is_confirmed = std::ranges::all_of(others, [&](const std::vector<Complex>& rates) {
            return std::ranges::any_of(rates, [&](Complex other) { return is_same(rate, other); });
        });
        IdentifiedMode mode{rate, 2 * poles.shapes.col(i), 0};  // with its conjugate
        mode.strength = mode.shape.cwiseAbs().cwiseQuotient(scales).squaredNorm() / 2 *
                        duration_of(rate, interval, samples) / static_cast<double>(samples * channels.size());
        if (!is_confirmed || mode.strength <= left_out) {
            ++(is_confirmed ? out.faint : out.spurious);
            continue;
        }
        out.modes.push_back(std::move(mode));
    }
    std::ranges::stable_sort(out.modes, std::greater{}, &IdentifiedMode::strength);
    if (out.modes.size() > wanted) {
        out.weaker = out.modes.size() - wanted;
        out.modes.resize(wanted);
    }
    std::ranges::stable_sort(out.modes, {}, [](const IdentifiedMode& mode) { return mode.rate.imag(); });
    return out;
}

}  // namespace dttmm::host
