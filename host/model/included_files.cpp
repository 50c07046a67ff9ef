// SPDX-License-Identifier: BSD-3-Clause
#include "model/included_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "model/text_file.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;

/// As two names of one file agree.
fs::path identity_of(const fs::path& file) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(file, error);
    return error ? file : canonical;
}

class FileIncluder {
public:
    FileIncluder(const fs::path& file, Diagnostics& diagnostics, InputFiles& inputs)
        : diagnostics_(diagnostics), inputs_(inputs) {
        if (file != "-") seen_.emplace(identity_of(file), Place{});
    }

    /// `document` of a file in `folder`, with what it includes.
    TomlValue with_included(TomlValue document, const fs::path& folder) {
        const TomlMember* include = document.find("include");
        if (!include) return document;
        TomlValue all;
        all.place = document.place;
        if (!include->value.is_array())
            diagnostics_.error(
                include->value.place,
                fmt::format("include must be a list of files, as [\"bolts.toml\"], got {}", kind_text(include->value.kind)));
        for (const TomlValue& name : include->value.items) read_into(all, name, folder);
        for (TomlMember& member : document.members)
            if (member.key != "include") join_table(all, std::move(member));
        return all;
    }

private:
    void read_into(TomlValue& all, const TomlValue& name, const fs::path& folder) {
        const auto fail = [&](const std::string& text) { diagnostics_.error(name.place, "include: " + text); };
        if (!name.is_text() || name.string.empty()) return fail("a file is named by a text, as \"bolts.toml\"");
        if (name.string.find('\0') != std::string::npos) return fail("the name of a file holds no NUL");
        const fs::path path = folder / name.string;
        const fs::path identity = identity_of(path);
        const auto [seen, is_new] = seen_.emplace(identity, name.place);
        if (!is_new && seen->second == Place{}) return fail(fmt::format("{} is the model file itself", quote(name.string)));
        if (!is_new && open_.contains(identity))
            return fail(fmt::format("{} includes itself by way of others, on {}; leave one of the two out",
                                    quote(name.string), diagnostics_.line_text(seen->second)));
        if (!is_new) return;  // it is there
        std::string text;
        try {
            if (path == "-") throw Error(ExitCode::input_output, "the standard input cannot be included");
            text = read_text_file(path);
        } catch (const Error& error) {
            return fail(error.what());
        }
        const int number = diagnostics_.add_file(path.string());
        inputs_.folders.push_back(path.parent_path());
        inputs_.read.push_back(path);
        auto document = parse_toml(text, diagnostics_, number);
        if (!document) return;
        check_format_of(*document);
        open_.insert(identity);
        for (TomlMember& member : with_included(std::move(*document), path.parent_path()).members)
            if (member.key != "format") join_table(all, std::move(member));
        open_.erase(identity);
    }

    /// An included file need not say its format.
    void check_format_of(const TomlValue& document) {
        const std::string word = find_key(key_table("file"), "format")->words;
        const TomlMember* format = document.find("format");
        if (format && format->value.string != word)
            diagnostics_.error(format->value.place, fmt::format("this version reads format \"{}\" only", word));
    }

    /// Adds a table, or a key, of the file; what is there already is joined where that has a meaning.
    void join_table(TomlValue& all, TomlMember member) {
        const auto found = std::ranges::find(all.members, member.key, &TomlMember::key);
        if (found == all.members.end()) {
            all.members.push_back(std::move(member));
        } else if (found->value.is_array() && member.value.is_array() && member.key != "dofs") {
            std::ranges::move(member.value.items, std::back_inserter(found->value.items));
        } else if (found->value.is_table() && member.value.is_table()) {
            for (TomlMember& inner : member.value.members)
                join_member(found->value, std::move(inner), member.key == "defaults");
        } else {
            fail_twice(member, *found);
        }
    }

    void join_member(TomlValue& table, TomlMember member, bool goes_deeper) {
        const auto found = std::ranges::find(table.members, member.key, &TomlMember::key);
        if (found == table.members.end()) {
            table.members.push_back(std::move(member));
        } else if (goes_deeper && found->value.is_table() && member.value.is_table()) {
            for (TomlMember& inner : member.value.members) join_member(found->value, std::move(inner), false);
        } else {
            fail_twice(member, *found);
        }
    }

    void fail_twice(const TomlMember& member, const TomlMember& first) {
        diagnostics_.error(member.place, fmt::format("{} is given already, on {}; leave one of them out", quote(member.key),
                                                     diagnostics_.line_text(first.place)));
    }

    Diagnostics& diagnostics_;
    InputFiles& inputs_;
    std::map<fs::path, Place> seen_;  ///< with where each was included
    std::set<fs::path> open_;         ///< whose own files are being included
};

}  // namespace

void include_files(TomlValue& document, const fs::path& file, Diagnostics& diagnostics, InputFiles& inputs) {
    document = FileIncluder(file, diagnostics, inputs).with_included(std::move(document), file.parent_path());
}

}  // namespace dttmm::host
