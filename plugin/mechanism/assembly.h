// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/index.h"
#include "core/pose.h"
#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm::plugin {

/// A frame that joints meet at: a body of the host, a point of the ground, or something that moves inside the network, a
/// mass (its origin then is the centre of mass) or a massless node.
struct FrameSpec {
    enum class Kind { port, ground, inner };
    Kind kind = Kind::inner;
    int segment = 0;                           ///< of an element, from 1; 0: it is no segment
    int element = -1;                          ///< one that hangs on it
    std::shared_ptr<const std::string> label;  ///< node "muzzle"; of all segments of an element: element "barrel"
    Pose pose;                                 ///< at the start; of a port that of its body
    double mass = 0;                           ///< [kg]
    Matrix3 inertia = Matrix3::Zero();         ///< about the origin, axes of the frame [kg m²]
    /// For messages: node "muzzle", segment 3 of element "barrel".
    std::string name() const;
};

/// A massless joint between two frames.
struct JointSpec {
    int element = 0;
    int from = 0, to = 0;  ///< frames
    std::shared_ptr<const JointLaw> law;
    Pose pose;  ///< the point where its ends meet at the start, and its axes
};

/// A uniform element in the frequency domain, between points of two frames.
struct LineSpec {
    int element = 0;
    int from = 0, to = 0;   ///< frames
    Vector3 start, finish;  ///< its ends, world [m]
    Line line;
};

/// The lumps of an element that is a line: frames first … first + count − 1, from its `from` end to its `to` end.
struct SegmentsSpec {
    int element = 0;
    int first = 0, count = 0;
    double length = 0;  ///< of a segment [m]
    Vector3 arm;        ///< from a frame's origin to the middle of its segment on the axis, axes of the frame [m]
    SectionModuli moduli;
};

/// A node of the description as a point of a frame.
struct NodeSpec {
    int frame = -1;
    Vector3 offset = Vector3::Zero();        ///< from the frame's origin, in its axes
    Matrix3 rotation = Matrix3::Identity();  ///< of the node's axes in those of the frame
    std::string name;                        ///< for messages: node "muzzle"
    int element = -1;                        ///< one that hangs on it
};

/// A network taken apart into frames and joints. The ports, which are the bodies, come first among the frames, in their
/// order, then the ground, then what is inside; the joints are in the order of the elements, within an element from its
/// `from` end to its `to` end.
struct Assembly {
    std::vector<FrameSpec> frames;
    int port_count = 0, driven_count = 0;  ///< ports; ports and ground
    std::vector<JointSpec> joints;         ///< of a Network until it is made
    std::vector<LineSpec> lines;           ///< with Waves::exact
    std::vector<NodeSpec> nodes;           ///< in the order of the description; none where a Network is done with them
    std::vector<SegmentsSpec> segments;    ///< of the lines that are divided, by element
    std::vector<int> first_joint;          ///< of every element, and one past the last; then those that hold fixed nodes
    std::vector<int> held_nodes;           ///< what the latter hold, in their order
    int inner_count() const { return as_int(frames.size()) - driven_count; }
};

/// What becomes of elements whose mass is spread along them: lumps and joints, or lines.
enum class Waves { lumped, exact };

/// Throws Error naming element or node: an end that is no node, a node on a body that there is not, a mass on a body, both
/// ends of a joint on one frame, a velocity in a fixed direction, a number that is not finite, a force per length on what is
/// no line. lumped: of the elements, those that are lumps and joints all the same; NULL: none. supported_by: of every node
/// the body that its fixed directions hang on; −1, or where there is none: the ground.
Assembly assemble(const dttmm_network& description, Waves waves = Waves::lumped, const std::vector<bool>* lumped = nullptr,
                  std::span<const int> supported_by = {});

}  // namespace dttmm::plugin
