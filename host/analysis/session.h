// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "analysis/halving.h"
#include "analysis/load_speed.h"
#include "analysis/request.h"
#include "loader/plugins.h"
#include "record/warnings.h"
#include "step/simulation.h"

namespace dttmm::host {

/// A model with its plugins as one command works on it: read, built and checked, before anything is written. Its warnings so
/// far are those of the file and of the loads.
class Session {
public:
    /// Throws Error for a model that cannot run.
    explicit Session(const Request& request);

    /// Looks for loads that the step of a simulation does not resolve, and warns of them.
    void look_at_loads(const Simulation& at);

    /// Throws Error(numerical_failure) for an explicit coupling beyond the limit of its scheme, which would throw the
    /// machine apart, unless forced; warns near it.
    void refuse_unstable(bool force);

    Warnings warnings;
    const Plugins plugins;
    bool has_chosen_step = false;  ///< neither file nor options give one
    const Model model;
    Simulation simulation;             ///< at the model's step
    const std::vector<int> selection;  ///< of its channels, those that the model asks for
    std::optional<Halving> halving;    ///< of a run to a tolerance
    std::vector<FastLoad> fast_loads;  ///< at the step of the results

private:
    Model prepare(const Request& request);
};

}  // namespace dttmm::host
