// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupling/modal_description.h"
#include "coupling/nonconservative.h"
#include "loader/modal_instance.h"
#include "model/index.h"

namespace dttmm::host {

/// A point of the machine whose motion is told: a body's origin, a marker, a node.
struct ModalPlace {
    std::string name;
    int body = -1, node = -1;  ///< index into Model::bodies, or the network's nodes; the other is −1
    Eigen::Vector3d position;  ///< world [m]
    unsigned held = 0;         ///< bit d set: a node that does not move in direction d
    bool is_held(int direction) const { return (held >> direction & 1u) != 0; }
};

/// A model in small vibrations and what its places do in them.
class ModalMachine {
public:
    using Vector6 = ModalInstance::Vector6;
    using Complex6 = ModalInstance::Complex6;

    /// Throws Error with the place in the model file of the element that is at fault.
    ModalMachine(const Model& model, const Plugins& plugins);
    /// About its equilibrium. resting: the model as its networks come to rest.
    ModalMachine(const Model& model, const Model& resting, const Plugins& plugins);
    ModalMachine(const Model& model, ModalDescription description);
    /// Where it rests; null: it is about the start.
    const RestState* rest() const { return description_.rest(); }
    std::vector<RestLimit> limits_at_rest() const { return description_.limits(); }

    /// As the model asks.
    std::vector<ModalInstance::Mode> find_modes() {
        return find_modes(model_.modes.below ? 0 : as_whole<uint32_t>(model_.modes.count), model_.modes.below.value_or(0));
    }
    /// All up to `below` [Hz], or if that is 0 the first `count`.
    std::vector<ModalInstance::Mode> find_modes(uint32_t count, double below);
    /// Motions that grow faster than rounding could make them.
    uint32_t count_growing();
    std::optional<uint32_t> count_free();
    /// Displacement at a place [6, world].
    Vector6 motion(const ModalPlace& place, const ModalInstance::Mode& mode) const;
    /// The damping that the model gives beside its elements, for what follows; highest: frequency asked for [Hz].
    void damp(double highest);
    std::vector<ModalInstance::Damped> find_damped(double below, int32_t& is_proved);
    Complex6 motion(const ModalPlace& place, const ModalInstance::Damped& mode) const;
    std::vector<Vector6> strain_directions(uint32_t mode) { return instance_.strain_directions(mode); }
    /// Of mode `first`, the first of its frequency: see dttmm_derivative.h.
    std::vector<double> frequency_changes(uint32_t first, uint32_t multiplicity, ModalMachine& above, ModalMachine& below) {
        return instance_.frequency_changes(first, multiplicity, above.instance_, below.instance_);
    }
    /// Of a body at rest, or where the file places it: its axes, as columns in world.
    Eigen::Matrix3d axes_of_body(size_t body) const {
        return rest() ? rest()->at[body].rotation : model_.bodies[body].rotation;
    }
    /// Displacements [6, world] at stations along a beam, and its length [m]; none for other elements.
    std::vector<Vector6> along(uint32_t mode, uint32_t element, uint32_t count, double& length);
    /// A harmonic load at a place.
    static dttmm_harmonic load_at(const ModalPlace& place, const Complex6& wrench);
    /// A node that moves in its fixed directions [m, rad].
    static dttmm_harmonic motion_at(const ModalPlace& node, const Complex6& motion);
    std::vector<ModalInstance::Response> respond(double frequency, const std::vector<ModalInstance::Loads>& cases,
                                                 bool with_forces = false);
    /// From now on respond() is linear about another machine, which must live on: see dttmm_derivative.h.
    void respond_beside(ModalMachine& middle) { instance_.respond_beside(middle.instance_); }
    /// An element that carries a force along the line through its ends, and nothing else.
    bool is_axial(size_t element) const { return instance_.is_axial(as_whole<uint32_t>(element)); }
    /// Force and moment of a joint as a run records them, in its axes [N, N m].
    Complex6 joint_wrench(size_t joint, const ModalInstance::Response& response) const;
    /// Displacement and rotation of its second body against its first at the joint, in its axes, which begin with the axis
    /// of a hinge or slider [m, rad].
    Complex6 joint_motion(size_t joint, const ModalInstance::Response& response) const;
    /// All natural frequencies up to a frequency [Hz], not those that the model asks for.
    std::vector<double> frequencies_below(double frequency);
    /// Of a place [m, rad].
    Complex6 motion(const ModalPlace& place, const ModalInstance::Response& response) const;

    /// Why one place does not move under a load at the other.
    std::string why_still(const ModalPlace& in, int in_direction, const ModalPlace& out, int out_direction) const;

    /// Force of an element at the start whose stiffness is in the modes [N]; 0: none.
    double force_at_start(size_t element) const { return instance_.force_at_start(as_whole<uint32_t>(element)); }

    /// How far a beam is bent at rest, as share of its radius of gyration; is_lumped: it counts by its segments therefore.
    double bent_at_rest(size_t element, bool& is_lumped) const {
        return instance_.bent_at_rest(as_whole<uint32_t>(element), is_lumped);
    }

    /// Indices of loads that act at rest and have no potential.
    std::vector<size_t> nonconservative() const { return find_nonconservative(model_, description_); }

    std::string layout() { return instance_.layout(); }
    dttmm_overall overall(double frequency) { return instance_.overall(frequency); }
    ModalInstance::OverallMatrix overall_matrix(double frequency) { return instance_.overall_matrix(frequency); }

    const std::vector<ModalPlace>& places() const { return places_; }
    const ModalPlace* find(const std::string& name) const;

private:
    Eigen::Matrix<double, 6, 6> by_body(const ModalPlace& place) const;
    Complex6 motion_of_body(int body, const Eigen::Vector3d& point, const ModalInstance::Response& response) const;

    const Model& model_;
    ModalDescription description_;
    ModalInstance instance_;
    std::vector<ModalPlace> places_;
    /// Of the joints asked for: found at the first question, so mutable.
    mutable std::vector<std::optional<Eigen::Matrix<double, 6, 12>>> joint_turning_;
};

/// Names of the six directions, in order.
const std::vector<std::string>& direction_names();

}  // namespace dttmm::host
