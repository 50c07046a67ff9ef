// SPDX-License-Identifier: BSD-3-Clause
#include "record/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr std::chrono::seconds kQuiet{1};  // shorter work shows no bar
constexpr std::chrono::milliseconds kBetweenDraws{100};
constexpr int kBarWidth = 24;
constexpr std::string_view kWipe = "\r\x1b[K";  // to the start of the line, erase to its end

std::size_t read_columns(int descriptor) {
    winsize size{};
    return ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

/// "0:07", "12:45", "3:20:00"
std::string make_duration(double seconds) {
    if (!(seconds >= 0 && seconds < 1e7)) return "?";
    const long s = std::lround(seconds);
    return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60) : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

void write_to_terminal(int descriptor, std::string_view text) {
    [[maybe_unused]] const ssize_t ignored = ::write(descriptor, text.data(), text.size());
}

}  // namespace

std::string make_progress_line(double done, double total, std::string_view unit, double elapsed) {
    const double share = total > 0 ? std::clamp(done / total, 0.0, 1.0) : 0.0;
    const int filled = static_cast<int>(share * kBarWidth);
    const std::string count = unit.empty() ? "" : fmt::format("  {:.4g}/{:.4g} {}", done, total, unit);
    return fmt::format("{:3} % [{:#<{}}{:-<{}}]{}  {} elapsed, {} left", static_cast<int>(share * 100), "", filled, "",
                       kBarWidth - filled, count, make_duration(elapsed), make_duration(elapsed * (1 - share) / share));
}

ProgressBar::ProgressBar(int descriptor)
    : descriptor_(descriptor), on_terminal_(::isatty(descriptor) == 1), next_draw_(start_ + kQuiet) {}

void ProgressBar::update(double done, double total, std::string_view unit) {
    if (!on_terminal_) return;
    const Clock::time_point now = Clock::now();
    if (now < next_draw_) return;
    const std::string line = make_progress_line(done, total, unit, std::chrono::duration<double>(now - start_).count());
    write_to_terminal(descriptor_, fmt::format("{}{}", kWipe, line.substr(0, read_columns(descriptor_) - 1)));
    next_draw_ = now + kBetweenDraws;
    drawn_ = true;
}

void ProgressBar::clear() {
    if (drawn_) write_to_terminal(descriptor_, kWipe);
    drawn_ = false;
}

}  // namespace dttmm::host
