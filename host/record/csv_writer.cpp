// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_writer.h"

#include <fmt/compile.h>
#include <unistd.h>

#include <atomic>
#include <cassert>
#include <cerrno>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr std::size_t kMostWaiting = 64 * 1024;  // bytes
constexpr std::size_t kPage = 4096;              // bytes: the kernel takes a write page by page
constexpr std::chrono::milliseconds kLongestWait{100};
constexpr std::size_t kLongestNumber = 25;  // "-2.2250738585072014e-308" and a comma

/// The writer made last.
std::atomic<CsvWriter*> last_made = nullptr;
static_assert(std::atomic<CsvWriter*>::is_always_lock_free, "a signal handler reads it");

std::string make_row(const std::vector<Column>& columns, std::string Column::*text) {
    std::string line;
    for (const Column& column : columns) {
        add_csv_field(column.*text, line);
        line += ',';
    }
    line.back() = '\n';
    return line;
}

}  // namespace

void add_csv_field(std::string_view text, std::string& line) {
    const auto has = [&](char c) { return text.find(c) != text.npos; };
    if (!has(',') && !has('"') && !has('\r') && !has('\n')) {
        line += text;
        return;
    }
    line += '"';
    for (const char c : text) line.append(c == '"' ? 2 : 1, c);
    line += '"';
}

std::string csv_header(const std::vector<Column>& columns) {
    return make_row(columns, &Column::name) + make_row(columns, &Column::unit);
}

/// While this lives, a signal leaves the waiting rows alone.
class CsvWriter::AtWork {
public:
    explicit AtWork(CsvWriter& writer) : writer_(writer) {
        writer_.is_at_work_ = 1;
        std::atomic_signal_fence(std::memory_order_seq_cst);
    }
    ~AtWork() {
        std::atomic_signal_fence(std::memory_order_seq_cst);
        writer_.is_at_work_ = 0;
    }
    AtWork(const AtWork&) = delete;
    AtWork& operator=(const AtWork&) = delete;

private:
    CsvWriter& writer_;
};

CsvWriter::CsvWriter(const std::filesystem::path& path, const std::vector<Column>& columns) : file_(File::create(path)) {
    assert(!columns.empty());
    waiting_ = csv_header(columns);
    write_waiting_rows();
    waiting_.reserve(kMostWaiting + kLongestNumber * columns.size());
    last_made = this;
}

CsvWriter::~CsvWriter() {
    CsvWriter* self = this;
    last_made.compare_exchange_strong(self, nullptr);
    const AtWork at_work(*this);
    try {
        write_waiting_rows();
    } catch (const Error&) {  // finish() is there for those who want to know
    }
}

void CsvWriter::write_row(std::span<const double> values) {
    const AtWork at_work(*this);
    const std::size_t size = waiting_.size();
    waiting_.resize(size + kLongestNumber * values.size());  // writing into it is faster than appending to it
    char* end = waiting_.data() + size;
    for (const double value : values) end = fmt::format_to(end, FMT_COMPILE("{},"), value);
    end[-1] = '\n';
    waiting_.resize(as_size(end - waiting_.data()));
    if (waiting_.size() >= kMostWaiting || Clock::now() - last_write_ >= kLongestWait) write_waiting_rows();
}

void CsvWriter::finish() {
    const AtWork at_work(*this);
    write_waiting_rows();
    file_.sync();
    file_.close();
}

void CsvWriter::rescue_rows() noexcept {
    const CsvWriter* writer = last_made;
    if (!writer || writer->is_at_work_) return;
    std::string_view rest = writer->waiting_;
    while (!rest.empty()) {
        const ssize_t written = ::write(writer->file_.descriptor(), rest.data(), rest.size());
        if (written <= 0) return;
        rest.remove_prefix(as_size(written));
    }
}

void CsvWriter::write_waiting_rows() {
    std::string_view rest = waiting_;
    while (!rest.empty()) {
        const std::string_view rows = rest.substr(0, size_of_next_write(rest));
        const std::size_t written = file_.write_some(rows);
        if (written < rows.size()) fail(rows.substr(0, written));
        file_size_ += written;
        rest.remove_prefix(written);
    }
    waiting_.clear();
    last_write_ = Clock::now();
}

/// The whole rows of `rest` that fit into the file's last page; if there are none, the one row that crosses its end.
std::size_t CsvWriter::size_of_next_write(std::string_view rest) const {
    const std::size_t room = kPage - file_size_ % kPage;
    if (rest.size() <= room) return rest.size();
    const std::size_t fitting = rest.rfind('\n', room - 1) + 1;  // npos + 1 = 0
    return fitting > 0 ? fitting : rest.find('\n') + 1;
}

/// written: what the disk took of the last write.
void CsvWriter::fail(std::string_view written) {
    const int reason = errno;
    file_size_ += written.rfind('\n') + 1;  // npos + 1 = 0: not one whole row
    waiting_.clear();
    file_.truncate(file_size_);
    throw file_error(file_.path(), "cannot write", reason);
}

}  // namespace dttmm::host
