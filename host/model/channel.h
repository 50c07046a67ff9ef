// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace dttmm::host {

/// One recorded quantity: a column of history.csv and a dataset of history.h5. Its name is made of what it is; nobody takes
/// a name apart. A large machine has a hundred thousand, so each text stands in memory once, for all of them and for good.
class Channel {
public:
    /// What it belongs to.
    enum class Of : unsigned char { nothing, element, joint, body, marker, node, energy };

    /// quantity: may hold dots; axis: may be empty; unit: of the SI value, "1" for a pure number; by_default: recorded when
    /// the user asks for nothing in particular.
    Channel(Of of, std::string_view owner, std::string_view quantity, std::string_view axis, std::string_view unit,
            bool by_default = true);
    /// It belongs to nothing and has a name only, as "time" has.
    Channel(std::string_view name, std::string_view unit) : Channel(Of::nothing, {}, name, {}, unit) {}

    Of of() const { return axis_->of; }
    bool by_default() const { return axis_->by_default; }
    const std::string& owner() const { return *owner_; }
    const std::string& quantity() const { return *quantity_; }
    const std::string& axis() const { return axis_->name; }
    const std::string& unit() const { return axis_->unit; }

    /// "bolt1.force.x": owner, quantity, axis.
    std::string name() const;
    /// Quantity and axis.
    std::string name_in_owner() const;
    /// Owner and quantity: what its axes have in common.
    std::string without_axis() const;

private:
    /// What few channels differ in.
    struct Axis {
        std::string name, unit;
        Of of;
        bool by_default;
        auto operator<=>(const Axis&) const = default;
    };

    const std::string *owner_, *quantity_;
    const Axis* axis_;
};

}  // namespace dttmm::host
