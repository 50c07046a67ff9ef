// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "model/element_catalogue.h"
#include "model/element_scale.h"
#include "model/model.h"
#include "model/parameters.h"
#include "model/read_modes.h"
#include "model/read_simulation.h"

namespace dttmm::host {

/// What a model is read for: histories want [simulation], modes want none.
enum class Purpose { histories, modes, statics };

/// What the command line changes in a model.
struct ModelOverrides : SimulationOverrides {
    Purpose purpose = Purpose::histories;
    double instant = 0;  ///< the first at which loads and motions count [s]
    ModesOverrides modes;
    std::optional<std::string> load_case;  ///< --case; none: loads act as the file has them
    Parameters::Overrides parameters;      ///< --set name=value; an empty value is an error
    std::vector<ElementScale> scales;      ///< of elements, after all else
};

/// Reads and checks a model file of format "dttmm/1".
/// Throws ModelError (exit code 3) with every fault of the file, one per line, as `file:line:column: message`, at most 50;
/// Error(input_output) if the file cannot be read; Error(usage) for an override of a parameter that does not exist.
Model read_model(const std::filesystem::path& file, const ElementCatalogue& catalogue, const ModelOverrides& overrides = {});

/// The same from text; `file` names the text in messages and its folder is where table files are looked for.
Model parse_model(std::string_view text, const std::filesystem::path& file, const ElementCatalogue& catalogue,
                  const ModelOverrides& overrides = {});

}  // namespace dttmm::host
