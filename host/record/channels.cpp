// SPDX-License-Identifier: BSD-3-Clause
#include "record/channels.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string_view>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr std::size_t kShownGroups = 12;

/// "bolt1.force.x" -> "bolt1", "bolt1.force", "bolt1.force.x": all that a pattern may match.
std::vector<std::string> leading_parts(const std::string& name) {
    std::vector<std::string> parts;
    for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1))
        parts.push_back(name.substr(0, dot));
    parts.push_back(name);
    return parts;
}

bool matches(const std::string& pattern, const std::vector<std::string>& parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const std::string& part) { return fnmatch(pattern.c_str(), part.c_str(), 0) == 0; });
}

/// Characters to insert, delete or replace until `pattern` matches `name`; what * and ? stand for is free.
std::size_t compute_distance(std::string_view pattern, std::string_view name) {
    std::vector<std::size_t> row(name.size() + 1), previous;
    std::iota(row.begin(), row.end(), std::size_t{0});  // the empty pattern: every character of the name is missing
    for (const char p : pattern) {
        previous = row;
        row[0] = previous[0] + (p == '*' ? 0 : 1);
        for (std::size_t i = 1; i < row.size(); ++i) {
            const std::size_t step = p == '*' ? 0 : 1;
            const std::size_t replaced = previous[i - 1] + (p == '*' || p == '?' || p == name[i - 1] ? 0 : 1);
            row[i] = std::min({replaced, previous[i] + step, row[i - 1] + step});
        }
    }
    return row.back();
}

std::string nearest(const std::vector<Channel>& all, const std::string& pattern) {
    std::string best;
    std::size_t best_distance = std::numeric_limits<std::size_t>::max();
    for (const Channel& channel : all)
        for (const std::string& part : leading_parts(channel.name()))
            if (const std::size_t distance = compute_distance(pattern, part); distance < best_distance) {
                best = part;
                best_distance = distance;
            }
    return best;
}

/// "time, bolt1.force, bolt1.moment, ... and 31 more": names without their last part, each once.
std::string list_available(const std::vector<Channel>& all) {
    std::vector<std::string> groups;
    for (const Channel& channel : all) {
        const bool is_scalar = channel.of() != Channel::Of::nothing && channel.axis().empty();
        std::string group = is_scalar ? channel.owner() : channel.without_axis();
        if (std::find(groups.rbegin(), groups.rend(), group) == groups.rend()) groups.push_back(std::move(group));
    }
    const std::size_t shown = std::min(groups.size(), kShownGroups);
    std::string text = fmt::format("{}", fmt::join(groups.begin(), groups.begin() + as_row(shown), ", "));
    if (shown < groups.size()) text += fmt::format(" and {} more", groups.size() - shown);
    return text;
}

Error no_match(const std::vector<Channel>& all, const std::string& pattern) {
    return Error(ExitCode::model_invalid,
                 fmt::format("the pattern \"{}\" matches no channel; the nearest is \"{}\". Available: {}", pattern,
                             nearest(all, pattern), list_available(all)));
}

}  // namespace

std::vector<int> select_channels(const std::vector<Channel>& all, const std::vector<std::string>& patterns) {
    std::vector<bool> selected(all.size(), false);
    if (!all.empty()) selected[0] = true;
    for (std::size_t i = 0; i < all.size() && patterns.empty(); ++i) selected[i] = selected[i] || all[i].by_default();

    std::vector<bool> has_match(patterns.size(), false);
    for (std::size_t i = 0; i < all.size() && !patterns.empty(); ++i) {
        const std::vector<std::string> parts = leading_parts(all[i].name());
        for (std::size_t p = 0; p < patterns.size(); ++p)
            if (matches(patterns[p], parts)) selected[i] = has_match[p] = true;
    }
    for (std::size_t p = 0; p < patterns.size(); ++p)
        if (!has_match[p]) throw no_match(all, patterns[p]);

    std::vector<int> indices;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (selected[i]) indices.push_back(as_int(i));
    return indices;
}

}  // namespace dttmm::host
