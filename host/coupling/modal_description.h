// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "coupling/network_description.h"
#include "dttmm_modal.h"

namespace dttmm::host {

/// A whole machine in small vibrations as a plugin is told of it: all elements as one network, the bodies, and ODE's joints
/// as directions that do not give. Stops do not act, loads and gravity leave frequencies alone.
class ModalDescription {
public:
    /// Throws Error(model_invalid) for elements of different plugins, and where there is no element at all.
    ModalDescription(const Model& model, const Plugins& plugins);

    const PluginLibrary& plugin() const { return description_.plugin(); }
    const NetworkDescription& network() const { return description_; }
    /// Valid as long as the model and this object.
    dttmm_modal_model model() const;

private:
    NetworkDescription description_;
    dttmm_network network_;
    std::vector<dttmm_constraint> constraints_;
    uint32_t directions_, lumped_beams_;
};

}  // namespace dttmm::host
