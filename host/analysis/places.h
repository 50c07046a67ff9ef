// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include "analysis/modal_machine.h"

namespace dttmm::host {

/// "plate.corner1.z" as a place of the machine and a direction. Throws Error(usage) that names the option and what is known.
std::pair<const ModalPlace*, int> place_and_direction(const Model& model, const ModalMachine& machine,
                                                      const std::string& option, const std::string& text);

/// A frequency as an option has it [Hz]. Throws Error(usage) for one that is negative or no frequency.
double frequency_of(const std::string& option, const std::string& text);

}  // namespace dttmm::host
