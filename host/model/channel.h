// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// One recorded quantity: a column of history.csv and a dataset of history.h5. Its name is made of what it is; nobody takes
/// a name apart. A large machine has a hundred thousand, so each text stands in memory once, for all of them and for good.
class Channel {
public:
    /// What it belongs to.
    enum class Of : unsigned char { nothing, element, joint, body, marker, node, energy };

    /// quantity: may hold dots; axis: may be empty; unit: of the SI value, "1" for a pure number; by_default: recorded when
    /// the user asks for nothing in particular. Throws Error(resource_limit) where the models of this process have more than
    /// 2^24 owners or quantities, or 2^16 combinations of axis, unit, kind of owner and default: none is ever forgotten.
    Channel(Of of, std::string_view owner, std::string_view quantity, std::string_view axis, std::string_view unit,
            bool by_default = true);
    /// It belongs to nothing and has a name only, as "time" has.
    Channel(std::string_view name, std::string_view unit) : Channel(Of::nothing, {}, name, {}, unit) {}

    Of of() const;
    bool by_default() const;
    // These texts stay where they are as long as the process runs; equal owners stand at one address
    const std::string& owner() const;
    const std::string& quantity() const;
    const std::string& axis() const;
    const std::string& unit() const;

    /// "bolt1.force.x": owner, quantity, axis.
    std::string name() const;
    /// Quantity and axis.
    std::string name_in_owner() const;
    /// Owner and quantity: what its axes have in common.
    std::string without_axis() const;
    /// Whether two channels have the same kind of owner, owner, quantity and axis.
    static bool have_duplicates(std::span<const Channel> channels);

private:
    static constexpr int kTextBits = 24, kFormBits = 16;
    static constexpr uint64_t kText = (1U << kTextBits) - 1, kForm = (1U << kFormBits) - 1;
    // Numbers of what is kept once; form: axis, unit and the rest
    uint64_t owner_ : kTextBits, quantity_ : kTextBits, form_ : kFormBits;
};

}  // namespace dttmm::host
