// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/modal_description.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <bitset>
#include <numeric>

#include "model/error.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::vector<size_t> all_elements(const Model& model) {
    if (model.elements.empty())
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: no element: nothing is elastic, nothing vibrates", model.path));
    std::vector<size_t> elements(model.elements.size());
    std::iota(elements.begin(), elements.end(), size_t{0});
    return elements;
}

/// Directions that a joint does not give, in axes whose x is its axis and whose y is its second one.
std::bitset<6> rigid_of(JointType type) {
    switch (type) {
        case JointType::ball:
            return 0b000111;
        case JointType::hinge:
            return 0b110111;
        case JointType::slider:
            return 0b111110;
        case JointType::universal:
            return 0b100111;
        case JointType::fixed:
            break;
    }
    return 0b111111;
}

/// x along the axis, y along the second one where there is one.
Eigen::Matrix3d axes_of(const Joint& joint) {
    const Eigen::Vector3d x = joint.axis.normalized();
    const Eigen::Vector3d y =
        joint.type == JointType::universal ? Eigen::Vector3d(joint.axis2 - x * x.dot(joint.axis2)) : x.unitOrthogonal();
    Eigen::Matrix3d axes;
    axes << x, y.normalized(), x.cross(y.normalized());
    return axes;
}

}  // namespace

ModalDescription::ModalDescription(const Model& model, const Plugins& plugins)
    : description_(model, plugins, all_elements(model)),
      network_(description_.network()),
      directions_(static_cast<uint32_t>(model.modes.directions.to_ulong())),
      lumped_beams_(model.modes.are_beams_lumped) {
    for (const Body& body : model.bodies) {
        dttmm_body out{body.name.c_str(), {}, body.mass, {}};
        Eigen::Map<Eigen::Vector3d>{out.position} = body.position + body.rotation * body.center_of_mass;
        Eigen::Map<RowMajor3>{out.inertia} = body.rotation * body.inertia * body.rotation.transpose();
        bodies_.push_back(out);
    }
    for (const NetworkDescription::Port& port : description_.ports())
        port_bodies_.push_back(static_cast<uint32_t>(port.at.body));
    for (const Joint& joint : model.joints) {
        dttmm_constraint out{joint.first, joint.second, {}, {}, static_cast<uint32_t>(rigid_of(joint.type).to_ulong())};
        Eigen::Map<Eigen::Vector3d>{out.position} = joint.anchor;
        Eigen::Map<RowMajor3>{out.axes} = axes_of(joint);
        constraints_.push_back(out);
    }
}

dttmm_modal_model ModalDescription::model() const {
    return {&network_,
            static_cast<uint32_t>(bodies_.size()),
            bodies_.data(),
            port_bodies_.data(),
            static_cast<uint32_t>(constraints_.size()),
            constraints_.data(),
            directions_,
            lumped_beams_};
}

}  // namespace dttmm::host
