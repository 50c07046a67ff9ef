// SPDX-License-Identifier: BSD-3-Clause
#include "record/recorder.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>

#include "record/child_process.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace {
std::atomic<long> allocations = 0;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<Channel> kPlateChannels{
    {"time", "s"}, {"bolt1.force.x", "N"}, {"bolt1.force.y", "N"}, {"plate.position.x", "m"}};

std::vector<double> plate_row(int n) { return {0.001 * n, std::sin(n), 1.0 / (n + 1), -2.5 * n}; }

std::vector<double> read_dataset(const std::filesystem::path& path, const char* name) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Sclose(space);
    H5Dclose(dataset);
    H5Fclose(file);
    return values;
}

// Oracle: the text by hand; HDF5 read back.
TEST(Recorder, WritesTheSelectedChannelsToBothFiles) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    Recorder recorder(folder, kPlateChannels, select_channels(kPlateChannels, {"plate", "bolt1.force.x"}),
                      {{"title", "Plate"}});
    recorder.close_row(std::vector{0.0, 1.5, 7.0, -3.0});
    recorder.close_row(std::vector{0.25, -2.5, 8.0, 4.0});
    recorder.finish();
    EXPECT_EQ(read_text(folder.file("history.csv")), "time,bolt1.force.x,plate.position.x\ns,N,m\n0,1.5,-3\n0.25,-2.5,4\n");
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "time"), (std::vector{0.0, 0.25}));
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "plate.position.x"), (std::vector{-3.0, 4.0}));
}

// Oracle: by hand. Of two equal peaks the first counts; channels that are not written are tracked all the same.
TEST(Recorder, TracksEveryChannel) {
    Recorder recorder(kPlateChannels);
    EXPECT_EQ(recorder.statistics(3).maximum, 0.0);
    recorder.close_row(std::vector{0.5, -4.0, 2.0, -1.0});
    recorder.close_row(std::vector{1.0, 3.0, -9.0, -5.0});
    recorder.close_row(std::vector{1.5, 4.0, 9.0, -2.0});
    EXPECT_EQ(recorder.rows(), 3);
    const auto expect = [&](int channel, ChannelStatistics wanted) {
        const ChannelStatistics& got = recorder.statistics(channel);
        EXPECT_EQ(got.peak, wanted.peak) << channel;
        EXPECT_EQ(got.peak_time, wanted.peak_time) << channel;
        EXPECT_EQ(got.minimum, wanted.minimum) << channel;
        EXPECT_EQ(got.maximum, wanted.maximum) << channel;
        EXPECT_EQ(got.final, wanted.final) << channel;
    };
    expect(1, {4.0, 0.5, -4.0, 4.0, 4.0});
    expect(2, {9.0, 1.0, -9.0, 9.0, 9.0});
    expect(3, {5.0, 1.0, -5.0, -1.0, -2.0});
}

// Oracle: the recorder that counts every channel; what is selected is written whether it counts or not.
TEST(Recorder, CountsTheChannelsAskedFor) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    const auto counts_of_bolt = [](const Channel& channel) {
        if (!channel.name().starts_with("bolt1")) return Recorder::Counts::nothing;
        return channel.name().ends_with("y") ? Recorder::Counts::extremes : Recorder::Counts::peak;
    };
    Recorder all(kPlateChannels), few(folder, kPlateChannels, {0, 1, 3}, {}, Recorder::Rows::plain, counts_of_bolt);
    for (int n = 0; n < 40; ++n) {
        const std::vector row{0.1 * n, std::sin(0.9 * n), n % 2 == 0 ? 3.0 : -2.5, 5.0 - n};
        all.close_row(row);
        few.close_row(row);
    }
    few.finish();
    for (const int channel : {1, 2}) {
        const ChannelStatistics wanted = all.statistics(channel), got = few.statistics(channel);
        EXPECT_EQ(got.peak, wanted.peak) << channel;
        EXPECT_EQ(got.peak_time, wanted.peak_time) << channel;
        EXPECT_EQ(got.final, wanted.final) << channel;
        EXPECT_EQ(got.ripple, wanted.ripple) << channel;
        EXPECT_EQ(got.bend, wanted.bend) << channel;
        EXPECT_EQ(got.minimum, channel == 2 ? wanted.minimum : 0) << channel;
        EXPECT_EQ(got.maximum, channel == 2 ? wanted.maximum : 0) << channel;
    }
    EXPECT_GT(few.statistics(2).ripple, 2);
    for (const int channel : {0, 3})
        expect_error([&] { few.statistics(channel); }, ExitCode::internal_error, HasSubstr("has no statistics"));
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "plate.position.x").back(), -34.0);
}

// Oracle: what alternates by A about anything smooth has the ripple A; a vibration of 20 rows has none but at its turns, a
// jump has none at all.
TEST(Recorder, TellsHowMuchAChannelAlternates) {
    Recorder recorder(kPlateChannels);
    for (int n = 0; n < 200; ++n) {
        const double t = 0.01 * n, ripple = n < 50 || n >= 150 ? 0 : n % 2 == 0 ? 3.7 : -3.7;
        recorder.close_row(std::vector{t, 40 + 2 * t + ripple, 5 * std::sin(0.1 * M_PI * n), n < 100 ? 0 : 1e3});
    }
    EXPECT_NEAR(recorder.statistics(1).ripple, 3.7, 0.02 * 3.7);
    EXPECT_LT(recorder.statistics(2).ripple, 0.01 * 5);
    EXPECT_EQ(recorder.statistics(3).ripple, 0);
}

// Oracle: of a vibration of N rows per period with a row at its crest, 2 A (1 − cos(2π/N)); of a ramp and of what is largest
// in the first row or the last, none.
TEST(Recorder, TellsTheBendOfTheRowsAtThePeak) {
    Recorder recorder(kPlateChannels);
    for (int n = 0; n < 20; ++n)
        recorder.close_row(std::vector{0.01 * n, 5 * std::exp(-0.01 * n) * std::sin(2 * M_PI * n / 8), 3.0 * n, 20.0 - n});
    EXPECT_NEAR(recorder.statistics(1).bend, 5 * std::exp(-0.02) * 2 * (1 - std::cos(2 * M_PI / 8)), 1e-2);
    EXPECT_EQ(recorder.statistics(2).bend, 0);
    EXPECT_EQ(recorder.statistics(3).bend, 0);
}

// Oracle: the text by hand; HDF5 read back; statistics of what is not selected are the other recorder's.
TEST(Recorder, EstimatesStandBesideTheirChannels) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    Recorder other(kPlateChannels);
    other.close_row(std::vector{0.0, 9.0, 7.0, 9.0});
    Recorder recorder(folder, kPlateChannels, {0, 1, 3}, {}, Recorder::Rows::estimated);
    recorder.close_selected_row(std::vector{0.0, 1.5, -3.0}, std::vector{0.0, 0.25, 0.5});
    recorder.close_selected_row(std::vector{0.25, -2.5, 4.0}, std::vector{0.0, 0.75, 0.5});
    recorder.adopt_unselected(other);
    expect_error(
        [&] {
            recorder.close_selected_row(std::vector{0.5, 1.0, 1.0}, std::vector{0.0, 1.0, std::nan("")});
        },
        ExitCode::internal_error, HasSubstr("plate.position.x"));
    recorder.finish();
    EXPECT_EQ(read_text(folder.file("history.csv")), "time,bolt1.force.x,plate.position.x\ns,N,m\n0,1.5,-3\n0.25,-2.5,4\n");
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "bolt1.force.x"), (std::vector{1.5, -2.5}));
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "bolt1.force.x.error"), (std::vector{0.25, 0.75}));
    EXPECT_EQ(read_dataset(folder.file("history.h5"), "plate.position.x.error"), (std::vector{0.5, 0.5}));
    EXPECT_EQ(recorder.statistics(1).peak, 2.5);
    EXPECT_EQ(recorder.statistics(2).peak, 7);
    EXPECT_EQ(recorder.statistics(3).final, 4);
    EXPECT_EQ(recorder.rows(), 2);
}

TEST(Recorder, RefusesWhatIsNotFiniteByName) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    {
        Recorder recorder(folder, kPlateChannels, {0, 1}, {});
        recorder.close_row(plate_row(0));
        expect_error(
            [&] {
                recorder.close_row(std::vector{0.001, 1.0, std::nan(""), 1.0});
            },
            ExitCode::internal_error, AllOf(HasSubstr("\"bolt1.force.y\" is nan"), HasSubstr("t = 0.001 s")));
        expect_error(
            [&] {
                recorder.close_row(std::vector{0.001, 1.0, 1.0, std::numeric_limits<double>::infinity()});
            },
            ExitCode::internal_error, HasSubstr("\"plate.position.x\" is inf"));
        expect_error([&] { recorder.close_row(std::vector{0.001, 1.0}); }, ExitCode::internal_error, HasSubstr("2 values"));
        EXPECT_EQ(recorder.rows(), 1);
    }
    EXPECT_EQ(read_text(folder.file("history.csv")), "time,bolt1.force.x\ns,N\n0,0\n");
    EXPECT_FALSE(std::filesystem::exists(folder.file("history.h5")));
    EXPECT_FALSE(std::filesystem::exists(folder.file("history.h5.part")));
}

TEST(Recorder, WithoutAFolderWritesNothing) {
    Recorder recorder(kPlateChannels);
    recorder.close_row(plate_row(3));
    EXPECT_NO_THROW(recorder.finish());
}

TEST(Recorder, RefusesChannelsNoFileCanStore) {
    const std::vector<Channel> channels = {{"time", "s"}, {"a/b", "m"}};
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    expect_error([&] { const Recorder recorder(folder, channels, {0, 1}, {}); }, ExitCode::internal_error, HasSubstr("a/b"));
}

// Oracle: a count of all calls of operator new in this program.
TEST(Recorder, AllocatesNothingPerRow) {
    const TemporaryFolder temporary;
    const ResultsFolder folder(temporary / "plate");
    Recorder recorder(folder, kPlateChannels, {0, 1, 3}, {});
    const std::vector<double> row = plate_row(17);
    recorder.close_row(row);
    const long before = allocations;
    for (int n = 0; n < 5000; ++n) recorder.close_row(row);
    EXPECT_EQ(allocations - before, 0);
}

// Oracle: the file of an undisturbed run; a disk filled at any size leaves a head of it made of whole rows, and no HDF5.
TEST(Recorder, AFullDiskLeavesWholeRowsAndNoFinalFile) {
    const TemporaryFolder temporary;
    const auto record = [](const std::filesystem::path& path, rlim_t bytes) {
        const ResultsFolder folder(path);
        limit_file_size(bytes);
        Recorder recorder(folder, kPlateChannels, {0, 1, 3}, {{"title", "Plate"}});
        for (int n = 0; n < 3000; ++n) recorder.close_row(plate_row(n));
        recorder.finish();
    };
    ASSERT_EQ(run_in_child([&] { record(temporary / "whole", RLIM_INFINITY); }), 0);
    const std::string whole = read_text(temporary / "whole/history.csv");
    const std::uintmax_t size =
        std::max<std::uintmax_t>(whole.size(), std::filesystem::file_size(temporary / "whole/history.h5"));
    for (std::uintmax_t k = 0; k < 50; ++k) {
        EXPECT_EQ(run_in_child([&] { record(temporary / "plate", k * size / 50); }),
                  static_cast<int>(ExitCode::input_output));
        const std::string text = read_text(temporary / "plate/history.csv");
        EXPECT_TRUE(whole.starts_with(text));
        EXPECT_TRUE(text.empty() || text.back() == '\n');
        EXPECT_FALSE(std::filesystem::exists(temporary / "plate/history.h5"));
        EXPECT_FALSE(std::filesystem::exists(temporary / "plate/history.h5.part"));
    }
}

}  // namespace
}  // namespace dttmm::host
