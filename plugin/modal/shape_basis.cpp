// SPDX-License-Identifier: BSD-3-Clause
#include "modal/shape_basis.h"

#include <algorithm>
#include <cmath>

namespace dttmm::plugin {

namespace {

/// A displacement (or another linear measure) of every shape of a group, and what decides between equal ones.
struct Measure {
    Eigen::VectorXd values;
    int direction;
    Vector3 position;
};

/// Whether `a` comes before `b` where both are as large: by direction, then by place, to `grain` [m].
bool comes_first(const Measure& a, const Measure& b, double grain) {
    if (a.direction != b.direction) return a.direction < b.direction;
    for (Eigen::Index i = 0; i < 3; ++i)
        if (std::abs(a.position(i) - b.position(i)) > grain) return a.position(i) < b.position(i);
    return false;
}

/// The measure in which a shape of unit norm can be largest; of displacements if there are any, else of rotations.
const Measure* find_largest(const std::vector<Measure>& measures) {
    double most[2] = {0, 0}, size = 0;
    for (const Measure& m : measures) {
        most[m.direction / 3] = std::max(most[m.direction / 3], m.values.norm());
        size = std::max(size, m.position.norm());
    }
    const int kind = most[0] > kShapeRounding * most[1] ? 0 : 1;
    const Measure* best = nullptr;
    for (const Measure& m : measures)
        if (m.direction / 3 == kind && m.values.norm() >= (1 - kShapeRounding) * most[kind] && m.values.norm() > 0)
            if (!best || comes_first(m, *best, kShapeRounding * size)) best = &m;
    return best;
}

/// Displacements and rotations of all stations.
std::vector<Measure> measure_stations(const DynamicStiffness& D, const std::vector<FrameVector>& shapes) {
    std::vector<Measure> measures;
    for (size_t j = 0; j < shapes.size(); ++j) {
        const std::vector<Station> list = stations(D, shapes[j]);
        measures.resize(6 * list.size());
        for (size_t i = 0; i < measures.size(); ++i) {
            if (j == 0) measures[i] = {Eigen::VectorXd(as_row(shapes.size())), as_int(i % 6), list[i / 6].position};
            measures[i].values(as_row(j)) = list[i / 6].motion(as_row(i % 6));
        }
    }
    return measures;
}

/// Momenta of the machine as a whole, of unit mass in each direction.
std::vector<Measure> measure_whole(const DynamicStiffness& D, const std::vector<FrameVector>& shapes) {
    std::vector<Measure> measures;
    for (int d = 0; d < 6; ++d) {
        const DynamicStiffness::Whole moved = D.move_whole(d);
        Measure measure{Eigen::VectorXd(as_row(shapes.size())), d, Vector3::Zero()};
        for (size_t j = 0; j < shapes.size(); ++j)
            measure.values(as_row(j)) = moved.mass > 0 ? dot(shapes[j], moved.momenta) / std::sqrt(moved.mass) : 0;
        measures.push_back(measure);
    }
    return measures;
}

}  // namespace

std::vector<FrameVector> mixed(const std::vector<FrameVector>& shapes, const Eigen::MatrixXd& mix) {
    std::vector<FrameVector> sums(as_size(mix.cols()), FrameVector(shapes.front().size(), Vector6::Zero()));
    for (size_t j = 0; j < sums.size(); ++j)
        for (size_t i = 0; i < shapes.size(); ++i)
            for (size_t f = 0; f < shapes[i].size(); ++f) sums[j][f] += mix(as_row(i), as_row(j)) * shapes[i][f];
    return sums;
}

void fix_basis(const DynamicStiffness& D, std::vector<FrameVector>& shapes, bool is_rigid) {
    for (FrameVector& shape : shapes) {
        const double unit = 1 / std::sqrt(dot(shape, D.mass_times(shape)));
        if (!std::isfinite(unit)) return;
        for (Vector6& u : shape) u *= unit;
    }
    std::vector<Measure> measures = measure_stations(D, shapes), whole;
    if (is_rigid) whole = measure_whole(D, shapes);
    // Each measure is largest for the shape along it; the rest of the measures is what shapes at right angles can do
    const auto n = as_row(shapes.size());
    Eigen::MatrixXd mix = Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
        const auto free = std::ranges::find_if(whole, [](const Measure& m) { return m.values.norm() > kShapeRounding; });
        const Measure* const chosen = free != whole.end() ? &*free : find_largest(measures);
        const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n) - mix.leftCols(k) * mix.leftCols(k).transpose();
        Eigen::Index any = 0;  // where no point moves: what is left the most
        rest.diagonal().maxCoeff(&any);
        mix.col(k) = (chosen ? Eigen::VectorXd(rest * chosen->values.normalized()) : rest.col(any)).normalized();
        for (auto* list : {&measures, &whole})
            for (Measure& m : *list) m.values -= m.values.dot(mix.col(k)) * mix.col(k);
    }
    shapes = mixed(shapes, mix);
}

}  // namespace dttmm::plugin
