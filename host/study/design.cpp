// SPDX-License-Identifier: BSD-3-Clause
#include "study/design.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// The upper 53 bits as a number in the middle of its cell: never 0, never 1.
double to_probability(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

/// Numbers that the standard fixes: what the library makes of an engine differs from one to the next.
class Draws {
public:
    explicit Draws(std::uint64_t seed) : engine_(seed) {}
    double probability() { return to_probability(engine_()); }
    std::uint64_t bits() { return engine_(); }
    /// 0 … count − 1.
    Eigen::Index below(Eigen::Index count) {
        return std::min(count - 1, static_cast<Eigen::Index>(probability() * static_cast<double>(count)));
    }

private:
    std::mt19937_64 engine_;
};

Eigen::MatrixXd draw_latin(Eigen::Index cases, Eigen::Index parameters, Draws draws) {
    Eigen::MatrixXd u(cases, parameters);
    std::vector<Eigen::Index> cell(as_size(cases));
    for (Eigen::Index p = 0; p < parameters; ++p) {
        std::iota(cell.begin(), cell.end(), 0);
        for (Eigen::Index i = cases - 1; i > 0; --i) std::swap(cell[as_size(i)], cell[as_size(draws.below(i + 1))]);
        for (Eigen::Index i = 0; i < cases; ++i)
            u(i, p) = (static_cast<double>(cell[as_size(i)]) + draws.probability()) / static_cast<double>(cases);
    }
    return u;
}

/// The first point of the sequence is 0 and belongs to every net of 2^m points; the library leaves it out. A random digital
/// shift of each parameter keeps the even spread and moves it.
Eigen::MatrixXd draw_sobol(Eigen::Index cases, Eigen::Index parameters, Draws draws) {
    boost::random::sobol sequence(as_size(parameters));
    std::vector<std::uint64_t> shift(as_size(parameters));
    for (std::uint64_t& bits : shift) bits = draws.bits();
    Eigen::MatrixXd u(cases, parameters);
    for (Eigen::Index i = 0; i < cases; ++i)
        for (Eigen::Index p = 0; p < parameters; ++p)
            u(i, p) = to_probability((i == 0 ? 0 : sequence()) ^ shift[as_size(p)]);
    return u;
}

/// A walk begins in the middle of one of four cells of each parameter and moves every parameter once, in random order, by
/// two cells.
Eigen::MatrixXd draw_morris(Eigen::Index walks, Eigen::Index parameters, Draws draws) {
    Eigen::MatrixXd u(walks * (parameters + 1), parameters);
    std::vector<Eigen::Index> order(as_size(parameters));
    for (Eigen::Index w = 0; w < walks; ++w) {
        const Eigen::Index first = w * (parameters + 1);
        for (Eigen::Index p = 0; p < parameters; ++p) u(first, p) = (static_cast<double>(draws.below(4)) + 0.5) / 4;
        std::iota(order.begin(), order.end(), 0);
        for (Eigen::Index i = parameters - 1; i > 0; --i) std::swap(order[as_size(i)], order[as_size(draws.below(i + 1))]);
        for (Eigen::Index step = 0; step < parameters; ++step) {
            u.row(first + step + 1) = u.row(first + step);
            double& moved = u(first + step + 1, order[as_size(step)]);
            moved += moved < 0.5 ? 0.5 : -0.5;
        }
    }
    return u;
}

/// A and B of each block are the two halves of a point of a sequence in twice as many dimensions.
Eigen::MatrixXd draw_indices(Eigen::Index blocks, Eigen::Index parameters, const Draws& draws) {
    const Eigen::MatrixXd both = draw_sobol(blocks, 2 * parameters, draws);
    Eigen::MatrixXd u(blocks * (parameters + 2), parameters);
    for (Eigen::Index b = 0; b < blocks; ++b) {
        const Eigen::Index first = b * (parameters + 2);
        u.row(first) = both.row(b).head(parameters);
        u.row(first + 1) = both.row(b).tail(parameters);
        for (Eigen::Index p = 0; p < parameters; ++p) {
            u.row(first + 2 + p) = u.row(first);
            u(first + 2 + p, p) = u(first + 1, p);
        }
    }
    return u;
}

/// Indices of a column from its smallest to its largest number.
std::vector<Eigen::Index> ranking(const Eigen::Ref<const Eigen::VectorXd>& column) {
    std::vector<Eigen::Index> order(as_size(column.size()));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](Eigen::Index i) { return column(i); });
    return order;
}

}  // namespace

Design parse_design(const std::string& text) {
    if (text == "latin") return Design::latin;
    if (text == "sobol") return Design::sobol;
    if (text == "random") return Design::random;
    if (text == "one-at-a-time") return Design::single;
    if (text == "morris") return Design::morris;
    if (text == "sobol-indices") return Design::indices;
    throw Error(ExitCode::usage,
                fmt::format("--design {}: there is no such design{}", quote(text),
                            suggestion(text, {"latin", "sobol", "random", "one-at-a-time", "morris", "sobol-indices"})));
}

Eigen::Index block_size(Design design, Eigen::Index parameters) {
    return design == Design::morris ? parameters + 1 : design == Design::indices ? parameters + 2 : 1;
}

Eigen::MatrixXd make_probabilities(Design design, Eigen::Index cases, Eigen::Index parameters, std::uint64_t seed) {
    Draws draws(seed);
    if (design == Design::latin) return draw_latin(cases, parameters, draws);
    if (design == Design::sobol) return draw_sobol(cases, parameters, draws);
    if (design == Design::morris) return draw_morris(cases / block_size(design, parameters), parameters, draws);
    if (design == Design::indices) return draw_indices(cases / block_size(design, parameters), parameters, draws);
    Eigen::MatrixXd u(cases, parameters);
    for (Eigen::Index i = 0; i < cases; ++i)
        for (Eigen::Index p = 0; p < parameters; ++p) u(i, p) = draws.probability();
    return u;
}

void correlate(Eigen::MatrixXd& probabilities, const Eigen::MatrixXd& correlation) {
    // Normal scores of correlation r have ranks of correlation 6/π asin(r/2)
    Eigen::MatrixXd of_scores = correlation.unaryExpr([](double rank) { return 2 * std::sin(std::numbers::pi / 6 * rank); });
    of_scores.diagonal().setOnes();  // 2 sin(π/6) but for rounding
    const Eigen::LLT<Eigen::MatrixXd> factor(of_scores);
    if (factor.info() != Eigen::Success)
        throw Error(ExitCode::usage,
                    "--correlate: these correlations contradict each other: their matrix, taken for normal scores, is not "
                    "positive definite; make them smaller");
    const boost::math::normal standard;
    Eigen::MatrixXd scores = probabilities.unaryExpr([&](double u) { return boost::math::quantile(standard, u); });
    scores *= factor.matrixL().transpose();
    for (Eigen::Index p = 0; p < probabilities.cols(); ++p) {
        const std::vector<Eigen::Index> own = ranking(probabilities.col(p)), wanted = ranking(scores.col(p));
        const Eigen::VectorXd numbers = probabilities.col(p);
        for (size_t rank = 0; rank < own.size(); ++rank) probabilities(wanted[rank], p) = numbers(own[rank]);
    }
}

}  // namespace dttmm::host
