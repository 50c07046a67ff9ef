// SPDX-License-Identifier: BSD-3-Clause
#include "time/supports.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

namespace {

using Map3 = Eigen::Map<const Vector3>;

constexpr uint32_t kAllFixed = 0x3f;

void write(dttmm_motion& out, const Frame& frame, const Twist& twist) {
    std::copy_n(frame.position, 3, out.position);
    std::copy_n(frame.rotation, 9, out.rotation);
    Eigen::Map<Vector3>{out.velocity} = twist.linear;
    Eigen::Map<Vector3>{out.angular_velocity} = twist.angular;
}

/// What leads from one frame to another: shift and rotation vector, world axes.
Twist between(const Frame& from, const Frame& to) {
    return {FrameView(to).origin() - FrameView(from).origin(),
            rotation_vector(FrameView(to).axes() * FrameView(from).axes().transpose())};
}

bool is_finite(const dttmm_support_motion& motion) {
    const double* numbers = motion.displacement;
    return std::all_of(numbers, numbers + sizeof(motion) / sizeof(double), [](double x) { return std::isfinite(x); });
}

}  // namespace

Supports::Supports(const dttmm_network& description) : description_(description) {
    if (description.support_count == 0) return;
    bodies_.assign(description.bodies, description.bodies + description.body_count);
    all_nodes_.assign(description.nodes, description.nodes + description.node_count);
    for (uint32_t index : std::span(description.supports, description.support_count)) {
        if (index >= description.node_count || description.nodes[index].kind != DTTMM_NODE_INNER ||
            description.nodes[index].fixed == 0 || (!nodes_.empty() && index <= nodes_.back()))
            throw Error(DTTMM_ERROR_ARGUMENT,
                        fmt::format("support {}: supports are inner nodes with fixed directions, ascending", index));
        dttmm_node& node = all_nodes_[index];
        const auto body = as_whole<uint32_t>(bodies_.size());
        if (node.fixed == kAllFixed) {
            node.kind = DTTMM_NODE_ON_BODY;
            node.body = body;
        }
        dttmm_body support{node.name, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
        std::copy_n(node.position, 3, support.position);
        bodies_.push_back(support);
        nodes_.push_back(index);
        Frame frame;
        std::copy_n(support.position, 3, frame.position);
        std::copy_n(support.rotation, 9, frame.rotation);
        rest_.push_back(frame);
    }
    description_.bodies = bodies_.data();
    description_.body_count = as_whole<uint32_t>(bodies_.size());
    description_.nodes = all_nodes_.data();
    wanted_.resize(nodes_.size());
    first_ = wanted_;
    at_ = before_ = end_ = rest_;
    begin_statics();
    over_.resize(nodes_.size());
    rigid_.assign(nodes_.size(), Vector6::Zero());
    over_before_ = open_ = over_;
}

int Supports::body_of(uint32_t node) const {
    const auto found = std::ranges::find(nodes_, node);
    return found == nodes_.end() ? -1 : as_int(bodies_.size() - nodes_.size()) + as_int(found - nodes_.begin());
}

void Supports::move_to(const dttmm_support_motion* motions) {
    for (size_t s = 0; s < nodes_.size(); ++s)
        if (!is_finite(motions[s]))
            throw Error(DTTMM_ERROR_ARGUMENT,
                        fmt::format("support \"{}\": its motion is not finite", all_nodes_[nodes_[s]].name));
    std::copy_n(motions, wanted_.size(), wanted_.begin());
}

Supports::Way Supports::wanted(size_t s) const { return {Map3(wanted_[s].displacement), Map3(wanted_[s].rotation)}; }

Frame Supports::at_end(size_t s, const Way& way) const {
    Frame frame = rest_[s];
    for (int i = 0; i < 3; ++i) frame.position[i] += way.shift(i);
    Eigen::Map<RowMajor3>{frame.rotation} = rotation_from_vector(way.turn);
    return frame;
}

// ---- In time ------------------------------------------------------------------------------------------------------------

void Supports::start() {
    for (size_t s = 0; s < nodes_.size(); ++s) {
        at_[s] = target(s);
        over_[s] = {Map3(wanted_[s].velocity), Map3(wanted_[s].angular_velocity)};
    }
    before_ = at_;
    over_before_ = over_;
    first_ = wanted_;
    record_ = {};
}

void Supports::start_at_rest() {
    for (size_t s = 0; s < nodes_.size(); ++s) at_[s] = at_end(s, rest_at_[s]);
    before_ = at_;
    std::ranges::fill(over_, Twist{});
    over_before_ = over_;
    std::ranges::fill(first_, dttmm_support_motion{});
    record_ = {};
}

void Supports::begin_step(double h) {
    record_.step_size = h;
    for (size_t s = 0; s < nodes_.size(); ++s) {
        end_[s] = target(s);
        const Twist way = between(at_[s], end_[s]);
        open_[s] = {way.linear / h, way.angular / h};
    }
}

void Supports::commit_step() {
    before_.swap(at_);
    at_ = end_;
    over_before_.swap(over_);
    over_ = open_;
    record_.steps += 1;
}

void Supports::write_start(std::span<dttmm_motion> out) const {
    for (size_t s = 0; s < nodes_.size(); ++s) write(out[s], at_[s], over_[s]);
}

void Supports::write_end(std::span<dttmm_motion> out) const {
    for (size_t s = 0; s < nodes_.size(); ++s) write(out[s], end_[s], open_[s]);
}

void Supports::write_instant(std::span<dttmm_motion> out) const {
    for (size_t s = 0; s < nodes_.size(); ++s) {
        Twist mean{0.5 * (over_before_[s].linear + over_[s].linear), 0.5 * (over_before_[s].angular + over_[s].angular)};
        if (record_.steps == 1) mean = {Map3(first_[s].velocity), Map3(first_[s].angular_velocity)};
        write(out[s], before_[s], mean);
    }
}

void Supports::write_accelerations(double* out) const {
    for (const dttmm_support_motion& motion : first_) {
        out = std::copy_n(motion.acceleration, 3, out);
        out = std::copy_n(motion.angular_acceleration, 3, out);
    }
}

void Supports::add_work(const double* wrenches, const double* rigid) {
    const auto dot = [](const Vector6& wrench, const Twist& twist) {
        return wrench.head<3>().dot(twist.linear) + wrench.tail<3>().dot(twist.angular);
    };
    record_.work += record_.last_work;
    record_.last_work = 0;
    for (size_t s = 0; s < nodes_.size(); ++s, wrenches += 6, rigid += 6) {  // they are on the supports
        const Vector6 now = Eigen::Map<const Vector6>(rigid), elastic = Eigen::Map<const Vector6>(wrenches) - now;
        record_.last_work -= record_.step_size * dot(elastic, over_[s]);
        if (record_.steps > 1) record_.work -= 0.5 * record_.step_size * dot(rigid_[s] + now, over_before_[s]);
        rigid_[s] = now;
    }
}

// ---- At rest ------------------------------------------------------------------------------------------------------------

void Supports::begin_statics() {
    rest_at_.assign(nodes_.size(), {});
    rest_base_ = rest_kept_ = rest_at_;
}

std::optional<double> Supports::write_change(double* out) const {
    std::optional<double> largest;
    for (size_t s = 0; s < nodes_.size(); ++s, out += 6) {
        const Way &base = rest_base_[s], end = wanted(s);
        const Vector3 shift = end.shift - base.shift, turn = angular_velocity(base.turn, end.turn - base.turn);
        Eigen::Map<Vector3>{out} = shift;
        Eigen::Map<Vector3>{out + 3} = turn;
        if (!shift.isZero(0) || !turn.isZero(0)) largest = std::max(largest.value_or(0), turn.norm());
    }
    return largest;
}

void Supports::move_statics(double share) {
    for (size_t s = 0; s < nodes_.size(); ++s) {
        const Way &base = rest_base_[s], end = wanted(s);
        rest_at_[s] = share == 1
                          ? end
                          : Way{base.shift + share * (end.shift - base.shift), base.turn + share * (end.turn - base.turn)};
    }
}

void Supports::write_at_rest(std::span<dttmm_motion> out) const {
    for (size_t s = 0; s < nodes_.size(); ++s) write(out[s], at_end(s, rest_at_[s]), {});
}

}  // namespace dttmm::plugin
