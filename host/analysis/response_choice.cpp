// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/channels.h"

namespace dttmm::host {

namespace {

/// A kind of response by the quantities of its outputs.
struct ResponseKind {
    const char* name;
    const char *linear, *angular;
};
constexpr ResponseKind kKinds[] = {{"receptance", "position", "rotation"},
                                   {"mobility", "velocity", "angular_velocity"},
                                   {"accelerance", "acceleration", "angular_acceleration"},
                                   {"transmissibility", nullptr, nullptr}};
constexpr ResponseKind kOfSupports{"", "position", "rotation"}, kOfForces{"", "force", "moment"};

const ResponseKind& kind_named(const std::string& name) {
    const auto found = std::ranges::find_if(kKinds, [&](const ResponseKind& kind) { return kind.name == name; });
    if (found != std::end(kKinds)) return *found;
    std::vector<std::string> known;
    for (const ResponseKind& kind : kKinds) known.emplace_back(kind.name);
    throw Error(ExitCode::usage,
                fmt::format("--as {}: write one of {}{}", quote(name), listed(known), suggestion(name, known)));
}

/// Whether all inputs move supports; none: all are forces and moments. Throws Error(usage) for what the kind does not know.
bool are_motions(const std::string& kind, const std::vector<Excitation::Input>& inputs) {
    if (inputs.empty())
        throw Error(ExitCode::usage,
                    fmt::format("--as {}: of which input? give it with --in PLACE.DIRECTION: a unit force, or the motion of "
                                "a support in a direction in which it is fixed",
                                kind));
    const auto motion = std::ranges::find_if(inputs, &Excitation::Input::is_motion),
               force = std::ranges::find_if_not(inputs, &Excitation::Input::is_motion);
    if (motion == inputs.end()) return false;
    if (kind != "transmissibility")
        throw Error(ExitCode::usage, fmt::format("--as {}: --in {} is fixed in this direction: it moves by itself and takes "
                                                 "no force; --as transmissibility has what follows it",
                                                 kind, motion->text));
    if (force != inputs.end())
        throw Error(ExitCode::usage,
                    fmt::format("--as transmissibility: --in {} is a motion and --in {} a force; ask for each in a command "
                                "of its own",
                                motion->text, force->text));
    return true;
}

/// The quantities that count as outputs; nullptr: none.
ResponseKind quantities_of(const ResponseKind& kind, const std::vector<Excitation::Input>& inputs) {
    const bool moves = are_motions(kind.name, inputs);
    if (kind.linear) return kind;
    ResponseKind equal = moves ? kOfSupports : kOfForces;  // the quantities of the inputs, so that the ratio has no unit
    if (std::ranges::all_of(inputs, &Excitation::Input::turns)) equal.linear = nullptr;
    if (std::ranges::none_of(inputs, &Excitation::Input::turns)) equal.angular = nullptr;
    return equal;
}

}  // namespace

std::vector<int> choose_response_channels(const Request& request, const std::vector<Channel>& all,
                                          const Excitation& excitation) {
    std::vector<int> chosen;
    if (request.response.kind.empty()) {
        chosen = select_channels(all, request.response.outputs);
        chosen.erase(chosen.begin());  // the frequency
        return chosen;
    }
    const ResponseKind kind = quantities_of(kind_named(request.response.kind), excitation.inputs());
    std::vector<Channel> names = {all.front()};  // by their whole names, then by those without quantity
    std::vector<int> indices = {0};
    for (const bool is_short : {false, true})
        for (size_t c = 1; c < all.size(); ++c) {
            const Channel& one = all[c];
            const bool is_angular = kind.angular && one.quantity() == kind.angular;
            if (!is_angular && !(kind.linear && one.quantity() == kind.linear)) continue;
            if (is_short && one.axis().empty()) continue;
            names.push_back(is_short ? Channel(one.of(), one.owner(), (is_angular ? "r" : "") + one.axis(), "", one.unit(),
                                               one.by_default())
                                     : one);
            indices.push_back(as_int(c));
        }
    for (const int found : select_channels(names, request.response.outputs)) chosen.push_back(indices[as_size(found)]);
    std::ranges::sort(chosen);
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    chosen.erase(chosen.begin());
    if (chosen.empty())
        throw Error(ExitCode::model_invalid, fmt::format("--as {}: the model has no element or joint that carries a {}",
                                                         request.response.kind, kind.linear ? kind.linear : kind.angular));
    return chosen;
}

}  // namespace dttmm::host
