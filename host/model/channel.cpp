// SPDX-License-Identifier: BSD-3-Clause
#include "model/channel.h"

#include <mutex>
#include <set>
#include <utility>

namespace dttmm::host {

namespace {

/// The one copy of `value` of this process. Models of one process share their names, so it is never freed.
template <class Value>
const Value* keep(Value value) {
    static std::mutex mutex;
    static std::set<Value> kept;
    const std::lock_guard lock(mutex);
    return &*kept.insert(std::move(value)).first;
}

}  // namespace

Channel::Channel(Of of, std::string_view owner, std::string_view quantity, std::string_view axis, std::string_view unit,
                 bool by_default)
    : owner_(keep(std::string(owner))),
      quantity_(keep(std::string(quantity))),
      axis_(keep(Axis{std::string(axis), std::string(unit), of, by_default})) {}

std::string Channel::without_axis() const { return owner().empty() ? quantity() : owner() + '.' + quantity(); }

std::string Channel::name() const { return axis().empty() ? without_axis() : without_axis() + '.' + axis(); }

std::string Channel::name_in_owner() const { return axis().empty() ? quantity() : quantity() + '.' + axis(); }

}  // namespace dttmm::host
