// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_writer.h"

#include <fmt/compile.h>

#include <cassert>
#include <cerrno>
#include <iterator>

namespace dttmm {

namespace {

constexpr std::size_t kMostWaiting = 64 * 1024;  // bytes
constexpr std::chrono::milliseconds kLongestWait{100};
constexpr std::size_t kLongestNumber = 25;  // "-2.2250738585072014e-308" and a comma

void append_text(std::string& line, const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        line += text;
        return;
    }
    line += '"';
    for (const char c : text) line.append(c == '"' ? 2 : 1, c);
    line += '"';
}

std::string make_header(const std::vector<Channel>& channels, std::string Channel::*text) {
    std::string line;
    for (const Channel& channel : channels) {
        append_text(line, channel.*text);
        line += ',';
    }
    line.back() = '\n';
    return line;
}

}  // namespace

CsvWriter::CsvWriter(const std::filesystem::path& path, const std::vector<Channel>& channels) : file_(File::create(path)) {
    assert(!channels.empty());
    waiting_ = make_header(channels, &Channel::name) + make_header(channels, &Channel::unit);
    write_waiting_rows();
    waiting_.reserve(kMostWaiting + kLongestNumber * channels.size());
}

CsvWriter::~CsvWriter() {
    try {
        write_waiting_rows();
    } catch (const Error&) {  // finish() is there for those who want to know
    }
}

void CsvWriter::write_row(std::span<const double> values) {
    for (const double value : values) fmt::format_to(std::back_inserter(waiting_), FMT_COMPILE("{},"), value);
    waiting_.back() = '\n';
    if (waiting_.size() >= kMostWaiting || Clock::now() - last_write_ >= kLongestWait) write_waiting_rows();
}

void CsvWriter::finish() {
    write_waiting_rows();
    file_.sync();
    file_.close();
}

void CsvWriter::write_waiting_rows() {
    const std::size_t written = file_.write_some(waiting_);
    if (written < waiting_.size()) {
        const int reason = errno;
        file_size_ += written == 0 ? 0 : waiting_.rfind('\n', written - 1) + 1;  // npos + 1 = 0: not one whole row
        waiting_.clear();
        file_.truncate(file_size_);
        throw file_error(file_.path(), "cannot write", reason);
    }
    file_size_ += written;
    waiting_.clear();
    last_write_ = Clock::now();
}

}  // namespace dttmm
