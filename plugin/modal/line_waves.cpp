// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_waves.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/parameters.h"
#include "modal/exponential.h"
#include "modal/line_equations.h"

namespace dttmm::plugin {

namespace {

/// Bending planes: the deflection and the rotation that goes with it.
constexpr std::array kPlanes = {std::pair<size_t, size_t>{1, 5}, std::pair<size_t, size_t>{2, 4}};

void require(double value, const char* key) {
    if (is_given(value)) return;
    const bool is_shear = key[0] == 'G' && key[1] == 'A';
    throw Error(DTTMM_ERROR_MODEL,
                fmt::format("section.{} is needed for the directions that move{}", key,
                            is_shear ? "; without shear write theory = \"euler-bernoulli\" in its place" : ""));
}

/// Of a unit length: the mass matrix of the section by the motion of its elastic axis.
Matrix6 mass_per_length(const Section& s) {
    const Vector3 c(0, s.offset_y, s.offset_z);
    Matrix6 M;
    M.topLeftCorner<3, 3>() = s.mass * Matrix3::Identity();
    M.topRightCorner<3, 3>() = -s.mass * skew(c);
    M.bottomLeftCorner<3, 3>() = s.mass * skew(c);
    M.bottomRightCorner<3, 3>() = -s.mass * skew(c) * skew(c);
    M(3, 3) = s.inertia;
    M(4, 4) += s.rotary_y;
    M(5, 5) += s.rotary_z;
    return M;
}

/// Calls with the number of directions of a group, one and two as constants: most groups are an axial or torsional wave or a
/// bending plane.
template <class Call>
void with_size(size_t directions, const Call& call) {
    if (directions == 1)
        call(std::integral_constant<int, 1>());
    else if (directions == 2)
        call(std::integral_constant<int, 2>());
    else
        call(std::integral_constant<int, Eigen::Dynamic>());
}

}  // namespace

LineWaves::LineWaves(const Line& line, double length, Directions active, Axial axial, const Matrix3& falling)
    : length_(length), axial_(axial) {
    const Section& s = line.section;
    Directions moving;
    moving[0] = active[0];
    if (line.stretches_only) {
        passed_ = active;
        passed_[0] = false;
        for (const auto& [deflection, rotation] : kPlanes)
            if (active[deflection] && !active[rotation]) {
                pinned_.set(deflection);
                passed_.reset(deflection);
            }
    } else {
        moving[3] = active[3];
        for (const auto& [deflection, rotation] : kPlanes) {
            if (active[deflection] && !active[rotation])
                throw Error(DTTMM_ERROR_MODEL,
                            fmt::format("dofs keep its local {} but not {}: a beam bends by both; keep both, or take a rod",
                                        kDirectionNames[deflection], kDirectionNames[rotation]));
            if (active[deflection])
                moving.set(deflection).set(rotation);
            else
                passed_[rotation] = active[rotation];
        }
    }
    if (moving[1]) require(s.EIz, "EIz"), require(s.GAy, "GAy");
    if (moving[2]) require(s.EIy, "EIy"), require(s.GAz, "GAz");
    if (moving[3]) require(s.GJ, "GJ"), require(s.inertia, "inertia");

    Vector6 C;
    C << 1 / s.EA, 1 / s.GAy, 1 / s.GAz, 1 / s.GJ, 1 / s.EIy, 1 / s.EIz;
    Matrix6 F = Matrix6::Zero();
    F.bottomRightCorner<3, 3>() = falling;
    group_directions(s, moving, mass_per_length(s), F, C);
}

/// Directions that the equations of the line couple, in groups: each is solved by itself.
void LineWaves::group_directions(const Section& s, Directions moving, const Matrix6& M, const Matrix6& falling,
                                 const Vector6& C) {
    Matrix6 A = Matrix6::Zero();
    A(1, 5) = 1;
    A(2, 4) = -1;
    std::array<int, 6> group_of{};
    group_of.fill(-1);
    for (size_t first = 0; first < 6; ++first) {
        if (!moving[first] || group_of[first] >= 0) continue;
        Group group;
        const auto add = [&](size_t d) {
            group_of[d] = as_int(groups_.size());
            group.directions.push_back(as_int(d));
        };
        add(first);
        for (size_t k = 0; k < group.directions.size(); ++k)
            for (size_t d = 0; d < 6; ++d) {
                const int other = group.directions[k], own = as_int(d);
                const bool bend = other != own && other + own == 6;  // a deflection and its rotation, also where N = GA
                if (moving[d] && group_of[d] < 0 && (bend || M(other, own) != 0 || falling(other, own) != 0)) add(d);
            }
        const auto n = as_row(group.directions.size());
        const auto own = [&](const Matrix6& of) {
            Group::Few part(n, n);
            for (Eigen::Index i = 0; i < n; ++i)
                for (Eigen::Index j = 0; j < n; ++j)
                    part(i, j) = of(group.directions[as_size(i)], group.directions[as_size(j)]);
            return part;
        };
        group.A = own(A);
        group.M = own(M);
        group.falling = own(falling);
        group.C = C(group.directions);
        group.unit_d.setOnes(n);
        group.unit_n.resize(n);
        for (Eigen::Index k = 0; k < n; ++k) {
            const int d = group.directions[as_size(k)];
            const double bending = d == 1 ? s.EIz : d == 2 ? s.EIy : 0;
            group.unit_n(k) = bending > 0 ? bending : 1 / C(d);
        }
        for (size_t g = 0; g < groups_.size() && group.mirror < 0; ++g)
            if (is_mirror(group, groups_[g])) group.mirror = as_int(g);
        groups_.push_back(std::move(group));
    }
}

/// Whether it is another plane's group with its rotation the other way round: so are both planes of a round or square
/// section.
bool LineWaves::is_mirror(const Group& one, const Group& other) {
    return one.directions.size() == 2 && other.directions.size() == 2 && one.C == other.C && one.M == other.M &&
           one.M(0, 1) == 0 && one.M(1, 0) == 0 && one.falling.isZero(0) && other.falling.isZero(0) && one.A == -other.A;
}

double LineWaves::scale(const Group& group, double start, double s, double lambda) const {
    const double force = std::max(std::abs(axial_at(start)), std::abs(axial_at(start + s)));
    double most = 1 / s;  // of wave numbers
    for (Eigen::Index k = 0; k < as_row(group.directions.size()); ++k) {
        const double mass = lambda * group.M(k, k);
        const int direction = group.directions[as_size(k)];
        most = std::max(most, std::sqrt(mass * group.C(k)));
        if (direction > 3) most = std::max(most, std::sqrt(force * group.C(k)));
        most = std::max(most, std::sqrt(group.falling.row(k).cwiseAbs().sum() * group.C(k)));
        for (Eigen::Index r = 0; r < as_row(group.directions.size()); ++r)
            if (direction + group.directions[as_size(r)] == 6 && (direction == 1 || direction == 2))
                most = std::max(most, std::pow(mass * group.C(r), 0.25));
    }
    return 1 / most;
}

/// Over s, in units in which deflections count in a length, and forces as what bends, or shears, by a radian on that.
template <class Scalar, int n>
LineEquations<LineWaves::Whole<Scalar, n>> LineWaves::equations_of(const Group& group, double start, double s, Scalar lambda,
                                                                   Scalar stiffening, double length, Numbers<n>& ud,
                                                                   Numbers<n>& un) const {
    using Real = Part<double, n>;
    using States = Whole<Scalar, n>;
    const auto size = as_row(group.directions.size());
    ud = group.unit_d;
    un = group.unit_n;
    for (Eigen::Index k = 0; k < size; ++k) {
        const int d = group.directions[as_size(k)];
        if (d < 3) ud(k) = length;
        if (d >= 3) un(k) /= length;
        if (d == 1 || d == 2) un(k) = 1 / (length * length / un(k) + group.C(k));
    }
    const auto in_units = [&](const Group::Few& by_d, const Numbers<n>& unit) {
        return Real(s * (unit.cwiseInverse().asDiagonal() * Real(by_d) * ud.asDiagonal()));
    };
    // Of n: −Aᵀ
    const Numbers<n> between = un.cwiseProduct(ud), back = between.cwiseInverse();
    const auto minus_At = [&](const Real& A) { return Real(back.asDiagonal() * (-A.transpose()) * between.asDiagonal()); };
    const auto corner = [&](States& of, int row, int column) {
        return of.template block<n, n>(row * size, column * size, size, size);
    };
    const Real A = in_units(group.A, ud), M = in_units(group.M, un);
    const Numbers<n> C = s * ud.cwiseInverse().cwiseProduct(Numbers<n>(group.C)).cwiseProduct(un);
    LineEquations<States> equations;
    for (States* S : {&equations.S[0], &equations.S[1], &equations.S[2], &equations.by_lambda})
        S->setZero(2 * size, 2 * size);
    States& S = equations.S[0];
    corner(S, 0, 0) = A.template cast<Scalar>();
    corner(S, 0, 1).diagonal() = C.template cast<Scalar>() / stiffening;
    corner(S, 1, 0) = in_units(group.falling, un).template cast<Scalar>() - lambda * M.template cast<Scalar>();
    corner(S, 1, 1) = minus_At(A).template cast<Scalar>();
    corner(equations.by_lambda, 1, 0) = -M.template cast<Scalar>();
    if ((axial_[0] != 0 || axial_[1] != 0) && !group.A.isZero(0)) {
        const double N = axial_at(start), rise = is_graded() ? axial_at(start + s) - N : 0;
        const Group::Few by_N = group.A_by_N();
        const Real A_by_N = in_units(by_N, ud), G_by_N = in_units(group.A.transpose() * group.A, un),
                   G_by_N2 = in_units(group.A.transpose() * by_N, un);
        const auto add = [&](States& to, double to_A, const Real& G) {
            corner(to, 0, 0) += (to_A * A_by_N).template cast<Scalar>();
            corner(to, 1, 0) += G.template cast<Scalar>();
            corner(to, 1, 1) += (to_A * minus_At(A_by_N)).template cast<Scalar>();
        };
        add(S, N, N * G_by_N + N * N * G_by_N2);
        add(equations.S[1], rise, rise * G_by_N + 2 * N * rise * G_by_N2);
        add(equations.S[2], 0, rise * rise * G_by_N2);
    }
    return equations;
}

template <class Scalar, int n>
LineWaves::Waves<Scalar, n> LineWaves::waves(const Group& group, double start, double s, Scalar lambda, Scalar stiffening,
                                             bool with_derivative) const {
    Waves<Scalar, n> waves;
    const auto equations = equations_of<Scalar, n>(group, start, s, lambda, stiffening,
                                                   scale(group, start, s, std::abs(lambda)), waves.unit_d, waves.unit_n);
    if (equations.is_uniform()) {
        exponential(equations.S[0], equations.by_lambda, with_derivative, waves.U, waves.by_lambda);
        return waves;
    }
    const auto size = equations.by_lambda.rows();
    using States = Whole<Scalar, n>;
    const States one = States::Identity(size, size);
    if (with_derivative) {
        std::array<States, 2> y{one, States::Zero(size, size)};
        carry_over(equations, equations.norm(), y);
        waves.U = y[0];
        waves.by_lambda = y[1];
    } else {
        std::array<States, 1> y{one};
        carry_over(equations, equations.norm(), y);
        waves.U = y[0];
    }
    return waves;
}

std::optional<LineWaves::Expansion> LineWaves::expand(int count, double largest, int index) const {
    const double s = length_ / count;
    Expansion expansion{largest, s, {}};
    bool is_possible = true;
    for (const Group& group : groups_) {
        Expansion::OfGroup& own = expansion.groups.emplace_back();
        if (group.mirror >= 0 || group.directions.size() == 1) continue;
        with_size(group.directions.size(), [&]<int n>(std::integral_constant<int, n>) {
            using States = Whole<double, n>;
            Numbers<n> unit_d, unit_n;
            auto equations =
                equations_of<double, n>(group, index * s, s, 0, 1, scale(group, index * s, s, largest), unit_d, unit_n);
            equations.by_lambda *= largest;
            const auto size = equations.by_lambda.rows();
            std::array<States, kPowers> powers;
            powers.fill(States::Zero(size, size));
            powers[0].setIdentity();
            carry_over(equations, equations.norm() + norm_of(equations.by_lambda), powers);
            // Up to the last that is felt
            States most = States::Zero(size, size);
            size_t felt = 0;
            for (size_t j = 0; j < kPowers; ++j) {
                const States more = most + powers[j].cwiseAbs();
                if (more != most) felt = j;
                most = more;
            }
            is_possible = is_possible && felt + 1 < kPowers;
            own.powers = felt + 1;
            own.unit_d = unit_d;
            own.unit_n = unit_n;
            for (size_t j = 0; j <= felt; ++j) own.U.insert(own.U.end(), powers[j].data(), powers[j].data() + size * size);
        });
    }
    return is_possible ? std::optional(std::move(expansion)) : std::nullopt;
}

/// By Horner's rule.
template <int n>
LineWaves::Waves<double, n> LineWaves::waves(const Expansion::OfGroup& own, double share, bool with_derivative) {
    const auto size = 2 * own.unit_d.size();
    Waves<double, n> waves;
    waves.unit_d = own.unit_d;
    waves.unit_n = own.unit_n;
    waves.U.setZero(size, size);
    waves.by_lambda.setZero(size, size);
    for (size_t j = own.powers; j-- > 0;) {
        if (with_derivative) waves.by_lambda = (share * waves.by_lambda + waves.U).eval();
        waves.U = (share * waves.U + Eigen::Map<const Whole<double, n>>(own.U.data() + j * as_size(size * size), size, size))
                      .eval();
    }
    return waves;
}

/// The longest piece, by a lower bound, that does not vibrate with its ends held at any ω² below λ. In a bending plane let
/// a = 1 − N/GA and γ = v' − a θ. Over a length l at whose ends v and θ vanish, Wirtinger's inequalities are
///     ∫θ² ≤ (l/π)² ∫θ'²,   ∫v² ≤ (l/π)² ∫v'²,   ∫v'² ≤ (1 + 1/e) ∫γ² + (1 + e) a² (l/2π)² ∫θ'²  for every e > 0;
/// the last holds because the mean of v' is zero. With the best e, and x = l²/π², λ ∫(µ v² + J θ²) + |N a| ∫θ² is at most
/// ∫(EI θ'² + GA γ²) if
///     λ µ a² x²/4 + (λ J + |N a| + EI λ µ/GA) x ≤ EI.
/// The axial force adds −N a ∫θ² to the left, at most |N a| ∫θ². With that in tension too, exponentials do not overflow. So
/// does what is falling, F: in each rotation it counts by Σ_j |F_ij|. A mass that couples directions counts in each by Σ_j
/// |M_ij| √(M_ii/M_jj).
double LineWaves::longest_held(const Group& group, double lambda) const {
    double least = std::numeric_limits<double>::infinity();  // of x
    const auto n = as_row(group.directions.size());
    const auto inertia = [&](Eigen::Index k) {
        double sum = 0;
        for (Eigen::Index j = 0; j < n; ++j)
            if (group.M(k, j) != 0) sum += std::abs(group.M(k, j)) * std::sqrt(group.M(k, k) / group.M(j, j));
        return lambda * sum;
    };
    for (Eigen::Index k = 0; k < n; ++k) {
        const int direction = group.directions[as_size(k)];
        if (direction > 3) continue;  // a rotation that bends goes with its deflection
        const auto falls = [&](Eigen::Index r) { return group.falling.row(r).cwiseAbs().sum(); };
        if (direction == 0 || direction == 3) {
            least = std::min(least, 1 / ((inertia(k) + falls(k)) * group.C(k)));
            continue;
        }
        const auto rotation = std::ranges::find(group.directions, direction == 1 ? 5 : 4) - group.directions.begin();
        const double strongest = std::max(std::abs(axial_[0]), std::abs(axial_[1]));
        const double a = std::max(std::abs(group.A_at(axial_[0])(k, rotation)),
                                  std::abs(group.A_at(axial_[1])(k, rotation))),
                     bending = 1 / group.C(rotation), mass = inertia(k);
        const double linear = inertia(rotation) + falls(rotation) + strongest * a + bending * mass * group.C(k);
        least = std::min(least, 2 * bending / (linear + std::sqrt(linear * linear + mass * a * a * bending)));
    }
    return M_PI * std::sqrt(least);
}

double LineWaves::longest_held(double lambda) const {
    double longest = std::numeric_limits<double>::infinity();
    for (const Group& group : groups_) longest = std::min(longest, longest_held(group, lambda));
    return longest;
}

std::string LineWaves::too_strong_to_cut() {
    return fmt::format("its axial force is so strong that it would take more than {} pieces", kMostPieces);
}

int LineWaves::pieces(double omega, int most) const {
    const double count = std::max(1.0, std::ceil(length_ / longest_held(kMargin * omega * omega)));
    return static_cast<int>(std::min(count, most + 1.0));
}

template <class Scalar>
void LineWaves::evaluate(int count, Scalar lambda, Scalar stiffening, Square<Scalar>& stiffness, Square<Scalar>* mass,
                         int index) const {
    const double s = length_ / count;
    evaluate_groups<Scalar>(stiffness, mass, [&]<int n>(size_t g, std::integral_constant<int, n>) {
        return waves<Scalar, n>(groups_[g], index * s, s, lambda, stiffening, mass != nullptr);
    });
}

void LineWaves::evaluate(const Expansion& expansion, double lambda, Matrix12& stiffness, Matrix12* mass) const {
    evaluate_groups<double>(stiffness, mass, [&]<int n>(size_t g, std::integral_constant<int, n>) {
        const Expansion::OfGroup& own = expansion.groups[g];
        if (own.powers == 0) return waves<double, n>(groups_[g], 0, expansion.length, lambda, 1, mass != nullptr);
        Waves<double, n> waves = LineWaves::waves<n>(own, lambda / expansion.largest, mass != nullptr);
        waves.by_lambda /= expansion.largest;
        return waves;
    });
}

/// What stands in rows of the plane that is this one's mirror, and in columns of both its ends. rows: 2 at a place, 4 at
/// both ends.
template <class Matrix>
void LineWaves::copy_mirrored(const Group& group, size_t rows, Matrix& matrix) const {
    const std::vector<int>& other = groups_[as_size(group.mirror)].directions;
    const auto at = [](const std::vector<int>& directions, size_t k) { return directions[k % 2] + (k < 2 ? 0 : 6); };
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < 4; ++j)
            matrix(at(group.directions, i), at(group.directions, j)) =
                ((i + j) % 2 == 0 ? 1.0 : -1.0) * matrix(at(other, i), at(other, j));
}

/// waves_of: of the group of a number, n as a constant.
template <class Scalar, class WavesOf>
void LineWaves::evaluate_groups(Square<Scalar>& stiffness, Square<Scalar>* mass, const WavesOf& waves_of) const {
    stiffness.setZero();
    if (mass) mass->setZero();
    for (size_t g = 0; g < groups_.size(); ++g) {
        const Group& group = groups_[g];
        if (group.mirror >= 0) {
            copy_mirrored(group, 4, stiffness);
            if (mass) copy_mirrored(group, 4, *mass);
            continue;
        }
        with_size(group.directions.size(), [&]<int n>(std::integral_constant<int, n> constant) {
            add_group<Scalar, n>(group, waves_of(g, constant), stiffness, mass);
        });
    }
}

template <class Scalar, int n>
void LineWaves::add_group(const Group& group, const Waves<Scalar, n>& w, Square<Scalar>& stiffness, Square<Scalar>* mass) {
    using Own = Part<Scalar, n>;
    const auto size = as_row(group.directions.size());
    const auto corner = [&](const Whole<Scalar, n>& of, int row, int column) {
        return Own(of.template block<n, n>(row * size, column * size, size, size));
    };
    const Own Udd = corner(w.U, 0, 0), Unn = corner(w.U, 1, 1), Udn = corner(w.U, 0, 1);
    Own W;
    if constexpr (n > 0)
        W = Udn.inverse();  // by cofactors
    else
        W = Udn.fullPivLu().inverse();
    // n0 = W (d1 − Udd d0),  n1 = Und d0 + Unn n0; on the piece act −n0 and n1
    const auto store = [&](const Own& first, const Own& across, const Own& end, double sign, Square<Scalar>& into) {
        const auto scaled = [&](const Own& part) {
            return Own(w.unit_n.asDiagonal() * part * w.unit_d.cwiseInverse().asDiagonal());
        };
        // The upper right block is taken, its transpose would have the units of the other side
        const Own here = scaled(first), between = scaled(across), there = scaled(end);
        for (Eigen::Index i = 0; i < size; ++i)
            for (Eigen::Index j = 0; j < size; ++j) {
                const int k = group.directions[as_size(i)], l = group.directions[as_size(j)];
                into(k, l) = 0.5 * sign * (here(i, j) + here(j, i));
                into(6 + k, 6 + l) = 0.5 * sign * (there(i, j) + there(j, i));
                into(k, 6 + l) = into(6 + l, k) = sign * between(i, j);
            }
    };
    store(W * Udd, -W, Unn * W, 1, stiffness);
    if (!mass) return;
    const Own dUdd = corner(w.by_lambda, 0, 0), dUnn = corner(w.by_lambda, 1, 1), dW = -W * corner(w.by_lambda, 0, 1) * W;
    store(dW * Udd + W * dUdd, -dW, dUnn * W + Unn * dW, -1, *mass);
}

Vector12 LineWaves::carry(Vector12 state, double lambda, double s, double start) const {
    if (!(s > 0)) return state;
    for (const Group& group : groups_)
        with_size(group.directions.size(), [&]<int n>(std::integral_constant<int, n>) {
            const auto size = as_row(group.directions.size());
            Numbers<n> unit_d, unit_n;
            const auto equations = equations_of<double, n>(group, start, s, lambda, 1,
                                                           scale(group, start, s, std::abs(lambda)), unit_d, unit_n);
            using States = Eigen::Matrix<double, kTwice<n>, 1, 0, 2 * kMost<n>, 1>;
            std::array<States, 1> y{States(2 * size)};
            y[0].head(size) = state(group.directions).cwiseQuotient(unit_d);
            y[0].tail(size) = state.tail<6>()(group.directions).cwiseQuotient(unit_n);
            carry_over(equations, equations.norm(), y);
            state(group.directions) = y[0].head(size).cwiseProduct(unit_d);
            state.tail<6>()(group.directions) = y[0].tail(size).cwiseProduct(unit_n);
        });
    return state;
}

Matrix12 LineWaves::transfer(double lambda, double s, double start) const {
    Matrix12 U = Matrix12::Identity();
    if (!(s > 0)) return U;
    for (const Group& group : groups_)
        with_size(group.directions.size(), [&]<int n>(std::integral_constant<int, n>) {
            const auto size = as_row(group.directions.size());
            const Waves<double, n> w = waves<double, n>(group, start, s, lambda, 1, false);
            Column unit(2 * size);
            unit << w.unit_d, w.unit_n;
            const auto at = [&](Eigen::Index k) { return group.directions[as_size(k % size)] + (k < size ? 0 : 6); };
            for (Eigen::Index i = 0; i < 2 * size; ++i)
                for (Eigen::Index j = 0; j < 2 * size; ++j) U(at(i), at(j)) = unit(i) * w.U(i, j) / unit(j);
        });
    return U;
}

LineShapes LineWaves::static_shapes() const {
    Matrix12 K;
    evaluate<double>(1, 0, 1, K, nullptr);
    LineShapes shapes;
    shapes.stiffness = K;
    for (LineShapes::Shape& shape : shapes.at) {
        shape.d.setIdentity();
        shape.slope.setZero();
    }
    for (const Group& group : groups_) {
        if (group.mirror >= 0) {
            for (LineShapes::Shape& shape : shapes.at)
                for (auto* matrix : {&shape.d, &shape.slope}) copy_mirrored(group, 2, *matrix);
            continue;
        }
        with_size(group.directions.size(), [&]<int n>(std::integral_constant<int, n>) {
            const auto size = as_row(group.directions.size());
            const auto at = [&](Eigen::Index k) { return group.directions[as_size(k % size)] + (k < size ? 0 : 6); };
            Whole<double, n> start(2 * size, 2 * size);  // [d; n] there by the ends
            for (Eigen::Index i = 0; i < size; ++i)
                for (Eigen::Index j = 0; j < 2 * size; ++j) {
                    start(i, j) = i == j;
                    start(size + i, j) = -K(at(i), at(j));
                }
            for (size_t k = 0; k < shapes.at.size(); ++k) {
                const double place = LineShapes::kPoints[k] * length_;
                const Waves<double, n> w = waves<double, n>(group, 0, place, 0, 1, false);
                Column unit(2 * size);
                unit << w.unit_d, w.unit_n;
                const Whole<double, n> state = unit.asDiagonal() * (w.U * (unit.cwiseInverse().asDiagonal() * start)).eval();
                const auto d = state.topRows(size), forces = state.bottomRows(size);
                const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 12> slope =
                    group.A_at(axial_at(place)) * d + group.C.asDiagonal() * forces;
                for (Eigen::Index i = 0; i < size; ++i)
                    for (Eigen::Index j = 0; j < 2 * size; ++j) {
                        shapes.at[k].d(at(i), at(j)) = d(i, j);
                        shapes.at[k].slope(at(i), at(j)) = slope(i, j);
                    }
            }
        });
    }
    return shapes;
}

template void LineWaves::evaluate(int, double, double, Square<double>&, Square<double>*, int) const;
template void LineWaves::evaluate(int, std::complex<double>, std::complex<double>, Square<std::complex<double>>&,
                                  Square<std::complex<double>>*, int) const;

}  // namespace dttmm::plugin
