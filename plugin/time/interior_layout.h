// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/index.h"
#include "mechanism/loading.h"
#include "mechanism/mechanism.h"
#include "mechanism/momentum.h"
#include "time/massless.h"

namespace dttmm::plugin {

/// What of the inside of a network stays as it is: its masses, who is next to whom, which joints do what.
struct InteriorLayout {
    InteriorLayout(const Mechanism& mechanism, const dttmm_network& description, const MasslessFrames& massless,
                   const Loading& loading);

    bool is_inner(int frame) const { return frame >= driven; }
    /// Of an inner frame among these.
    size_t at(int frame) const { return as_size(frame - driven); }

    int ports, driven, count;  ///< frames that are ports, ports and ground, and inner ones
    Vector3 gravity;

    // Of every inner frame:
    std::vector<Inertia> inertias;
    std::vector<Matrix3> inverse_moments;  ///< of inertia, axes of the frame; zero where there is none
    std::vector<double> reach;             ///< of its joints from its origin [m], at least its radius of gyration
    std::vector<double> turn_weight;       ///< its square, and 1 by that: what makes one size of linear and angular motion,
    std::vector<double> spin_weight;       ///< and of linear and angular momentum; 0: nothing reaches out
    std::vector<int> receivers;            ///< frame nearby that takes over what a massless one leaves over; −1: none
    std::vector<int> load_of;              ///< index in `loaded`; −1: none

    std::vector<double> port_reach;  ///< the reach of every port
    std::vector<int> port_frames;    ///< the ports, and massless frames whose receivers they are

    std::vector<int> inner_nodes;  ///< of the description
    /// How each of them is to start.
    struct Given {
        bool moves;
        Twist velocity;
    };
    std::vector<Given> given;
    std::vector<size_t> loaded;  ///< inner frames that a load may act on, or with a massless half: the others take no load

    std::vector<size_t> port_joints;      ///< of the ports
    std::vector<size_t> near_joints;      ///< whose forces the ports feel
    std::vector<int> near_index;          ///< of every joint among them; −1: it is not
    std::vector<size_t> rigid_joints;     ///< with rigid directions
    std::vector<int> rigid_index;         ///< of every joint among them; −1: it has none
    std::vector<size_t> settling_joints;  ///< of massless frames

private:
    void read_nodes(const dttmm_network& description);
    void set_reaches(const Mechanism& mechanism);
    void choose_receivers(const Mechanism& mechanism, const MasslessFrames& massless);
    void choose_near(const Mechanism& mechanism);
    void choose_loaded(const Loading& loading, const MasslessFrames& massless);
};

}  // namespace dttmm::plugin
