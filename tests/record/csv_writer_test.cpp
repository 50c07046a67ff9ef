// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_writer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <thread>

#include "record/child_process.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace {

/// While set, stands in for the system's write.
std::function<ssize_t(int, const void*, std::size_t)> replaced_write;

ssize_t real_write(int descriptor, const void* data, std::size_t size) {
    return ::syscall(SYS_write, descriptor, data, size);
}

}  // namespace

extern "C" ssize_t write(int descriptor, const void* data, std::size_t size) {
    return replaced_write ? replaced_write(descriptor, data, size) : real_write(descriptor, data, size);
}

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<Column> kCsvChannels{{"time", "s"}, {"bolt1.force.x", "N"}, {"bolt1.moment.z", "N m"}};
constexpr const char* kHeader = "time,bolt1.force.x,bolt1.moment.z\ns,N,N m\n";

/// Sets the stand-in for the life of one scope.
class ReplacedWrite {
public:
    explicit ReplacedWrite(decltype(replaced_write) with) { replaced_write = std::move(with); }
    ~ReplacedWrite() { replaced_write = nullptr; }
};

std::vector<double> csv_row(int n) { return {0.001 * n, std::sin(n), -1e6 / (n + 1)}; }

std::string expected_line(int n) {
    const std::vector<double> row = csv_row(n);
    return fmt::format("{},{},{}\n", row[0], row[1], row[2]);
}

std::string expected_text(int rows) {
    std::string text = kHeader;
    for (int n = 0; n < rows; ++n) text += expected_line(n);
    return text;
}

void write_rows(const std::filesystem::path& path, int rows) {
    CsvWriter writer(path, kCsvChannels);
    for (int n = 0; n < rows; ++n) writer.write_row(csv_row(n));
    writer.finish();
}

// Oracle: the text as a person would write it.
TEST(CsvWriter, ExactText) {
    const TemporaryFolder folder;
    CsvWriter writer(folder / "history.csv", {{"time", "s"}, {"a,b", "1"}, {"say \"x\"", "N/m"}, {"плита.x", "rad/s²"}});
    writer.write_row(std::vector{0.0, 1.5, -0.0, 1e300});
    writer.write_row(std::vector{0.1, 100.0, 1e-7, -123456789.0});
    writer.finish();
    EXPECT_EQ(read_text(folder / "history.csv"),
              "time,\"a,b\",\"say \"\"x\"\"\",плита.x\n"
              "s,1,N/m,rad/s²\n"
              "0,1.5,-0,1e+300\n"
              "0.1,100,1e-07,-123456789\n");
}

// Oracle: an identity. strtod of the text gives back the same bits, for the ugly and for 2000 random bit patterns.
TEST(CsvWriter, NumbersReadBackToTheBit) {
    using Limits = std::numeric_limits<double>;
    std::vector<double> numbers{0.0,
                                -0.0,
                                0.1,
                                1.0 / 3,
                                Limits::denorm_min(),
                                Limits::min(),
                                Limits::max(),
                                -Limits::max(),
                                1e300,
                                5e-310,
                                9007199254740993.0,
                                1e22,
                                1e23,
                                2.2250738585072011e-308};
    std::mt19937_64 random(7);
    while (numbers.size() < 2000)
        if (const double number = std::bit_cast<double>(random()); std::isfinite(number)) numbers.push_back(number);

    const TemporaryFolder folder;
    CsvWriter writer(folder / "history.csv", {{"time", "s"}});
    for (const double number : numbers) writer.write_row(std::span(&number, 1));
    writer.finish();

    std::istringstream lines(read_text(folder / "history.csv"));
    std::string line;
    std::getline(lines, line);
    std::getline(lines, line);
    for (const double number : numbers) {
        ASSERT_TRUE(std::getline(lines, line));
        EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(line.c_str(), nullptr)), std::bit_cast<std::uint64_t>(number))
            << line;
    }
}

TEST(CsvWriter, HeaderIsThereAtOnceAndRowsFollowWithin100Milliseconds) {
    const TemporaryFolder folder;
    CsvWriter writer(folder / "history.csv", kCsvChannels);
    EXPECT_EQ(read_text(folder / "history.csv"), kHeader);
    writer.write_row(csv_row(0));
    std::this_thread::sleep_for(std::chrono::milliseconds(110));
    writer.write_row(csv_row(1));
    EXPECT_EQ(read_text(folder / "history.csv"), expected_text(2));
}

// Oracle: the promise of the header, watched where it matters, at the call to the system: whole rows, and a page boundary
// inside of one row at most.
TEST(CsvWriter, EveryWriteHoldsWholeRowsAndCrossesNoPageWithTwo) {
    const TemporaryFolder folder;
    std::vector<std::string> writes;
    {
        const ReplacedWrite watch([&](int descriptor, const void* data, std::size_t size) {
            writes.emplace_back(static_cast<const char*>(data), size);
            return real_write(descriptor, data, size);
        });
        write_rows(folder / "history.csv", 5000);
    }
    std::size_t start = 0;
    for (const std::string& text : writes) {
        const std::size_t end = start + text.size();
        EXPECT_EQ(text.back(), '\n');
        EXPECT_TRUE(start / 4096 == (end - 1) / 4096 || std::count(text.begin(), text.end(), '\n') == 1)
            << start << ' ' << end;
        start = end;
    }
    EXPECT_EQ(read_text(folder / "history.csv"), expected_text(5000));
}

TEST(CsvWriter, TheDestructorWritesTheRowsThatWait) {
    const TemporaryFolder folder;
    {
        CsvWriter writer(folder / "history.csv", kCsvChannels);
        for (int n = 0; n < 3; ++n) writer.write_row(csv_row(n));
    }
    EXPECT_EQ(read_text(folder / "history.csv"), expected_text(3));
}

TEST(CsvWriter, GoesOnAfterInterruptionsAndShortWrites) {
    const TemporaryFolder folder;
    int calls = 0;
    {
        const ReplacedWrite hostile([&](int descriptor, const void* data, std::size_t size) -> ssize_t {
            if (++calls % 3 == 0) {
                errno = EINTR;
                return -1;
            }
            return real_write(descriptor, data, std::min<std::size_t>(size, 7));
        });
        write_rows(folder / "history.csv", 40);
    }
    EXPECT_GT(calls, 100);
    EXPECT_EQ(read_text(folder / "history.csv"), expected_text(40));
}

// Oracle: the whole text, cut after the last line feed within the bytes that the disk took.
TEST(CsvWriter, AFailedDiskLeavesWholeRows) {
    const std::string whole = expected_text(40);
    const auto cut = [&](std::size_t bytes) { return bytes == 0 ? "" : whole.substr(0, whole.rfind('\n', bytes - 1) + 1); };
    for (const std::size_t bytes : {0UL, 1UL, 50UL, 333UL, whole.size() - 1}) {
        const TemporaryFolder folder;
        std::size_t room = bytes;
        const ReplacedWrite broken([&](int descriptor, const void* data, std::size_t size) -> ssize_t {
            errno = EIO;
            if (room == 0) return -1;
            const ssize_t count = real_write(descriptor, data, std::min(size, room));
            room -= static_cast<std::size_t>(count);
            return count;
        });
        expect_error([&] { write_rows(folder / "history.csv", 40); }, ExitCode::input_output,
                     AllOf(HasSubstr("history.csv: cannot write: Input/output error"), HasSubstr("check the disk")));
        EXPECT_EQ(read_text(folder / "history.csv"), cut(bytes)) << bytes << " bytes";
    }
}

TEST(CsvWriter, AWriteThatMakesNoProgressIsAFailureNotALoop) {
    const TemporaryFolder folder;
    const ReplacedWrite stuck([](int, const void*, std::size_t) -> ssize_t { return 0; });
    expect_error([&] { write_rows(folder / "history.csv", 1); }, ExitCode::input_output, HasSubstr("Input/output error"));
}

// Oracle: as above, with the system's own limit on the size of a file in the role of the full disk.
TEST(CsvWriter, AFullDiskLeavesWholeRowsWhereverItFills) {
    const std::string whole = expected_text(4000);
    for (int k = 0; k < 200; ++k) {
        const std::size_t bytes = static_cast<std::size_t>(k) * whole.size() / 200;
        const TemporaryFolder folder;
        EXPECT_EQ(run_in_child([&] {
                      limit_file_size(bytes);
                      write_rows(folder / "history.csv", 4000);
                  }),
                  static_cast<int>(ExitCode::input_output));
        EXPECT_EQ(read_text(folder / "history.csv"), bytes == 0 ? "" : whole.substr(0, whole.rfind('\n', bytes - 1) + 1));
    }
}

/// Writes rows for ever at the pace of a real run, 20 000 a second.
void write_until_killed(const std::filesystem::path& path) {
    CsvWriter writer(path, kCsvChannels);
    const auto start = std::chrono::steady_clock::now();
    for (int n = 0;; ++n) {
        writer.write_row(csv_row(n));
        while (std::chrono::steady_clock::now() < start + n * std::chrono::microseconds(50)) {
        }
    }
}

// Oracle: row n is a known function of n, so every byte is known. A kill may tear the last row (see the header), but so
// seldom that two in twelve are a fault.
TEST(CsvWriter, AKilledProcessLeavesWholeRows) {
    int torn = 0;
    for (int kill = 0; kill < 12; ++kill) {
        const TemporaryFolder folder;
        const pid_t child = start_child([&] { write_until_killed(folder / "history.csv"); });
        std::this_thread::sleep_for(std::chrono::milliseconds(250 + 37 * kill));
        ::kill(child, SIGKILL);
        EXPECT_EQ(wait_for(child), -SIGKILL);
        const std::string text = read_text(folder / "history.csv");
        const auto rows = static_cast<int>(std::count(text.begin(), text.end(), '\n')) - 2;
        EXPECT_GT(rows, 100);
        EXPECT_TRUE(text.starts_with(expected_text(rows)));
        torn += text.back() == '\n' ? 0 : 1;
    }
    EXPECT_LE(torn, 1);
}

}  // namespace
}  // namespace dttmm::host
