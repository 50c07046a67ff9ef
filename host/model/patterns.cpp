// SPDX-License-Identifier: BSD-3-Clause
#include "model/patterns.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/bolt_circle.h"
#include "model/index.h"
#include "model/name_registry.h"
#include "model/pattern_index.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

/// Values that all copies hold together: half a gigabyte of them.
constexpr int kMostCopied = 2'000'000;

/// Where a table stands decides whether a key in it is a pattern.
enum class Scope { file, body, plain };

bool is_pattern(std::string_view key, Scope scope) {
    return (key == "repeat" && scope != Scope::plain) || (key == "bolt_circle" && scope == Scope::file);
}

Scope scope_inside(std::string_view key, Scope scope) {
    return scope == Scope::file && key == "body" ? Scope::body : Scope::plain;
}

bool has_patterns(const TomlValue& document) {
    if (document.find("repeat") || document.find("bolt_circle")) return true;
    const TomlMember* bodies = document.find("body");
    const auto has_repeat = [](const TomlValue& body) { return body.find("repeat") != nullptr; };
    return bodies && std::ranges::any_of(bodies->value.items, has_repeat);
}

/// Whether a [[repeat]] makes parameters, itself or by one in it.
bool makes_parameters(const TomlValue& entry) {
    const TomlMember* inner = entry.find("repeat");
    return entry.find("parameters") || (inner && std::ranges::any_of(inner->value.items, makes_parameters));
}

/// Lists and tables of the same key become one.
void join(TomlValue& table, TomlMember member) {
    const auto found = std::ranges::find(table.members, member.key, &TomlMember::key);
    if (found == table.members.end()) {
        table.members.push_back(std::move(member));
    } else if (found->value.is_array() && member.value.is_array()) {
        std::ranges::move(member.value.items, std::back_inserter(found->value.items));
    } else if (found->value.is_table() && member.value.is_table()) {
        std::ranges::move(member.value.members, std::back_inserter(found->value.members));
    } else {
        table.members.push_back(std::move(member));  // one of them is of a wrong kind, which its reader reports
    }
}

/// What stands for nothing in the expressions of a repeat that makes parameters.
struct WithoutParameters {
    explicit WithoutParameters(Diagnostics& diagnostics)
        : parameters(nullptr, nullptr, {}, diagnostics), context{parameters, diagnostics, inputs} {}
    Parameters parameters;
    InputFiles inputs;
    ReadContext context;
};

class PatternExpander {
public:
    /// catalogue null: parameters alone are wanted.
    PatternExpander(const ReadContext& context, const ElementCatalogue* catalogue)
        : context_(context), catalogue_(catalogue), bare_(context.diagnostics) {}

    void expand_document(TomlValue& document, const std::function<void(TomlValue&)>& before_circles) {
        TomlValue expanded = expand(document, Scope::file);
        before_circles(expanded);
        for (const Circle& circle : std::vector(std::move(circles_))) make_circle(circle, expanded);
        document = std::move(expanded);
    }

    std::vector<TomlMember> take_parameters(const TomlValue& document) {
        TomlValue made;
        for (const TomlMember& member : document.members)
            if (member.key == "repeat") unroll_all(member, made, Scope::file);
        TomlMember* parameters = nullptr;
        for (TomlMember& member : made.members)
            if (member.key == "parameters") parameters = &member;
        return parameters ? std::move(parameters->value.members) : std::vector<TomlMember>();
    }

private:
    Place stamped(Place place) const {
        if (copy_ > 0) place.copy = copy_;
        return place;
    }

    void fail(Place place, const std::string& text) { context_.diagnostics.error(place, text); }

    /// Counts a value against the bound; reports it once where there are too many.
    bool count_value(Place place) {
        if (copy_ == 0) return true;
        if (++copied_ == kMostCopied + 1)
            fail(place, fmt::format("the patterns of this file make more than {} values; make them smaller", kMostCopied));
        return copied_ <= kMostCopied;
    }

    std::string substituted(const std::string& text, Place place) {
        if (indices_.empty()) return text;
        try {
            return with_indices(text, indices_, is_in_parameters_ ? Constants() : context_.parameters.constants());
        } catch (const Error& error) {
            if (error.code() != ExitCode::model_invalid) throw;
            fail(place, error.what());
            return text;
        }
    }

    TomlValue expand(const TomlValue& value, Scope scope) {
        TomlValue result;
        result.kind = value.kind;
        result.place = stamped(value.place);
        result.number = value.number;
        if (!count_value(result.place)) return result;
        result.string = substituted(value.string, result.place);
        result.items.reserve(value.items.size());
        for (const TomlValue& item : value.items) result.items.push_back(expand(item, scope));
        for (const TomlMember& member : value.members)
            if (!is_pattern(member.key, scope)) result.members.push_back(expand(member, scope));
        for (const TomlMember& member : value.members)
            if (is_pattern(member.key, scope)) unroll_all(member, result, scope);
        return result;
    }

    TomlMember expand(const TomlMember& member, Scope scope) {
        const Place place = stamped(member.place);
        return {substituted(member.key, place), place, expand(member.value, scope_inside(member.key, scope))};
    }

    void unroll_all(const TomlMember& pattern, TomlValue& target, Scope scope) {
        if (!pattern.value.is_array())
            return fail(stamped(pattern.place), fmt::format("{0} must be a list of tables; write [[{0}]]", pattern.key));
        for (const TomlValue& entry : pattern.value.items) {
            if (pattern.key == "repeat")
                unroll(entry, target, scope);
            else
                circles_.push_back({&entry, indices_, copy_});
        }
    }

    /// The keys of a pattern in the copy around it; of the tables in it, whose time comes later, the names alone.
    TomlValue head_of(const TomlValue& entry, const std::vector<std::string>& own) {
        TomlValue head;
        head.kind = entry.kind;
        head.place = stamped(entry.place);
        for (const TomlMember& member : entry.members) {
            if (std::ranges::find(own, member.key) != own.end())
                head.members.push_back(expand(member, Scope::plain));
            else
                head.members.push_back({member.key, stamped(member.place), {}});
        }
        return head;
    }

    void unroll(const TomlValue& entry, TomlValue& target, Scope scope) {
        static const std::vector<std::string> kOwn = {"index", "count", "values"};
        const bool is_bare = scope == Scope::file && makes_parameters(entry);
        if (!catalogue_ && !is_bare) return;
        const TomlValue head = head_of(entry, kOwn);
        const TableReader table(is_bare ? bare_.context : context_, head,
                                is_bare ? "repeat with parameters of its own, which are made before all others" : "repeat",
                                key_table(scope == Scope::file ? "repeat" : "body.repeat"));
        if (!table.is_valid()) return;
        const std::optional<PatternIndices> values = read_indices(table, indices_);
        if (entry.members.size() <= head_keys(entry, kOwn))
            table.error(head.place, fmt::format("it repeats nothing; write tables in it, as {}",
                                                scope == Scope::file ? "[[repeat.element]]" : "[body.repeat.markers]"));
        if (!values) return;
        for (const PatternIndex& value : *values) {
            const CopyGuard guard(*this, value);
            if (!count_value(head.place)) return;
            for (const TomlMember& member : entry.members) {
                if (std::ranges::find(kOwn, member.key) != kOwn.end()) continue;
                if (is_pattern(member.key, scope)) {
                    unroll_all(member, target, scope);
                } else if (member.key == "parameters" || catalogue_) {
                    is_in_parameters_ = member.key == "parameters";
                    TomlMember made = expand(member, scope);
                    // With a catalogue those are there already
                    if (!catalogue_ || !is_in_parameters_) join(target, std::move(made));
                    is_in_parameters_ = false;
                }
            }
        }
    }

    static std::size_t head_keys(const TomlValue& entry, const std::vector<std::string>& own) {
        return as_size(std::ranges::count_if(
            entry.members, [&](const TomlMember& member) { return std::ranges::find(own, member.key) != own.end(); }));
    }

    /// Bodies may come later than their circle: all circles are made when everything else is there.
    struct Circle {
        const TomlValue* entry;
        PatternIndices indices;
        int copy;
    };

    void make_circle(const Circle& pending, TomlValue& document) {
        indices_ = pending.indices;
        copy_ = pending.copy;
        const TomlValue& entry = *pending.entry;
        std::vector<std::string> own = names_of(key_table("bolt_circle"));
        std::erase(own, "element");
        const TomlValue head = head_of(entry, own);
        const TableReader table(context_, head, entry_label("bolt_circle", head, 0), key_table("bolt_circle"));
        if (!table.is_valid()) return;
        const TomlMember* element = entry.find("element");
        const auto index = table.find("index") ? read_index_name(table, indices_) : std::optional<std::string>("");
        const auto circle = read_bolt_circle(table, element ? &element->value : nullptr, *catalogue_);
        if (!circle || !index || !add_bolt_markers(document, *circle, table)) return;
        TomlMember elements{"element", head.place, {}};
        elements.value.kind = TomlValue::Kind::array;
        for (int k = 1; k <= circle->count; ++k) {
            const CopyGuard guard(*this, numbered_index(*index, k));
            if (!count_value(head.place)) return;
            elements.value.items.push_back(make_bolt(*circle, k, expand(element->value, Scope::plain)));
        }
        join(document, std::move(elements));
    }

    /// Sets the index for one copy.
    class CopyGuard {
    public:
        CopyGuard(PatternExpander& expander, const PatternIndex& index) : expander_(expander), outer_(expander.copy_) {
            expander.indices_.push_back(index);
            expander.copy_ = ++expander.copies_;
        }
        ~CopyGuard() {
            expander_.indices_.pop_back();
            expander_.copy_ = outer_;
        }
        CopyGuard(const CopyGuard&) = delete;
        CopyGuard& operator=(const CopyGuard&) = delete;

    private:
        PatternExpander& expander_;
        int outer_;
    };

    const ReadContext& context_;
    const ElementCatalogue* catalogue_;
    WithoutParameters bare_;
    PatternIndices indices_;
    std::vector<Circle> circles_;
    int copy_ = 0, copies_ = 0, copied_ = 0;
    bool is_in_parameters_ = false;
};

}  // namespace

void expand_parameters(TomlValue& document) {
    const TomlMember* repeat = document.find("repeat");
    if (!repeat || !repeat->value.is_array() || std::ranges::none_of(repeat->value.items, makes_parameters)) return;
    Diagnostics unheard("");
    const WithoutParameters none(unheard);
    std::vector<TomlMember> made = PatternExpander(none.context, nullptr).take_parameters(document);
    if (made.empty()) return;
    TomlMember parameters{"parameters", made.front().place, {}};
    parameters.value.place = parameters.place;
    parameters.value.members = std::move(made);
    join(document, std::move(parameters));
}

void expand_patterns(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue,
                     const std::function<void(TomlValue&)>& before_circles) {
    if (!has_patterns(document)) return before_circles(document);
    PatternExpander(context, &catalogue).expand_document(document, before_circles);
}

}  // namespace dttmm::host
