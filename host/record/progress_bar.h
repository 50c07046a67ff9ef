// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace dttmm::host {

/// One line on a terminal that is rewritten in place while work goes on, for work longer than a second:
///      41 % [##########--------------]  37/90 cases  0:12 elapsed, 0:17 left
/// It is wiped by clear() or with its owner, so a message printed next stands on a clean line. One thread at a time.
class ProgressBar {
public:
    /// Draws on the open file `descriptor` (2: stderr) if that is a terminal, else on nothing; -1 is silent.
    explicit ProgressBar(int descriptor = 2);
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar() { clear(); }

    /// done of total, in any unit; `unit` ("cases", "s") shows both numbers, none shows the share alone. Reads the clock and
    /// no more, unless 0.1 s have passed since the line was drawn. Never fails.
    void update(double done, double total, std::string_view unit = {});
    void clear();

private:
    using Clock = std::chrono::steady_clock;

    int descriptor_;
    bool on_terminal_;
    bool drawn_ = false;
    Clock::time_point start_ = Clock::now();
    Clock::time_point next_draw_;
};

/// The line itself, without what rewrites it. elapsed: [s]; the time left assumes the same pace; "?" before there is one.
std::string make_progress_line(double done, double total, std::string_view unit, double elapsed);

}  // namespace dttmm::host
