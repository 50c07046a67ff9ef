// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/json.h"

#include "record/atomic_file.h"

namespace dttmm::host {

namespace {

constexpr unsigned kIndent = 2;

void dump(std::ostream& stream, const Json& json, unsigned depth) {
    // Json::dump makes one text of it all, three times as large as what it describes
    nlohmann::detail::serializer<Json> serializer(nlohmann::detail::output_adapter<char>(stream), ' ',
                                                  Json::error_handler_t::replace);
    serializer.dump(json, true, false, kIndent, kIndent * depth);
}

}  // namespace

void JsonWriter::open() {
    stream_ << '{';
    ++depth_;
    is_empty_ = true;
}

void JsonWriter::close() {
    --depth_;
    if (!is_empty_) start_line();
    stream_ << '}';
    is_empty_ = false;
}

void JsonWriter::start_line() { stream_ << '\n' << std::string(kIndent * depth_, ' '); }

void JsonWriter::begin_member(std::string_view name) {
    if (!is_empty_) stream_ << ',';
    is_empty_ = false;
    start_line();
    dump(stream_, Json(name), 0);
    stream_ << ": ";
}

void JsonWriter::member(std::string_view name, const Json& value) {
    begin_member(name);
    dump(stream_, value, depth_);
}

void JsonWriter::finish() {
    close();
    stream_ << '\n';
}

void write_json(std::ostream& stream, const Json& json) {
    dump(stream, json, 0);
    stream << '\n';
}

void write_json(const std::filesystem::path& path, const Json& json) {
    write_atomically(path, [&](std::ostream& stream) { write_json(stream, json); });
}

void write_json(const std::filesystem::path& path, const std::function<void(JsonWriter&)>& write_members) {
    write_atomically(path, [&](std::ostream& stream) {
        JsonWriter out(stream);
        write_members(out);
        out.finish();
    });
}

std::string to_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace dttmm::host
