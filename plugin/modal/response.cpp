// SPDX-License-Identifier: BSD-3-Clause
#include "modal/response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

namespace {

using Sparse = Eigen::SparseMatrix<Complex>;

/// K + iω C − ω² M, 6 rows per frame, and the rows of rigid directions behind it, entry by entry.
class Entries {
public:
    explicit Entries(int frames) : row_(6 * frames) {}

    void add(int row, int column, const ComplexBlock& block) {
        if (row < 0 || column < 0) return;
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                if (block(i, j) != 0.0) entries_.emplace_back(6 * row + i, 6 * column + j, block(i, j));
    }
    void join(const Joined& at, const ComplexBlock& start, const ComplexBlock& across, const ComplexBlock& end) {
        add(at.from, at.from, at.by_from.transpose() * start * at.by_from);
        add(at.to, at.to, at.by_to.transpose() * end * at.by_to);
        const ComplexBlock between = at.by_from.transpose() * across * at.by_to;
        add(at.from, at.to, between);
        add(at.to, at.from, between.transpose());
        for (const Rigid& rigid : at.rigid) {
            for (const auto& [f, by] : {std::pair(at.from, &rigid.by_from), {at.to, &rigid.by_to}})
                for (int i = 0; f >= 0 && i < 6; ++i) {
                    if ((*by)(i) == 0) continue;
                    entries_.emplace_back(row_, 6 * f + i, (*by)(i));
                    entries_.emplace_back(6 * f + i, row_, (*by)(i));
                }
            ++row_;
        }
    }
    /// C of a mode with its own unknown q: s p q on the frames, s pᵀ u − s/r q = 0.
    void damp(const FrameVector& momentum, double rate, Complex s) {
        for (size_t f = 0; f < momentum.size(); ++f)
            for (int i = 0; i < 6; ++i) {
                const Complex value = s * momentum[f](i);
                if (value == 0.0) continue;
                entries_.emplace_back(row_, 6 * as_int(f) + i, value);
                entries_.emplace_back(6 * as_int(f) + i, row_, value);
            }
        entries_.emplace_back(row_, row_, s == 0.0 ? -1.0 : -s / rate);
        ++row_;
    }
    /// Maxwell series between the ends of a bond, each term with its own unknown z, k (d − z) = k s τ z: k (d − z) on the
    /// deformation d, −k d + k (1 + s τ) z = 0.
    void add_series(const Bond& bond, Complex s) {
        for (const auto& [direction, law] : bond.materials) {
            const Vector6 axis = bond.axes.col(direction);
            const std::pair<int, Vector6> ends[] = {{bond.from, -bond.by_from.transpose() * axis},
                                                    {bond.to, bond.by_to.transpose() * axis}};
            for (const auto& [stiffness, time] : law->series().terms) {
                for (const auto& [f, by] : ends) {
                    if (f < 0) continue;
                    for (const auto& [g, other] : ends) add(f, g, complex(stiffness * by * other.transpose()));
                    for (int i = 0; i < 6; ++i) {
                        if (by(i) == 0) continue;
                        entries_.emplace_back(row_, 6 * f + i, -stiffness * by(i));
                        entries_.emplace_back(6 * f + i, row_, -stiffness * by(i));
                    }
                }
                entries_.emplace_back(row_, row_, stiffness * (1.0 + s * time));
                ++row_;
            }
        }
    }
    Sparse matrix() const {
        Sparse matrix(row_, row_);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        return matrix;
    }

private:
    std::vector<Eigen::Triplet<Complex>> entries_;
    int row_;  ///< the next of a rigid direction
};

}  // namespace

// ---- Equations ----------------------------------------------------------------------------------------------------------

Eigen::SparseMatrix<Complex> HarmonicSolver::assemble(Complex s, Form form) {
    const FrequencyModel& model = D_.model();
    const Complex inertia = s * s + mass_rate_ * s;
    Entries entries(D_.frame_count());
    for (const Bond& bond : model.bonds) {
        const ComplexBlock K = form == Form::steady ? stiffness_of(bond, s.imag()) : stiffness_at_rest(bond, s);
        entries.join(bond, K, -K, K);
        if (!bond.turning) continue;
        const int ends[2] = {bond.from, bond.to};
        for (int i : {0, 1})
            for (int k : {0, 1})
                if (ends[i] >= 0 && ends[k] >= 0) entries.add(ends[i], ends[k], complex(bond.turning->at[i][k]));
    }
    waves_.assign(D_.slot_count(), std::nullopt);
    for (const DynamicStiffness::Piece& piece : D_.pieces()) {
        const LineModel& line = D_.line(piece);
        auto& L = waves_[D_.slot(piece)];
        if (!L) {
            const Section& section = line.line.section;
            const Complex stiffening = Complex(1, section.loss_factor) + s * section.stiffness_damping;
            if (form == Form::polynomial) {
                // What an axial force adds is not damped: the stiffness goes by the modulus to first order
                constexpr double kStep = 1e-10;  // of the modulus, imaginary: it leaves its square
                LineWaves::Square<double> stiffness, mass;
                LineWaves::Square<Complex> beside;
                line.waves->evaluate<double>(D_.count(line), 0, 1, stiffness, &mass, piece.index);
                line.waves->evaluate<Complex>(D_.count(line), 0, Complex(1, kStep), beside, nullptr, piece.index);
                L = stiffness.cast<Complex>() + (stiffening - 1.0) * (beside.imag() / kStep).cast<Complex>() +
                    inertia * mass.cast<Complex>();
            } else {
                line.waves->evaluate<Complex>(D_.count(line), -inertia, stiffening, L.emplace(), nullptr, piece.index);
            }
        }
        entries.join(piece, L->topLeftCorner<6, 6>(), L->topRightCorner<6, 6>(), L->bottomRightCorner<6, 6>());
    }
    for (const Pin& pin : model.pins) {
        const ComplexBlock own = inertia / 3.0 * complex(pin.mass), across = 0.5 * own;
        entries.join(pin, own, across, own);
    }
    D_.for_each_mass([&](const FrequencyModel::Mass& mass) {
        entries.add(mass.frame, mass.frame, inertia * complex(model.mask * mass.block * model.mask));
    });
    for (const FrequencyModel::Lever& lever : model.levers) entries.add(lever.frame, lever.frame, complex(lever.stiffness));
    const Matrix6 idle = Matrix6::Identity() - model.mask;
    for (int f = 0; f < D_.frame_count(); ++f) entries.add(f, f, complex(idle));
    for (size_t m = 0; of_modes_ && m < of_modes_->rates.size(); ++m)
        entries.damp(of_modes_->momenta[m], of_modes_->rates[m], s);
    if (form != Form::steady)
        for (const Bond& bond : model.bonds) entries.add_series(bond, s);
    return entries.matrix();
}

Eigen::MatrixXd HarmonicSolver::modal_damping() const {
    const Eigen::Index n = 6 * D_.frame_count();
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
    for (size_t m = 0; of_modes_ && m < of_modes_->rates.size(); ++m) {
        const Eigen::Map<const Eigen::VectorXd> p(of_modes_->momenta[m].front().data(), n);
        C += of_modes_->rates[m] * p * p.transpose();
    }
    return C;
}

Eigen::Index HarmonicSolver::rigid_rows() const {
    size_t rows = 0;
    for (const Bond& bond : D_.model().bonds) rows += bond.rigid.size();
    for (const DynamicStiffness::Piece& piece : D_.pieces()) rows += piece.rigid.size();
    for (const Pin& pin : D_.model().pins) rows += pin.rigid.size();
    return as_row(rows);
}

Eigen::Index HarmonicSolver::series_rows() const {
    size_t rows = 0;
    for (const Bond& bond : D_.model().bonds)
        for (const Bond::Material& material : bond.materials) rows += material.law->series().terms.size();
    return as_row(rows);
}

void HarmonicSolver::factor(double omega) {
    omega_ = omega;
    middle_ = nullptr;
    parts_.emplace(D_);
    refuse_beyond_rows();
    factor_matrix(assemble({0, omega}, Form::steady));
}

void HarmonicSolver::lean_on(const HarmonicSolver& middle) {
    omega_ = middle.omega_;
    middle_ = &middle;
    parts_.emplace(D_);
    refuse_beyond_rows();
    leaning_ = assemble({0, omega_}, Form::steady);
    if (of_modes_ || middle.of_modes_ || leaning_.rows() != middle.lu_.size() || rigid_rows() != middle.rigid_rows())
        throw Error(DTTMM_ERROR_ARGUMENT, "the equations of the machines are not laid out alike");
}

void HarmonicSolver::follow_supports(ModalDamping& damping) {
    const FrequencyModel& model = D_.model();
    factor(0);
    damping.followed.assign(damping.momenta.size(), std::vector<Complex6>(model.nodes.size(), Complex6::Zero()));
    for (size_t n = 0; n < model.nodes.size(); ++n)
        for (Eigen::Index d = 0; d < 6; ++d) {
            if ((model.fixed[n] >> d & 1) == 0) continue;
            const Response at_rest = solve({{}, {{as_int(n), Complex6::Unit(d)}}});
            for (size_t m = 0; m < damping.momenta.size(); ++m)
                for (size_t f = 0; f < at_rest.motion.size(); ++f)
                    damping.followed[m][n](d) += damping.momenta[m][f].cast<Complex>().dot(at_rest.motion[f]);
        }
}

/// Beyond its rows nothing is known of a material.
void HarmonicSolver::refuse_beyond_rows() const {
    constexpr double kRoundOff = 1e-9;
    for (const Bond& bond : D_.model().bonds)
        for (const auto& [direction, law] : bond.materials)
            if (omega_ > (1 + kRoundOff) * law->highest())
                throw Error(
                    DTTMM_ERROR_MODEL,
                    fmt::format("its rows in {} end at {:.6g} Hz, and {:.6g} Hz is asked for: add rows up to there",
                                kDirectionNames[as_size(direction)], law->highest() / (2 * M_PI), omega_ / (2 * M_PI)),
                    bond.element);
}

void HarmonicSolver::factor_matrix(const Sparse& matrix) {
    if (!lu_.factor(matrix))
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("{:.6g} Hz is a natural frequency without damping: the response there has no bound",
                                omega_ / (2 * M_PI)));
}

/// What moving supports do to what is joined to them.
void HarmonicSolver::add_supports(const Response& response, Eigen::VectorXcd& r) const {
    const FrequencyModel& model = D_.model();
    Eigen::Index row = 6 * D_.frame_count();
    // across: force on `from` by the motion of `to`; turning: of forces at rest, on one by the motion of the other
    const auto add = [&](const Joined& at, int held_node, const ComplexBlock& across, const EndBlocks* turning) {
        const bool is_to = at.to < 0;
        const Complex6 ground =
            at.from < 0 || at.to < 0 ? ground_at(model, at, held_node, is_to, response) : Complex6(Complex6::Zero());
        if (at.from >= 0 && is_to)
            r.segment<6>(6 * at.from) -= complex(at.by_from.transpose()) * across * complex(at.by_to) * ground;
        if (at.to >= 0 && !is_to && at.from < 0)
            r.segment<6>(6 * at.to) -= complex(at.by_to.transpose()) * across.transpose() * complex(at.by_from) * ground;
        if (turning && at.from >= 0 && is_to) r.segment<6>(6 * at.from) -= complex(turning->at[0][1]) * ground;
        if (turning && at.to >= 0 && at.from < 0) r.segment<6>(6 * at.to) -= complex(turning->at[1][0]) * ground;
        for (const Rigid& rigid : at.rigid) r(row++) -= rigid.by_ground.cast<Complex>().dot(ground);
    };
    for (const Bond& bond : model.bonds) add(bond, bond.held_node, -stiffness_of(bond, omega_), bond.turning.get());
    for (const DynamicStiffness::Piece& piece : D_.pieces())
        add(piece, -1, waves_[D_.slot(piece)]->topRightCorner<6, 6>(), nullptr);
    for (const Pin& pin : model.pins)
        add(pin, -1, Complex(-omega_ * omega_, mass_rate_ * omega_) / 6.0 * complex(pin.mass), nullptr);
    if (!of_modes_) return;
    for (const std::vector<Complex6>& followed : of_modes_->followed) {
        for (size_t n = 0; n < followed.size(); ++n)
            r(row) += Complex(0, omega_) * followed[n].cwiseProduct(response.supports[n]).sum();
        ++row;
    }
}

Response HarmonicSolver::solve(const Drive& drive) const {
    const FrequencyModel& model = D_.model();
    Eigen::VectorXcd r = Eigen::VectorXcd::Zero(middle_ ? leaning_.rows() : lu_.size());
    Response response;
    if (!drive.supports.empty()) {
        response.supports.assign(model.nodes.size(), Complex6::Zero());
        for (const SupportMotion& support : drive.supports) response.supports[as_size(support.node)] += support.motion;
        add_supports(response, r);
    }
    for (const PointWrench& load : drive.loads)
        if (load.frame >= 0)
            r.segment<6>(6 * load.frame) +=
                complex(model.masked_at(load.point, model.origin(load.frame)).transpose()) * load.wrench;
    Eigen::VectorXcd x = middle_ ? middle_->lu_.solve(r) : lu_.solve(r);
    if (middle_) x += middle_->lu_.solve(Eigen::VectorXcd(r - leaning_ * x));
    if (!x.allFinite())
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("{:.6g} Hz is a natural frequency without damping: the response there has no bound",
                                omega_ / (2 * M_PI)));
    for (int f = 0; f < D_.frame_count(); ++f) response.motion.push_back(complex(model.mask) * x.segment<6>(6 * f));
    const Eigen::VectorXcd q = x.segment(6 * D_.frame_count(), rigid_rows());
    response.reactions.assign(q.begin(), q.end());
    return response;
}

}  // namespace dttmm::plugin
