// SPDX-License-Identifier: BSD-3-Clause
#include "report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "report/html_text.h"

namespace dttmm::host {

namespace {

constexpr double kWidth = 860, kLeft = 78, kRight = 18, kTop = 14, kPlotHeight = 230, kBelow = 46, kLegendRow = 19;
constexpr std::size_t kColours = 7, kDashes = 4, kLegendColumns = 3;

/// Colours that people of every colour vision tell apart (Okabe and Ito), darker on light pages.
constexpr const char* kStyle = R"(<style>
svg{color-scheme:light dark;font:12px system-ui,sans-serif;--text:#1d1f21;--faint:#dcdcd7;--c0:#0072b2;--c1:#c04e00;--c2:#00795a;--c3:#a3477b;--c4:#8a6a00;--c5:#2a8fc9;--c6:#5b5b5b}
@media(prefers-color-scheme:dark){svg{--text:#e4e4e0;--faint:#3a3d40;--c0:#62b5f0;--c1:#f0a030;--c2:#37cfa5;--c3:#e9a0cc;--c4:#efe25a;--c5:#ff8a5c;--c6:#d0d0d0}}
text{fill:var(--text)}.grid{stroke:var(--faint)}.curve{fill:none;stroke-width:1.6;stroke-linejoin:round}
)";

constexpr const char* kDash[kDashes] = {"", "9 4", "2 4", "12 4 2 4"};

/// From values to the picture along one axis.
struct Axis {
    double low, high;   ///< values, or their logarithms
    double begin, end;  ///< places in the picture
    bool is_logarithmic;
    double place(double value) const {
        const double v = is_logarithmic ? std::log10(value) : value;
        return begin + (v - low) / (high - low) * (end - begin);
    }
};

/// With some room where the values would touch the frame; a constant gets a range of its own.
Axis make_axis(double low, double high, double begin, double end, bool is_logarithmic, double room) {
    if (!(low <= high)) low = is_logarithmic ? 1 : 0, high = is_logarithmic ? 10 : 1;  // there are no values
    if (is_logarithmic) low = std::log10(low), high = std::log10(high);
    if (high - low <= 1e-12 * std::max(std::abs(low), std::abs(high))) {
        const double half = low == 0 || is_logarithmic ? 0.5 : 0.5 * std::abs(low);
        low -= half, high += half;
    }
    return {low - room * (high - low), high + room * (high - low), begin, end, is_logarithmic};
}

std::vector<double> ticks_of(const Axis& axis, int count) {
    if (!axis.is_logarithmic) return round_ticks(axis.low, axis.high, count);
    std::vector<double> ticks;
    const int first = static_cast<int>(std::ceil(axis.low)), last = static_cast<int>(std::floor(axis.high));
    const int every = std::max(1, (last - first) / count + 1);
    for (int power = first; power <= last; power += every) ticks.push_back(std::pow(10, power));
    // Within less than a decade there is no power of ten
    return ticks.size() >= 2 ? ticks : round_ticks(std::pow(10, axis.low), std::pow(10, axis.high), count);
}

std::string tick_text(double value, double step) {
    if (std::abs(value) < 1e-9 * step) return "0";
    return fmt::format("{:.6g}", value);
}

double height_of(const Chart& chart) {
    const std::size_t rows = (chart.lines.size() + kLegendColumns - 1) / kLegendColumns;
    return kTop + kPlotHeight + kBelow + kLegendRow * static_cast<double>(rows);
}

/// One chart whose upper edge is at `top`.
class Drawing {
public:
    Drawing(const Chart& chart, double top, std::string& svg) : chart_(chart), svg_(svg), bottom_(top + kTop + kPlotHeight) {
        constexpr double kInfinite = std::numeric_limits<double>::infinity();
        double x_low = kInfinite, x_high = -kInfinite, y_low = kInfinite, y_high = -kInfinite;
        for (const ChartLine& line : chart.lines)
            for (std::size_t i = 0; i < line.x.size(); ++i) {
                if (!is_shown(line.y[i])) continue;
                x_low = std::min(x_low, line.x[i]), x_high = std::max(x_high, line.x[i]);
                y_low = std::min(y_low, line.y[i]), y_high = std::max(y_high, line.y[i]);
            }
        x_ = make_axis(x_low, x_high, kLeft, kWidth - kRight, false, 0);
        y_ = make_axis(y_low, y_high, bottom_, top + kTop, chart.is_logarithmic, 0.04);
    }

    void draw() {
        draw_axes();
        for (std::size_t i = 0; i < chart_.lines.size(); ++i) {
            draw_line(i);
            draw_legend(i);
        }
    }

private:
    bool is_shown(double y) const { return std::isfinite(y) && (!chart_.is_logarithmic || y > 0); }

    void draw_axes() {
        const std::vector<double> xs = ticks_of(x_, 8), ys = ticks_of(y_, 6);
        for (const double x : xs) {
            svg_ += fmt::format("<path class=\"grid\" d=\"M{0:.2f} {1:.2f}V{2:.2f}\"/>", x_.place(x), y_.end, y_.begin);
            svg_ += fmt::format("<text class=\"x\" x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n",
                                x_.place(x), bottom_ + 17, tick_text(x, x_.high - x_.low));
        }
        for (const double y : ys) {
            svg_ += fmt::format("<path class=\"grid\" d=\"M{0:.2f} {1:.2f}H{2:.2f}\"/>", x_.begin, y_.place(y), x_.end);
            svg_ += fmt::format("<text class=\"y\" x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"end\" dy=\".35em\">{}</text>\n",
                                kLeft - 8, y_.place(y), tick_text(y, y_.high - y_.low));
        }
        svg_ += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n", (x_.begin + x_.end) / 2,
                            bottom_ + 36, html_text(chart_.x_label));
        svg_ += fmt::format("<text transform=\"translate(16 {:.2f})rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                            (y_.begin + y_.end) / 2, html_text(chart_.y_label));
    }

    std::string stroke(std::size_t i) const {
        const char* const dash = kDash[i / kColours % kDashes];
        return fmt::format("stroke=\"var(--c{})\"{}", i % kColours,
                           *dash ? fmt::format(" stroke-dasharray=\"{}\"", dash) : "");
    }

    void draw_line(std::size_t i) {
        const ChartLine& line = chart_.lines[i];
        svg_ += fmt::format("<path class=\"curve\" {} d=\"", stroke(i));
        bool is_open = false;
        for (std::size_t k = 0; k < line.x.size(); ++k) {
            const bool was_open = std::exchange(is_open, is_shown(line.y[k]));
            if (is_open)
                svg_ += fmt::format("{}{:.2f} {:.2f}", was_open ? 'L' : 'M', x_.place(line.x[k]), y_.place(line.y[k]));
        }
        svg_ += "\"/>\n";
    }

    void draw_legend(std::size_t i) {
        const double x = kLeft +
                         static_cast<double>(i % kLegendColumns) * (kWidth - kLeft) / static_cast<double>(kLegendColumns),
                     y = bottom_ + 56 + kLegendRow * static_cast<double>(i / kLegendColumns);
        svg_ += fmt::format("<path {} stroke-width=\"3\" d=\"M{:.2f} {:.2f}h26\"/>", stroke(i), x, y - 4);
        svg_ += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n", x + 33, y, html_text(chart_.lines[i].label));
    }

    const Chart& chart_;
    std::string& svg_;
    double bottom_;
    Axis x_{}, y_{};
};

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
    const double raw = (high - low) / count, power = std::pow(10, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double factor : {5., 2., 1.})
        if (factor * power >= raw * (1 - 1e-9)) step = factor * power;
    std::vector<double> ticks;
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push_back(k * step);
    return ticks;
}

std::string draw_svg(const std::string& title, const std::vector<Chart>& charts) {
    double height = 8;
    for (const Chart& chart : charts) height += height_of(chart);
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\">\n"
        "<title>{2}</title>\n{3}</style>\n",
        kWidth, height, html_text(title), kStyle);
    double top = 0;
    for (const Chart& chart : charts) {
        Drawing(chart, top, svg).draw();
        top += height_of(chart);
    }
    return svg + "</svg>\n";
}

}  // namespace dttmm::host
