// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_study.h"

#include <fmt/format.h>

#include <cmath>

#include "model/wording.h"

namespace dttmm::host {

namespace {

/// The options of one key.
class StudyReader {
public:
    explicit StudyReader(const TableReader& table) : table_(table) {}

    void take_texts(const char* key) {
        const TomlMember* member = table_.find(key);
        if (!member) return;
        const auto take = [&](const TomlValue& value) {
            if (value.is_text())
                add(key, value.string);
            else
                table_.error(value.place, fmt::format("{} must be a text or a list of texts", key));
        };
        if (!member->value.is_array()) return take(member->value);
        for (const TomlValue& item : member->value.items) take(item);
    }
    void take_text(const char* key) {
        if (!table_.find(key)) return;
        if (const auto text = table_.text(key)) add(key, *text);
    }
    void take_word(const char* key) {
        if (!table_.find(key)) return;
        if (const auto choice = table_.choice(key, 0)) add(key, words_of(table_.key(key))[static_cast<size_t>(*choice)]);
    }
    void take_whole(const char* key) {
        const TomlMember* member = table_.find(key);
        if (!member) return;
        const auto number = table_.number(key);
        if (number && *number != std::floor(*number))
            table_.error(member->value.place, fmt::format("{} must be a whole number", key));
        if (number) add(key, fmt::format("{:.0f}", *number));
    }
    void take_seconds(const char* key) {
        if (!table_.find(key)) return;
        if (const auto number = table_.number(key)) add(key, number_text(*number) + " s");
    }
    std::vector<std::pair<std::string, std::string>> take() { return std::move(options_); }

private:
    void add(const std::string& key, const std::string& value) { options_.emplace_back("--" + key, value); }
    const TableReader& table_;
    std::vector<std::pair<std::string, std::string>> options_;
};

}  // namespace

std::vector<std::pair<std::string, std::string>> read_study(const TableReader& file) {
    const TomlMember* member = file.find("study");
    if (!member) return {};
    const TableReader table(file.context(), member->value, "study", key_table("study"));
    if (!table.is_valid()) return {};
    StudyReader reader(table);
    for (const char* key : {"vary", "correlate", "sweep", "figures"}) reader.take_texts(key);
    reader.take_text("table");
    for (const char* key : {"cases", "seed"}) reader.take_whole(key);
    for (const char* key : {"design", "command"}) reader.take_word(key);
    reader.take_seconds("limit");
    return reader.take();
}

}  // namespace dttmm::host
