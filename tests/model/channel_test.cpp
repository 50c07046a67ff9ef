// SPDX-License-Identifier: BSD-3-Clause
#include "model/channel.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <tuple>
#include <vector>

namespace dttmm::host {
namespace {

using Of = Channel::Of;

TEST(Channel, IsNamedByWhatItIs) {
    const Channel whole = Channel(Of::marker, "plate.tip", "velocity", "x", "m/s");
    EXPECT_EQ(whole.name(), "plate.tip.velocity.x");
    EXPECT_EQ(whole.owner(), "plate.tip");
    EXPECT_EQ(whole.quantity(), "velocity");
    EXPECT_EQ(whole.axis(), "x");
    EXPECT_EQ(whole.without_axis(), "plate.tip.velocity");
    EXPECT_EQ(whole.name_in_owner(), "velocity.x");
    const Channel scalar = Channel(Of::energy, "energy", "residual", "", "J");
    EXPECT_EQ(scalar.name(), "energy.residual");
    EXPECT_EQ(scalar.quantity(), "residual");
    EXPECT_EQ(scalar.name_in_owner(), "residual");
    EXPECT_EQ(scalar.axis(), "");
    const Channel nobody{"time", "s"};
    EXPECT_EQ(nobody.name(), "time");
    EXPECT_EQ(nobody.owner(), "");
    EXPECT_EQ(nobody.axis(), "");
}

// Threads make channels of the same owners, and of owners of their own, and read them meanwhile.
TEST(Channel, ThreadsShareTheTexts) {
    constexpr int kOwners = 3000;
    std::vector<std::vector<Channel>> made(4);
    std::vector<std::thread> threads;
    for (size_t t = 0; t < made.size(); ++t)
        threads.emplace_back([&made, t] {
            for (int i = 0; i < kOwners; ++i) {
                const std::string shared = "bolt" + std::to_string(i), own = "own" + std::to_string(t) + shared;
                made[t].emplace_back(Of::element, shared, "force", "x", "N");
                made[t].emplace_back(Of::body, own, "quantity" + std::to_string(i % 100 + 100 * static_cast<int>(t)), "",
                                     "1", false);
                for (const size_t back : {size_t{0}, made[t].size() / 2}) (void)made[t][back].name();
            }
        });
    for (std::thread& thread : threads) thread.join();
    for (size_t t = 0; t < made.size(); ++t)
        for (int i = 0; i < kOwners; ++i) {
            const Channel &shared = made[t][2 * static_cast<size_t>(i)], &own = made[t][2 * static_cast<size_t>(i) + 1];
            ASSERT_EQ(shared.name(), "bolt" + std::to_string(i) + ".force.x");
            ASSERT_EQ(&shared.owner(), &made[0][2 * static_cast<size_t>(i)].owner());
            ASSERT_TRUE(shared.by_default());
            ASSERT_EQ(own.owner(), "own" + std::to_string(t) + shared.owner());
            ASSERT_EQ(own.quantity(), "quantity" + std::to_string(i % 100 + 100 * static_cast<int>(t)));
            ASSERT_FALSE(own.by_default());
        }
}

// What differs in one thing alone is another channel.
TEST(Channel, KindsDifferInAnything) {
    const Channel first(Of::element, "a", "force", "x", "N"), others[] = {{Of::node, "a", "force", "x", "N"},
                                                                          {Of::element, "a", "force", "y", "N"},
                                                                          {Of::element, "a", "moment", "x", "N"},
                                                                          {Of::element, "a", "force", "x", "kN"},
                                                                          {Of::element, "a", "force", "x", "N", false}};
    const auto all = [](const Channel& c) { return std::tuple(c.of(), c.quantity(), c.axis(), c.unit(), c.by_default()); };
    for (const Channel& other : others) EXPECT_NE(all(first), all(other));
    EXPECT_EQ(all(first), all(Channel(Of::element, "b", "force", "x", "N")));
}

// Of one name are those that differ in what is no part of it: unit and default.
TEST(Channel, DuplicatesAreThoseOfOneName) {
    const Channel first(Of::element, "a", "force", "x", "N");
    const std::vector<Channel> others = {{Of::node, "a", "force", "x", "N"},
                                         {Of::element, "b", "force", "x", "N"},
                                         {Of::element, "a", "moment", "x", "N"},
                                         {Of::element, "a", "force", "y", "N"}};
    std::vector<Channel> all = others;
    all.push_back(first);
    EXPECT_FALSE(Channel::have_duplicates(all));
    EXPECT_FALSE(Channel::have_duplicates({}));
    for (const Channel& same :
         {first, Channel(Of::element, "a", "force", "x", "kN"), Channel(Of::element, "a", "force", "x", "N", false)}) {
        std::vector<Channel> more = all;
        more.insert(more.begin() + 2, same);
        EXPECT_TRUE(Channel::have_duplicates(more)) << same.unit();
    }
}

}  // namespace
}  // namespace dttmm::host
