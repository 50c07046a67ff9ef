// SPDX-License-Identifier: BSD-3-Clause
#include "study/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "model/error.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

CaseOutcome outcome_of(double figure, int attempt = 1) { return {"completed", "", 2, {figure, std::nan("")}, attempt}; }

std::map<size_t, CaseOutcome> read_all(const std::filesystem::path& folder) {
    std::map<size_t, CaseOutcome> all;
    Journals(folder).read([&](size_t index, CaseOutcome&& outcome) { all[index] = std::move(outcome); });
    return all;
}

// Oracle: the same numbers, to the bit.
TEST(JournalOfCases, ReadsBackWhatWasNoted) {
    const TemporaryFolder folder;
    Journal journal(folder.path(), "one");
    journal.begin(6);
    journal.end(6, outcome_of(1.0 / 3));
    journal.begin(7);
    journal.end(7, {"failed", "a \"reason\"\nof two lines", 0, {}, 1});
    const auto all = read_all(folder.path());
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all.at(6).figures[0], 1.0 / 3);
    EXPECT_TRUE(std::isnan(all.at(6).figures[1]));
    EXPECT_EQ(all.at(6).warnings, 2u);
    EXPECT_EQ(all.at(7).status, "failed");
    EXPECT_EQ(all.at(7).reason, "a \"reason\"\nof two lines");
}

// A worker that is killed leaves any piece of a line, at any place of it.
TEST(JournalOfCases, APieceOfALineDoesNotCount) {
    const TemporaryFolder folder;
    {
        Journal journal(folder.path(), "one");
        journal.end(0, outcome_of(1));
        journal.end(1, outcome_of(2));
    }
    const std::string whole = read_text(folder / "one.jsonl");
    const size_t first = whole.find('\n') + 1;
    for (size_t size = 0; size < whole.size(); ++size) {
        write_text(folder / "one.jsonl", whole.substr(0, size));
        EXPECT_EQ(read_all(folder.path()).size(), size < first ? 0u : 1u) << size;
    }
}

TEST(JournalOfCases, ReadingGoesOnAndKnowsTheCaseInHand) {
    const TemporaryFolder folder;
    Journal one(folder.path(), "one"), other(folder.path(), "other");
    Journals journals(folder.path());
    size_t count = 0;
    const auto read = [&] { journals.read([&](size_t, CaseOutcome&&) { ++count; }); };
    one.begin(4);
    other.begin(9);
    other.end(9, outcome_of(1));
    read();
    EXPECT_EQ(count, 1u);
    EXPECT_EQ(journals.open_case("one"), 4u);
    EXPECT_EQ(journals.open_case("other"), std::nullopt);
    one.end(4, outcome_of(1));
    read();
    read();
    EXPECT_EQ(count, 2u);
    EXPECT_EQ(journals.open_case("one"), std::nullopt);
}

TEST(JournalOfCases, GarbageIsPassedOver) {
    const TemporaryFolder folder;
    write_text(folder / "one.jsonl",
               "garbage\n{\"end\":-3}\n[]\n{\"end\":2,\"status\":5,\"warnings\":0,\"attempt\":1,\"figures\":[]}\n\n"
               "{\"end\":3,\"status\":\"completed\",\"warnings\":0,\"attempt\":1,\"figures\":[7]}\n");
    write_text(folder / "notes.txt", "{\"end\":9,\"status\":\"completed\",\"warnings\":0,\"attempt\":1,\"figures\":[7]}\n");
    const auto all = read_all(folder.path());
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all.at(2).figures, std::vector<double>{7});
}

TEST(JournalOfCases, NobodyWritesIntoTheJournalOfAnother) {
    const TemporaryFolder folder;
    Journal journal(folder.path(), "one");
    EXPECT_THROW(Journal(folder.path(), "one"), Error);
}

TEST(JournalOfCases, WhatCompletedCountsThenTheLaterAttempt) {
    const CaseOutcome completed = outcome_of(1, 1), failed = {"failed", "", 0, {}, 2}, again = {"failed", "", 0, {}, 3};
    EXPECT_TRUE(counts_more(completed, failed));
    EXPECT_FALSE(counts_more(failed, completed));
    EXPECT_TRUE(counts_more(again, failed));
    EXPECT_FALSE(counts_more(failed, again));
}

}  // namespace
}  // namespace dttmm::host
