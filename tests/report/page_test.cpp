// SPDX-License-Identifier: BSD-3-Clause
#include "report/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "report/assets.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, std::string_view what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++found;
    return found;
}

// Oracle: as many scripts end as without the text that would end one.
TEST(Page, NoTextOfResultsIsMarkup) {
    const std::string hostile = "</script><script>alert(1)</script><!-- & \" '";
    const std::string plain = make_page("a", {{"title", "a"}}, false),
                      page = make_page(hostile, {{"title", hostile}}, false);
    EXPECT_EQ(count(page, "</script"), count(plain, "</script"));
    EXPECT_EQ(count(page, "<script"), count(plain, "<script"));
    EXPECT_THAT(page,
                HasSubstr("<title>&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;!-- &amp; &quot; '</title>"));
}

TEST(Page, NothingComesFromElsewhere) {
    const std::string page = make_page("a", {}, true);
    EXPECT_TRUE(page.starts_with(kReportBeginning));
    EXPECT_THAT(page, HasSubstr("content=\"default-src 'none'; script-src 'sha256-"));
    EXPECT_THAT(page.substr(0, page.find("<title>")), Not(HasSubstr("unsafe")));
    for (const char* mark : {" src=\"", "<link", "@import", "url(", "{{"})
        EXPECT_EQ(count(page.substr(0, page.find("<script")), mark), 0u) << mark;
    EXPECT_LT(page.size(), 1500000u);
}

TEST(Page, TheMachineIsThereOnRequest) {
    EXPECT_THAT(make_page("a", {}, true), HasSubstr("var THREE="));
    EXPECT_THAT(make_page("a", {}, false), Not(HasSubstr("var THREE=")));
}

// Oracle: the files of the tree, and the list of hashes that was made with them.
TEST(Page, TheBundlesAreThoseOfTheTree) {
    const std::filesystem::path folder = std::filesystem::path(test::paths::source_dir()) / "host/report/assets";
    const std::string sums = read_text(folder / "SHA256SUMS");
    for (const char* name : {"uplot.js", "uplot.css", "three.js", "licences.txt"}) {
        EXPECT_EQ(report_asset(name).text, read_text(folder / name)) << name;
        EXPECT_THAT(sums, HasSubstr(std::string(report_asset(name).sha256) + "  " + name));
    }
    EXPECT_THAT(make_page("a", {}, true), HasSubstr("uplot 1.6.32\n\nThe MIT License"));
}

}  // namespace
}  // namespace dttmm::host
