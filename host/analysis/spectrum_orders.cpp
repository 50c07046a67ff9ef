// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/spectrum_orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/csv_table.h"

namespace dttmm::host {

namespace {

constexpr double kRadiansPerRpm = std::numbers::pi / 30;
constexpr size_t kShownOrders = 20;  // lines on the terminal

std::vector<double> parse_orders(const std::vector<std::string>& texts) {
    std::vector<double> orders;
    for (const std::string& text : split_at_commas(texts)) {
        double order = 0;
        try {
            order = parse_quantity(text, "1");
        } catch (const Error& error) {
            throw Error(ExitCode::usage, fmt::format("--orders {}: {}", quote(text), error.what()));
        }
        if (!(order > 0) || std::ranges::find(orders, order) != orders.end())
            throw Error(ExitCode::usage, fmt::format("--orders {}: orders are positive, each given once", quote(text)));
        orders.push_back(order);
    }
    return orders;
}

}  // namespace

SpectrumOrders::SpectrumOrders(const Request& request, const RecordedRun& run, const std::vector<size_t>& moving,
                               Warnings& warnings)
    : orders_(parse_orders(request.response.orders)), start_(run.start()) {
    std::vector<const std::vector<double>*> values;
    for (const size_t c : moving) {
        channels_.push_back(run.channels()[c]);
        values.push_back(&run.values()[c]);
    }
    const ShaftAngle shaft = shaft_angle(run.always(), request.spectrum.speed, run.always_unit(), run.interval());
    rows_ = track_orders(values, shaft, orders_, run.interval());
    size_t unresolved = 0;
    for (const OrderRow& row : rows_)
        unresolved += std::ranges::any_of(row.amplitudes, [](const auto& a) { return std::isnan(a.real()); });
    if (unresolved > 0)
        warnings.add(
            "order-beyond-band",
            fmt::format("{} of {} rows of orders.csv lack an order: it is faster there than 0.45 of the rate of rows, "
                        "{:g} Hz; run with a shorter --output-step",
                        unresolved, rows_.size(), 1 / run.interval()));
}

std::string SpectrumOrders::name(size_t column) const {
    return fmt::format("{}.order{:g}", channels_[column / orders_.size()].name, orders_[column % orders_.size()]);
}

SpectrumOrders::Largest SpectrumOrders::largest(size_t column) const {
    Largest largest;
    for (const OrderRow& row : rows_)
        if (std::abs(row.amplitudes[column]) > largest.amplitude) largest = {std::abs(row.amplitudes[column]), row.speed};
    return largest;
}

std::string SpectrumOrders::table() const {
    std::vector<Column> columns = {{"time", "s"}, {"rpm", "rpm"}};
    for (size_t c = 0; c < channels_.size() * orders_.size(); ++c) {
        columns.push_back({name(c) + ".amplitude", unit(c)});
        columns.push_back({name(c) + ".phase", "deg"});
    }
    CsvTable table(columns);
    for (const OrderRow& row : rows_) {
        table.add(start_ + row.time).add(row.speed / kRadiansPerRpm);
        for (const std::complex<double> value : row.amplitudes)
            table.add(std::abs(value)).add(std::arg(value) * 180 / std::numbers::pi);
        table.end_row();
    }
    return table.text();
}

void SpectrumOrders::print() const {
    const size_t columns = channels_.size() * orders_.size();
    size_t width = 16;
    for (size_t c = 0; c < std::min(columns, kShownOrders); ++c) width = std::max(width, name(c).size());
    fmt::print("{:<{}} {:>12} {:>8} {:>10}\n", "largest of order", width, "amplitude", "unit", "at [rpm]");
    for (size_t c = 0; c < std::min(columns, kShownOrders); ++c)
        fmt::print("{:<{}} {:>12.5g} {:>8} {:>10.6g}\n", name(c), width, largest(c).amplitude, unit(c),
                   largest(c).speed / kRadiansPerRpm);
    if (columns > kShownOrders) fmt::print("and {} more in summary.json\n", columns - kShownOrders);
    fmt::print("{} of orders from {:.5g} to {:.5g} rpm, over {:.3g} revolutions each\n",
               counted(rows_.size(), "row", "rows"), rows_.front().speed / kRadiansPerRpm,
               rows_.back().speed / kRadiansPerRpm, revolutions_per_block(orders_));
}

Json SpectrumOrders::describe() const {
    Json out = {{"revolutions_per_block", revolutions_per_block(orders_)}, {"rows", rows_.size()}};
    for (size_t c = 0; c < channels_.size() * orders_.size(); ++c)
        out["largest"][name(c)] = {
            {"amplitude", largest(c).amplitude}, {"unit", unit(c)}, {"rpm", largest(c).speed / kRadiansPerRpm}};
    return out;
}

}  // namespace dttmm::host
