// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/model.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// Finds what "ground", "body", "body.marker" and "node" mean.
class Attachments {
public:
    Attachments(const std::vector<Body>& bodies, const std::vector<Node>& nodes);

    /// The place that `key` of a table names. An unknown name is reported with the nearest; returns nothing then.
    std::optional<Attachment> read(const TableReader& table, const char* key) const;

    /// The same for a value of the table that messages call `what`; anything but a text is reported too.
    std::optional<Attachment> read(const TableReader& table, const TomlValue& value, const std::string& what) const;

    /// Whether there is a body or node of that name.
    bool has(const std::string& name) const { return index_.contains(name); }

    /// Whether it is a node that is fixed in all directions.
    bool is_clamped(const Attachment& attachment) const;
    /// Whether it is a node that is fixed in every direction in which a force, or a moment, along `direction` pushes.
    bool is_held(const Attachment& attachment, const Eigen::Vector3d& direction, bool is_moment) const;

    /// Where it is in the world at the start [m]; not for the ground.
    Eigen::Vector3d position(const Attachment& attachment) const;

    /// Whether it is a body by its name alone, whose origin is not its centre of mass.
    bool is_off_centre(const Attachment& attachment) const;

    /// Its axes in the world at the start; not for the ground.
    Eigen::Matrix3d axes(const Attachment& attachment) const;

private:
    std::vector<std::string> known_names() const;

    const std::vector<Body>& bodies_;
    const std::vector<Node>& nodes_;
    std::map<std::string, Attachment, std::less<>> index_;
};

}  // namespace dttmm::host
