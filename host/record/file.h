// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "model/error.h"

namespace dttmm::host {

/// Error(input_output) with the text "<path>: <fault>: <reason>; <cure>", reason and cure from `error_number`, an errno.
Error file_error(const std::filesystem::path& path, std::string_view fault, int error_number);

/// A file open for writing; closed with its owner, not inherited by other programs, never reached through a link.
class File {
public:
    /// Creates the file, or empties the one that is there. Throws Error(input_output).
    static File create(const std::filesystem::path& path);
    /// Creates the file, or opens the one that is there as it stands, at its start. Throws Error(input_output).
    static File open(const std::filesystem::path& path);

    File(File&& other) noexcept;
    File& operator=(File&&) = delete;
    ~File();

    /// Appends `text`; goes on after interruptions and short writes. Returns how many bytes reached the file: fewer than
    /// asked for is a failure, and errno says which.
    std::size_t write_some(std::string_view text) noexcept;
    /// The same, but a failure is thrown: Error(input_output).
    void write(std::string_view text);

    /// Cuts the file to `size` bytes; what is written next starts there. Throws Error(input_output).
    void truncate(std::uintmax_t size);
    /// Waits until the disk has it. Throws Error(input_output).
    void sync();
    /// Throws Error(input_output): some file systems report a failed write only now. The file is closed either way.
    void close();

    int descriptor() const { return descriptor_; }
    const std::filesystem::path& path() const { return path_; }

private:
    File(std::filesystem::path path, int flags);

    std::filesystem::path path_;
    int descriptor_ = -1;
};

}  // namespace dttmm::host
