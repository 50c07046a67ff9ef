// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "model/error.h"

namespace dttmm::host {

/// `work` throws an Error with this code whose text matches.
inline void expect_error(const std::function<void()>& work, ExitCode code, const testing::Matcher<std::string>& text) {
    try {
        work();
        ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        EXPECT_THAT(std::string(error.what()), text);
    }
}

}  // namespace dttmm::host
