// SPDX-License-Identifier: BSD-3-Clause
#include "law/registry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace dttmm::plugin {
namespace {

constexpr double kPaths[][2] = {{0, 0.3}, {-0.7, 0.2}, {0.4, -1.3}, {1.1, 1.1}, {0, 0}, {0.8, 0.8 + 1e-9}};

/// Every law with ugly numbers, some negative where they may be.
std::vector<std::unique_ptr<const Law>> all_laws() {
    std::vector<std::unique_ptr<const Law>> laws;
    for (const LawType& type : law_types()) {
        for (double sign : {1, -1}) {
            std::vector<double> values;
            for (const LawParameter& parameter : type.parameters)
                values.push_back((parameter.minimum < 0 ? sign : 1) * (3.7 + 1.9 * static_cast<double>(values.size())));
            laws.push_back(type.make(values.data()));
        }
    }
    return laws;
}

// Oracle: the energy: what a force stores along a path is its mean times the change of deformation.
TEST(Laws, StoreWhatTheirMeanForceDoes) {
    for (const auto& law : all_laws()) {
        EXPECT_EQ(law->first(0).force, 0);
        EXPECT_EQ(law->first(0).stored, 0);
        for (const auto& [a, b] : kPaths) {
            const LawOnPath path = law->along({a, b});
            EXPECT_NEAR(path.mean * (b - a), path.stored - law->first(a).stored, 1e-14);
            if (a == b) {
                EXPECT_NEAR(path.mean, path.force, 1e-14);
            }
        }
    }
}

// Oracle: central differences.
TEST(Laws, HaveTheTangentsOfTheirForces) {
    for (const auto& law : all_laws()) {
        for (const auto& [a, b] : kPaths) {
            constexpr double e = 1e-5;
            const LawOnPath path = law->along({a, b}), more = law->along({a, b + e}), less = law->along({a, b - e});
            EXPECT_NEAR(path.tangent, (more.force - less.force) / (2 * e), 1e-8);
            EXPECT_NEAR(path.mean_tangent, (more.mean - less.mean) / (2 * e), 1e-8);
        }
    }
}

// Oracle: the rule itself: where the force depends on the deformation alone, the path does not matter.
TEST(Laws, DoNotDependOnThePath) {
    for (const auto& law : all_laws()) {
        EXPECT_EQ(law->along({-0.3, 0.9}).force, law->first(0.9).force);
        EXPECT_EQ(law->along({2.1, 0.9}).stored, law->first(0.9).stored);
        if (law->is_linear()) {
            EXPECT_EQ(law->first(0.9).tangent, law->first(-0.4).tangent);
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
