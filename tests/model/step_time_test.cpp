// SPDX-License-Identifier: BSD-3-Clause
#include "model/step_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace dttmm::host {
namespace {

// Oracle: the decimal number itself, as the library reads it from a file.
TEST(StepTime, IsTheNumberThatAFileHas) {
    int off = 0;
    for (const char* step : {"0.01", "1e-3", "2.5e-4", "6.25e-5", "1e-6", "3e-7"}) {
        const double h = std::stod(step);
        for (int hundredths = 1; hundredths < 2000; ++hundredths) {
            const double time =
                std::stod(std::to_string(hundredths / 100) + "." + std::to_string(100 + hundredths % 100).substr(1));
            const double steps = std::round(time / h);
            if (std::abs(steps * h / time - 1) > 1e-12) continue;  // not a whole number
            EXPECT_EQ(time_after(static_cast<uint64_t>(steps), h), time) << step;
            off += steps * h != time;
        }
    }
    EXPECT_GT(off, 500);  // by so many the product alone differs
}

// A step that is no decimal number: rounding, and no more.
TEST(StepTime, IsTheProductToRounding) {
    EXPECT_EQ(time_after(0, 0.01), 0);
    for (const double h : {1. / 3, 1e-3 / 7, 1e-9, 2.3e-11, 1e-5 * M_PI}) {
        double before = 0;
        for (uint64_t n = 1; n < 1'000'000'000'000; n = n * 3 + 1) {
            const double time = time_after(n, h);
            EXPECT_NEAR(time, static_cast<double>(n) * h, 6e-15 * time);
            EXPECT_GT(time, before);
            before = time;
        }
    }
}

}  // namespace
}  // namespace dttmm::host
