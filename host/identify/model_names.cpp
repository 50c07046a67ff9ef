// SPDX-License-Identifier: BSD-3-Clause
#include "identify/model_names.h"

#include "analysis/modal_session.h"
#include "analysis/response_channels.h"
#include "record/warnings.h"
#include "step/simulation.h"

namespace dttmm::host {

const std::vector<Channel>& ModelNames::histories() {
    if (!histories_) {
        Model own = model_;
        if (own.simulation.step == 0) own.simulation.step = kShortestStep;
        histories_ = Simulation(own, plugins_).channels();
    }
    return *histories_;
}

const std::vector<Channel>& ModelNames::responses() {
    make_machine_once();
    return responses_;
}

const ModalMachine& ModelNames::machine() {
    make_machine_once();
    return *machine_;
}

const Model& ModelNames::modal_model() {
    make_machine_once();
    return *modal_model_;
}

void ModelNames::make_machine_once() {
    if (machine_) return;
    ModelOverrides overrides = request_.overrides;
    overrides.purpose = Purpose::modes;
    modal_model_ = read_model(request_.model, plugins_.catalogue(), overrides);
    Warnings silent(Warnings::Silent::yes);
    machine_.emplace(make_machine(*modal_model_, plugins_, silent));
    responses_ = ResponseChannels(*modal_model_, *machine_).all();
}

}  // namespace dttmm::host
