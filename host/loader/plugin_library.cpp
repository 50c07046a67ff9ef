// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugin_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <set>
#include <span>

#include "loader/build_id.h"
#include "loader/law_library.h"
#include "loader/plugin_call.h"
#include "model/error.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& fault) {
    throw Error(ExitCode::plugin_failure, fmt::format("plugin {}: {}", name, printable(fault)));
}

constexpr uint32_t kMostTypes = 10'000;

/// UTF-8 that a terminal and a file of JSON take as it is.
bool is_text(const char* text) { return is_printable(text); }

/// Letters, digits, underscore, hyphen and point.
bool is_word(const std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
               c == '.';
    });
}

/// Words are one text for one number, each its own, none that reads as a number.
bool has_good_words(const dttmm_parameter& parameter) {
    if (parameter.word_count == 0) return !(parameter.flags & DTTMM_PARAMETER_WORDS_ONLY);
    if (!parameter.words || parameter.count != 1 || parameter.word_count > 1000) return false;
    std::set<std::string> names;
    for (const dttmm_word& word : std::span(parameter.words, parameter.word_count)) {
        if (!word.name || !*word.name || std::strchr(" =+-.0123456789", *word.name) || std::isnan(word.value)) return false;
        if (!names.emplace(word.name).second) return false;
    }
    return true;
}

/// A number that is not finite needs a word; not a number says that the model does not give it.
bool has_good_default(const dttmm_parameter& parameter) {
    const double value = parameter.default_value;
    if (std::isnan(value) || (std::isfinite(value) && !(parameter.flags & DTTMM_PARAMETER_WORDS_ONLY))) return true;
    if (parameter.flags & DTTMM_PARAMETER_REQUIRED) return true;
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (parameter.words[w].value == value) return true;
    return false;
}

bool is_well_declared(const dttmm_parameter& parameter) {
    return parameter.name && is_word(parameter.name) && parameter.unit && is_text(parameter.unit) &&
           parameter.documentation && is_text(parameter.documentation) && parameter.count >= 1 && parameter.count <= 1000 &&
           parameter.minimum <= parameter.maximum && has_good_words(parameter) && has_good_default(parameter);
}

/// Keys of the model file: no two alike, none that every element has, and "a.b" only where "a" is no number.
void check_parameters(const std::string& plugin, const dttmm_element_type& type) {
    std::set<std::string> names = {"name", "type", "from", "to", "at", "axes", "motion"}, tables;
    for (uint32_t p = 0; p < type.parameter_count; ++p) {
        const dttmm_parameter& parameter = type.parameters[p];
        if (!is_well_declared(parameter))
            fail(plugin, fmt::format("element type \"{}\": parameter {} is not well declared", type.name, p));
        const std::string name = parameter.name;
        const size_t dot = name.find('.');
        const bool is_key = !name.empty() && dot != 0 && dot + 1 != name.size() && name.find('.', dot + 1) == name.npos;
        if (dot != name.npos) tables.insert(name.substr(0, dot));
        if (!is_key || !names.insert(name).second)
            fail(plugin, fmt::format("element type \"{}\": the name \"{}\" of parameter {} is taken, or no key", type.name,
                                     name, p));
    }
    for (const std::string& table : tables)
        if (names.contains(table))
            fail(plugin, fmt::format("element type \"{}\": \"{}\" cannot be both a key and a table", type.name, table));
}

const dttmm_plugin* checked(const std::string& name, const dttmm_plugin* table) {
    if (table == nullptr)
        fail(name,
             fmt::format("it does not support version {} of the interface (its entry returned null)", DTTMM_PLUGIN_MAJOR));
    if (table->major != DTTMM_PLUGIN_MAJOR)
        fail(name, fmt::format("it was built for version {} of the interface, this host speaks version {}", table->major,
                               DTTMM_PLUGIN_MAJOR));
    if (table->size < sizeof(dttmm_plugin))
        fail(name, fmt::format("its table has {} bytes, version {}.0 wants at least {}", table->size, DTTMM_PLUGIN_MAJOR,
                               sizeof(dttmm_plugin)));
    const bool whole = table->name && table->version && table->create && table->destroy && table->blocks &&
                       table->linearise && table->start && table->begin_step && table->evaluate && table->commit_step &&
                       table->discard_step && table->is_implicit && table->load_weights && table->channel_count &&
                       table->channels && table->outputs && !table->part_count == !table->iterate;
    if (!whole)
        fail(name,
             "its table has a null entry; only extension, part_count and iterate, mean_wrench, stand and take_up may be "
             "null");
    if (table->element_type_count > kMostTypes)
        fail(name, fmt::format("it declares {} element types; at most {} are taken", table->element_type_count, kMostTypes));
    if (table->element_type_count > 0 && table->element_types == nullptr) fail(name, "its list of element types is null");
    for (uint32_t t = 0; t < table->element_type_count; ++t) {
        const dttmm_element_type& type = table->element_types[t];
        if (!type.name || (type.parameter_count > 0 && !type.parameters))
            fail(name, fmt::format("element type {} has a null name or parameter list", t));
        if (!is_word(type.name) || (type.documentation && !is_text(type.documentation)))
            fail(name, fmt::format("element type {}: its name or documentation is no plain text", t));
        if (type.ends > DTTMM_ENDS_LINE)
            fail(name, fmt::format("element type \"{}\": there is no kind {} of ends", type.name, type.ends));
        check_parameters(name, type);
    }
    return table;
}

/// The table of an extension; null: the plugin has it not. A smaller one of an earlier minor version is completed by null
/// entries. least: the size of the entries that none lacks.
template <class Table>
std::shared_ptr<const Table> extension(const std::string& name, const dttmm_plugin& plugin, const char* wanted,
                                       size_t least = sizeof(Table)) {
    if (!plugin.extension) return nullptr;
    const auto* table = static_cast<const Table*>(plugin.extension(wanted));
    if (!table) return nullptr;
    if (table->size < least)
        fail(name,
             fmt::format("its table of extension {} has {} bytes, at least {} are wanted", wanted, table->size, least));
    const auto own = std::make_shared<Table>();
    std::memcpy(own.get(), table, std::min<size_t>(table->size, sizeof(Table)));
    return own;
}

}  // namespace

PluginLibrary::PluginLibrary(std::string name, const dttmm_plugin* table, std::shared_ptr<void> handle)
    : name_(std::move(name)),
      table_(checked(name_, table)),
      modal_(extension<dttmm_modal_table>(name_, *table, DTTMM_MODAL, offsetof(dttmm_modal_table, force_at_start))),
      response_(extension<dttmm_response_table>(name_, *table, DTTMM_RESPONSE, offsetof(dttmm_response_table, is_axial))),
      laws_(extension<dttmm_laws_table>(name_, *table, DTTMM_LAWS, offsetof(dttmm_laws_table, fit))),
      statics_(extension<dttmm_static_table>(name_, *table, DTTMM_STATIC)),
      supports_(extension<dttmm_support_table>(name_, *table, DTTMM_SUPPORT)),
      shapes_(extension<dttmm_shape_table>(name_, *table, DTTMM_SHAPE)),
      derivative_(
          extension<dttmm_derivative_table>(name_, *table, DTTMM_DERIVATIVE, offsetof(dttmm_derivative_table, centre))),
      handle_(std::move(handle)) {
    const bool whole =
        (!modal_ || (modal_->create && modal_->destroy && modal_->find_modes && modal_->mode && modal_->mode_along &&
                     modal_->overall)) &&
        (!response_ || (response_->respond && modal_)) && (!laws_ || laws_->add_law) &&
        (!statics_ || (statics_->begin && statics_->keep && statics_->recall && statics_->set_loads && statics_->form &&
                       statics_->correct && statics_->move && statics_->start)) &&
        (!shapes_ || (shapes_->lines && shapes_->positions)) &&
        (!derivative_ || ((!derivative_->frequency_changes || modal_) && (!derivative_->respond_beside || response_)));
    if (!whole) fail(name_, "an extension of it has a null entry, or is without the one that it stands on");
}

PluginLibrary PluginLibrary::built_in() { return {"built in", dttmm_plugin_entry(DTTMM_PLUGIN_MAJOR), nullptr}; }

std::string PluginLibrary::built_in_build() { return build_id_at(reinterpret_cast<const void*>(&dttmm_plugin_entry)); }

PluginLibrary PluginLibrary::load(const SharedLibrary& library) {
    const std::string& name = library.name();
    const PluginCall at_work(name);
    const auto entry = reinterpret_cast<dttmm_plugin_entry_function>(library.symbol(DTTMM_PLUGIN_ENTRY));
    if (!entry)
        fail(name, fmt::format("it exports neither {} nor {}: not a dttmm plugin", DTTMM_PLUGIN_ENTRY, DTTMM_LAW_ENTRY));
    try {
        const dttmm_plugin* table = entry(DTTMM_PLUGIN_MAJOR);
        refuse_changed_arithmetic("plugin " + name);
        PluginLibrary plugin(name, table, library.handle());
        refuse_changed_arithmetic("plugin " + name);
        return plugin;
    } catch (const Error&) {
        throw;
    } catch (...) {
        fail(name, describe_exception());
    }
}

/// Calls one of its functions, which returns a status; what it says where it refuses, or `otherwise`; empty: all is well.
template <class Call>
std::string PluginLibrary::ask(const Call& call, const std::string& otherwise) const {
    const PluginCall at_work(name_);
    dttmm_error error{-1, {}};
    dttmm_status status = DTTMM_OK;
    try {
        status = call(&error);
    } catch (...) {
        fail(name_, describe_exception());
    }
    const std::string text(error.text, ::strnlen(error.text, sizeof error.text));
    return status == DTTMM_OK ? "" : text.empty() ? otherwise : text;
}

bool PluginLibrary::add_law(const dttmm_law& law) const {
    if (!laws_) return false;
    const std::string fault = ask([&](dttmm_error* error) { return laws_->add_law(&law, LawLibrary::at_work(), error); },
                                  fmt::format("plugin {} does not take the law", name_));
    if (!fault.empty()) fail(LawLibrary::file_of(&law), fault);
    return true;
}

dttmm_fit PluginLibrary::fit(uint32_t type, const std::vector<double>& values, uint32_t direction) const {
    dttmm_fit fit{};
    if (!laws_ || !laws_->fit) return fit;
    const std::string fault =
        ask([&](dttmm_error* error) { return laws_->fit(type, values.data(), direction, &fit, error); }, "no fit is known");
    if (!fault.empty()) fail(name_, fault);
    return fit;
}

}  // namespace dttmm::host
