// SPDX-License-Identifier: BSD-3-Clause
#include "modal/slow_motions.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/index.h"
#include "modal/search.h"
#include "modal/shape_basis.h"

namespace dttmm::plugin {

namespace {

/// Shapes beside those that are looked for, as many again: random ones have next to nothing of a spin, and find what is near
/// instead.
size_t guards(size_t count) { return std::min(count, kMostShapes - std::min(count, kMostShapes)); }

}  // namespace

double SlowMotions::rounding() const { return std::max(kRigidRounding * stiffness_.stiffest(), of_turning_); }

double SlowMotions::most_hidden() const { return kWiden * kWiden * rounding(); }

double SlowMotions::quiet() {
    if (quiet_) return *quiet_;
    find_rounding();
    quiet_ = std::sqrt(rounding());
    if (*quiet_ == 0) return 0;
    for (const double far : {kNoise * *quiet_, kWiden * kWiden * kNoise * *quiet_})
        if (const std::optional<double> found = look_for_noise(*quiet_, far)) return *(quiet_ = found);
    is_noisy_ = true;
    return *quiet_;
}

/// A spring against turning has its stiffness in the matrix of both its frames, over their inertia and not over the whole
/// mass. A motion that turns both alike does not strain it, and has its rounding.
void SlowMotions::find_rounding() {
    const FrequencyModel& model = stiffness_.model();
    const double base = std::sqrt(rounding());
    const double most = kStrainRounding * model.stiffest_rotor();
    if (base == 0 || most <= base * base || count(kWiden * std::sqrt(most)) == 0) return;  // nothing so slow has it
    const double shift = -kFixed * base * base;
    const auto below = as_size(std::max(count(kNoise * base), 0));
    for (const size_t more : {guards(below), size_t{0}}) {
        if (below + more == 0 || below + more > kMostShapes) continue;
        std::vector<FrameVector> shapes = inverse_.random_shapes(below + more);
        std::vector<Strained> all;
        for (int round = 0; round < 2 && (round == 0 || !all.empty()); ++round) all = iterate_slow(shapes, shift, true);
        for (size_t k = 0; k < all.size(); ++k) {
            const double own = kStrainRounding * model.turning_of_springs(shapes[k]);
            if (all[k].surely <= own) of_turning_ = std::max(of_turning_, own);
        }
        if (!all.empty()) return;
    }
}

/// -1: not known.
int SlowMotions::count(double omega) {
    try {
        stiffness_.cut(omega);
        return stiffness_.count(omega * omega).value_or(-1);
    } catch (const Error&) {
        return -1;
    }
}

/// The spin of a thin rod between joints has so little inertia that rounding makes more of its λ than rounding() says. What
/// counts say there is noise, up to where they agree with the strain of the slowest motions. Nothing: they do not up to
/// `far`.
std::optional<double> SlowMotions::look_for_noise(double base, double far) {
    const double shift = -kFixed * far * far;
    const int above = count(far), fast = stiffness_.count(2 * shift - far * far).value_or(above);  // as far from the shift
    if (above <= fast) return base;
    if (as_size(above - fast) > kMostShapes) {
        grow_fast_ = fast;
        return base;
    }
    bool differ = stiffness_.count(-kFixed * base * base) != fast;
    for (double probe = far / kWiden; probe >= base && !differ; probe /= kWiden) differ = count(probe) != above;
    if (!differ) return base;
    stiffness_.cut(far);
    const size_t slow = as_size(above - fast);
    for (const size_t more : {guards(slow), size_t{0}}) {
        const std::vector<Strained> all = look_at_slow(slow + more, shift);
        if (all.empty()) continue;
        // Forces at rest balance to some digits only, and may leave strain where nothing holds: the second attempt allows it
        for (const double least : {kStrain * rounding(), most_hidden()}) {
            if (least == most_hidden() && !stiffness_.model().is_at_rest) break;
            int free = 0, growing = 0;
            double slowest = far * kNarrow;
            for (const Strained& own : all)
                if (own.surely <= least)
                    ++free;
                else
                    slowest = std::min(slowest, std::sqrt(own.surely / (own.grows ? kFixed : 1))), growing += own.grows;
            if (slowest < base) continue;
            for (const double probe : {std::max(slowest / kNarrow, base), base}) {
                if (count(probe) != fast + growing + free || stiffness_.count(-kFixed * probe * probe) != fast + growing)
                    continue;
                looked_at_ = {slow, shift};
                return probe;
            }
        }
        return std::nullopt;
    }
    return std::nullopt;
}

/// What strain makes of so many motions next to a shift; nothing: they cannot be distinguished.
std::vector<SlowMotions::Strained> SlowMotions::look_at_slow(size_t count, double shift) {
    std::vector<FrameVector> shapes = inverse_.random_shapes(count);
    return iterate_slow(shapes, shift, true);
}

/// Inverse iteration, and what strain makes of the shapes, the least strained first where they are parted.
std::vector<SlowMotions::Strained> SlowMotions::iterate_slow(std::vector<FrameVector>& shapes, double shift, bool parts) {
    if (inverse_.iterate(shapes, shift).empty()) return {};
    stiffness_.set(0);
    std::vector<Strained> all = strain_of(shapes);
    const auto is_free = [&](const Strained& one) { return one.surely <= kStrain * rounding(); };
    if (!parts || std::ranges::all_of(all, is_free)) {
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> span(masses_of(shapes), Eigen::EigenvaluesOnly);
        const bool are_apart = span.eigenvalues().minCoeff() > kSameShape * span.eigenvalues().maxCoeff();
        if (are_apart) return all;
        if (!parts) return {};
    }
    if (!part_by_strain(shapes)) return {};
    all = strain_of(shapes);
    std::vector<size_t> order(shapes.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::stable_sort(order, {}, [&](size_t k) { return all[k].surely; });
    std::vector<FrameVector> sorted;
    std::vector<Strained> strained;
    for (const size_t k : order) {
        sorted.push_back(std::move(shapes[k]));
        strained.push_back(all[k]);
    }
    shapes = std::move(sorted);
    return strained;
}

/// λ is twice the energy of a shape of unit modal mass.
std::vector<SlowMotions::Strained> SlowMotions::strain_of(const std::vector<FrameVector>& shapes) const {
    std::vector<Strained> all;
    for (const FrameVector& shape : shapes) {
        const Strain strain = sum(strain_energies(stiffness_, shape));
        const double size = std::abs(strain.energy);
        all.push_back({2 * (size - strain.unsure), 2 * (size + strain.unsure), strain.energy < -strain.unsure});
    }
    return all;
}

/// The mass between every two shapes.
Eigen::MatrixXd SlowMotions::masses_of(const std::vector<FrameVector>& shapes) const {
    const auto n = as_row(shapes.size());
    Eigen::MatrixXd mass(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const FrameVector momenta = stiffness_.mass_times(shapes[as_size(i)]);
        for (Eigen::Index j = 0; j <= i; ++j) mass(i, j) = mass(j, i) = dot(shapes[as_size(j)], momenta);
    }
    return mass;
}

/// Mixes shapes so that what nothing strains stands apart from what vibrates slowly. D cannot tell them apart: its rounding
/// is that of the largest stiffness. Of shapes that say the same one is left.
bool SlowMotions::part_by_strain(std::vector<FrameVector>& shapes) const {
    const Eigen::MatrixXd strain = strain_between(stiffness_, shapes);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> span(masses_of(shapes));
    if (span.info() != Eigen::Success || !span.eigenvectors().allFinite()) return false;
    const Eigen::Index rank = (span.eigenvalues().array() > kSameShape * span.eigenvalues().maxCoeff()).count();
    const Eigen::MatrixXd unit =
        span.eigenvectors().rightCols(rank) * span.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(unit.transpose() * strain * unit);
    if (own.info() != Eigen::Success || !own.eigenvectors().allFinite()) return false;
    shapes = mixed(shapes, unit * own.eigenvectors());
    return true;
}

SlowMotions::Strained SlowMotions::find_free(size_t count, double shift, std::vector<FrameVector>& shapes) {
    const size_t most = std::max(count, looked_at_.count);
    const struct {
        size_t among;
        double shift;
    } attempts[] = {
        {count, shift}, {count + guards(count), shift}, {most + guards(most), std::min(shift, looked_at_.shift)}};
    std::optional<Strained> found;
    for (const auto& [among, at] : attempts) {
        if (among > std::max(count, kMostShapes)) continue;
        std::vector<FrameVector> others;
        const std::optional<Strained> strained = find_least(count, among, at, others);
        if (!strained || (found && found->surely <= strained->surely)) continue;
        found = strained;
        shapes = std::move(others);
        if (found->surely <= kStrain * rounding()) break;
    }
    if (!found) throw Error(DTTMM_ERROR_NUMERIC, "the shapes of the rigid-body modes were not found");
    return *found;
}

/// The least strained among so many; nothing: they cannot be distinguished.
std::optional<SlowMotions::Strained> SlowMotions::find_least(size_t count, size_t among, double shift,
                                                             std::vector<FrameVector>& shapes) {
    shapes = inverse_.random_shapes(among);
    // What slow modes leave in the shapes falls by shift/(shift + λ) per round: until what is strained is rounding
    std::vector<Strained> all;
    double last, before = std::numeric_limits<double>::infinity();
    for (;; before = last) {
        all = iterate_slow(shapes, shift, among > count);
        if (all.size() < count) return std::nullopt;
        all.resize(count);
        last = std::ranges::max(all, {}, &Strained::surely).surely;
        if (!(last > 0 && last < 0.5 * before)) break;
    }
    shapes.resize(count);
    Strained found{last, 0, false};
    for (const Strained& own : all) found.most = std::max(found.most, own.most), found.grows = found.grows || own.grows;
    return found;
}

}  // namespace dttmm::plugin
