// SPDX-License-Identifier: BSD-3-Clause
#include "record/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <ostream>
#include <streambuf>
#include <string>
#include <utility>

#include "model/index.h"
#include "record/file.h"

namespace dttmm::host {

namespace {

std::filesystem::path with_part(std::filesystem::path path) { return path += ".part"; }

/// A rename survives a power cut once its folder is on the disk. Not every file system can sync a folder: best effort.
void sync_folder_of(const std::filesystem::path& path) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    ::fsync(descriptor);
    ::close(descriptor);
}

/// A stream into a file. What the file throws passes through the stream.
class FileStream : private std::streambuf, public std::ostream {
public:
    explicit FileStream(File& file) : std::ostream(this), file_(file) { exceptions(std::ios::badbit); }

private:
    std::streamsize xsputn(const char* text, std::streamsize size) override {
        waiting_.append(text, as_size(size));
        if (waiting_.size() >= kMostWaiting) sync();
        return size;
    }
    int overflow(int character) override {
        waiting_ += static_cast<char>(character);
        return character;
    }
    int sync() override {
        file_.write(waiting_);
        waiting_.clear();
        return 0;
    }

    static constexpr std::size_t kMostWaiting = 64 * 1024;  // bytes: few calls of the system, little memory
    File& file_;
    std::string waiting_;
};

}  // namespace

PartFile::PartFile(std::filesystem::path final_path)
    : final_path_(std::move(final_path)), part_path_(with_part(final_path_)) {}

PartFile::~PartFile() {
    if (!published_) ::unlink(part_path_.c_str());
}

void PartFile::publish() {
    File file = File::open(part_path_);
    file.sync();
    file.close();
    if (std::rename(part_path_.c_str(), final_path_.c_str()) != 0)
        throw file_error(part_path_, "cannot rename to " + final_path_.filename().string(), errno);
    published_ = true;
    sync_folder_of(final_path_);
}

void write_atomically(const std::filesystem::path& path, std::string_view text) {
    write_atomically(path, [&](std::ostream& stream) { stream << text; });
}

void write_atomically(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write) {
    PartFile part(path);
    File file = File::create(part.path());
    FileStream stream(file);
    write(stream);
    stream.flush();
    file.close();
    part.publish();
}

}  // namespace dttmm::host
