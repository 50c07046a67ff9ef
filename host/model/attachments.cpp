// SPDX-License-Identifier: BSD-3-Clause
#include "model/attachments.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/index.h"
#include "model/names.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

std::vector<std::string> names_of(const auto& things) {
    std::vector<std::string> names;
    for (const auto& thing : things) names.push_back(thing.name);
    return names;
}

}  // namespace

Attachments::Attachments(const std::vector<Body>& bodies, const std::vector<Node>& nodes) : bodies_(bodies), nodes_(nodes) {
    for (std::size_t i = 0; i < bodies.size(); ++i)
        if (!bodies[i].name.empty()) index_.emplace(bodies[i].name, Attachment{as_int(i), -1, -1});
    for (std::size_t i = 0; i < nodes.size(); ++i) index_.emplace(nodes[i].name, Attachment{-1, -1, as_int(i)});
}

std::vector<std::string> Attachments::known_names() const {
    std::vector<std::string> known = names_of(bodies_);
    for (const Node& node : nodes_) known.push_back(node.name);
    known.emplace_back("ground");
    return known;
}

std::optional<Attachment> Attachments::read(const TableReader& table, const char* key) const {
    const TomlMember* member = table.require(key);
    return member ? read(table, member->value, key) : std::nullopt;
}

std::optional<Attachment> Attachments::read(const TableReader& table, const TomlValue& value,
                                            const std::string& what) const {
    const auto fail = [&](const std::string& message) {
        table.error(value.place, what + message);
        return std::nullopt;
    };
    if (!value.is_text()) return fail(fmt::format(" must be a text, got {}", kind_text(value.kind)));
    const std::string name = normalise_name(value.string);
    if (name == "ground") return Attachment{};
    const std::size_t dot = name.find('.');
    const auto found = index_.find(name.substr(0, dot));
    if (found == index_.end())
        return fail(fmt::format(": there is no {} {}{}", nodes_.empty() ? "body" : "body or node",
                                quote(name.substr(0, dot)), suggestion(name.substr(0, dot), known_names())));
    const Attachment& whole = found->second;
    if (dot == name.npos) return whole;
    if (whole.node >= 0) return fail(fmt::format(": {} is a node, which has no markers", quote(found->first)));
    const std::string marker_name = name.substr(dot + 1);
    const auto& markers = bodies_[as_size(whole.body)].markers;
    const auto marker = std::find_if(markers.begin(), markers.end(), [&](const Marker& m) { return m.name == marker_name; });
    if (marker == markers.end())
        return fail(fmt::format(": body {} has no marker {}{}", quote(found->first), quote(marker_name),
                                suggestion(marker_name, names_of(markers))));
    return Attachment{whole.body, as_int(marker - markers.begin()), -1};
}

bool Attachments::is_clamped(const Attachment& attachment) const {
    return attachment.node >= 0 && nodes_[as_size(attachment.node)].fixed.all();
}

bool Attachments::is_held(const Attachment& attachment, const Eigen::Vector3d& direction, bool is_moment) const {
    if (attachment.node < 0) return false;
    const auto& fixed = nodes_[as_size(attachment.node)].fixed;
    for (std::size_t d = 0; d < 3; ++d)
        if (direction(as_row(d)) != 0 && !fixed[(is_moment ? 3 : 0) + d]) return false;
    return true;
}

Eigen::Vector3d Attachments::position(const Attachment& attachment) const {
    if (attachment.node >= 0) return nodes_[as_size(attachment.node)].position;
    const Body& body = bodies_[as_size(attachment.body)];
    if (attachment.marker < 0) return body.position;
    return body.position + body.rotation * body.markers[as_size(attachment.marker)].position;
}

bool Attachments::is_off_centre(const Attachment& attachment) const {
    return attachment.body >= 0 && attachment.marker < 0 && !bodies_[as_size(attachment.body)].center_of_mass.isZero(0);
}

Eigen::Matrix3d Attachments::axes(const Attachment& attachment) const {
    if (attachment.node >= 0) return nodes_[as_size(attachment.node)].rotation;
    const Body& body = bodies_[as_size(attachment.body)];
    if (attachment.marker < 0) return body.rotation;
    return body.rotation * body.markers[as_size(attachment.marker)].axes();
}

}  // namespace dttmm::host
