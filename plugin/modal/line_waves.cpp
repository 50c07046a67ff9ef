// SPDX-License-Identifier: BSD-3-Clause
#include "modal/line_waves.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;

/// Bending planes: the deflection and the rotation that goes with it.
constexpr std::array kPlanes = {std::pair<size_t, size_t>{1, 5}, std::pair<size_t, size_t>{2, 4}};

void require(double value, const char* key) {
    if (!is_given(value))
        throw Error(DTTMM_ERROR_MODEL, fmt::format("section.{} is needed for the directions that move", key));
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

/// e^X and its derivative by Y, X' = Y: Taylor of a small fraction until a term changes nothing, then squared. At λ = 0 the
/// series ends by itself.
template <class Square>
void exponential_of(Square X, Square Y, Square& E, Square& D) {
    constexpr int kMostTerms = 16;  // of a norm of 0.5 the next is 1e-20
    const double norm = X.cwiseAbs().colwise().sum().maxCoeff();
    const int squarings = norm > 0.5 ? static_cast<int>(std::ceil(std::log2(norm / 0.5))) : 0;
    const double part = std::ldexp(1.0, -squarings);
    X *= part;
    Y *= part;
    const auto n = X.rows();
    Square term = Square::Identity(n, n), change = Square::Zero(n, n);
    E = term;
    D = change;
    for (int k = 1; k <= kMostTerms; ++k) {
        const Square before = E, derivative = D;
        D += change = ((X * change + Y * term) / k).eval();
        E += term = (X * term / k).eval();
        if (E == before && D == derivative) break;
    }
    for (int k = 0; k < squarings; ++k) {
        D = (E * D + D * E).eval();
        E = (E * E).eval();
    }
}

/// e^X alone, by fewer products: Taylor's terms up to X¹⁵ as a polynomial in X⁴ (Paterson and Stockmeyer).
template <class Square>
Square exponential_alone(Square X) {
    const double norm = X.cwiseAbs().colwise().sum().maxCoeff();  // at 0.5 the first term left out is 7e-19
    const int squarings = norm > 0.5 ? static_cast<int>(std::ceil(std::log2(norm / 0.5))) : 0;
    X *= std::ldexp(1.0, -squarings);
    const Square X2 = X * X, X3 = X2 * X, X4 = X2 * X2;
    constexpr std::array<double, 16> kPartOf = [] {
        std::array<double, 16> parts{1};
        for (size_t k = 1; k < parts.size(); ++k) parts[k] = parts[k - 1] / static_cast<double>(k);
        return parts;
    }();
    const auto four = [&](size_t k) {
        Square sum = kPartOf[k + 1] * X + kPartOf[k + 2] * X2 + kPartOf[k + 3] * X3;
        sum.diagonal().array() += kPartOf[k];
        return sum;
    };
    Square E = four(12);
    for (const size_t k : {size_t{8}, size_t{4}, size_t{0}}) E = (four(k) + X4 * E).eval();
    for (int k = 0; k < squarings; ++k) E = (E * E).eval();
    return E;
}

/// Of blocks of one to six directions, those of one and two by their cofactors.
template <class Block>
Block inverse_of_block(const Block& block) {
    using Scalar = typename Block::Scalar;
    Block inverse(block.rows(), block.cols());
    if (block.rows() == 1)
        inverse(0, 0) = Scalar(1) / block(0, 0);
    else if (block.rows() == 2)
        inverse = Eigen::Matrix<Scalar, 2, 2>(block).inverse();
    else
        inverse = block.fullPivLu().inverse();
    return inverse;
}

/// The same of blocks of one, two, .. six directions, each worked out at its own size.
template <class Scalar, int kSize>
void exponential_in(const LineWaves::Block<Scalar>& X, const LineWaves::Block<Scalar>& Y, bool with_derivative,
                    LineWaves::Block<Scalar>& E, LineWaves::Block<Scalar>& D) {
    if (!with_derivative) {
        E = exponential_alone<Eigen::Matrix<Scalar, kSize, kSize>>(X);
        return;
    }
    Eigen::Matrix<Scalar, kSize, kSize> exponential, derivative;
    exponential_of<Eigen::Matrix<Scalar, kSize, kSize>>(X, Y, exponential, derivative);
    E = exponential;
    D = derivative;
}
template <class Scalar>
void exponential(const LineWaves::Block<Scalar>& X, const LineWaves::Block<Scalar>& Y, bool with_derivative,
                 LineWaves::Block<Scalar>& E, LineWaves::Block<Scalar>& D) {
    switch (X.rows()) {
        case 2:
            return exponential_in<Scalar, 2>(X, Y, with_derivative, E, D);
        case 4:
            return exponential_in<Scalar, 4>(X, Y, with_derivative, E, D);
        case 6:
            return exponential_in<Scalar, 6>(X, Y, with_derivative, E, D);
        case 8:
            return exponential_in<Scalar, 8>(X, Y, with_derivative, E, D);
        case 10:
            return exponential_in<Scalar, 10>(X, Y, with_derivative, E, D);
        default:
            exponential_in<Scalar, 12>(X, Y, with_derivative, E, D);
    }
}

}  // namespace

LineWaves::LineWaves(const Line& line, double length, Directions active, Axial axial) : length_(length), axial_(axial) {
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
    group_directions(s, moving, mass_per_length(s), C);
}

/// Directions that the equations of the line couple, in groups: each is solved by itself.
void LineWaves::group_directions(const Section& s, Directions moving, const Matrix6& M, const Vector6& C) {
    Matrix6 A = Matrix6::Zero(), A_by_N = A, G_by_N = A, G_by_N2 = A;
    A(1, 5) = 1;
    A(2, 4) = -1;
    for (const auto& [deflection, rotation] : kPlanes) {
        const auto d = as_row(deflection), r = as_row(rotation);
        const double shear = moving[deflection] ? C(d) : 0;
        A_by_N(d, r) = -shear * A(d, r);
        G_by_N(r, r) = 1;
        G_by_N2(r, r) = -shear;
    }
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
                if (moving[d] && group_of[d] < 0 && (bend || M(other, own) != 0)) add(d);
            }
        group.A = A(group.directions, group.directions);
        group.M = M(group.directions, group.directions);
        group.A_by_N = A_by_N(group.directions, group.directions);
        group.G_by_N = G_by_N(group.directions, group.directions);
        group.G_by_N2 = G_by_N2(group.directions, group.directions);
        group.C = C(group.directions);
        const auto n = as_row(group.directions.size());
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
           one.M(0, 1) == 0 && one.M(1, 0) == 0 && one.A == -other.A;
}

/// U of a group over s in its units, where a deflection counts in lengths of s and forces as what bends, or shears, by a
/// radian on s.
template <class Scalar>
LineWaves::Waves<Scalar> LineWaves::waves(const Group& group, double start, double s, Scalar lambda, Scalar stiffening,
                                          bool with_derivative) const {
    const auto n = as_row(group.directions.size());
    Waves<Scalar> waves;
    waves.unit_d = group.unit_d;
    waves.unit_n = group.unit_n;
    for (Eigen::Index k = 0; k < n; ++k) {
        const int d = group.directions[as_size(k)];
        if (d < 3) waves.unit_d(k) = s;
        if (d >= 3) waves.unit_n(k) /= s;
        if (d == 1 || d == 2) waves.unit_n(k) = 1 / (s * s / group.unit_n(k) + group.C(k));
    }
    const auto &ud = waves.unit_d, &un = waves.unit_n;
    const auto of_d = [&](const Block<double>& by_d) {
        return Matrix(s * (ud.cwiseInverse().asDiagonal() * by_d * ud.asDiagonal()));
    };
    const auto of_n = [&](const Block<double>& by_d) {
        return Matrix(s * (un.cwiseInverse().asDiagonal() * by_d * ud.asDiagonal()));
    };
    const bool has_axial = (axial_[0] != 0 || axial_[1] != 0) && !group.G_by_N.isZero(0);
    // Of n: −Aᵀ
    const Column between = un.cwiseProduct(ud), back = between.cwiseInverse();
    const auto minus_At = [&](const Matrix& A) {
        return Matrix(back.asDiagonal() * (-A.transpose()) * between.asDiagonal());
    };
    const double middle = axial_at(start + 0.5 * s);
    Matrix A = of_d(group.A), A_by_N, G_by_N, G_by_N2;
    if (has_axial) {
        A_by_N = of_d(group.A_by_N);
        G_by_N = of_n(group.G_by_N);
        G_by_N2 = of_n(group.G_by_N2);
        A += middle * A_by_N;
    }
    const Matrix C = s * (ud.cwiseInverse().cwiseProduct(group.C).cwiseProduct(un)).asDiagonal().toDenseMatrix();
    const Matrix M = s * (un.cwiseInverse().asDiagonal() * group.M * ud.asDiagonal());
    Block<Scalar> S = Block<Scalar>::Zero(2 * n, 2 * n), by_lambda = S;
    S.topLeftCorner(n, n) = A.template cast<Scalar>();
    S.topRightCorner(n, n) = C.template cast<Scalar>() / stiffening;
    S.bottomLeftCorner(n, n) = -lambda * M.template cast<Scalar>();
    if (has_axial) S.bottomLeftCorner(n, n) += Matrix(middle * G_by_N + middle * middle * G_by_N2).template cast<Scalar>();
    S.bottomRightCorner(n, n) = minus_At(A).template cast<Scalar>();
    by_lambda.bottomLeftCorner(n, n) = -M.template cast<Scalar>();
    if (has_axial && is_graded()) {
        const double rise = axial_at(start + s) - axial_at(start);
        // Of G, a parabola, the mean
        S.bottomLeftCorner(n, n) += Matrix(rise * rise / 12 * G_by_N2).template cast<Scalar>();
        const Matrix A_rise = rise * A_by_N;
        Block<Scalar> change = Block<Scalar>::Zero(2 * n, 2 * n);
        change.topLeftCorner(n, n) = A_rise.template cast<Scalar>();
        change.bottomLeftCorner(n, n) = Matrix(rise * G_by_N + 2 * middle * rise * G_by_N2).template cast<Scalar>();
        change.bottomRightCorner(n, n) = minus_At(A_rise).template cast<Scalar>();
        S += (change * S - S * change).eval() / 12.0;
        if (with_derivative) by_lambda += (change * by_lambda - by_lambda * change).eval() / 12.0;
    }
    exponential(S, by_lambda, with_derivative, waves.U, waves.by_lambda);
    return waves;
}

/// The longest piece, by a lower bound, that does not vibrate with its ends held at any ω² below λ. In a bending plane let
/// a = 1 − N/GA and γ = v' − a θ. Over a length l at whose ends v and θ vanish, Wirtinger's inequalities are
///     ∫θ² ≤ (l/π)² ∫θ'²,   ∫v² ≤ (l/π)² ∫v'²,   ∫v'² ≤ (1 + 1/e) ∫γ² + (1 + e) a² (l/2π)² ∫θ'²  for every e > 0;
/// the last holds because the mean of v' is zero. With the best e, and x = l²/π², λ ∫(µ v² + J θ²) + |N a| ∫θ² is at most
/// ∫(EI θ'² + GA γ²) if
///     λ µ a² x²/4 + (λ J + |N a| + EI λ µ/GA) x ≤ EI.
/// The axial force adds −N a ∫θ² to the left, at most |N a| ∫θ². With that in tension too, exponentials do not overflow. A
/// mass that couples directions counts in each by Σ_j |M_ij| √(M_ii/M_jj).
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
        if (direction == 0 || direction == 3) {
            least = std::min(least, 1 / (inertia(k) * group.C(k)));
            continue;
        }
        const auto rotation = std::ranges::find(group.directions, direction == 1 ? 5 : 4) - group.directions.begin();
        const double strongest = std::max(std::abs(axial_[0]), std::abs(axial_[1]));
        const double a = std::max(std::abs(group.A_at(axial_[0])(k, rotation)),
                                  std::abs(group.A_at(axial_[1])(k, rotation))),
                     bending = 1 / group.C(rotation), mass = inertia(k);
        const double linear = inertia(rotation) + strongest * a + bending * mass * group.C(k);
        least = std::min(least, 2 * bending / (linear + std::sqrt(linear * linear + mass * a * a * bending)));
    }
    return M_PI * std::sqrt(least);
}

double LineWaves::longest_held(double lambda) const {
    double longest = std::numeric_limits<double>::infinity();
    for (const Group& group : groups_) longest = std::min(longest, longest_held(group, lambda));
    return longest;
}

int LineWaves::pieces(double omega, int most) const {
    // Share of λ: at the frequency of a held bar its stiffness is infinite, with 2 it is -1.7 times that at rest. With 1.05
    // to 4, 59 random machines, the hydroplane and the headstock have the same frequencies to 3e-10, in the same time.
    constexpr double kMargin = 2;
    // An axial force that varies by v EI/length² leaves at most 0.0055 v/count⁴ of a frequency: cantilevers and bars between
    // pins, v = 0.1 to 900, in 1 to 16 pieces.
    // That is kept below 1e-6, and below 5e-8 where few pieces do it: many short ones show the rounding of stiff lines.
    constexpr double kGraded = 0.0055 / 1e-6, kFinely = 0.0055 / 5e-8, kFew = 20;
    double count = std::max(1.0, std::ceil(length_ / longest_held(kMargin * omega * omega)));
    for (const Group& group : groups_) {
        for (size_t k = 0; k < group.directions.size(); ++k)
            if (group.directions[k] > 3) {
                const double varies = std::abs(axial_[1] - axial_[0]) * length_ * length_ * group.C(as_row(k));
                count = std::max({count, std::ceil(std::pow(kGraded * varies, 0.25)),
                                  std::min(kFew, std::ceil(std::pow(kFinely * varies, 0.25)))});
            }
    }
    return static_cast<int>(std::min(count, most + 1.0));
}

template <class Scalar>
void LineWaves::evaluate(int count, Scalar lambda, Scalar stiffening, Square<Scalar>& stiffness, Square<Scalar>* mass,
                         int index) const {
    stiffness.setZero();
    if (mass) mass->setZero();
    for (const Group& group : groups_) {
        const auto n = as_row(group.directions.size());
        if (group.mirror >= 0) {
            const std::vector<int>& other = groups_[as_size(group.mirror)].directions;
            const auto at = [](const std::vector<int>& directions, size_t k) { return directions[k % 2] + (k < 2 ? 0 : 6); };
            for (size_t i = 0; i < 4; ++i)
                for (size_t j = 0; j < 4; ++j)
                    for (Square<Scalar>* into : {&stiffness, mass})
                        if (into)
                            (*into)(at(group.directions, i), at(group.directions, j)) =
                                ((i + j) % 2 == 0 ? 1.0 : -1.0) * (*into)(at(other, i), at(other, j));
            continue;
        }
        const Waves<Scalar> w =
            waves<Scalar>(group, index * length_ / count, length_ / count, lambda, stiffening, mass != nullptr);
        const Block<Scalar> Udd = w.U.topLeftCorner(n, n), Unn = w.U.bottomRightCorner(n, n);
        const Block<Scalar> W = inverse_of_block<Block<Scalar>>(w.U.topRightCorner(n, n));
        // n0 = W (d1 − Udd d0),  n1 = Und d0 + Unn n0; on the piece act −n0 and n1
        Eigen::Matrix<int, Eigen::Dynamic, 1, 0, 12, 1> at(2 * n);
        for (Eigen::Index k = 0; k < n; ++k) {
            at(k) = group.directions[as_size(k)];
            at(n + k) = 6 + at(k);
        }
        const auto store = [&](const Block<Scalar>& start, const Block<Scalar>& across, const Block<Scalar>& end,
                               double sign, Square<Scalar>& into) {
            Block<Scalar> all(2 * n, 2 * n);
            all << start, across, across.transpose(), end;
            const Column un = w.unit_n.replicate(2, 1), ud = w.unit_d.replicate(2, 1).cwiseInverse();
            // In units: the upper right block is taken, its transpose would have the units of the other side
            Block<Scalar> scaled = un.asDiagonal() * all * ud.asDiagonal();
            scaled.bottomLeftCorner(n, n) = scaled.topRightCorner(n, n).transpose();
            scaled = (0.5 * sign * (scaled + scaled.transpose())).eval();
            for (Eigen::Index i = 0; i < 2 * n; ++i)
                for (Eigen::Index j = 0; j < 2 * n; ++j) into(at(i), at(j)) = scaled(i, j);
        };
        store(W * Udd, -W, Unn * W, 1, stiffness);
        if (!mass) continue;
        const Block<Scalar> dUdd = w.by_lambda.topLeftCorner(n, n), dUnn = w.by_lambda.bottomRightCorner(n, n);
        const Block<Scalar> dW = -W * w.by_lambda.topRightCorner(n, n) * W;
        store(dW * Udd + W * dUdd, -dW, dUnn * W + Unn * dW, -1, *mass);
    }
}

Matrix12 LineWaves::transfer(double lambda, double s, double start) const {
    Matrix12 U = Matrix12::Identity();
    if (!(s > 0)) return U;
    for (const Group& group : groups_) {
        const auto n = as_row(group.directions.size());
        const Waves<double> w = waves<double>(group, start, s, lambda, 1, false);
        Column unit(2 * n);
        unit << w.unit_d, w.unit_n;
        const Matrix own = unit.asDiagonal() * w.U * unit.cwiseInverse().asDiagonal();
        for (Eigen::Index i = 0; i < 2 * n; ++i)
            for (Eigen::Index j = 0; j < 2 * n; ++j) {
                const auto at = [&](Eigen::Index k) { return group.directions[as_size(k % n)] + (k < n ? 0 : 6); };
                U(at(i), at(j)) = own(i, j);
            }
    }
    return U;
}

LineShapes LineWaves::static_shapes() const {
    Matrix12 K, start;  // [d; n] at the start by the ends
    evaluate<double>(1, 0, 1, K, nullptr);
    start << Matrix6::Identity(), Matrix6::Zero(), -K.topRows<6>();
    LineShapes shapes;
    for (size_t k = 0; k < shapes.at.size(); ++k) {
        const Matrix12 state = transfer(0, LineShapes::kPoints[k] * length_) * start;
        LineShapes::Shape& shape = shapes.at[k] = {state.topRows<6>(), Eigen::Matrix<double, 6, 12>::Zero()};
        for (const Group& group : groups_)
            shape.slope(group.directions, Eigen::all) =
                group.A_at(axial_at(LineShapes::kPoints[k] * length_)) * state(group.directions, Eigen::all) +
                group.C.asDiagonal() * state.bottomRows<6>()(group.directions, Eigen::all);
    }
    return shapes;
}

template void LineWaves::evaluate(int, double, double, Square<double>&, Square<double>*, int) const;
template void LineWaves::evaluate(int, std::complex<double>, std::complex<double>, Square<std::complex<double>>&,
                                  Square<std::complex<double>>*, int) const;

}  // namespace dttmm::plugin
