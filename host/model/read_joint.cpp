// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_joint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "model/index.h"
#include "model/read_position.h"
#include "model/read_rotation.h"
#include "model/read_signal.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr double kCoincident = 1e-6;                // [m]
constexpr double kRightAngle = 1e-6;                // [rad]
constexpr double kSuspectMassRatio = 1e6;           // ODE's joints give way beyond
constexpr double kFarthestStop = 175 * M_PI / 180;  // of a stop: the angle jumps at 180 degrees
constexpr double kLeastPlay = 1e-9;                 // between two stops [rad, m]
constexpr double kLargestMassRatio = 1e12;

bool has_axis(JointType type) { return type != JointType::ball && type != JointType::fixed; }
bool needs_anchor(JointType type) { return type != JointType::slider && type != JointType::fixed; }
bool has_limits(JointType type) { return type == JointType::hinge || type == JointType::slider; }

std::string point_text(const Eigen::Vector3d& p) { return fmt::format("({:.9g}, {:.9g}, {:.9g}) m", p.x(), p.y(), p.z()); }

std::optional<JointType> read_type(const TableReader& table) {
    const auto type = table.text("type");
    if (!type) return std::nullopt;
    const std::vector<std::string> types = words_of(table.key("type"));
    const auto found = std::find(types.begin(), types.end(), *type);
    if (found != types.end()) return static_cast<JointType>(found - types.begin());
    const auto nearest = find_nearest(*type, types);
    table.error(table.find("type")->value.place,
                fmt::format("type must be one of: {}; got {}{}", listed(types), quote(*type),
                            nearest ? fmt::format("; did you mean {}?", quote(*nearest)) : ""));
    return std::nullopt;
}

using JointEnds = std::array<Attachment, 2>;

/// The two places of `between`.
std::optional<JointEnds> read_ends(const TableReader& table, const Attachments& attachments) {
    const TomlMember* between = table.require("between");
    if (!between) return std::nullopt;
    const TomlValue& value = between->value;
    if (!value.is_array() || value.items.size() != 2) {
        const std::string got = value.is_array() ? std::to_string(value.items.size()) : std::string(kind_text(value.kind));
        table.error(
            value.place,
            fmt::format("between wants two names, e.g. [\"crank\", \"rod\"] or [\"ground\", \"crank.pin\"]; got {}", got));
        return std::nullopt;
    }
    const auto first = attachments.read(table, value.items[0], "between");
    const auto second = attachments.read(table, value.items[1], "between");
    if (!first || !second) return std::nullopt;
    const JointEnds ends{*first, *second};
    for (std::size_t i : {0u, 1u})
        if (ends[i].node >= 0) {
            table.error(value.items[i].place, fmt::format("between: {} is a node; a joint joins bodies or a body and the "
                                                          "ground, an element holds a node",
                                                          quote(value.items[i].string)));
            return std::nullopt;
        }
    if (first->body != second->body) return ends;
    table.error(value.items[1].place, first->body < 0 ? "both ends are on the ground" : "both ends are on the same body");
    return std::nullopt;
}

/// The point `anchor` gives: three lengths, or the name of a place.
std::optional<Eigen::Vector3d> read_point(const TableReader& table, const TomlMember& member,
                                          const Attachments& attachments) {
    if (!member.value.is_text() || member.value.string.starts_with("=")) return table.vector(member.key);
    const auto at = attachments.read(table, member.value, member.key);
    if (!at) return std::nullopt;
    if (at->body >= 0) return attachments.position(*at);
    if (at->node >= 0)
        table.error(member.value.place, "anchor: a node is no point of a body; give three lengths, or \"body.marker\"");
    else
        table.error(member.value.place,
                    "anchor: the ground has no point of its own; give three lengths, or \"body.marker\"");
    return std::nullopt;
}

/// Where the joint is: at the markers of its ends and at `anchor`, which must be one point.
std::optional<Eigen::Vector3d> read_anchor(const TableReader& table, const Attachments& attachments, const JointEnds& ends,
                                           JointType type) {
    const std::vector<TomlValue>& names = table.find("between")->value.items;
    std::optional<Eigen::Vector3d> anchor;
    std::string source;
    if (const TomlMember* member = table.find("anchor")) {
        anchor = read_point(table, *member, attachments);
        source = "anchor";
        if (!anchor) return std::nullopt;
    }
    for (std::size_t i = 0; i < 2; ++i) {
        if (ends[i].marker < 0) continue;
        const Eigen::Vector3d position = attachments.position(ends[i]);
        if (anchor && (position - *anchor).norm() > kCoincident) {
            table.error(
                names[i].place,
                fmt::format("a joint has one anchor, to within {} m at the start, but {} is at {} and {} at {}; move "
                            "a body, or name the body without marker",
                            kCoincident, source, point_text(*anchor), quote(names[i].string), point_text(position)));
            return std::nullopt;
        }
        if (!anchor) {
            anchor = position;
            source = quote(names[i].string);
        }
    }
    if (anchor) return anchor;
    if (!needs_anchor(type)) return attachments.position({ends[1].body < 0 ? ends[0].body : ends[1].body, -1});
    table.error(table.place(), fmt::format("missing key \"anchor\": a {} joint is at a point; give three lengths, or name a "
                                           "marker in between, e.g. \"body.marker\"",
                                           joint_type_name(type)));
    return std::nullopt;
}

/// Reports a key that a joint of this type has no use for.
void refuse(const TableReader& table, const char* key, JointType type, const char* owners) {
    if (const TomlMember* member = table.find(key))
        table.error(member->place,
                    fmt::format("a {} joint has no {}; it belongs to {}", joint_type_name(type), key, owners));
}

/// Whether `joint` has the axes its type needs.
bool read_axes(const TableReader& table, Joint& joint) {
    const bool is_universal = joint.type == JointType::universal;
    if (!is_universal) refuse(table, "axis2", joint.type, "a universal joint");
    if (!has_axis(joint.type)) {
        refuse(table, "axis", joint.type, "a hinge, slider or universal joint");
        return true;
    }
    const auto axis = read_direction(table, "axis");
    if (axis) joint.axis = *axis;
    if (!is_universal) return axis.has_value();
    const auto axis2 = read_direction(table, "axis2");
    if (!axis || !axis2) return false;
    const double cosine = axis->dot(*axis2);
    if (std::abs(cosine) > kRightAngle) {
        table.error(table.find("axis2")->value.place,
                    fmt::format("axis2 must be at right angles to axis, got {:.6g} degrees",
                                std::atan2(axis->cross(*axis2).norm(), cosine) * 180 / M_PI));
        return false;
    }
    joint.axis2 = (*axis2 - cosine * *axis).normalized();
    return true;
}

/// Whether the stops of the joint, if it has any, are right.
bool read_limits(const TableReader& table, Joint& joint) {
    const TomlMember* member = table.find("limits");
    if (!member) return true;
    if (!has_limits(joint.type)) {
        refuse(table, "limits", joint.type, "a hinge or slider");
        return false;
    }
    const bool is_hinge = joint.type == JointType::hinge;
    const char* unit = is_hinge ? "rad" : "m";
    const double most = is_hinge ? kFarthestStop : kFarthest;
    const auto limits = read_numbers(table.context(), member->value, table.what("limits"), unit, 2);
    if (!limits) return false;
    const double low = (*limits)[0], high = (*limits)[1];
    const auto fail = [&](const char* rule) {
        table.error(member->value.place, fmt::format("limits = [low, high] {}, got [{}, {}] {}", rule, number_text(low),
                                                     number_text(high), unit));
        return false;
    };
    if (!(low < high)) return fail("must have low < high");
    if (!(high - low >= kLeastPlay)) return fail("must lie 1e-9 apart at least (a fixed joint has no play)");
    if (!(low <= 0 && high >= 0)) return fail("must have 0 between them, which is where the joint starts");
    if (!(-most < low && high < most))
        return fail(is_hinge ? "of a hinge must lie within -175 to 175 degrees" : "must lie within 1e6 m");
    joint.limits = {low, high};
    return true;
}

/// Whether the motor of the joint, if it has one, is right: `angle` of a hinge, `travel` of a slider.
bool read_drive(const TableReader& table, Joint& joint) {
    const bool is_hinge = joint.type == JointType::hinge;
    if (!is_hinge) refuse(table, "angle", joint.type, "a hinge");
    if (joint.type != JointType::slider) refuse(table, "travel", joint.type, "a slider");
    if (!has_limits(joint.type)) return true;
    const TomlMember* member = table.find(is_hinge ? "angle" : "travel");
    if (!member) return true;
    if (joint.limits) {
        table.error(
            member->place,
            fmt::format("{} and limits exclude each other: a motor passes no stops; leave one of them out", member->key));
        return false;
    }
    joint.drive = read_signal(table.context(), member->value, table.what(member->key), table.key(member->key).unit);
    joint.drive_place = table.context().diagnostics.place_text(member->value.place);
    return joint.drive.has_value();
}

class JointsReader {
public:
    JointsReader(const Attachments& attachments, const std::vector<Body>& bodies,
                 const std::vector<const NameRegistry*>& others)
        : attachments_(attachments), bodies_(bodies), others_(others) {}

    void read(const ReadContext& context, const TomlValue& entry, std::size_t index) {
        const TableReader table(context, entry, entry_label("joint", entry, index), key_table("joint"),
                                entry_note("joint", index));
        if (!table.is_valid()) return;
        Joint joint;
        joint.name = names_.add_from(table);
        joint.place = context.diagnostics.place_text(table.place());
        check_name(table, joint.name, others_);
        const auto type = read_type(table);
        const auto ends = read_ends(table, attachments_);
        if (ends) {
            joint.first = (*ends)[0].body;
            joint.second = (*ends)[1].body;
            check_masses(table, joint);
        }
        if (!type) return;
        joint.type = *type;
        const bool has_axes = read_axes(table, joint), has_stops = read_limits(table, joint),
                   has_drive = read_drive(table, joint);
        const auto anchor = ends ? read_anchor(table, attachments_, *ends, *type) : std::nullopt;
        if (!anchor || !has_axes || !has_stops || !has_drive) return;
        joint.anchor = *anchor;
        warn_twin(table, joint);
        joints_.push_back(std::move(joint));
    }

    std::vector<Joint> take() { return std::move(joints_); }

private:
    void check_masses(const TableReader& table, const Joint& joint) const {
        if (joint.first < 0 || joint.second < 0) return;
        const Body& first = bodies_[as_size(joint.first)];
        const Body& second = bodies_[as_size(joint.second)];
        const auto [light, heavy] = std::minmax(first.mass, second.mass);
        if (!(light > 0) || heavy <= kSuspectMassRatio * light) return;  // a mass of zero is reported with its body
        const Place place = table.find("between")->value.place;
        const std::string text = fmt::format("the masses of {} ({:.4g} kg) and {} ({:.4g} kg) differ by a factor of {:.3g}",
                                             quote(first.name), first.mass, quote(second.name), second.mass, heavy / light);
        if (heavy > kLargestMassRatio * light)
            table.error(place,
                        fmt::format("{}; at most {:g} is allowed, as the joint would give way", text, kLargestMassRatio));
        else
            table.warning(place, "mass-ratio", text + "; digits are lost: see that the energy balance closes");
    }

    void warn_twin(const TableReader& table, const Joint& joint) {
        const auto list = [](const Eigen::Vector3d& v) { return std::array<double, 3>{v.x(), v.y(), v.z()}; };
        const auto [first, second] = std::minmax(joint.first, joint.second);
        const auto [twin, is_new] = seen_.emplace(
            std::tuple(joint.type, first, second, list(joint.anchor), list(joint.axis), list(joint.axis2)), joint.name);
        if (!is_new)
            table.warning(table.place(), "duplicate-joint",
                          fmt::format("identical to joint {}: same bodies, type, anchor and axes", quote(twin->second)));
    }

    const Attachments& attachments_;
    const std::vector<Body>& bodies_;
    const std::vector<const NameRegistry*>& others_;
    NameRegistry names_{"joint"};
    std::map<std::tuple<JointType, int, int, std::array<double, 3>, std::array<double, 3>, std::array<double, 3>>,
             std::string>
        seen_;
    std::vector<Joint> joints_;
};

}  // namespace

const std::string& joint_type_name(JointType type) {
    static const std::vector<std::string> names =
        words_of(*find_key(key_table("joint"), "type"));  // in the order of JointType
    return names[static_cast<size_t>(type)];
}

std::vector<Joint> read_joints(const TableReader& file, const Attachments& attachments, const std::vector<Body>& bodies,
                               const std::vector<const NameRegistry*>& others) {
    JointsReader reader(attachments, bodies, others);
    std::size_t index = 0;
    for (const TomlValue& entry : read_entries(file, "joint")) reader.read(file.context(), entry, index++);
    return reader.take();
}

}  // namespace dttmm::host
