// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "coupling/equilibrium.h"
#include "coupling/network_description.h"
#include "dttmm_modal.h"

namespace dttmm::host {

/// How near an element at rest is to the limit of its law.
struct RestLimit {
    std::string channel, element;
    double most = 0;  ///< beyond 1 the law does not hold
};

/// A machine that has come to rest, and what it did so by.
struct Resting {
    Networks* networks;
    Equilibrium* equilibrium;
    RestState state;
};

/// A whole machine in small vibrations as a plugin is told of it: all elements as one network, the bodies, and ODE's joints
/// as directions that do not give. Stops do not act, loads and gravity leave frequencies alone.
class ModalDescription {
public:
    /// Throws Error(model_invalid) for elements of different plugins, and where there is no element at all and it is not
    /// at_rest. at_rest: as it vibrates about its equilibrium; throws what Equilibrium does.
    ModalDescription(const Model& model, const Plugins& plugins, bool at_rest = false);
    /// About the equilibrium that it is in, which must live on. There are no limits of it.
    ModalDescription(const Model& model, const Plugins& plugins, Resting resting);

    const PluginLibrary& plugin() const { return description_.plugin(); }
    const NetworkDescription& network() const { return description_; }
    /// Where it rests; none: the machine as the file places it.
    const RestState* rest() const { return rest_ ? &rest_->at.state : nullptr; }
    /// At rest, see Equilibrium; zero about the start.
    Eigen::Matrix<double, 6, 12> joint_turning(size_t joint) const {
        return rest_ ? rest_->at.equilibrium->joint_turning(joint)
                     : Eigen::Matrix<double, 6, 12>(Eigen::Matrix<double, 6, 12>::Zero());
    }
    /// Of the elements there whose laws are limited.
    std::vector<RestLimit> limits() const { return rest_ ? rest_->limits : std::vector<RestLimit>(); }
    /// Valid as long as the model and this object.
    dttmm_modal_model model() const;
    /// At rest, all forces counting so many times from now on.
    void scale_forces(double factor) { rest_->told.factor = factor; }

private:
    /// What finds the equilibrium.
    struct Search {
        Search(const Model& model, const Plugins& plugins);
        Networks networks;
        Loads loads;
        Equilibrium equilibrium;
    };
    /// A machine at rest, and what of it a plugin is told.
    struct Rest {
        explicit Rest(Resting resting);
        void find_limits(const Loads& loads, double step);
        std::unique_ptr<Search> search;  ///< null: it was at rest already
        Resting at;
        std::vector<dttmm_motion> bodies;
        std::vector<double> load_stiffness, joint_stiffness;
        dttmm_rest told;
        std::vector<RestLimit> limits;
    };
    void describe_joints(const Model& model);
    void place_at_rest(const Model& model);

    NetworkDescription description_;
    dttmm_network network_;
    std::vector<dttmm_constraint> constraints_;
    uint32_t directions_, lumped_beams_;
    std::unique_ptr<Rest> rest_;
};

}  // namespace dttmm::host
