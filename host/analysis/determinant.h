// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "analysis/modal_machine.h"

namespace dttmm::host {

/// The determinant of the overall transfer equation over frequency, which is zero at the natural frequencies:
/// determinant.csv. range: "1Hz..200Hz:400", from, to and number of frequencies. Throws Error(usage) for another form, and
/// what ModalMachine::overall does.
std::string determinant_table(ModalMachine& machine, const std::string& range);

/// overall_matrix.csv: the matrix of the overall transfer equation at a frequency, "38.6 Hz", a column per unknown. Throws
/// Error(usage) for what is no frequency, and what ModalMachine::overall_matrix does.
std::string overall_matrix_table(ModalMachine& machine, const std::string& frequency);

}  // namespace dttmm::host
