// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugin_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cmath>

#include "model/error.h"

namespace dttmm {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& fault) {
    throw Error(ExitCode::plugin_failure, fmt::format("plugin {}: {}", name, fault));
}

void check_file(const std::filesystem::path& file) {
    struct stat status {};
    if (::stat(file.c_str(), &status) != 0) fail(file, "there is no such file; --plugin wants the path of a shared library");
    if (!S_ISREG(status.st_mode)) fail(file, "this is no regular file");
    if (status.st_mode & S_IWOTH) fail(file, "everybody may write to this file; it is not loaded (chmod o-w)");
}

const dttmm_plugin* checked(const std::string& name, const dttmm_plugin* table) {
    if (table == nullptr)
        fail(name,
             fmt::format("it does not support version {} of the interface (its entry returned null)", DTTMM_PLUGIN_MAJOR));
    if (table->major != DTTMM_PLUGIN_MAJOR)
        fail(name, fmt::format("it was built for version {} of the interface, this host speaks version {}", table->major,
                               DTTMM_PLUGIN_MAJOR));
    if (table->size < sizeof(dttmm_plugin))
        fail(name, fmt::format("its table has {} bytes, version {}.{} wants at least {}", table->size, DTTMM_PLUGIN_MAJOR,
                               DTTMM_PLUGIN_MINOR, sizeof(dttmm_plugin)));
    const bool whole = table->name && table->version && table->create && table->destroy && table->linearise &&
                       table->start && table->begin_step && table->evaluate && table->commit_step && table->discard_step &&
                       table->is_implicit && table->load_weights && table->state_size && table->save_state &&
                       table->restore_state && table->channel_count && table->channels && table->outputs;
    if (!whole) fail(name, "its table has a null entry; every function of the interface is required");
    if (table->element_type_count > 0 && table->element_types == nullptr) fail(name, "its list of element types is null");
    for (uint32_t t = 0; t < table->element_type_count; ++t) {
        const dttmm_element_type& type = table->element_types[t];
        if (!type.name || (type.parameter_count > 0 && !type.parameters))
            fail(name, fmt::format("element type {} has a null name or parameter list", t));
        for (uint32_t p = 0; p < type.parameter_count; ++p) {
            const dttmm_parameter& parameter = type.parameters[p];
            if (!parameter.name || !parameter.unit || !parameter.documentation || parameter.count == 0 ||
                parameter.count > 1000 || !std::isfinite(parameter.default_value) ||
                !(parameter.minimum <= parameter.maximum))
                fail(name, fmt::format("element type \"{}\": parameter {} is not well declared", type.name, p));
        }
    }
    return table;
}

}  // namespace

PluginLibrary::PluginLibrary(std::string name, const dttmm_plugin* table, std::shared_ptr<void> handle)
    : name_(std::move(name)), table_(checked(name_, table)), handle_(std::move(handle)) {}

PluginLibrary PluginLibrary::built_in() { return {"built in", dttmm_plugin_entry(DTTMM_PLUGIN_MAJOR), nullptr}; }

PluginLibrary PluginLibrary::load(const std::filesystem::path& file) {
    check_file(file);
    const std::filesystem::path path = std::filesystem::absolute(file);  // a bare name would be searched on the library path
    const std::shared_ptr<void> handle(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL), [](void* h) {
        if (h) dlclose(h);
    });
    if (!handle) fail(file, dlerror());
    const auto entry = reinterpret_cast<dttmm_plugin_entry_function>(dlsym(handle.get(), DTTMM_PLUGIN_ENTRY));
    if (!entry) fail(file, fmt::format("it exports no {}: not a dttmm plugin", DTTMM_PLUGIN_ENTRY));
    return {file, entry(DTTMM_PLUGIN_MAJOR), handle};
}

}  // namespace dttmm
