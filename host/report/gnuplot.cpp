// SPDX-License-Identifier: BSD-3-Clause
#include "report/gnuplot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/program.h"
#include "model/error.h"
#include "record/atomic_file.h"

namespace dttmm::host {

namespace {

/// Colours of the light picture that draw_svg makes.
constexpr const char* kPictureColours[] = {"#0072b2", "#c04e00", "#00795a", "#a3477b", "#8a6a00", "#2a8fc9", "#5b5b5b"};

/// In gnuplot's single quotes nothing but a quote has a meaning.
std::string plot_word(const std::string& text) {
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string("''") : std::string(1, static_cast<unsigned char>(c) < ' ' ? ' ' : c);
    return word + "'";
}

bool is_drawn(const Chart& chart, double y) { return std::isfinite(y) && (!chart.is_logarithmic || y > 0); }

/// Points of a line; where it is interrupted a blank line.
std::string data_block(const Chart& chart, const ChartLine& line) {
    std::string text;
    for (std::size_t i = 0; i < line.x.size(); ++i) {
        text += is_drawn(chart, line.y[i]) ? fmt::format("{:.9g} {:.9g}\n", line.x[i], line.y[i]) : "\n";
    }
    return text;
}

/// gnuplot warns of ranges without a size; what it says would stand in the text.
std::string range_of(const Chart& chart) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const ChartLine& line : chart.lines)
        for (const double y : line.y)
            if (is_drawn(chart, y)) low = std::min(low, y), high = std::max(high, y);
    if (low > high) return "set xrange [0:1]\nset yrange [1:2]\n";
    if (low < high) return "set autoscale\n";
    const double half = low == 0 ? 1 : 0.5 * std::abs(low);
    return fmt::format("set autoscale\nset yrange [{}:{}]\n", low - half, high + half);
}

/// What draws the charts, once the terminal is set. is_coloured: in a picture.
std::string script_of(const std::vector<Chart>& charts, bool is_coloured) {
    std::string script;
    for (const Chart& chart : charts) {
        script += fmt::format("set xlabel {}\nset ylabel {}\n{}set logscale y\n{}", plot_word(chart.x_label),
                              plot_word(chart.y_label), chart.is_logarithmic ? "" : "un", range_of(chart));
        std::string plots;
        for (std::size_t i = 0; i < chart.lines.size(); ++i) {
            const std::string points = data_block(chart, chart.lines[i]);
            script += fmt::format("$line{} << END_OF_LINE\n{}END_OF_LINE\n", i, points);
            const bool is_empty = points.find_first_not_of('\n') == std::string::npos;
            plots += fmt::format("{} {} title {}", i == 0 ? "plot" : ",",
                                 is_empty ? "NaN" : fmt::format("$line{} using 1:2 with lines", i),
                                 plot_word(chart.lines[i].label));
            if (is_coloured)
                plots += fmt::format(" linewidth 2 dashtype {} linecolor rgb '{}'", i / std::size(kPictureColours) + 1,
                                     kPictureColours[i % std::size(kPictureColours)]);
        }
        script += (plots.empty() ? "plot NaN notitle" : plots) + "\n";
    }
    return script;
}

std::string run_gnuplot(const std::string& script) {
    const ProgramEnd ended = run_program({"gnuplot", "-"}, script);
    if (ended.status != 0) refuse_failed(ended, "gnuplot", "gnuplot-nox");
    return ended.output;
}

}  // namespace

void draw_png(const std::string& title, const std::vector<Chart>& charts, const std::filesystem::path& path) {
    PartFile part(path);
    run_gnuplot(
        fmt::format("set terminal pngcairo noenhanced background rgb 'white' font 'sans,11' size 1100,{}\nset output {}\n"
                    "set grid\nset key outside below horizontal\nset multiplot layout {},1 title {}\n{}unset multiplot\n"
                    "set output\n",
                    380 * charts.size() + 40, plot_word(part.path().string()), charts.size(), plot_word(title),
                    script_of(charts, true)));
    part.publish();
}

std::string draw_text(const std::vector<Chart>& charts, int columns, int rows) {
    std::string text =
        run_gnuplot(fmt::format("set terminal dumb noenhanced mono size {},{}\nset key below vertical maxcols 1\n{}",
                                columns, rows, script_of(charts, false)));
    std::erase(text, '\f');  // of a printer, between charts
    return text;
}

}  // namespace dttmm::host
