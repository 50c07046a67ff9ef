// SPDX-License-Identifier: BSD-3-Clause
#include "modal/response.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

namespace {

using Block = Eigen::Matrix<Complex, 6, 6>;
using Sparse = Eigen::SparseMatrix<Complex>;

Block complex(const Matrix6& block) { return block.cast<Complex>(); }

/// K (1 + iη) + s C, K at rest.
Block stiffness_at_rest(const Bond& bond, Complex s) {
    return Complex(1, bond.loss_factor) * complex(bond.stiffness) + s * complex(bond.damping);
}

/// The same in a vibration, materials by their rows.
Block stiffness_of(const Bond& bond, double omega) {
    Block K = stiffness_at_rest(bond, {0, omega});
    for (const auto& [direction, law] : bond.materials) {
        const Vector6 axis = bond.axes.col(direction);
        K += (law->stiffness_at(omega) - law->series().spring) * complex(axis * axis.transpose());
    }
    return K;
}

/// K + iω C − ω² M, 6 rows per frame, and the rows of rigid directions behind it, entry by entry.
class Entries {
public:
    explicit Entries(int frames) : row_(6 * frames) {}

    void add(int row, int column, const Block& block) {
        if (row < 0 || column < 0) return;
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                if (block(i, j) != 0.0) entries_.emplace_back(6 * row + i, 6 * column + j, block(i, j));
    }
    void join(const Joined& at, const Block& start, const Block& across, const Block& end) {
        add(at.from, at.from, at.by_from.transpose() * start * at.by_from);
        add(at.to, at.to, at.by_to.transpose() * end * at.by_to);
        const Block between = at.by_from.transpose() * across * at.by_to;
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

bool is_alike(const Sparse& a, const Sparse& b) {
    return a.rows() == b.rows() && a.nonZeros() == b.nonZeros() &&
           std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.outerSize() + 1, b.outerIndexPtr()) &&
           std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

}  // namespace

Response Response::mixed(double factor, double other_factor, const Response& other) const {
    Response sum = *this;
    for (size_t f = 0; f < motion.size(); ++f) sum.motion[f] = factor * motion[f] + other_factor * other.motion[f];
    for (size_t r = 0; r < reactions.size(); ++r)
        sum.reactions[r] = factor * reactions[r] + other_factor * other.reactions[r];
    return sum;
}

// ---- Equations ----------------------------------------------------------------------------------------------------------

Eigen::SparseMatrix<Complex> HarmonicSolver::assemble(Complex s, Form form) {
    const FrequencyModel& model = D_.model();
    const Complex inertia = s * s + mass_rate_ * s;
    Entries entries(D_.frame_count());
    for (const Bond& bond : model.bonds) {
        const Block K = form == Form::steady ? stiffness_of(bond, s.imag()) : stiffness_at_rest(bond, s);
        entries.join(bond, K, -K, K);
        if (!bond.turning) continue;
        const int ends[2] = {bond.from, bond.to};
        for (int i : {0, 1})
            for (int k : {0, 1})
                if (ends[i] >= 0 && ends[k] >= 0) entries.add(ends[i], ends[k], complex(bond.turning->at[i][k]));
    }
    waves_.assign(model.kinds.size(), std::nullopt);
    for (const DynamicStiffness::Piece& piece : D_.pieces()) {
        const LineModel& line = D_.line(piece);
        auto& L = waves_[line.kind];
        if (!L) {
            const Section& section = line.line.section;
            const Complex stiffening = Complex(1, section.loss_factor) + s * section.stiffness_damping;
            if (form == Form::polynomial) {
                LineWaves::Square<double> stiffness, mass;
                line.waves->evaluate<double>(D_.count(line), 0, 1, stiffness, &mass);
                L = stiffening * stiffness.cast<Complex>() + inertia * mass.cast<Complex>();
            } else {
                line.waves->evaluate<Complex>(D_.count(line), -inertia, stiffening, L.emplace(), nullptr);
            }
        }
        entries.join(piece, L->topLeftCorner<6, 6>(), L->topRightCorner<6, 6>(), L->bottomRightCorner<6, 6>());
    }
    for (const Pin& pin : model.pins) {
        const Block own = inertia / 3.0 * complex(pin.mass), across = 0.5 * own;
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
    find_parts();
    refuse_beyond_rows();
    factor_matrix(assemble({0, omega}, Form::steady));
}

void HarmonicSolver::lean_on(const HarmonicSolver& middle) {
    omega_ = middle.omega_;
    middle_ = &middle;
    find_parts();
    refuse_beyond_rows();
    leaning_ = assemble({0, omega_}, Form::steady);
    if (of_modes_ || middle.of_modes_ || leaning_.rows() != middle.pattern_.rows() || rigid_rows() != middle.rigid_rows())
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
    if (!is_alike(matrix, pattern_)) {
        lu_.analyzePattern(matrix);
        pattern_ = matrix;
    }
    lu_.factorize(matrix);
    if (lu_.info() != Eigen::Success)
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("{:.6g} Hz is a natural frequency without damping: the response there has no bound",
                                omega_ / (2 * M_PI)));
}

/// Where bonds and pieces of the elements stand.
void HarmonicSolver::find_parts() {
    const FrequencyModel& model = D_.model();
    parts_.assign(model.element_count, Parts{});
    first_row_.clear();
    size_t row = 0;
    for (size_t b = 0; b < model.bonds.size(); ++b) {
        const Bond& bond = model.bonds[b];
        first_row_.push_back(row);
        row += bond.rigid.size();
        if (bond.element < 0 || bond.held_node >= 0) continue;
        Parts& own = parts_[as_size(bond.element)];
        if (own.bonds++ == 0) own.bond = as_int(b);
    }
    for (size_t k = 0; k < D_.pieces().size(); ++k) {
        Parts& own = parts_[as_size(D_.pieces()[k].element)];
        if (own.piece < 0) {
            own.piece = as_int(k);
            own.row = row;
        }
        row += D_.pieces()[k].rigid.size();
    }
}

/// Motion of the ground at an end of what is joined to it, about the world's origin.
Complex6 HarmonicSolver::ground_at(const Joined& joined, int held_node, bool is_to, const Response& response) const {
    const FrequencyModel& model = D_.model();
    if (response.supports.empty()) return Complex6::Zero();
    int node = held_node;
    if (node < 0 && joined.element >= 0) {
        const auto [from, to] = model.ends[as_size(joined.element)];
        node = is_to ? to : from;
    }
    if (node < 0) return Complex6::Zero();
    return complex(FrequencyModel::at_point(Vector3::Zero(), model.nodes[as_size(node)].position)) *
           response.supports[as_size(node)];
}

/// What moving supports do to what is joined to them.
void HarmonicSolver::add_supports(const Response& response, Eigen::VectorXcd& r) const {
    const FrequencyModel& model = D_.model();
    Eigen::Index row = 6 * D_.frame_count();
    // across: force on `from` by the motion of `to`
    const auto add = [&](const Joined& at, int held_node, const Block& across) {
        const bool is_to = at.to < 0;
        const Complex6 ground =
            at.from < 0 || at.to < 0 ? ground_at(at, held_node, is_to, response) : Complex6(Complex6::Zero());
        if (at.from >= 0 && is_to)
            r.segment<6>(6 * at.from) -= complex(at.by_from.transpose()) * across * complex(at.by_to) * ground;
        if (at.to >= 0 && !is_to && at.from < 0)
            r.segment<6>(6 * at.to) -= complex(at.by_to.transpose()) * across.transpose() * complex(at.by_from) * ground;
        for (const Rigid& rigid : at.rigid) r(row++) -= rigid.by_ground.cast<Complex>().dot(ground);
    };
    for (const Bond& bond : model.bonds) add(bond, bond.held_node, -stiffness_of(bond, omega_));
    for (const DynamicStiffness::Piece& piece : D_.pieces())
        add(piece, -1, waves_[D_.line(piece).kind]->topRightCorner<6, 6>());
    for (const Pin& pin : model.pins) add(pin, -1, Complex(-omega_ * omega_, mass_rate_ * omega_) / 6.0 * complex(pin.mass));
    if (!of_modes_) return;
    for (const std::vector<Complex6>& followed : of_modes_->followed) {
        for (size_t n = 0; n < followed.size(); ++n)
            r(row) += Complex(0, omega_) * followed[n].cwiseProduct(response.supports[n]).sum();
        ++row;
    }
}

Response HarmonicSolver::solve(const Drive& drive) const {
    const FrequencyModel& model = D_.model();
    Eigen::VectorXcd r = Eigen::VectorXcd::Zero(middle_ ? leaning_.rows() : pattern_.rows());
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

// ---- Forces -------------------------------------------------------------------------------------------------------------

Complex6 HarmonicSolver::motion_of(int frame, const Response& response) const {
    return frame < 0 ? Complex6(Complex6::Zero()) : response.motion[as_size(frame)];
}

/// Displacement of its end at `to` against that at `from`.
Complex6 HarmonicSolver::relative(const Bond& bond, const Response& response) const {
    const auto end = [&](int frame, bool is_to) {
        return frame < 0 ? ground_at(bond, bond.held_node, is_to, response) : motion_of(frame, response);
    };
    return complex(bond.by_to) * end(bond.to, true) - complex(bond.by_from) * end(bond.from, false);
}

/// With which it holds its `to` end back, its own point, world axes.
Complex6 HarmonicSolver::wrench_of(const Bond& bond, const Response& response) const {
    Complex6 wrench = stiffness_of(bond, omega_) * relative(bond, response);
    size_t row = first_row_[as_size(as_int(&bond - D_.model().bonds.data()))];
    Complex6 on_frame = Complex6::Zero();
    for (const Rigid& rigid : bond.rigid)
        on_frame += response.reactions[row++] * (bond.to >= 0 ? rigid.by_to : Vector6(-rigid.by_from)).cast<Complex>();
    const int end = bond.to >= 0 ? 1 : 0;
    const Matrix6 by = FrequencyModel::at_point(bond.points[end], D_.model().origin(end == 1 ? bond.to : bond.from));
    return wrench + complex(by.transpose().inverse()) * on_frame;
}

/// The same in its own axes, which turn with its `from` end as a run has them.
Complex6 HarmonicSolver::own_wrench_of(const Bond& bond, const Response& response) const {
    const Block to_own = complex(bond.axes.transpose());
    return to_own * wrench_of(bond, response) + complex(bond.spread) * (to_own * relative(bond, response));
}

Carried HarmonicSolver::carried(size_t element, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const Parts& parts = parts_[element];
    if (parts.piece >= 0) return carried_by_line(element, response);
    if (parts.bond < 0) return {};
    if (parts.bonds > 1) return carried_by_chain(element, response);
    const Bond& bond = model.bonds[as_size(parts.bond)];
    Carried carried{own_wrench_of(bond, response), complex(bond.axes.transpose()) * relative(bond, response)};
    carried.deflection.tail<3>() = (rotation_vector_rate(bond.turned).cast<Complex>() * carried.deflection.tail<3>()).eval();
    return carried;
}

/// Motion of an end of what is joined, in its axes.
Complex6 HarmonicSolver::motion_at(const Joined& joined, bool is_to, const Response& response) const {
    const int frame = is_to ? joined.to : joined.from;
    return complex(is_to ? joined.by_to : joined.by_from) *
           (frame < 0 ? ground_at(joined, -1, is_to, response) : motion_of(frame, response));
}

/// Force and moment at the `from` end.
Carried HarmonicSolver::carried_by_line(size_t element, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_[element].piece)];
    const LineModel& line = D_.line(piece);
    Eigen::Matrix<Complex, 12, 1> ends;
    ends << motion_at(piece, false, response), motion_at(piece, true, response);
    Complex6 force = held_by_line(element, response) - waves_[line.kind]->topRows<6>() * ends;
    if (line.waves->pinned().any())
        for (const Pin& pin : model.pins)
            if (pin.element == as_int(element))
                force += omega_ * omega_ / 6 * complex(pin.mass) *
                         (2 * motion_at(pin, false, response) + motion_at(pin, true, response));
    Carried carried = between_ends(element, model.is_at_rest ? model.resting[element].axes : line.axes, response);
    carried.force = model.is_at_rest ? turned_with_line(element, force, response) : force;
    return carried;
}

/// On the `from` end of a line by its first piece, local axes: in rigid directions, and of a bar by the mass that goes with
/// that end.
Complex6 HarmonicSolver::held_by_line(size_t element, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_[element].piece)];
    const LineModel& line = D_.line(piece);
    Complex6 on_frame = Complex6::Zero();
    size_t row = parts_[element].row;
    for (const Rigid& rigid : piece.rigid)
        on_frame -= response.reactions[row++] * (piece.from < 0 ? rigid.by_ground : rigid.by_from).cast<Complex>();
    if (model.is_bar(line) && piece.from >= 0) {
        const double length = D_.piece_length(line);
        const Vector3 middle = line.start + 0.5 * length * line.axes.col(0);
        const Matrix6 by = both(line.axes.transpose()) * model.masked_at(middle, model.origin(piece.from));
        on_frame += omega_ * omega_ * complex(by.transpose() * bar_mass(line.line.section, length) * by) *
                    motion_of(piece.from, response);
        for (const FrequencyModel::Lever& lever : model.levers)
            if (lever.is_bar && lever.element == as_int(element))
                on_frame -= complex(lever.stiffness) * motion_of(piece.from, response);
    }
    if (on_frame.isZero(0)) return on_frame;
    const Matrix6 by_from = both(line.axes.transpose()) * FrequencyModel::at_point(line.start, model.origin(piece.from));
    return complex(by_from.transpose().inverse()) * on_frame;
}

/// The force of the waves on the `from` end of a line at rest, local axes, with what its other forces there add; in the axes
/// of that end, which turn with it. The moment of the equations does work on a rotation vector: half its turn is in it.
Complex6 HarmonicSolver::turned_with_line(size_t element, const Complex6& force, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const FrequencyModel::RestingLine& resting = model.resting[element];
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_[element].piece)];
    const LineModel& line = D_.line(piece);
    Complex6 all = force;
    if (line.deviation >= 0) {
        const Bond& bond = model.bonds[as_size(line.deviation)];
        const auto motion = [&](int frame, bool is_to) {
            return frame < 0 ? ground_at(bond, -1, is_to, response) : motion_of(frame, response);
        };
        const Complex6 on_frame = complex(bond.turning->at[0][0]) * motion(bond.from, false) +
                                  complex(bond.turning->at[0][1]) * motion(bond.to, true);
        all -= complex(bond.axes.transpose() * bond.by_from.transpose().inverse()) * on_frame;
    }
    const Block to_end = complex(both(resting.axes.transpose() * line.axes));
    const Complex6 end = to_end * motion_at(piece, false, response);
    all = (to_end * all).eval();
    const Eigen::Vector3cd turn = end.tail<3>();
    all.head<3>() += skew(resting.at_from.head<3>()).cast<Complex>() * turn;
    all.tail<3>() += 0.5 * skew(resting.at_from.tail<3>()).cast<Complex>() * turn;
    return all;
}

/// Of lumps: its first joint lies a quarter of a segment behind the `from` end.
Carried HarmonicSolver::carried_by_chain(size_t element, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const Bond& first = model.bonds[as_size(parts_[element].bond)];
    const Matrix3 axes = first.axes.topLeftCorner<3, 3>();
    Carried carried = between_ends(element, axes, response);
    carried.force = own_wrench_of(first, response);
    const Vector3 lever = axes.transpose() * (first.points[0] - model.nodes[as_size(model.ends[element].from)].position);
    const Eigen::Vector3cd force = carried.force.head<3>();
    carried.force.tail<3>() += skew(lever).cast<Complex>() * force;  // cross() of Eigen conjugates
    return carried;
}

/// The motion of the `to` end as seen from the `from` end.
Carried HarmonicSolver::between_ends(size_t element, const Matrix3& axes, const Response& response) const {
    const FrequencyModel& model = D_.model();
    const auto [from, to] = model.ends[element];
    const auto motion = [&](int node) {
        const int frame = model.nodes[as_size(node)].frame;
        return frame < 0 ? (response.supports.empty() ? Complex6(Complex6::Zero()) : response.supports[as_size(node)])
                         : Complex6(complex(model.by_node(as_size(node))) * response.motion[as_size(frame)]);
    };
    const Vector3 way = model.nodes[as_size(to)].position - model.nodes[as_size(from)].position;
    const Complex6 seen = complex(FrequencyModel::at_point(way, Vector3::Zero())) * motion(from);
    Carried carried;
    carried.deflection = complex(both(axes.transpose())) * (motion(to) - seen);
    if (model.is_at_rest)
        carried.deflection.tail<3>() =
            (rotation_vector_rate(model.resting[element].turned).cast<Complex>() * carried.deflection.tail<3>()).eval();
    return carried;
}

Complex6 HarmonicSolver::on_first(size_t constraint, const Response& response) const {
    const int bond = D_.model().constraints[constraint];
    return bond < 0 ? Complex6(Complex6::Zero()) : wrench_of(D_.model().bonds[as_size(bond)], response);
}

}  // namespace dttmm::plugin
