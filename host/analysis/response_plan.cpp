// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "analysis/places.h"
#include "model/error.h"
#include "model/units.h"
#include "model/vibrations.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
/// Natural frequencies that become points, at most: each costs a solution. A warning says that there are more.
constexpr size_t kMostStarts = 2000;

std::vector<double> spaced(double from, double to, int count, bool is_logarithmic) {
    std::vector<double> points;
    for (int i = 0; i < count; ++i) {
        const double part = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
        points.push_back(i == count - 1   ? to
                         : is_logarithmic ? from * std::pow(to / from, part)
                                          : from + part * (to - from));
    }
    return points;
}

void sort_and_unite(std::vector<double>& values) {
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// `natural` with the ends of a range and even points between: a trough between two natural frequencies that no halving of
/// their distance meets is seen if it is wider than a 16th of the range.
std::vector<double> begin_with(double from, double to, const std::vector<double>& natural) {
    constexpr int kEven = 17;
    std::vector<double> x = spaced(from, to, kEven, false);
    std::ranges::copy_if(natural, std::back_inserter(x), [&](double f) { return f > from && f < to; });
    sort_and_unite(x);
    return x;
}

/// "800..6000" or "800..6000:260" [rpm], or with units.
struct Speeds {
    double from = 0, to = 0;  ///< [rad/s]
    int count = 0;            ///< 0: adaptive
};

Speeds parse_speeds(const std::string& text) {
    const auto fail = [&](const std::string& why) {
        return Error(ExitCode::usage,
                     fmt::format("--rpm {}: {}; write --rpm 800..6000 or --rpm 800..6000:260", quote(text), why));
    };
    const auto number = [&](const std::string& part) {
        try {
            const Quantity quantity = parse_quantity(part);
            return quantity.unit == "1" ? quantity.value * kPerRpm : parse_quantity(part, "rad/s");
        } catch (const Error& error) {
            throw fail(error.what());
        }
    };
    const size_t dots = text.find("..");
    if (dots == std::string::npos) {
        const double one = number(text);
        if (!(one >= 0)) throw fail("speeds are zero or more");
        return {one, one, 1};
    }
    const size_t colon = text.find(':', dots + 2);
    Speeds speeds{number(text.substr(0, dots)), number(text.substr(dots + 2, colon - dots - 2)), 0};
    if (colon != std::string::npos) {
        const std::string count = text.substr(colon + 1);
        const bool is_number = !count.empty() && count.size() < 9 && count.find_first_not_of("0123456789") == count.npos;
        if (!is_number || std::stoi(count) < 2)
            throw fail(fmt::format("{} is no number of speeds, 2 or more", quote(count)));
        speeds.count = std::stoi(count);
    }
    if (!(speeds.from >= 0)) throw fail("speeds are zero or more");
    if (!(speeds.to > speeds.from)) throw fail("the second speed must be more than the first");
    return speeds;
}

/// Those of the loads, or of these the ones that are asked for.
std::vector<double> orders_of(const Request& request, const Model& model, const Excitation& excitation) {
    const std::vector<double> known = excitation.orders();
    if (known.empty())
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: --rpm: no load{} is an order of the speed; write order = 2 in a harmonic load, or an "
                                "unbalance{}",
                                model.path, model.load_case.empty() ? "" : " of case " + quote(model.load_case),
                                describe_left_out(model)));
    if (request.response.orders.empty()) return known;
    std::vector<double> chosen;
    for (const std::string& text : request.response.orders) {
        double order = 0;
        try {
            order = parse_quantity(text, "1");
        } catch (const Error& error) {
            throw Error(ExitCode::usage, fmt::format("--order {}: {}", quote(text), error.what()));
        }
        if (std::ranges::find(known, order) == known.end())
            throw Error(ExitCode::usage,
                        fmt::format("--order {}: no load has this order; they have {}", text, fmt::join(known, ", ")));
        chosen.push_back(order);
    }
    sort_and_unite(chosen);
    return chosen;
}

}  // namespace

OperatingPoint ResponseSweep::at(double at) const {
    return is_speed ? OperatingPoint{order * at / kWholeTurn, at, order} : OperatingPoint{at, std::nullopt, 0};
}

double ResponsePlan::highest() const {
    double highest = random_to;
    for (const ResponseSweep& sweep : sweeps) {
        if (!sweep.x.empty()) highest = std::max(highest, sweep.at(sweep.x.back()).frequency);
        if (!sweep.own.empty()) highest = std::max(highest, sweep.own.back());
    }
    return highest;
}

std::vector<double> natural_frequencies(ModalMachine& machine, double to, Warnings& warnings) {
    std::vector<double> natural;
    try {
        natural = machine.frequencies_below(to);
    } catch (const Error& error) {
        warnings.add("no-natural-frequencies",
                     fmt::format("the natural frequencies are not found, so that a narrow peak between the points may be "
                                 "missed: {}",
                                 error.what()));
    }
    std::erase_if(natural, [](double f) { return !(f > 0); });
    if (natural.size() > kMostStarts) {
        warnings.add(
            "many-natural-frequencies",
            fmt::format("{} natural frequencies lie below {:g} Hz: those above {:g} Hz are no points of their own, a "
                        "narrow peak there may be missed; give a shorter range",
                        natural.size(), to, natural[kMostStarts - 1]));
        natural.resize(kMostStarts);
    }
    return natural;
}

ResponsePlan::ResponsePlan(const Request& request, const Model& model, const Excitation& excitation, ModalMachine& machine,
                           Warnings& warnings) {
    if (!request.response.rpm.empty())
        plan_speeds(request, model, excitation, machine, warnings);
    else if (request.response.orders.empty())
        plan_frequencies(request, excitation, machine, warnings);
    else
        throw Error(ExitCode::usage, "--order: orders of which speed? give it with --rpm, as --rpm 800..6000");
}

void ResponsePlan::plan_speeds(const Request& request, const Model& model, const Excitation& excitation,
                               ModalMachine& machine, Warnings& warnings) {
    if (excitation.is_by_inputs())
        throw Error(ExitCode::usage,
                    "--rpm asks for the orders of the model's loads; with --in give frequencies, --from and --to");
    if (!request.response.from.empty() || !request.response.to.empty() || request.response.points > 0)
        throw Error(ExitCode::usage,
                    "--rpm excludes --from, --to and --points; write the number of speeds behind it, --rpm 800..6000:260");
    const std::vector<double> orders = orders_of(request, model, excitation);
    const Speeds speeds = parse_speeds(request.response.rpm);
    if (model.machine_rests_on_speed)
        warnings.add("machine-of-speed",
                     "other numbers of the model than amplitudes rest on Omega: they stay as they are at the model's own "
                     "Omega; --set Omega=.. changes them for all speeds");
    if (excitation.has_others_than_orders())
        warnings.note("no-orders", "loads that are no order of the speed do not act in the rows over speed");
    has_speeds = true;
    const bool is_adaptive = speeds.count == 0;
    std::vector<double> natural;
    if (is_adaptive) natural = natural_frequencies(machine, orders.back() * speeds.to / kWholeTurn, warnings);
    for (const double order : orders) {
        std::vector<double> critical;
        for (const double f : natural) critical.push_back(kWholeTurn * f / order);
        sweeps.push_back({is_adaptive ? begin_with(speeds.from, speeds.to, critical)
                                      : spaced(speeds.from, speeds.to, speeds.count, false),
                          {},
                          is_adaptive,
                          true,
                          order});
    }
}

void ResponsePlan::plan_frequencies(const Request& request, const Excitation& excitation, ModalMachine& machine,
                                    Warnings& warnings) {
    const bool has_range = !request.response.from.empty() || !request.response.to.empty(),
               everywhere = excitation.acts_everywhere();
    if (has_range && (request.response.from.empty() || request.response.to.empty()))
        throw Error(ExitCode::usage, "--from and --to go together");
    if (everywhere && !has_range && excitation.random_count() == 0)
        throw Error(ExitCode::usage, "which frequencies? give --from and --to, e.g. --from 1Hz --to 200Hz");
    double from = 0, to = std::numeric_limits<double>::infinity();
    if (excitation.random_count() > 0) std::tie(random_from, random_to) = excitation.random_range();
    if (has_range) {
        from = frequency_of("--from", request.response.from);
        to = frequency_of("--to", request.response.to);
        if (!(to > from)) throw Error(ExitCode::usage, "--to must be more than --from");
        if (request.response.is_logarithmic && from == 0)
            throw Error(ExitCode::usage, "--log: --from must be more than zero");
        if (excitation.random_count() > 0 && (random_from < from || random_to > to)) {
            warnings.note("density-cut",
                          fmt::format("random loads count from {:g} to {:g} Hz only: what their densities have "
                                      "outside is not in the RMS values",
                                      from, to));
            random_from = std::max(random_from, from);
            random_to = std::max(random_from, std::min(random_to, to));
        }
    } else if (everywhere) {
        std::tie(from, to) = std::pair(random_from, random_to);
    }
    if (excitation.random_count() > 0 && request.response.points > 0)
        warnings.note("own-points", "RMS values are integrals over points of their own choice, not over --points");
    if (!excitation.is_by_inputs() && !excitation.has_harmonics()) return;
    ResponseSweep sweep;
    for (const double f : excitation.own_frequencies())
        if (f >= from && f <= to) sweep.own.push_back(f);
    if (everywhere) {
        sweep.is_adaptive = request.response.points == 0;
        sweep.x = sweep.is_adaptive ? begin_with(from, to, natural_frequencies(machine, to, warnings))
                                    : spaced(from, to, request.response.points, request.response.is_logarithmic);
    } else if (sweep.own.empty()) {
        throw Error(ExitCode::usage, fmt::format("no harmonic load acts from {:g} to {:g} Hz: they act at {} Hz", from, to,
                                                 fmt::join(excitation.own_frequencies(), ", ")));
    } else if (has_range) {
        warnings.note("own-frequencies",
                      "every harmonic load has a frequency of its own: the rows are these frequencies; a harmonic without "
                      "`frequency` acts at all");
    }
    sweeps.push_back(std::move(sweep));
}

}  // namespace dttmm::host
