// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_model.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseLU>
#include <Eigen/SparseQR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Pieces of a line, at most.
constexpr int kMostPieces = 20000;
/// Of the eigenvalues of a pivot when all that moves is held: smaller ones, as share of the largest, stem from rounding.
constexpr double kSingular = 1e-14;
/// Of the entries of a piece's stiffness.
constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
/// Of a frame's largest stiffness: what is less in its rotations, or its translations, is rounding of levers [m²].
constexpr double kIdleRounding = 1e-24;
/// Cosine of an angle that is rounding.
constexpr double kAligned = 1e-9;

Matrix6 both(const Matrix3& R) {
    Matrix6 twice = Matrix6::Zero();
    twice.topLeftCorner<3, 3>() = twice.bottomRightCorner<3, 3>() = R;
    return twice;
}

Matrix6 mass_block(double mass, const Matrix3& inertia) {
    Matrix6 block = Matrix6::Zero();
    block.diagonal().head<3>().setConstant(mass);
    block.bottomRightCorner<3, 3>() = inertia;
    return block;
}

/// Of a section that need not be given whole, as a key to tell lines apart.
std::vector<double> key_of(const Line& line, double length, Directions active) {
    const Section& s = line.section;
    return {s.EA,
            s.EIy,
            s.EIz,
            s.GJ,
            s.GAy,
            s.GAz,
            s.mass,
            s.inertia,
            s.rotary_y,
            s.rotary_z,
            s.offset_y,
            s.offset_z,
            s.stiffness_damping,
            length,
            static_cast<double>(line.stretches_only),
            static_cast<double>(active.to_ulong())};
}

bool is_same(const std::vector<double>& a, const std::vector<double>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// The strain energy V of a piece by the motion of its ends, local axes: uᵀ D u = 2 (V − λ T') and uᵀ (−∂D/∂λ) u = 2 T'.
/// A short piece's ends move almost as one rigid body, which strains it by what rounding makes of D and, of order λ², by
/// its own mass: that motion is taken out where it makes no more than rounding would.
FrequencyModel::Strain strain_of(const Matrix12& D, const Matrix12& lambda_M, const Vector12& ends, double length) {
    Vector12 deformed;
    deformed << Vector6::Zero(), ends.segment<3>(6) - ends.head<3>() - length * Vector3(0, ends(5), -ends(4)),
        ends.tail<3>() - ends.segment<3>(3);
    const Matrix12 B = D + lambda_M;
    const double of_ends = 0.5 * ends.dot(B * ends), of_deformed = 0.5 * deformed.dot(B * deformed);
    const double rounding = kRounding * ends.cwiseAbs().dot(D.cwiseAbs() * ends.cwiseAbs());
    const double difference = std::abs(of_ends - of_deformed);
    return difference <= rounding ? FrequencyModel::Strain{of_deformed, difference}
                                  : FrequencyModel::Strain{of_ends, rounding};
}

}  // namespace

FrequencyModel::FrequencyModel(const dttmm_modal_model& model)
    : assembly_(assemble(*model.network, model.lumped_beams ? Waves::lumped : Waves::exact)), directions_(model.directions) {
    mask_.setZero();
    for (size_t d = 0; d < 6; ++d)
        if (directions_[d]) mask_(as_row(d), as_row(d)) = 1;
    add_bodies(model);
    frame_of_.assign(assembly_.frames.size(), -1);
    for (int f = 0; f < as_int(assembly_.frames.size()); ++f) {
        const FrameSpec& frame = assembly_.frames[as_size(f)];
        int& own = frame_of_[as_size(f)];
        if (f < assembly_.port_count) {
            own = f;
        } else if (frame.kind == FrameSpec::Kind::inner) {
            own = as_int(positions_.size());
            positions_.push_back(frame.pose.position);
            names_.push_back(frame.name);
            elements_.push_back(frame.element);
            if (frame.mass > 0)
                masses_.push_back(
                    {own, mass_block(frame.mass, frame.pose.rotation * frame.inertia * frame.pose.rotation.transpose())});
            total_mass_ += frame.mass;
        }
    }
    if (!directions_.all()) refer_to_inputs();
    const auto frame = [&](int f) { return frame_of_[as_size(f)]; };
    for (const JointSpec& joint : assembly_.joints) try {
            add_joint(joint.element, frame(joint.from), frame(joint.to), *joint.law, joint.pose);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), joint.element);
        }
    for (uint32_t c = 0; c < model.constraint_count; ++c) {
        const dttmm_constraint& constraint = model.constraints[c];
        JointLaw law;
        law.rigid = Directions(constraint.rigid);
        add_joint(-1, constraint.first, constraint.second, law,
                  {Eigen::Map<const Vector3>(constraint.position), Eigen::Map<const RowMajor3>(constraint.axes)});
    }
    own_frames_ = positions_.size();
    for (const LineSpec& line : assembly_.lines) add_line(line);
    if (own_frames_ == 0) throw Error(DTTMM_ERROR_MODEL, "nothing moves: no body and no free node");
}

void FrequencyModel::add_bodies(const dttmm_modal_model& model) {
    body_count_ = as_int(model.network->body_count);
    for (uint32_t b = 0; b < model.network->body_count; ++b) {
        const dttmm_body& body = model.network->bodies[b];
        const Eigen::Map<const Vector3> position(body.position);
        const Eigen::Map<const RowMajor3> inertia(body.inertia);
        if (!position.allFinite() || !inertia.allFinite() || !(body.mass > 0 && std::isfinite(body.mass)))
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("body \"{}\": its numbers must be finite", body.name));
        positions_.push_back(position);
        centres_.push_back(position);
        names_.push_back(fmt::format("body \"{}\"", body.name));
        elements_.push_back(-1);
        masses_.push_back({as_int(b), mass_block(body.mass, inertia)});
        total_mass_ += body.mass;
    }
}

/// In a reduced state the place counts at which a body is looked at: what is left out is left out there, while the centre of
/// mass keeps all the velocity that the rotations give it, as in the paper's J_xx + m (c2² + c3²). That is its first node.
void FrequencyModel::refer_to_inputs() {
    std::vector<bool> is_referred(positions_.size());
    for (size_t n = 0; n < assembly_.nodes.size(); ++n) {
        const int f = frame_of_node(n);
        if (f < 0 || is_referred[as_size(f)]) continue;
        is_referred[as_size(f)] = true;
        const Vector3 node = position_of_node(n), centre = positions_[as_size(f)];
        const Matrix6 to_centre = at_point(centre, node);
        for (Mass& mass : masses_)
            if (mass.frame == f) mass.block = to_centre.transpose() * mass.block * to_centre;
        positions_[as_size(f)] = node;
    }
}

Matrix6 FrequencyModel::by_centre(int body) const { return at_point(centres_[as_size(body)], positions_[as_size(body)]); }

Matrix6 FrequencyModel::at_point(const Vector3& point, const Vector3& origin) {
    Matrix6 by = Matrix6::Identity();
    by.topRightCorner<3, 3>() = -skew(point - origin);
    return by;
}

/// Between directions that the model leaves.
Matrix6 FrequencyModel::masked(const Matrix6& by) const { return mask_ * by * mask_; }

/// Adds a row unless it says nothing or what the rows before it say.
void FrequencyModel::add_rigid(std::vector<Rigid>& rows, const Rigid& row) const {
    Eigen::Matrix<double, 12, 1> rest;
    rest << row.by_from, row.by_to;
    const double size = rest.norm();
    if (!(size > kAligned)) return;
    std::vector<Eigen::Matrix<double, 12, 1>> basis;
    for (const Rigid& other : rows) {
        Eigen::Matrix<double, 12, 1> next;
        next << other.by_from, other.by_to;
        for (const auto& b : basis) next -= b.dot(next) * b;
        basis.push_back(next.normalized());
    }
    for (const auto& b : basis) rest -= b.dot(rest) * b;
    if (rest.norm() > kAligned * size) rows.push_back(row);
}

void FrequencyModel::add_joint(int element, int from, int to, const JointLaw& law, const Pose& pose) {
    if (from < 0 && to < 0) return;
    Bond bond;
    bond.element = element;
    bond.from = from;
    bond.to = to;
    bond.points[0] = bond.points[1] = pose.position;
    const Matrix6 axes = both(pose.rotation);
    Vector6 stiffness = law.stiffness, damping = law.damping;
    if (law.axial) {
        bond.points[0] -= law.axial->length * pose.rotation.col(0);
        add_force(bond, law, pose.rotation.col(0), stiffness);
    }
    const auto by = [&](int frame, int end) { return masked(at_point(bond.points[end], positions_[as_size(frame)])); };
    if (from >= 0) bond.by_from = by(from, 0);
    if (to >= 0) bond.by_to = by(to, 1);
    for (size_t d = 0; d < 6; ++d) {
        const auto i = as_row(d);
        if (!law.rigid[d]) continue;
        stiffness(i) = damping(i) = 0;
        const Eigen::Matrix<double, 1, 6> row = axes.col(i).transpose();
        bond.held.push_back(mask_ * axes.col(i));
        add_rigid(bond.rigid, {-(row * bond.by_from).transpose(), (row * bond.by_to).transpose()});
    }
    bond.axes = axes;
    bond.springs = stiffness;
    bond.stiffness = axes * stiffness.asDiagonal() * axes.transpose();
    bond.damping = axes * damping.asDiagonal() * axes.transpose();
    bonds_.push_back(std::move(bond));
}

/// The law of a joint along a line where that is at the start, and what its force there adds: F/L across the line, and the
/// levers of its points.
void FrequencyModel::add_force(const Bond& bond, const JointLaw& law, const Vector3& along, Vector6& stiffness) {
    const double elongation = law.axial->length - law.axial->natural;
    std::array<double, Law::kMostMemory> nothing{}, memory{};
    law.along(0, {0, elongation, 0, nothing.data(), memory.data()});
    const LawOnPath at_start = law.at(0, elongation, memory.data());
    stiffness(0) = at_start.tangent;
    stiffness(1) = stiffness(2) = at_start.force / law.axial->length;
    if (at_start.force == 0) return;
    start_forces_.emplace_back(bond.element, at_start.force);
    const int frames[2] = {bond.from, bond.to};
    for (int end : {0, 1}) {
        if (frames[end] < 0) continue;
        acting_.push_back({frames[end], bond.points[end] - positions_[as_size(frames[end])],
                           (end == 0 ? at_start.force : -at_start.force) * along});
        add_lever(bond.element, acting_.back());
    }
}

/// A force that keeps its direction while its lever arm turns: the symmetric part of −∂(a × F)/∂θ.
void FrequencyModel::add_lever(int element, const StartForce& acting) {
    const Matrix3 aF = skew(acting.arm) * skew(acting.force);
    Lever lever{element, acting.frame, Matrix6::Zero()};
    lever.stiffness.bottomRightCorner<3, 3>() = -0.5 * (aF + aF.transpose());
    lever.stiffness = masked(lever.stiffness);
    levers_.push_back(lever);
}

/// What rigid directions bear of the forces at the start, as masses at rest leave it to them, has levers too: without them a
/// body on a hinge would turn about its centre of mass.
void FrequencyModel::add_reactions() {
    constexpr double kInertial = 1e6;  // −λ M over K: the flap on a hinge has one frequency to 1e-5 from 1e4 to 1e8
    has_reactions_ = true;
    set_matrices(total_mass_ > 0 ? -kInertial * largest_stiffness() / total_mass_ : -1, false);
    if (const auto fault = elimination_->factor()) refuse(*fault);
    Motion r(as_size(frame_count()), Vector6::Zero());
    for (const StartForce& acting : acting_) {
        Vector6 wrench;
        wrench << acting.force, acting.arm.cross(acting.force);
        r[as_size(acting.frame)] += mask_ * wrench;
    }
    std::vector<double> q(as_size(elimination_->rigid_count()));
    elimination_->solve(r, q);
    size_t row = 0;
    for (const Bond& bond : bonds_)
        for (const Rigid& rigid : bond.rigid) {
            const double force = -q[row++];
            if (bond.from >= 0)
                add_lever(start_forces_.front().first,
                          {bond.from, bond.points[0] - positions_[as_size(bond.from)], force * rigid.by_from.head<3>()});
            if (bond.to >= 0)
                add_lever(start_forces_.front().first,
                          {bond.to, bond.points[1] - positions_[as_size(bond.to)], force * rigid.by_to.head<3>()});
        }
}

/// Displacement of the end of a line in its axes by the motion of a frame; of the ground none.
Matrix6 FrequencyModel::local_end(const Matrix3& axes, const Vector3& point, int frame) const {
    if (frame < 0) return Matrix6::Zero();
    return both(axes.transpose()) * masked(at_point(point, positions_[as_size(frame)]));
}

void FrequencyModel::add_line(const LineSpec& spec) {
    LineModel line{spec.element,
                   frame_of_[as_size(spec.from)],
                   frame_of_[as_size(spec.to)],
                   spec.start,
                   spec.finish,
                   spec.line.axes,
                   nullptr,
                   spec.line,
                   0};
    Directions active;
    for (size_t d = 0; d < 6; ++d) {
        const auto half = as_row(3 * (d / 3));
        const double share = (mask_.diagonal().segment<3>(half).cwiseProduct(line.axes.col(as_row(d % 3)))).norm();
        if (share > kAligned && share < 1 - kAligned)
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("dofs: its local {} lies at an angle to the directions that are left: turn the beam or "
                                    "its `up`, or leave all directions",
                                    kDirectionNames[d]),
                        spec.element);
        active[d] = share > 0.5;
    }
    const double length = (spec.finish - spec.start).norm();
    const std::vector<double> key = key_of(spec.line, length, active);
    const auto known = std::ranges::find_if(kinds_, [&](const Kind& kind) { return is_same(kind.key, key); });
    line.kind = as_size(known - kinds_.begin());
    if (known == kinds_.end()) {
        try {
            kinds_.push_back({key, std::make_unique<LineWaves>(spec.line, length, active), {}});
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), spec.element);
        }
    }
    line.waves = kinds_[line.kind].waves.get();
    total_mass_ += spec.line.section.mass * length;
    lines_.push_back(line);
    if (line.waves->pinned().none()) return;
    const auto ground = [&](int frame, const Vector3& point) -> Matrix6 {
        if (frame >= 0) return Matrix6::Zero();
        return both(line.axes.transpose()) * masked(at_point(point, Vector3::Zero()));
    };
    Pin pin{line.from,
            line.to,
            local_end(line.axes, line.start, line.from),
            local_end(line.axes, line.finish, line.to),
            Matrix6::Zero(),
            ground(line.from, line.start),
            ground(line.to, line.finish)};
    for (Eigen::Index d : {1, 2})
        if (line.waves->pinned()[as_size(d)]) pin.mass(d, d) = spec.line.section.mass * length;
    pins_.push_back(pin);
}

void FrequencyModel::cut(double omega) {
    std::vector<int> counts;
    for (const Kind& kind : kinds_) counts.push_back(kind.waves->pieces(omega, kMostPieces));
    if (is_cut_ && counts == counts_) return;
    is_cut_ = false;  // until it is
    ++cuts_;
    counts_ = counts;
    positions_.resize(own_frames_);
    names_.resize(own_frames_);
    elements_.resize(own_frames_);
    pieces_.clear();
    held_pieces_.clear();
    bar_masses_.clear();
    size_t total = 0;
    for (LineModel& line : lines_) {
        const int count = counts[line.kind];
        total += as_size(count);
        if (count > kMostPieces || total > 100 * as_size(kMostPieces))
            throw Error(DTTMM_ERROR_MEMORY,
                        fmt::format("up to {:.4g} Hz it has too many waves to count: more than {} pieces; ask for lower "
                                    "frequencies",
                                    omega / (2 * M_PI), kMostPieces),
                        line.element);
        cut_line(line, count);
    }
    build();
    if (!acting_.empty() && !has_reactions_) add_reactions();
    is_cut_ = true;
}

void FrequencyModel::cut_line(LineModel& line, int count) {
    line.first_piece = as_int(pieces_.size());
    line.count = count;
    const Directions passed = line.waves->passed();
    const auto point = [&](int i) { return Vector3(line.start + double(i) / count * (line.finish - line.start)); };
    int from = line.from;
    for (int i = 0; i < count; ++i) {
        int to = line.to;
        if (i + 1 < count) {
            to = as_int(positions_.size());
            positions_.push_back(point(i + 1));
            names_.push_back(fmt::format("a point of the line at ({:.4g}, {:.4g}, {:.4g}) m", point(i + 1).x(),
                                         point(i + 1).y(), point(i + 1).z()));
            elements_.push_back(line.element);
        }
        Piece piece{from, to, local_end(line.axes, point(i), from), local_end(line.axes, point(i + 1), to), {}};
        // A rod is a bar, its far end goes with its near one; in a restricted state it passes all but x as it is
        const bool is_bar = line.line.stretches_only && directions_.all();
        const Matrix6 carried = is_bar ? local_end(line.axes, point(i + 1), from) : piece.by_from;
        // What lies between pins: points inside go across with the start, no piece feels them
        const Directions held = i + 1 < count ? passed | line.waves->pinned() : passed;
        for (Eigen::Index d = 0; d < 6; ++d)
            if (held[as_size(d)]) add_rigid(piece.rigid, {-carried.row(d).transpose(), piece.by_to.row(d).transpose()});
        if (is_bar) {
            const Matrix6 bar = bar_mass(line.line.section, line.length() / count);
            const int frame = from >= 0 ? from : to;
            if (frame >= 0) {
                const Matrix6 middle = local_end(line.axes, 0.5 * (point(i) + point(i + 1)), frame);
                bar_masses_.push_back({frame, middle.transpose() * bar * middle});
            }
        }
        if (from < 0 || to < 0) {
            const auto ground = [&](int frame, int end) -> Matrix6 {
                if (frame >= 0) return Matrix6::Zero();
                return both(line.axes.transpose()) * masked(at_point(point(end), Vector3::Zero()));
            };
            held_pieces_.push_back({pieces_.size(), as_size(&line - lines_.data()), ground(from, i), ground(to, i + 1)});
        }
        pieces_.push_back(std::move(piece));
        from = to;
    }
}

/// Fixes the order of elimination and what stands in the directions left out.
void FrequencyModel::build() {
    for (;;) {
        std::vector<Link> links;
        for (const Bond& bond : bonds_) links.push_back({bond.from, bond.to, as_int(bond.rigid.size())});
        for (const Piece& piece : pieces_) links.push_back({piece.from, piece.to, as_int(piece.rigid.size())});
        for (const Pin& pin : pins_) links.push_back({pin.from, pin.to, 0});
        elimination_.emplace(frame_count(), links);
        elimination_->count_negatives(kSingular);
        int link = 0;
        const auto set = [&](const std::vector<Rigid>& rows) {
            for (size_t i = 0; i < rows.size(); ++i)
                elimination_->set_rigid(link, as_int(i), rows[i].by_from, rows[i].by_to);
            ++link;
        };
        for (const Bond& bond : bonds_) set(bond.rigid);
        for (const Piece& piece : pieces_) set(piece.rigid);

        // With λ < 0 all that moves is held: what is singular then is so at every frequency
        const double stiffest = largest_stiffness();
        const double lambda = total_mass_ > 0 && stiffest > 0 ? -1e-3 * stiffest / total_mass_ : -1;
        set_matrices(lambda);
        const auto fault = elimination_->factor();
        if (!fault) {
            elimination_->count_negatives(0);
            return;
        }
        if (fault->link < 0 || fault->too_many) refuse(*fault);
        // Of rigid directions that say the same one is enough, in small motions
        if (!is_redundant(fault->link, fault->rigid))
            throw Error(
                DTTMM_ERROR_NUMERIC,
                fmt::format("{}: the rigid directions that meet there cannot be told apart from rounding; give some of "
                            "them a stiffness",
                            names_[as_size(fault->frame)]),
                elements_[as_size(fault->frame)]);
        std::vector<Rigid>& rows = rigid_of(fault->link);
        rows.erase(rows.begin() + fault->rigid);
    }
}

std::vector<FrequencyModel::Rigid>& FrequencyModel::rigid_of(int link) {
    const auto l = as_size(link);
    return l < bonds_.size() ? bonds_[l].rigid : pieces_[l - bonds_.size()].rigid;
}

/// Whether rigid direction number i of a link says what the others, of all links together, say.
bool FrequencyModel::is_redundant(int link, int i) {
    const int links = as_int(bonds_.size() + pieces_.size());
    const Eigen::Index frames = frame_count();
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd own = Eigen::VectorXd::Zero(6 * frames);
    Eigen::Index count = 0;
    for (int l = 0; l < links; ++l) {
        const auto at = as_size(l);
        const bool is_bond = at < bonds_.size();
        const int from = is_bond ? bonds_[at].from : pieces_[at - bonds_.size()].from;
        const int to = is_bond ? bonds_[at].to : pieces_[at - bonds_.size()].to;
        const std::vector<Rigid>& rows = rigid_of(l);
        for (size_t k = 0; k < rows.size(); ++k) {
            const bool is_own = l == link && as_int(k) == i;
            for (const auto& [frame, by] : {std::pair(from, &rows[k].by_from), std::pair(to, &rows[k].by_to)})
                for (int d = 0; frame >= 0 && d < 6; ++d) {
                    if (is_own)
                        own(6 * frame + d) += (*by)(d);
                    else if ((*by)(d) != 0)
                        entries.emplace_back(6 * frame + d, count, (*by)(d));
                }
            if (!is_own) ++count;
        }
    }
    if (count == 0) return false;
    Eigen::SparseMatrix<double> others(6 * frames, count);
    others.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SparseQR<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> qr(others);
    return qr.info() == Eigen::Success && (others * qr.solve(own) - own).norm() <= kAligned * own.norm();
}

void FrequencyModel::refuse(const Elimination::Fault& fault) const {
    const auto f = as_size(fault.frame);
    if (fault.too_many)
        throw Error(DTTMM_ERROR_MODEL,
                    fmt::format("{}: more than {} rigid directions meet there; give some of them a stiffness", names_[f],
                                Elimination::kMostRows),
                    elements_[f]);
    throw Error(DTTMM_ERROR_MODEL,
                fmt::format("{}: nothing determines its motion in {} (world axes): it has no mass, and no element holds it "
                            "there; give it a stiffness, a mass or a `fixed` direction, or leave the direction out of dofs",
                            names_[f], kDirectionNames[as_size(fault.direction)]),
                elements_[f]);
}

/// Calls body(link, piece, kind, count) for every piece.
template <class Body>
void FrequencyModel::for_each_piece(const Body& body) const {
    for (const LineModel& line : lines_)
        for (int i = 0; i < line.count; ++i) {
            const int p = line.first_piece + i;
            body(as_int(bonds_.size()) + p, pieces_[as_size(p)], line);
        }
}

void FrequencyModel::set_matrices(double lambda, bool with_mass) {
    lambda_ = lambda;
    Elimination& e = *elimination_;
    e.set_zero();
    for (Kind& kind : kinds_) kind.at_lambda.clear();
    const auto add = [&](int link, int from, int to, const Matrix6& by_from, const Matrix6& by_to, const Matrix6& start,
                         const Matrix6& across, const Matrix6& end) {
        if (from >= 0) e.add_diagonal(from, by_from.transpose() * start * by_from);
        if (to >= 0) e.add_diagonal(to, by_to.transpose() * end * by_to);
        if (from >= 0 && to >= 0) e.add_coupling(link, by_from.transpose() * across * by_to);
    };
    for (size_t b = 0; b < bonds_.size(); ++b) {
        const Bond& bond = bonds_[b];
        add(as_int(b), bond.from, bond.to, bond.by_from, bond.by_to, bond.stiffness, -bond.stiffness, bond.stiffness);
    }
    for_each_piece([&](int link, const Piece& piece, const LineModel& line) {
        auto& known = kinds_[line.kind].at_lambda;
        auto [it, is_new] = known.try_emplace(line.count);
        if (is_new)
            line.waves->evaluate<double>(line.count, lambda, 1, it->second.first, with_mass ? &it->second.second : nullptr);
        const Matrix12& D = it->second.first;
        add(link, piece.from, piece.to, piece.by_from, piece.by_to, D.topLeftCorner<6, 6>(), D.topRightCorner<6, 6>(),
            D.bottomRightCorner<6, 6>());
    });
    int link = as_int(bonds_.size() + pieces_.size());
    for (const Pin& pin : pins_)
        add(link++, pin.from, pin.to, pin.by_from, pin.by_to, -lambda / 3 * pin.mass, -lambda / 6 * pin.mass,
            -lambda / 3 * pin.mass);
    for (const auto* list : {&masses_, &bar_masses_})
        for (const Mass& mass : *list) e.add_diagonal(mass.frame, -lambda * mask_ * mass.block * mask_);
    for (const Lever& lever : levers_) e.add_diagonal(lever.frame, lever.stiffness);
    for (int f = 0; f < frame_count(); ++f) {
        Matrix6 idle = Matrix6::Zero();
        const Vector6 sizes = e.diagonal(f).diagonal().cwiseAbs();
        for (Eigen::Index half : {0, 3}) {
            double size = sizes.segment<3>(half).maxCoeff();
            if (size <= kIdleRounding * sizes.maxCoeff()) size = sizes.maxCoeff();
            for (Eigen::Index d = half; d < half + 3; ++d)
                if (!directions_[as_size(d)]) idle(d, d) = size > 0 ? size : 1;
        }
        e.add_diagonal(f, idle);
    }
}

std::optional<int> FrequencyModel::factor(double lambda, bool with_mass) {
    set_matrices(lambda, with_mass);
    if (elimination_->factor()) return std::nullopt;
    return elimination_->negatives();
}

void FrequencyModel::solve(Motion& r) const {
    for (Vector6& own : r) own = mask_ * own;
    std::vector<double> q(as_size(elimination_->rigid_count()));
    elimination_->solve(r, q);
}

FrequencyModel::Motion FrequencyModel::mass_times(const Motion& u) const {
    Motion out(u.size(), Vector6::Zero());
    for (const auto* list : {&masses_, &bar_masses_})
        for (const Mass& mass : *list) {
            const auto f = as_size(mass.frame);
            out[f] += mask_ * (mass.block * (mask_ * u[f]));
        }
    add_pins(1, u, out);
    for_each_piece([&](int, const Piece& piece, const LineModel& line) {
        add_piece(piece, kinds_[line.kind].at_lambda.at(line.count).second, u, out);
    });
    return out;
}

FrequencyModel::Motion FrequencyModel::stiffness_times(const Motion& u) const {
    Motion out(u.size(), Vector6::Zero());
    for (const auto* list : {&masses_, &bar_masses_})
        for (const Mass& mass : *list) {
            const auto f = as_size(mass.frame);
            out[f] -= lambda_ * mask_ * (mass.block * (mask_ * u[f]));
        }
    add_pins(-lambda_, u, out);
    for (const Lever& lever : levers_) {
        const auto f = as_size(lever.frame);
        out[f] += lever.stiffness * u[f];
    }
    for (const Bond& bond : bonds_) {
        const Vector6 force = bond.stiffness * relative(bond, u);
        if (bond.from >= 0) out[as_size(bond.from)] -= bond.by_from.transpose() * force;
        if (bond.to >= 0) out[as_size(bond.to)] += bond.by_to.transpose() * force;
    }
    for_each_piece([&](int, const Piece& piece, const LineModel& line) {
        add_piece(piece, kinds_[line.kind].at_lambda.at(line.count).first, u, out);
    });
    return out;
}

/// Adds the momenta of pinned rods, times a factor.
void FrequencyModel::add_pins(double factor, const Motion& u, Motion& out) const {
    for (const Pin& pin : pins_) {
        Vector6 start = Vector6::Zero(), finish = start;
        if (pin.from >= 0) start = pin.by_from * u[as_size(pin.from)];
        if (pin.to >= 0) finish = pin.by_to * u[as_size(pin.to)];
        if (pin.from >= 0)
            out[as_size(pin.from)] += factor * pin.by_from.transpose() * (pin.mass * (start / 3 + finish / 6));
        if (pin.to >= 0) out[as_size(pin.to)] += factor * pin.by_to.transpose() * (pin.mass * (start / 6 + finish / 3));
    }
}

Vector6 FrequencyModel::relative(const Bond& bond, const Motion& u) {
    Vector6 d = Vector6::Zero();
    if (bond.from >= 0) d -= bond.by_from * u[as_size(bond.from)];
    if (bond.to >= 0) d += bond.by_to * u[as_size(bond.to)];
    return d;
}

Vector12 FrequencyModel::ends_of(const Piece& piece, const Motion& u) {
    Vector12 ends = Vector12::Zero();
    if (piece.from >= 0) ends.head<6>() = piece.by_from * u[as_size(piece.from)];
    if (piece.to >= 0) ends.tail<6>() = piece.by_to * u[as_size(piece.to)];
    return ends;
}

void FrequencyModel::add_piece(const Piece& piece, const Matrix12& D, const Motion& u, Motion& out) {
    const Vector12 force = D * ends_of(piece, u);
    if (piece.from >= 0) out[as_size(piece.from)] += piece.by_from.transpose() * force.head<6>();
    if (piece.to >= 0) out[as_size(piece.to)] += piece.by_to.transpose() * force.tail<6>();
}

double FrequencyModel::largest_stiffness() const {
    double largest = 0;
    for (const Bond& bond : bonds_) largest = std::max(largest, bond.stiffness.diagonal().head<3>().maxCoeff());
    for (const LineModel& line : lines_) {
        const double l = (line.finish - line.start).norm() / std::max(line.count, 1);
        largest = std::max(largest, line.line.section.EA / l);
    }
    return largest;
}

bool FrequencyModel::is_elastic() const {
    const auto gives = [](const Bond& bond, const Matrix6& by) {
        return (by.transpose() * bond.stiffness * by).diagonal().maxCoeff() > 0;
    };
    return !lines_.empty() ||
           std::ranges::any_of(bonds_, [&](const Bond& b) { return gives(b, b.by_from) || gives(b, b.by_to); });
}

double FrequencyModel::force_at_start(size_t element) const {
    const auto own = std::ranges::find_if(start_forces_, [&](const auto& one) { return one.first == as_int(element); });
    return own == start_forces_.end() ? 0 : own->second;
}

void FrequencyModel::refuse_growing(double lambda) {
    const std::optional<int> growing = factor(lambda, false);
    if (growing && *growing > 0)
        throw Error(DTTMM_ERROR_MODEL,
                    fmt::format("{} of its motions would grow, not vibrate: the forces of its springs at the start drive it "
                                "away from there",
                                *growing));
}

FrequencyModel::Whole FrequencyModel::move_whole(int direction) const {
    Whole whole{Motion(positions_.size()), {}, {}, 0};
    for (size_t f = 0; f < positions_.size(); ++f)
        whole.motion[f] = masked(at_point(positions_[f], Vector3::Zero())).col(direction);
    whole.forces = stiffness_times(whole.motion);
    whole.momenta = mass_times(whole.motion);
    for (size_t f = 0; f < positions_.size(); ++f) whole.mass += whole.motion[f].dot(whole.momenta[f]);
    // And the ends on the ground: g moves along, D g and M g act on the other ends
    for (const HeldPiece& held : held_pieces_) {
        const LineModel& line = lines_[held.line];
        const Piece& piece = pieces_[held.piece];
        const auto& [D, M] = kinds_[line.kind].at_lambda.at(line.count);
        Vector12 ground;
        ground << held.start.col(direction), held.finish.col(direction);
        const Vector12 force = D * ground, momentum = M * ground, own = ends_of(piece, whole.motion);
        whole.mass += ground.dot(momentum) + 2 * own.dot(momentum);
        for (const auto& [frame, by, end] : {std::tuple(piece.from, &piece.by_from, 0), {piece.to, &piece.by_to, 6}}) {
            if (frame < 0) continue;
            whole.forces[as_size(frame)] += by->transpose() * force.segment<6>(end);
            whole.momenta[as_size(frame)] += by->transpose() * momentum.segment<6>(end);
        }
    }
    for (const Pin& pin : pins_) {
        const Vector6 start = pin.start.col(direction), finish = pin.finish.col(direction);
        const Vector6 at_start = pin.mass * (start / 3 + finish / 6), at_finish = pin.mass * (start / 6 + finish / 3);
        whole.mass += start.dot(at_start) + finish.dot(at_finish);
        for (const auto& [frame, by, momentum] :
             {std::tuple(pin.from, &pin.by_from, &at_start), {pin.to, &pin.by_to, &at_finish}}) {
            if (frame < 0) continue;
            const auto f = as_size(frame);
            whole.mass += 2 * (*by * whole.motion[f]).dot(*momentum);
            whole.forces[f] -= lambda_ * by->transpose() * *momentum;
            whole.momenta[f] += by->transpose() * *momentum;
        }
    }
    return whole;
}

Vector3 FrequencyModel::position_of_node(size_t node) const {
    const NodeSpec& spec = assembly_.nodes[node];
    const Pose& pose = assembly_.frames[as_size(spec.frame)].pose;
    return pose.position + pose.rotation * spec.offset;
}

Vector6 FrequencyModel::node_motion(size_t node, const Motion& u) const {
    const int frame = frame_of_node(node);
    return frame < 0 ? Vector6(Vector6::Zero()) : Vector6(by_node(node) * u[as_size(frame)]);
}

Matrix6 FrequencyModel::by_node(size_t node) const {
    return masked(at_point(position_of_node(node), positions_[as_size(frame_of_node(node))]));
}

std::vector<FrequencyModel::Strain> FrequencyModel::strain_energies(const Motion& u, size_t elements) const {
    std::vector<Strain> energies(elements);
    const auto add = [&](int element, const Strain& strain) {
        if (element < 0) return;
        Strain& own = energies[as_size(element)];
        own.energy += strain.energy;
        own.unsure += strain.unsure;
    };
    for (const Bond& bond : bonds_) {
        const Vector6 d =
            bond.axes.transpose() * relative(bond, u);  // where nothing holds there is no strain, not rounding of it
        add(bond.element, {0.5 * d.dot(bond.springs.cwiseProduct(d)), 0});
    }
    for (const Lever& lever : levers_) {
        const Vector6& own = u[as_size(lever.frame)];
        add(lever.element, {0.5 * own.dot(lever.stiffness * own), 0});
    }
    for_each_piece([&](int, const Piece& piece, const LineModel& line) {
        const auto& [D, M] = kinds_[line.kind].at_lambda.at(line.count);
        add(line.element, strain_of(D, lambda_ * M, ends_of(piece, u), line.length() / line.count));
    });
    return energies;
}

FrequencyModel::Quotient FrequencyModel::strain_quotient(const Motion& u) const {
    const size_t elements = assembly_.first_joint.size() - 1;  // after them come the fixed nodes
    Strain all;
    for (const Strain& strain : strain_energies(u, elements)) {
        all.energy += strain.energy;
        all.unsure += strain.unsure;
    }
    const Motion momenta = mass_times(u);
    double mass = 0;
    for (size_t f = 0; f < u.size(); ++f) mass += u[f].dot(momenta[f]);
    return {2 * std::max(all.energy, 0.0) / mass, 2 * all.unsure / mass};
}

double FrequencyModel::along(size_t element, const Motion& u, size_t count, double* shape) const {
    for (const LineModel& line : lines_) {
        if (line.element != as_int(element)) continue;
        const double length = (line.finish - line.start).norm(), piece_length = length / line.count;
        const Matrix12& D = kinds_[line.kind].at_lambda.at(line.count).first;
        for (size_t k = 0; shape && k < count; ++k) {
            const double s = count > 1 ? static_cast<double>(k) / static_cast<double>(count - 1) * length : 0;
            const int i = std::min(line.count - 1, static_cast<int>(s / piece_length));
            const Piece& piece = pieces_[as_size(line.first_piece + i)];
            const Vector12 ends = ends_of(piece, u);
            Vector12 start;
            start << ends.head<6>(), -(D.topRows<6>() * ends);
            Vector6 local = (line.waves->transfer(lambda_, s - i * piece_length) * start).head<6>();
            if (line.line.stretches_only && directions_.all())
                local.segment<3>(1) += (s - i * piece_length) * Vector3(ends(5), -ends(4), 0);
            for (Eigen::Index d : {1, 2}) {  // straight between pins
                if (!line.waves->pinned()[as_size(d)]) continue;
                const auto across = [&](int frame, const Vector3& point) {
                    return frame < 0 ? 0.0 : (local_end(line.axes, point, frame) * u[as_size(frame)])(d);
                };
                local(d) = (1 - s / length) * across(line.from, line.start) + s / length * across(line.to, line.finish);
            }
            Eigen::Map<Vector6>{shape + 6 * k} = both(line.axes) * local;
        }
        return length;
    }
    return 0;
}

std::vector<FrequencyModel::Station> FrequencyModel::stations(const Motion& u) const {
    constexpr int kStations = 8;  // of a piece, which is half a wave at most
    std::vector<Station> list;
    for (int b = 0; b < body_count_; ++b) list.push_back({centres_[as_size(b)], by_centre(b) * u[as_size(b)]});
    for (size_t n = 0; n < node_count(); ++n) list.push_back({position_of_node(n), node_motion(n, u)});
    for (const LineModel& line : lines_) {
        const double piece_length = line.length() / line.count;
        const Matrix12& D = kinds_[line.kind].at_lambda.at(line.count).first;
        const Vector3 along = line.axes.col(0);
        std::vector<Matrix12> transfers;
        for (int k = 1; k <= kStations; ++k)
            transfers.push_back(line.waves->transfer(lambda_, k * piece_length / kStations));
        for (int i = 0; i < line.count; ++i) {
            const Vector12 ends = ends_of(pieces_[as_size(line.first_piece + i)], u);
            Vector12 start;
            start << ends.head<6>(), -(D.topRows<6>() * ends);
            for (int k = 1; k <= kStations; ++k) {
                const double s = (i + static_cast<double>(k) / kStations) * piece_length;
                const Vector6 local = (transfers[as_size(k - 1)] * start).head<6>();
                list.push_back({line.start + s * along, both(line.axes) * local});
            }
        }
    }
    return list;
}

std::pair<double, double> FrequencyModel::largest(const Motion& u) const {
    constexpr int kStations = 8;  // of a piece, which is half a wave at most
    double way = 0, turn = 0;
    const auto look = [&](const Vector6& motion) {
        way = std::max(way, motion.head<3>().norm());
        turn = std::max(turn, motion.tail<3>().norm());
    };
    for (const Vector6& motion : u) look(motion);
    for (size_t n = 0; n < node_count(); ++n) look(node_motion(n, u));
    std::map<std::pair<size_t, int>, std::vector<Matrix12>> transfers;
    for_each_piece([&](int, const Piece& piece, const LineModel& line) {
        const double step = (line.finish - line.start).norm() / line.count / kStations;
        auto [known, is_new] = transfers.try_emplace({line.kind, line.count});
        for (int k = 1; is_new && k < kStations; ++k) known->second.push_back(line.waves->transfer(lambda_, k * step));
        const Vector12 ends = ends_of(piece, u);
        Vector12 start;
        start << ends.head<6>(), -(kinds_[line.kind].at_lambda.at(line.count).first.topRows<6>() * ends);
        for (const Matrix12& transfer : known->second) look((transfer * start).head<6>());
    });
    return {way, turn};
}

/// K + iω C − ω² M and the rows of rigid directions behind it, entry by entry.
class FrequencyModel::DynamicStiffness {
public:
    using Block = Eigen::Matrix<Frequency, 6, 6>;
    explicit DynamicStiffness(int frames) : row_(6 * frames) {}

    void add(int row, int column, const Block& block) {
        if (row < 0 || column < 0) return;
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                if (block(i, j) != 0.0) entries_.emplace_back(6 * row + i, 6 * column + j, block(i, j));
    }
    void couple(int from, int to, const Matrix6& by_from, const Matrix6& by_to, const Block& start, const Block& across,
                const Block& end) {
        add(from, from, by_from.transpose() * start * by_from);
        add(to, to, by_to.transpose() * end * by_to);
        const Block between = by_from.transpose() * across * by_to;
        add(from, to, between);
        add(to, from, between.transpose());
    }
    void hold(int from, int to, const std::vector<Rigid>& rows) {
        for (const Rigid& rigid : rows) {
            for (const auto& [f, by] : {std::pair(from, &rigid.by_from), std::pair(to, &rigid.by_to)}) {
                if (f < 0) continue;
                for (int i = 0; i < 6; ++i) {
                    if ((*by)(i) == 0) continue;
                    entries_.emplace_back(row_, 6 * f + i, (*by)(i));
                    entries_.emplace_back(6 * f + i, row_, (*by)(i));
                }
            }
            ++row_;
        }
    }
    void keep_out(int frame, int direction) { entries_.emplace_back(6 * frame + direction, 6 * frame + direction, 1.0); }
    Eigen::SparseMatrix<Frequency> matrix() const {
        Eigen::SparseMatrix<Frequency> matrix(row_, row_);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        return matrix;
    }

private:
    std::vector<Eigen::Triplet<Frequency>> entries_;
    int row_;  ///< the next of a rigid direction
};

Eigen::SparseMatrix<FrequencyModel::Frequency> FrequencyModel::dynamic_stiffness(double omega) const {
    using Block = DynamicStiffness::Block;
    DynamicStiffness D(frame_count());
    for (const Bond& bond : bonds_) {
        const Block K = bond.stiffness.cast<Frequency>() + Frequency(0, omega) * bond.damping.cast<Frequency>();
        D.couple(bond.from, bond.to, bond.by_from, bond.by_to, K, -K, K);
        D.hold(bond.from, bond.to, bond.rigid);
    }
    std::map<std::pair<size_t, int>, Eigen::Matrix<Frequency, 12, 12>> known;
    for_each_piece([&](int, const Piece& piece, const LineModel& line) {
        auto [it, is_new] = known.try_emplace({line.kind, line.count});
        if (is_new)
            line.waves->evaluate<Frequency>(line.count, omega * omega,
                                            Frequency(1, omega * line.line.section.stiffness_damping), it->second, nullptr);
        const auto& L = it->second;
        D.couple(piece.from, piece.to, piece.by_from, piece.by_to, L.topLeftCorner<6, 6>(), L.topRightCorner<6, 6>(),
                 L.bottomRightCorner<6, 6>());
        D.hold(piece.from, piece.to, piece.rigid);
    });
    for (const Pin& pin : pins_) {
        const Block own = (-omega * omega / 3 * pin.mass).cast<Frequency>(), across = 0.5 * own;
        D.couple(pin.from, pin.to, pin.by_from, pin.by_to, own, across, own);
    }
    for (const auto* list : {&masses_, &bar_masses_})
        for (const Mass& mass : *list)
            D.add(mass.frame, mass.frame, (-omega * omega * mask_ * mass.block * mask_).cast<Frequency>());
    for (const Lever& lever : levers_) D.add(lever.frame, lever.frame, lever.stiffness.cast<Frequency>());
    for (int f = 0; f < frame_count(); ++f)
        for (int d = 0; d < 6; ++d)
            if (!directions_[as_size(d)]) D.keep_out(f, d);
    return D.matrix();
}

std::vector<Eigen::Matrix<FrequencyModel::Frequency, 6, 1>> FrequencyModel::respond(double omega, int frame,
                                                                                    const Vector3& point,
                                                                                    const Vector6& wrench) const {
    const Eigen::SparseMatrix<Frequency> matrix = dynamic_stiffness(omega);
    Eigen::SparseLU<Eigen::SparseMatrix<Frequency>> lu(matrix);
    Eigen::VectorXcd r = Eigen::VectorXcd::Zero(matrix.rows());
    if (frame >= 0) {
        const Matrix6 by = masked(at_point(point, positions_[as_size(frame)]));
        r.segment<6>(6 * frame) = (by.transpose() * wrench).cast<Frequency>();
    }
    const Eigen::VectorXcd x = lu.info() == Eigen::Success ? Eigen::VectorXcd(lu.solve(r)) : r;
    if (lu.info() != Eigen::Success || !x.allFinite())
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("{:.6g} Hz is a natural frequency without damping: the response there has no bound",
                                omega / (2 * M_PI)));
    std::vector<Eigen::Matrix<Frequency, 6, 1>> motion;
    for (int f = 0; f < frame_count(); ++f) motion.push_back(mask_ * x.segment<6>(6 * f));
    return motion;
}

Matrix6 bar_mass(const Section& section, double length) {
    const double m = section.mass * length, J = m * length * length / 12;
    const double polar = is_given(section.inertia) ? section.inertia : 0;
    Matrix6 bar = Matrix6::Zero();
    bar.diagonal() << 0, m, m, polar * length, J, J;
    return bar;
}

}  // namespace dttmm::plugin
