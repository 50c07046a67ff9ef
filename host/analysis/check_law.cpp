// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/check_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "loader/law_library.h"
#include "loader/plugin_call.h"
#include "loader/plugin_library.h"
#include "model/error.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

using Answer = dttmm_law_answer;
using Memory = std::vector<double>;

constexpr int kSets = 60, kPaths = 25;
/// Reach of the deformations, and of parameters that are not given [SI]: decades.
constexpr double kLeastReach = -6, kMostReach = -1, kLeastValue = -1, kMostValue = 6;
/// Of the differences that stand for tangents, as share of the reach, and how near a tangent must be to one.
constexpr double kDifference = 1e-6, kNear = 1e-4;
/// Of energies and forces, as share of the largest: rounding of a few operations.
constexpr double kRounding = 1e-9;

/// Asks one law, and remembers the first fault of each kind.
class Examination {
public:
    Examination(const dttmm_law& law, const Request& request) : law_(law), request_(request) {}

    void run() {
        for (int set = 0; set < kSets; ++set) {
            const double reach = std::pow(10, uniform(kLeastReach, kMostReach));
            draw_values(reach);
            walk(reach);
        }
    }
    size_t paths() const { return paths_; }
    size_t paths_with_force() const { return paths_with_force_; }
    const std::map<std::string, std::string>& faults() const { return faults_; }

private:
    struct Asked {
        Answer answer;
        Memory after;
    };

    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53; }

    /// Lengths are drawn about the reach of the deformations.
    void draw_values(double reach) {
        values_.clear();
        for (const dttmm_law_parameter& parameter : std::span(law_.parameters, law_.parameter_count)) {
            const bool is_length = measures(parameter.unit, "m") && std::string_view(parameter.unit) != "1";
            const double size =
                is_length ? reach * std::pow(10, uniform(-1.5, 0.5)) : std::pow(10, uniform(kLeastValue, kMostValue));
            double value = parameter.minimum < 0 && uniform(0, 1) < 0.5 ? -size : size;
            for (const auto& [name, text] : request_.overrides.parameters)
                if (name == parameter.name) value = parse_quantity(text, parameter.unit);
            values_.push_back(std::max(value, parameter.minimum));
        }
    }

    Asked ask(double from, double to, const Memory& memory) {
        constexpr size_t kGuard = 64;  // numbers behind the memory that must stay
        constexpr double kUntouched = -7.25;
        Asked asked{{}, Memory(law_.memory_count + kGuard, kUntouched)};
        std::fill_n(asked.after.begin(), law_.memory_count, 0.0);
        const Memory given = memory;
        const dttmm_law_path path{from, to, from == to ? 0 : time_, memory.data(), asked.after.data()};
        *LawLibrary::at_work() = &law_;
        law_.along(values_.data(), &path, &asked.answer);
        *LawLibrary::at_work() = nullptr;
        if (given != memory) fault("it changes the memory it is given", "");
        if (std::any_of(asked.after.begin() + law_.memory_count, asked.after.end(),
                        [](double x) { return x != kUntouched; }))
            fault("it writes more numbers than its memory has", "");
        asked.after.resize(law_.memory_count);
        return asked;
    }

    void fault(const char* rule, const std::string& figures) {
        if (faults_.contains(rule)) return;
        std::string given;
        for (size_t p = 0; p < values_.size(); ++p)
            given += fmt::format("{}{} = {:.6g}", p > 0 ? ", " : "", law_.parameters[p].name, values_[p]);
        faults_[rule] = fmt::format("{}{}{}", figures, figures.empty() || given.empty() ? "" : "; ", given);
    }

    static bool is_finite(const Asked& asked) {
        const Answer& a = asked.answer;
        return std::isfinite(a.force) && std::isfinite(a.tangent) && std::isfinite(a.mean) &&
               std::isfinite(a.mean_tangent) && std::isfinite(a.stored) && std::isfinite(a.dissipated) &&
               std::ranges::all_of(asked.after, [](double x) { return std::isfinite(x); });
    }
    static bool is_same(const Asked& a, const Asked& b) {
        const Answer &p = a.answer, &q = b.answer;
        return p.force == q.force && p.tangent == q.tangent && p.mean == q.mean && p.mean_tangent == q.mean_tangent &&
               p.stored == q.stored && p.dissipated == q.dissipated && a.after == b.after;
    }

    /// Between the differences to either side, where the law has a kink.
    static bool is_derivative(double tangent, double at, double less, double more, double e, double scale) {
        const double left = (at - less) / e, right = (more - at) / e;
        const double slack = kNear * std::max({std::abs(left), std::abs(right), std::abs(tangent)}) + 1e-14 * scale / e;
        return tangent >= std::min(left, right) - slack && tangent <= std::max(left, right) + slack;
    }

    /// Random straight paths, one after the other, within a reach, from the undeformed state.
    void walk(double reach) {
        Memory memory(law_.memory_count, 0);
        Answer before = ask(0, 0, memory).answer;
        if (before.force != 0 || before.stored != 0)
            fault("undeformed it has a force or energy", fmt::format("{:.6g}, {:.6g}", before.force, before.stored));
        double from = 0, earlier = 0, force = 0, energy = 0;  // forces and energies: largest
        for (int path = 0; path < kPaths; ++path) {
            const double to = uniform(-reach, reach);
            time_ = std::pow(10, uniform(-6, 0));
            ++paths_;
            const Asked asked = ask(from, to, memory);
            if (!is_finite(asked)) return fault("its answer is not finite", fmt::format("path {:.6g} to {:.6g}", from, to));
            force = std::max({force, std::abs(asked.answer.force), std::abs(asked.answer.mean)});
            energy = std::max({energy, std::abs(asked.answer.stored), std::abs(asked.answer.mean * (to - from))});
            paths_with_force_ += asked.answer.force != 0;
            look_at_rest(from, from - earlier, before, memory, kDifference * reach, force, energy);
            look_at_path(from, to, before, memory, asked, reach, force, energy);
            before = asked.answer;
            memory = asked.after;
            earlier = std::exchange(from, to);
        }
        time_ = 0;  // slow, as where a machine starts
        const double to = uniform(-reach, reach);
        if (!is_finite(ask(0, to, Memory(law_.memory_count, 0))))
            fault("its answer is not finite", fmt::format("path {:.6g} to {:.6g} that takes no time", 0., to));
    }

    /// A path of no length changes nothing. way: of the path before.
    void look_at_rest(double at, double way, const Answer& before, const Memory& memory, double e, double force,
                      double energy) {
        const Asked rest = ask(at, at, memory);
        if (!is_finite(rest)) return fault("its answer is not finite", fmt::format("path of no length at {:.6g}", at));
        if (std::abs(rest.answer.force - before.force) > kRounding * force)
            fault("a path of no length changes its force",
                  fmt::format("from {:.6g} to {:.6g}", before.force, rest.answer.force));
        const double time = std::exchange(time_, 1e-15);  // at once: no rate has an effect
        const Answer less = ask(at, at - e, memory).answer, more = ask(at, at + e, memory).answer;
        time_ = time;
        if (!is_derivative(rest.answer.tangent, rest.answer.force, less.force, more.force, e, force))
            fault("on a path of no length its tangent is not that of unloading",
                  fmt::format("{:.6g}; differences {:.6g} and {:.6g}", rest.answer.tangent,
                              (rest.answer.force - less.force) / e, (more.force - rest.answer.force) / e));
        // Where the two differ for what it remembers, as in a slider that gives way
        const double back = way > 0 ? rest.answer.force - less.force : more.force - rest.answer.force;
        if (law_.memory_count > 0 && way != 0 && !is_derivative(rest.answer.tangent, 0, -back, back, e, force))
            fault("on a path of no length its tangent is not that of going back",
                  fmt::format("{:.6g}; the difference back is {:.6g}", rest.answer.tangent, back / e));
        if (std::abs(rest.answer.mean - rest.answer.force) > kRounding * force ||
            std::abs(rest.answer.dissipated) > kRounding * energy)
            fault("on a path of no length its mean force is not its force, or it dissipates",
                  fmt::format("{:.6g}, {:.6g}, {:.6g}", rest.answer.mean, rest.answer.force, rest.answer.dissipated));
        for (size_t m = 0; m < memory.size(); ++m)
            if (std::abs(rest.after[m] - memory[m]) > kRounding * (std::abs(memory[m]) + std::abs(at)))
                fault("a path of no length changes its memory",
                      fmt::format("from {:.6g} to {:.6g}", memory[m], rest.after[m]));
    }

    void look_at_path(double from, double to, const Answer& before, const Memory& memory, const Asked& asked, double reach,
                      double force, double energy) {
        const Answer& now = asked.answer;
        const double e = kDifference * reach;
        const Answer less = ask(from, to - e, memory).answer, more = ask(from, to + e, memory).answer;
        if (!is_same(asked, ask(from, to, memory))) fault("it answers the same question in two ways", "");
        if (!is_derivative(now.tangent, now.force, less.force, more.force, e, force))
            fault("its tangent is not the derivative of its force",
                  fmt::format("{:.6g}; differences {:.6g} and {:.6g}", now.tangent, (now.force - less.force) / e,
                              (more.force - now.force) / e));
        if (std::abs(to - from) > 100 * e && !is_derivative(now.mean_tangent, now.mean, less.mean, more.mean, e, force))
            fault("its mean_tangent is not the derivative of its mean force",
                  fmt::format("{:.6g}; differences {:.6g} and {:.6g}", now.mean_tangent, (now.mean - less.mean) / e,
                              (more.mean - now.mean) / e));
        if (now.dissipated < -kRounding * energy)
            fault("it dissipates less than nothing", fmt::format("{:.6g}", now.dissipated));
        const double work = now.mean * (to - from), kept = now.stored - before.stored + now.dissipated;
        if (std::abs(work - kept) > kRounding * energy)
            fault("its mean force does not do what it stores and dissipates", fmt::format("{:.6g}, {:.6g}", work, kept));
        if (law_.memory_count > 0) return;
        // Elastic: the path does not matter, and a closed path does no work
        const double other = uniform(-reach, reach);
        const Answer back = ask(to, other, memory).answer, round = ask(other, from, memory).answer,
                     elsewhere = (time_ *= 0.37, ask(other, to, memory).answer);
        energy = std::max(
            {energy, std::abs(back.stored), std::abs(back.mean * (other - to)), std::abs(round.mean * (from - other))});
        if (std::abs(elsewhere.force - now.force) > kRounding * force)
            fault("it is elastic, but its force depends on the path or the time",
                  fmt::format("{:.6g}, {:.6g}", now.force, elsewhere.force));
        const double loop = work + back.mean * (other - to) + round.mean * (from - other);
        if (std::abs(loop) > kRounding * energy)
            fault("it is elastic, but does work on a closed path", fmt::format("{:.6g} of {:.6g}", loop, energy));
    }

    const dttmm_law& law_;
    const Request& request_;
    std::mt19937_64 random_{1};
    std::vector<double> values_;
    std::map<std::string, std::string> faults_;  ///< by rule, with figures
    size_t paths_ = 0, paths_with_force_ = 0;
    double time_ = 1e-3;  ///< of a path [s]
};

void refuse_values_out_of_range(const std::vector<const dttmm_law*>& laws, const Request& request) {
    for (const dttmm_law* law : laws)
        for (const dttmm_law_parameter& parameter : std::span(law->parameters, law->parameter_count))
            for (const auto& [name, text] : request.overrides.parameters)
                if (name == parameter.name && !(parse_quantity(text, parameter.unit) >= parameter.minimum))
                    throw Error(ExitCode::usage, fmt::format("--set {}={}: it must be at least {:g} {}", name, text,
                                                             parameter.minimum, parameter.unit));
}

void refuse_texts(const std::vector<const dttmm_law*>& laws, const std::string& library) {
    const auto fail = [&](const dttmm_law& law, const std::string& fault) {
        throw Error(ExitCode::plugin_failure, fmt::format("{}: law \"{}\": {}", library, law.name, fault));
    };
    for (const dttmm_law* law : laws) {
        if (law->documentation && !is_printable(law->documentation)) fail(*law, "its documentation is not one line of text");
        for (const dttmm_law_parameter& parameter : std::span(law->parameters, law->parameter_count)) {
            if (parameter.documentation && !is_printable(parameter.documentation))
                fail(*law, fmt::format("the documentation of {} is not one line of text", parameter.name));
            for (const char* unit : {parameter.unit, parameter.rotation_unit}) try {
                    if (std::string_view(unit) != "1") parse_quantity(fmt::format("1 {}", unit));
                } catch (const Error& error) {
                    fail(*law, fmt::format("{} has a unit that cannot be read: {}", parameter.name, error.what()));
                }
        }
    }
}

}  // namespace

void check_law(const Request& request) {
    const SharedLibrary library(request.words.front());
    const std::vector<const dttmm_law*> laws = LawLibrary::laws_of(library);
    if (laws.empty())
        throw Error(ExitCode::plugin_failure,
                    fmt::format("{}: it exports no {}: there is no law in it", library.name(), DTTMM_LAW_ENTRY));
    for (const dttmm_law* law : laws) PluginLibrary::built_in().add_law(*law);  // looks at how it is declared
    refuse_texts(laws, library.name());
    for (const auto& [name, text] : request.overrides.parameters)
        if (std::ranges::none_of(laws, [&, own = name](const dttmm_law* law) {
                return std::ranges::any_of(std::span(law->parameters, law->parameter_count),
                                           [&](const dttmm_law_parameter& one) { return own == one.name; });
            }))
            throw Error(ExitCode::usage, fmt::format("--set {}: no law has a parameter of that name", name));
    refuse_values_out_of_range(laws, request);
    std::string faults;
    for (const dttmm_law* law : laws) {
        Examination examination(*law, request);
        const PluginCall at_work(library.name());
        try {
            examination.run();
        } catch (const Error&) {
            throw;
        } catch (...) {
            throw Error(ExitCode::plugin_failure,
                        fmt::format("{}: law \"{}\": {}", library.name(), law->name, describe_exception()));
        }
        refuse_changed_arithmetic(library.name());
        if (examination.faults().empty())
            fmt::print("law \"{}\": keeps all rules, {} paths with {} sets of parameters, {} of them with a force\n",
                       law->name, examination.paths(), kSets, examination.paths_with_force());
        for (const auto& [rule, figures] : examination.faults())
            faults += fmt::format("{}law \"{}\": {}{}", faults.empty() ? "" : "\n", law->name, rule,
                                  figures.empty() ? "" : fmt::format(" ({})", figures));
    }
    if (!faults.empty()) throw Error(ExitCode::plugin_failure, fmt::format("{}: {}", library.name(), faults));
}

}  // namespace dttmm::host
