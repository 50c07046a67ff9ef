// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "record/column.h"

namespace dttmm::host {

/// Name and text of what is noted on the file as a whole: title, version, the text of the model. The texts are the
/// caller's.
using Attributes = std::vector<std::pair<std::string, const char*>>;

/// history.h5: one dataset of doubles per channel, named as the channel (no groups), its unit in the attribute "unit". A run
/// to a tolerance has a second one for every channel but the time, `<channel>.error`: a bound estimated for the error of the
/// values up to and including that row.
/// All texts are UTF-8 of variable length. Written as history.h5.part, up to 1024 rows at a time, and published under the
/// final name once whole. Nothing is allocated by us per row. May be used from several threads, each with its own writer:
/// HDF5 itself is not made for that, so its calls take turns.
class Hdf5Writer {
public:
    /// Creates `<path>.part`. Throws Error(input_output).
    Hdf5Writer(const std::filesystem::path& path, const std::vector<Column>& columns, const Attributes& attributes);
    /// Of the library: "1.10.8".
    static std::string version();
    /// Removes the part unless it was published.
    ~Hdf5Writer();

    /// values: one per column. Throws Error(input_output).
    void write_row(std::span<const double> values);
    /// Writes the rest, closes, brings the file to the disk and gives it its final name. Throws Error(input_output).
    void publish();

private:
    class Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace dttmm::host
