// SPDX-License-Identifier: BSD-3-Clause
#include "record/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "model/index.h"

namespace dttmm::host {

namespace {

std::string_view cure_for(int error_number) {
    switch (error_number) {
        case ENOSPC:
        case EDQUOT:
            return "free some space or choose another folder with -o";
        case EFBIG:
            return "record fewer channels or rows, or raise the limit on the size of a file (ulimit -f)";
        case EACCES:
        case EPERM:
        case EROFS:
            return "choose a folder you may write to with -o";
        case EMFILE:
        case ENFILE:
            return "run fewer cases at once or raise the limit on open files (ulimit -n)";
        case ELOOP:
            return "remove the symbolic link or choose another folder with -o";
        case ENOENT:
            return "check the path, or choose another folder with -o";
        default:
            return "check the disk or choose another folder with -o";
    }
}

}  // namespace

Error file_error(const std::filesystem::path& path, std::string_view fault, int error_number) {
    return Error(ExitCode::input_output, fmt::format("{}: {}: {}; {}", path.string(), fault,
                                                     std::generic_category().message(error_number), cure_for(error_number)));
}

File::File(std::filesystem::path path, int flags) : path_(std::move(path)) {
    do descriptor_ = ::open(path_.c_str(), flags | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    while (descriptor_ < 0 && errno == EINTR);
    if (descriptor_ < 0) throw file_error(path_, "cannot open for writing", errno);
}

File File::create(const std::filesystem::path& path) { return File(path, O_WRONLY | O_TRUNC); }

File File::open(const std::filesystem::path& path) { return File(path, O_RDWR); }

File::File(File&& other) noexcept : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File::~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

std::size_t File::write_some(std::string_view text) noexcept {
    std::size_t written = 0;
    while (written < text.size()) {
        const ssize_t count = ::write(descriptor_, text.data() + written, text.size() - written);
        if (count > 0) {
            written += as_size(count);
        } else if (count == 0) {  // no progress and no reason: do not try for ever
            errno = EIO;
            break;
        } else if (errno != EINTR) {
            break;
        }
    }
    return written;
}

void File::write(std::string_view text) {
    if (write_some(text) < text.size()) throw file_error(path_, "cannot write", errno);
}

void File::truncate(std::uintmax_t size) {
    const auto end = static_cast<off_t>(size);
    if (::ftruncate(descriptor_, end) != 0 || ::lseek(descriptor_, end, SEEK_SET) != end)
        throw file_error(path_, "cannot cut to its whole rows", errno);
}

void File::sync() {
    // A file system that cannot sync (EINVAL) has written as well as it can.
    if (::fsync(descriptor_) != 0 && errno != EINVAL) throw file_error(path_, "cannot write to the disk", errno);
}

void File::close() {
    const int descriptor = std::exchange(descriptor_, -1);
    // After EINTR Linux has closed the descriptor all the same.
    if (descriptor >= 0 && ::close(descriptor) != 0 && errno != EINTR) throw file_error(path_, "cannot close", errno);
}

}  // namespace dttmm::host
