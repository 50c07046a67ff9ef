// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/nonconservative.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// Directions and forms of a unit load on unit motions below it are 0: rounding of anchors and axes is below 1e-12.
constexpr double kEmpty = 1e-9;

/// An orthonormal basis of what the columns span, and of what they leave.
struct Bases {
    Eigen::MatrixXd span, rest;
};
Bases bases_of(const Eigen::MatrixXd& columns) {
    if (columns.cols() == 0) return {Eigen::MatrixXd(6, 0), Eigen::MatrixXd::Identity(6, 6)};
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(columns, Eigen::ComputeFullU);
    const Eigen::VectorXd& values = svd.singularValues();
    Eigen::Index rank = 0;
    while (rank < values.size() && values(rank) > kEmpty) ++rank;
    return {svd.matrixU().leftCols(rank), svd.matrixU().rightCols(6 - rank)};
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    Eigen::MatrixXd both(6, a.cols() + b.cols());
    both << a, b;
    return both;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
    Eigen::Matrix3d matrix;
    matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return matrix;
}

/// What ideal joints leave each body: motions [v; θ] of the point of it that is at `origin`, lengths by `size`. A joint
/// gives a body the motions of the other one and its own free ones; several joints leave what all of them give. In loops
/// that is more than is free: a load may then count as one without a potential that has one.
class FreeMotionsOfBodies {
public:
    FreeMotionsOfBodies(const Model& model, const ModalDescription& machine)
        : description_(machine.model()),
          joints_(model.bodies.size()),
          free_(model.bodies.size(), Eigen::MatrixXd::Identity(6, 6)) {
        const uint32_t count = description_.constraint_count;
        if (count > 0) origin_ = Eigen::Map<const Eigen::Vector3d>(description_.constraints[0].position);
        for (uint32_t j = 0; j < count; ++j) {
            const dttmm_constraint& joint = description_.constraints[j];
            size_ = std::max(size_, (Eigen::Map<const Eigen::Vector3d>(joint.position) - origin_).norm());
            for (const int body : {joint.first, joint.second})
                if (body >= 0) joints_[as_size(body)].push_back(j);
        }
        if (size_ == 0) size_ = 1;
        for (uint32_t j = 0; j < count; ++j) own_.push_back(motions_of(description_.constraints[j]));
        std::deque<size_t> waiting;
        for (size_t b = 0; b < joints_.size(); ++b) waiting.push_back(b);
        while (!waiting.empty()) {
            const size_t body = waiting.front();
            waiting.pop_front();
            if (!narrow(body)) continue;
            for (const uint32_t j : joints_[body])
                if (const int other = other_of(j, body); other >= 0) waiting.push_back(as_size(other));
        }
    }

    /// Of the point of a body that is at p, 6 × as many as are free.
    Eigen::MatrixXd at(size_t body, const Eigen::Vector3d& p) const {
        Eigen::MatrixXd motions = free_[body];
        motions.topRows<3>() -= cross((p - origin_) / size_) * motions.bottomRows<3>();
        return motions;
    }

private:
    int other_of(uint32_t j, size_t body) const {
        const dttmm_constraint& joint = description_.constraints[j];
        return joint.first == as_int(body) ? joint.second : joint.first;
    }
    Eigen::MatrixXd motions_of(const dttmm_constraint& joint) const {
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(joint.axes);
        const Eigen::Vector3d arm = (Eigen::Map<const Eigen::Vector3d>(joint.position) - origin_) / size_;
        Eigen::MatrixXd motions(6, 0);
        for (int d = 0; d < 6; ++d) {
            if (joint.rigid >> d & 1u) continue;
            const Eigen::Vector3d axis = axes.col(d % 3);
            Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
            if (d < 3)
                motion.head<3>() = axis;
            else
                motion << arm.cross(axis), axis;
            motions = beside(motions, motion);
        }
        return motions;
    }
    /// Whether less is left than before.
    bool narrow(size_t body) {
        Eigen::MatrixXd held(6, 0);
        for (const uint32_t j : joints_[body]) {
            const int other = other_of(j, body);
            const Eigen::MatrixXd of_other = other < 0 ? Eigen::MatrixXd(6, 0) : free_[as_size(other)];
            held = beside(held, bases_of(beside(of_other, own_[j])).rest);
        }
        const Eigen::MatrixXd left = bases_of(held).rest;
        if (left.cols() >= free_[body].cols()) return false;
        free_[body] = left;
        return true;
    }

    dttmm_modal_model description_;
    std::vector<std::vector<uint32_t>> joints_;  ///< by body
    std::vector<Eigen::MatrixXd> own_;           ///< what each joint leaves free itself
    std::vector<Eigen::MatrixXd> free_;          ///< by body
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    double size_ = 0;
};

/// The antisymmetric part b(1, 2) of a unit load, by motions [v; θ] of its point.
Eigen::MatrixXd form_of(const Load& load, const Eigen::Vector3d& direction) {
    Eigen::MatrixXd form = Eigen::MatrixXd::Zero(6, 6);
    if (load.is_moment)
        form.bottomRightCorner<3, 3>() = -cross(direction);  // m·(θ1 × θ2) = −θ1·(m × θ2)
    else
        form.topRightCorner<3, 3>() = form.bottomLeftCorner<3, 3>() = -cross(direction);
    return form;
}

bool has_potential(const Load& load, const Eigen::Vector3d& direction, const Eigen::MatrixXd& free) {
    if (free.cols() < 2) return true;
    return (free.transpose() * form_of(load, direction) * free).cwiseAbs().maxCoeff() <= kEmpty;
}

/// Directions in which a node is not fixed. Those that are fixed turn with a support: which are free then is not looked at,
/// unless it is one at most.
Eigen::MatrixXd free_of(const Node& node) {
    Eigen::MatrixXd free = Eigen::MatrixXd::Zero(6, 0);
    const bool turns = node.is_support() && (node.fixed >> 3).count() < 2;
    for (size_t d = 0; d < 6; ++d)
        if (!node.fixed[d] || (turns && d >= 3)) free = beside(free, Eigen::MatrixXd::Identity(6, 6).col(as_row(d)));
    return free;
}

}  // namespace

std::vector<size_t> find_nonconservative(const Model& model, const ModalDescription& machine) {
    std::vector<size_t> found;
    if (!machine.rest()) return found;
    std::optional<FreeMotionsOfBodies> bodies;  // made where a load on a body asks for it
    for (size_t i = 0; i < model.loads.size(); ++i) {
        const Load& load = model.loads[i];
        if ((!load.turns && !load.is_moment) || (load.signal.value(0) == 0 && load.at_to().value(0) == 0)) continue;
        bool is_conservative = false;  // along a line
        if (load.on.node >= 0)
            is_conservative = has_potential(load, load.direction, free_of(model.nodes[as_size(load.on.node)]));
        if (load.on.body >= 0) {
            if (!bodies) bodies.emplace(model, machine);
            const size_t b = as_size(load.on.body);
            const BodyState& at = machine.rest()->at[b];
            const Body& body = model.bodies[b];
            Eigen::Vector3d point = at.position;
            if (load.on.marker >= 0)
                point += at.rotation * (body.markers[as_size(load.on.marker)].position - body.center_of_mass);
            const Eigen::Vector3d direction = load.turns ? Eigen::Vector3d(at.rotation * load.direction) : load.direction;
            is_conservative = has_potential(load, direction, bodies->at(b, point));
        }
        if (!is_conservative) found.push_back(i);
    }
    return found;
}

}  // namespace dttmm::host
