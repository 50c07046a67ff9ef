// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_writer.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

TomlValue document_of(const std::string& text) {
    Diagnostics diagnostics("m.toml");
    const auto parsed = parse_toml(text, diagnostics);
    EXPECT_TRUE(parsed);
    return parsed.value_or(TomlValue());
}

// Oracle: the text by hand; and what is written reads back to what is written again.
TEST(TomlWriter, WritesWhatItRead) {
    const std::string text =
        "title = \"a \\\"b\\\" \\\\ \\u000A\"\nlist = [1, -2.5, 1e-30, inf, true, []]\nodd.\"key x\" = "
        "\"ü\"\n[[body]]\nname = "
        "\"p\"\nmarkers.a = { position = [0.1, 0, 3] }\nempty = {}\n[[body]]\nx = 1e300\n";
    const std::string written = write_toml(document_of(text));
    EXPECT_EQ(written,
              "title = \"a \\\"b\\\" \\\\ \\u000A\"\nlist = [1, -2.5, 1e-30, inf, true, []]\n\n[odd]\n\"key x\" = "
              "\"ü\"\n\n[[body]]\nname = \"p\"\nmarkers = { a = { position = [0.1, 0, 3] } }\nempty = {}\n\n[[body]]\nx = "
              "1e+300\n");
    EXPECT_EQ(write_toml(document_of(written)), written);
}

}  // namespace
}  // namespace dttmm::host
