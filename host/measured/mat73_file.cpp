// SPDX-License-Identifier: BSD-3-Clause
#include "measured/mat73_file.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <exception>
#include <set>
#include <string>
#include <string_view>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// Owns one HDF5 identifier and the function that closes its kind.
class Hdf5Id {
public:
    Hdf5Id(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
    Hdf5Id(const Hdf5Id&) = delete;
    Hdf5Id& operator=(const Hdf5Id&) = delete;
    ~Hdf5Id() {
        if (id_ >= 0) closer_(id_);
    }
    operator hid_t() const { return id_; }

private:
    hid_t id_;
    herr_t (*closer_)(hid_t);
};

/// Whether a compound is a real and an imaginary part, each within it.
bool is_complex_type(hid_t type) {
    if (H5Tget_nmembers(type) != 2) return false;
    for (const char* part : {"real", "imag"}) {
        const int index = H5Tget_member_index(type, part);
        if (index < 0) return false;
        const auto member = as_whole<unsigned>(index);
        const Hdf5Id own(H5Tget_member_type(type, member), &H5Tclose);
        if (own < 0 || (H5Tget_class(own) != H5T_FLOAT && H5Tget_class(own) != H5T_INTEGER)) return false;
        if (H5Tget_member_offset(type, member) + H5Tget_size(own) > H5Tget_size(type)) return false;
    }
    return true;
}

/// Reads the variables one after another. In HDF5 a struct is a group, and a struct array a group of datasets of references.
class Mat73Reader {
public:
    explicit Mat73Reader(const std::filesystem::path& file) : file_(file) {}
    std::vector<MatArray> read();

private:
    [[noreturn]] void fail(const std::string& name, const std::string& fault) const;
    static herr_t keep_name(hid_t group, const char* name, const H5L_info_t* info, void* names);
    void take_group(hid_t group, const std::string& name, int depth);
    void take_object(hid_t object, const std::string& name, int depth);
    void take_dataset(hid_t dataset, const std::string& name, const std::string& of, int depth);
    void take_elements(hid_t dataset, const std::string& name, std::size_t count, int depth);
    void take_numbers(hid_t dataset, bool is_complex, MatArray& array);
    void check_storage(hid_t dataset, const std::string& name, std::uintmax_t count) const;
    static std::string matlab_class(hid_t object);

    std::filesystem::path file_;
    std::uintmax_t size_ = 0, numbers_ = 0;
    std::set<haddr_t> seen_;  ///< objects: each belongs to one variable
    std::vector<MatArray> arrays_;
};

void Mat73Reader::fail(const std::string& name, const std::string& fault) const {
    throw Error(ExitCode::input_output, fmt::format("{}: {}: {}: the file is cut off or damaged: save it again",
                                                    file_.string(), printable(name), fault));
}

/// The attribute MATLAB_class; empty: there is none.
std::string Mat73Reader::matlab_class(hid_t object) {
    if (H5Aexists(object, "MATLAB_class") <= 0) return {};
    const Hdf5Id attribute(H5Aopen(object, "MATLAB_class", H5P_DEFAULT), &H5Aclose);
    const Hdf5Id type(H5Aget_type(attribute), &H5Tclose), space(H5Aget_space(attribute), &H5Sclose);
    constexpr std::size_t kLongest = 256;  // names of MATLAB have 63 bytes
    const std::size_t size = type >= 0 ? H5Tget_size(type) : 0;
    const bool is_text = type >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
    if (!is_text || size == 0 || size > kLongest || H5Sget_simple_extent_npoints(space) != 1) return "unknown";
    std::string text(size, '\0');
    if (H5Aread(attribute, type, text.data()) < 0) return "unknown";
    return text.substr(0, text.find_first_of(std::string_view("\0 ", 2)));
}

/// Names of hard links: others lead to other files.
herr_t Mat73Reader::keep_name(hid_t, const char* name, const H5L_info_t* info, void* names) {
    const std::string_view link = name;
    if (info->type == H5L_TYPE_HARD && link != "#refs#" && link != "#subsystem#")
        static_cast<std::vector<std::string>*>(names)->emplace_back(link);
    return 0;
}

/// The group's variables, or the fields of a struct of this name.
void Mat73Reader::take_group(hid_t group, const std::string& name, int depth) {
    std::vector<std::string> names;
    if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, &Mat73Reader::keep_name, &names) < 0)
        fail(name, "HDF5 cannot list what is in it");
    for (const std::string& own : names) {
        const std::string whole = name.empty() ? own : name + "." + own;
        const Hdf5Id object(H5Oopen(group, own.c_str(), H5P_DEFAULT), &H5Oclose);
        if (object < 0) fail(whole, "HDF5 cannot open it");
        take_object(object, whole, depth);
    }
}

void Mat73Reader::take_object(hid_t object, const std::string& name, int depth) {
    if (depth > kDeepestMat) fail(name, "structs are nested too deep");
    H5O_info_t info;
    if (H5Oget_info2(object, &info, H5O_INFO_BASIC) < 0 || !seen_.insert(info.addr).second)
        fail(name, "it is a part of itself or of another variable");
    const std::string of = matlab_class(object);
    if (info.type == H5O_TYPE_GROUP && (of == "struct" || of.empty())) {
        take_group(object, name, depth + 1);
    } else if (info.type == H5O_TYPE_DATASET) {
        take_dataset(object, name, of, depth);
    } else {
        MatArray array;
        array.name = name;
        array.kind = H5Aexists(object, "MATLAB_sparse") > 0 ? "sparse matrix" : "object of a MATLAB class";
        array.sizes = {1, 1};
        arrays_.push_back(std::move(array));
    }
}

/// What the file has of the dataset must be enough for its numbers.
void Mat73Reader::check_storage(hid_t dataset, const std::string& name, std::uintmax_t count) const {
    const Hdf5Id type(H5Dget_type(dataset), &H5Tclose), made(H5Dget_create_plist(dataset), &H5Pclose);
    const std::uintmax_t stored = H5Dget_storage_size(dataset), each = H5Tget_size(type);
    const bool is_filtered = H5Pget_nfilters(made) > 0;
    if (stored > size_ || each == 0 || count > stored * (is_filtered ? kMostInflation : 1) / each)
        fail(name, "it has more numbers than the file holds");
    if (H5Pget_layout(made) != H5D_CHUNKED) return;
    std::vector<hsize_t> chunk(H5S_MAX_RANK);
    const int rank = H5Pget_chunk(made, H5S_MAX_RANK, chunk.data());
    std::uintmax_t most = size_ * kMostInflation / each;
    for (int i = 0; i < rank; ++i) most /= std::max<hsize_t>(chunk[as_size(i)], 1);
    if (most == 0) fail(name, "its chunks are larger than the file");
}

void Mat73Reader::take_numbers(hid_t dataset, bool is_complex, MatArray& array) {
    const std::size_t count = array.count();
    if (count == 0) return;
    numbers_ += count * (is_complex ? 2 : 1);
    if (numbers_ > kMostMatNumbers) fail(array.name, "the numbers so far take more than 4 GiB");
    const auto read = [&](hid_t type, std::vector<double>& values) {
        values.resize(count);
        if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
            fail(array.name, "HDF5 cannot read its numbers");
    };
    if (!is_complex) return read(H5T_NATIVE_DOUBLE, array.real);
    for (const auto& [part, values] : {std::pair("real", &array.real), std::pair("imag", &array.imaginary)}) {
        const Hdf5Id type(H5Tcreate(H5T_COMPOUND, sizeof(double)), &H5Tclose);
        H5Tinsert(type, part, 0, H5T_NATIVE_DOUBLE);
        read(type, *values);
    }
}

/// A field of a struct array: a reference per element.
void Mat73Reader::take_elements(hid_t dataset, const std::string& name, std::size_t count, int depth) {
    std::vector<hobj_ref_t> references(count);
    if (H5Dread(dataset, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, references.data()) < 0)
        fail(name, "HDF5 cannot read its references");
    const std::size_t dot = name.rfind('.');
    for (std::size_t e = 0; e < count; ++e) {
        const std::string own = fmt::format("{}({}){}", name.substr(0, dot), e + 1, name.substr(dot));
        const Hdf5Id object(H5Rdereference2(dataset, H5P_DEFAULT, H5R_OBJECT, &references[e]), &H5Oclose);
        if (object < 0) fail(own, "HDF5 cannot open it");
        take_object(object, own, depth + 1);
    }
}

void Mat73Reader::take_dataset(hid_t dataset, const std::string& name, const std::string& of, int depth) {
    const Hdf5Id type(H5Dget_type(dataset), &H5Tclose), space(H5Dget_space(dataset), &H5Sclose);
    std::vector<hsize_t> lengths(H5S_MAX_RANK);
    const int rank = H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
    if (type < 0 || rank < 0) fail(name, "HDF5 cannot tell its sizes");
    MatArray array;
    array.name = name;
    array.kind = of.empty() ? "double" : of;
    const bool is_empty = H5Aexists(dataset, "MATLAB_empty") > 0;  // sizes stand for the numbers then
    std::uintmax_t count = is_empty ? 0 : 1;
    for (int i = rank; i-- > 0;) {  // the last subscript runs fastest in HDF5, the first in MATLAB
        const hsize_t length = lengths[as_size(i)];
        if (length > 0 && count > kMostMatNumbers / length) fail(name, "it has too many numbers");
        count *= length;
        array.sizes.push_back(is_empty ? 0 : length);
    }
    array.sizes.resize(std::max<std::size_t>(array.sizes.size(), 2), is_empty ? 0 : 1);
    if (count > 0) check_storage(dataset, name, count);
    const H5T_class_t kind = H5Tget_class(type);
    const bool is_complex = kind == H5T_COMPOUND && is_complex_type(type);
    constexpr std::string_view kNumeric[] = {"",      "double", "single", "logical", "int8",  "uint8",
                                             "int16", "uint16", "int32",  "uint32",  "int64", "uint64"};
    const bool is_numeric =
        std::ranges::find(kNumeric, of) != std::end(kNumeric) && H5Aexists(dataset, "MATLAB_object_decode") <= 0;
    if (is_numeric && (kind == H5T_INTEGER || kind == H5T_FLOAT || is_complex)) {
        array.of = MatArray::Of::numbers;
        take_numbers(dataset, is_complex, array);
    } else if (of == "char" && kind == H5T_INTEGER) {
        array.of = MatArray::Of::text;
        std::vector<std::uint16_t> units(count);
        if (count > 0 && H5Dread(dataset, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, units.data()) < 0)
            fail(name, "HDF5 cannot read its characters");
        array.text = utf8_of_utf16(units);
    } else if (of.empty() && H5Tequal(type, H5T_STD_REF_OBJ) > 0 && name.find('.') != name.npos) {
        return take_elements(dataset, name, count, depth);
    } else if (of != "cell" && of != "function_handle") {
        array.kind = of.empty() ? "unknown class" : "object of class " + of;
    }
    arrays_.push_back(std::move(array));
}

std::vector<MatArray> Mat73Reader::read() {
    std::error_code fault;
    size_ = std::filesystem::file_size(file_, fault);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // this reader reports faults itself
    const Hdf5Id id(H5Fopen(file_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), &H5Fclose);
    if (id < 0)
        throw Error(ExitCode::input_output,
                    fmt::format("{}: HDF5 cannot open it: the file is cut off or damaged: save it again", file_.string()));
    take_group(id, "", 0);
    return std::move(arrays_);
}

}  // namespace

std::vector<MatArray> read_mat73(const std::filesystem::path& file) { return Mat73Reader(file).read(); }

}  // namespace dttmm::host
