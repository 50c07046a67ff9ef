// SPDX-License-Identifier: BSD-3-Clause
#include "record/column.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/error_matcher.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

TEST(CheckColumns, RefusesWhatNoFileCanStore) {
    EXPECT_NO_THROW(check_columns({{"time", "s"}, {"bolt1.force.x", "N"}, {"плита.moment.z", "N m"}}));
    const auto refused = [](const std::vector<Column>& columns) {
        expect_error([&] { check_columns(columns); }, ExitCode::internal_error, HasSubstr("channel"));
    };
    refused({});
    refused({{"a", "m"}});
    refused({{"time", "s"}, {"", "m"}});
    refused({{"time", "s"}, {".", "m"}});
    refused({{"time", "s"}, {"a", "m"}, {"a", "m"}});
    refused({{"time", "s"}, {"../../a", "m"}});
    refused({{"time", "s"}, {"a\nb", "m"}});
    refused({{"time", "s"}, {"a", "m\n"}});
}

}  // namespace
}  // namespace dttmm::host
