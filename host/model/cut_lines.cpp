// SPDX-License-Identifier: BSD-3-Clause
#include "model/cut_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "model/index.h"
#include "model/name_registry.h"
#include "model/names.h"
#include "model/tree_places.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

/// Of the distance of the ends: lengths typed with seven digits differ by less. The sections are then scaled to the
/// distance, which moves frequencies by up to twice as much.
constexpr double kLengthTolerance = 1e-6;
/// Of a line's length: a probe nearer to a node makes a part so stiff that `dttmm static` loses the forces in rounding. A
/// tube of 1 m with a weight at its end rests with parts down to 3e-4 of it, and not with one of 1e-4.
constexpr double kShortestPart = 1e-3;

std::string text_of(const TomlValue& table, const char* key) {
    const TomlMember* member = table.find(key);
    return member && member->value.is_text() ? normalise_name(member->value.string) : std::string();
}

/// A part of a line that is an element.
struct Part {
    std::string name;
    double start, length;  ///< from the `from` end of the line [m]
    double segment = 0;    ///< length of a lump before the first cut [m]; 0: it is not cut
};

class LineCutter {
public:
    LineCutter(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue)
        : document_(document), context_(context), catalogue_(catalogue) {
        document_.members.reserve(document_.members.size() + 1);  // add_node() may add "nodes" beside entries at hand
    }

    void divide_sections() {
        TomlValue* elements = find_list("element");
        if (!elements) return;
        std::vector<TomlValue> all;
        for (std::size_t i = 0; i < elements->items.size(); ++i) {
            TomlValue& entry = elements->items[i];
            if (entry.is_table() && entry.find("sections") && line_type(entry))
                divide(entry, entry_label("element", entry, i), all);
            else
                all.push_back(std::move(entry));
        }
        elements->items = std::move(all);
    }

    void add_probes() {
        TomlValue* probes = find_list("probe");
        if (!probes) return;
        NameRegistry names("probe");
        for (std::size_t i = 0; i < probes->items.size(); ++i) {
            const TomlValue& entry = probes->items[i];
            const TableReader table(context_, entry, entry_label("probe", entry, i), key_table("probe"),
                                    entry_note("probe", i));
            if (!table.is_valid()) continue;
            const std::string name = names.add_from(table);
            const auto on = table.text("on");
            if (name.empty() || !on) continue;
            add_probe(table, name, normalise_name(*on));
        }
        std::erase_if(document_.members, [](const TomlMember& member) { return member.key == "probe"; });
    }

    /// A force per length on a line of several parts becomes one on each.
    void share_loads() {
        TomlValue* loads = find_list("load");
        if (!loads || lines_.empty()) return;
        std::vector<TomlValue> all;
        for (TomlValue& load : loads->items) {
            const auto line = lines_.find(text_of(load, "element"));
            if (line == lines_.end() || line->second.size() == 1) {
                all.push_back(std::move(load));
                continue;
            }
            const TomlMember* size = load.find("force_per_length");
            if (size && size->value.is_array())
                context_.diagnostics.error(
                    size->value.place,
                    fmt::format(
                        "element {} has sections or probes: a force_per_length on it has one value; write one for each "
                        "of its parts, {}",
                        quote(line->first), listed(names_of_parts(line->second))));
            for (const Part& part : line->second) {
                all.push_back(load);
                set_member(all.back(), "element", text_value(part.name, load.find("element")->value.place));
            }
        }
        loads->items = std::move(all);
    }

    std::vector<std::string> take_markers() { return std::move(markers_); }

private:
    /// The entries of a table of the file that is a list; null where there is none.
    TomlValue* find_list(std::string_view key) {
        for (TomlMember& member : document_.members)
            if (member.key == key && member.value.is_array()) return &member.value;
        return nullptr;
    }

    static std::vector<std::string> names_of_parts(const std::vector<Part>& parts) {
        std::vector<std::string> names;
        for (const Part& part : parts) names.push_back(part.name);
        return names;
    }

    const dttmm_element_type* line_type(const TomlValue& entry) const {
        const int type = catalogue_.find(text_of(entry, "type"));
        if (type < 0 || !takes_line_loads(*catalogue_.types[as_size(type)])) return nullptr;
        return catalogue_.types[as_size(type)];
    }

    struct Ends {
        Eigen::Vector3d from, to;
        double length() const { return (to - from).norm(); }
    };

    /// Nothing where an end is faulty, which its reader reports.
    std::optional<Ends> ends_of(const TomlValue& entry) const {
        const auto from = find_tree_place(context_, document_, text_of(entry, "from"));
        const auto to = find_tree_place(context_, document_, text_of(entry, "to"));
        return from && to && *from != *to ? std::optional(Ends{*from, *to}) : std::nullopt;
    }

    void add_node(const std::string& name, const Eigen::Vector3d& position, Place place) {
        TomlValue& nodes = member_of(document_, "nodes", TomlValue::Kind::table);
        nodes.members.push_back({name, place, list_value({position.x(), position.y(), position.z()}, place)});
    }

    /// Lengths of the sections of an element; nothing where one is faulty, which is reported.
    std::optional<std::vector<double>> read_lengths(const TomlValue& sections, const std::string& label) const {
        const auto fail = [&](Place place, const std::string& text) {
            context_.diagnostics.error(place, label + ": " + text);
            return std::nullopt;
        };
        const char* kForm =
            "sections must be a list of tables, as [{ length = \"90 mm\", section = { circle = \"50 mm\" } }, ...]";
        if (!sections.is_array() || sections.items.empty()) return fail(sections.place, kForm);
        std::vector<double> lengths;
        for (const TomlValue& item : sections.items) {
            if (!item.is_table()) return fail(item.place, kForm);
            for (const char* key : {"name", "type", "from", "to", "sections"})
                if (const TomlMember* member = item.find(key))
                    return fail(member->place, fmt::format("{} is not of a section; leave it out", key));
            const TomlMember* length = item.find("length");
            if (!length) return fail(item.place, "a section without length");
            const Key& key = *find_key(key_table("section"), "length");
            const auto number = read_number(context_, length->value, label + ": length", key.unit, key.bounds);
            if (!number) return std::nullopt;
            lengths.push_back(*number);
        }
        return lengths;
    }

    void divide(const TomlValue& entry, const std::string& label, std::vector<TomlValue>& all) {
        const TomlMember& sections = *entry.find("sections");
        const auto fail = [&](const std::string& text) { context_.diagnostics.error(sections.place, label + ": " + text); };
        const auto lengths = read_lengths(sections.value, label);
        const auto ends = ends_of(entry);
        const std::string name = text_of(entry, "name");
        if (!lengths || name.empty()) return;
        if (!ends)
            return fail(
                "its sections lie on the line from `from` to `to`: both must be bodies, markers or nodes, and apart");
        double total = 0;
        for (const double length : *lengths) total += length;
        if (std::abs(total - ends->length()) > kLengthTolerance * ends->length())
            return fail(fmt::format("the sections are {} m long together, but its ends are {} m apart", number_text(total),
                                    number_text(ends->length())));
        std::vector<Part>& parts = lines_[name];
        double start = 0;
        std::string from = entry.find("from")->value.string;
        for (std::size_t k = 0; k < lengths->size(); ++k) {
            const bool is_last = k + 1 == lengths->size();
            const TomlValue& section = sections.value.items[k];
            const std::string to = is_last ? entry.find("to")->value.string : fmt::format("{}_{}", name, k + 1);
            parts.push_back({fmt::format("{}{}", name, k + 1), start, (*lengths)[k]});
            TomlValue part = entry;
            std::erase_if(part.members, [](const TomlMember& member) { return member.key == "sections"; });
            part.place = section.place;
            for (const TomlMember& member : section.members)
                if (member.key != "length") set_member(part, member.key, member.value);
            set_member(part, "name", text_value(parts.back().name, entry.find("name")->value.place));
            set_member(part, "from", text_value(from, entry.find("from")->value.place));
            set_member(part, "to", text_value(to, entry.find("to")->value.place));
            all.push_back(std::move(part));
            start += (*lengths)[k];
            if (!is_last) add_node(to, ends->from + (ends->to - ends->from) * (start / total), section.place);
            from = to;
        }
    }

    void add_probe(const TableReader& table, const std::string& name, const std::string& on) {
        if (TomlValue* body = find_named("body", on)) {
            if (const TomlMember* at = table.find("at"))
                return table.error(at->place, "at is for a probe on a beam or rod; on a body write position = [x, y, z]");
            const TomlMember* position = table.require("position");
            if (!position) return;
            member_of(*body, "markers", TomlValue::Kind::table)
                .members.push_back({name, table.find("name")->value.place, position->value});
            markers_.push_back(on + "." + name);
            return;
        }
        if (const TomlMember* position = table.find("position"))
            return table.error(position->place, "position is for a probe on a body; on a beam or rod write at = \"0.3 m\"");
        const auto at = table.number("at");
        if (at) probe_line(table, name, on, *at);
    }

    TomlValue* find_named(std::string_view kind, const std::string& name) {
        TomlValue* list = find_list(kind);
        if (!list) return nullptr;
        const auto found =
            std::ranges::find_if(list->items, [&](const TomlValue& entry) { return text_of(entry, "name") == name; });
        return found == list->items.end() ? nullptr : &*found;
    }

    void probe_line(const TableReader& table, const std::string& name, const std::string& on, double at) {
        const Place place = table.find("on")->value.place;
        if (!lines_.contains(on)) {
            const TomlValue* entry = find_named("element", on);
            if (!entry) return table.error(place, fmt::format("on: there is no body or element {}{}", quote(on), known(on)));
            if (!line_type(*entry))
                return table.error(
                    place,
                    fmt::format("on: element {} is no beam or rod; its force is recorded without a probe", quote(on)));
            const auto ends = ends_of(*entry);
            if (!ends) return;
            lines_[on] = {{on, 0, ends->length()}};
        }
        std::vector<Part>& parts = lines_[on];
        const double length = parts.back().start + parts.back().length;
        const auto part = std::ranges::find_if(parts, [&](const Part& p) { return at < p.start + p.length; });
        if (at > length)
            return table.error(table.find("at")->value.place,
                               fmt::format("at: the line is {} m long, got {} m", number_text(length), number_text(at)));
        const double least = kShortestPart * length;
        if (part == parts.end() || at - part->start < least || part->start + part->length - at < least)
            return table.error(
                table.find("at")->value.place,
                fmt::format(
                    "at: a node or an end is {:.4g} m away, and its motion is recorded already; place the probe at least "
                    "{:.4g} m away, or leave it out",
                    part == parts.end() ? 0 : std::min(at - part->start, part->start + part->length - at), least));
        Part behind{on + "_" + name, at, part->start + part->length - at};
        cut(*part, behind, name, table.find("name")->value.place);
        part->length = at - part->start;
        parts.insert(part + 1, behind);
    }

    /// Shortens the element of a part and puts a new one behind it.
    void cut(Part& part, Part& behind, const std::string& node, Place place) {
        TomlValue& elements = *find_list("element");
        const auto entry =
            std::ranges::find_if(elements.items, [&](const TomlValue& one) { return text_of(one, "name") == part.name; });
        const Ends ends = *ends_of(*entry);
        add_node(node, ends.from + (ends.to - ends.from) * ((behind.start - part.start) / part.length), place);
        TomlValue second = *entry;
        set_member(second, "name", text_value(behind.name, place));
        set_member(second, "from", text_value(node, place));
        set_member(*entry, "to", text_value(node, place));
        share_segments(part, behind, *entry, second);
        elements.items.insert(entry + 1, std::move(second));
    }

    /// So many lumps for each part that none is longer than before the first cut, whatever else is cut: where that is a
    /// whole number of them they stay where they were.
    void share_segments(Part& part, Part& behind, TomlValue& first, TomlValue& second) const {
        const dttmm_element_type& type = *line_type(first);
        const dttmm_parameter* end = type.parameters + type.parameter_count;
        const dttmm_parameter* parameter = std::find_if(
            type.parameters, end, [](const dttmm_parameter& one) { return one.name == std::string_view("segments"); });
        if (parameter == end) return;
        const TomlMember* given = first.find("segments");
        Diagnostics unheard("");
        const ReadContext silent{context_.parameters, unheard, context_.inputs};
        const auto number =
            given ? read_number(silent, given->value, "segments", "1") : std::optional(parameter->default_value);
        if (!number || *number < 1 || *number != std::round(*number)) return;  // its reader reports it
        if (part.segment == 0) part.segment = part.length / *number;
        behind.segment = part.segment;
        const Place place = given ? given->value.place : first.place;
        const auto set = [&](TomlValue& entry, double length) {
            TomlValue value;
            value.kind = TomlValue::Kind::integer;
            value.place = place;
            value.number = std::max(1.0, std::ceil(length / part.segment * (1 - kLengthTolerance)));
            set_member(entry, "segments", value);
        };
        set(first, behind.start - part.start);
        set(second, behind.length);
    }

    std::string known(const std::string& name) {
        std::vector<std::string> names;
        for (const char* kind : {"body", "element"})
            if (const TomlValue* list = find_list(kind))
                for (const TomlValue& entry : list->items) names.push_back(text_of(entry, "name"));
        return suggestion(name, names);
    }

    TomlValue& document_;
    const ReadContext& context_;
    const ElementCatalogue& catalogue_;
    std::map<std::string, std::vector<Part>> lines_;  ///< by the name in the file
    std::vector<std::string> markers_;
};

}  // namespace

std::vector<std::string> cut_lines(TomlValue& document, const ReadContext& context, const ElementCatalogue& catalogue) {
    LineCutter cutter(document, context, catalogue);
    cutter.divide_sections();
    cutter.add_probes();
    cutter.share_loads();
    return cutter.take_markers();
}

}  // namespace dttmm::host
