// SPDX-License-Identifier: BSD-3-Clause
#include "modal/mode_finder.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "modal/shape_basis.h"

namespace dttmm::plugin {

namespace {

// What decides the search. Range: at its ends the tests of modal/ pass and all examples keep their frequencies to 1e-11.
// "None fails": no test bounds it there.
/// Rounding of a rigid-body mode's λ, as share of the largest stiffness over the whole mass. Range 1e-13 (below it
/// RandomTrees) to 2e-12 (above it ASlowSpringIsNoRigidBodyMode).
constexpr double kRigidRounding = 1e-12;
/// What rounding makes of the difference between equal λ, of the same share: the count around them is their proof. Range
/// 5e-16 (with none ALineUnderItsOwnWeight fails) to 1e-10, none fails.
constexpr double kSplit = 1e-14;
/// Of the range looked at: lower frequencies are taken for zero, as rounding splits equal ones by their λ. Range 1e-9 or
/// less to 2e-7 (ASlowSpringIsNoRigidBodyMode).
const double kLowest = std::sqrt(kSplit);
/// Strain of a rigid-body mode beyond its rounding, as share of λ where the count begins. More is a mode too slow to be
/// counted. Range 1e-5 (below it RandomTrees) to 1e-3 (above it ASlowSpringIsNoRigidBodyMode).
constexpr double kStrain = 1e-4;
/// Frequencies so near each other count as equal, unless the count can tell them apart. Range 2e-11 to 2e-7, none fails.
constexpr double kEqual = 2e-9;
/// Beside a frequency: there D can be factored, and inside an interval of kEqual.
constexpr double kBeside = 0.25 * kEqual;
/// Of ω: the narrowest interval in which a mode is confirmed by counts, and the widest; λ of a group of modes that are
/// refined together lie nearer than that. Range 2.5e-13 to 2.5e-9, none fails; 1e-6 (below it RandomTrees) to 1e-3, none
/// fails.
constexpr double kFinestBracket = 2.5e-11, kWidestBracket = 1e-5;
/// The same where forces at rest may bring a frequency near to zero. Of 864 columns near their critical loads 52 are refused
/// with 1e-5, 8 with 1e-4, 5 with 1e-2; 39 known to 6e-5 or less lie where their neighbours lead to, to 1 % of ω².
constexpr double kWidestAtRest = 1e-4;
/// Of √rounding: what rounding makes of spins with little inertia reaches so far at most. At 64 three tests of Trusses fail,
/// from 256 to 2048 none.
constexpr double kMostNoise = 1024;
/// Not of more motions: the shapes of 90 may take 3 s. No test bounds it.
constexpr int kMostShapes = 100;
/// Where the search for the first few begins, and where a model of finitely many masses has no more [rad/s]. Range 0.06 to
/// 600 and 1e10 to 1e14, none fails.
constexpr double kFirstTrial = 2 * M_PI, kFastest = 1e12;
/// By so much a search widens at a time. Range 2 to 8 (above it ASlowSpringIsNoRigidBodyMode). Modes slower than its square
/// times √rounding are not known to kWidestBracket: 3 to 6 were measured at a column near Euler's load.
constexpr double kWiden = 4;
/// high/low of an interval in whose middle the shapes of its modes are looked for. Range 1.05 or less to 1.3 (at 1.41
/// ABeamBetweenTwoPointsOfOneRigidBody: pieces cut for another ω show another largest displacement).
constexpr double kNarrow = 1.3;
/// Of inverse iteration with one factor, range 2 (below it ASlowSpringIsNoRigidBodyMode) to 8, none fails. And of Newton's
/// iteration, which converges quadratically: after a correction of √ε of λ the next one is rounding. Where that is larger it
/// is stopped after so many passes, and the bracket has the remaining error. Range 4 to 16, none fails.
constexpr int kMostPasses = 5;
const double kConverged = std::sqrt(std::numeric_limits<double>::epsilon());

double hertz(double omega) { return omega / (2 * M_PI); }

}  // namespace

/// What rounding makes of λ = 0 [1/s²].
double ModeFinder::rounding() const { return kRigidRounding * stiffness_.stiffest(); }

/// What else helps a machine at rest: forces cancel all but some rounding of its stiffness there.
std::string ModeFinder::of_load() const {
    if (!stiffness_.model().is_at_rest) return "";
    return ", or change the load a little where it is near a critical one: there a frequency goes through zero";
}

double ModeFinder::lowest_for(double below) {
    const double base = std::sqrt(rounding());
    return std::max({base, quiet(), kLowest * below});
}

/// Where counts begin to hold. By another finder: frequencies do not hang on what it has looked at. [after cut()]
double ModeFinder::quiet() {
    if (!quiet_) quiet_ = ModeFinder(stiffness_).look_for_noise(std::sqrt(rounding()));
    return *quiet_;
}

/// The spin of a thin rod between joints has so little inertia that rounding makes more of its λ than rounding() says. Where
/// nothing that is counted far above is strained, what counts say below there is noise.
double ModeFinder::look_for_noise(double base) {
    if (base == 0) return base;
    const auto count = [&](double omega) {
        try {
            return count_at(omega);
        } catch (const Error&) {
            return -1;
        }
    };
    const double far = base * kMostNoise;
    const int above = count(far);
    if (above <= 0 || above > kMostShapes) return base;
    bool differ = stiffness_.count(-kWiden * base * base) != 0;
    for (double probe = far / kWiden; probe >= base && !differ; probe /= kWiden) differ = count(probe) != above;
    return differ && are_free(above, far) ? far : base;
}

/// Whether so many motions below a frequency are strained by no more than rounding.
bool ModeFinder::are_free(int count, double probe) {
    std::vector<FrameVector> shapes = random_shapes(as_size(count));
    try {
        const double most = stiffness_.model().is_at_rest ? kWiden * kWiden : kStrain;
        return iterate_free(shapes, -kWiden * probe * probe).surely <= most * rounding();
    } catch (const Error&) {
        return false;
    }
}

/// A frequency hit to rounding has no count: a little beside it there is one.
int ModeFinder::count_at(double omega) {
    if (const auto known = counts_.find(omega); known != counts_.end()) return known->second;
    stiffness_.cut(omega);
    for (const double at : {omega, omega * (1 + kBeside)})
        if (const auto count = count_beside(at * at); count && *count >= 0) return counts_[at] = *count;
    throw Error(DTTMM_ERROR_NUMERIC,
                fmt::format("the natural frequencies near {:.9g} Hz cannot be counted: rounding of the stiffest parts hides "
                            "them. Make these parts rigid{}",
                            hertz(omega), of_load()));
}

/// Natural frequencies with ω² below λ, motions that grow among them; of those alone with sign_ = −1.
std::optional<int> ModeFinder::count_beside(double lambda) {
    const std::optional<int> count = stiffness_.count(sign_ * lambda);
    return sign_ > 0 || !count ? count : growing_ - *count;
}

/// iterate() in terms of ω².
std::vector<double> ModeFinder::approach(std::vector<FrameVector>& shapes, double lambda) {
    std::vector<double> lambdas = iterate(shapes, sign_ * lambda);
    if (sign_ > 0) return lambdas;
    for (double& own : lambdas) own = -own;
    std::ranges::reverse(lambdas);
    std::ranges::reverse(shapes);
    return lambdas;
}

std::vector<Mode> ModeFinder::find_below(double below) {
    find_until(below * (1 + kEqual), std::numeric_limits<size_t>::max());
    return std::move(modes_);
}

std::vector<Mode> ModeFinder::find_first(int count) {
    // How far to look. Masses without lines between them have only so many
    double below = kFirstTrial;
    int most = -1;
    for (double trial = kFirstTrial; most < count && trial < kFastest; trial *= kWiden) {
        stiffness_.cut(trial);
        if (const int there = lowest_for(trial) < trial ? count_at(trial) : 0; there > most) {
            most = there;
            below = trial;
        }
    }
    find_until(below, as_size(count));
    const auto is_equal = [](const Mode& a, const Mode& b) { return std::abs(a.omega - b.omega) <= kEqual * a.omega; };
    size_t keep = std::min(modes_.size(), as_size(count));
    while (keep > 0 && keep < modes_.size() && is_equal(modes_[keep - 1], modes_[keep])) ++keep;
    modes_.resize(keep);
    return std::move(modes_);
}

int ModeFinder::count_growing(int slack) {
    stiffness_.cut(0);
    if (stiffness_.model().total_mass == 0) return stiffness_.count(0).value_or(0);  // the same at any λ
    if (stiffness_.stiffest() == 0) return 0;
    const double lowest = slack == 0 ? lowest_for(0) : 0;
    stiffness_.cut(0);
    const double shift = slack == 1 ? 0 : slack == 0 ? -kWiden * lowest * lowest : -slack * rounding();
    // An eigenvalue hit to rounding has no count; beside it, by what rounding may make of one, there is one
    for (const double at : {shift, shift - rounding()})
        if (const auto count = stiffness_.count(at)) return *count;
    throw Error(DTTMM_ERROR_NUMERIC, "the motions that grow cannot be counted");
}

void ModeFinder::refuse_growing() { refuse(count_growing(0)); }

void ModeFinder::refuse(int growing) const {
    if (growing == 0) return;
    throw Error(DTTMM_ERROR_MODEL, fmt::format("{} of its motions would grow, not vibrate: {}", growing,
                                               stiffness_.model().is_at_rest
                                                   ? "its equilibrium is unstable"
                                                   : "the forces of its springs at the start drive it away from there"));
}

/// Where nothing is stiff, all that has a mass is free.
int ModeFinder::count_free() {
    stiffness_.cut(0);
    if (stiffness_.model().total_mass == 0) return 0;
    if (stiffness_.stiffest() == 0) return stiffness_.count(1).value_or(0);
    // First: where nothing is free, nothing grows
    const int rigid = count_rigid(), free = rigid - count_growing(0);
    if (free < 0) throw Error(DTTMM_ERROR_NUMERIC, "the motions that nothing holds cannot be counted");
    return free;
}

int ModeFinder::count_rigid() {
    stiffness_.cut(0);
    return count_at(lowest_for(0));
}

/// From interval to interval between frequencies at which they are counted, until there are so many.
void ModeFinder::find_until(double below, size_t wanted) {
    stiffness_.cut(below);
    const double lowest = lowest_for(below);
    if (lowest >= below)
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("below {:.4g} Hz rounding hides everything: its stiffest parts vibrate too much faster",
                                hertz(lowest)));
    count_at(below);
    const int rigid = count_at(lowest);
    counts_.erase(counts_.begin(), counts_.lower_bound(lowest));
    counts_.erase(counts_.upper_bound(below * (1 + kBeside)), counts_.end());
    if (stiffness_.model().is_at_rest) {
        std::map<double, int> counts;
        counts.swap(counts_);
        find_growing(lowest);
        counts.swap(counts_);
    }
    find_rigid(rigid - growing_, lowest);
    find_between(wanted);
}

/// Motions of a machine at rest that grow, the fastest first.
void ModeFinder::find_growing(double lowest) {
    growing_ = stiffness_.count(-kWiden * lowest * lowest).value_or(0);
    if (growing_ == 0) return;
    sign_ = -1;
    counts_[lowest * std::sqrt(kWiden)] = 0;
    for (double trial = std::max(kFirstTrial, lowest * kWiden); trial < kFastest; trial *= kWiden)
        if (count_at(trial) == growing_) break;
    find_between(std::numeric_limits<size_t>::max());
    sign_ = 1;
    if (as_int(modes_.size()) != growing_)
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("{} motions grow, of which {} could be found", growing_, modes_.size()));
    std::ranges::reverse(modes_);
}

/// From count to count.
void ModeFinder::find_between(size_t wanted) {
    for (auto low = counts_.begin(); std::next(low) != counts_.end() && modes_.size() < wanted;) {
        const auto high = std::next(low);
        const Interval interval{low->first, high->first, low->second, high->second};
        const bool is_narrow = interval.high <= kNarrow * interval.low;
        if (interval.until == interval.before || (is_narrow && refine(interval)))
            low = high;
        else
            split(interval);
    }
}

void ModeFinder::split(const Interval& interval) {
    if (interval.high - interval.low < kEqual * interval.low) {
        const int number = interval.until - interval.before;
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("{} natural {} at {:.9g} Hz could be counted but not confirmed: rounding of the stiffest "
                                "parts hides {}. Make these parts rigid{}",
                                number, number == 1 ? "frequency" : "frequencies", hertz(interval.low),
                                number == 1 ? "it" : "them", of_load()));
    }
    const double middle = std::sqrt(interval.low * interval.high);
    const int count = count_at(middle);
    if (count < interval.before || count > interval.until)
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("the count of natural frequencies near {:.9g} Hz is lost in rounding", hertz(middle)));
}

std::vector<FrameVector> ModeFinder::random_shapes(size_t count) {
    std::vector<FrameVector> shapes(count, FrameVector(as_size(stiffness_.frame_count())));
    for (FrameVector& shape : shapes)
        for (Vector6& u : shape)
            for (double& x : u) {
                seed_ = seed_ * 6364136223846793005u + 1442695040888963407u;
                x = static_cast<double>(seed_ >> 11) * 0x1p-53 - 0.5;
            }
    return shapes;
}

/// Inverse iteration on a group of shapes at a shift, and what their span says of the frequencies next to it: λ, ascending.
/// The shapes are then these, of unit modal mass. Nothing: they cannot be distinguished there.
std::vector<double> ModeFinder::iterate(std::vector<FrameVector>& shapes, double lambda) {
    const auto n = as_row(shapes.size());
    if (!stiffness_.factor(lambda)) return {};
    Eigen::MatrixXd A(n, n), B(n, n);
    std::vector<double> lambdas(shapes.size());
    for (int round = 0; round < kMostPasses; ++round) {
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
        shapes = mixed(shapes, unit.asDiagonal() * ritz.eigenvectors());
        for (Eigen::Index i = 0; i < n; ++i) lambdas[as_size(i)] = lambda + ritz.eigenvalues()(i);
    }
    return lambdas;
}

ModeFinder::Strained ModeFinder::iterate_free(std::vector<FrameVector>& shapes, double shift) {
    // What slow modes leave in the shapes falls by shift/(shift + λ) per round: until what is strained is rounding
    Strained found{std::numeric_limits<double>::infinity(), 0, false};
    double before;
    do {
        if (iterate(shapes, shift).empty())
            throw Error(DTTMM_ERROR_NUMERIC, "the shapes of the rigid-body modes were not found");
        before = found.surely;
        found.surely = found.most = 0;
        for (const FrameVector& shape : shapes) {  // λ is twice the energy of a shape of unit modal mass
            const Strain all = sum(strain_energies(stiffness_, shape));
            found.surely = std::max(found.surely, 2 * (std::abs(all.energy) - all.unsure));
            found.most = std::max(found.most, 2 * (std::abs(all.energy) + all.unsure));
            found.grows = found.grows || all.energy < -all.unsure;
        }
    } while (found.surely > 0 && found.surely < 0.5 * before);
    found.surely = std::min(found.surely, before);
    return found;
}

void ModeFinder::find_rigid(int count, double lowest) {
    if (count == 0) return;
    std::vector<FrameVector> shapes = random_shapes(as_size(count));
    const double shift = -kWiden * lowest * lowest;  // all is fixed there
    if (!stiffness_.model().levers.empty() && !stiffness_.model().is_at_rest) refuse(stiffness_.count(shift).value_or(0));
    const auto [strained, most, grows] = iterate_free(shapes, shift);
    const double least = lowest > quiet() ? lowest * lowest : rounding();
    const bool is_seen = strained > kStrain * least;
    // Forces at rest balance to some digits only: what they leave of a motion that nothing holds is no reason to refuse it
    const bool is_hidden = stiffness_.model().is_at_rest && strained <= kWiden * kWiden * rounding();
    if (is_seen && !is_hidden) {
        // Growth is counted from that shift on. The strain is known to some parts of itself only
        const double slow = std::sqrt(strained), limit = std::max(slow, grows ? std::sqrt(-shift) : lowest);
        throw Error(
            DTTMM_ERROR_NUMERIC,
            fmt::format("{} at about {:.2g} Hz cannot be told from a motion that nothing holds: up to {:.2g} Hz "
                        "rounding of the stiffest parts hides what is counted. Make these parts rigid{}{}",
                        grows ? "a motion that grows" : "a natural frequency", hertz(slow), hertz(limit),
                        slow > kWiden * kWiden * std::sqrt(rounding()) ? ", or ask for lower frequencies" : "", of_load()));
    }
    const size_t first = modes_.size();
    add({std::vector<double>(shapes.size(), 0.0), shapes, stiffness_.cuts()}, 0);
    if (!is_seen) return;
    for (Mode& mode : std::span(modes_).subspan(first)) mode.bracket = hertz(std::sqrt(most));
}

/// Finds what an interval has, with the counts at its ends as proof.
bool ModeFinder::refine(const Interval& interval) {
    const size_t known = modes_.size();
    int before = interval.before;
    for (Cluster& cluster : approximate(interval))
        if (!prove(cluster, before)) {
            modes_.resize(known);
            return false;
        }
    return before == interval.until;
}

/// Takes the frequencies of a group into the list, those that are equal together. before: the count below it, then above it.
bool ModeFinder::prove(Cluster& near, int& before) {
    if (!converge(near)) return false;
    while (!near.shapes.empty()) {
        Cluster equal = take_equal(near);
        const double bracket = confirm(equal, before);
        if (bracket == 0) return false;
        before += as_int(equal.shapes.size());
        add(std::move(equal), bracket);
    }
    return true;
}

/// Groups of frequencies next to each other in an interval, from its middle; nothing: others were found.
std::vector<ModeFinder::Cluster> ModeFinder::approximate(const Interval& interval) {
    stiffness_.cut(interval.high);
    std::vector<FrameVector> shapes = random_shapes(as_size(interval.until - interval.before));
    const double middle = 0.5 * (interval.low + interval.high);
    const std::vector<double> lambdas = approach(shapes, middle * middle);
    std::vector<Cluster> clusters;
    for (size_t k = 0; k < lambdas.size(); ++k) {
        const double omega = std::sqrt(std::max(lambdas[k], 0.0));
        if (!(omega >= interval.low / kNarrow && omega <= interval.high * kNarrow)) return {};
        if (clusters.empty() || lambdas[k] > clusters.back().lambdas.back() * (1 + kWidestBracket))
            clusters.push_back({{}, {}, stiffness_.cuts()});
        clusters.back().lambdas.push_back(lambdas[k]);
        clusters.back().shapes.push_back(std::move(shapes[k]));
    }
    return clusters;
}

/// Newton's method: inverse iteration with the shift next to the cluster, with the lines cut for it alone, however far the
/// search reaches, until its frequencies stand.
bool ModeFinder::converge(Cluster& cluster) {
    stiffness_.cut(std::sqrt(cluster.lambdas.back()));
    if (stiffness_.cuts() != cluster.cuts) cluster.shapes = random_shapes(cluster.shapes.size());
    double change = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < kMostPasses && change > kConverged; ++pass) {
        const double mean = 0.5 * (cluster.lambdas.front() + cluster.lambdas.back());
        const std::vector<double> next = approach(cluster.shapes, mean * (1 + kBeside));
        if (next.empty() || !(next.front() > 0)) return false;
        change = 0;
        for (size_t k = 0; k < next.size(); ++k) change = std::max(change, std::abs(next[k] - cluster.lambdas[k]) / next[k]);
        cluster.lambdas = next;
    }
    return true;
}

/// The first frequencies of a group of near ones that count as equal.
ModeFinder::Cluster ModeFinder::take_equal(Cluster& near) const {
    size_t count = 1;
    const auto is_equal = [&](double a, double b) { return b <= a * (1 + 2 * kEqual) + kSplit * stiffness_.stiffest(); };
    while (count < near.lambdas.size() && is_equal(near.lambdas[count - 1], near.lambdas[count])) ++count;
    const auto n = static_cast<std::ptrdiff_t>(count);
    Cluster equal{{near.lambdas.begin(), near.lambdas.begin() + n},
                  {std::move_iterator(near.shapes.begin()), std::move_iterator(near.shapes.begin() + n)},
                  near.cuts};
    near.lambdas.erase(near.lambdas.begin(), near.lambdas.begin() + n);
    near.shapes.erase(near.shapes.begin(), near.shapes.begin() + n);
    return equal;
}

/// The count on both sides of a cluster, as near as it can tell: the share of ω; 0: it says otherwise.
double ModeFinder::confirm(const Cluster& cluster, int before) {
    const int until = before + as_int(cluster.shapes.size());
    for (double bracket = kFinestBracket; bracket <= kWidestBracket; bracket *= kWiden) {
        const double low = std::sqrt(cluster.lambdas.front()) * (1 - bracket);
        const double high = std::sqrt(cluster.lambdas.back()) * (1 + bracket);
        if (count_beside(low * low) == before && count_beside(high * high) == until) return bracket;
    }
    return 0;
}

/// Takes shapes of equal frequencies into the list.
void ModeFinder::add(Cluster cluster, double bracket) {
    for (double& own : cluster.lambdas) own *= sign_;
    const double lambda = cluster.lambdas.front();
    stiffness_.set(lambda);
    fix_basis(stiffness_, cluster.shapes, lambda == 0);
    const size_t first = modes_.size();
    for (size_t k = 0; k < cluster.shapes.size(); ++k) {
        modes_.push_back(describe(std::move(cluster.shapes[k]), cluster.lambdas[k]));
        bracket = std::max(bracket, modes_.back().bracket);
    }
    for (size_t m = first; m < modes_.size(); ++m) {
        modes_[m].bracket = bracket;
        modes_[m].multiplicity = as_int(modes_.size() - first);
    }
    find_participation(std::span(modes_).subspan(first));
}

/// A mode by its shape, at which the stiffness stands. Its bracket is what the strain energy makes of λ. The dynamic
/// stiffness of a long chain of short stiff parts loses small frequencies in its last digits, and count and iteration agree
/// on what is left; energies of deformations do not. Throws Error(DTTMM_ERROR_NUMERIC) if that is too much.
Mode ModeFinder::describe(FrameVector shape, double lambda) const {
    Mode mode;
    mode.omega = std::copysign(std::sqrt(std::abs(lambda)), lambda);
    mode.cut = stiffness_.cut_for();
    // A shape is scaled by its largest displacement, one that only turns by its rotation
    const auto [most, turn] = largest(stiffness_, shape);
    const double scale = 1 / (most > kShapeRounding * turn ? most : turn);
    for (Vector6& u : shape) u *= scale;
    mode.mass = dot(shape, stiffness_.mass_times(shape));
    const std::vector<Strain> strains = strain_energies(stiffness_, shape);
    const Strain all = sum(strains);
    for (size_t e = 0; e + 1 < strains.size(); ++e)  // of a rigid-body mode rounding is all there is
        mode.shares.push_back(lambda != 0 && all.energy != 0 ? strains[e].energy / all.energy : 0);
    if (const double inertial = lambda * mode.mass; inertial != 0) {
        const double elastic = inertial > 0 ? std::max(all.energy, 0.0) : all.energy;
        mode.residual = std::abs(dot(shape, stiffness_.stiffness_times(shape)) / inertial);
        mode.bracket = (std::abs(2 * elastic - inertial) + 2 * all.unsure) / std::abs(inertial);
    }
    if (mode.bracket > (stiffness_.model().is_at_rest ? kWidestAtRest : kWidestBracket))
        throw Error(
            DTTMM_ERROR_NUMERIC,
            fmt::format("a natural frequency at {:.6g} Hz is known to {:.1e} of itself only: rounding of the stiffest "
                        "parts hides it; join short ones, take fewer segments of bent beams, or make them rigid{}",
                        hertz(mode.omega), mode.bracket, of_load()));
    mode.shape = std::move(shape);
    return mode;
}

/// Shares of what moves as a whole. Of two motions φ at λ and r at 0 the mass between them is −φᵀ (D(λ) − D(0)) r / λ.
void ModeFinder::find_participation(std::span<Mode> modes) {
    const double lambda = stiffness_.lambda();
    const Directions& directions = stiffness_.model().directions;
    std::array<FrameVector, 6> forces;
    for (size_t d = 0; d < 6; ++d)
        if (directions[d] && lambda != 0) forces[d] = stiffness_.move_whole(as_int(d)).forces;
    stiffness_.set(0);
    for (size_t d = 0; d < 6; ++d) {
        if (!directions[d]) continue;
        const DynamicStiffness::Whole at_rest = stiffness_.move_whole(as_int(d));
        for (Mode& mode : modes) {
            const double moved = lambda != 0 ? (dot(mode.shape, at_rest.forces) - dot(mode.shape, forces[d])) / lambda
                                             : dot(mode.shape, at_rest.momenta);
            mode.participation(as_row(d)) = at_rest.mass > 0 ? moved * moved / (mode.mass * at_rest.mass) : 0;
        }
    }
}

}  // namespace dttmm::plugin
