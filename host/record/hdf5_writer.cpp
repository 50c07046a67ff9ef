// SPDX-License-Identifier: BSD-3-Clause
#include "record/hdf5_writer.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <mutex>
#include <optional>
#include <string_view>

#include "model/error.h"
#include "model/freed_memory.h"
#include "record/atomic_file.h"

namespace dttmm::host {

namespace {

constexpr hsize_t kMostRowsPerChunk = 1024, kFewestRowsPerChunk = 32;
constexpr std::size_t kTogether = 8;
constexpr hsize_t kNumbersWaiting = hsize_t{1} << 21;  ///< at most, 16 MiB
/// Half of the chunks that a node of a dataset's index holds. HDF5's own 32 takes 2 KiB for each dataset, however short.
constexpr unsigned kHalfNode = 8;
/// Datasets that stay open between writes. HDF5 keeps 13 KiB for each: these take 50 MiB. The others are opened for every
/// write, which takes 10 us each.
constexpr std::size_t kMostOpen = 4096;

/// The library, ours while this lives: one thread at a time, its own error printing off.
class Hdf5Turn {
public:
    Hdf5Turn() : lock_(mutex()) {
        // At exit HDF5 1.10 would flush files that a full disk kept from closing, and crash on them (SIGSEGV).
        [[maybe_unused]] static const herr_t never_at_exit = H5dont_atexit();
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }

private:
    static std::mutex& mutex() {
        static std::mutex instance;
        return instance;
    }
    std::lock_guard<std::mutex> lock_;
};

/// Owns one HDF5 identifier and the function that closes its kind.
class Handle {
public:
    Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}
    Handle& operator=(Handle&&) = delete;
    ~Handle() { close(); }

    operator hid_t() const { return id_; }
    /// Negative on failure; closed for us either way.
    herr_t close() { return id_ < 0 ? 0 : closer_(std::exchange(id_, H5I_INVALID_HID)); }

private:
    hid_t id_;
    herr_t (*closer_)(hid_t);
};

/// Called by HDF5 from the place of the fault outwards: keeps the first text.
herr_t keep_first(unsigned, const H5E_error2_t* error, void* text) {
    auto& kept = *static_cast<std::string*>(text);
    if (kept.empty() && error->desc != nullptr) kept = error->desc;
    return 0;
}

/// "File too large" out of "... errno = 27, error message = 'File too large', buf = ...", or HDF5's own text.
std::string last_fault() {
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, &keep_first, &text);
    constexpr std::string_view key = "error message = '";
    const std::size_t start = text.find(key);
    if (start == std::string::npos) return text.empty() ? "unknown fault in HDF5" : text;
    const std::size_t from = start + key.size();
    return text.substr(from, text.find('\'', from) - from);
}

Handle make_text_type() {
    Handle type(H5Tcopy(H5T_C_S1), &H5Tclose);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

/// How datasets and attributes are made: the same for all, and long to make.
struct Settings {
    explicit Settings(hsize_t chunk)
        : link(H5Pcreate(H5P_LINK_CREATE), &H5Pclose),
          layout(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose),
          whole(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose),
          access(H5Pcreate(H5P_DATASET_ACCESS), &H5Pclose),
          attribute(H5Pcreate(H5P_ATTRIBUTE_CREATE), &H5Pclose),
          text(make_text_type()) {
        H5Pset_char_encoding(link, H5T_CSET_UTF8);
        H5Pset_chunk(layout, 1, &chunk);
        H5Pset_layout(whole, H5D_COMPACT);
        H5Pset_chunk_cache(access, 0, 0, 0);  // chunks are written whole: 1 MiB per channel would hold nothing of use
        H5Pset_char_encoding(attribute, H5T_CSET_UTF8);
    }
    const Handle link, layout, whole, access, attribute, text;
};

}  // namespace

class Hdf5Writer::Implementation {
public:
    Implementation(const std::filesystem::path& path, const std::vector<Column>& columns, const Attributes& attributes);

    void write_row(std::span<const double> values);
    void write_waiting_rows();
    void close();
    void publish() { part_.publish(); }

private:
    template <typename Result>
    Result check(Result result, std::string_view fault) const;

    Handle create_file(const Attributes& attributes) const;
    Handle create_dataset(const Column& column) const;
    void write_whole(const Column& column, const double* values) const;
    Handle open_dataset(const std::string& name) const;
    void write_attribute(hid_t owner, const std::string& name, const char* text) const;
    void append(hid_t dataset, const double* values) const;
    const double* take_column(std::size_t channel);

    PartFile part_;  // declared first: removed last
    const std::vector<Column> heads_;
    hsize_t rows_per_chunk_;  ///< few for many channels, so that a short run of a large machine stays small
    Settings settings_;
    Handle file_;
    std::vector<Handle> datasets_;  ///< of the first kMostOpen channels once rows were written; others are opened every time
    std::vector<double> waiting_;   ///< rows that are not written, one behind the other
    /// Values of kTogether channels, each channel's behind each other: as many as a line of the cache holds of a row.
    std::vector<double> columns_;
    hsize_t rows_waiting_ = 0;
    hsize_t rows_written_ = 0;
};

template <typename Result>
Result Hdf5Writer::Implementation::check(Result result, std::string_view fault) const {
    if (result >= 0) return result;
    throw Error(ExitCode::input_output, fmt::format("{}: {}: {}; free some space or choose another folder with -o",
                                                    part_.path().string(), fault, last_fault()));
}

Hdf5Writer::Implementation::Implementation(const std::filesystem::path& path, const std::vector<Column>& columns,
                                           const Attributes& attributes)
    : part_(path),
      heads_(columns),
      rows_per_chunk_(std::clamp(kNumbersWaiting / columns.size(), kFewestRowsPerChunk, kMostRowsPerChunk)),
      settings_(rows_per_chunk_),
      file_(create_file(attributes)),
      waiting_(columns.size() * rows_per_chunk_),
      columns_(kTogether * rows_per_chunk_) {
    datasets_.reserve(std::min(columns.size(), kMostOpen));
}

/// The file, with its attributes, closed and opened again: HDF5 would keep twice the text of the model in memory while it is
/// open. For a moment it takes 3.5 times the text, in pieces that find no place among what the model and the networks have
/// left free: so that goes back to the system before, and HDF5's own behind.
Handle Hdf5Writer::Implementation::create_file(const Attributes& attributes) const {
    give_back_memory();
    ::unlink(part_.path().c_str());  // what a killed run left, or a link: never written through
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), &H5Pclose);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);  // closing the file closes whatever a failure left open in it
    H5Pset_file_locking(access, false, true);        // the results folder is locked already, and not every disk can lock
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), &H5Pclose);
    H5Pset_istore_k(creation, kHalfNode);
    {
        Handle file(check(H5Fcreate(part_.path().c_str(), H5F_ACC_EXCL, creation, access), "cannot create"), &H5Fclose);
        for (const auto& [name, text] : attributes) write_attribute(file, name, text);
        check(file.close(), "cannot write");
    }
    H5garbage_collect();
    give_back_memory();
    return Handle(check(H5Fopen(part_.path().c_str(), H5F_ACC_RDWR, access), "cannot write"), &H5Fclose);
}

Handle Hdf5Writer::Implementation::create_dataset(const Column& column) const {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(1, &none, &unlimited), &H5Sclose);
    Handle dataset(check(H5Dcreate2(file_, column.name.c_str(), H5T_NATIVE_DOUBLE, space, settings_.link, settings_.layout,
                                    settings_.access),
                         "cannot write"),
                   &H5Dclose);
    write_attribute(dataset, "unit", column.unit.c_str());
    return dataset;
}

/// A dataset whose rows are all there: no index of chunks, which takes most of the time and space of a short one.
void Hdf5Writer::Implementation::write_whole(const Column& column, const double* values) const {
    const Handle space(H5Screate_simple(1, &rows_waiting_, nullptr), &H5Sclose);
    Handle dataset(
        check(H5Dcreate2(file_, column.name.c_str(), H5T_NATIVE_DOUBLE, space, settings_.link, settings_.whole, H5P_DEFAULT),
              "cannot write"),
        &H5Dclose);
    write_attribute(dataset, "unit", column.unit.c_str());
    if (rows_waiting_ > 0)
        check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "cannot write");
    check(dataset.close(), "cannot write");
}

Handle Hdf5Writer::Implementation::open_dataset(const std::string& name) const {
    return Handle(check(H5Dopen2(file_, name.c_str(), settings_.access), "cannot write"), &H5Dclose);
}

void Hdf5Writer::Implementation::write_attribute(hid_t owner, const std::string& name, const char* text) const {
    const Handle space(H5Screate(H5S_SCALAR), &H5Sclose);
    const Handle attribute(
        check(H5Acreate2(owner, name.c_str(), settings_.text, space, settings_.attribute, H5P_DEFAULT), "cannot write"),
        &H5Aclose);
    check(H5Awrite(attribute, settings_.text, &text), "cannot write");
}

void Hdf5Writer::Implementation::write_row(std::span<const double> values) {
    assert(values.size() == heads_.size());
    if (rows_waiting_ == rows_per_chunk_) {
        const Hdf5Turn turn;
        write_waiting_rows();
    }
    std::copy(values.begin(), values.end(), &waiting_[rows_waiting_ * heads_.size()]);
    ++rows_waiting_;
}

void Hdf5Writer::Implementation::write_waiting_rows() {
    if (rows_waiting_ == 0) return;
    for (std::size_t i = 0; i < heads_.size(); ++i) {
        const double* const values = take_column(i);
        if (i < datasets_.size()) {
            append(datasets_[i], values);
            continue;
        }
        Handle dataset = rows_written_ == 0 ? create_dataset(heads_[i]) : open_dataset(heads_[i].name);
        append(dataset, values);
        if (i < kMostOpen)
            datasets_.push_back(std::move(dataset));
        else
            check(dataset.close(), "cannot write");
    }
    rows_written_ += rows_waiting_;
    rows_waiting_ = 0;
}

/// The waiting values of a channel. Channels are asked for in their order.
const double* Hdf5Writer::Implementation::take_column(std::size_t channel) {
    const std::size_t column = channel % kTogether, count = std::min(kTogether, heads_.size() - (channel - column));
    for (hsize_t row = 0; column == 0 && row < rows_waiting_; ++row)
        for (std::size_t k = 0; k < count; ++k)
            columns_[k * rows_per_chunk_ + row] = waiting_[row * heads_.size() + channel + k];
    return &columns_[column * rows_per_chunk_];
}

void Hdf5Writer::Implementation::append(hid_t dataset, const double* values) const {
    const hsize_t rows = rows_written_ + rows_waiting_;
    check(H5Dset_extent(dataset, &rows), "cannot write");
    const Handle in_memory(H5Screate_simple(1, &rows_waiting_, nullptr), &H5Sclose);
    const Handle in_file(check(H5Dget_space(dataset), "cannot write"), &H5Sclose);
    check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &rows_written_, nullptr, &rows_waiting_, nullptr), "cannot write");
    check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values), "cannot write");
}

void Hdf5Writer::Implementation::close() {
    if (rows_written_ == 0)
        for (std::size_t i = 0; i < heads_.size(); ++i) write_whole(heads_[i], take_column(i));
    else
        write_waiting_rows();
    for (Handle& dataset : datasets_) check(dataset.close(), "cannot write");
    check(file_.close(), "cannot write");
}

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path, const std::vector<Column>& columns, const Attributes& attributes) {
    const Hdf5Turn turn;
    implementation_ = std::make_unique<Implementation>(path, columns, attributes);
}

Hdf5Writer::~Hdf5Writer() {
    const Hdf5Turn turn;
    implementation_.reset();
}

void Hdf5Writer::write_row(std::span<const double> values) { implementation_->write_row(values); }

void Hdf5Writer::publish() {
    {
        const Hdf5Turn turn;
        implementation_->close();
    }
    implementation_->publish();
}

std::string Hdf5Writer::version() {
    return fmt::format("{}.{}.{}", H5_VERS_MAJOR, H5_VERS_MINOR,
                       H5_VERS_RELEASE);  // of the headers: H5get_libversion() would start the library
}

}  // namespace dttmm::host
