// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "analysis/adaptive_points.h"
#include "analysis/modal_machine.h"
#include "model/channel.h"

namespace dttmm::host {

/// The channels of a run as complex amplitudes of a machine in steady vibration: motions of bodies, markers and nodes, world
/// axes, and forces, moments and deflections of elements and joints in their axes, each by its name in a run. A position is
/// the displacement from where the machine is at rest.
class ResponseChannels {
public:
    /// The machine must outlive it.
    ResponseChannels(const Model& model, const ModalMachine& machine);

    const std::vector<Channel>& all() const { return channels_; }
    /// Whether one of these is a force, a moment or a deflection: a response must then have them.
    bool has_forces(const std::vector<int>& channels) const;
    /// Amplitude of a channel; angular frequency [rad/s].
    std::complex<double> value(int channel, const ModalInstance::Response& response, double omega) const;

    /// Displacements, velocities, accelerations and forces; rotations and moments go with them by the size of the machine.
    static constexpr size_t kKinds = 4;
    AdaptivePoints::Kind kind(int channel) const;
    /// The largest of each kind anywhere in the machine: displacements [m] to forces [N].
    std::array<double, kKinds> largest(const ModalInstance::Response& response, double omega) const;

private:
    enum class Of : unsigned char { place, element_force, element_deflection, joint, joint_angle, joint_travel };
    struct Source {
        Of of;
        size_t index;        ///< of the place, element or joint
        int direction;       ///< 0 … 5
        int derivative = 0;  ///< of a motion
    };
    void add(Channel::Of of, const std::string& owner, const char* quantity, const char* unit, const Source& first,
             bool by_default = true);
    void add_places(const Model& model);
    void add_joints(const Model& model);

    const ModalMachine& machine_;
    double size_ = 0;  ///< of the machine [m]
    std::vector<Channel> channels_;
    std::vector<Source> sources_;
};

}  // namespace dttmm::host
