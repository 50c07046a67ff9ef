// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/rest_equations.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// s by the largest stiffness over mass: what vibrates 10⁶ times slower than the fastest counts as not held.
constexpr double kLeastResistance = 1e-12;
/// Where nothing is stiff [1/s²]. Smaller ones find the same; at 1e-7 Statics.SnappingThroughIsTold fails, and at 0
/// Statics.AChainOfRigidPartsInsideANetworkHangs.
constexpr double kSlowest = 1e-10;

/// The rotation vector of R with as many full turns as bring it nearest to another.
Eigen::Vector3d followed(const Eigen::Matrix3d& R, const Eigen::Vector3d& from) {
    constexpr double kNoAxis = 1e-6;  // below it rounding makes the axis [rad]
    const Eigen::AngleAxisd turn(R);
    const bool has_axis = turn.angle() > kNoAxis || from.norm() < M_PI;
    const Eigen::Vector3d axis = has_axis ? turn.axis() : from.normalized();
    const double angle = has_axis ? turn.angle() : 0;
    return (angle + 2 * M_PI * std::round((axis.dot(from) - angle) / (2 * M_PI))) * axis;
}

/// Half of every entry goes to the other side.
void make_symmetric(std::vector<Eigen::Triplet<double>>& entries) {
    const size_t count = entries.size();
    for (size_t i = 0; i < count; ++i) {
        const Eigen::Triplet<double> entry = entries[i];
        entries[i] = {entry.row(), entry.col(), 0.5 * entry.value()};
        entries.emplace_back(entry.col(), entry.row(), 0.5 * entry.value());
    }
}

}  // namespace

RestEquations::RestEquations(const Model& model, Networks& networks, Loads& loads)
    : model_(model),
      networks_(networks),
      loads_(loads),
      joints_(model),
      size_(model, joints_.equations()),
      wrenches_(6 * model.bodies.size()),
      change_(6 * model.bodies.size()) {
    for (Eigen::VectorXd* list : {&right_hand_side_, &solution_}) list->setZero(joints_.rows());
    start_.at = states_at_start(model);
    start_.turned.assign(start_.at.size(), Eigen::Vector3d::Zero());
    now_ = kept_ = start_;
}

void RestEquations::begin(double t0) {
    now_ = kept_ = start_;
    balance_ = {};
    stiffest_ = 0;
    least_resistance_ = kSlowest;
    loads_.start(t0);
    joints_.start(t0);
    networks_.begin_statics();
}

void RestEquations::keep() {
    networks_.keep_statics();
    kept_ = now_;
    joints_.keep();
}

void RestEquations::recall() {
    networks_.recall_statics();
    now_ = kept_;
    joints_.recall();
}

void RestEquations::set_load(double factor) {
    factor_ = factor;
    std::vector<double> loads;
    for (double load : loads_.on_networks()) loads.push_back(factor * load);
    networks_.set_static_loads(factor * model_.simulation.gravity, loads.data());
}

double RestEquations::largest_turn() const {
    double largest = balance_.turn;
    for (const Eigen::Vector3d& turn : now_.turned) largest = std::max(largest, turn.norm());
    return largest;
}

bool RestEquations::is_loaded() const {
    const std::vector<double> loads = loads_on(now_.at, 1);
    const auto on_networks = loads_.on_networks().first(6 * (model_.nodes.size() + model_.loads.size()));
    const auto acts = [](double number) { return number != 0; };
    return !model_.simulation.gravity.isZero(0) || std::ranges::any_of(loads, acts) ||
           std::ranges::any_of(on_networks, acts);
}

bool RestEquations::has_unsymmetric_loads() const {
    return std::ranges::any_of(model_.loads,
                               [](const Load& load) { return load.on.body >= 0 && (load.is_moment || load.turns); });
}

double RestEquations::heaviest() const {
    double mass = 0;
    for (const Inertia& inertia : size_.inertias) mass = std::max(mass, inertia.mass);
    return mass;
}

// ---- A correction -------------------------------------------------------------------------------------------------------

RestEquations::Correction RestEquations::correct(double resistance) {
    solve(resistance);
    const Networks::StaticMeasure inside = networks_.correct_static(change_.data());
    // Work below this share of the sum of its parts is rounding. Where joints contradict each other their forces grow, and
    // rounding is 1e-9 of the parts. Range 1e-9 (at 1e-10 Statics.AnchorsThatTheFileRounds...) to 1e-2; no test bounds it
    // there.
    constexpr double kWorkRounding = 1e-8;
    Correction all;
    all.work = inside.work;
    all.size = inside.shift;
    all.turn = inside.turn;
    all.bend = inside.bend;
    all.falling = inside.falling;
    if (!inside.element.empty()) all.mover = fmt::format("element \"{}\"", inside.element);
    const std::vector<double> loads = loads_on(now_.at, factor_);
    const auto add_work = [&](double work) {
        all.work += work;
        all.rounding += kWorkRounding * std::abs(work);
    };
    for (size_t i = 0; i < loads.size(); ++i) add_work(loads[i] * change_[i]);
    joints_.for_each_work(matrix_, solution_, right_hand_side_, add_work);
    for (size_t b = 0; b < model_.bodies.size(); ++b) {
        const Eigen::Map<const Vector6> u(&change_[6 * b]);
        const double turn = u.tail<3>().norm(), shift = std::max(u.head<3>().norm(), reach(b) * turn);
        all.turn = std::max(all.turn, turn);
        if (shift <= all.size) continue;
        all.size = shift;
        all.mover = fmt::format("body \"{}\"", model_.bodies[b].name);
    }
    return all;
}

/// Of the symmetric part. Of equations with joints the stiffness has a negative eigenvalue for each of their rows
/// (Haynsworth's inertia additivity).
bool RestEquations::is_stable() {
    form(least_resistance_);
    std::ranges::fill(change_, 0.0);
    if (networks_.correct_static(change_.data()).falling > 0) return false;
    if (joints_.rows() == 0) return true;
    const Eigen::SparseMatrix<double> transposed = matrix_.transpose(), symmetric = 0.5 * (matrix_ + transposed);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factors(symmetric);
    const Eigen::Index of_joints = joints_.rows() - as_row(change_.size());
    return factors.info() != Eigen::Success || (factors.vectorD().array() < 0).count() <= of_joints;
}

/// Solves the condensed equations formed where the machine is.
void RestEquations::solve(double resistance) {
    form(resistance);
    if (joints_.rows() == 0) return;
    if (!has_same_pattern()) {
        solver_.lu.analyzePattern(matrix_);
        solver_.pattern = matrix_;
    }
    solver_.lu.factorize(matrix_);
    if (solver_.lu.info() != Eigen::Success)
        throw Error(ExitCode::numerical_failure, "the equations of the equilibrium are singular");
    solution_ = solver_.lu.solve(right_hand_side_);
    for (size_t i = 0; i < change_.size(); ++i) change_[i] = solution_(as_row(i));
}

/// As the matrix that was analysed last.
bool RestEquations::has_same_pattern() const {
    const auto same = [&](const int* one, const int* other, Eigen::Index count) {
        return std::equal(one, one + count, other);
    };
    return matrix_.rows() == solver_.pattern.rows() && matrix_.nonZeros() == solver_.pattern.nonZeros() &&
           same(matrix_.outerIndexPtr(), solver_.pattern.outerIndexPtr(), matrix_.outerSize() + 1) &&
           same(matrix_.innerIndexPtr(), solver_.pattern.innerIndexPtr(), matrix_.nonZeros());
}

void RestEquations::form(double resistance) {
    Triplets entries;
    std::ranges::fill(wrenches_, 0.0);
    Eigen::VectorXd held = Eigen::VectorXd::Zero(joints_.rows());
    networks_.form_static(now_.at, resistance, wrenches_.data(), [&](int row, int column, const Networks::Block& K) {
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) entries.emplace_back(6 * row + i, 6 * column + j, K(i, j));
        if (row == column) held.segment<6>(6 * row) += K.diagonal().cwiseAbs();
    });
    if (stiffest_ == 0) set_least_resistance(held);
    resistance = std::max(resistance, least_resistance_);
    const std::vector<double> loads = loads_on(now_.at, factor_);
    for (size_t i = 0; i < loads.size(); ++i) wrenches_[i] += loads[i];
    add_load_stiffness(factor_, entries);
    add_turning_about(loads, entries);
    if (is_symmetric_) make_symmetric(entries);
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const BlockMatrix::Block M = size_.inertias[b].block(now_.at[b].rotation);
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                entries.emplace_back(6 * as_int(b) + i, 6 * as_int(b) + j,
                                     resistance * (M(i, j) + (i == j && i >= 3 ? turning_mass(b) : 0)));
    }
    for (size_t i = 0; i < wrenches_.size(); ++i) right_hand_side_(as_row(i)) = wrenches_[i];
    std::vector<double> stiffnesses;
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const double mass = size_.inertias[b].mass, turning = turning_mass(b) / (reach(b) * reach(b));
        stiffnesses.push_back(stiffest_ * mass + resistance * (mass + turning));
    }
    joints_.add(now_.at, factor_, stiffnesses, shares_anew_, entries, right_hand_side_);
    matrix_.resize(joints_.rows(), joints_.rows());
    matrix_.setFromTriplets(entries.begin(), entries.end());
}

/// By what holds the bodies where the machine is assembled, 6 rows each.
void RestEquations::set_least_resistance(const Eigen::VectorXd& held) {
    const std::vector<double> loads = loads_on(now_.at, 1);
    for (size_t b = 0; b < size_.inertias.size(); ++b) {
        const double mass = size_.inertias[b].mass, inertia = size_.inertias[b].J.trace() / 2, arm = reach(b);
        const Eigen::Map<const Vector6> load(&loads[6 * b]);
        stiffest_ = std::max({stiffest_, held.segment<3>(6 * as_row(b)).maxCoeff() / mass,
                              held.segment<3>(6 * as_row(b) + 3).maxCoeff() / inertia, load.head<3>().norm() / (mass * arm),
                              load.tail<3>().norm() / inertia});
    }
    least_resistance_ = std::max(kLeastResistance * stiffest_, kSlowest);
}

std::vector<double> RestEquations::loads_on(const std::vector<BodyState>& at, double factor) const {
    std::vector<double> loads(wrenches_.size(), 0.0);
    loads_.add_at_start(at, loads.data());
    for (double& load : loads) load *= factor;
    return loads;
}

/// Of forces that turn, or whose lever arms do, with their bodies: no load hangs on another body, so that all turn at once.
void RestEquations::add_load_stiffness(double factor, Triplets& entries) const {
    if (model_.loads.empty()) return;
    const auto turned = [&](int c, double angle) {
        std::vector<BodyState> at = now_.at;
        for (BodyState& body : at) body = moved(body, angle * Vector6::Unit(3 + c));
        std::vector<double> wrenches = loads_on(at, factor);
        return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(wrenches.data(), as_row(wrenches.size())));
    };
    for (int c = 0; c < 3; ++c) {
        const Eigen::VectorXd slope =
            slope_by_turn([&](double angle) { return Eigen::VectorXd(0.5 * (turned(c, angle) - turned(c, -angle))); });
        for (size_t b = 0; b < model_.bodies.size(); ++b)
            for (int r = 0; r < 6; ++r) {
                const int row = 6 * as_int(b) + r, column = 6 * as_int(b) + 3 + c;
                const double k = -slope(row);
                if (k != 0) entries.emplace_back(row, column, k);
            }
    }
}

/// Turns about two world axes in turn do work on a moment that hangs on which comes first. The stiffness of what balances a
/// moment M on a body by its turns is therefore K − ½ [M]×, K symmetric; elements and joints give K. Where M has a
/// potential, as that of a force on a lever arm, the stiffness of the load has ½ [M]×, and the two cancel out. Without this
/// part Newton's iteration diverges under a large moment that keeps its direction.
void RestEquations::add_turning_about(const std::vector<double>& loads, Triplets& entries) const {
    for (size_t b = 0; b < model_.bodies.size(); ++b) {
        const int row = 6 * as_int(b) + 3;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const double half = 0.5 * loads[as_size(row + i)];
            if (half == 0) continue;
            entries.emplace_back(row + j, row + k, half);
            entries.emplace_back(row + k, row + j, -half);
        }
    }
}

std::vector<double> RestEquations::load_stiffness() const {
    Triplets entries;
    add_load_stiffness(1, entries);
    std::vector<double> all(36 * model_.bodies.size(), 0.0);
    make_symmetric(entries);
    for (const auto& entry : entries)
        all[36 * as_size(entry.row() / 6) + 6 * as_size(entry.row() % 6) + as_size(entry.col() % 6)] += entry.value();
    return all;
}

// ---- What lacks ---------------------------------------------------------------------------------------------------------

const RestEquations::Balance& RestEquations::move(double share) {
    for (size_t b = 0; b < now_.at.size(); ++b) {
        now_.at[b] = moved(now_.at[b], share * Eigen::Map<const Vector6>(&change_[6 * b]));
        now_.turned[b] = followed(now_.at[b].rotation * start_.at[b].rotation.transpose(), now_.turned[b]);
    }
    joints_.change(share, solution_);
    std::ranges::fill(wrenches_, 0.0);
    const Networks::StaticMeasure inside = networks_.move_static(now_.at, share, wrenches_.data());
    const std::vector<double> loads = loads_on(now_.at, factor_);
    const double of_joints = joints_.take_off(now_.at, wrenches_);
    balance_ = {inside.residual, inside.force, std::max(inside.force, of_joints), inside.noise, inside.bend, inside.turn};
    for (size_t b = 0; b < now_.at.size(); ++b) {
        const Eigen::Map<const Vector6> load(&loads[6 * b]);
        const Vector6 r = Eigen::Map<const Vector6>(&wrenches_[6 * b]) + load;
        const double force = load.head<3>().norm(), by_moment = load.tail<3>().norm() / reach(b);
        balance_.force = std::max(balance_.force, force);
        balance_.strongest = std::max({balance_.strongest, force, by_moment});
        balance_.residual = std::max({balance_.residual, r.head<3>().norm(), r.tail<3>().norm() / reach(b)});
    }
    return balance_;
}

}  // namespace dttmm::host
