// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_load.h"

#include <fmt/format.h>

#include "model/name_registry.h"
#include "model/read_rotation.h"
#include "model/read_signal.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

/// Only `[1, 1, 0]` and the like need another length than one. Along one axis a length looks like a part of the force.
void warn_length(const TableReader& table) {
    const auto direction = table.vector("direction");
    const bool is_along_axis = direction && (direction->array() != 0).count() == 1;
    if (is_along_axis && direction->cwiseAbs().maxCoeff() != 1)
        table.warning(
            table.find("direction")->value.place, "direction-length",
            fmt::format("the length of direction, {:g}, does not count: force or moment alone gives the magnitude; "
                        "write 1 or -1",
                        direction->cwiseAbs().maxCoeff()));
}

std::optional<Load> read_load(const ReadContext& context, const TomlValue& entry, std::size_t index,
                              const Attachments& attachments) {
    const TableReader table(context, entry, entry_label("load", entry, index), key_table("load"), entry_note("load", index));
    if (!table.is_valid()) return std::nullopt;
    const auto on = attachments.read(table, "on");
    const auto direction = read_direction(table, "direction");
    if (direction) warn_length(table);
    const TomlMember* magnitude = table.require_one({"force", "moment"});
    if (on && on->is_ground()) table.error(table.find("on")->value.place, "a load on the ground moves nothing");
    if (!magnitude) return std::nullopt;
    const bool is_moment = magnitude->key == "moment";
    if (on && direction && attachments.is_held(*on, *direction, is_moment))
        table.error(table.find("on")->value.place,
                    fmt::format("node {} is fixed in the direction of the {}, which moves nothing",
                                quote(table.find("on")->value.string), magnitude->key));
    if (on && !is_moment && attachments.is_off_centre(*on))
        table.error(
            table.find("on")->value.place,
            fmt::format("{} is a body whose center_of_mass is not its origin: say where the force acts; give the body "
                        "a marker there, as markers.centre at its center_of_mass, and name that",
                        quote(table.find("on")->value.string)));
    const auto signal = read_signal(context, magnitude->value, table.what(magnitude->key), table.key(magnitude->key).unit);
    if (!on || !direction || !signal) return std::nullopt;
    return Load{*on, *direction, is_moment, *signal, context.diagnostics.place_text(magnitude->place)};
}

}  // namespace

std::vector<Load> read_loads(const TableReader& file, const Attachments& attachments) {
    std::vector<Load> loads;
    std::size_t index = 0;
    for (const TomlValue& entry : read_entries(file, "load"))
        if (auto load = read_load(file.context(), entry, index++, attachments)) loads.push_back(std::move(*load));
    return loads;
}

}  // namespace dttmm::host
