// SPDX-License-Identifier: BSD-3-Clause
#include "identify/repeats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "identify/mains_hum.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kSameInstant = 1e-3;  // of an interval: at half the sampling frequency that moves a value by 0.3 %
constexpr double kCopy = 1e-4;         // share of the largest value: no two measurements agree so, copies rounded may
constexpr double kNoScatter = 1e-12;   // of logarithms of frequencies
constexpr double kSeen = 4;            // standard deviations: one in 16 000 differs as much in size by noise alone
constexpr double kOneMode = 0.1;       // share of a frequency: two that differ by more are not one mode
constexpr double kOneShape = 0.5;      // of MAC: nor are two shapes that differ by more
// Differences behind the scatter of one line of a response. A sum of squares over an estimated variance is too large by
// n/(n - 2) in the mean, which is corrected; its own scatter grows by a tenth.
constexpr size_t kFewestDifferences = 20;

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::input_output, text); }

/// Sets of equal keys, each in the order of `all`, the sets in the order of their first.
template <class Observed, class Key>
std::vector<std::vector<const Observed*>> sets_of(const std::vector<Observed>& all, Key key) {
    std::vector<std::vector<const Observed*>> sets;
    for (const Observed& one : all) {
        const auto own = std::ranges::find_if(sets, [&](const auto& set) { return key(*set.front()) == key(one); });
        if (own == sets.end())
            sets.push_back({&one});
        else
            own->push_back(&one);
    }
    return sets;
}

template <class Observed>
std::vector<std::string> places_of(const std::vector<const Observed*>& set) {
    std::vector<std::string> places;
    for (const Observed* one : set) places.push_back(one->place);
    return places;
}

void check_same_points(const std::vector<double>& a, const std::vector<double>& b, const std::vector<std::string>& places,
                       const char* points) {
    assert(a.size() > 1);
    bool are_same = a.size() == b.size();
    const double interval = (a.back() - a.front()) / static_cast<double>(a.size() - 1);
    for (size_t i = 0; are_same && i < a.size(); ++i) are_same = std::abs(a[i] - b[i]) <= kSameInstant * interval;
    if (!are_same)
        refuse(fmt::format("{}: repeats of one channel must have the same {}: resample them, or give one of them",
                           listed(places), points));
}

/// Repeats of numbers, a column each.
class Scatter {
public:
    Scatter(const Eigen::MatrixXd& repeats, const std::vector<std::string>& places)
        : mean_(repeats.rowwise().mean()), differences_(repeats.colwise() - mean_), rows_(repeats.rows()) {
        for (Eigen::Index r = 1; r < repeats.cols(); ++r)
            for (const double step : (repeats.col(r) - repeats.col(0)).cwiseAbs())
                if (step > 0 && (quantum_ == 0 || step < quantum_)) quantum_ = step;
        const double largest = mean_.cwiseAbs().maxCoeff();
        for (Eigen::Index a = 0; a < repeats.cols(); ++a)
            for (Eigen::Index b = 0; b < a; ++b)
                if ((repeats.col(a) - repeats.col(b)).cwiseAbs().maxCoeff() <= kCopy * largest)
                    refuse(
                        fmt::format("{} and {} are the same: a copy is no repeat", places[as_size(b)], places[as_size(a)]));
    }

    /// Hum has another phase in every repeat; the fit takes it off.
    void take_off_hum(std::span<const double> times, double hum) {
        for (auto column : differences_.colwise()) column -= fit_sine(times, column, hum);
        rows_ -= 2;
    }

    const Eigen::VectorXd& mean() const { return mean_; }
    size_t freedom() const { return as_size(rows_ * (differences_.cols() - 1)); }
    /// Standard deviation of the mean, as far as all differences tell.
    double deviation_of_mean() const {
        return std::sqrt(differences_.squaredNorm() / static_cast<double>(freedom()) / repeats());
    }
    /// Of rows `first` to `end`.
    double deviation_of_mean(Eigen::Index first, Eigen::Index end) const {
        const double freedom = static_cast<double>(end - first) * (repeats() - 1);
        return std::sqrt(differences_.middleRows(first, end - first).squaredNorm() / freedom / repeats());
    }
    /// Standard deviation of the mean by the last digit of the numbers: no two differ by less.
    double rounding() const { return quantum_ / std::sqrt(12 * repeats()); }
    /// Of a harder blow the difference is the signal itself.
    void warn_of_size(const std::vector<std::string>& places, Warnings& warnings) const {
        const double square = mean_.squaredNorm();
        if (square == 0) return;
        for (Eigen::Index r = 0; r < differences_.cols(); ++r) {
            const double size = mean_.dot(differences_.col(r)) / square;
            const double left = std::max(0.0, differences_.squaredNorm() - size * size * square);
            const double deviation = std::sqrt(left / static_cast<double>(freedom()) / square * (repeats() - 1) / repeats());
            if (std::abs(size) > kSeen * deviation)
                warnings.add(
                    "unequal-repeats",
                    fmt::format("{}: {:.2g} % {} than the mean of its {} repeats. Their scatter is not noise alone; "
                                "fit responses per force, or repeats of one size",
                                places[as_size(r)], 100 * std::abs(size), size > 0 ? "larger" : "smaller",
                                differences_.cols()));
        }
    }

    /// Sensors' noise has no memory from sample to sample; a trigger, a sign or a blow that differs has.
    void warn_of_memory(const std::string& channel, Warnings& warnings) const {
        const Eigen::Index last = differences_.rows() - 1;
        const double now = differences_.squaredNorm(),
                     next = differences_.topRows(last).cwiseProduct(differences_.bottomRows(last)).sum();
        if (next / now * std::sqrt(static_cast<double>(freedom())) > kSeen)
            warnings.add("unlike-repeats",
                         fmt::format("{}: what its repeats differ by is correlated from sample to sample ({:.2g}): "
                                     "a trigger, sign or blow that differs, or filtered noise. Intervals "
                                     "that rest on it are too narrow",
                                     channel, next / now));
    }

private:
    double repeats() const { return static_cast<double>(differences_.cols()); }

    Eigen::VectorXd mean_;
    Eigen::MatrixXd differences_;
    Eigen::Index rows_;   ///< less what was fitted to each repeat
    double quantum_ = 0;  ///< least difference of two numbers
};

template <class Observed>
void note_mean(const std::vector<const Observed*>& set, const std::string& name, bool is_noise_known, Warnings& warnings) {
    warnings.note("repeats", fmt::format("{}: the mean of {} repeats is used; {}", name, set.size(),
                                         is_noise_known ? "its noise is that of one, divided by the root of their number"
                                                        : "their scatter is the noise"));
}

ObservedHistory join(const std::vector<const ObservedHistory*>& set, Warnings& warnings) {
    const std::vector<std::string> places = places_of(set);
    ObservedHistory joined = *set.front();
    Eigen::MatrixXd repeats(as_row(joined.values.size()), as_row(set.size()));
    for (size_t r = 0; r < set.size(); ++r) {
        check_same_points(joined.times, set[r]->times, places, "times");
        repeats.col(as_row(r)) = Eigen::Map<const Eigen::VectorXd>(set[r]->values.data(), repeats.rows());
    }
    Scatter scatter(repeats, places);
    if (joined.hum > 0) scatter.take_off_hum(joined.times, joined.hum);
    scatter.warn_of_size(places, warnings);
    scatter.warn_of_memory(joined.channel, warnings);
    joined.values.assign(scatter.mean().begin(), scatter.mean().end());
    note_mean(set, joined.channel, joined.is_noise_of_user, warnings);
    if (joined.is_noise_of_user) {
        joined.noise /= std::sqrt(static_cast<double>(set.size()));
        return joined;
    }
    joined.noise = scatter.deviation_of_mean();
    joined.noise_samples = scatter.freedom();
    return joined;
}

ObservedResponse join(const std::vector<const ObservedResponse*>& set, Warnings& warnings) {
    const std::vector<std::string> places = places_of(set);
    ObservedResponse joined = *set.front();
    const Eigen::Index parts = joined.is_real ? 1 : 2, lines = as_row(joined.values.size());
    Eigen::MatrixXd repeats(parts * lines, as_row(set.size()));
    for (size_t r = 0; r < set.size(); ++r) {
        check_same_points(joined.frequencies, set[r]->frequencies, places, "frequencies");
        if (set[r]->is_real != joined.is_real)
            refuse(fmt::format("{}: some repeats are real, some complex", listed(places)));
        for (Eigen::Index i = 0; i < lines; ++i) {
            repeats(parts * i, as_row(r)) = set[r]->values[as_size(i)].real();
            if (parts == 2) repeats(2 * i + 1, as_row(r)) = set[r]->values[as_size(i)].imag();
        }
    }
    const Scatter scatter(repeats, places);
    const Eigen::VectorXd& mean = scatter.mean();
    for (Eigen::Index i = 0; i < lines; ++i) joined.values[as_size(i)] = {mean(parts * i), parts == 2 ? mean(2 * i + 1) : 0};
    note_mean(set, joined.channel + "/" + joined.input, joined.noise > 0, warnings);
    if (joined.noise > 0) {
        joined.noise /= std::sqrt(static_cast<double>(set.size()));
        return joined;
    }
    const size_t per_line = as_size(parts) * (set.size() - 1);
    const Eigen::Index wide = std::min(lines, as_row((kFewestDifferences + per_line - 1) / per_line));
    const auto freedom = static_cast<double>(as_size(wide) * per_line);
    const double correction = freedom > 2 ? std::sqrt(freedom / (freedom - 2)) : 1;
    joined.noise_samples = scatter.freedom();
    joined.deviations.resize(as_size(lines));
    for (Eigen::Index i = 0; i < lines; ++i) {
        const Eigen::Index first = std::clamp(i - wide / 2, Eigen::Index{0}, lines - wide);
        joined.deviations[as_size(i)] =
            std::hypot(correction * scatter.deviation_of_mean(parts * first, parts * (first + wide)), scatter.rounding());
    }
    return joined;
}

/// The mean of the shapes that a mode has in the files, with the sign of the first, largest 1; none: none has one.
Eigen::VectorXd mean_shape(const std::vector<const ObservedMode*>& set, const std::vector<std::string>& places) {
    Eigen::VectorXd first, sum;
    for (const ObservedMode* one : set) {
        const Eigen::VectorXd& own = one->shape;
        if (own.size() == 0) continue;
        if (first.size() == 0) {
            first = sum = own;
            continue;
        }
        bool are_same = true;
        for (Eigen::Index i = 0; are_same && i < first.size(); ++i) are_same = std::isnan(own(i)) == std::isnan(first(i));
        if (!are_same)
            refuse(
                fmt::format("{}: repeats of a shape must have the same places and directions; what was measured in parts "
                            "belongs into one file",
                            listed(places)));
        const auto without_gaps = [](const Eigen::VectorXd& shape) {
            return Eigen::VectorXd(shape.unaryExpr([](double value) { return std::isnan(value) ? 0 : value; }));
        };
        const Eigen::VectorXd a = without_gaps(first), b = without_gaps(own);
        const double product = a.dot(b);
        if (product * product < kOneShape * a.squaredNorm() * b.squaredNorm())
            refuse(fmt::format("{}: the shapes differ, MAC {:.2g}: not one mode. Number the modes alike", listed(places),
                               product * product / (a.squaredNorm() * b.squaredNorm())));
        sum += product < 0 ? -own : own;
    }
    double largest = 0;
    for (const double value : sum)
        if (!std::isnan(value)) largest = std::max(largest, std::abs(value));
    return sum.size() > 0 ? Eigen::VectorXd(sum / largest) : sum;
}

/// The mean of a mode's repeats; its deviation where the files or the user give that of each, else 0. squares: of the
/// differences of the logarithms of its frequencies.
ObservedMode mean_mode(const std::vector<const ObservedMode*>& set, double& squares) {
    const std::vector<std::string> places = places_of(set);
    const auto count = static_cast<double>(set.size());
    double sum = 0, damping = 0, variance = 0;
    bool is_known = true;
    for (const ObservedMode* one : set) {
        if (std::abs(one->frequency - set.front()->frequency) > kOneMode * set.front()->frequency)
            refuse(
                fmt::format("{}: mode {} has {:.6g} Hz in one file and {:.6g} Hz in another: not one mode. Number the "
                            "modes alike",
                            listed(places), one->number, set.front()->frequency, one->frequency));
        sum += std::log(one->frequency);
        damping += one->damping / count;
        variance += one->deviation * one->deviation;
        is_known = is_known && one->deviation > 0;
    }
    for (const ObservedMode* one : set) squares += std::pow(std::log(one->frequency) - sum / count, 2);
    ObservedMode joined = *set.front();
    joined.frequency = std::exp(sum / count);
    joined.damping = damping;
    joined.deviation = is_known ? std::sqrt(variance) / count : 0;
    joined.shape = mean_shape(set, places);
    return joined;
}

void join_modes(Observations& observations, Warnings& warnings) {
    const auto sets =
        sets_of(observations.modes, [](const ObservedMode& one) { return std::pair(one.number, one.row_of_number); });
    if (sets.size() == observations.modes.size()) return;
    std::vector<ObservedMode> joined;
    double squares = 0;
    bool are_known = true;
    for (const auto& set : sets) {
        joined.push_back(set.size() == 1 ? *set.front() : mean_mode(set, squares));
        are_known = are_known && joined.back().deviation > 0;
    }
    std::string noise = "their noise is that of one, divided by the root of their number";
    if (!are_known) {
        observations.frequency_samples = observations.modes.size() - sets.size();
        const double scatter = std::sqrt(squares / static_cast<double>(observations.frequency_samples));
        if (scatter <= kNoScatter)
            refuse("the natural frequencies of the repeats do not differ: their scatter is no noise; give --noise");
        for (size_t i = 0; i < joined.size(); ++i)
            joined[i].deviation = scatter / std::sqrt(static_cast<double>(sets[i].size()));
        noise = fmt::format("they scatter by {:.2g} %, which is their noise", 100 * scatter);
    }
    warnings.note("repeats", fmt::format("natural frequencies: the means of repeats are used; {}. The noise of shapes stays "
                                         "what is usual",
                                         noise));
    observations.modes = std::move(joined);
}

template <class Observed, class Key>
void join_all(std::vector<Observed>& all, Key key, Warnings& warnings) {
    std::vector<Observed> joined;
    for (const auto& set : sets_of(all, key)) joined.push_back(set.size() == 1 ? *set.front() : join(set, warnings));
    all = std::move(joined);
}

}  // namespace

void join_repeats(Observations& observations, Warnings& warnings) {
    join_all(
        observations.histories, [](const ObservedHistory& one) { return one.channel; }, warnings);
    join_all(
        observations.responses, [](const ObservedResponse& one) { return std::pair(one.channel, one.input); }, warnings);
    join_modes(observations, warnings);
}

}  // namespace dttmm::host
