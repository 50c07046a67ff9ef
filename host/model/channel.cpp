// SPDX-License-Identifier: BSD-3-Clause
#include "model/channel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "model/error.h"

namespace dttmm::host {

namespace {

/// One copy of each value, by number. A value stays where it is as long as the process runs: its models share them.
template <class Value, class Hash>
class InternTable {
public:
    /// The number of the value that `key` shows. Threads may call it together.
    template <class Key>
    uint32_t keep(const Key& key) {
        const std::lock_guard lock(mutex_);
        if (count_ > 0 && (*this)[last_] == key) return last_;  // often: neighbours differ in one text
        if (2 * (count_ + 1) > seats_.size()) double_seats();
        uint32_t& seat = seat_of(key);
        if (seat != kFree) return last_ = seat;
        const Place place(count_);
        if (place.index == 0) blocks_[place.block] = std::make_unique<Value[]>(size_t{1} << place.block);
        blocks_[place.block][place.index] = Value(key);
        return last_ = seat = count_++;
    }
    /// number: from keep(). What other threads keep meanwhile leaves all that is read here alone.
    const Value& operator[](uint32_t number) const {
        const Place place(number);
        return blocks_[place.block][place.index];
    }

private:
    /// Block b has room for 2^b values.
    struct Place {
        explicit Place(uint32_t number)
            : block(static_cast<size_t>(std::bit_width(number + 1)) - 1), index(number + 1 - (size_t{1} << block)) {}
        size_t block, index;
    };
    static constexpr uint32_t kFree = std::numeric_limits<uint32_t>::max();

    /// The seat of the number of the value that `key` shows, or the free one where it belongs: from that of its hash on the
    /// first that is free or has it. At most half of the seats are taken.
    uint32_t& seat_of(const auto& key) {
        const size_t last = seats_.size() - 1;  // a power of two less one
        size_t at = Hash{}(key)&last;
        while (seats_[at] != kFree && !((*this)[seats_[at]] == key)) at = (at + 1) & last;
        return seats_[at];
    }
    void double_seats() {
        const size_t size = std::max<size_t>(16, 2 * seats_.size());
        std::vector<uint32_t>().swap(seats_);  // before the larger list: both together would be half as much again
        seats_.resize(size, kFree);
        for (uint32_t number = 0; number < count_; ++number) {
            size_t at = Hash{}((*this)[number]) & (size - 1);
            while (seats_[at] != kFree) at = (at + 1) & (size - 1);
            seats_[at] = number;
        }
    }

    std::mutex mutex_;
    uint32_t last_ = 0;  ///< asked for
    uint32_t count_ = 0;
    std::array<std::unique_ptr<Value[]>, 32> blocks_;
    std::vector<uint32_t> seats_;  ///< numbers by the hashes of their values; four bytes each, a set of them takes forty
};

struct TextHash {
    size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
};

/// What few channels differ in; its texts are elsewhere.
struct FormKey {
    std::string_view axis, unit;
    Channel::Of of;
    bool by_default;
};

struct Form {
    Form() = default;
    explicit Form(const FormKey& key) : axis(key.axis), unit(key.unit), of(key.of), by_default(key.by_default) {}
    bool operator==(const FormKey& key) const {
        return axis == key.axis && unit == key.unit && of == key.of && by_default == key.by_default;
    }
    std::string axis, unit;
    Channel::Of of = Channel::Of::nothing;
    bool by_default = false;
};

struct FormHash {
    size_t operator()(const auto& form) const { return TextHash{}(form.axis) + 31 * TextHash{}(form.unit); }
};

using Texts = InternTable<std::string, TextHash>;

Texts& owners() {
    static Texts table;
    return table;
}

Texts& quantities() {
    static Texts table;
    return table;
}

InternTable<Form, FormHash>& forms() {
    static InternTable<Form, FormHash> table;
    return table;
}

/// Throws where a number of what `names` says needs more bits.
uint64_t checked(uint32_t number, int bits, const char* names) {
    if (number >> bits != 0)
        throw Error(ExitCode::resource_limit,
                    fmt::format("the models of this process have more than {} {}; divide them", 1U << bits, names));
    return number;
}

/// The texts that are not empty, with dots between them.
std::string with_dots(std::initializer_list<std::string_view> texts) {
    size_t size = 0;
    for (const std::string_view text : texts) size += text.size() + 1;
    std::string all;
    all.reserve(size);
    for (const std::string_view text : texts) {
        if (!all.empty() && !text.empty()) all += '.';
        all += text;
    }
    return all;
}

}  // namespace

Channel::Channel(Of of, std::string_view owner, std::string_view quantity, std::string_view axis, std::string_view unit,
                 bool by_default)
    // Masked for the compiler, which does not know that they fit
    : owner_(checked(owners().keep(owner), kTextBits, "names of elements, joints, bodies, markers and nodes") & kText),
      quantity_(checked(quantities().keep(quantity), kTextBits, "quantities of channels") & kText),
      form_(checked(forms().keep(FormKey{axis, unit, of, by_default}), kFormBits, "axes and units of channels") & kForm) {
    static_assert(sizeof(Channel) == 8);
}

Channel::Of Channel::of() const { return forms()[form_].of; }
bool Channel::by_default() const { return forms()[form_].by_default; }
const std::string& Channel::owner() const { return owners()[owner_]; }
const std::string& Channel::quantity() const { return quantities()[quantity_]; }
const std::string& Channel::axis() const { return forms()[form_].axis; }
const std::string& Channel::unit() const { return forms()[form_].unit; }

bool Channel::have_duplicates(std::span<const Channel> channels) {
    // Forms of one kind differ in unit and default only
    std::map<std::pair<Of, std::string_view>, uint64_t> kinds;
    std::map<uint32_t, uint64_t> kind_of_form;
    const auto kind_of = [&](uint32_t number) {
        const auto [known, is_new] = kind_of_form.emplace(number, 0);
        if (!is_new) return known->second;
        const Form& form = forms()[number];
        const std::pair<Of, std::string_view> kind(form.of, form.axis);
        return known->second = kinds.emplace(kind, kinds.size()).first->second;
    };
    std::vector<uint64_t> numbers;
    numbers.reserve(channels.size());
    for (const Channel& c : channels) {
        const uint64_t owner = c.owner_, quantity = c.quantity_;
        numbers.push_back(owner << (kTextBits + kFormBits) | quantity << kFormBits | kind_of(c.form_));
    }
    std::ranges::sort(numbers);
    return std::ranges::adjacent_find(numbers) != numbers.end();
}

std::string Channel::without_axis() const { return with_dots({owner(), quantity()}); }

std::string Channel::name() const { return with_dots({owner(), quantity(), axis()}); }

std::string Channel::name_in_owner() const { return with_dots({quantity(), axis()}); }

}  // namespace dttmm::host
