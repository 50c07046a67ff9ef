// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/name_registry.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

MeasuredChannel read_channel(const TableReader& table) {
    MeasuredChannel channel;
    channel.place = table.context().diagnostics.place_text(table.place());
    channel.column = table.text("column").value_or("");
    set_channel(channel, table.text("is").value_or(""));
    channel.unit = table.text("unit", "").value_or("");
    channel.gain = table.number("gain", 1).value_or(1);
    channel.delay = table.number("delay", 0).value_or(0);
    channel.noise = table.text("noise", "").value_or("");
    if (channel.unit.empty()) return channel;
    try {
        parse_quantity("1 " + channel.unit);
    } catch (const std::exception& error) {
        table.error(table.find("unit")->value.place, fmt::format("{}: {}", table.what("unit"), error.what()));
    }
    return channel;
}

}  // namespace

void set_channel(MeasuredChannel& channel, std::string_view text) {
    const size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
    text.remove_prefix(begin);
    channel.is_reversed = text.starts_with('-');
    if (channel.is_reversed || text.starts_with('+')) text.remove_prefix(1);
    const size_t first = std::min(text.find_first_not_of(" \t"), text.size());
    text.remove_prefix(first);
    channel.channel = std::string(text.substr(0, text.find_last_not_of(" \t") + 1));
}

MeasuredSettings read_measured(const TableReader& file) {
    MeasuredSettings measured;
    const TomlMember* member = file.find("measured");
    if (!member) return measured;
    const TableReader table(file.context(), member->value, "measured", key_table("measured"));
    if (!table.is_valid()) return measured;
    const std::string name = table.text("file", "").value_or("");
    if (!name.empty()) measured.file = file.context().folder_of(member->value.place) / name;
    measured.input = table.text("input", "").value_or("");
    measured.noise = table.text("noise", "").value_or("");
    measured.clock = table.number("clock", 1).value_or(1);
    measured.hum = table.number("hum", 0).value_or(0);
    if (const TomlMember* hum = table.find("hum"); hum && table.find("clock"))
        table.error(hum->value.place, "hum tells the clock: leave out hum or clock");
    const double averages = table.number("averages", 1).value_or(1);
    if (averages != std::floor(averages))
        table.error(table.find("averages")->value.place, "averages must be a whole number");
    measured.averages = static_cast<int>(averages);
    for (const TomlValue& entry : read_entries(table, "channel")) {
        const TableReader one(file.context(), entry, fmt::format("measured channel {}", measured.channels.size() + 1),
                              key_table("measured.channel"));
        if (!one.is_valid()) continue;
        MeasuredChannel channel = read_channel(one);
        if (std::ranges::find(measured.channels, channel.column, &MeasuredChannel::column) != measured.channels.end())
            one.error(one.place(), fmt::format("the column {} has a channel already", quote(channel.column)));
        measured.channels.push_back(std::move(channel));
    }
    return measured;
}

}  // namespace dttmm::host
