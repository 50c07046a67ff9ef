// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "analysis/schema.h"
#include "analysis/templates.h"
#include "loader/plugins.h"
#include "model/expression.h"
#include "model/index.h"
#include "model/keys.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

struct Row {
    std::string name, value, fallback, text;
};

/// Rows in columns as wide as they need to be.
void print_rows(const std::vector<Row>& rows) {
    size_t name = 0, value = 0, fallback = 0;
    for (const Row& row : rows) {
        name = std::max(name, row.name.size());
        value = std::max(value, row.value.size());
        fallback = std::max(fallback, row.fallback.size());
    }
    for (const Row& row : rows) {
        std::string line = fmt::format("    {:<{}}  {:<{}}  {:<{}}  {}", row.name, name, row.value, value, row.fallback,
                                       fallback, row.text);
        line.resize(line.find_last_not_of(' ') + 1);
        fmt::print("{}\n", line);
    }
}

std::string unit_text(std::string_view unit) { return std::string(unit == "1" ? "number" : unit); }

/// ", > 0 to 5", ", >= 0": where a value may lie.
std::string describe_range(const Bounds& bounds) {
    const double most = std::numeric_limits<double>::max();
    const bool has_least = bounds.minimum >= -most, has_most = bounds.maximum <= most;
    if (!has_least) return has_most ? fmt::format(", <= {:g}", bounds.maximum) : "";
    if (!has_most) return fmt::format(", {} {:g}", bounds.excludes_minimum ? ">" : ">=", bounds.minimum);
    return fmt::format(", {}{:g} to {:g}", bounds.excludes_minimum ? "> " : "", bounds.minimum, bounds.maximum);
}

/// What a value may be: "s", "3 x m", "implicit | explicit".
std::string describe_value(const Key& key) {
    const std::string unit = *key.unit ? unit_text(key.unit) : "as the load";
    const std::string inner = *key.table ? fmt::format(" or {{ }} of {}", key.table) : "";
    switch (key.kind) {
        case Key::Kind::number:
            return unit + describe_range(key.bounds);
        case Key::Kind::numbers:
            return (key.count == 0   ? fmt::format("list of {}", unit)
                    : key.count == 1 ? unit
                                     : fmt::format("{} x {}", key.count, unit)) +
                   describe_range(key.bounds) + inner;
        case Key::Kind::point:
            return fmt::format("{} x {}, or a name", key.count, unit);
        case Key::Kind::word:
            return fmt::format("{}", fmt::join(words_of(key), " | ")) + inner;
        case Key::Kind::text:
            return "text";
        case Key::Kind::texts:
            return "list of texts";
        case Key::Kind::directions:
            return "list of x y z rx ry rz";
        case Key::Kind::place:
            return "name";
        case Key::Kind::places:
            return key.count > 0 ? fmt::format("{} names", key.count) : "name or names";
        case Key::Kind::signal:
            return fmt::format("{}, \"=f(t)\" or {{ }} of signal", unit);
        case Key::Kind::signals:
            return fmt::format("{}, \"=f(t)\" or {{ }} of signal, or {} of these", unit, key.count);
        case Key::Kind::table:
            return fmt::format("{{ }} of {}", key.table);
        case Key::Kind::tables:
            return key.name == std::string_view("sections") ? "list of { } of section" : fmt::format("[[{}]]", key.name);
        case Key::Kind::named:
            if (*key.table) return fmt::format("name = {{ }} of {}", key.table);
            return *key.unit == 'm' ? "name = [x, y, z]" : "name = number";
    }
    return {};
}

std::string describe_default(const Key& key) {
    if (!*key.fallback) return "optional";
    return key.fallback == std::string_view(kRequired) ? kRequired : fmt::format("default {}", key.fallback);
}

/// The value of a parameter that the model leaves out, as the model would write it.
std::string describe_default(const dttmm_parameter& parameter) {
    if (parameter.flags & DTTMM_PARAMETER_REQUIRED) return kRequired;
    if (std::isnan(parameter.default_value)) return "optional";
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (parameter.words[w].value == parameter.default_value)
            if (!std::isfinite(parameter.default_value) || parameter.flags & DTTMM_PARAMETER_WORDS_ONLY)
                return fmt::format("default {}", parameter.words[w].name);
    return fmt::format("default {:g}", parameter.default_value);
}

/// What a parameter may be: unit, range, words.
std::string describe_value(const dttmm_parameter& parameter) {
    std::string text;
    if (parameter.flags & DTTMM_PARAMETER_TABLE) return fmt::format("file or rows: {}", parameter.unit);
    if (!(parameter.flags & DTTMM_PARAMETER_WORDS_ONLY)) {
        text = parameter.count == 1 ? unit_text(parameter.unit)
                                    : fmt::format("{} x {}", parameter.count, unit_text(parameter.unit));
        if (parameter.flags & DTTMM_PARAMETER_SPREADS) text = fmt::format("one or {}", text);
        text += describe_range(bounds_of(parameter));
        if (parameter.flags & DTTMM_PARAMETER_INTEGER) text += ", whole";
    }
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        text += fmt::format("{}{}", text.empty() ? "" : " | ", parameter.words[w].name);
    return text;
}

std::vector<Row> rows_of(const KeyTable& table) {
    std::vector<Row> rows;
    for (const Key& key : table.keys) rows.push_back({key.name, describe_value(key), describe_default(key), key.help});
    return rows;
}

std::vector<Row> rows_of(const dttmm_element_type& type) {
    std::vector<Row> rows;
    for (uint32_t p = 0; p < type.parameter_count; ++p) {
        const dttmm_parameter& parameter = type.parameters[p];
        rows.push_back({parameter.name, describe_value(parameter), describe_default(parameter),
                        parameter.documentation ? parameter.documentation : ""});
    }
    return rows;
}

const Template* find_model(std::span<const Template> models, std::string_view name) {
    const auto found = std::ranges::find_if(models, [&](const Template& one) { return one.name == name; });
    return found == models.end() ? nullptr : &*found;
}

void print_example(const Template* example) {
    if (example) fmt::print("\nA complete model:\n\n{}", example->text);
}

void print_table(const KeyTable& table) {
    fmt::print("{}{}{}\n\n", table.head, *table.head ? "  " : "", table.help);
    print_rows(rows_of(table));
}

/// Axes, acting point and sign of an element's force.
void print_conventions(const dttmm_element_type& type) {
    if (type.ends == DTTMM_ENDS_AT) {
        fmt::print("\nIts axes are those of the first node it is `at`.\n");
        return;
    }
    fmt::print(
        "\nForce and moment are positive when `to` is displaced in the positive direction against `from`: in tension.\n");
    if (is_line(type))
        fmt::print(
            "Its ends are apart. An end at a point of the world is a node with all directions fixed, not \"ground\".\n"
            "Local x leads from `from` to `to`. Forces of the results act at the `from` end, in the local axes there.\n");
    else
        fmt::print(
            "A ground end coincides with the other end in place and axes.\n"
            "Axes are those of the `from` end, or as `axes` says. Where the ends stand apart the force acts at `to`.\n");
}

void print_parameters(const dttmm_element_type& type) {
    fmt::print("{}  {}\n\n", type.name, type.documentation ? type.documentation : "");
    std::vector<Row> rows = rows_of(key_table(type.ends == DTTMM_ENDS_AT ? "element.at" : "element"));
    if (is_line(type)) std::erase_if(rows, [](const Row& row) { return row.name == "axes"; });
    if (!takes_line_loads(type)) std::erase_if(rows, [](const Row& row) { return row.name == "sections"; });
    for (Row& row : rows_of(type)) rows.push_back(std::move(row));
    print_rows(rows);
    print_conventions(type);
}

void print_element(const dttmm_element_type& type) {
    print_parameters(type);
    print_example(find_model(help_models(), type.name));
}

/// What holds for every value of the model file.
struct Topic {
    const char *name, *title, *help;
    void (*print)();
};

void print_units() {
    fmt::print(
        "A bare number is in SI units. A text has its own unit: \"500 N/mm\", \"30 deg\", \"2 ms\", \"5 %\".\n"
        "Products, quotients and powers are written N*s/mm, kg*m^2, m/s^2, with any SI prefix.\n\n");
    std::vector<Row> rows;
    for (const std::vector<std::string>& units : usual_units())
        rows.push_back({units.front(), fmt::format("{}", fmt::join(units.begin() + 1, units.end(), ", ")), "", ""});
    print_rows(rows);
    fmt::print(
        "\nAn angular speed is in rad/s: \"3000 rpm\" is 314.16 rad/s. 1/min is a frequency: \"3000 1/min\" is 50 Hz,\nand "
        "no angular speed.\n");
}

void print_expressions() {
    fmt::print(
        "A text that begins with = is a formula of the parameters and pi; that of a load also of the time t in s:\n\n"
        "    stiffness = \"=2*k\"\n"
        "    force     = \"=800*sin(pi*t/T)*(t<T)\"      a half sine of 800 N that lasts T\n\n"
        "operators    + - * / ^, comparisons < > <= >= == != (1 or 0), && ||, condition ? a : b\n"
        "functions    {}\n\n"
        "Parameters enter in SI units. A formula that is one parameter alone must have the unit of the key. The result of "
        "any\n"
        "other is taken in the SI unit of the key and its unit is not checked: for a frequency in Hz write "
        "\"=omega/(2*pi)\".\n",
        fmt::join(expression_functions(), " "));
}

constexpr Topic kTopics[] = {{"units", "Units", "how numbers with units are written", print_units},
                             {"expressions", "Expressions", "formulas of parameters and time", print_expressions}};

void print_topics(const ElementCatalogue& catalogue) {
    fmt::print("dttmm help TOPIC: the keys of a table of the model file, or of an element type\n\ntables\n");
    std::vector<Row> rows;
    for (const KeyTable& table : key_tables()) rows.push_back({table.name, table.head, "", table.help});
    print_rows(rows);
    fmt::print("\nelement types\n");
    rows.clear();
    for (const dttmm_element_type* type : catalogue.types)
        rows.push_back({type->name, type->ends == DTTMM_ENDS_AT ? "at" : "from, to", "",
                        type->documentation ? type->documentation : ""});
    print_rows(rows);
    fmt::print("\nvalues, and all\n");
    rows.clear();
    rows.push_back({"reference", "", "", "all of these, as a page of Markdown"});
    for (const Topic& topic : kTopics) rows.push_back({topic.name, "", "", topic.help});
    print_rows(rows);
}

/// All of it but the models: host/reference.md.
void print_reference(const ElementCatalogue& catalogue) {
    fmt::print(
        "# Reference of the model file\n\nMade by `dttmm help reference` from the tables that the program reads by.\n");
    for (const KeyTable& table : key_tables()) {
        fmt::print("\n## {}\n\n```text\n", table.name);
        print_table(table);
        fmt::print("```\n");
    }
    for (const dttmm_element_type* type : catalogue.types) {
        fmt::print("\n## Element `{}`\n\n```text\n", type->name);
        print_parameters(*type);
        fmt::print("```\n");
    }
    for (const Topic& topic : kTopics) {
        fmt::print("\n## {}\n\n```text\n", topic.title);
        topic.print();
        fmt::print("```\n");
    }
}

/// A parameter of an element type for a program.
Json describe_parameter(const dttmm_parameter& parameter) {
    Json value = {{"name", parameter.name},
                  {"unit", parameter.unit},
                  {"count", parameter.count},
                  {"value", describe_value(parameter)},
                  {"default", describe_default(parameter)},
                  {"help", parameter.documentation ? parameter.documentation : ""}};
    if (parameter.word_count > 0) value["words"] = Json::array();
    for (uint32_t w = 0; w < parameter.word_count; ++w) value["words"].push_back(parameter.words[w].name);
    const Bounds bounds = bounds_of(parameter);
    if (std::isfinite(bounds.minimum)) value[bounds.excludes_minimum ? "more_than" : "at_least"] = bounds.minimum;
    if (std::isfinite(bounds.maximum)) value["at_most"] = bounds.maximum;
    return value;
}

Json describe_types(std::span<const dttmm_element_type* const> types) {
    Json all = Json::array();
    for (const dttmm_element_type* type : types) {
        Json parameters = Json::array();
        for (const dttmm_parameter& parameter : std::span(type->parameters, type->parameter_count))
            parameters.push_back(describe_parameter(parameter));
        all.push_back({{"type", type->name},
                       {"ends", type->ends == DTTMM_ENDS_AT ? "at" : "from, to"},
                       {"help", type->documentation ? type->documentation : ""},
                       {"parameters", std::move(parameters)}});
    }
    return all;
}

}  // namespace

std::vector<std::string> help_topics(const ElementCatalogue& catalogue) {
    std::vector<std::string> names;
    for (const KeyTable& table : key_tables()) names.emplace_back(table.name);
    names.emplace_back("signal");
    names.emplace_back("reference");
    for (const Topic& topic : kTopics) names.emplace_back(topic.name);
    for (const dttmm_element_type* type : catalogue.types) names.emplace_back(type->name);
    return names;
}

void print_help(const Request& request) {
    const Plugins plugins(request.plugins);
    const ElementCatalogue& catalogue = plugins.catalogue();
    if (request.words.empty()) return print_topics(catalogue);
    const std::string& topic = request.words.front();
    if (topic == "reference") return print_reference(catalogue);
    for (const Topic& one : kTopics)
        if (topic == one.name) return one.print();
    bool is_known = false;
    for (const KeyTable& table : key_tables()) {
        const std::string_view name = table.name;
        if (name != topic && !(topic == "signal" && name.starts_with("signal.")) && !(topic == "nodes" && name == "node"))
            continue;
        if (is_known) fmt::print("\n");
        print_table(table);
        if (topic != "signal") print_example(find_model(help_models(), table.example));
        is_known = true;
    }
    const int type = catalogue.find(topic);
    if (type >= 0) print_element(*catalogue.types[as_size(type)]);
    if (!is_known && type < 0)
        throw Error(ExitCode::usage, fmt::format("there is no help on {}{}; \"dttmm help\" lists what there is",
                                                 quote(topic), suggestion(topic, help_topics(catalogue))));
}

void print_elements(const Request& request) {
    const Plugins plugins(request.plugins);
    const ElementCatalogue& catalogue = plugins.catalogue();
    if (!request.words.empty()) {
        const int type = catalogue.find(request.words.front());
        if (type < 0) {
            std::vector<std::string> names;
            for (const dttmm_element_type* one : catalogue.types) names.emplace_back(one->name);
            throw Error(ExitCode::usage, fmt::format("there is no element type {}{}", quote(request.words.front()),
                                                     suggestion(request.words.front(), names)));
        }
        const auto one = std::span(catalogue.types).subspan(as_size(type), 1);
        if (request.modes.as_json) return fmt::print("{}", to_text(describe_types(one)));
        return print_element(*one.front());
    }
    if (request.modes.as_json) return fmt::print("{}", to_text(describe_types(catalogue.types)));
    for (const PluginLibrary& library : plugins.libraries()) {
        const dttmm_plugin& table = library.table();
        fmt::print("plugin {}: {} {}\n", library.name(), table.name, table.version);
        for (uint32_t t = 0; t < table.element_type_count; ++t) {
            const dttmm_element_type& type = table.element_types[t];
            fmt::print("\n  {} ({})  {}\n", type.name, type.ends == DTTMM_ENDS_AT ? "at" : "from, to",
                       type.documentation ? type.documentation : "");
            print_rows(rows_of(type));
        }
        fmt::print("\n");
    }
    fmt::print("\"dttmm help TYPE\" shows all keys of one type, its axes and signs, and a complete model.\n");
}

void print_schema(const Request& request) {
    const Plugins plugins(request.plugins);
    fmt::print("{}\n", make_schema(plugins.catalogue()).dump(1));
}

void make_new(const Request& request) {
    namespace fs = std::filesystem;
    const fs::path folder = request.words.front();
    const std::string kind = request.response.from.empty() ? "mounts" : request.response.from;
    const Template* model = find_model(new_models(), kind);
    if (!model) {
        std::vector<std::string> kinds;
        for (const Template& one : new_models()) kinds.emplace_back(one.name);
        throw Error(ExitCode::usage, fmt::format("--from wants one of {}, got {}", listed(kinds), quote(kind)));
    }
    const Plugins plugins(request.plugins);
    const std::string schema = make_schema(plugins.catalogue()).dump(1) + "\n";
    std::error_code fault;
    if (fs::exists(folder, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: is there already; nothing was written", folder.string()));
    if (!fs::create_directories(folder, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: {}", folder.string(), fault.message()));
    const auto write = [&](const char* name, const std::string& text) {
        const fs::path file = folder / name;
        std::ofstream out(file);
        out << text << std::flush;
        if (!out) throw Error(ExitCode::input_output, fmt::format("{}: cannot be written", file.string()));
    };
    const std::string text = model->text;
    const size_t first = text.starts_with("#:schema") ? text.find('\n') + 1 : 0;
    write("model.toml", "#:schema ./model.schema.json\n" + text.substr(first));
    write("model.schema.json", schema);
    const bool runs = text.find("\n[simulation]") != std::string::npos;
    fmt::print("{} and its schema, which editors complete keys by, are in {}. Next:\n  dttmm check {}\n  dttmm {} {}\n",
               (folder / "model.toml").string(), folder.string(), folder.string(), runs ? "run" : "modes", folder.string());
}

}  // namespace dttmm::host
