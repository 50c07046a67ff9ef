// SPDX-License-Identifier: BSD-3-Clause
#include "report/mat_file.h"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/file.h"

namespace dttmm::host {

namespace {

struct FreeVariable {
    void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

Variable made(matvar_t* variable) {
    if (!variable) throw std::bad_alloc();
    return Variable(variable);
}

/// A copy of data, which matio takes as not constant.
Variable variable(const std::string& name, matio_classes of, matio_types type, std::array<std::size_t, 2> sizes,
                  const void* data, int options = 0) {
    return made(Mat_VarCreate(name.c_str(), of, type, 2, sizes.data(), const_cast<void*>(data), options));
}

Variable column(const std::string& name, const std::vector<double>& values) {
    return variable(name, MAT_C_DOUBLE, MAT_T_DOUBLE, {values.size(), 1}, values.data());
}

Variable column(const std::string& name, const std::vector<std::complex<double>>& values) {
    std::vector<double> real, imaginary;
    for (const std::complex<double>& value : values) {
        real.push_back(value.real());
        imaginary.push_back(value.imag());
    }
    const mat_complex_split_t parts = {real.data(), imaginary.data()};
    return variable(name, MAT_C_DOUBLE, MAT_T_DOUBLE, {values.size(), 1}, &parts, MAT_F_COMPLEX);
}

/// UTF-16 of UTF-8; U+FFFD for what is none.
std::u16string utf16(std::string_view text) {
    std::u16string out;
    for (std::size_t i = 0; i < text.size();) {
        const auto first = static_cast<unsigned char>(text[i++]);
        const int more = first < 0x80 ? 0 : first >> 5 == 6 ? 1 : first >> 4 == 14 ? 2 : first >> 3 == 30 ? 3 : -1;
        char32_t code = more <= 0 ? first : first & (0x3fu >> more);
        bool is_bad = more < 0;
        for (int k = 0; k < more && !is_bad; ++k) {
            is_bad = i >= text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80;
            if (!is_bad) code = code << 6 | (static_cast<unsigned char>(text[i++]) & 0x3fu);
        }
        if (is_bad) code = 0xfffd;
        if (code < 0x10000) {
            out += static_cast<char16_t>(code);
        } else {
            out += static_cast<char16_t>(0xd800 + ((code - 0x10000) >> 10));
            out += static_cast<char16_t>(0xdc00 + ((code - 0x10000) & 0x3ff));
        }
    }
    return out;
}

Variable text(const std::string& name, std::string_view value) {
    const std::u16string units = utf16(value);
    return variable(name, MAT_C_CHAR, MAT_T_UINT16, {units.empty() ? 0u : 1u, units.size()}, units.data());
}

Variable texts(const std::string& name, const std::vector<std::string>& values) {
    Variable cell = variable(name, MAT_C_CELL, MAT_T_CELL, {values.size(), 1}, nullptr);
    for (std::size_t i = 0; i < values.size(); ++i) Mat_VarSetCell(cell.get(), as_int(i), text("", values[i]).release());
    return cell;
}

/// A struct array of 1×count.
class Struct {
public:
    Struct(const std::string& name, const std::vector<std::string>& fields, std::size_t count = 1) {
        std::vector<const char*> names;
        for (const std::string& field : fields) names.push_back(field.c_str());
        std::array<std::size_t, 2> sizes = {1, count};
        variable_ = made(Mat_VarCreateStruct(name.c_str(), 2, sizes.data(), names.data(), as_whole<unsigned>(names.size())));
    }
    void set(std::size_t field, Variable value, std::size_t index = 0) {
        Mat_VarSetStructFieldByIndex(variable_.get(), field, index, value.release());
    }
    Variable take() { return std::move(variable_); }

private:
    Variable variable_;
};

/// A MAT file that has its name when it is whole.
class MatFile {
public:
    explicit MatFile(const std::filesystem::path& path, const std::string& head)
        : part_(path), file_(Mat_CreateVer(part_.path().c_str(), head.c_str(), MAT_FT_MAT5)) {
        if (!file_) fail();
    }
    MatFile(const MatFile&) = delete;
    MatFile& operator=(const MatFile&) = delete;
    ~MatFile() {
        if (file_) Mat_Close(file_);
    }

    void write(const Variable& variable) {
        if (Mat_VarWrite(file_, variable.get(), MAT_COMPRESSION_ZLIB) != 0) fail();
    }
    void publish() {
        if (Mat_Close(std::exchange(file_, nullptr)) != 0) fail();
        part_.publish();
    }

private:
    [[noreturn]] void fail() const { throw file_error(part_.final_path(), "cannot write", errno); }

    PartFile part_;
    mat_t* file_;
};

/// Columns without a unit are texts in the file; some are numbers all the same, each with the unit of its row.
std::optional<std::vector<double>> numbers_of(const std::vector<std::string>& values) {
    std::vector<double> numbers;
    bool has_number = false;
    for (const std::string& value : values) {
        double number = NAN;
        const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), number);
        if (!value.empty() && (fault != std::errc() || end != value.data() + value.size())) return {};
        has_number = has_number || !value.empty();
        numbers.push_back(number);
    }
    if (!has_number) return {};
    return numbers;
}

Variable table_variable(const std::string& name, const CsvFile& table) {
    MatlabNames names;
    std::vector<std::string> fields;
    for (const Column& head : table.columns()) fields.push_back(names.take(head.name));
    Struct units("units", fields);
    for (std::size_t c = 0; c < fields.size(); ++c) units.set(c, text(fields[c], table.columns()[c].unit));
    std::vector<std::string> with_units = fields;
    with_units.push_back(names.take("units"));
    Struct all(name, with_units);
    for (std::size_t c = 0; c < fields.size(); ++c) {
        if (!table.is_text(c))
            all.set(c, column(fields[c], table.numbers(c)));
        else if (const auto numbers = numbers_of(table.texts(c)))
            all.set(c, column(fields[c], *numbers));
        else
            all.set(c, texts(fields[c], table.texts(c)));
    }
    all.set(fields.size(), units.take());
    return all.take();
}

Variable parameters_of(const Json& model) {
    MatlabNames names;
    std::vector<std::string> fields;
    std::vector<double> values;
    if (model.is_object() && model.contains("parameters") && model["parameters"].is_object())
        for (const auto& [name, value] : model["parameters"].items()) {
            if (!value.is_number()) continue;
            fields.push_back(names.take(name));
            values.push_back(value.get<double>());
        }
    Struct all("parameters", fields);
    for (std::size_t i = 0; i < fields.size(); ++i) all.set(i, column(fields[i], std::vector<double>{values[i]}));
    return all.take();
}

/// What channels says of a curve.
struct ChannelLine {
    std::array<std::string, 7> texts;
};

const std::vector<std::string> kChannelFields = {"name", "unit", "variable", "over", "over_unit", "file", "label"};

std::string member_text(const Json& object, const char* name) {
    return object.is_object() && object.contains(name) && object[name].is_string() ? object[name].get<std::string>() : "";
}

}  // namespace

std::string MatlabNames::take(std::string_view name) {
    constexpr std::size_t kLongest = 63;  // of MATLAB
    static const std::set<std::string, std::less<>> kKeywords = {
        "break",  "case", "catch",     "classdef", "continue",   "else",   "elseif", "end",    "for", "function",
        "global", "if",   "otherwise", "parfor",   "persistent", "return", "spmd",   "switch", "try", "while"};
    std::string made;
    for (const char c : name) {
        if ((static_cast<unsigned char>(c) & 0xc0) == 0x80) continue;  // within a character
        const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        if (made.empty() && !is_letter) made = "x";
        made += is_letter || (c >= '0' && c <= '9') ? c : '_';
    }
    if (made.empty()) made = "x";
    if (kKeywords.contains(made)) made += '_';
    made.resize(std::min(made.size(), kLongest));
    std::string unique = made;
    for (int i = 2; !taken_.insert(unique).second; ++i) {
        const std::string ending = fmt::format("_{}", i);
        unique = made.substr(0, kLongest - ending.size()) + ending;
    }
    return unique;
}

std::string write_mat(const Results& results, const std::vector<CsvFile>& tables, const std::filesystem::path& path) {
    MatFile file(path, fmt::format("MATLAB 5.0 MAT-file, dttmm {}, results of {}", DTTMM_VERSION, results.written));
    MatlabNames names;
    for (const char* own : {"channels", "parameters", "title", "kind", "version", "model_text", "command_line"})
        names.take(own);
    file.write(text("title", results.title));
    file.write(text("kind", results.kind));
    file.write(text("version", DTTMM_VERSION));
    file.write(text("command_line", member_text(results.summary, "command_line")));
    file.write(text("model_text", results.model_text));
    file.write(parameters_of(results.model));
    std::vector<ChannelLine> lines;
    for (const CurveSet& set : results.sets) {
        const std::string ending = set.label.empty() ? "" : "_" + set.label, over = names.take(set.x.name + ending);
        file.write(column(over, set.places));
        for (const Curve& curve : set.curves) {
            const std::string variable = names.take(curve.head.name + ending);
            file.write(curve.complex_values.empty() ? column(variable, curve.values)
                                                    : column(variable, curve.complex_values));
            lines.push_back({{curve.head.name, curve.head.unit, variable, over, set.x.unit, set.file, set.label}});
        }
    }
    Struct channels("channels", kChannelFields, lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i)
        for (std::size_t field = 0; field < kChannelFields.size(); ++field)
            channels.set(field, text(kChannelFields[field], lines[i].texts[field]), i);
    file.write(channels.take());
    for (const CsvFile& table : tables) file.write(table_variable(names.take(table.path().stem().string()), table));
    file.publish();
    return fmt::format("{}, {}", counted(lines.size(), "curve", "curves"), counted(tables.size(), "table", "tables"));
}

}  // namespace dttmm::host
