// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "analysis/modal_machine.h"
#include "analysis/request.h"
#include "loader/plugins.h"
#include "model/channel.h"
#include "model/model.h"

namespace dttmm::host {

/// All names that a model knows, for each kind of data. Each list is made when it is first asked for.
class ModelNames {
public:
    /// All must outlive it.
    ModelNames(const Request& request, const Model& model, const Plugins& plugins)
        : request_(request), model_(model), plugins_(plugins) {}

    const std::vector<Channel>& histories();
    const std::vector<Channel>& responses();
    const ModalMachine& machine();
    const Model& modal_model();

private:
    void make_machine_once();

    const Request& request_;
    const Model& model_;
    const Plugins& plugins_;
    std::optional<std::vector<Channel>> histories_;
    std::optional<Model> modal_model_;
    std::optional<ModalMachine> machine_;
    std::vector<Channel> responses_;
};

}  // namespace dttmm::host
