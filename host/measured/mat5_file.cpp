// SPDX-License-Identifier: BSD-3-Clause
#include "measured/mat5_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// Types of elements, and classes of arrays.
enum MatType : std::uint32_t {
    kInt8 = 1,
    kUint8 = 2,
    kInt16 = 3,
    kUint16 = 4,
    kInt32 = 5,
    kUint32 = 6,
    kSingle = 7,
    kDouble = 9,
    kInt64 = 12,
    kUint64 = 13,
    kMatrix = 14,
    kCompressed = 15,
    kUtf8 = 16,
    kUtf16 = 17
};
enum MatClass : std::uint32_t { kCell = 1, kStruct = 2, kChar = 4, kDoubleClass = 6, kLastNumeric = 15, kOpaque = 17 };

constexpr std::array<const char*, 18> kMatKinds = {"unknown class",
                                                   "cell",
                                                   "struct",
                                                   "object of a MATLAB class",
                                                   "char",
                                                   "sparse matrix",
                                                   "double",
                                                   "single",
                                                   "int8",
                                                   "uint8",
                                                   "int16",
                                                   "uint16",
                                                   "int32",
                                                   "uint32",
                                                   "int64",
                                                   "uint64",
                                                   "function handle",
                                                   "object of a MATLAB class"};

struct MatElement {
    std::uint32_t type = 0;
    std::string_view data;
};

/// Reads the variables one after another.
class Mat5Reader {
public:
    Mat5Reader(const std::filesystem::path& file, std::string_view bytes, bool is_big_endian)
        : file_(file.string()), bytes_(bytes), is_big_endian_(is_big_endian) {}
    std::vector<MatArray> read();

private:
    [[noreturn]] void fail(const std::string& fault) const;
    template <class Number>
    Number number(std::string_view data, std::size_t at) const;
    MatElement next(std::string_view& bytes) const;
    std::string inflated(std::string_view data) const;
    void take_matrix(std::string_view data, const std::string& name, int depth);
    void take_struct(std::string_view data, const std::string& name, std::size_t count, int depth);
    void take_text(std::string_view data, MatArray& array) const;
    std::vector<double> numbers(const MatElement& element, std::size_t count);
    template <class Number>
    std::vector<double> numbers_of(std::string_view data, std::size_t count) const;
    std::vector<std::size_t> sizes(std::string_view data) const;

    std::string file_;
    std::string_view bytes_;
    bool is_big_endian_;
    std::string where_;  ///< the variable that is read
    std::uintmax_t numbers_ = 0;
    std::vector<MatArray> arrays_;
};

void Mat5Reader::fail(const std::string& fault) const {
    throw Error(ExitCode::input_output,
                fmt::format("{}: {}: {}: the file is cut off or damaged: save it again", file_, where_, fault));
}

template <class Number>
Number Mat5Reader::number(std::string_view data, std::size_t at) const {
    std::array<char, sizeof(Number)> bytes;
    if (at + bytes.size() > data.size()) fail("it ends early");
    std::copy_n(data.begin() + as_row(at), bytes.size(), bytes.begin());
    if (is_big_endian_ != (std::endian::native == std::endian::big)) std::ranges::reverse(bytes);
    return std::bit_cast<Number>(bytes);
}

/// The next element: type and size of four bytes each and data up to a multiple of eight bytes; or of two bytes each, and
/// data of up to four bytes. `bytes` moves behind it.
MatElement Mat5Reader::next(std::string_view& bytes) const {
    const auto first = number<std::uint32_t>(bytes, 0);
    const bool is_small = first >> 16 != 0;
    const std::size_t begin = is_small ? 4 : 8, size = is_small ? first >> 16 : number<std::uint32_t>(bytes, 4);
    if (size > bytes.size() - std::min(begin, bytes.size()) || (is_small && size > 4)) fail("an element ends early");
    const MatElement element = {is_small ? first & 0xffff : first, bytes.substr(begin, size)};
    bytes.remove_prefix(std::min(bytes.size(), is_small ? 8 : begin + (size + 7) / 8 * 8));
    return element;
}

std::string Mat5Reader::inflated(std::string_view data) const {
    // Measurements shrink to a tenth at best. More is for files of a few constants only.
    const std::uintmax_t most = (std::uintmax_t{64} << 20) + 100 * std::uintmax_t{data.size()};
    std::string all;
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));  // zlib does not write to it
    stream.avail_in = static_cast<uInt>(data.size());
    std::array<char, 1 << 16> block;
    int state = Z_OK;
    while (state == Z_OK && all.size() <= most) {
        stream.next_out = reinterpret_cast<Bytef*>(block.data());
        stream.avail_out = static_cast<uInt>(block.size());
        state = inflate(&stream, Z_NO_FLUSH);
        all.append(block.data(), block.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    if (all.size() > most) fail("it holds hardly anything but one number: save it with save -v6 of MATLAB, or");
    if (state != Z_STREAM_END) fail("its compressed data are not whole");
    return all;
}

std::vector<std::size_t> Mat5Reader::sizes(std::string_view data) const {
    std::vector<std::size_t> sizes;
    std::uintmax_t product = 1;
    constexpr std::size_t kMostDimensions = 32;  // MATLAB's own files have hardly more than four
    if (data.size() > 4 * kMostDimensions) fail("it has too many dimensions");
    for (std::size_t at = 0; at + 4 <= data.size(); at += 4) {
        const auto length = number<std::int32_t>(data, at);
        if (length < 0) fail("a size is below 0");
        if (length > 0 && product > kMostMatNumbers / static_cast<std::uintmax_t>(length)) fail("it has too many numbers");
        product *= static_cast<std::uintmax_t>(length);
        sizes.push_back(as_size(length));
    }
    sizes.resize(std::max<std::size_t>(sizes.size(), 2), 1);
    return sizes;
}

template <class Number>
std::vector<double> Mat5Reader::numbers_of(std::string_view data, std::size_t count) const {
    if (data.size() / sizeof(Number) < count) fail("there are fewer numbers than its sizes say");
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(number<Number>(data, i * sizeof(Number)));
    return values;
}

/// Of whatever type: numbers may be stored in a smaller one than that of their class.
std::vector<double> Mat5Reader::numbers(const MatElement& element, std::size_t count) {
    numbers_ += count;
    if (numbers_ > kMostMatNumbers) fail("the numbers so far take more than 4 GiB");
    switch (element.type) {
        case kInt8:
            return numbers_of<std::int8_t>(element.data, count);
        case kUint8:
            return numbers_of<std::uint8_t>(element.data, count);
        case kInt16:
            return numbers_of<std::int16_t>(element.data, count);
        case kUint16:
            return numbers_of<std::uint16_t>(element.data, count);
        case kInt32:
            return numbers_of<std::int32_t>(element.data, count);
        case kUint32:
            return numbers_of<std::uint32_t>(element.data, count);
        case kSingle:
            return numbers_of<float>(element.data, count);
        case kDouble:
            return numbers_of<double>(element.data, count);
        case kInt64:
            return numbers_of<std::int64_t>(element.data, count);
        case kUint64:
            return numbers_of<std::uint64_t>(element.data, count);
        default:
            fail(fmt::format("elements of type {} are no numbers", element.type));
    }
}

void Mat5Reader::take_text(std::string_view data, MatArray& array) const {
    if (data.empty()) return;
    const MatElement element = next(data);
    if (element.type == kUint16 || element.type == kUtf16) {
        std::vector<std::uint16_t> units;
        for (std::size_t at = 0; at + 2 <= element.data.size(); at += 2)
            units.push_back(number<std::uint16_t>(element.data, at));
        array.text = utf8_of_utf16(units);
    } else if (element.type == kUtf8 || element.type == kUint8 || element.type == kInt8) {
        array.text = element.data;
    }
}

/// Fields by element, then by name. data: behind the name of the struct.
void Mat5Reader::take_struct(std::string_view data, const std::string& name, std::size_t count, int depth) {
    const auto width = number<std::int32_t>(next(data).data, 0);
    const std::string_view all = next(data).data;
    if (width <= 0) fail("the names of its fields have no length");
    std::vector<std::string> fields;
    for (std::size_t at = 0; at < all.size(); at += as_size(width)) {
        const std::string_view field = all.substr(at, as_size(width));
        fields.emplace_back(field.substr(0, field.find('\0')));
    }
    constexpr std::size_t kTag = 8;  // bytes that a field takes at least
    if (!fields.empty() && count > data.size() / kTag / fields.size()) fail("there are fewer fields than its sizes say");
    for (std::size_t e = 0; e < count; ++e)
        for (const std::string& field : fields) {
            const MatElement element = next(data);
            if (element.type != kMatrix) fail("a field is no array");
            take_matrix(element.data, fmt::format("{}{}.{}", name, count > 1 ? fmt::format("({})", e + 1) : "", field),
                        depth + 1);
        }
}

/// data: flags, sizes, name, values. name: of a field, which has none itself; empty for a variable.
void Mat5Reader::take_matrix(std::string_view data, const std::string& name, int depth) {
    if (data.empty()) return;  // an empty array in a struct
    if (depth > kDeepestMat) fail("structs are nested too deep");
    const auto flags = number<std::uint32_t>(next(data).data, 0);
    const std::uint32_t of = flags & 0xff;
    constexpr std::uint32_t kLogical = 0x0200, kComplex = 0x0800;
    MatArray array;
    array.kind = of < kMatKinds.size() ? kMatKinds[of] : kMatKinds[0];
    if (of == kDoubleClass + 3 && (flags & kLogical)) array.kind = "logical";
    if (of != kOpaque) array.sizes = sizes(next(data).data);
    array.sizes.resize(std::max<std::size_t>(array.sizes.size(), 2), 1);
    const std::string own(next(data).data);
    array.name = name.empty() ? own : name;
    if (array.name.empty()) return;  // what MATLAB keeps for its objects
    if (of == kStruct) return take_struct(data, array.name, array.count(), depth);
    if (of >= kDoubleClass && of <= kLastNumeric) {
        array.of = MatArray::Of::numbers;
        if (array.count() > 0) array.real = numbers(next(data), array.count());
        if (array.count() > 0 && (flags & kComplex)) array.imaginary = numbers(next(data), array.count());
    } else if (of == kChar) {
        array.of = MatArray::Of::text;
        take_text(data, array);
    }
    arrays_.push_back(std::move(array));
}

std::vector<MatArray> Mat5Reader::read() {
    constexpr std::size_t kHead = 128;
    std::size_t count = 0;
    for (std::size_t at = kHead; at < bytes_.size();) {
        where_ = fmt::format("variable {} at byte {}", ++count, at);
        const auto type = number<std::uint32_t>(bytes_, at), size = number<std::uint32_t>(bytes_, at + 4);
        if (type != kMatrix && type != kCompressed) fail(fmt::format("elements of type {} are no variables", type));
        if (size > bytes_.size() - at - 8) fail("it ends early");
        const std::string_view data = bytes_.substr(at + 8, size);
        at += 8 + std::size_t{size};
        if (type == kMatrix) {
            take_matrix(data, "", 0);
            continue;
        }
        const std::string whole = inflated(data);
        std::string_view rest = whole;
        const MatElement element = next(rest);
        if (element.type != kMatrix) fail("its compressed data are no array");
        take_matrix(element.data, "", 0);
    }
    return std::move(arrays_);
}

}  // namespace

std::vector<MatArray> read_mat5(const std::filesystem::path& file, std::string_view bytes, bool is_big_endian) {
    return Mat5Reader(file, bytes, is_big_endian).read();
}

}  // namespace dttmm::host
