// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace dttmm::host {

/// A variable of a MAT file, or a field of a struct.
struct MatArray {
    enum class Of : unsigned char { numbers, text, other };
    Of of = Of::other;
    std::string name;                ///< "acc"; of a struct "run.acc", of one of several "run(2).acc"
    std::string kind;                ///< "double", "char", "cell", "sparse matrix", "object", ...
    std::vector<std::size_t> sizes;  ///< of each dimension; two at least
    std::vector<double> real;        ///< of numbers: the first subscript runs fastest
    std::vector<double> imaginary;   ///< of complex numbers
    std::string text;                ///< of a text: UTF-8

    std::size_t count() const;
    bool is_complex() const { return !imaginary.empty(); }
    /// Has one row or one column.
    bool is_vector() const;
    std::string sizes_text() const;  ///< "7x3"
};

/// All variables of a MAT file of level 5, compressed or not, or 7.3; structs as their fields. Of cells, sparse matrices,
/// objects of MATLAB classes and function handles only the name and kind are given. Throws Error(input_output) for another
/// file and for one that is cut off or damaged. Sizes that the file cannot hold are refused before memory is taken.
/// Not while another thread uses HDF5.
/// matio is not used here: version 1.5.23 crashes on some damaged structs, does not return, or takes gigabytes.
std::vector<MatArray> read_mat_arrays(const std::filesystem::path& file);

/// UTF-8 of UTF-16; U+FFFD for half of a pair.
std::string utf8_of_utf16(std::span<const std::uint16_t> units);

/// More numbers than this, 4 GiB, would not fit into the memory of a desk.
inline constexpr std::uintmax_t kMostMatNumbers = std::uintmax_t{1} << 29;
/// Structs in structs, and cells in cells.
inline constexpr int kDeepestMat = 32;
/// Deflate makes at most this many bytes of one.
inline constexpr std::uintmax_t kMostInflation = 1032;

}  // namespace dttmm::host
