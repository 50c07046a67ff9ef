// SPDX-License-Identifier: BSD-3-Clause
#include "modal/resting_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"
#include "element/parameters.h"
#include "mechanism/loading.h"
#include "statics/frame_links.h"
#include "statics/resting_joint.h"

namespace dttmm::plugin {

namespace {

/// Of a line that counts as nearly straight: how far it may be bent, as share of its radius of gyration. Pieces as long as
/// its segments leave up to 0.12 b²/n² of a frequency for a bend of b. At 3 that is what lumps leave in the second mode of a
/// beam, 0.5/n² to 2/n².
constexpr double kStraight = 3;

/// Segments stand for arcs of the curvature κ that moments make, and turn by κ times their length in the joints between
/// them. The axis passes κ h²/8 beside such a joint, local axes. factor: so many times the forces that have bent it.
Vector3 beside_joint(const Vector6& forces, double step, const Section& section, double factor) {
    if (factor == 0) return Vector3::Zero();
    const auto curvature = [&](double moment, double bending) { return is_given(bending) ? moment / bending : 0; };
    return step * step / (8 * factor) * Vector3(0, curvature(forces(5), section.EIz), -curvature(forces(4), section.EIy));
}

}  // namespace

void RestingParts::find_lines() {
    model_.resting.resize(model_.element_count);
    const Assembly exact = assemble(*description_.network, Waves::exact), lumps = assemble(*description_.network);
    for (const LineSpec& line : exact.lines) {
        const auto e = as_size(line.element);
        FrequencyModel::RestingLine& own = model_.resting[e];
        const std::vector<AtRest::Link>& links = rest_.elements[e];
        if (links.size() < 2) continue;
        own.points = {links.front().from.point(line.start)};
        for (size_t k = 0; k < links.size(); ++k) {
            const JointSpec& spec = lumps.joints[as_size(lumps.first_joint[e]) + k];
            const Joint joint(spec, lumps, std::make_shared<JointKind>(spec.law));
            const Pose from = links[k].from.pose(lumps.frames[as_size(spec.from)].pose);
            const Frame at_from = make_frame(from),
                        at_to = make_frame(links[k].to.pose(lumps.frames[as_size(spec.to)].pose));
            const JointPose pose = joint.pose(at_from, at_to);
            // The first joint and the last one lie inside the segments at the ends. Its forces act half way between its
            // ends.
            Matrix3 axes = pose.axes;
            Vector3 point = from.position + pose.arm;
            Vector6 forces = both(pose.axes) * (links[k].force + links[k].rigid);
            if (joint.is_line()) {
                const Vector6 x = joint.deformation(pose, at_from, at_to);
                axes = pose.axes * rotation_from_vector<double>(0.5 * x.tail<3>());
                const Vector3 half = 0.5 * pose.axes * x.head<3>();
                point -= half;
                forces = both(pose.axes) * (joint.spread(x, links[k].force) + links[k].rigid);
                forces.tail<3>() += half.cross(Vector3(forces.head<3>()));
            }
            const auto move_to = [&](const Vector3& end) {
                forces.tail<3>() += (point - end).cross(Vector3(forces.head<3>()));
                point = end;
            };
            if (k == 0) {
                move_to(own.points.front());
                own.ends[0] = links[k].from.turn * line.line.axes.col(0);
                own.axes = pose.axes;
                own.at_from = both(own.axes.transpose()) * forces;
            } else {
                if (k + 1 < links.size()) {
                    const double step = (line.finish - line.start).norm() / static_cast<double>(links.size() - 1);
                    move_to(point + axes * beside_joint(links[k].force, step, line.line.section, description_.rest->factor));
                } else {
                    move_to(links[k].to.point(line.finish));
                    own.ends[1] = links[k].to.turn * line.line.axes.col(0);
                    own.turned = rotation_vector(Matrix3(own.axes.transpose() * joint.seat().axes_at_to(FrameView(at_to))));
                }
                own.points.push_back(point);
                own.axes_of_segments.push_back(pose.axes);
            }
            own.forces.push_back(forces);
        }
        const double length = (line.finish - line.start).norm();
        own.turning = length * line_load(line.element, DTTMM_AXES_ELEMENT);
        own.steady = length * line_load(line.element, DTTMM_AXES_WORLD);
        if (description_.lumped_beams || line.line.stretches_only) continue;
        const LineForces forces = forces_of(line);
        own.share = forces.bend(line.line.section);
        own.is_lumped = own.share > kStraight;
        own.share = std::max(own.share, forces.bend_between(line.line.section));
    }
}

LineForces RestingParts::forces_of(const LineSpec& line) const {
    const FrequencyModel::RestingLine& own = model_.resting[as_size(line.element)];
    LineForces forces(own.points, own.forces, Vector6::Zero());
    forces = {own.points, own.forces, own.turning / forces.length(), description_.rest->factor};
    forces.set_weight(line.line.section.mass * rest_.gravity);
    forces.set_rise(own.steady.tail<3>() - own.steady.head<3>());
    forces.set_sections(own.axes_of_segments, own.ends);
    return forces;
}

/// Of the loads along a line in such axes: force per length at its start and at its end, at the start of time.
Vector6 RestingParts::line_load(int element, uint32_t axes) const {
    const dttmm_network& network = *description_.network;
    const size_t on_nodes = rest_.loads.size() - network.line_load_count;
    Vector6 sum = Vector6::Zero();
    for (uint32_t k = 0; k < network.line_load_count; ++k)
        if (as_int(network.line_loads[k].element) == element && network.line_loads[k].axes == axes)
            sum += rest_.loads[on_nodes + k];
    return sum;
}

void scale_to(Section& section, double stretch) {
    for (double* stiffness : {&section.EA, &section.EIy, &section.EIz, &section.GJ, &section.GAy, &section.GAz})
        *stiffness *= stretch;
    for (double* inertia : {&section.mass, &section.inertia, &section.rotary_y, &section.rotary_z}) *inertia /= stretch;
}

std::vector<const AtRest::Link*> RestingParts::place(Assembly& assembly) const {
    std::vector<const AtRest::Link*> links;
    std::vector<Pose> start;
    for (const FrameSpec& frame : assembly.frames) start.push_back(frame.pose);
    const auto place_frame = [&](int frame, const MovedFrame& moved) {
        assembly.frames[as_size(frame)].pose = moved.pose(start[as_size(frame)]);
    };
    for (size_t j = 0; j < assembly.joints.size(); ++j) {
        const JointSpec& joint = assembly.joints[j];
        if (const int h = as_int(j) - assembly.first_joint.back(); h >= 0) {
            const auto node = as_whole<uint32_t>(assembly.held_nodes[as_size(h)]);
            const auto found = std::ranges::find(rest_.held, node, &AtRest::Held::node);
            if (found == rest_.held.end()) throw Error(DTTMM_ERROR_INTERNAL, "a fixed node is not at rest", joint.element);
            links.push_back(&found->link);
        } else {
            links.push_back(
                &rest_.elements[as_size(joint.element)][j - as_size(assembly.first_joint[as_size(joint.element)])]);
        }
        place_frame(joint.from, links.back()->from);
        place_frame(joint.to, links.back()->to);
    }
    for (LineSpec& line : assembly.lines) {
        const std::vector<AtRest::Link>& own = rest_.elements[as_size(line.element)];
        const double length = (line.finish - line.start).norm();
        line.start = own.front().from.point(line.start);
        line.finish = own.back().to.point(line.finish);
        place_frame(line.from, own.front().from);  // what lines alone join
        place_frame(line.to, own.back().to);
        scale_to(line.line.section, forces_of(line).length() / length);
        const Vector3 x = (line.finish - line.start).normalized(), y = own.front().from.turn * line.line.axes.col(1),
                      z = x.cross(y).normalized();
        line.line.axes << x, z.cross(x), z;
    }
    return links;
}

void RestingParts::add_joint(const Joint& joint, const AtRest::Link& link, Ends at, int from, int to) {
    if (from < 0 && to < 0) return;
    const PlacedJoint placed(joint, at);
    const JointPose& pose = placed.pose;
    const Vector6& x = placed.x;
    const Vector3 point = placed.at.from.origin() + pose.arm;
    Bond bond;
    bond.element = joint.element();
    bond.from = from;
    bond.to = to;
    bond.points[0] = bond.points[1] = point;
    bond.by_from = FrequencyModel::at_point(point, model_.origin(from));
    bond.by_to = FrequencyModel::at_point(point, model_.origin(to));
    bond.axes = both(pose.axes);
    Vector6 tangent = unloading_tangent(joint, x);
    for (size_t d = 0; d < 6; ++d)
        if (joint.rigid()[d]) tangent(as_row(d)) = 0;
    const Matrix6 damping = joint.damping_tangent(x);
    bond.springs = tangent;
    bond.stiffness = bond.axes * joint.along(x, tangent) * bond.axes.transpose();
    bond.damping = bond.axes * damping * bond.axes.transpose();
    // Ground, and a support, moves by its motion at the origin of the world
    const bool is_ground[2] = {from < 0, to < 0};
    const auto by_ground = [&](int end) {
        return FrequencyModel::at_point((end == 0 ? placed.at.from : placed.at.to).origin(), Vector3::Zero());
    };
    Matrix6 rows[2] = {rigid_rows(joint, x.tail<3>(), joint.by_from(pose)),
                       rigid_rows(joint, x.tail<3>(), joint.by_to(pose))};
    for (int k : {0, 1})
        if (is_ground[k]) rows[k] *= by_ground(k);
    for_each_rigid(joint, [&](int, int d) {
        bond.held.push_back(bond.axes.col(d));
        bond.hold(rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
    bond.spread = spread_tangent(placed, link.force, link.rigid);
    EndBlocks turning = turning_stiffness(placed, link.force, link.rigid, bond.spread);
    // The rest balances on a frame that moves by itself: what is not symmetric adds up to nothing. A support has a given
    // motion
    for (int k : {0, 1})
        if (is_ground[k]) turning.at[1 - k][k] *= by_ground(k);
    if (!is_ground[0] && !is_ground[1]) {
        const Matrix6 across = 0.5 * (turning.at[0][1] + turning.at[1][0].transpose());
        turning.at[0][1] = across;
        turning.at[1][0] = across.transpose();
    }
    for (int i : {0, 1}) turning.at[i][i] = (0.5 * (turning.at[i][i] + turning.at[i][i].transpose())).eval();
    bond.turning = std::make_shared<const EndBlocks>(turning);
    bond.turned = joint.turns() ? Vector3(x.tail<3>()) : rotation_vector(joint.attitude(placed.at.from, placed.at.to));
    model_.bonds.push_back(std::move(bond));
}

/// What the forces of the constraint last added do as they turn with its bodies.
void RestingParts::turn_constraint(const double* stiffness, double factor) {
    EndBlocks turning;
    const Eigen::Map<const Eigen::Matrix<double, 12, 12, Eigen::RowMajor>> K(stiffness);
    for (int i : {0, 1})
        for (int k : {0, 1}) turning.at[i][k] = factor * K.block<6, 6>(6 * i, 6 * k);
    model_.bonds.back().turning = std::make_shared<const EndBlocks>(turning);
}

void RestingParts::add_loads(const Assembly& assembly, const std::vector<int>& frame_of) {
    for (uint32_t b = 0; b < description_.network->body_count; ++b)
        model_.levers.push_back(
            {-1, as_int(b),
             description_.rest->factor * Eigen::Map<const Matrix6>(description_.rest->loads + 36 * size_t{b})});
    const Loading loading(assembly, *description_.network);
    for (size_t f = 0; f < frame_of.size(); ++f) {
        const int frame = frame_of[f];
        if (frame < 0 || !loading.is_on(as_int(f))) continue;
        const Matrix6 stiffness = loading.stiffness(as_int(f), make_frame(assembly.frames[f].pose), model_.origin(frame),
                                                    rest_.loads.front().data());
        model_.levers.push_back({-1, frame, model_.mask * stiffness * model_.mask});
    }
}

void RestingParts::add_lever(int element, int frame, const Vector3& point, const Vector3& force) {
    const Matrix3 aF = skew(point - model_.origin(frame)) * skew(force);
    Matrix6 stiffness = Matrix6::Zero();
    stiffness.bottomRightCorner<3, 3>() = -0.5 * (aF + aF.transpose());
    model_.levers.push_back({element, frame, model_.mask * stiffness * model_.mask});
}

void RestingParts::add_bar_force(const LineModel& line, const LineForces& forces) {
    const int frame = line.from >= 0 ? line.from : line.to;
    if (frame < 0) return;
    const Vector3 f = forces.mean_force(), e = line.axes.col(0);
    Matrix6 stiffness = Matrix6::Zero();
    stiffness.bottomRightCorner<3, 3>() =
        forces.length() * (f.dot(e) * Matrix3::Identity() - 0.5 * (e * f.transpose() + f * e.transpose()));
    // Loads that turn with the line, which is as stiff across as the frame
    Matrix6 half = Matrix6::Zero();
    for (size_t k = 0; k < LineShapes::kPoints.size(); ++k) {
        const double s = LineShapes::kPoints[k] * forces.length(), weight = LineShapes::kWeights[k] * forces.length();
        const Matrix3 q = 0.5 * weight * skew(Vector3(line.axes * forces.turning_load(LineShapes::kPoints[k])));
        half.topRightCorner<3, 3>() += q;
        half.bottomRightCorner<3, 3>() += skew(Vector3(line.start + s * e - model_.origin(frame))) * q;
    }
    stiffness += half + half.transpose();
    model_.levers.push_back({line.element, frame, stiffness, true});
}

void RestingParts::add_deviation(const LineModel& line, const Matrix12& K) {
    Bond turning;
    turning.element = line.element;
    turning.from = line.from;
    turning.to = line.to;
    turning.points[0] = line.start;
    turning.points[1] = line.finish;
    turning.by_from = FrequencyModel::at_point(line.start, model_.origin(line.from));
    turning.by_to = FrequencyModel::at_point(line.finish, model_.origin(line.to));
    turning.axes = both(line.axes);
    turning.springs.setZero();
    turning.stiffness.setZero();
    turning.damping.setZero();
    const Matrix6 by[2] = {turning.axes.transpose() * turning.by_from, turning.axes.transpose() * turning.by_to};
    EndBlocks blocks;
    for (int i : {0, 1})
        for (int k : {0, 1}) blocks.at[i][k] = by[i].transpose() * K.block<6, 6>(6 * i, 6 * k) * by[k];
    turning.turning = std::make_shared<const EndBlocks>(blocks);
    model_.bonds.push_back(std::move(turning));
}

}  // namespace dttmm::plugin
