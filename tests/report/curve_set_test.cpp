// SPDX-License-Identifier: BSD-3-Clause
#include "report/curve_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "record/temporary_folder.h"
#include "report/base64.h"

namespace dttmm::host {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Three sines that never repeat, so that no two spans are alike.
std::vector<double> uneven(std::size_t rows) {
    std::vector<double> values;
    for (std::size_t i = 0; i < rows; ++i) {
        const auto t = static_cast<double>(i);
        values.push_back(std::sin(0.7 * t) + 0.3 * std::sin(2.3 * t + 1) + 0.01 * std::sin(1e-3 * t));
    }
    return values;
}

// Oracle: the least and the largest value of every tenth of the rows, by a search of its own.
TEST(CurveSet, ThinningKeepsTheExtremesOfEverySpan) {
    const std::vector<double> values = uneven(1003);
    const std::vector<std::size_t> rows = thin(values, 20);
    ASSERT_EQ(rows.size(), 20u);
    EXPECT_TRUE(std::ranges::is_sorted(rows));
    for (std::size_t span = 0; span < 10; ++span) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(span * 1003 / 10),
                   end = values.begin() + static_cast<std::ptrdiff_t>((span + 1) * 1003 / 10);
        const auto [least, largest] = std::minmax({values[rows[2 * span]], values[rows[2 * span + 1]]});
        EXPECT_EQ(least, *std::min_element(begin, end)) << span;
        EXPECT_EQ(largest, *std::max_element(begin, end)) << span;
    }
}

TEST(CurveSet, FewRowsAreAllThere) { EXPECT_THAT(thin({3, 1, 2}, 3), ElementsAre(0, 1, 2)); }

TEST(CurveSet, PlacesOfThinnedCurvesAreThoseOfTheirSpans) {
    CurveSet set{"history.csv",
                 "",
                 {"time", "s"},
                 {},
                 {{{"a", "N"}, uneven(1000), {}}, {{"b", "N"}, std::vector<double>(1000, 4.5), {}}}};
    for (int i = 0; i < 1000; ++i) set.places.push_back(0.001 * i);
    set.curves[0].values[613] = 7;
    set.curves[0].values[21] = -9;
    const Json json = describe(set, 4);
    EXPECT_EQ(json["span"], 500);
    EXPECT_EQ(json["places"], base64_of_doubles(std::vector<double>{0, 0.001 * 250, 0.001 * 500, 0.001 * 750}));
    EXPECT_EQ(json["curves"][0]["largest"], 7);
    EXPECT_EQ(json["curves"][0]["largest_at"], 0.001 * 613);
    EXPECT_EQ(json["curves"][0]["least"], -9);
    EXPECT_EQ(json["curves"][0]["least_at"], 0.001 * 21);
    EXPECT_EQ(json["curves"][0]["last"], set.curves[0].values.back());
    EXPECT_EQ(json["curves"][1]["constant"], 4.5);
    EXPECT_FALSE(json["curves"][1].contains("values"));
}

// Oracle: 3 + 4i has magnitude 5 and phase atan2(4, 3); -2i has 2 and -90 degrees.
TEST(CurveSet, RealAndImaginaryPartAreOneCurve) {
    const TemporaryFolder folder;
    write_text(folder / "response.csv",
               "frequency,a.re,a.im,b.amplitude,b.phase,b.psd,receptance.re,receptance.im,receptance,phase\n"
               "Hz,N,N,m,deg,m^2/Hz,m/N,m/N,m/N,deg\n1,3,4,6,30,7,1,0,1,0\n2,0,-2,8,40,9,0,1,1,90\n");
    const CurveSet set = curves_of(CsvFile(folder / "response.csv"), 0, 1, {0, 1});
    ASSERT_EQ(set.curves.size(), 4u);
    EXPECT_EQ(set.curves[0].head.name, "a");
    EXPECT_THAT(set.curves[0].values, ElementsAre(5, 2));
    EXPECT_THAT(set.curves[0].phases, ElementsAre(DoubleNear(53.13010235415598, 1e-12), -90));
    EXPECT_EQ(set.curves[1].head.name, "b.amplitude");
    EXPECT_THAT(set.curves[1].phases, ElementsAre(30, 40));
    EXPECT_EQ(set.curves[2].head.name, "b.psd");
    EXPECT_THAT(set.curves[2].phases, IsEmpty());
    EXPECT_EQ(set.curves[3].head.name, "receptance");
    EXPECT_THAT(set.curves[3].phases, ElementsAre(0, DoubleNear(90, 1e-12)));
}

}  // namespace
}  // namespace dttmm::host
