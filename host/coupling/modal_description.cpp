// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/modal_description.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <bitset>

#include "model/error.h"

namespace dttmm::host {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::vector<size_t> all_elements(const Model& model, const Plugins& plugins) {
    const std::vector<std::vector<size_t>> groups = split_by_plugin(model, plugins);
    if (groups.empty())
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: no element: nothing is elastic, nothing vibrates", model.path));
    if (groups.size() > 1) {
        const Element &first = model.elements[groups[0].front()], &other = model.elements[groups[1].front()];
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: element \"{}\" (plugin {}) and element \"{}\" (plugin {}): one plugin must have all "
                                "elements of a machine to know its small vibrations",
                                other.place, first.name, plugins.resolve(first.type).first->name(), other.name,
                                plugins.resolve(other.type).first->name()));
    }
    return groups.front();
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
    : description_(model, plugins, all_elements(model, plugins)),
      network_(description_.network()),
      directions_(static_cast<uint32_t>(model.modes.directions.to_ulong())),
      lumped_beams_(model.modes.are_beams_lumped) {
    for (const Joint& joint : model.joints) {
        dttmm_constraint out{joint.first, joint.second, {}, {}, static_cast<uint32_t>(rigid_of(joint.type).to_ulong())};
        Eigen::Map<Eigen::Vector3d>{out.position} = joint.anchor;
        Eigen::Map<RowMajor3>{out.axes} = axes_of(joint);
        constraints_.push_back(out);
    }
}

dttmm_modal_model ModalDescription::model() const {
    return {&network_, static_cast<uint32_t>(constraints_.size()), constraints_.data(), directions_, lumped_beams_};
}

}  // namespace dttmm::host
