// SPDX-License-Identifier: BSD-3-Clause
#include "modal/dynamic_stiffness.h"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "core/loose_motion.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

namespace {

/// Of the eigenvalues of a pivot when all that moves is held: smaller ones, as share of the largest, stem from rounding.
constexpr double kSingular = 1e-14;
/// Of a frame's largest stiffness: what is less in its rotations, or its translations, is rounding of levers [m²].
constexpr double kIdleRounding = 1e-24;
/// Of a row of rigid directions: what is left of one that follows from others.
constexpr double kRedundant = 1e-9;
/// Evaluations of lines after which their expansion pays: it takes as long as so many.
constexpr int kDirect = 6;

/// Of a bar between pins: m [1/3 1/6; 1/6 1/3].
Vector12 momentum_of(const Pin& pin, const Vector12& ends) {
    Vector12 momentum;
    momentum << pin.mass * (ends.head<6>() / 3 + ends.tail<6>() / 6), pin.mass * (ends.head<6>() / 6 + ends.tail<6>() / 3);
    return momentum;
}

}  // namespace

// ---- The pieces ---------------------------------------------------------------------------------------------------------

void DynamicStiffness::cut(double omega) {
    std::vector<int> counts;
    for (const auto& kind : model_.kinds) counts.push_back(kind->pieces(omega, LineWaves::kMostPieces));
    asked_for_ = std::max(asked_for_, omega);
    if (is_cut_ && counts == counts_) return;
    cut_for_ = omega;
    cut_into(counts);
}

void DynamicStiffness::cut_like(const DynamicStiffness& other) {
    std::vector<int> counts(model_.kinds.size(), 0);
    bool is_possible = model_.lines.size() == other.model_.lines.size();
    for (size_t l = 0; is_possible && l < model_.lines.size(); ++l) {
        int& own = counts[model_.lines[l].kind];
        const int wanted = other.count(other.model_.lines[l]);
        is_possible = own == 0 || own == wanted;
        own = wanted;
    }
    if (!is_possible) throw Error(DTTMM_ERROR_ARGUMENT, "the machines differ in more than numbers");
    asked_for_ = std::max(asked_for_, other.asked_for_);
    if (is_cut_ && counts == counts_) return;
    cut_for_ = other.cut_for_;
    cut_into(counts);
}

void DynamicStiffness::cut_into(const std::vector<int>& counts) {
    is_cut_ = false;  // until it is
    ++cuts_;
    asked_for_ = cut_for_;
    counts_ = counts;
    points_.clear();
    pieces_.clear();
    bar_masses_.clear();
    first_slot_.clear();
    first_piece_.clear();
    size_t slots = 0;
    for (size_t k = 0; k < counts_.size(); ++k) {
        first_slot_.push_back(slots);
        slots += model_.kinds[k]->is_graded() ? as_size(counts_[k]) : 1;
    }
    waves_.resize(slots);
    expansions_.assign(slots, std::nullopt);
    expanded_to_ = 0;
    direct_ = 0;
    for (size_t l = 0; l < model_.lines.size(); ++l) {
        const LineModel& line = model_.lines[l];
        if (count(line) > LineWaves::kMostPieces ||
            pieces_.size() + as_size(count(line)) > 100 * as_size(LineWaves::kMostPieces))
            throw Error(DTTMM_ERROR_MEMORY,
                        cut_for_ > 0
                            ? fmt::format("up to {:.4g} Hz it has too many waves to count: more than {} pieces; ask for "
                                          "lower frequencies",
                                          cut_for_ / (2 * M_PI), LineWaves::kMostPieces)
                            : LineWaves::too_strong_to_cut(),
                        line.element);
        cut_line(l);
    }
    build();
    is_cut_ = true;
}

void DynamicStiffness::cut_line(size_t l) {
    const LineModel& line = model_.lines[l];
    const int pieces = count(line);
    first_piece_.push_back(as_row(pieces_.size()));
    const auto point = [&](int i) { return Vector3(line.start + double(i) / pieces * (line.finish - line.start)); };
    int from = line.from;
    for (int i = 0; i < pieces; ++i) {
        int to = line.to;
        if (i + 1 < pieces) {
            to = frame_count();
            points_.push_back({point(i + 1), l});
        }
        add_piece({{line.element, from, to, {}, {}, {}}, l, i}, point(i), point(i + 1));
        from = to;
    }
}

void DynamicStiffness::add_piece(Piece piece, const Vector3& start, const Vector3& finish) {
    const LineModel& line = model_.lines[piece.line];
    const auto by = [&](int frame, const Vector3& point) {
        return Matrix6(both(line.axes.transpose()) * model_.masked_at(point, origin(frame)));
    };
    piece.by_from = by(piece.from, start);
    piece.by_to = by(piece.to, finish);
    // A rod is a bar, its far end goes with its near one; in a restricted state it passes all but x as it is
    const bool is_bar = model_.is_bar(line);
    const Matrix6 carried = is_bar ? by(piece.from, finish) : piece.by_from;
    // What lies between pins: points inside go across with the start, no piece feels them
    Directions held = line.waves->passed();
    if (piece.index + 1 < count(line)) held |= line.waves->pinned();
    for (Eigen::Index d = 0; d < 6; ++d)
        if (held[as_size(d)]) piece.hold(-carried.row(d).transpose(), piece.by_to.row(d).transpose());
    if (const int frame = piece.from >= 0 ? piece.from : piece.to; is_bar && frame >= 0) {
        const Matrix6 middle = by(frame, 0.5 * (start + finish));
        bar_masses_.push_back({frame, middle.transpose() * bar_mass(line.line.section, piece_length(line)) * middle});
    }
    pieces_.push_back(std::move(piece));
}

Vector3 DynamicStiffness::origin(int frame) const {
    const int own = as_int(model_.frames.size());
    return frame < own ? model_.origin(frame) : points_[as_size(frame - own)].position;
}

// ---- Elimination --------------------------------------------------------------------------------------------------------

/// Bonds, then pieces, then pins: the links of the elimination.
template <class Self>
auto& DynamicStiffness::joined(Self& self, int link) {
    using Part = std::conditional_t<std::is_const_v<Self>, const Joined, Joined>;
    const size_t l = as_size(link), bonds = self.model_.bonds.size(), before = bonds + self.pieces_.size();
    if (l < bonds) return static_cast<Part&>(self.model_.bonds[l]);
    if (l < before) return static_cast<Part&>(self.pieces_[l - bonds]);
    return static_cast<Part&>(self.model_.pins[l - before]);
}

/// Fixes the order of elimination, and strikes out what rigid directions say twice.
void DynamicStiffness::build() {
    for (;;) {
        std::vector<Link> links;
        for (int l = 0; l < link_count(); ++l)
            links.push_back({joined(*this, l).from, joined(*this, l).to, as_int(joined(*this, l).rigid.size())});
        elimination_.emplace(frame_count(), links);
        for (int l = 0; l < link_count(); ++l)
            for (size_t i = 0; i < joined(*this, l).rigid.size(); ++i)
                elimination_->set_rigid(l, as_int(i), joined(*this, l).rigid[i].by_from, joined(*this, l).rigid[i].by_to);

        const auto fault = factor_held();
        if (!fault) return;
        if (fault->too_many)
            refuse(DTTMM_ERROR_MODEL, fault->frame,
                   fmt::format("more than {} rigid directions meet there; give some of them a stiffness",
                               Elimination::kMostRows));
        if (fault->link < 0) refuse_loose(fault->frame, fault->direction);
        // Of rigid directions that say the same one is enough, in small motions
        if (!is_redundant(fault->link, fault->rigid))
            refuse(DTTMM_ERROR_NUMERIC, fault->frame,
                   "the rigid directions that meet there cannot be told apart from rounding; give some of them a stiffness");
        std::vector<Rigid>& rows = joined(*this, fault->link).rigid;
        rows.erase(rows.begin() + fault->rigid);
    }
}

/// With λ < 0 all that moves is held: what is singular then is so at every frequency. Where a line is far softer in one
/// direction than in another its waves are so short there that rounding, or no number, is left; any smaller −λ holds too.
std::optional<Elimination::Fault> DynamicStiffness::factor_held() {
    constexpr double kLess = 1e-3;  // of −λ; which share was not varied
    constexpr int kMostTimes = 4;   // to 1e-15 of the stiffest
    const auto is_finite = [&] {
        for (int f = 0; f < frame_count(); ++f)
            if (!elimination_->diagonal(f).allFinite()) return false;
        return true;
    };
    const double stiff = stiffest();
    double lambda = stiff > 0 ? -1e-3 * stiff : -1;
    for (int times = 0;; ++times, lambda *= kLess) {
        evaluate_waves(lambda, false);
        assemble();
        if (!is_finite() && times < kMostTimes) continue;
        const auto fault = elimination_->factor_counting(kSingular);
        if (!fault || fault->link >= 0 || times == kMostTimes) return fault;
    }
}

void DynamicStiffness::refuse_loose(int frame, int direction) const {
    double own_mass = 0;
    for_each_mass([&](const FrequencyModel::Mass& mass) {
        if (mass.frame == frame) own_mass += std::abs(mass.block(direction, direction));
    });
    const bool ends_beam = std::ranges::any_of(
        pieces_, [&](const Piece& at) { return !model_.is_bar(line(at)) && (at.from == frame || at.to == frame); });
    const char* const name = kDirectionNames[as_size(direction)];
    if (own_mass > 0 || ends_beam)
        refuse(DTTMM_ERROR_NUMERIC, frame,
               fmt::format("its motion in {} (world axes) is lost in rounding: what holds it there, and its mass there, are "
                           "less than 1e-14 of what acts in its other directions; bring the stiffnesses nearer to each "
                           "other, or make the stiffest directions rigid",
                           name));
    refuse(DTTMM_ERROR_MODEL, frame, nothing_determines(direction, "world", true) + ", or leave the direction out of dofs");
}

/// Whether rigid direction number i of a link says what the others, of all links together, say.
bool DynamicStiffness::is_redundant(int link, int i) {
    const Eigen::Index frames = frame_count();
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd own = Eigen::VectorXd::Zero(6 * frames);
    Eigen::Index count = 0;
    for (int l = 0; l < link_count(); ++l) {
        const Joined& at = joined(*this, l);
        for (size_t k = 0; k < at.rigid.size(); ++k) {
            const bool is_own = l == link && as_int(k) == i;
            for (const auto& [frame, by] : {std::pair(at.from, &at.rigid[k].by_from), {at.to, &at.rigid[k].by_to}})
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
    return qr.info() == Eigen::Success && (others * qr.solve(own) - own).norm() <= kRedundant * own.norm();
}

void DynamicStiffness::refuse(dttmm_status status, int frame, const std::string& why) const {
    const size_t f = as_size(frame), own = model_.frames.size();
    if (f < own) throw Error(status, fmt::format("{}: {}", model_.frames[f].name, why), model_.frames[f].element);
    const auto& [position, line] = points_[f - own];
    throw Error(
        status,
        fmt::format("a point of the line at ({:.4g}, {:.4g}, {:.4g}) m: {}", position.x(), position.y(), position.z(), why),
        model_.lines[line].element);
}

void DynamicStiffness::evaluate_waves(double lambda, bool with_mass) {
    lambda_ = lambda;
    const double most = LineWaves::kMargin * asked_for_ * asked_for_;
    const bool may_expand = std::abs(lambda) <= most;
    if (may_expand && std::abs(lambda) > expanded_to_ && ++direct_ > kDirect) {
        for_each_slot([&](size_t slot, const LineWaves& waves, int count, int index) {
            expansions_[slot] = waves.expand(count, most, index);
        });
        expanded_to_ = most;
        direct_ = 0;
    }
    for_each_slot([&](size_t slot, const LineWaves& waves, int count, int index) {
        auto& [stiffness, mass] = waves_[slot];
        if (std::abs(lambda) <= expanded_to_ && expansions_[slot])
            waves.evaluate(*expansions_[slot], lambda, stiffness, with_mass ? &mass : nullptr);
        else
            waves.evaluate<double>(count, lambda, 1, stiffness, with_mass ? &mass : nullptr, index);
    });
}

void DynamicStiffness::assemble() {
    Elimination& e = *elimination_;
    e.set_zero();
    int link = 0;
    const auto add = [&](const Joined& at, const Matrix6& start, const Matrix6& across, const Matrix6& end) {
        if (at.from >= 0) e.add_diagonal(at.from, at.by_from.transpose() * start * at.by_from);
        if (at.to >= 0) e.add_diagonal(at.to, at.by_to.transpose() * end * at.by_to);
        if (at.from >= 0 && at.to >= 0) e.add_coupling(link, at.by_from.transpose() * across * at.by_to);
        ++link;
    };
    for (const Bond& bond : model_.bonds) {
        if (bond.turning) {
            const EndBlocks& K = *bond.turning;
            if (bond.from >= 0) e.add_acting(bond.from, K.at[0][0]);
            if (bond.to >= 0) e.add_acting(bond.to, K.at[1][1]);
            if (bond.from >= 0 && bond.to >= 0) e.add_coupling(link, K.at[0][1]);
        }
        add(bond, bond.stiffness, -bond.stiffness, bond.stiffness);
    }
    for (const Piece& piece : pieces_) {
        const Matrix12& D = waves(piece).stiffness;
        add(piece, D.topLeftCorner<6, 6>(), D.topRightCorner<6, 6>(), D.bottomRightCorner<6, 6>());
    }
    for (const Pin& pin : model_.pins) add(pin, -lambda_ / 3 * pin.mass, -lambda_ / 6 * pin.mass, -lambda_ / 3 * pin.mass);
    for_each_mass([&](const FrequencyModel::Mass& mass) {
        e.add_diagonal(mass.frame, -lambda_ * model_.mask * mass.block * model_.mask);
    });
    for (const FrequencyModel::Lever& lever : model_.levers) e.add_diagonal(lever.frame, lever.stiffness);
    if (!model_.directions.all()) hold_idle();
}

/// Directions left out get a stiffness like that of the others.
void DynamicStiffness::hold_idle() {
    for (int f = 0; f < frame_count(); ++f) {
        Matrix6 idle = Matrix6::Zero();
        const Vector6 sizes = elimination_->diagonal(f).diagonal().cwiseAbs();
        for (Eigen::Index half : {0, 3}) {
            double size = sizes.segment<3>(half).maxCoeff();
            if (size <= kIdleRounding * sizes.maxCoeff()) size = sizes.maxCoeff();
            for (Eigen::Index d = half; d < half + 3; ++d)
                if (!model_.directions[as_size(d)]) idle(d, d) = size > 0 ? size : 1;
        }
        elimination_->add_diagonal(f, idle);
    }
}

std::optional<int> DynamicStiffness::factor(double lambda, bool with_mass) {
    evaluate_waves(lambda, with_mass);
    assemble();
    if (elimination_->factor_counting(0)) return std::nullopt;
    if (elimination_->negatives() == 0) none_below_ = std::max(none_below_, lambda);
    return elimination_->negatives();
}

std::optional<int> DynamicStiffness::count(double lambda) { return lambda <= none_below_ ? 0 : factor(lambda, false); }

bool DynamicStiffness::factor_far_below(double lambda) {
    evaluate_waves(0, true);
    for (Waves& own : waves_) own.stiffness -= lambda * own.mass;
    lambda_ = lambda;
    assemble();
    return !elimination_->factor_counting(0);
}

std::vector<double> DynamicStiffness::solve(FrameVector& r) const {
    for (Vector6& own : r) own = model_.mask * own;
    std::vector<double> q(as_size(elimination_->rigid_count()));
    elimination_->solve(r, q);
    return q;
}

// ---- Products -----------------------------------------------------------------------------------------------------------

FrameVector DynamicStiffness::mass_times(const FrameVector& u, const Vector6& ground, Vector6* on_ground) const {
    FrameVector out(u.size(), Vector6::Zero());
    Vector6 reaction = Vector6::Zero();
    for_each_mass([&](const FrequencyModel::Mass& mass) {
        const auto f = as_size(mass.frame);
        out[f] += model_.mask * (mass.block * (model_.mask * u[f]));
    });
    for (const Pin& pin : model_.pins) reaction += pin.add(momentum_of(pin, pin.ends(u, ground)), out);
    for (const Piece& piece : pieces_) reaction += piece.add(waves(piece).mass * piece.ends(u, ground), out);
    if (on_ground) *on_ground += reaction;
    return out;
}

FrameVector DynamicStiffness::stiffness_times(const FrameVector& u, const Vector6& ground) const {
    FrameVector out(u.size(), Vector6::Zero());
    for_each_mass([&](const FrequencyModel::Mass& mass) {
        const auto f = as_size(mass.frame);
        out[f] -= lambda_ * model_.mask * (mass.block * (model_.mask * u[f]));
    });
    for (const Pin& pin : model_.pins) pin.add(-lambda_ * momentum_of(pin, pin.ends(u, ground)), out);
    for (const FrequencyModel::Lever& lever : model_.levers)
        out[as_size(lever.frame)] += lever.stiffness * u[as_size(lever.frame)];
    for (const Bond& bond : model_.bonds) {
        const Vector12 ends = bond.ends(u, ground);
        const Vector6 force = bond.stiffness * (ends.tail<6>() - ends.head<6>());
        Vector12 forces;
        forces << -force, force;
        bond.add(forces, out);
        if (bond.turning) bond.add_turning(u, out);
    }
    for (const Piece& piece : pieces_) piece.add(waves(piece).stiffness * piece.ends(u, ground), out);
    return out;
}

std::vector<double> DynamicStiffness::openings(const FrameVector& u) const {
    std::vector<double> all;
    for (int l = 0; l < link_count(); ++l) {
        const Joined& at = joined(*this, l);
        for (const Rigid& row : at.rigid)
            all.push_back((at.from < 0 ? 0 : row.by_from.dot(u[as_size(at.from)])) +
                          (at.to < 0 ? 0 : row.by_to.dot(u[as_size(at.to)])));
    }
    return all;
}

std::vector<std::pair<int, int>> DynamicStiffness::rigid_rows() const {
    std::vector<std::pair<int, int>> all;
    for (int l = 0; l < link_count(); ++l)
        for (const Rigid& row : joined(*this, l).rigid) all.emplace_back(l, row.number);
    return all;
}

DynamicStiffness::Whole DynamicStiffness::move_whole(int direction) const {
    const Vector6 ground = model_.mask.col(direction);
    Vector6 on_ground = Vector6::Zero();
    Whole whole;
    for (int f = 0; f < frame_count(); ++f)
        whole.motion.push_back(model_.masked_at(origin(f), Vector3::Zero()).col(direction));
    whole.forces = stiffness_times(whole.motion, ground);
    whole.momenta = mass_times(whole.motion, ground, &on_ground);
    whole.mass = dot(whole.motion, whole.momenta) + ground.dot(on_ground);
    return whole;
}

double DynamicStiffness::stiffest() const {
    double largest = 0;
    for (const Bond& bond : model_.bonds) largest = std::max(largest, bond.stiffness.diagonal().head<3>().maxCoeff());
    for (const LineModel& line : model_.lines) largest = std::max(largest, line.line.section.EA / piece_length(line));
    if (largest == 0)  // what hangs or stands on joints, and turns against springs
        return std::max(model_.stiffest_turning(), model_.stiffest_hinge());
    return model_.total_mass > 0 ? largest / model_.total_mass : 0;
}

}  // namespace dttmm::plugin
