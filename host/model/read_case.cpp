// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "model/error.h"
#include "model/index.h"
#include "model/name_registry.h"
#include "model/names.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

/// A signal times a factor.
class ScaledSignal : public Signal::Shape {
public:
    ScaledSignal(Signal signal, double factor) : signal_(std::move(signal)), factor_(factor) {}
    double value(double time) const override { return factor_ * signal_.value(time); }
    std::optional<std::vector<SignalPart>> parts() const override {
        return factor_ == 0 ? std::vector<SignalPart>() : signal_.parts();  // shares of its largest value
    }

private:
    Signal signal_;
    double factor_;
};

Signal scaled(const Signal& signal, double factor) {
    return factor == 1 ? signal : Signal(std::make_shared<ScaledSignal>(signal, factor));
}

/// A case as written: names with their factors.
struct Written {
    struct Term {
        std::string name;
        double factor;
        Place place;
    };
    std::vector<Term> loads, cases;
    std::optional<double> gravity;
    bool is_done = false, is_open = false;  ///< its factors are known; they are being found
};

class Reader {
public:
    Reader(const TableReader& file, const Model& model) : file_(file), model_(model) {
        for (const Load& load : model.loads) add_name(load.name);
        for (const Node& node : model.nodes)
            if (node.is_support()) add_name(node.name);
    }

    std::vector<LoadCase> read() {
        const std::vector<TomlValue>& entries = read_entries(file_, "case");
        for (size_t i = 0; i < entries.size(); ++i) read(entries[i], i);
        for (size_t c = 0; c < cases_.size(); ++c) resolve(c);
        if (!cases_.empty() && !file_.context().diagnostics.has_errors()) warn_unnamed();
        return std::move(cases_);
    }

private:
    void add_name(const std::string& name) {
        if (!name.empty() && std::ranges::find(names_, name) == names_.end()) names_.push_back(name);
    }

    void read(const TomlValue& entry, size_t index) {
        const TableReader table(file_.context(), entry, entry_label("case", entry, index), key_table("case"),
                                entry_note("case", index));
        if (!table.is_valid()) return;
        LoadCase load_case;
        load_case.place = file_.context().diagnostics.place_text(entry.place);
        load_case.name = read_free_name(table, "case");
        load_case.load_factors.assign(model_.loads.size(), 0);
        load_case.motion_factors.assign(model_.nodes.size(), 0);
        if (const TomlMember* name = table.find("name")) {
            if (load_case.name.empty() && name->value.is_text()) table.error(name->value.place, "a name must not be empty");
            for (const LoadCase& other : cases_)
                if (other.name == load_case.name)
                    table.error(name->value.place, fmt::format("there is a case {} already, at {}; give each case a name of "
                                                               "its own",
                                                               quote(other.name), other.place));
        }
        Written written;
        if (const TomlMember* loads = table.find("loads")) read_list(table, *loads, written.loads);
        if (const TomlMember* factors = table.find("factors")) read_factors(table, *factors, written.loads);
        if (const TomlMember* cases = table.find("cases")) read_factors(table, *cases, written.cases);
        if (table.find("gravity")) written.gravity = table.number("gravity");
        if (!table.find("loads") && !table.find("factors") && !table.find("cases") && !table.find("gravity"))
            table.error(entry.place,
                        "nothing acts in it; write loads = [\"snow\"], factors = { snow = 1.5 }, or gravity = 1");
        for (const Written::Term& term : written.loads) take_load(table, term, load_case);
        cases_.push_back(std::move(load_case));
        written_.push_back(std::move(written));
    }

    void read_list(const TableReader& table, const TomlMember& member, std::vector<Written::Term>& terms) {
        if (!member.value.is_array())
            return table.error(member.value.place, fmt::format("loads must be a list of names, got {}; factors = {{ snow = "
                                                               "1.5 }} has factors",
                                                               kind_text(member.value.kind)));
        for (const TomlValue& item : member.value.items) {
            if (!item.is_text())
                table.error(item.place, fmt::format("loads wants names, got {}", kind_text(item.kind)));
            else
                add_term(table, {normalise_name(item.string), 1, item.place}, terms);
        }
    }

    void read_factors(const TableReader& table, const TomlMember& member, std::vector<Written::Term>& terms) {
        if (!member.value.is_table())
            return table.error(member.value.place, fmt::format("{} must be a table of name = factor, got {}", member.key,
                                                               kind_text(member.value.kind)));
        for (const TomlMember& one : member.value.members) {
            const auto factor = read_number(table.context(), one.value, table.what(member.key) + "." + one.key, "1");
            if (factor) add_term(table, {normalise_name(one.key), *factor, one.place}, terms);
        }
    }

    static void add_term(const TableReader& table, const Written::Term& term, std::vector<Written::Term>& terms) {
        if (std::ranges::find(terms, term.name, &Written::Term::name) != terms.end())
            return table.error(term.place, fmt::format("{} is named twice; give it one factor", quote(term.name)));
        terms.push_back(term);
    }

    /// All loads of the name, and the motion of the node of the name.
    void take_load(const TableReader& table, const Written::Term& term, LoadCase& load_case) const {
        bool is_known = false;
        for (size_t i = 0; i < model_.loads.size(); ++i)
            if (model_.loads[i].name == term.name) {
                load_case.load_factors[i] = term.factor;
                is_known = true;
            }
        for (size_t n = 0; n < model_.nodes.size(); ++n)
            if (model_.nodes[n].name == term.name && model_.nodes[n].is_support()) {
                load_case.motion_factors[n] = term.factor;
                is_known = true;
            }
        if (is_known || model_.loads.size() < read_entries(file_, "load").size()) return;  // its own fault is reported
        const bool are_named = !names_.empty();
        table.error(term.place, fmt::format("there is no load {}{}", quote(term.name),
                                            are_named ? suggestion(term.name, names_)
                                                      : fmt::format("; give the load a name = {}", quote(term.name))));
    }

    /// Adds the cases that a case names; those first.
    void resolve(size_t c) {
        Written& written = written_[c];
        if (written.is_done) return;
        written.is_open = true;
        double gravity = written.cases.empty() ? 1 : 0;
        for (const Written::Term& term : written.cases) {
            const auto found = std::ranges::find(cases_, term.name, &LoadCase::name);
            if (found == cases_.end()) {
                std::vector<std::string> names;
                for (const LoadCase& one : cases_) names.push_back(one.name);
                file_.error(term.place, fmt::format("case {}: there is no case {}{}", quote(cases_[c].name),
                                                    quote(term.name), suggestion(term.name, names)));
                continue;
            }
            const auto other = as_size(as_int(found - cases_.begin()));
            if (written_[other].is_open) {
                file_.error(term.place, fmt::format("case {}: it is a part of itself by case {}; name loads, or cases that "
                                                    "do not lead back",
                                                    quote(cases_[c].name), quote(term.name)));
                continue;
            }
            resolve(other);
            for (size_t i = 0; i < model_.loads.size(); ++i)
                cases_[c].load_factors[i] += term.factor * cases_[other].load_factors[i];
            for (size_t n = 0; n < model_.nodes.size(); ++n)
                cases_[c].motion_factors[n] += term.factor * cases_[other].motion_factors[n];
            gravity += term.factor * cases_[other].gravity;
        }
        cases_[c].gravity = written.gravity.value_or(gravity);
        written.is_open = false;
        written.is_done = true;
    }

    void warn_unnamed() const {
        const auto is_in_none = [&](const auto& factor_of) {
            return std::ranges::none_of(cases_, [&](const LoadCase& one) { return factor_of(one) != 0; });
        };
        const auto warn = [&](Place place, const std::string& what) {
            file_.warning(place, "load-in-no-case", what + " acts in no case; name it in one");
        };
        const std::vector<TomlValue>& entries = read_entries(file_, "load");
        for (size_t i = 0; i < model_.loads.size() && i < entries.size(); ++i)
            if (is_in_none([&](const LoadCase& one) { return one.load_factors[i]; }))
                warn(entries[i].place, model_.loads[i].name.empty() ? std::string("a load without a name")
                                                                    : fmt::format("load {}", quote(model_.loads[i].name)));
        const TomlMember* nodes = file_.find("nodes");
        for (size_t n = 0; n < model_.nodes.size(); ++n)
            if (model_.nodes[n].is_support() && is_in_none([&](const LoadCase& one) { return one.motion_factors[n]; }))
                warn(nodes->value.members[n].place, fmt::format("the motion of node {}", quote(model_.nodes[n].name)));
    }

    const TableReader& file_;
    const Model& model_;
    std::vector<std::string> names_;  ///< of loads and moved nodes
    std::vector<LoadCase> cases_;
    std::vector<Written> written_;
};

}  // namespace

std::vector<LoadCase> read_cases(const TableReader& file, const Model& model) { return Reader(file, model).read(); }

const LoadCase& find_case(const Model& model, const std::string& name) {
    const auto found = std::ranges::find(model.cases, normalise_name(name), &LoadCase::name);
    if (found != model.cases.end()) return *found;
    std::vector<std::string> names;
    for (const LoadCase& one : model.cases) names.push_back(one.name);
    throw Error(ExitCode::usage,
                fmt::format("--case {}: {}", quote(name),
                            names.empty() ? fmt::format("{} has no [[case]]", model.path)
                                          : fmt::format("there is no case {}{}", quote(name), suggestion(name, names))));
}

void apply_case(Model& model, const LoadCase& load_case) {
    model.simulation.gravity *= load_case.gravity;
    for (size_t i = 0; i < model.loads.size(); ++i) {
        Load& load = model.loads[i];
        load.vibration_factor = load_case.load_factors[i];
        load.signal = scaled(load.signal, load_case.load_factors[i]);
        if (load.signal_at_to) load.signal_at_to = scaled(*load.signal_at_to, load_case.load_factors[i]);
    }
    for (size_t n = 0; n < model.nodes.size(); ++n) model.nodes[n].vibration_factor = load_case.motion_factors[n];
    for (size_t n = 0; n < model.nodes.size(); ++n)
        for (auto& signal : model.nodes[n].motion)
            if (signal) signal = scaled(*signal, load_case.motion_factors[n]);
}

}  // namespace dttmm::host
