// SPDX-License-Identifier: BSD-3-Clause
#include "report/gnuplot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "record/csv_file.h"
#include "record/file.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Chart chart_of(std::vector<double> y, bool is_logarithmic = false) {
    Chart chart{"time [s]", "N", {{"bolt'1 $(date) \"x\" _a^{2}\n", {}, std::move(y)}}, is_logarithmic};
    for (std::size_t i = 0; i < chart.lines[0].y.size(); ++i) chart.lines[0].x.push_back(0.25 * static_cast<double>(i));
    return chart;
}

/// The row and the column of the first star of every column that has one, from the upper left corner of the frame.
std::vector<std::pair<int, int>> stars_in(const std::string& text) {
    std::vector<std::string> rows;
    for (std::size_t at = 0, end; (end = text.find('\n', at)) != text.npos; at = end + 1)
        rows.push_back(text.substr(at, end - at));
    std::vector<std::pair<int, int>> stars;
    int first = -1;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        if (first < 0 && rows[r].find("+----") != std::string::npos) first = static_cast<int>(r);
        const std::size_t left = rows[r].find('|');
        if (first < 0 || left == std::string::npos) continue;
        for (std::size_t c = left; c < rows[r].size(); ++c)
            if (rows[r][c] == '*') stars.emplace_back(static_cast<int>(r) - first, static_cast<int>(c - left));
    }
    return stars;
}

// Oracle: a straight line from (0, 0) to (1, 8): rows of stars fall as columns rise, from one corner to the other.
TEST(Gnuplot, TextHasTheLineWhereItsNumbersAre) {
    const auto stars = stars_in(draw_text({chart_of({0, 2, 4, 6, 8})}, 80, 30));
    ASSERT_GT(stars.size(), 30u);
    double sum_r = 0, sum_c = 0, sum_rc = 0, sum_rr = 0, sum_cc = 0;
    for (const auto& [r, c] : stars) sum_r += r, sum_c += c, sum_rc += r * c, sum_rr += r * r, sum_cc += c * c;
    const auto n = static_cast<double>(stars.size());
    const double correlation =
        (n * sum_rc - sum_r * sum_c) / std::sqrt((n * sum_rr - sum_r * sum_r) * (n * sum_cc - sum_c * sum_c));
    EXPECT_LT(correlation, -0.99);
}

TEST(Gnuplot, WordsAreNoCommands) {
    const std::string text = draw_text({chart_of({1, 3, 2})}, 100, 30);
    EXPECT_THAT(text, HasSubstr("bolt'1 $(date) \"x\" _a^{2}"));
}

TEST(Gnuplot, ConstantsGapsAndNothingAreDrawnWithoutAWarning) {
    const double nan = std::nan("");
    for (const Chart& chart : {chart_of({5, 5, 5}), chart_of({0, 0}), chart_of({nan, nan}), chart_of({}),
                               chart_of({1, nan, 2}), chart_of({-1, 0, 10, 100}, true), chart_of({-1, -2}, true)}) {
        const std::string text = draw_text({chart}, 80, 25);
        EXPECT_THAT(text, HasSubstr("time [s]"));
        EXPECT_THAT(text, Not(HasSubstr("arning")));
    }
}

// Oracle: the header of PNG (RFC 2083): eight bytes, then the width and the height of the picture, big-endian.
TEST(Gnuplot, PngIsAPictureOfItsSize) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "two 'charts'.png";
    draw_png("a title", {chart_of({1, 2, 3}), chart_of({3, 2})}, path);
    const std::string png = read_whole_file(path);
    ASSERT_GT(png.size(), 1000u);
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    const auto number_at = [&](std::size_t at) {
        std::uint32_t number = 0;
        for (std::size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(png[at + i]);
        return number;
    };
    EXPECT_EQ(number_at(16), 1100u);
    EXPECT_EQ(number_at(20), 800u);
}

}  // namespace
}  // namespace dttmm::host
