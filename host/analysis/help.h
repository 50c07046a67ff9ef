// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/request.h"
#include "model/element_catalogue.h"

namespace dttmm::host {

/// Prints the keys of a table of the model file or the parameters of an element type, with a complete model that shows it;
/// without a topic the list of topics. Throws Error(usage) for a topic there is not.
void print_help(const Request& request);

/// What there is help on, besides commands.
std::vector<std::string> help_topics(const ElementCatalogue& catalogue);

/// Prints all element types, or one, and their parameters.
void print_elements(const Request& request);

/// Prints a JSON schema (draft 7) of the model file with the element types of the plugins given.
void print_schema(const Request& request);

/// Writes a new folder with a model of the kind asked for, and its schema. Throws Error(usage) for another kind,
/// Error(input_output) where the folder is there or cannot be written.
void make_new(const Request& request);

}  // namespace dttmm::host
