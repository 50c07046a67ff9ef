// SPDX-License-Identifier: BSD-3-Clause
#include "step/observer.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <unordered_set>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using Of = Channel::Of;

constexpr const char* kAxes[] = {"x", "y", "z"};

double* write(double* out, const Eigen::Vector3d& v) {
    Eigen::Map<Eigen::Vector3d>{out} = v;
    return out + 3;
}

/// Motion of a body at t_n, centre of mass.
struct Moving {
    const BodyState& at;
    const Eigen::Matrix<double, 6, 1>& acceleration;
    Eigen::Vector3d velocity_at(const Eigen::Vector3d& arm) const { return at.velocity + at.angular_velocity.cross(arm); }
    Eigen::Vector3d acceleration_at(const Eigen::Vector3d& arm) const {
        const Eigen::Vector3d& w = at.angular_velocity;
        return acceleration.head<3>() + acceleration.tail<3>().cross(arm) + w.cross(w.cross(arm));
    }
};

/// Markers that an element or a load is attached to, as (body, marker).
std::set<std::pair<int, int>> used_markers(const Model& model) {
    std::set<std::pair<int, int>> used;
    for (const Element& element : model.elements)
        for (const Attachment& end : element.ends) used.emplace(end.body, end.marker);
    for (const Load& load : model.loads) used.emplace(load.on.body, load.on.marker);
    return used;
}

/// An element may be called like a node as long as their channels differ.
void refuse_shared_channels(const Model& model, const std::vector<Channel>& channels) {
    std::unordered_set<std::string_view> nodes;
    for (const Node& node : model.nodes) nodes.insert(node.name);
    std::map<std::string_view, const Element*> shared;  // elements called like a node
    for (const Element& element : model.elements)
        if (nodes.contains(element.name)) shared.emplace(element.name, &element);
    std::set<std::string> names;
    for (const Channel& channel : channels) {
        const auto found = shared.find(channel.owner());
        if (found == shared.end() || names.insert(channel.name()).second) continue;
        const Element& element = *found->second;
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: element \"{}\": a node has the same name, and both have a channel \"{}\"; rename one",
                                element.place, element.name, channel.name_in_owner()));
    }
}

}  // namespace

Observer::Observer(const Model& model, Networks& networks, const JointSystem& joints)
    : bodies_(model.bodies), joints_(joints.joints()), gravity_(model.simulation.gravity) {
    size_t markers = 0;
    for (const Body& body : bodies_) markers += body.markers.size();
    size_t energies = 0;
    for (const NetworkInstance& instance : networks.instances())
        energies += as_size(std::ranges::count_if(instance.roles(), NetworkInstance::is_energy));
    channels_.reserve(networks.output_count() - energies + 7 * model.joints.size() + 16 * bodies_.size() + 9 * markers + 6);
    channels_.emplace_back("time", "s");
    declare_networks(model, networks);
    declare_joints(model);
    declare_bodies(model);
    declare_energies();
    if (model.output.has_lines) {
        networks.watch_lines(kStations);
        declare_lines(networks);
    }
    networks.share_channels(std::span(channels_).subspan(1));
    room_ = std::max(channels_.size(), 1 + networks.output_count());
}

void Observer::add_vector(Channel::Of of, const std::string& owner, const char* quantity, const char* unit,
                          bool by_default) {
    for (const char* axis : kAxes) channels_.push_back(Channel(of, owner, quantity, axis, unit, by_default));
}

void Observer::declare_networks(const Model& model, const Networks& networks) {
    for (const NetworkInstance& instance : networks.instances())
        for (size_t c = 0; c < instance.channel_count(); ++c) {
            const Channel channel = instance.channel(c);
            const uint8_t role = instance.roles()[c];
            if (NetworkInstance::is_energy(role)) continue;
            if (role == DTTMM_ROLE_LIMIT) limits_.push_back({channels_.size(), channel.owner()});
            channels_.push_back(channel);
        }
    network_channels_ = channels_.size() - 1;
    refuse_shared_channels(model, channels_);
}

void Observer::declare_joints(const Model& model) {
    for (size_t j = 0; j < model.joints.size(); ++j) {
        const std::string& name = model.joints[j].name;
        add_vector(Of::joint, name, "force", "N");
        add_vector(Of::joint, name, "moment", "N*m");
        const JointEquations& equations = joints_[j];
        if (!equations.has_coordinate()) continue;
        if (equations.turns())
            channels_.push_back(Channel(Of::joint, name, "angle", "", "rad"));
        else
            channels_.push_back(Channel(Of::joint, name, "travel", "", "m"));
    }
}

void Observer::declare_bodies(const Model& model) {
    const auto used = used_markers(model);
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const std::string& name = bodies_[b].name;
        add_vector(Of::body, name, "position", "m");
        add_vector(Of::body, name, "velocity", "m/s");
        add_vector(Of::body, name, "acceleration", "m/s^2");
        add_vector(Of::body, name, "angular_velocity", "rad/s");
        for (const char* part : {"w", "x", "y", "z"}) channels_.push_back(Channel(Of::body, name, "quaternion", part, "1"));
        for (size_t m = 0; m < bodies_[b].markers.size(); ++m) {
            const Marker& marker = bodies_[b].markers[m];
            const std::string point = name + "." + marker.name;
            add_vector(Of::marker, point, "acceleration", "m/s^2", marker.is_probe || used.contains({as_int(b), as_int(m)}));
            add_vector(Of::marker, point, "position", "m", marker.is_probe);
            add_vector(Of::marker, point, "velocity", "m/s", marker.is_probe);
        }
    }
}

void Observer::declare_energies() {
    for (const char* part : {"kinetic", "strain", "dissipated", "work", "residual"})
        channels_.push_back(Channel(Of::energy, "energy", part, "", "J"));
}

void Observer::declare_lines(const Networks& networks) {
    for (const NetworkInstance& instance : networks.instances())
        for (const uint32_t element : instance.lines()) {
            shows_lines_ = true;
            for (uint32_t s = 0; s < kStations; ++s)
                add_vector(Of::element, instance.element_name(element), fmt::format("station{}.position", s).c_str(), "m",
                           false);
        }
}

void Observer::want(std::span<const int> channels) {
    wants_networks_ = std::ranges::any_of(channels, [&](int c) {
        return (c > 0 && as_size(c) <= network_channels_) || channels_[as_size(c)].of() == Of::energy;
    });
}

void Observer::advance(const Loads& loads, const StepEquations& step, const std::vector<BodyState>& before,
                       const std::vector<BodyState>& after, double h) {
    const double stop_loss = -step.stop_work(before, after);
    if (ledger_.opened) ledger_.stop_loss += 0.5 * (ledger_.stop_loss_now + stop_loss);
    ledger_.stop_loss_now = ledger_.opened ? stop_loss : 2 * stop_loss;  // what strikes at the start counts from then on
    const double drive_work = step.drive_work(before, after);
    ledger_.load_work += ledger_.last_work + 0.5 * (ledger_.drive_work_now + drive_work);
    ledger_.drive_work_now = drive_work;
    ledger_.last_work = loads.work_over_step(before, after, h);
}

std::span<const double> Observer::row(double time, const Networks& networks, const Instant& instant) {
    Energies energies{kinetic_energy(instant.at), 0, ledger_.stop_loss, ledger_.load_work + gravity_work(instant.at)};
    row_.front() = time;
    double* out = row_.data() + 1;
    if (wants_networks_)
        out = write_networks(out, networks, energies);
    else
        out = std::fill_n(out, network_channels_, 0.0);
    for (Limit& limit : limits_)
        if (row_[limit.channel] > limit.most) limit.most = row_[limit.channel], limit.time = time;
    out = write_joints(out, instant);
    out = write_bodies(out, instant);

    const auto& [kinetic, strain, dissipated, work] = energies;
    const double balance = kinetic + strain + dissipated - work;
    if (!ledger_.opened) ledger_.initial = balance;
    ledger_.opened = true;
    for (double value : {kinetic, strain, dissipated, work, balance - ledger_.initial}) *out++ = value;
    if (shows_lines_) networks.positions(out);
    return std::span(row_).first(channels_.size());
}

/// The outputs come into the row. Those that are parts of energies are taken out of it, the others move up.
double* Observer::write_networks(double* out, const Networks& networks, Energies& energies) {
    networks.outputs(out);
    const double* output = out;
    for (const NetworkInstance& instance : networks.instances())
        for (const uint8_t role : instance.roles()) {
            const double value = *output++;
            switch (role) {
                case DTTMM_ROLE_STRAIN_ENERGY:
                    energies.strain += value;
                    break;
                case DTTMM_ROLE_KINETIC_ENERGY:
                    energies.kinetic += value;
                    break;
                case DTTMM_ROLE_DISSIPATED_ENERGY:
                    energies.dissipated += value;
                    break;
                case DTTMM_ROLE_WORK:
                    energies.work += value;
                    break;
                default:
                    *out++ = value;
            }
        }
    return out;
}

double* Observer::write_joints(double* out, const Instant& instant) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Eigen::Matrix<double, 6, 1>& wrench = instant.joint_wrenches[j];
        const Eigen::Matrix3d axes = joints_[j].axes(instant.at);
        out = write(out, axes.transpose() * wrench.head<3>());
        out = write(out, axes.transpose() * wrench.tail<3>());
        if (joints_[j].has_coordinate()) *out++ = joints_[j].coordinate(instant.at);
    }
    return out;
}

double* Observer::write_bodies(double* out, const Instant& instant) const {
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const BodyState& at = instant.at[b];
        const Moving motion{at, instant.accelerations[b]};
        const Eigen::Vector3d origin = -(at.rotation * bodies_[b].center_of_mass);
        out = write(out, at.position + origin);
        out = write(out, motion.velocity_at(origin));
        out = write(out, motion.acceleration_at(origin));
        out = write(out, at.angular_velocity);
        const Eigen::Quaterniond q(at.rotation);
        for (double part : {q.w(), q.x(), q.y(), q.z()}) *out++ = part;
        for (const Marker& marker : bodies_[b].markers) {
            const Eigen::Vector3d arm = at.rotation * (marker.position - bodies_[b].center_of_mass);
            out = write(out, motion.acceleration_at(arm));
            out = write(out, at.position + arm);
            out = write(out, motion.velocity_at(arm));
        }
    }
    return out;
}

double Observer::kinetic_energy(const std::vector<BodyState>& at) const {
    double twice = 0;
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const Eigen::Vector3d w = at[b].rotation.transpose() * at[b].angular_velocity;
        twice += bodies_[b].mass * at[b].velocity.squaredNorm() + w.dot(bodies_[b].inertia * w);
    }
    return 0.5 * twice;
}

double Observer::gravity_work(const std::vector<BodyState>& at) const {
    double work = 0;
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const Eigen::Vector3d start = bodies_[b].position + bodies_[b].rotation * bodies_[b].center_of_mass;
        work += bodies_[b].mass * gravity_.dot(at[b].position - start);
    }
    return work;
}

}  // namespace dttmm::host
