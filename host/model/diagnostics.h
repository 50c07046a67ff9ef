// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "model/error.h"
#include "model/warning.h"

namespace dttmm::host {

/// A place in the model file, both counted from 1, columns in characters. Line 0 is a command-line option, numbered by
/// Diagnostics::option_place.
struct Place {
    int line = 0;
    int column = 0;
    int file = 0;  ///< 0: the model file; else as Diagnostics::add_file numbered it
    int copy = 0;  ///< of what a pattern makes: the number of the copy, counted through the model; 0: as written
    auto operator<=>(const Place&) const = default;

    bool is_same_text(const Place& other) const {
        return line == other.line && column == other.column && file == other.file;
    }
};

/// The model cannot be run as written: every fault found, one per line, in the order of the file.
class ModelError : public Error {
public:
    explicit ModelError(const std::string& text) : Error(ExitCode::model_invalid, text) {}
};

/// Collects what is wrong with one model file, so that all of it can be told in one go.
class Diagnostics {
public:
    static constexpr int kMostShown = 50;

    explicit Diagnostics(std::string file) : files_{std::move(file)} {}

    /// A further file, for places in it: its number.
    int add_file(std::string file);

    void error(Place place, std::string text) { errors_.push_back({place, {}, std::move(text)}); }
    void warning(Place place, std::string code, std::string text) {
        warnings_.push_back({place, std::move(code), std::move(text)});
    }

    /// A place that reads `option`, e.g. "--step", instead of a line of the file.
    Place option_place(std::string option);

    /// "file:line:column", or the option.
    std::string place_text(Place place) const;

    /// "line 12", "line 12 of bolts.toml" of a further file, or the option: the other place a message speaks of.
    std::string line_text(Place place) const;

    bool has_errors() const { return !errors_.empty(); }

    /// Throws ModelError if there was an error; at most kMostShown are spelt out. Of those in copies of the same text the
    /// first copy's are spelt out, and the other copies are counted.
    void throw_if_errors() const;

    /// The warnings in the order of the file, each text with its place; of copies as for errors.
    std::vector<Warning> warnings() const;

private:
    struct Diagnostic {
        Place place;
        std::string code;  ///< of a warning
        std::string text;
    };
    std::vector<Warning> in_order(std::vector<Diagnostic> diagnostics) const;

    std::vector<std::string> files_, options_;
    std::vector<Diagnostic> errors_, warnings_;
};

}  // namespace dttmm::host
