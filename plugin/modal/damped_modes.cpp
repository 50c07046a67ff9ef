// SPDX-License-Identifier: BSD-3-Clause
#include "modal/damped_modes.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "core/error.h"
#include "core/index.h"
#include "modal/balanced_lu.h"

namespace dttmm::plugin {

namespace {

/// How far, as share of s, a candidate may be from its mode: three times what was measured, see kFiner. Newton's method that
/// leads farther has left it, and candidates so far beyond the bound are improved too.
constexpr double kAway = 0.05;
/// Largest correction of a mode that counts as found, as share of s. Measured on the examples: 3e-13 at most.
constexpr double kSolved = 1e-8;
/// Share of s: nearer modes are distinguished by their shapes. Rounding parts double ones by 1e-12.
constexpr double kSameRate = 1e-6;
/// Share of the bound: what is slower is a rigid-body mode. Of a double eigenvalue 0 rounding leaves its root, 1e-8.
constexpr double kSlowest = 1e-6;
/// µ in units of 1/shift: what is smaller has no mass, and s no bound.
constexpr double kNoMass = 1e-12;

}  // namespace

bool DampedModes::has_loss_factor() const {
    const FrequencyModel& model = D_.model();
    return std::ranges::any_of(model.bonds, [](const Bond& bond) { return bond.loss_factor > 0; }) ||
           std::ranges::any_of(model.lines, [](const LineModel& line) { return line.line.section.loss_factor > 0; });
}

DampedModes::DampedModes(const DynamicStiffness& D, HarmonicSolver& solver, double below) : D_(D), solver_(solver) {
    if (has_loss_factor())
        find_all<Complex>(below);
    else
        find_all<double>(below);
}

/// Columns that span the motions which no rigid direction forbids: of the real matrix at s = 0, rows of rigid directions
/// last.
DampedModes::Matrix DampedModes::free_directions(const Matrix& K) const {
    constexpr double kDependent = 1e-9;  // as of the directions of one joint: redundant ones leave rounding, 1e-15
    const Eigen::Index n = 6 * D_.frame_count(), rigid = solver_.rigid_rows();
    std::vector<Eigen::Index> moving;  // directions that the model leaves
    for (Eigen::Index i = 0; i < n; ++i)
        if (D_.model().mask(i % 6, i % 6) != 0) moving.push_back(i);
    Matrix select = Matrix::Zero(n, as_row(moving.size()));
    for (size_t k = 0; k < moving.size(); ++k) select(moving[k], as_row(k)) = 1;
    if (rigid == 0) return select;
    const Matrix J = K.block(n, 0, rigid, n) * select;
    Eigen::ColPivHouseholderQR<Matrix> qr(J.transpose());
    qr.setThreshold(kDependent);
    const Matrix Q = qr.householderQ();
    return select * Q.rightCols(Q.cols() - qr.rank());
}

/// Whether it is near −1/η of a line. A line whose damping is η times its stiffness has infinitely many modes without
/// vibration that pile up there.
bool DampedModes::piles_up(Complex s) const {
    constexpr double kNear = 0.02;
    return std::ranges::any_of(D_.model().lines, [&](const LineModel& line) {
        return line.line.section.stiffness_damping > 0 && std::abs(1.0 + line.line.section.stiffness_damping * s) < kNear;
    });
}

/// zᴴ C z of the terms of Maxwell series.
double DampedModes::lost_inside(const Eigen::VectorXcd& z) const {
    double sum = 0;
    Eigen::Index row = 0;
    for (const Bond& bond : D_.model().bonds)
        for (const Bond::Material& material : bond.materials)
            for (const auto& [stiffness, time] : material.law->series().terms) sum += stiffness * time * std::norm(z(row++));
    return sum;
}

namespace {

/// Of s² M + s C + K, whose value at `shift` is A: s = shift + 1/µ and µ² A + µ (C + 2 shift M) + M = 0. Its eigenvalues are
/// µ in units of 1/shift. Where there is no mass µ is 0, and s without bound.
template <class Dense>
Dense companion_of(const Dense& A, const Dense& C, const Dense& M, double shift) {
    const Eigen::PartialPivLU<Dense> lu(A);
    const Eigen::Index n = A.rows();
    Dense companion = Dense::Zero(2 * n, 2 * n);
    companion.topLeftCorner(n, n) = -shift * lu.solve(C + 2 * shift * M);
    companion.topRightCorner(n, n) = -shift * shift * lu.solve(M);
    companion.bottomLeftCorner(n, n).setIdentity();
    return companion;
}

}  // namespace

/// Complex numbers are there for stiffness with a loss factor: it counts for what turns as e^(iωt) with ω > 0.
template <class Scalar>
void DampedModes::find_all(double below) {
    using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
    constexpr bool kIsReal = std::is_same_v<Scalar, double>;
    using Solver = std::conditional_t<kIsReal, Eigen::EigenSolver<Matrix>, Eigen::ComplexEigenSolver<Eigen::MatrixXcd>>;
    const Matrix of_modes = solver_.modal_damping();
    const Eigen::Index n_frames = of_modes.rows(), terms = solver_.series_rows();
    const auto at = [&](double s) -> Dense {
        const Eigen::SparseMatrix<Complex> whole = solver_.assemble({s, 0}, HarmonicSolver::Form::polynomial);
        Dense dense;
        if constexpr (kIsReal)
            dense = whole.real();
        else
            dense = whole;
        dense.topLeftCorner(n_frames, n_frames) += s * of_modes.template cast<Scalar>();
        return dense;
    };
    // Quadratic in s, so three values have it. Beyond a shift on the positive axis the matrix is positive definite
    const double shift = below;
    const Dense at_zero = at(0), above = at(shift), under = at(-shift);
    const Matrix Z = free_directions(at_zero.real());
    if (Z.cols() + terms > kMostUnknowns)
        throw Error(DTTMM_ERROR_MODEL,
                    fmt::format("damped modes of {} unknowns: at most {} are taken; ask for a lower highest frequency, "
                                "which parts beams into fewer pieces, or look at `dttmm response`",
                                Z.cols() + terms, kMostUnknowns));
    // The motions that are free, then the terms of Maxwell series
    Dense own = Dense::Zero(at_zero.rows(), Z.cols() + terms);
    own.topLeftCorner(Z.rows(), Z.cols()) = Z.template cast<Scalar>();
    own.bottomRightCorner(terms, terms).setIdentity();
    const auto reduced = [&](const Dense& whole) -> Dense { return own.transpose() * whole * own; };
    const Dense K = reduced(at_zero), A = reduced(above), B = reduced(under);
    const Dense M = ((A + B) / 2 - K) / (shift * shift), C = (A - B) / (2 * shift);
    const Eigen::Index n = K.rows();
    const Solver found(companion_of<Dense>(A, C, M, shift));
    if (found.info() != Eigen::Success)
        throw Error(DTTMM_ERROR_NUMERIC, "the damped modes are not found: the eigenvalues do not converge");
    const Eigen::MatrixXcd vectors = found.eigenvectors();
    for (Eigen::Index k = 0; k < 2 * n; ++k) {
        const Complex mu = found.eigenvalues()(k) / shift;
        if (std::abs(mu) * shift < kNoMass) continue;
        const Complex s = shift + 1.0 / mu;
        if (std::abs(s) > (1 + kAway) * below || s.imag() < 0) continue;
        // What a motion without vibration loses, and of it in materials
        const Eigen::VectorXcd y = vectors.col(k).head(n);
        const bool relaxes =
            std::abs(s.imag()) < kSameRate * std::abs(s) && 2 * lost_inside(y.tail(terms)) > std::abs(y.dot(C * y));
        if (piles_up(s) || relaxes)
            has_left_out_ = true;
        else
            take(std::abs(s) < kSlowest * below ? 0 : s, Z.cast<Complex>() * y.head(Z.cols()));
    }
    is_proved_ = std::ranges::all_of(modes_, [](const DampedMode& mode) { return mode.correction < kSolved; });
    std::erase_if(modes_, [&](const DampedMode& mode) { return std::abs(mode.s) > below; });
    std::ranges::sort(modes_, {}, [](const DampedMode& mode) { return std::pair(std::abs(mode.s), mode.s.imag()); });
}

void DampedModes::take(Complex s, Eigen::VectorXcd x) {
    if (s == 0.0 && !is_new_rigid(x)) return;
    DampedMode mode{s, 0, {}};
    improve(mode, x);
    modes_.push_back(std::move(mode));
}

/// Whether a motion with s = 0 is another than those found; takes these out of it. A free direction without damping has the
/// eigenvalue 0 twice, to be somewhere and to move on, with one shape.
bool DampedModes::is_new_rigid(Eigen::VectorXcd& x) const {
    constexpr double kOther = 1e-3;  // of its length; rounding of a double eigenvalue leaves 1e-8
    x.normalize();
    for (size_t m = 0; m < modes_.size(); ++m) {
        if (modes_[m].s != 0.0) continue;
        const Eigen::VectorXcd known = found_[m].first.head(x.size()).normalized();
        x -= known.dot(x) * known;
    }
    return x.norm() > kOther;
}

/// Takes out of x what belongs to modes found before with nearly this s: for two modes x₁ᵀ A' x₂ is zero.
void DampedModes::deflate(Complex s, Eigen::VectorXcd& x) const {
    for (size_t m = 0; m < modes_.size(); ++m) {
        if (std::abs(modes_[m].s - s) > kSameRate * std::abs(s)) continue;
        const auto& [whole, slope] = found_[m];
        const Complex own = (slope.transpose() * whole)(0), other = (slope.transpose() * x)(0);
        x -= other / own * whole;
    }
}

/// Newton's method with both vectors alike, as the matrix is symmetric: y = A⁻¹ A' x, s − xᵀ x / xᵀ y.
void DampedModes::improve(DampedMode& mode, Eigen::VectorXcd& x) {
    constexpr int kMostPasses = 12;
    constexpr auto kExact = HarmonicSolver::Form::exact;
    const Eigen::Index n = x.size();
    const Complex start = mode.s;
    Eigen::VectorXcd whole = Eigen::VectorXcd::Zero(solver_.assemble(start, kExact).rows());
    whole.head(n) = x;
    Eigen::VectorXcd best = whole, best_slope = whole;
    if (start != 0.0) mode.correction = std::numeric_limits<double>::infinity();
    Complex s = start;
    BalancedLu lu;
    for (int pass = 0; pass < kMostPasses && start != 0.0; ++pass) {
        const double step = 1e-5 * std::abs(s);
        const Eigen::SparseMatrix<Complex> A = solver_.assemble(s, kExact);
        const Eigen::SparseMatrix<Complex> slope =
            (solver_.assemble(s + step, kExact) - solver_.assemble(s - step, kExact)) / (2 * step);
        if (!lu.factor(A)) break;
        deflate(s, whole);
        const Eigen::VectorXcd y = lu.solve(slope * whole);
        const Complex below = (whole.transpose() * y)(0), own = (whole.transpose() * whole)(0);
        if (!y.allFinite() || std::abs(below) == 0) break;
        const Complex correction = -own / below;
        if (!(std::abs(correction) < mode.correction * std::abs(s))) break;  // rounding, or it goes away
        mode.correction = std::abs(correction) / std::abs(s);
        mode.s = s;
        best = whole;
        best_slope = slope * whole;
        s += correction;
        whole = y / y.norm();
        if (std::abs(s - start) > kAway * std::abs(start)) break;
    }
    if (mode.s.imag() == 0) mode.s.imag(0);  // no negative zero
    // A vibration that does not decay has a real part of rounding only
    if (std::abs(mode.s.real()) < 1e-13 * std::abs(mode.s)) mode.s.real(0);
    Complex largest = 0;
    for (const Eigen::Index half : {0, 3}) {
        for (Eigen::Index i = 0; i < n; ++i)
            if ((i % 6 < 3) == (half == 0) && std::abs(best(i)) > std::abs(largest)) largest = best(i);
        if (std::abs(largest) > 1e-9 * best.head(n).norm()) break;
    }
    found_.emplace_back(best, best_slope);
    for (Eigen::Index f = 0; f < n / 6; ++f) mode.motion.emplace_back(best.segment<6>(6 * f) / largest);
}

}  // namespace dttmm::plugin
