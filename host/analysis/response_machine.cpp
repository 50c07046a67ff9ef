// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response_machine.h"

#include <fmt/format.h>

#include "analysis/places.h"
#include "analysis/response_choice.h"
#include "model/error.h"

namespace dttmm::host {

namespace {

Excitation make_excitation(const Request& request, const Model& model, const ModalMachine& machine) {
    if (request.response.inputs.empty()) {
        Excitation loads(model, machine);
        if (!loads.has_harmonics() && loads.random_count() == 0)
            throw Error(
                ExitCode::model_invalid,
                fmt::format("{}: nothing vibrates: the model has no harmonic, psd or unbalance load; give one, or ask "
                            "for the response to a unit force with --in PLACE.DIRECTION",
                            model.path));
        return loads;
    }
    std::vector<Excitation::Input> inputs;
    for (const std::string& text : request.response.inputs) {
        const auto [place, direction] = place_and_direction(model, machine, "--in", text);
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
