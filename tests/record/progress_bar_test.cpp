// SPDX-License-Identifier: BSD-3-Clause
#include "record/progress_bar.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <limits>
#include <thread>

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

/// A terminal without a person: what is drawn on `descriptor()` can be read back.
class Terminal {
public:
    explicit Terminal(unsigned short columns) : screen_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
        ::grantpt(screen_);
        ::unlockpt(screen_);
        line_ = ::open(::ptsname(screen_), O_RDWR | O_NOCTTY);
        const winsize size{24, columns, 0, 0};
        ::ioctl(line_, TIOCSWINSZ, &size);
    }
    ~Terminal() {
        ::close(line_);
        ::close(screen_);
    }
    int descriptor() const { return line_; }
    std::string read_drawn() const {
        char text[4096];
        const ssize_t size = ::read(screen_, text, sizeof text);
        return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
    }

private:
    int screen_;
    int line_;
};

void wait(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

// Oracle: the lines as a person would write them.
TEST(ProgressLine, ShowsShareBarCountAndTimes) {
    EXPECT_EQ(make_progress_line(37, 90, "cases", 12),
              " 41 % [#########---------------]  37/90 cases  0:12 elapsed, 0:17 left");
    EXPECT_EQ(make_progress_line(0.5, 2, "s", 3600),
              " 25 % [######------------------]  0.5/2 s  1:00:00 elapsed, 3:00:00 left");
    EXPECT_EQ(make_progress_line(2, 2, "", 65), "100 % [########################]  1:05 elapsed, 0:00 left");
}

TEST(ProgressLine, KnowsWhatItDoesNotKnow) {
    EXPECT_THAT(make_progress_line(0, 90, "cases", 2), AllOf(StartsWith("  0 % [-----"), EndsWith("? left")));
    EXPECT_THAT(make_progress_line(0, 0, "", 2), StartsWith("  0 %"));
    EXPECT_THAT(make_progress_line(3, 2, "", 2), StartsWith("100 %"));
    EXPECT_THAT(make_progress_line(1e-12, 1, "", 2), EndsWith("? left"));
}

// Oracle: what a terminal received. The bar is silent for a second, draws every 0.1 s at most, and wipes its line.
TEST(ProgressBar, DrawsAfterASecondAndWipesItsLine) {
    const Terminal terminal(80);
    {
        ProgressBar bar(terminal.descriptor());
        bar.update(1, 90, "cases");
        EXPECT_EQ(terminal.read_drawn(), "");
        wait(1050);
        bar.update(45, 90, "cases");
        bar.update(46, 90, "cases");
        EXPECT_THAT(terminal.read_drawn(),
                    AllOf(StartsWith("\r\x1b[K 50 % ["), HasSubstr("45/90 cases"), EndsWith("0:01 left")));
        wait(110);
        bar.update(47, 90, "cases");
        EXPECT_THAT(terminal.read_drawn(), HasSubstr("47/90 cases"));
    }
    EXPECT_EQ(terminal.read_drawn(), "\r\x1b[K");
}

TEST(ProgressBar, StaysWithinANarrowTerminal) {
    const Terminal terminal(20);
    ProgressBar bar(terminal.descriptor());
    wait(1050);
    bar.update(45, 90, "cases");
    EXPECT_EQ(terminal.read_drawn(), "\r\x1b[K 50 % [############");  // 19 columns: the last stays free
}

TEST(ProgressBar, DrawsOnNothingElseThanATerminal) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_NONBLOCK), 0);
    {
        ProgressBar bar(ends[1]);
        ProgressBar silent(-1);
        wait(1050);
        bar.update(1, 2);
        silent.update(1, 2);
    }
    char byte = 0;
    EXPECT_EQ(::read(ends[0], &byte, 1), -1);
    ::close(ends[0]);
    ::close(ends[1]);
}

}  // namespace
}  // namespace dttmm::host
