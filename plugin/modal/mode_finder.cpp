// SPDX-License-Identifier: BSD-3-Clause
#include "modal/mode_finder.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Rounding of a rigid-body mode, as share of the largest stiffness over the whole mass.
constexpr double kRigidRounding = 1e-12;
/// Of the range looked at: lower frequencies are taken for zero.
constexpr double kLowest = 1e-7;
/// Strain of a rigid-body mode: of lines, whose D is a difference of large numbers, as share of the rounding above (0.4 in a
/// few thousand random trees); of joints, whose ends are subtracted, as share of λ where the count begins. More is a mode
/// too slow to be counted.
constexpr double kLineStrain = 2, kJointStrain = 1e-6;
/// Frequencies so near each other count as equal, unless the count can tell them apart.
constexpr double kEqual = 2e-9;
/// Of λ: how near inverse iteration comes at first, and at last.
constexpr double kRough = 1e-7, kFine = 1e-12;
/// Wider than this the shapes of a group are not looked for yet: high/low of an interval.
constexpr double kNarrow = 1.3;
constexpr double kFinestBracket = 2.5e-11, kWidestBracket = 1e-5;
/// Lines are cut for so much more than is asked, and a frequency that is the upper limit itself belongs to the range.
constexpr double kAhead = 1.01, kUpTo = 1e-7;
/// Where the search for the first few begins, and where a model of finitely many masses has no more [rad/s].
constexpr double kFirstTrial = 2 * M_PI, kFastest = 1e12;
/// Without a range to measure it by: slower is rigid [rad/s].
constexpr double kSlowest = 1e-6;

/// A displacement (or another linear measure) of every shape of a group, and what decides between equal ones.
struct Measure {
    Eigen::VectorXd values;
    int direction;
    Vector3 position;
};

/// Whether `a` comes before `b` where both are as large: by direction, then by place, to `grain` [m].
bool comes_first(const Measure& a, const Measure& b, double grain) {
    if (a.direction != b.direction) return a.direction < b.direction;
    for (Eigen::Index i = 0; i < 3; ++i)
        if (std::abs(a.position(i) - b.position(i)) > grain) return a.position(i) < b.position(i);
    return false;
}

/// The measure in which a shape of unit norm can be largest; of displacements if there are any, else of rotations.
const Measure* find_largest(const std::vector<Measure>& measures, double grain) {
    constexpr double kNone = 1e-6;  // displacement beside rotation, per metre: rounding of shapes is well below
    constexpr double kTie = 1e-6;   // two that differ by less are equal: shapes are found to 1e-7 or better
    double most[2] = {0, 0};
    for (const Measure& m : measures) most[m.direction / 3] = std::max(most[m.direction / 3], m.values.norm());
    const int kind = most[0] > kNone * most[1] ? 0 : 1;
    const Measure* best = nullptr;
    for (const Measure& m : measures)
        if (m.direction / 3 == kind && m.values.norm() >= (1 - kTie) * most[kind] && m.values.norm() > 0)
            if (!best || comes_first(m, *best, grain)) best = &m;
    return best;
}

}  // namespace

/// Cuts the lines for a frequency unless they are.
void ModeFinder::cut_for(double omega) {
    if (omega <= cut_ && (cut_ < 2 * omega || stiffness_.model().lines.empty())) return;
    stiffness_.cut(kAhead * omega);
    cut_ = kAhead * omega;
}

/// What rounding makes of λ = 0 [1/s²].
double ModeFinder::rounding() const { return kRigidRounding * stiffness_.stiffest(); }

double ModeFinder::lowest_for(double below) const { return std::max(std::sqrt(rounding()), kLowest * below); }

/// A frequency hit to rounding has no count: a little beside it there is one.
int ModeFinder::count_at(double& omega) {
    cut_for(omega);
    for (const double shift : {0.0, 1e-10, 3e-10, 1e-9, 3e-9, 1e-8}) {
        const double beside = omega * (1 + shift);
        if (const auto count = stiffness_.factor(beside * beside, false); count && *count >= 0) {
            omega = beside;
            return *count;
        }
    }
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("the natural frequencies near {:.9g} Hz cannot be counted", omega / (2 * M_PI)));
}

std::vector<Mode> ModeFinder::find_below(double below) {
    below *= 1 + kUpTo;
    cut_for(below);
    lowest_ = lowest_for(below);
    if (lowest_ >= below)
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("below {:.4g} Hz rounding hides everything: its stiffest parts vibrate too much faster",
                                lowest_ / (2 * M_PI)));
    const int until = count_at(below), rigid = count_at(lowest_);
    find_rigid(rigid);
    separate({lowest_, below, rigid, until});
    if (as_int(modes_.size()) != until)
        throw Error(DTTMM_ERROR_NUMERIC, fmt::format("{} natural frequencies were counted below {:.9g} Hz, {} were found",
                                                     until, below / (2 * M_PI), modes_.size()));
    return finish();
}

std::vector<Mode> ModeFinder::find_first(int count) {
    // How far to look: no farther than needed. Masses without lines between them have only so many
    double below = 0;
    int most = -1;
    for (double trial = kFirstTrial; most < count && trial < kFastest; trial *= 4) {
        double counted = trial;
        cut_for(trial);
        const int there = lowest_for(trial) < trial ? count_at(counted) : 0;
        if (there <= most) continue;
        most = there;
        below = trial;
    }
    double low = below / 4;
    while (below > 1.1 * low) {
        double middle = std::sqrt(low * below);
        if (middle > lowest_for(middle) && count_at(middle) >= std::min(count, most))
            below = middle;
        else
            low = middle;
    }
    std::vector<Mode> modes = find_below(below);
    if (as_int(modes.size()) < std::min(count, most))
        throw Error(
            DTTMM_ERROR_NUMERIC,
            fmt::format("below {:.4g} Hz {} natural frequencies were counted first and {} then: rounding of the stiffest "
                        "parts hides them; join short ones, or make them rigid",
                        below / (2 * M_PI), std::min(count, most), modes.size()));
    const auto is_equal = [](const Mode& a, const Mode& b) { return std::abs(a.omega - b.omega) <= kEqual * a.omega; };
    size_t keep = std::min(modes.size(), as_size(count));
    while (keep > 0 && keep < modes.size() && is_equal(modes[keep - 1], modes[keep])) ++keep;
    modes.resize(keep);
    return modes;
}

int ModeFinder::count_rigid() {
    cut_for(kSlowest);
    double lowest = std::max(lowest_for(0), kSlowest);
    return count_at(lowest);
}

FrameVector ModeFinder::random_motion() {
    FrameVector motion(as_size(stiffness_.frame_count()));
    for (Vector6& u : motion)
        for (double& x : u) {
            seed_ = seed_ * 6364136223846793005u + 1442695040888963407u;
            x = static_cast<double>(seed_ >> 11) * 0x1p-53 - 0.5;
        }
    return motion;
}

/// Inverse iteration on a group of shapes at a shift, and what their span says of the frequencies next to it: λ, ascending.
/// The shapes are then these, of unit modal mass.
std::vector<double> ModeFinder::iterate(std::vector<FrameVector>& shapes, double lambda, int rounds) {
    const auto n = as_row(shapes.size());
    if (!stiffness_.factor(lambda)) return {};
    Eigen::MatrixXd A(n, n), B(n, n);
    std::vector<double> lambdas(shapes.size());
    for (int round = 0; round < rounds; ++round) {
        std::vector<FrameVector> loads, masses;
        for (FrameVector& shape : shapes) {
            loads.push_back(stiffness_.mass_times(shape));
            shape = loads.back();
            stiffness_.solve(shape);
            // Overflow and underflow have nothing to do with shapes
            double largest = 0;
            for (const Vector6& u : shape) largest = std::max(largest, u.cwiseAbs().maxCoeff());
            if (!(largest > 0) || !std::isfinite(largest)) return {};
            for (Vector6& u : shape) u /= largest;
            for (Vector6& r : loads.back()) r /= largest;
            masses.push_back(stiffness_.mass_times(shape));
        }
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j < n; ++j) {
                A(i, j) = dot(shapes[as_size(i)], loads[as_size(j)]);
                B(i, j) = dot(shapes[as_size(i)], masses[as_size(j)]);
            }
        // In units in which every shape has unit mass
        const Eigen::VectorXd unit = B.diagonal().cwiseSqrt().cwiseInverse();
        if (!unit.allFinite()) return {};
        const Eigen::MatrixXd scaled_a = unit.asDiagonal() * (0.5 * (A + A.transpose())) * unit.asDiagonal();
        const Eigen::MatrixXd scaled_b = unit.asDiagonal() * (0.5 * (B + B.transpose())) * unit.asDiagonal();
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(scaled_a, scaled_b);
        if (ritz.info() != Eigen::Success || !ritz.eigenvectors().allFinite()) return {};
        const Eigen::MatrixXd mix = unit.asDiagonal() * ritz.eigenvectors();
        std::vector<FrameVector> mixed(shapes.size(), FrameVector(shapes.front().size(), Vector6::Zero()));
        for (Eigen::Index j = 0; j < n; ++j)
            for (Eigen::Index i = 0; i < n; ++i)
                for (size_t f = 0; f < shapes.front().size(); ++f) mixed[as_size(j)][f] += mix(i, j) * shapes[as_size(i)][f];
        shapes = std::move(mixed);
        for (Eigen::Index i = 0; i < n; ++i) lambdas[as_size(i)] = lambda + ritz.eigenvalues()(i);
    }
    return lambdas;
}

void ModeFinder::find_rigid(int count) {
    if (count == 0) return;
    std::vector<FrameVector> shapes;
    for (int i = 0; i < count; ++i) shapes.push_back(random_motion());
    const double shift = -10 * lowest_ * lowest_;  // all is held there
    if (!stiffness_.model().levers.empty()) stiffness_.refuse_growing(shift);
    // What slow modes leave in the shapes falls by shift/(shift + λ) per round: until nothing is strained any more, to
    // rounding
    double lambda = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < 40; ++pass) {
        if (iterate(shapes, shift, 4).empty())
            throw Error(DTTMM_ERROR_NUMERIC, "the shapes of the rigid-body modes were not found");
        double strained = 0;
        for (const FrameVector& shape : shapes) strained = std::max(strained, strain_quotient(stiffness_, shape).lambda);
        const bool stands = strained > 0.5 * lambda;
        lambda = std::min(lambda, strained);
        if (stands) break;
    }
    if (lambda > (!stiffness_.model().lines.empty() ? kLineStrain * rounding() : kJointStrain * lowest_ * lowest_))
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("there is a natural frequency at about {:.3g} Hz, below {:.3g} Hz where rounding hides what "
                                "is counted: make the stiffest parts rigid, or ask for lower frequencies",
                                std::sqrt(lambda) / (2 * M_PI), lowest_ / (2 * M_PI)));
    add({std::vector<double>(shapes.size(), 0.0), shapes}, 0);
}

/// Splits an interval by counts until its group of frequencies can be refined.
void ModeFinder::separate(Interval interval) {
    while (interval.until > interval.before) {
        if (interval.high <= kNarrow * interval.low && refine(interval)) return;
        if (interval.high - interval.low < kEqual * interval.low) {
            const int number = interval.until - interval.before;
            throw Error(
                DTTMM_ERROR_NUMERIC,
                fmt::format("{} natural {} at {:.9g} Hz could be counted but not confirmed: rounding of the stiffest "
                            "parts hides {}",
                            number, number == 1 ? "frequency" : "frequencies", interval.low / (2 * M_PI),
                            number == 1 ? "it" : "them"));
        }
        const bool is_wide = interval.high > 2 * interval.low;
        double middle = is_wide ? std::sqrt(interval.low * interval.high) : 0.5 * (interval.low + interval.high);
        const int count = count_at(middle);
        if (count < interval.before || count > interval.until)
            throw Error(
                DTTMM_ERROR_NUMERIC,
                fmt::format("the count of natural frequencies near {:.9g} Hz is lost in rounding", middle / (2 * M_PI)));
        separate({interval.low, middle, interval.before, count});
        interval = {middle, interval.high, count, interval.until};
    }
}

bool ModeFinder::refine(const Interval& interval) {
    cut_for(interval.high);
    std::vector<FrameVector> shapes;
    for (int i = interval.before; i < interval.until; ++i) shapes.push_back(random_motion());
    const double middle = 0.5 * (interval.low + interval.high);
    const std::vector<double> lambdas = iterate(shapes, middle * middle, 4);
    if (lambdas.empty()) return false;
    std::vector<Cluster> clusters;
    for (size_t k = 0; k < lambdas.size(); ++k) {
        const double omega = std::sqrt(std::max(lambdas[k], 0.0));
        if (!(omega >= interval.low * 0.99 && omega <= interval.high * 1.01)) return false;
        if (clusters.empty() || lambdas[k] > clusters.back().lambdas.back() * (1 + 1e-4)) clusters.emplace_back();
        clusters.back().lambdas.push_back(lambdas[k]);
        clusters.back().shapes.push_back(shapes[k]);
        clusters.back().cuts = stiffness_.cuts();
    }
    for (Cluster& cluster : clusters)
        if (!converge(cluster, !stiffness_.model().lines.empty() ? kRough : kFine)) return false;
    const size_t known = modes_.size();
    int before = interval.before;
    for (Cluster& cluster : clusters) {
        double bracket = 0;
        if (!settle(cluster) || !confirm(cluster, before, bracket)) {
            modes_.resize(known);
            return false;
        }
        stiffness_.factor(cluster.lambdas.front());
        add(cluster, std::max(bracket, lost_in_rounding(cluster)));
        before += as_int(cluster.shapes.size());
    }
    return true;
}

/// Inverse iteration with the shift next to the cluster until its frequencies stand.
bool ModeFinder::converge(Cluster& cluster, double tolerance) {
    std::vector<double> before = cluster.lambdas;
    for (int pass = 0; pass < 8; ++pass) {
        const double mean = 0.5 * (before.front() + before.back());
        std::vector<double> next = iterate(cluster.shapes, mean * (1 + 1e-9), 2);
        if (next.empty()) next = iterate(cluster.shapes, mean * (1 + 1e-7), 2);
        if (next.empty() || !(next.front() > 0)) return false;
        double change = 0;
        for (size_t k = 0; k < next.size(); ++k) change = std::max(change, std::abs(next[k] - before[k]) / next[k]);
        before = next;
        if (change < tolerance || (pass > 2 && change < 100 * tolerance)) break;
    }
    cluster.lambdas = before;
    return cluster.lambdas.back() <= cluster.lambdas.front() * (1 + 2 * kEqual);
}

/// Once more with the lines cut for this frequency alone, however far the search reaches.
bool ModeFinder::settle(Cluster& cluster) {
    const double omega = std::sqrt(cluster.lambdas.back());
    if (stiffness_.model().lines.empty()) return true;
    cut_ = kAhead * omega;
    stiffness_.cut(cut_);
    if (stiffness_.cuts() == cluster.cuts) return converge(cluster, kFine);
    for (FrameVector& shape : cluster.shapes) shape = random_motion();
    const double beside = omega * (1 + 1e-8);
    if (iterate(cluster.shapes, beside * beside, 3).empty()) return false;
    return converge(cluster, kFine);
}

/// The count on both sides of a cluster, as near as it can tell.
bool ModeFinder::confirm(const Cluster& cluster, int before, double& bracket) {
    const int until = before + as_int(cluster.shapes.size());
    for (bracket = kFinestBracket; bracket <= kWidestBracket; bracket *= 4) {
        const double low = std::sqrt(cluster.lambdas.front()) * (1 - bracket);
        const double high = std::sqrt(cluster.lambdas.back()) * (1 + bracket);
        if (stiffness_.factor(low * low, false) == before && stiffness_.factor(high * high, false) == until) return true;
    }
    return false;
}

/// What the strain energies of the shapes make of the frequencies, as share of these. The dynamic stiffness of a long chain
/// of short stiff parts loses small frequencies in its last digits, and count and iteration agree on what is left; energies
/// of deformations do not. Throws Error(DTTMM_ERROR_NUMERIC) if that is too much. The model stands at the cluster.
double ModeFinder::lost_in_rounding(const Cluster& cluster) const {
    double lost = 0;  // of λ; of ω it is half
    for (size_t k = 0; k < cluster.shapes.size(); ++k) {
        const Quotient quotient = strain_quotient(stiffness_, cluster.shapes[k]);
        lost = std::max(lost, (std::abs(quotient.lambda - cluster.lambdas[k]) + quotient.unsure) / cluster.lambdas[k]);
    }
    if (lost > kWidestBracket)
        throw Error(
            DTTMM_ERROR_NUMERIC,
            fmt::format("a natural frequency at {:.6g} Hz is told to {:.1e} of itself only: rounding of the stiffest "
                        "parts hides it; join short ones, or make them rigid",
                        std::sqrt(cluster.lambdas.front()) / (2 * M_PI), lost));
    return lost;
}

/// Mixes shapes of equal frequencies to the basis that the header describes; the model stands at them.
void ModeFinder::fix_basis(std::vector<FrameVector>& shapes, bool is_rigid) const {
    for (FrameVector& shape : shapes) {
        const double unit = 1 / std::sqrt(dot(shape, stiffness_.mass_times(shape)));
        if (!std::isfinite(unit)) return;
        for (Vector6& u : shape) u *= unit;
    }
    const auto n = as_row(shapes.size());
    std::vector<Measure> measures, whole;
    double size = 0;
    for (Eigen::Index j = 0; j < n; ++j) {
        const std::vector<Station> list = stations(stiffness_, shapes[as_size(j)]);
        measures.resize(6 * list.size());
        for (size_t i = 0; i < measures.size(); ++i) {
            const Station& station = list[i / 6];
            if (j == 0) measures[i] = {Eigen::VectorXd(n), as_int(i % 6), station.position};
            measures[i].values(j) = station.motion(as_row(i % 6));
            size = std::max(size, station.position.norm());
        }
    }
    for (int d = 0; d < 6 && is_rigid; ++d) {  // momentum of the machine as a whole
        const DynamicStiffness::Whole moved = stiffness_.move_whole(d);
        Measure measure{Eigen::VectorXd(n), d, Vector3::Zero()};
        for (Eigen::Index j = 0; j < n; ++j)
            measure.values(j) = moved.mass > 0 ? dot(shapes[as_size(j)], moved.momenta) / std::sqrt(moved.mass) : 0;
        whole.push_back(measure);
    }
    // Each measure is largest for the shape along it; the rest of the measures is what shapes at right angles can do
    Eigen::MatrixXd mix = Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
        constexpr double kLeft = 1e-4;  // share of the whole that is still free to move as one
        const Measure* chosen = nullptr;
        for (const Measure& m : whole)
            if (!chosen && m.values.norm() > kLeft) chosen = &m;
        if (!chosen) chosen = find_largest(measures, 1e-9 * size);
        const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(n, n) - mix.leftCols(k) * mix.leftCols(k).transpose();
        Eigen::Index any = 0;  // where no point moves: what is left the most
        rest.diagonal().maxCoeff(&any);
        mix.col(k) = (chosen ? Eigen::VectorXd(rest * chosen->values.normalized()) : rest.col(any)).normalized();
        for (auto* list : {&measures, &whole})
            for (Measure& m : *list) m.values -= m.values.dot(mix.col(k)) * mix.col(k);
    }
    std::vector<FrameVector> mixed(shapes.size(), FrameVector(shapes.front().size(), Vector6::Zero()));
    for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index i = 0; i < n; ++i)
            for (size_t f = 0; f < shapes.front().size(); ++f) mixed[as_size(j)][f] += mix(i, j) * shapes[as_size(i)][f];
    shapes = std::move(mixed);
}

/// Takes shapes of equal frequencies into the list; the model stands at them.
void ModeFinder::add(Cluster cluster, double bracket) {
    fix_basis(cluster.shapes, cluster.lambdas.front() == 0);
    for (size_t k = 0; k < cluster.shapes.size(); ++k) {
        Mode mode;
        mode.omega = std::sqrt(cluster.lambdas[k]);
        mode.bracket = bracket;
        mode.multiplicity = as_int(cluster.shapes.size());
        mode.shape = cluster.shapes[k];
        mode.cut = cut_;
        const auto [most, turn] = largest(stiffness_, mode.shape);
        // A shape is scaled by its largest displacement, one that only turns by its rotation
        const double scale = 1 / (most > 1e-9 * turn ? most : turn);
        for (Vector6& u : mode.shape) u *= scale;
        mode.mass = dot(mode.shape, stiffness_.mass_times(mode.shape));
        const double inertial = mode.omega * mode.omega * mode.mass;
        if (inertial > 0) mode.residual = std::abs(dot(mode.shape, stiffness_.stiffness_times(mode.shape))) / inertial;
        modes_.push_back(std::move(mode));
    }
}

std::vector<Mode> ModeFinder::finish() {
    std::ranges::stable_sort(modes_, {}, &Mode::omega);
    // Shares of what moves as a whole. Of two motions φ at λ and r at 0 the mass between them is −φᵀ (D(λ) − D(0)) r / λ
    std::vector<DynamicStiffness::Whole> at_rest, whole;
    const auto move_whole = [&] {
        std::vector<DynamicStiffness::Whole> all;
        for (int d = 0; d < 6; ++d) all.push_back(stiffness_.move_whole(d));
        return all;
    };
    double cut = 0, lambda = 0;
    for (Mode& mode : modes_) {
        if (mode.cut != cut) {
            stiffness_.cut(mode.cut);
            cut_ = cut = mode.cut;
            lambda = 0;
            stiffness_.factor(0);
            at_rest = whole = move_whole();
        }
        if (mode.omega > 0 && mode.omega * mode.omega != lambda) {
            lambda = mode.omega * mode.omega;
            stiffness_.factor(lambda);
            whole = move_whole();
        }
        for (int d = 0; d < 6; ++d) {
            const auto i = as_size(d);
            const double moved = mode.omega > 0
                                     ? (dot(mode.shape, at_rest[i].forces) - dot(mode.shape, whole[i].forces)) / lambda
                                     : dot(mode.shape, at_rest[i].momenta);
            mode.participation(d) = at_rest[i].mass > 0 ? moved * moved / (mode.mass * at_rest[i].mass) : 0;
        }
    }
    return std::move(modes_);
}

}  // namespace dttmm::plugin
