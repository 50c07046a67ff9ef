// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/warning.h"

namespace dttmm::host {

/// The warnings of one command. Each is printed on the standard error when it is added, and kept for summary.json. An equal
/// warning is added once.
class Warnings {
public:
    Warnings() = default;
    /// Of a part of the command, as a case of a sweep: kept here, printed by the whole, which prints an equal one once.
    explicit Warnings(Warnings& whole) : whole_(&whole) {}
    /// Of one trial among many: kept here, never printed.
    enum class Silent : unsigned char { yes };
    explicit Warnings(Silent) : is_silent_(true) {}

    /// More lines than these push the first ones out of a terminal's view.
    static constexpr std::size_t kMostPrinted = 50;

    /// Prints "warning: <text>".
    void add(const std::string& code, const std::string& text) { print("warning", {code, text}); }
    void add(const std::vector<Warning>& warnings);
    /// Prints "note: <text>": the result is right, and something about it is worth knowing.
    void note(const std::string& code, const std::string& text) { print("note", {code, text}); }
    /// Prints how many more warnings than kMostPrinted there are, by code. The text ends with `where` they are to be found.
    void print_rest(const std::string& where) const;

    const std::vector<Warning>& all() const { return all_; }
    bool has(const std::string& code) const;

private:
    void print(const char* kind, const Warning& warning);

    Warnings* whole_ = nullptr;
    bool is_silent_ = false;
    std::vector<Warning> all_;
    std::set<std::pair<std::string, std::string>> seen_;
    std::map<std::string, std::size_t> unprinted_;  ///< number by code
};

}  // namespace dttmm::host
