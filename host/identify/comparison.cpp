// SPDX-License-Identifier: BSD-3-Clause
#include "identify/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "analysis/advance.h"
#include "analysis/modal_session.h"
#include "analysis/places.h"
#include "analysis/response_channels.h"
#include "analysis/response_curves.h"
#include "identify/mains_hum.h"
#include "model/error.h"
#include "model/index.h"
#include "step/simulation.h"

namespace dttmm::host {

namespace {

// Of data whose noise nobody gives. Frequencies: usual of a modal test; shapes: share of their largest component. Source:
// identification of structures by modal tests, Friswell and Mottershead, Finite Element Model Updating, 1995, chapter 3.
constexpr double kFrequencyNoise = 0.005, kShapeNoise = 0.03;
constexpr double kStartNoise = 0.01;  // share of the largest value of a channel, before residuals tell more
constexpr int kFinestOfSample = 4;    // steps per sample, where the model gives none

/// The four rows around a place between rows, and their weights: Lagrange's cubic. On a row only that one counts.
struct Interpolation {
    Eigen::Index first = 0, count = 1;
    double weights[4] = {1, 0, 0, 0};

    Interpolation(double at, Eigen::Index rows) {
        const double nearest = std::round(at);
        if (std::abs(at - nearest) < 1e-6 || rows < 4) {
            first = std::clamp(static_cast<Eigen::Index>(nearest), Eigen::Index{0}, rows - 1);
            return;
        }
        count = 4;
        first = std::clamp(static_cast<Eigen::Index>(std::floor(at)) - 1, Eigen::Index{0}, rows - 4);
        const double s = at - static_cast<double>(first);
        for (int i = 0; i < 4; ++i) {
            weights[i] = 1;
            for (int j = 0; j < 4; ++j)
                if (j != i) weights[i] *= (s - j) / (i - j);
        }
    }
};

/// Writes a shape, scaled to be nearest to the measured one, where that has a value. Returns the row behind it.
Eigen::Index write_scaled(const Eigen::VectorXd& own, const Eigen::VectorXd& measured, Eigen::Index row,
                          Eigen::VectorXd& out) {
    double product = 0, square = 0;
    for (Eigen::Index k = 0; k < own.size(); ++k) {
        if (std::isnan(measured(k))) continue;
        product += own(k) * measured(k);
        square += own(k) * own(k);
    }
    for (Eigen::Index k = 0; k < own.size(); ++k)
        if (!std::isnan(measured(k))) out(row++) = square > 0 ? product / square * own(k) : 0;
    return row;
}

/// Data by group, with the weights of those that have some of their own.
class Gathered {
public:
    static DataGroup open(DataGroup::Kind kind, const std::string& name) { return {kind, name}; }
    void add(double value) { values_.push_back(value); }
    void add(double value, double weight) {
        weights_.resize(values_.size(), 1);
        values_.push_back(value);
        weights_.push_back(weight);
    }
    /// Ends the group of what was added since the last one; none if that is nothing.
    void close(DataGroup group, std::vector<DataGroup>& groups) {
        group.first = as_row(begin_);
        group.count = as_row(values_.size() - begin_);
        begin_ = values_.size();
        for (Eigen::Index i = group.first; i < group.first + group.count; ++i)
            group.largest = std::max(group.largest, std::abs(values_[as_size(i)]));
        if (group.noise == 0) group.noise = kStartNoise * group.largest;
        if (group.count > 0) groups.push_back(group);
    }
    Eigen::VectorXd values() const { return Eigen::Map<const Eigen::VectorXd>(values_.data(), as_row(values_.size())); }
    Eigen::VectorXd weights() {
        weights_.resize(values_.size(), 1);
        return Eigen::Map<const Eigen::VectorXd>(weights_.data(), as_row(weights_.size()));
    }

private:
    std::vector<double> values_, weights_;
    size_t begin_ = 0;  ///< of the open group
};

DataGroup gather_response(const ObservedResponse& one, Gathered& data) {
    DataGroup group = Gathered::open(DataGroup::Kind::response, one.channel + "/" + one.input);
    for (size_t i = 0; i < one.values.size(); ++i) {
        const double weight = one.deviations.empty() ? 1 : one.deviations[i];
        data.add(one.values[i].real(), weight);
        data.add(one.is_real ? 0 : one.values[i].imag(), weight);
    }
    group.noise = one.deviations.empty() ? one.noise : 1;
    group.noise_samples = one.noise_samples;
    if (group.noise > 0) group.noise_from = one.deviations.empty() ? DataGroup::NoiseFrom::user : DataGroup::NoiseFrom::data;
    return group;
}

DataGroup gather_frequencies(const Observations& observations, Gathered& data) {
    DataGroup group = Gathered::open(DataGroup::Kind::frequency, "frequencies");
    for (const ObservedMode& mode : observations.modes)
        data.add(std::log(mode.frequency), mode.deviation > 0 ? mode.deviation : kFrequencyNoise);
    group.noise = 1;
    group.noise_samples = observations.frequency_samples;
    group.noise_from = observations.frequency_samples > 0   ? DataGroup::NoiseFrom::data
                       : observations.are_frequencies_known ? DataGroup::NoiseFrom::user
                                                            : DataGroup::NoiseFrom::assumed;
    return group;
}

}  // namespace

Comparison::Comparison(const Request& request, const Observations& observations, const Plugins& plugins)
    : request_(request), observations_(observations), plugins_(plugins) {
    Gathered data;
    for (const ObservedHistory& one : observations.histories) {
        DataGroup group = Gathered::open(DataGroup::Kind::history, one.channel);
        for (const double value : one.values) data.add(value);
        group.noise = one.noise;
        if (one.noise > 0) group.noise_from = one.is_noise_of_user ? DataGroup::NoiseFrom::user : DataGroup::NoiseFrom::data;
        group.noise_samples = one.noise_samples;
        duration_ = std::max(duration_, one.times.back());
        if (one.hum > 0) scales_ += 2;
        data.close(group, groups_);
    }
    for (const ObservedResponse& one : observations.responses) data.close(gather_response(one, data), groups_);
    if (!observations.modes.empty()) {
        data.close(gather_frequencies(observations, data), groups_);
        DataGroup shapes = Gathered::open(DataGroup::Kind::shape, "shapes");
        for (const ObservedMode& mode : observations.modes) {
            bool has_shape = false;
            for (Eigen::Index i = 0; i < mode.shape.size(); ++i) {
                if (std::isnan(mode.shape(i))) continue;
                data.add(mode.shape(i));
                has_shape = true;
            }
            if (has_shape) ++scales_;
        }
        shapes.noise = kShapeNoise;
        shapes.noise_from = DataGroup::NoiseFrom::assumed;
        data.close(shapes, groups_);
    }
    data_ = data.values();
    weights_ = data.weights();
    if (has_histories()) choose_step();
}

/// That of the model or the command line; else one that divides the interval between samples.
void Comparison::choose_step() {
    const Model model = read({}, {}, Purpose::histories);
    step_ = model.simulation.step;
    if (step_ > 0) return;
    double interval = duration_;
    for (const ObservedHistory& one : observations_.histories)
        interval = std::min(interval, (one.times.back() - one.times.front()) / static_cast<double>(one.times.size() - 1));
    step_ = std::clamp(interval / kFinestOfSample, kShortestStep, kLongestStep);
}

Model Comparison::read(const Unknowns& unknowns, const Eigen::VectorXd& x, Purpose purpose) const {
    ModelOverrides overrides = request_.overrides;
    overrides.purpose = purpose;
    unknowns.apply(x, overrides);
    return read_model(request_.model, plugins_.catalogue(), overrides);
}

ShortWindow::ShortWindow(Comparison& comparison, double share) : comparison_(comparison) { comparison.set_window(share); }

ShortWindow::~ShortWindow() { comparison_.set_window(1); }

Eigen::Index Comparison::counted(const DataGroup& group) const {
    if (group.kind != DataGroup::Kind::history) return group.count;
    const std::vector<double>& times = observations_.histories[as_size(&group - groups_.data())].times;
    return std::ranges::upper_bound(times, window_ * duration_) - times.begin();
}

Eigen::VectorXd Comparison::deviations() const {
    Eigen::VectorXd deviations = weights_;
    for (const DataGroup& group : groups_) deviations.segment(group.first, group.count) *= group.noise;
    return deviations;
}

void Comparison::estimate_noise(const Eigen::VectorXd& predicted, size_t unknowns) {
    const double freedom_per_row = 1 - static_cast<double>(unknowns) / static_cast<double>(rows());
    for (DataGroup& group : groups_) {
        if (group.noise_from != DataGroup::NoiseFrom::residuals) continue;
        const double squares = (predicted - data_).segment(group.first, group.count).squaredNorm();
        const double freedom = std::max(1.0, freedom_per_row * static_cast<double>(group.count));
        group.noise = std::max(std::sqrt(squares / freedom), kLeastNoise * group.largest);
    }
}

Eigen::VectorXd Comparison::predict(const Unknowns& unknowns, const Eigen::VectorXd& x, int finer) const {
    Eigen::VectorXd predicted = data_;
    const MeasurementFactors factors = unknowns.factors(x);
    if (has_histories()) predict_histories(read(unknowns, x, Purpose::histories), factors, finer, predicted);
    if (has_responses() || has_modes()) {
        const Model model = read(unknowns, x, Purpose::modes);
        if (has_responses()) predict_responses(model, factors, predicted);
        if (has_modes()) predict_modes(model, factors, predicted);
    }
    return predicted;
}

void Comparison::predict_histories(Model model, const MeasurementFactors& factors, int finer, Eigen::VectorXd& out) const {
    const double step = step_ / finer, end = window_ * duration_;
    model.simulation.step = step;
    model.simulation.tolerance.reset();
    // One row beyond the last sample, for the interpolation, and as far as delay and clock may move it
    model.simulation.duration = step * std::ceil(factors.clock * (end + std::abs(factors.delay)) / step + 2);
    model.output.step = 0;
    model.output.every = 1;
    Simulation simulation(model, plugins_);
    std::vector<int> columns;
    for (const ObservedHistory& one : observations_.histories) {
        const auto channel =
            std::ranges::find_if(simulation.channels(), [&](const Channel& c) { return c.name() == one.channel; });
        if (channel == simulation.channels().end())
            throw Error(ExitCode::model_invalid, fmt::format("the model has no channel {} any more", one.channel));
        columns.push_back(as_int(channel - simulation.channels().begin()));
    }
    simulation.want(columns);
    simulation.leave_ode();  // it moves bodies as predicted, and takes 5 to 18 % of a diagnosis
    std::vector<double> rows;
    rows.reserve((simulation.step_count() + 1) * columns.size());
    simulation.record_to([&](std::span<const double> row) {
        for (const int column : columns) rows.push_back(row[as_size(column)]);
    });
    const Ending ending = advance_to_end(simulation, true);
    if (ending.code != ExitCode::ok) throw Error(ending.code, ending.outcome.reason);
    const auto count = as_row(columns.size()), recorded = as_row(rows.size()) / count;
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> table(rows.data(),
                                                                                                         recorded, count);
    for (size_t c = 0; c < columns.size(); ++c) {
        const ObservedHistory& one = observations_.histories[c];
        const double gain = factors.gain * (c < factors.gains.size() ? factors.gains[c] : 1);
        for (size_t i = 0; i < one.times.size() && one.times[i] <= end; ++i) {
            const double time = factors.clock * (one.times[i] - factors.delay);
            const Interpolation at(std::max(time, 0.0) / step, recorded);
            double value = 0;
            for (Eigen::Index k = 0; k < at.count; ++k) value += at.weights[k] * table(at.first + k, as_row(c));
            out(groups_[c].first + as_row(i)) = gain * value;
        }
        if (one.hum == 0) continue;
        // The hum that brings the history nearest to the data: least squares without the unknowns
        const Eigen::Index first = groups_[c].first, within = counted(groups_[c]);
        out.segment(first, within) += fit_sine(one.times, (data_ - out).segment(first, within), one.hum);
    }
}

void Comparison::predict_responses(const Model& model, const MeasurementFactors& factors, Eigen::VectorXd& out) const {
    Warnings silent(Warnings::Silent::yes);
    ModalMachine machine = make_machine(model, plugins_, silent);
    const ResponseChannels channels(model, machine);
    double highest = 0;
    // Equal frequencies are solved once for all inputs and outputs
    struct Wanted {
        size_t response, point;
    };
    std::map<double, std::vector<Wanted>> by_frequency;
    std::vector<std::string> inputs;
    std::vector<Excitation::Input> driven;
    std::vector<size_t> input_of;
    std::vector<int> chosen;
    for (size_t r = 0; r < observations_.responses.size(); ++r) {
        const ObservedResponse& one = observations_.responses[r];
        const auto known = std::ranges::find(inputs, one.input);
        input_of.push_back(as_size(known - inputs.begin()));
        if (known == inputs.end()) {
            inputs.push_back(one.input);
            const auto [place, direction] = place_and_direction(model, machine, "input", one.input);
            driven.push_back({one.input, place, direction});
        }
        const auto channel = std::ranges::find_if(channels.all(), [&](const Channel& c) { return c.name() == one.channel; });
        chosen.push_back(as_int(channel - channels.all().begin()));
        for (size_t i = 0; i < one.frequencies.size(); ++i) {
            by_frequency[one.frequencies[i]].push_back({r, i});
            highest = std::max(highest, one.frequencies[i]);
        }
    }
    machine.damp(highest / factors.clock);
    const Excitation excitation(driven);
    const bool with_forces = channels.has_forces(chosen);
    for (const auto& [measured, wanted] : by_frequency) {
        const double f = measured / factors.clock, omega = 2 * std::numbers::pi * f;
        OperatingPoint at;
        at.frequency = f;
        const std::vector<ModalInstance::Response> responses = machine.respond(f, excitation.cases(at), with_forces);
        for (const auto& [r, i] : wanted) {
            const size_t own = observations_.histories.size() + r;
            const double gain = factors.gain * (own < factors.gains.size() ? factors.gains[own] : 1);
            const std::complex<double> value =
                gain * channels.value(chosen[r], responses[input_of[r]], omega) * std::polar(1.0, -omega * factors.delay);
            const DataGroup& group = groups_[own];
            out(group.first + as_row(2 * i)) = value.real();
            if (!observations_.responses[r].is_real) out(group.first + as_row(2 * i + 1)) = value.imag();
        }
    }
}

std::vector<ModePair> Comparison::predict_modes(const Model& asked, const MeasurementFactors& factors,
                                                Eigen::VectorXd& out) const {
    constexpr int kBeyond = 3;  // modes above the highest measured one that a shape may belong to
    Model model = asked;
    int highest = 0, lowest = std::numeric_limits<int>::max();
    for (const ObservedMode& mode : observations_.modes) {
        highest = std::max(highest, mode.number);
        lowest = std::min(lowest, mode.number);
    }
    model.modes.count = highest + (observations_.freedoms.empty() ? 0 : kBeyond);
    model.modes.below.reset();
    Warnings silent(Warnings::Silent::yes);
    ModalMachine machine = make_machine(model, plugins_, silent);
    std::vector<ModalInstance::Mode> modes = machine.find_modes();
    const auto count_rigid = [&] {
        return as_int(std::ranges::count_if(modes, [](const auto& mode) { return !(mode.numbers.frequency > 0); }));
    };
    int rigid = 0;
    // A test of a free machine may number its modes from the first one above 0 Hz
    while (!observations_.freedoms.empty() && count_rigid() > rigid && lowest <= count_rigid()) {
        rigid = count_rigid();
        modes = machine.find_modes(as_whole<uint32_t>(model.modes.count + rigid), 0);
    }
    const auto count = as_row(observations_.freedoms.size());
    Eigen::MatrixXd shapes(count, as_row(modes.size()));
    for (Eigen::Index i = 0; i < count; ++i) {
        const ObservedFreedom& freedom = observations_.freedoms[as_size(i)];
        const ModalPlace* place = machine.find(freedom.place);
        for (size_t m = 0; m < modes.size(); ++m) shapes(i, as_row(m)) = machine.motion(*place, modes[m])(freedom.direction);
    }
    std::vector<double> frequencies;
    for (const ModalInstance::Mode& mode : modes) frequencies.push_back(mode.numbers.frequency);
    std::vector<ModePair> pairs = pair_modes(observations_.modes, frequencies, shapes);
    const size_t first_group = observations_.histories.size() + observations_.responses.size();
    Eigen::Index row = groups_[first_group].first, shape_row = row + groups_[first_group].count;
    for (size_t i = 0; i < observations_.modes.size(); ++i, ++row) {
        const ObservedMode& mode = observations_.modes[i];
        if (pairs[i].mode == 0 && mode.number <= count_rigid())
            throw Error(ExitCode::model_invalid,
                        fmt::format("mode {} of the model has 0 Hz and cannot be the measured one of {:.6g} Hz: number the "
                                    "measured modes as `dttmm modes` does, or give their shapes",
                                    mode.number, mode.frequency));
        if (pairs[i].mode == 0)
            throw Error(
                ExitCode::model_invalid,
                fmt::format(
                    "the model has {} natural frequencies, but none is left for the measured one of {:.6g} Hz: leave "
                    "out of the file what is no mode of the model",
                    modes.size(), mode.frequency));
        out(row) = std::log(pairs[i].frequency / factors.clock);
        if (mode.shape.size() > 0) shape_row = write_scaled(pairs[i].shape, mode.shape, shape_row, out);
    }
    return pairs;
}

std::vector<ModePair> Comparison::pairs(const Unknowns& unknowns, const Eigen::VectorXd& x) const {
    if (!has_modes()) return {};
    Eigen::VectorXd predicted = data_;
    return predict_modes(read(unknowns, x, Purpose::modes), unknowns.factors(x), predicted);
}

Eigen::VectorXd Comparison::residual(const Eigen::VectorXd& predicted, bool are_logarithmic) const {
    const Eigen::VectorXd deviation = deviations();
    Eigen::VectorXd residual = (predicted - data_).cwiseQuotient(deviation);
    if (!are_logarithmic) return residual;
    for (const DataGroup& group : groups_) {
        if (group.kind != DataGroup::Kind::response) continue;
        for (Eigen::Index i = group.first; i < group.first + group.count; i += 2) {
            const std::complex<double> measured(data_(i), data_(i + 1)), own(predicted(i), predicted(i + 1));
            if (std::abs(own) == 0) continue;
            const double share = std::hypot(deviation(i) / std::abs(measured), kStartNoise);
            const std::complex<double> ratio = std::log(own / measured);
            residual(i) = ratio.real() / share;
            residual(i + 1) = ratio.imag() / share;
        }
    }
    return residual;
}

}  // namespace dttmm::host
