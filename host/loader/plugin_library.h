// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dttmm_derivative.h"
#include "dttmm_laws.h"
#include "dttmm_modal.h"
#include "dttmm_plugin.h"
#include "dttmm_response.h"
#include "dttmm_shape.h"
#include "dttmm_static.h"
#include "dttmm_support.h"
#include "loader/shared_library.h"

namespace dttmm::host {

/// A plugin's function table, checked: right version, whole, no null function. The built-in plugin is linked in; a foreign
/// one is a shared library, loaded only because the user gave its path. Stays loaded as long as a copy of this object lives.
class PluginLibrary {
public:
    /// The plugin that comes with dttmm.
    static PluginLibrary built_in();
    /// Its build ID (build_id.h).
    static std::string built_in_build();

    /// Throws Error(plugin_failure) when the library is without the entry symbol, of another major version, or incomplete.
    static PluginLibrary load(const SharedLibrary& library);
    static PluginLibrary load(const std::filesystem::path& file) { return load(SharedLibrary(file)); }

    const dttmm_plugin& table() const { return *table_; }
    const std::string& name() const { return name_; }
    /// Its extensions; NULL: it has it not.
    const dttmm_modal_table* modal() const { return modal_.get(); }
    const dttmm_response_table* response() const { return response_.get(); }
    const dttmm_laws_table* laws() const { return laws_.get(); }
    const dttmm_static_table* statics() const { return statics_.get(); }
    const dttmm_support_table* supports() const { return supports_.get(); }
    const dttmm_shape_table* shapes() const { return shapes_.get(); }
    const dttmm_derivative_table* derivative() const { return derivative_.get(); }
    /// Gives its elements one more law; false: they take none. Throws Error(plugin_failure) with what it says of the law.
    bool add_law(const dttmm_law& law) const;
    /// The Maxwell series of a direction of an element; no terms: it has none. Throws Error(plugin_failure).
    dttmm_fit fit(uint32_t type, const std::vector<double>& values, uint32_t direction) const;

private:
    template <class Call>
    std::string ask(const Call& call, const std::string& otherwise) const;
    PluginLibrary(std::string name, const dttmm_plugin* table, std::shared_ptr<void> handle);
    std::string name_;
    const dttmm_plugin* table_;
    std::shared_ptr<const dttmm_modal_table> modal_;
    std::shared_ptr<const dttmm_response_table> response_;
    std::shared_ptr<const dttmm_laws_table> laws_;
    std::shared_ptr<const dttmm_static_table> statics_;
    std::shared_ptr<const dttmm_support_table> supports_;
    std::shared_ptr<const dttmm_shape_table> shapes_;
    std::shared_ptr<const dttmm_derivative_table> derivative_;
    std::shared_ptr<void> handle_;
};

}  // namespace dttmm::host
