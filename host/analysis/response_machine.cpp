// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_machine.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/places.h"
#include "analysis/response_choice.h"
#include "model/error.h"
#include "model/vibrations.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void refuse_rest(const Model& model) {
    const std::string left_out = describe_left_out(model),
                      whole = model.load_case.empty() ? "the model" : "case " + quote(model.load_case);
    const auto in_time = std::ranges::find_if(model.loads, [](const Load& load) { return !load.vibration; });
    throw Error(
        ExitCode::model_invalid,
        fmt::format(
            "{}: nothing vibrates: {} has no harmonic, psd or unbalance load{}{}", model.path, whole,
            !left_out.empty() ? left_out
                              : "; give one, or ask for the response to a unit force with --in "
                                "PLACE.DIRECTION",
            in_time != model.loads.end() ? fmt::format(". The load at {} acts in runs and at rest", in_time->place) : ""));
}

Excitation make_excitation(const Request& request, const Model& model, const ModalMachine& machine) {
    if (request.response.inputs.empty()) {
        Excitation loads(model, machine);
        if (!loads.has_harmonics() && loads.random_count() == 0) refuse_rest(model);
        return loads;
    }
    std::vector<Excitation::Input> inputs;
    for (const std::string& text : request.response.inputs) {
        const auto [place, direction] = place_and_direction(model, machine, "--in", text);
        for (const Excitation::Input& other : inputs)
            if (other.place == place && other.direction == direction)
                throw Error(ExitCode::usage, fmt::format("--in {} and --in {} are the same input; give it once",
                                                         quote(other.text), quote(text)));
        inputs.push_back({text, place, direction});
    }
    return Excitation(std::move(inputs));
}

}  // namespace

ResponseMachine::ResponseMachine(const Request& request, const Plugins& plugins, Warnings& warnings)
    : session(request, plugins, warnings),
      channels(session.model, session.machine),
      excitation(make_excitation(request, session.model, session.machine)),
      curves(session.machine, channels, excitation, choose_response_channels(request, channels.all(), excitation),
             warnings) {}

}  // namespace dttmm::host
