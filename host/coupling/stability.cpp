// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/stability.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/inertia.h"
#include "world/joint_system.h"

namespace dttmm::host {

namespace {

constexpr int kMostIterations = 500;
constexpr double kChange = 1e-7;     // of the eigenvalue in one iteration
constexpr size_t kMostElements = 3;  // that a message names
constexpr double kSmallestShare = 0.01;

using Matrix = Eigen::SparseMatrix<double>;

/// M of all bodies, block by block in the matrices' order, M = L Lᵀ; and the joints that they hang on.
class ConstrainedInertia {
public:
    ConstrainedInertia(const Model& model, const JointSystem& joints, BlockMatrix matrix, const std::vector<BodyState>& at)
        : factor_(matrix) {
        matrix.set_zero();
        for (size_t b = 0; b < model.bodies.size(); ++b) {
            const int body = as_int(b);
            const BlockMatrix::Block M = Inertia(model.bodies[b]).block(at[b].rotation);
            parts_.push_back({matrix.index(body), M, M.llt()});
            matrix.add(body, body, M);
        }
        joints.write_to(matrix);
        factor_.factor(matrix);
        for (size_t j = 0; j < joints.joints().size(); ++j)
            multipliers_.push_back({matrix.joint_index(as_int(j)), joints.joints()[j].count()});
    }
    /// y ← the motion u that the joints allow with M u + Jᵀ q = y; without joints M⁻¹ y
    void divide(Eigen::VectorXd& y) const {
        const Eigen::VectorXd momentum = y;
        factor_.solve(momentum, y);
        for (const auto& [start, count] : multipliers_) y.segment(start, count).setZero();
    }
    /// z ← L z
    void multiply_by_root(Eigen::VectorXd& z) const {
        for (const Part& part : parts_) z.segment<6>(part.index) = (part.root.matrixL() * z.segment<6>(part.index)).eval();
        for (const auto& [start, count] : multipliers_) z.segment(start, count).setZero();
    }
    /// uᵀ M u of one body
    double energy(size_t body, const Eigen::VectorXd& u) const {
        const auto part = u.segment<6>(parts_[body].index);
        return part.dot(parts_[body].M * part);
    }

private:
    struct Part {
        int index;
        BlockMatrix::Block M;
        Eigen::LLT<BlockMatrix::Block> root;
    };
    std::vector<Part> parts_;
    std::vector<std::pair<int, int>> multipliers_;  ///< rows of the joints: start and count
    BlockFactor factor_;
};

/// An eigenvalue of M⁻¹ A and its vector.
struct Eigenpair {
    double value = 0;
    Eigen::VectorXd u;
};

/// The linear machine: M, K and C of the bodies on their networks and joints at one instant.
class Linearisation {
public:
    Linearisation(const Model& model, Networks& networks, const std::vector<BodyState>& at)
        : model_(model),
          networks_(networks),
          at_(at),
          joints_(linearised(model, at)),
          K_(as_int(model.bodies.size()), networks.neighbours(), joints_.nodes()),
          C_(K_),
          M_(model, joints_, K_, at) {
        hand_out([&](int row, int column, const BlockMatrix::Block& K, const BlockMatrix::Block& C) {
            K_.add(row, column, K);
            C_.add(row, column, C);
        });
    }

    /// Largest eigenvalue of M⁻¹ (a K + b C) and its vector.
    Eigenpair find_largest(double a, double b) const {
        Matrix A = K_.upper();
        A.coeffs() = a * K_.upper().coeffs() + b * C_.upper().coeffs();

        // u ← M⁻¹ A u; uᵀ A M⁻¹ A u / uᵀ A u bounds λ from below and converges twice as fast as u. In the start L⁻ᵀ z with z
        // without symmetry (brought to what the joints allow), light and heavy bodies move alike by kinetic energy, so that
        // none is overheard.
        const Eigen::Index n = A.rows();
        Eigenpair pair{0, Eigen::VectorXd(n)};
        Eigen::VectorXd& u = pair.u;
        Eigen::VectorXd Au(n);
        for (Eigen::Index i = 0; i < n; ++i) u(i) = std::cos(1.0 + 0.7 * static_cast<double>(i) * static_cast<double>(i));
        M_.multiply_by_root(u);
        M_.divide(u);
        for (int iteration = 0; iteration < kMostIterations; ++iteration) {
            Au = A.selfadjointView<Eigen::Upper>() * u;
            const double energy = u.dot(Au);
            if (!(energy > 0)) break;
            u = Au;
            M_.divide(u);
            const double next = u.dot(Au) / energy;
            u /= u.cwiseAbs().maxCoeff();
            const bool converged = std::abs(next - pair.value) <= kChange * next;
            pair.value = next;
            if (converged) break;
        }
        return pair;
    }

    /// uᵀ K u / uᵀ M u and uᵀ C u / uᵀ M u
    std::pair<double, double> quotients(const Eigen::VectorXd& u) const {
        double inertia = 0;
        for (size_t b = 0; b < model_.bodies.size(); ++b) inertia += M_.energy(b, u);
        return {u.dot(K_.upper().selfadjointView<Eigen::Upper>() * u) / inertia,
                u.dot(C_.upper().selfadjointView<Eigen::Upper>() * u) / inertia};
    }

    /// Who makes the motion u, the elements' shares by uᵀ (a K + b C) u.
    FastestMode describe_motion(const Eigen::VectorXd& u, double a, double b) const {
        FastestMode mode;
        mode.omega = std::sqrt(quotients(u).first);
        double most = -1;
        for (size_t body = 0; body < model_.bodies.size(); ++body) {
            const double energy = M_.energy(body, u);
            if (energy <= most) continue;
            most = energy;
            mode.body = model_.bodies[body].name;
        }

        std::vector<double> motion(6 * model_.bodies.size());
        for (size_t body = 0; body < model_.bodies.size(); ++body)
            std::copy_n(u.data() + K_.index(as_int(body)), 6, &motion[6 * body]);
        double total = 0;
        const std::vector<Networks::TakenUp> all = networks_.take_up(at_, motion.data());
        mode.elements.reserve(all.size());
        for (const Networks::TakenUp& taken : all) {
            mode.elements.push_back({taken.element, a * taken.elastic + b * taken.damped});
            total += mode.elements.back().share;
        }
        for (ElementShare& element : mode.elements) element.share /= total;
        // What only rounding tells apart stays in the order of the model
        std::stable_sort(mode.elements.begin(), mode.elements.end(), [](const ElementShare& x, const ElementShare& y) {
            return std::round(1000 * x.share) > std::round(1000 * y.share);
        });
        return mode;
    }

private:
    static JointSystem linearised(const Model& model, const std::vector<BodyState>& at) {
        JointSystem joints(model.bodies, model.joints);
        joints.linearise(at, at, std::vector<Stop>(model.joints.size()));
        return joints;
    }
    void hand_out(const Networks::LinearSink& sink) const {
        std::vector<double> wrenches(6 * model_.bodies.size());
        networks_.linearise(at_, wrenches.data(), &sink);
    }

    const Model& model_;
    Networks& networks_;
    const std::vector<BodyState>& at_;
    JointSystem joints_;
    BlockMatrix K_, C_;
    ConstrainedInertia M_;
};

}  // namespace

std::string describe(const FastestMode& mode) {
    std::string made_by;
    size_t named = 0, others = 0;
    for (const ElementShare& element : mode.elements) {
        if (named > 0 && element.share < kSmallestShare) break;  // the largest of many small shares is named too
        if (named == kMostElements) {
            ++others;
            continue;
        }
        ++named;
        made_by += fmt::format("{}{} ({} %)", made_by.empty() ? ", made by " : ", ", element.element,
                               element.share >= kSmallestShare ? fmt::format("{:.0f}", 100 * element.share)
                                                               : fmt::format("{:.1g}", 100 * element.share));
    }
    if (others > 0) made_by += fmt::format(" and {} more", others);
    return fmt::format("{:.5g} Hz at body \"{}\"{}", mode.omega / (2 * M_PI), mode.body, made_by);
}

FastestMode find_fastest_mode(const Model& model, Networks& networks, const std::vector<BodyState>& at) {
    const Linearisation machine(model, networks, at);
    const Eigenpair fastest = machine.find_largest(1, 0);
    if (!(fastest.value > 0)) return {};
    FastestMode mode = machine.describe_motion(fastest.u, 1, 0);
    mode.omega = std::sqrt(fastest.value);
    return mode;
}

double alternating_weight(ExplicitScheme scheme) {
    switch (scheme) {
        case ExplicitScheme::bdf1:  // (1, −1)/h
            return 2;
        case ExplicitScheme::park:  // (10, −15, 6, −1)/6h
            return 16.0 / 3;
        case ExplicitScheme::houbolt:  // (11, −18, 9, −2)/6h
            return 20.0 / 3;
        default:  // (3, −4, 1)/2h
            return 4;
    }
}

ExplicitLimit find_explicit_limit(const Model& model, Networks& networks, const std::vector<BodyState>& at, double step,
                                  ExplicitScheme scheme) {
    const Linearisation machine(model, networks, at);
    const double W = alternating_weight(scheme);
    const Eigenpair present = machine.find_largest(step * step, W * step);
    ExplicitLimit limit;
    if (!(present.value > 0)) return limit;
    limit.load = std::sqrt(present.value);
    limit.damping_share = W * step * machine.quotients(present.u).second / present.value;
    limit.mode = machine.describe_motion(present.u, step * step, W * step);

    // λ(h) = 4: with the quotients k, c of the vector at one h, h² k + W h c = 4 gives the next, never too short, for λ is
    // the largest of all such quotients
    Eigen::VectorXd u = present.u;
    for (int iteration = 0; iteration < 20; ++iteration) {
        const auto [k, c] = machine.quotients(u);
        const double next = 8 / (W * c + std::sqrt(W * W * c * c + 16 * k));
        const bool converged = std::abs(next - limit.longest_step) <= 1e-6 * next;
        limit.longest_step = next;
        if (converged) break;
        u = machine.find_largest(next * next, W * next).u;
    }
    return limit;
}

}  // namespace dttmm::host
