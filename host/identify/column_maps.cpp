// SPDX-License-Identifier: BSD-3-Clause
#include "identify/column_maps.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/error.h"
#include "model/read_measured.h"
#include "model/wording.h"
#include "study/text_list.h"

namespace dttmm::host {

ColumnMaps::ColumnMaps(const Request& request, const MeasuredSettings& settings) : channels_(settings.channels) {
    for (const std::string& text : request.fit.maps) add(text);
}

void ColumnMaps::add(const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == text.npos) throw Error(ExitCode::usage, fmt::format("--map {}: write COLUMN=CHANNEL", quote(text)));
    MeasuredChannel channel;
    channel.column = without_blanks_around(text.substr(0, equals));
    channel.place = "--map";
    std::string is = without_blanks_around(text.substr(equals + 1));
    if (const size_t open = is.rfind('['); is.ends_with(']') && open != is.npos) {
        channel.unit = without_blanks_around(is.substr(open + 1, is.size() - open - 2));
        is.resize(open);
    }
    set_channel(channel, is);
    std::erase_if(channels_, [&](const MeasuredChannel& one) { return one.column == channel.column; });
    channels_.push_back(channel);
}

const MeasuredChannel* ColumnMaps::find(const std::string& column) {
    columns_.push_back(column);
    return find_reference(column);
}

const MeasuredChannel* ColumnMaps::find_reference(const std::string& name) {
    found_.insert(name);
    const auto own = std::ranges::find(channels_, name, &MeasuredChannel::column);
    return own == channels_.end() ? nullptr : &*own;
}

void ColumnMaps::claim(const std::string& channel, const std::string& place) {
    if (!claimed_.emplace(channel, place).second)
        throw Error(ExitCode::usage, fmt::format("{}: the channel {} has its data from {} already: map one of the two only",
                                                 place, quote(channel), claimed_[channel]));
}

void ColumnMaps::check_all_found(const std::vector<std::string>& files) const {
    for (const MeasuredChannel& one : channels_)
        if (!found_.contains(one.column))
            throw Error(ExitCode::usage, fmt::format("{}: there is no column {} in {}{}", one.place, quote(one.column),
                                                     listed(files), suggestion(one.column, columns_)));
}

}  // namespace dttmm::host
