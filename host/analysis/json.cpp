// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/json.h"

#include <algorithm>

#include "record/atomic_file.h"

namespace dttmm::host {

namespace {

constexpr unsigned kIndent = 2;

/// Takes characters to a stream in blocks: a stream takes long for each call.
class Blocks : public nlohmann::detail::output_adapter_protocol<char> {
public:
    explicit Blocks(std::ostream& stream) : stream_(stream) {}
    void write_character(char character) override { write({&character, 1}); }
    void write_characters(const char* characters, std::size_t count) override { write({characters, count}); }
    void write(std::string_view text) {
        waiting_ += text;
        if (waiting_.size() >= kBlock) flush();
    }
    void flush() {
        stream_.write(waiting_.data(), static_cast<std::streamsize>(waiting_.size()));
        waiting_.clear();
    }

private:
    static constexpr std::size_t kBlock = 4096;  // bytes
    std::ostream& stream_;
    std::string waiting_;
};

}  // namespace

/// Json::dump makes one text of it all, three times as large as what it describes.
class JsonOutput {
public:
    explicit JsonOutput(std::ostream& stream)
        : blocks_(std::make_shared<Blocks>(stream)), serializer_(blocks_, ' ', Json::error_handler_t::replace) {}

    void write(std::string_view text) { blocks_->write(text); }
    void dump(const Json& json, unsigned depth) { serializer_.dump(json, true, false, kIndent, kIndent * depth); }
    void flush() { blocks_->flush(); }

private:
    std::shared_ptr<Blocks> blocks_;
    nlohmann::detail::serializer<Json> serializer_;
};

JsonWriter::JsonWriter(std::ostream& stream) : output_(std::make_unique<JsonOutput>(stream)) { open('{'); }
JsonWriter::~JsonWriter() = default;

void JsonWriter::open(char bracket) {
    output_->write({&bracket, 1});
    ++depth_;
    is_empty_ = true;
}

void JsonWriter::close(char bracket) {
    --depth_;
    if (!is_empty_) start_line();
    output_->write({&bracket, 1});
    is_empty_ = false;
}

void JsonWriter::start_line() {
    output_->write("\n");
    for (unsigned i = 0; i < kIndent * depth_; ++i) output_->write(" ");
}

void JsonWriter::begin_line() {
    if (!is_empty_) output_->write(",");
    is_empty_ = false;
    start_line();
}

void JsonWriter::dump(const Json& value) { output_->dump(value, depth_); }

void JsonWriter::begin_member(std::string_view name) {
    begin_line();
    output_->dump(Json(name), depth_);
    output_->write(": ");
}

void JsonWriter::member(std::string_view name, const Json& value) {
    begin_member(name);
    output_->dump(value, depth_);
}

void JsonWriter::text(std::string_view name, std::string_view value) {
    constexpr std::size_t kPiece = 4096;  // bytes
    begin_member(name);
    output_->write("\"");
    while (!value.empty()) {
        std::size_t end = std::min(kPiece, value.size());
        for (int back = 0; back < 3 && end < value.size() && (value[end] & 0xC0) == 0x80; ++back)
            --end;  // within a character
        const std::string quoted = Json(value.substr(0, end)).dump(-1, ' ', false, Json::error_handler_t::replace);
        output_->write(std::string_view(quoted).substr(1, quoted.size() - 2));
        value.remove_prefix(end);
    }
    output_->write("\"");
}

void JsonWriter::finish() {
    close('}');
    output_->write("\n");
    output_->flush();
}

void write_json(std::ostream& stream, const Json& json) {
    JsonOutput output(stream);
    output.dump(json, 0);
    output.write("\n");
    output.flush();
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
