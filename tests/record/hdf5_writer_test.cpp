// SPDX-License-Identifier: BSD-3-Clause
#include "record/hdf5_writer.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <thread>

#include "record/child_process.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<Column> kHdf5Channels{{"time", "s"}, {"bolt1.force.x", "N"}, {"плита.moment.z", "N m"}};
const std::string kModelText(100'000, '#');
const Attributes kAttributes{{"title", "Four bolts"}, {"version", "0.1.0"}, {"model", kModelText.c_str()}};

std::vector<double> hdf5_row(int n) { return {0.001 * n, std::sin(n), -1e6 / (n + 1)}; }

void write_file(const std::filesystem::path& path, int rows) {
    Hdf5Writer writer(path, kHdf5Channels, kAttributes);
    for (int n = 0; n < rows; ++n) writer.write_row(hdf5_row(n));
    writer.publish();
}

std::vector<double> read_values(hid_t file, const std::string& name) {
    const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    EXPECT_EQ(H5Sget_simple_extent_ndims(space), 1);
    std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    EXPECT_GE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
    H5Sclose(space);
    H5Dclose(dataset);
    return values;
}

/// owner: the name of a dataset, or "/" for the file.
std::string read_attribute(hid_t file, const std::string& owner, const std::string& name) {
    const hid_t attribute = H5Aopen_by_name(file, owner.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8);
    char* start = nullptr;
    EXPECT_GE(H5Aread(attribute, type, &start), 0);
    const std::string text = start;
    H5free_memory(start);
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
}

void expect_rows(const std::filesystem::path& path, int rows) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    for (std::size_t i = 0; i < kHdf5Channels.size(); ++i) {
        const std::vector<double> values = read_values(file, kHdf5Channels[i].name);
        ASSERT_EQ(values.size(), static_cast<std::size_t>(rows));
        for (int n = 0; n < rows; ++n)
            ASSERT_EQ(values[static_cast<std::size_t>(n)], hdf5_row(n)[i]) << kHdf5Channels[i].name << n;
    }
    H5Fclose(file);
}

// Oracle: the numbers and texts given, read back through the HDF5 library; row counts around the 1024 of one chunk.
TEST(Hdf5Writer, ValuesReadBackToTheBit) {
    const TemporaryFolder folder;
    for (const int rows : {0, 1, 1023, 1024, 1025, 2500}) {
        write_file(folder / "history.h5", rows);
        expect_rows(folder / "history.h5", rows);
    }
}

// Oracle: the numbers given, of more channels than stay open; no row, and rows around those that wait together.
TEST(Hdf5Writer, ManyChannelsReadBack) {
    const TemporaryFolder folder;
    std::vector<Column> channels{{"time", "s"}};
    while (channels.size() < 5000) channels.push_back({"c" + std::to_string(channels.size()), "N"});
    for (const int rows : {0, 5, 900}) {
        {
            Hdf5Writer writer(folder / "many.h5", channels, kAttributes);
            std::vector<double> row(channels.size());
            for (int n = 0; n < rows; ++n) {
                for (std::size_t i = 0; i < row.size(); ++i) row[i] = n + 1e-4 * static_cast<double>(i);
                writer.write_row(row);
            }
            writer.publish();
        }
        const hid_t file = H5Fopen((folder / "many.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
        for (const std::size_t i : {std::size_t{0}, std::size_t{4095}, std::size_t{4096}, std::size_t{4999}}) {
            const std::vector<double> values = read_values(file, channels[i].name);
            ASSERT_EQ(values.size(), static_cast<std::size_t>(rows));
            for (int n = 0; n < rows; ++n) ASSERT_EQ(values[static_cast<std::size_t>(n)], n + 1e-4 * static_cast<double>(i));
            EXPECT_EQ(read_attribute(file, channels[i].name, "unit"), channels[i].unit);
        }
        H5Fclose(file);
    }
}

TEST(Hdf5Writer, UnitsAndFileAttributesReadBack) {
    const TemporaryFolder folder;
    write_file(folder / "history.h5", 5);
    const hid_t file = H5Fopen((folder / "history.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const Column& channel : kHdf5Channels) EXPECT_EQ(read_attribute(file, channel.name, "unit"), channel.unit);
    for (const auto& [name, text] : kAttributes) EXPECT_EQ(read_attribute(file, "/", name), text);
    H5Fclose(file);
}

TEST(Hdf5Writer, TheFinalNameAppearsWhenPublished) {
    const TemporaryFolder folder;
    Hdf5Writer writer(folder / "history.h5", kHdf5Channels, kAttributes);
    EXPECT_TRUE(std::filesystem::exists(folder / "history.h5.part"));
    writer.write_row(hdf5_row(0));
    EXPECT_FALSE(std::filesystem::exists(folder / "history.h5"));
    writer.publish();
    EXPECT_TRUE(std::filesystem::exists(folder / "history.h5"));
    EXPECT_FALSE(std::filesystem::exists(folder / "history.h5.part"));
}

TEST(Hdf5Writer, WithoutPublishNothingIsLeft) {
    const TemporaryFolder folder;
    {
        Hdf5Writer writer(folder / "history.h5", kHdf5Channels, kAttributes);
        for (int n = 0; n < 3000; ++n) writer.write_row(hdf5_row(n));
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Hdf5Writer, APartOfAKilledRunIsReplacedAndALinkNotFollowed) {
    const TemporaryFolder folder;
    write_text(folder / "precious", "precious");
    std::filesystem::create_symlink("precious", folder / "history.h5.part");
    write_file(folder / "history.h5", 7);
    EXPECT_EQ(read_text(folder / "precious"), "precious");
    expect_rows(folder / "history.h5", 7);
}

TEST(Hdf5Writer, AFailureNamesFileFaultAndCure) {
    const TemporaryFolder folder;
    expect_error([&] { write_file(folder / "missing/history.h5", 1); }, ExitCode::input_output,
                 AllOf(HasSubstr("missing/history.h5.part: cannot create: No such file or directory"), HasSubstr("-o")));
}

// Oracle: exit code 5 and an empty folder wherever the disk fills; HDF5 itself crashes at exit here if it is allowed to.
TEST(Hdf5Writer, AFullDiskIsAnErrorNotACrash) {
    const TemporaryFolder folder;
    write_file(folder / "whole.h5", 2500);
    const std::uintmax_t size = std::filesystem::file_size(folder / "whole.h5");
    std::filesystem::remove(folder / "whole.h5");
    for (std::uintmax_t k = 0; k < 100; ++k) {
        EXPECT_EQ(run_in_child([&] {
                      limit_file_size(k * size / 100);
                      write_file(folder / "history.h5", 2500);
                  }),
                  static_cast<int>(ExitCode::input_output))
            << k << " % of the size needed";
        EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    }
}

TEST(Hdf5Writer, AfterAFullDiskTheNextFileIsWhole) {
    const TemporaryFolder folder;
    const auto full_then_free = [&] {
        for (const rlim_t bytes : {rlim_t{0}, rlim_t{3000}, rlim_t{40'000}}) {
            limit_file_size(bytes);
            expect_error([&] { write_file(folder / "history.h5", 2500); }, ExitCode::input_output,
                         HasSubstr("File too large"));
            limit_file_size(RLIM_INFINITY);
            write_file(folder / "history.h5", 2500);
        }
        std::_Exit(testing::Test::HasFailure() ? 1 : 0);  // HDF5 loses the memory of a failed file; not our leak to report
    };
    EXPECT_EQ(run_in_child(full_then_free), 0);
    expect_rows(folder / "history.h5", 2500);
}

TEST(Hdf5Writer, WritersOfSeveralThreadsTakeTurns) {
    const TemporaryFolder folder;
    {
        const std::jthread one([&] { write_file(folder / "one.h5", 20'000); });
        const std::jthread two([&] { write_file(folder / "two.h5", 15'000); });
    }
    expect_rows(folder / "one.h5", 20'000);
    expect_rows(folder / "two.h5", 15'000);
}

}  // namespace
}  // namespace dttmm::host
