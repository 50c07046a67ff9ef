// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string_view>

namespace dttmm::host {

/// The name `<final name>.part` under which a file is written until it is whole. Whoever sees the final name sees a whole
/// file; without publish() the part is removed with its owner.
class PartFile {
public:
    explicit PartFile(std::filesystem::path final_path);
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;
    ~PartFile();

    /// Where to write.
    const std::filesystem::path& path() const { return part_path_; }
    const std::filesystem::path& final_path() const { return final_path_; }

    /// Brings the closed part to the disk and gives it the final name, in place of an older file. Throws
    /// Error(input_output).
    void publish();

private:
    std::filesystem::path final_path_;
    std::filesystem::path part_path_;
    bool published_ = false;
};

/// The file at `path` is `text` or what it was before, never a piece. Throws Error(input_output); then no part is left.
void write_atomically(const std::filesystem::path& path, std::string_view text);
/// The same for a text that is too large to stand in memory: `write` puts it into the stream piece by piece.
void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace dttmm::host
