// SPDX-License-Identifier: BSD-3-Clause
#include "model/expanded_file.h"

#include <fmt/format.h>

#include "model/cut_lines.h"
#include "model/element_defaults.h"
#include "model/included_files.h"
#include "model/names.h"
#include "model/patterns.h"
#include "model/text_file.h"
#include "model/toml_writer.h"
#include "model/tree_places.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

std::string format_word() { return find_key(key_table("file"), "format")->words; }

/// Whether the rest of the file can be judged: it is of the format this version reads, or forgets to say so. Reports where
/// it is not of that format.
bool check_format(const TomlValue& document, Diagnostics& diagnostics) {
    const TomlMember* format = document.find("format");
    if (!format) {
        diagnostics.error({1, 1}, fmt::format("no format key; begin the file with: format = \"{}\"", format_word()));
        return !document.members.empty();
    }
    if (format->value.is_text() && format->value.string == format_word()) return true;
    const std::string got =
        format->value.is_text() ? quote(format->value.string) : std::string(kind_text(format->value.kind));
    diagnostics.error(format->value.place, fmt::format("this version reads format \"{}\" only, got {}", format_word(), got));
    return false;
}

}  // namespace

ExpandedFile::ExpandedFile(std::string_view text, const std::filesystem::path& file, const ElementCatalogue& catalogue,
                           const ModelOverrides& overrides)
    : diagnostics(file == "-" ? "<standard input>" : file.string()), instant(overrides.instant) {
    auto parsed = parse_toml(text, diagnostics);
    if (!parsed || !check_format(*parsed, diagnostics)) diagnostics.throw_if_errors();
    document = std::move(*parsed);
    inputs.folders = {file.parent_path()};
    include_files(document, file, diagnostics, inputs);
    expand_parameters(document);
    const auto table = [&](const char* key) {
        const TomlMember* member = document.find(key);
        return member ? &member->value : nullptr;
    };
    parameters.emplace(table("parameters"), table("stations"), overrides.parameters, diagnostics);
    const ReadContext reading = context();
    expand_patterns(document, reading, catalogue,
                    [&](TomlValue& repeated) { apply_defaults(repeated, reading, catalogue); });
    apply_element_defaults(document, reading, catalogue);
    probes = cut_lines(document, reading, catalogue);
}

std::string write_expanded(const std::filesystem::path& file, const ElementCatalogue& catalogue,
                           const ModelOverrides& overrides) {
    ExpandedFile expanded(read_text_file(file), file, catalogue, overrides);
    expanded.diagnostics.throw_if_errors();
    const auto members = [&](const char* key) -> std::vector<TomlMember>& {
        return member_of(expanded.document, key, TomlValue::Kind::table).members;
    };
    for (const auto& [name, text] : overrides.parameters) {
        for (TomlMember& member : members("parameters"))
            if (normalise_name(member.key) == normalise_name(name)) member.value = text_value(text, member.place);
        if (!expanded.document.find("stations")) continue;
        for (TomlMember& member : members("stations"))
            for (std::size_t d = 0; d < 3; ++d)
                if (normalise_name(member.key) + "." + "xyz"[d] == normalise_name(name))
                    member.value.items[d] = text_value(text, member.place);
    }
    return write_toml(expanded.document);
}

}  // namespace dttmm::host
