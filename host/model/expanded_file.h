// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "model/read_model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// A model file with what it includes, its patterns and its defaults written out: all that the readers of its tables see.
struct ExpandedFile {
    /// Faults of the tables go to `diagnostics`. Throws ModelError where nothing else of the file can be judged, and
    /// Error(usage) for an override of a parameter that does not exist.
    ExpandedFile(std::string_view text, const std::filesystem::path& file, const ElementCatalogue& catalogue,
                 const ModelOverrides& overrides);

    ReadContext context() { return {*parameters, diagnostics, inputs, instant}; }

    Diagnostics diagnostics;
    InputFiles inputs;
    double instant;
    TomlValue document;
    std::optional<Parameters> parameters;
    std::vector<std::string> probes;  ///< markers, as "body.marker"
};

/// The same as the text of a model file, with the parameters that --set gives and without comments. Throws like read_model.
std::string write_expanded(const std::filesystem::path& file, const ElementCatalogue& catalogue,
                           const ModelOverrides& overrides);

}  // namespace dttmm::host
