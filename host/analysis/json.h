// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

/// The members of a JSON object in the order written. A member is found in constant time: nlohmann::ordered_map searches
/// from the front, so that building or reading an object of n members takes n^2/2 comparisons.
template <class Key, class T, class IgnoredLess = std::less<Key>, class Allocator = std::allocator<std::pair<Key, T>>>
class OrderedMembers : public std::vector<std::pair<Key, T>> {
    using Container = std::vector<std::pair<Key, T>>;

public:
    using key_type = Key;
    using mapped_type = T;
    using key_compare = std::equal_to<>;
    using typename Container::const_iterator, typename Container::iterator, typename Container::size_type,
        typename Container::value_type;

    OrderedMembers() = default;
    template <class It>
    OrderedMembers(It first, It last) {
        for (; first != last; ++first) emplace(first->first, T(first->second));
    }
    OrderedMembers(std::initializer_list<value_type> members) : OrderedMembers(members.begin(), members.end()) {}

    template <class K>
    std::pair<iterator, bool> emplace(K&& key, T&& value) {
        const size_type found = position(key);
        if (found < this->size()) return {at_position(found), false};
        if (this->empty()) this->reserve(kUsual);
        this->emplace_back(Key(std::forward<K>(key)), std::move(value));
        if (this->size() > kFewest) note_last();
        return {std::prev(this->end()), true};
    }
    std::pair<iterator, bool> insert(const value_type& member) { return emplace(member.first, T(member.second)); }
    template <class It>
    void insert(It first, It last) {
        for (; first != last; ++first) insert(*first);
    }
    template <class K>
    T& operator[](K&& key) {
        return emplace(std::forward<K>(key), T{}).first->second;
    }
    template <class K>
    iterator find(const K& key) {
        return at_position(position(key));
    }
    template <class K>
    const_iterator find(const K& key) const {
        return this->begin() + as_row(position(key));
    }
    template <class K>
    size_type count(const K& key) const {
        return position(key) < this->size();
    }
    template <class K>
    const T& at(const K& key) const {
        const size_type found = position(key);
        if (found == this->size()) throw std::out_of_range("key not found");
        return member(found).second;
    }
    /// The container is not constant, so neither is what it has.
    template <class K>
    T& at(const K& key) {
        return const_cast<T&>(std::as_const(*this).at(key));
    }
    iterator erase(iterator member) {
        slots_.clear();
        return Container::erase(member);
    }
    iterator erase(iterator first, iterator last) {
        slots_.clear();
        return Container::erase(first, last);
    }
    template <class K>
    size_type erase(const K& key) {
        const size_type found = position(key);
        if (found == this->size()) return 0;
        erase(at_position(found));
        return 1;
    }
    void clear() {
        slots_.clear();
        Container::clear();
    }

private:
    /// Up to so many members are searched from the front: most objects hold a handful, and need no table.
    static constexpr size_type kFewest = 16;

    /// Room at first: peak, time and final value are by far the most of a summary.
    static constexpr size_type kUsual = 3;

    const value_type& member(size_type i) const { return this->data()[i]; }
    iterator at_position(size_type position) { return this->begin() + as_row(position); }

    /// Of the member called `key`; size() if there is none.
    template <class K>
    size_type position(const K& key) const {
        const std::string_view name(key);
        if (this->size() <= kFewest) {
            for (size_type i = 0; i < this->size(); ++i)
                if (member(i).first == name) return i;
            return this->size();
        }
        if (slots_.empty()) rebuild();
        for (size_type slot = first_slot(name);; slot = (slot + 1) % slots_.size()) {
            if (slots_[slot] == 0) return this->size();
            if (member(slots_[slot] - 1).first == name) return slots_[slot] - 1;
        }
    }
    size_type first_slot(std::string_view name) const { return std::hash<std::string_view>{}(name) % slots_.size(); }

    /// Enters the member added last. At most half of the slots are taken, so that a search meets a free one soon.
    void note_last() {
        if (2 * this->size() > slots_.size())
            rebuild();
        else
            note(this->size() - 1);
    }
    void note(size_type index) const {
        size_type slot = first_slot(member(index).first);
        while (slots_[slot] != 0) slot = (slot + 1) % slots_.size();
        slots_[slot] = as_whole<std::uint32_t>(index + 1);
    }
    void rebuild() const {
        slots_.assign(4 * this->size(), 0);
        for (size_type i = 0; i < this->size(); ++i) note(i);
    }

    /// 1 + position of a member, or 0; empty: not built. The first look at many members builds it, so mutable.
    mutable std::vector<std::uint32_t> slots_;
};

/// Members stay in the order written.
using Json = nlohmann::basic_json<OrderedMembers>;

/// For a person: indented, with a line feed at the end; what is not UTF-8 is replaced.
std::string to_text(const Json& json);

class JsonOutput;

/// Writes an object member by member in the form of write_json(), for one that is too large to stand in memory. Nothing is
/// complete before finish().
class JsonWriter {
public:
    explicit JsonWriter(std::ostream& stream);
    ~JsonWriter();

    void member(std::string_view name, const Json& value);
    /// A text too large to be copied.
    void text(std::string_view name, std::string_view value);
    /// Members that `write` gives, as an object.
    template <class Write>
    void object(std::string_view name, const Write& write) {
        begin_member(name);
        open('{');
        write();
        close('}');
    }
    /// value_of(item) of every item, as an array.
    template <class Items, class ValueOf>
    void array(std::string_view name, const Items& items, const ValueOf& value_of) {
        begin_member(name);
        open('[');
        for (const auto& item : items) {
            begin_line();
            dump(value_of(item));
        }
        close(']');
    }
    /// The last call.
    void finish();

private:
    void open(char bracket);
    void close(char bracket);
    void begin_line();
    void begin_member(std::string_view name);
    void start_line();
    void dump(const Json& value);

    std::unique_ptr<JsonOutput> output_;
    unsigned depth_ = 0;
    bool is_empty_ = true;  ///< the innermost open object or array, so far
};

/// Writes `json` and a line feed, indented by two. What is not UTF-8 becomes a replacement character.
void write_json(std::ostream& stream, const Json& json);
/// The same into a file. Throws Error(input_output) as write_atomically does.
void write_json(const std::filesystem::path& path, const Json& json);
void write_json(const std::filesystem::path& path, const std::function<void(JsonWriter&)>& write_members);

}  // namespace dttmm::host
