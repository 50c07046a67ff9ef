// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "model/index.h"
#include "model/keys.h"

namespace dttmm::host {

namespace {

/// Bounds are those of a plain number, in SI.
Json quantity(const Bounds& bounds = {}) {
    Json value = {{"type", {"number", "string"}}};
    if (std::isfinite(bounds.minimum)) value[bounds.excludes_minimum ? "exclusiveMinimum" : "minimum"] = bounds.minimum;
    if (std::isfinite(bounds.maximum)) value["maximum"] = bounds.maximum;
    return value;
}

Json list_of(Json items, int count) {
    Json list = {{"type", "array"}, {"items", std::move(items)}};
    if (count > 0) list["minItems"] = list["maxItems"] = count;
    return list;
}

Json reference(std::string_view table) { return {{"$ref", fmt::format("#/definitions/{}", table)}}; }

Json any_of(std::vector<Json> forms) {
    if (forms.size() == 1) return forms.front();
    return {{"anyOf", std::move(forms)}};
}

/// "=front": the coordinates of a station.
Json station() { return {{"type", "string"}, {"pattern", "^="}}; }

bool is_position(const Key& key) { return key.count == 3 && key.unit == std::string_view("m"); }

/// "[N/m] of the bolt. Default 0."
std::string describe(std::string_view unit, const std::string& help, const std::string& fallback) {
    std::string text = unit.empty() || unit == "1" ? std::string() : fmt::format("[{}] ", unit);
    text += help;
    return fallback.empty() ? text : fmt::format("{}. Default: {}.", text, fallback);
}

Json value_of(const Key& key) {
    std::vector<Json> forms;
    if (*key.table && key.kind != Key::Kind::signal && key.kind != Key::Kind::signals && key.kind != Key::Kind::tables &&
        key.kind != Key::Kind::named)
        forms.push_back(reference(key.table));
    switch (key.kind) {
        case Key::Kind::number:
            forms.push_back(quantity(key.bounds));
            break;
        case Key::Kind::numbers:
            forms.push_back(list_of(quantity(key.bounds), key.count));
            if (key.count == 1) forms.push_back(quantity(key.bounds));
            if (is_position(key)) forms.push_back(station());
            break;
        case Key::Kind::point:
            forms.push_back(list_of(quantity(), key.count));
            forms.push_back({{"type", "string"}});
            break;
        case Key::Kind::word:
            forms.push_back({{"enum", words_of(key)}});
            break;
        case Key::Kind::text:
        case Key::Kind::place:
            forms.push_back({{"type", "string"}});
            break;
        case Key::Kind::texts:
            forms.push_back(list_of({{"type", "string"}}, 0));
            break;
        case Key::Kind::directions:
            forms.push_back(list_of({{"enum", {"x", "y", "z", "rx", "ry", "rz"}}}, 0));
            break;
        case Key::Kind::places:
            forms.push_back(list_of({{"type", "string"}}, key.count));
            if (key.count == 0) forms.push_back({{"type", "string"}});
            break;
        case Key::Kind::signal:
        case Key::Kind::signals:
            forms.push_back(quantity());
            forms.push_back(reference(key.table));
            if (key.kind == Key::Kind::signals) forms.push_back(list_of(any_of(forms), key.count));
            break;
        case Key::Kind::table:
            break;
        case Key::Kind::tables:
            return list_of(reference(key.table), 0);
        case Key::Kind::named: {
            std::vector<Json> named = {is_position(key) ? list_of(quantity(), 3) : quantity()};
            if (*key.table) {
                named.push_back(station());
                named.push_back(reference(key.table));
            }
            return {{"type", "object"}, {"additionalProperties", any_of(std::move(named))}};
        }
    }
    return any_of(std::move(forms));
}

/// What stands beside a reference is not looked at: what it refers to has a description of its own.
Json described(Json value, const std::string& text) {
    if (!value.contains("$ref")) value["description"] = text;
    return value;
}

bool is_required(const Key& key) { return key.fallback == std::string_view(kRequired); }

Json property_of(const Key& key) {
    return described(value_of(key), describe(key.unit, key.help, is_required(key) ? "" : key.fallback));
}

/// What [defaults] may supply in place of the table itself, so that an editor must not miss it there.
bool may_be_default(const KeyTable& table, const Key& key) {
    const std::string_view owner = table.name, name = key.name;
    const bool has_defaults = owner == "body" || owner == "joint" || owner == "load";
    return has_defaults && name != "name" && name != "on" && name != "between";
}

Json object_of(const KeyTable& table) {
    Json object = {{"type", "object"}, {"description", table.help}, {"additionalProperties", false}};
    Json required = Json::array(), properties = Json::object();
    for (const Key& key : table.keys) {
        properties[key.name] = property_of(key);
        if (is_required(key) && !may_be_default(table, key)) required.push_back(key.name);
    }
    object["properties"] = std::move(properties);
    if (!required.empty()) object["required"] = std::move(required);
    return object;
}

Json value_of(const dttmm_parameter& parameter) {
    Json words = Json::array();
    for (uint32_t w = 0; w < parameter.word_count; ++w) words.push_back(parameter.words[w].name);
    if (parameter.flags & DTTMM_PARAMETER_WORDS_ONLY) return {{"enum", words}};
    if (parameter.flags & DTTMM_PARAMETER_TABLE)
        return any_of({{{"type", "string"}}, {{"type", "array"}, {"items", {{"type", "array"}}}, {"minItems", 2}}});
    const Json one = quantity(bounds_of(parameter));
    if (parameter.count == 1) return one;
    std::vector<Json> forms = {list_of(one, as_int(parameter.count))};
    if (parameter.flags & DTTMM_PARAMETER_SPREADS) forms.push_back(one);
    return any_of(std::move(forms));
}

std::string default_of(const dttmm_parameter& parameter) {
    if (parameter.flags & DTTMM_PARAMETER_REQUIRED || std::isnan(parameter.default_value)) return "";
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (parameter.words[w].value == parameter.default_value) return parameter.words[w].name;
    return fmt::format("{:g}", parameter.default_value);
}

Json property_of(const dttmm_parameter& parameter) {
    return described(value_of(parameter), describe(parameter.unit, parameter.documentation ? parameter.documentation : "",
                                                   default_of(parameter)));
}

/// An object whose keys depend on its `type`: the keys of all, and a closed form for each.
class Variants {
public:
    explicit Variants(std::string help) : help_(std::move(help)) {}

    void add(const std::string& type, const Json& properties, Json required) {
        types_.push_back(type);
        Json closed = {{"properties", properties}, {"additionalProperties", false}};
        closed["required"] = std::move(required);
        cases_.push_back(
            {{"if", {{"properties", {{"type", {{"const", type}}}}}, {"required", {"type"}}}}, {"then", closed}});
        for (const auto& [key, property] : properties.items()) {
            if (key == "type") continue;
            if (std::ranges::find(order_, key) == order_.end()) order_.push_back(key);
            std::vector<Json>& forms = forms_[key];
            if (std::ranges::find(forms, property) == forms.end()) forms.push_back(property);
            owners_[key].push_back(type);
        }
    }

    Json take() const {
        Json properties = {{"type", {{"enum", types_}, {"description", help_}}}};
        for (const std::string& key : order_) {
            const std::vector<Json>& forms = forms_.at(key);
            Json property = any_of(forms);
            if (forms.size() > 1) {
                std::string text = fmt::format("of {}", fmt::join(owners_.at(key), ", "));
                for (const Json& form : forms)
                    if (form.contains("description")) text += fmt::format("; {}", form["description"].get<std::string>());
                property["description"] = text;
            }
            properties[key] = std::move(property);
        }
        return {{"type", "object"},
                {"properties", std::move(properties)},
                {"required", {"type"}},
                {"additionalProperties", true},
                {"allOf", cases_}};
    }

private:
    std::string help_;
    std::vector<std::string> types_, order_;
    std::map<std::string, std::vector<Json>> forms_;
    std::map<std::string, std::vector<std::string>> owners_;
    Json cases_ = Json::array();
};

Json type_word(const std::string& type) { return {{"const", type}}; }

Json signal_object() {
    constexpr std::string_view kPrefix = "signal.";
    Variants signals("how the size goes over time");
    for (const KeyTable& table : key_tables()) {
        if (!std::string_view(table.name).starts_with(kPrefix)) continue;
        const std::string type = table.name + kPrefix.size();
        Json object = object_of(table);
        object["properties"]["type"] = type_word(type);
        signals.add(type, object["properties"], object.value("required", Json::array()));
    }
    return signals.take();
}

/// The keys that a type declares, with those of the tables in it.
Json parameters_of(const dttmm_element_type& type) {
    Json properties = Json::object();
    for (uint32_t p = 0; p < type.parameter_count; ++p) {
        const dttmm_parameter& parameter = type.parameters[p];
        const std::string name = parameter.name;
        const size_t dot = name.find('.');
        if (dot == std::string::npos) {
            properties[name] = property_of(parameter);
            continue;
        }
        Json& inner = properties[name.substr(0, dot)];
        if (inner.is_null()) inner = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
        inner["properties"][name.substr(dot + 1)] = property_of(parameter);
        if (parameter.flags & DTTMM_PARAMETER_REQUIRED) inner["required"].push_back(name.substr(dot + 1));
    }
    return properties;
}

/// A table of some of these keys, whose values are described elsewhere.
Json table_of_keys(const std::vector<std::string>& keys, const char* help) {
    return {{"type", "object"}, {"description", help}, {"propertyNames", {{"enum", keys}}}};
}

std::vector<std::string> keys_of(const Json& properties, const std::vector<std::string>& but) {
    std::vector<std::string> keys;
    for (const auto& [key, property] : properties.items())
        if (std::ranges::find(but, key) == but.end()) keys.push_back(key);
    return keys;
}

/// Keys of a section of a line: a length and those of the type.
Json sections_of(const Json& parameters) {
    const KeyTable& table = key_table("section");
    std::vector<std::string> keys = names_of(table);
    for (std::string& key : keys_of(parameters, {})) keys.push_back(std::move(key));
    Json section = table_of_keys(keys, table.help);
    section["properties"] = object_of(table)["properties"];
    section["required"] = {"length"};
    return described(list_of(std::move(section), 0), find_key(key_table("element"), "sections")->help);
}

/// All keys of an element of a type.
Json element_properties(const dttmm_element_type& type) {
    Json properties = object_of(key_table(type.ends == DTTMM_ENDS_AT ? "element.at" : "element"))["properties"];
    properties["type"] = described(type_word(type.name), type.documentation ? type.documentation : "");
    const Json own = parameters_of(type);
    if (takes_line_loads(type))
        properties["sections"] = sections_of(own);
    else
        properties.erase("sections");
    for (const auto& [name, property] : own.items()) properties[name] = property;
    return properties;
}

/// What a type wants besides name and ends may stand in [defaults].
Json element_object(const ElementCatalogue& catalogue) {
    Variants elements("what it is; `dttmm help TYPE` says more");
    for (const dttmm_element_type* type : catalogue.types)
        elements.add(type->name, element_properties(*type),
                     object_of(key_table(type->ends == DTTMM_ENDS_AT ? "element.at" : "element"))["required"]);
    return elements.take();
}

/// An element whose name and ends its circle gives.
Json bolt_object(const ElementCatalogue& catalogue) {
    Json types = Json::array(), cases = Json::array();
    for (const dttmm_element_type* type : catalogue.types) {
        if (type->ends == DTTMM_ENDS_AT) continue;
        types.push_back(type->name);
        const std::vector<std::string> keys = keys_of(element_properties(*type), {"name", "from", "to"});
        cases.push_back({{"if", {{"properties", {{"type", {{"const", type->name}}}}}, {"required", {"type"}}}},
                         {"then", {{"propertyNames", {{"enum", keys}}}}}});
    }
    return {{"type", "object"},
            {"description", key_table("bolt").help},
            {"properties", {{"type", {{"enum", types}}}}},
            {"required", {"type"}},
            {"allOf", cases}};
}

/// Keys of all of a kind, of which any may be missing.
Json defaults_object(const ElementCatalogue& catalogue) {
    Json object = object_of(key_table("defaults"));
    for (const Key& key : key_table("defaults").keys)
        object["properties"][key.name] =
            table_of_keys(keys_of(object_of(key_table(key.table))["properties"], {"name"}), key.help);
    for (const dttmm_element_type* type : catalogue.types)
        object["properties"][type->name] =
            table_of_keys(keys_of(element_properties(*type), {"name", "type"}), "keys of every element of this type");
    return object;
}

}  // namespace

Json make_schema(const ElementCatalogue& catalogue) {
    Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "model of dttmm, format dttmm/1"}};
    const Json file = object_of(key_table("file"));
    for (const auto& [key, value] : file.items()) schema[key] = value;
    Json definitions = Json::object();
    for (const KeyTable& table : key_tables()) {
        const std::string_view name = table.name;
        if (name != "file" && name != "element" && name != "element.at" && name != "section" && !name.starts_with("signal."))
            definitions[table.name] = object_of(table);
    }
    definitions["signal"] = signal_object();
    definitions["element"] = element_object(catalogue);
    definitions["bolt"] = bolt_object(catalogue);
    definitions["defaults"] = defaults_object(catalogue);
    schema["definitions"] = std::move(definitions);
    return schema;
}

}  // namespace dttmm::host
