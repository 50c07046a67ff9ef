// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model/signal.h"
#include "model/signal_shapes.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// A signal whose value is in the SI unit `unit`: a number or quantity (constant), "=expression of t", or a table with a
/// `type` of signal_shapes.h. Reports faults and then returns nothing.
std::optional<Signal> read_signal(const ReadContext& context, const TomlValue& value, const std::string& what,
                                  std::string_view unit);

/// The same of a table of keys "harmonic" or "psd", in the unit of the reader.
std::optional<Signal> read_vibration(const TableReader& table, bool is_random);

/// The name of the speed of orders, a parameter [rad/s].
inline constexpr const char* kSpeed = "Omega";
/// Gives it to a vibration whose frequency or amplitude rests on it, if the model has it. False, with an error at `place`:
/// it is no angular speed.
bool read_speed(const TableReader& table, Place place, HarmonicSignal::Numbers& numbers);

}  // namespace dttmm::host
