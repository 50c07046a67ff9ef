// SPDX-License-Identifier: BSD-3-Clause
#include "modal/mode_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/index.h"
#include "core/rounding.h"
#include "modal/search.h"
#include "modal/shape_basis.h"

namespace dttmm::plugin {

namespace {

/// Beside a frequency: there D can be factored, and inside an interval of kEqual.
constexpr double kBeside = kEqual / kWiden;
/// The narrowest interval in which a mode is confirmed by counts, as share of ω.
constexpr double kFinestBracket = kBeside / (kWiden * kWiden);
/// Of Newton's iteration, which converges quadratically: after a smaller correction of λ the next one is rounding.
const double kConverged = std::sqrt(std::numeric_limits<double>::epsilon());

double hertz(double omega) { return omega / (2 * M_PI); }

}  // namespace

/// What else helps a machine at rest: forces cancel all but some rounding of its stiffness there.
std::string ModeFinder::of_load() const {
    if (!stiffness_.model().is_at_rest) return "";
    return ", or change the load a little where it is near a critical one: there a frequency goes through zero";
}

/// Where nothing is stiff, any frequency will do.
double ModeFinder::lowest_for(double below) {
    const double quiet = slow_.quiet();
    return quiet > 0 ? quiet : below / kWiden;
}

/// Where a search begins: half-way between what rounding hides and what is stiffest.
double ModeFinder::first_trial() const { return std::sqrt(std::sqrt(slow_.rounding() * stiffness_.stiffest())); }

/// Masses without lines between them have no faster motions: a mass of less than ε of the whole is rounding.
double ModeFinder::fastest_mass() const { return std::sqrt(stiffness_.stiffest() / std::numeric_limits<double>::epsilon()); }

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

/// InverseIteration in terms of ω².
std::vector<double> ModeFinder::approach(std::vector<FrameVector>& shapes, double lambda) {
    std::vector<double> lambdas = inverse_.iterate(shapes, sign_ * lambda);
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
    stiffness_.cut(0);
    const double fastest = fastest_mass();
    double below = first_trial();
    int most = -1;
    for (double trial = below; most < count && trial < fastest; trial *= kWiden) {
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
    const int growing = count_growth(slack);
    if (slack == 0 && stiffness_.stiffest() > 0) refuse_noise("what grows", growing);
    return growing;
}

int ModeFinder::count_growth(int slack) {
    stiffness_.cut(0);
    if (stiffness_.model().total_mass == 0) return stiffness_.count(0).value_or(0);  // the same at any λ
    if (stiffness_.stiffest() == 0) return 0;
    const double lowest = slack == 0 ? lowest_for(0) : 0;
    stiffness_.cut(0);
    const double shift = slack == 1 ? 0 : slack == 0 ? kFixed * -lowest * lowest : -slack * slow_.rounding();
    // An eigenvalue hit to rounding has no count; beside it, by what rounding may make of one, there is one
    for (const double at : {shift, shift - slow_.rounding()})
        if (const auto count = stiffness_.count(at)) return *count;
    throw Error(DTTMM_ERROR_NUMERIC, "the motions that grow cannot be counted");
}

/// Throws where rounding may make up what is counted at the lowest frequency. [after lowest_for()]
void ModeFinder::refuse_noise(const char* what, int growing) const {
    if (!slow_.is_noisy() && growing == slow_.grow_fast().value_or(growing)) return;
    throw Error(
        DTTMM_ERROR_NUMERIC,
        fmt::format(
            "{} cannot be distinguished from what vibrates slowly: rounding of the stiffest parts hides it. Make these "
            "parts rigid{}",
            what, of_load()));
}

void ModeFinder::refuse_growing() {
    const int growing = count_growth(0);
    if (growing > 0) refuse_noise("what grows", growing);
    refuse(growing);
}

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
    const int rigid = count_rigid();
    const int growing = count_growth(0), free = rigid - growing;
    refuse_noise("what nothing holds", growing);
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
    growing_ = stiffness_.count(kFixed * -lowest * lowest).value_or(0);
    if (growing_ == 0) return;
    sign_ = -1;
    counts_[lowest * std::sqrt(kFixed)] = 0;
    const double fastest = fastest_mass();
    for (double trial = std::max(first_trial(), lowest * kWiden); trial < fastest; trial *= kWiden)
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

void ModeFinder::find_rigid(int count, double lowest) {
    if (count == 0) return;
    const double shift = kFixed * -lowest * lowest;  // all is fixed there
    if (!stiffness_.model().levers.empty() && !stiffness_.model().is_at_rest) refuse(stiffness_.count(shift).value_or(0));
    std::vector<FrameVector> shapes;
    const auto [strained, most, grows] = slow_.find_free(as_size(count), shift, shapes);
    const double least = lowest > slow_.quiet() ? lowest * lowest : slow_.rounding();
    // Forces at rest balance to some digits only: what they leave of a motion that nothing holds is no reason to refuse it
    const bool is_hidden = stiffness_.model().is_at_rest && strained <= slow_.most_hidden();
    const bool is_strained = strained > kStrain * least;
    // Where counts begin to hold above rounding, they do not say how slow is what they have below
    const bool may_be =
        slow_.quiet() > std::sqrt(slow_.rounding()) && most > std::max(slow_.most_hidden(), kStrain * -shift);
    if (is_strained && !is_hidden) {
        // Growth is counted from that shift on. The strain is known to some parts of itself only
        const double slow = std::sqrt(strained), limit = std::max(slow, grows ? std::sqrt(-shift) : lowest);
        throw Error(DTTMM_ERROR_NUMERIC,
                    fmt::format("{} at about {:.2g} Hz cannot be told from a motion that nothing holds: up to {:.2g} Hz "
                                "rounding of the stiffest parts hides what is counted. Make these parts rigid{}{}",
                                grows ? "a motion that grows" : "a natural frequency", hertz(slow), hertz(limit),
                                strained > slow_.most_hidden() ? ", or ask for lower frequencies" : "", of_load()));
    }
    const size_t first = modes_.size();
    add({std::vector<double>(shapes.size(), 0.0), shapes, stiffness_.cuts()}, 0);
    if (!is_strained && !may_be) return;
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
        if (bracket == 0 || !part_from_others(equal)) return false;
        before += as_int(equal.shapes.size());
        add(std::move(equal), bracket);
    }
    return true;
}

/// Groups of frequencies next to each other in an interval, from its middle; nothing: others were found.
std::vector<ModeFinder::Cluster> ModeFinder::approximate(const Interval& interval) {
    stiffness_.cut(interval.high);
    std::vector<FrameVector> shapes = inverse_.random_shapes(as_size(interval.until - interval.before));
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
    if (stiffness_.cuts() != cluster.cuts) cluster.shapes = inverse_.random_shapes(cluster.shapes.size());
    double change = std::numeric_limits<double>::infinity(), before;
    do {
        before = change;
        const double mean = 0.5 * (cluster.lambdas.front() + cluster.lambdas.back());
        const std::vector<double> next = approach(cluster.shapes, mean * (1 + kBeside));
        if (next.empty() || !(next.front() > 0)) return false;
        change = 0;
        for (size_t k = 0; k < next.size(); ++k) change = std::max(change, std::abs(next[k] - cluster.lambdas[k]) / next[k]);
        cluster.lambdas = next;
    } while (change > kConverged && change < before);
    return true;
}

/// The first frequencies of a group of near ones that count as equal.
ModeFinder::Cluster ModeFinder::take_equal(Cluster& near) const {
    size_t count = 1;
    const auto is_equal = [&](double a, double b) {
        return b <= a * (1 + 2 * kEqual) + kRoundingOfSums * stiffness_.stiffest();
    };
    while (count < near.lambdas.size() && is_equal(near.lambdas[count - 1], near.lambdas[count])) ++count;
    const auto n = as_row(count);
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

/// Leaves of shapes what is at right angles to modes next to them. Whether something is: a spin that rounding counts there
/// leads to one of these once more.
bool ModeFinder::part_from_others(Cluster& equal) const {
    const double omega = sign_ * std::sqrt(equal.lambdas.front()), near = 2 * kWidestBracket * std::abs(omega);
    for (FrameVector& shape : equal.shapes) {
        const double mass = dot(shape, stiffness_.mass_times(shape));
        for (size_t k = modes_.size(); k > 0 && std::abs(omega - modes_[k - 1].omega) <= near; --k) {
            const Mode& other = modes_[k - 1];
            if (other.shape.size() != shape.size()) continue;
            const double share = dot(other.shape, stiffness_.mass_times(shape)) / other.mass;
            for (size_t f = 0; f < shape.size(); ++f) shape[f] -= share * other.shape[f];
        }
        if (dot(shape, stiffness_.mass_times(shape)) <= kSameShape * mass) return false;
    }
    return true;
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
