// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

// A motion u of the frames at the λ at which D stands, everywhere in the machine.

/// Of a sum that gives a strain: some times that of the machine's numbers.
constexpr double kStrainRounding = 8 * std::numeric_limits<double>::epsilon();

/// Strain energy for a motion of amplitude u, and what of it may be rounding [J].
struct Strain {
    double energy = 0, unsure = 0;
};
/// Of springs and joints of every element, in the directions of its axes [J]; zero of one that is a line.
std::vector<Vector6> strain_by_direction(const FrequencyModel& model, const FrameVector& u);

/// Of every element.
std::vector<Strain> strain_energies(const DynamicStiffness& D, const FrameVector& u);

/// E of all elements [J]: a mix of shapes by c has the strain energy cᵀ E c.
Eigen::MatrixXd strain_between(const DynamicStiffness& D, const std::vector<FrameVector>& shapes);

/// Of all elements.
Strain sum(const std::vector<Strain>& strains);

/// Displacement [6, world] along an element at `count` equally spaced stations, ends included; its length [m], 0 if it is no
/// line. shape: NULL, or 6 numbers per station.
double along(const DynamicStiffness& D, size_t element, const FrameVector& u, size_t count, double* shape);

/// Displacement [6, world] of a line at a distance s from its start [m].
Vector6 motion_along(const DynamicStiffness& D, const LineModel& line, const FrameVector& u, double s);

/// Points of the machine and how they move: centres of mass of the bodies, nodes, stations along the lines. They do not
/// depend on the order in which the model lists its parts.
struct Station {
    Vector3 position;  ///< at the start [m, world]
    Vector6 motion;    ///< [world]
};
std::vector<Station> stations(const DynamicStiffness& D, const FrameVector& u);

/// Largest displacement [m] and rotation [rad] of frames and stations.
std::pair<double, double> largest(const DynamicStiffness& D, const FrameVector& u);

}  // namespace dttmm::plugin
