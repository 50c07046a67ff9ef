// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "cli/process.h"

namespace dttmm::host {

/// Rigid floors on shear springs in one direction: stiffness k1, k2, ... [N/m], masses [kg].
inline std::string shear_frame(const std::vector<double>& masses, const std::vector<double>& stiffnesses) {
    std::string text =
        fmt::format("format = \"dttmm/1\"\ndofs = [\"x\"]\n[modes]\ncount = {}\n[parameters]\n", masses.size());
    for (size_t i = 0; i < masses.size(); ++i) text += fmt::format("k{} = \"{} N/m\"\n", i + 1, stiffnesses[i]);
    for (size_t i = 0; i < masses.size(); ++i)
        text += fmt::format("[[body]]\nname = \"floor{}\"\nmass = {}\ninertia = [1, 1, 1]\n", i + 1, masses[i]);
    for (size_t i = 0; i < masses.size(); ++i)
        text += fmt::format(
            "[[element]]\nname = \"storey{}\"\ntype = \"spring_damper\"\nfrom = \"{}\"\nto = \"floor{}\"\nstiffness = "
            "[\"=k{}\", 0, 0]\n",
            i + 1, i == 0 ? "ground" : fmt::format("floor{}", i), i + 1, i + 1);
    return text;
}

/// The plate of examples/four_bolt_plate with four bolts of their own, struck at a corner: 200 N, 4 ms.
inline std::string struck_plate(const std::string& at = "plate.corner1") {
    std::string text = R"(format = "dttmm/1"
[parameters]
k1 = "500 N/mm"
k2 = "500 N/mm"
k3 = "500 N/mm"
k4 = "500 N/mm"
c  = "0.1 N*s/mm"
idle = "3 kg"
[simulation]
duration = "0.5 s"
step = "1 ms"
[[body]]
name = "plate"
density = "7850 kg/m^3"
box = ["300 mm", "200 mm", "20 mm"]
markers = { corner1 = [0.13, 0.08, 0], corner2 = [-0.13, 0.08, 0], corner3 = [-0.13, -0.08, 0], corner4 = [0.13, -0.08, 0] }
)";
    for (int i = 1; i <= 4; ++i)
        text += fmt::format(
            "[[element]]\nname = \"bolt{0}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = "
            "\"plate.corner{0}\"\nstiffness = \"=k{0}\"\ndamping = \"=c\"\n",
            i);
    return text + fmt::format(
                      "[[load]]\non = \"{}\"\ndirection = [0, 0, 1]\nforce = {{ type = \"haversine\", peak = \"200 N\", "
                      "start = 0, width = \"4 ms\" }}\n",
                      at);
}

/// One mass on a spring to the ground, or a second one on top of it, along z, with dampers beside the springs.
struct SprungMasses {
    std::vector<double> masses, stiffnesses, dampings;  ///< kg, N/m, N s/m

    std::string model() const {
        std::string text = "format = \"dttmm/1\"\ndofs = [\"z\"]\n";
        for (size_t i = 0; i < masses.size(); ++i)
            text += fmt::format("[[body]]\nname = \"b{}\"\nmass = {}\ninertia = [1, 1, 1]\n", i, masses[i]);
        for (size_t i = 0; i < masses.size(); ++i)
            text += fmt::format(
                "[[element]]\nname = \"s{0}\"\ntype = \"spring_damper\"\nfrom = \"{1}\"\nto = \"b{0}\"\nstiffness = [0, 0, "
                "{2}]\ndamping = [0, 0, {3}]\n",
                i, i == 0 ? "ground" : "b0", stiffnesses[i], dampings[i]);
        return text;
    }

    /// Accelerations per force on b0, in closed form, 3 to 150 Hz: a CSV file with noise, its deviation as share of the
    /// largest magnitude of each.
    std::string response(size_t points, double share, unsigned seed) const {
        using Number = std::complex<double>;
        std::vector<double> frequencies;
        std::vector<std::vector<Number>> columns(masses.size());
        for (size_t p = 0; p < points; ++p) {
            const double f = 3 + 147 * static_cast<double>(p) / static_cast<double>(points - 1),
                         w = 2 * std::numbers::pi * f;
            frequencies.push_back(f);
            const Number K0(stiffnesses[0], w * dampings[0]);
            if (masses.size() == 1) {
                columns[0].push_back(-w * w / (K0 - masses[0] * w * w));
                continue;
            }
            const Number K1(stiffnesses[1], w * dampings[1]), upper = K1 - masses[1] * w * w,
                                                              det = (K0 + K1 - masses[0] * w * w) * upper - K1 * K1;
            columns[0].push_back(-w * w * upper / det);
            columns[1].push_back(-w * w * K1 / det);
        }
        std::mt19937_64 engine(seed);
        std::normal_distribution<double> normal;
        std::string names = "frequency", units = "Hz";
        for (size_t i = 0; i < columns.size(); ++i) {
            names += fmt::format(",b{0}.acceleration.z.re,b{0}.acceleration.z.im", i);
            units += ",m/s^2/N,m/s^2/N";
            double largest = 0;
            for (const Number& one : columns[i]) largest = std::max(largest, std::abs(one));
            for (Number& one : columns[i]) {
                const double re = normal(engine), im = normal(engine);
                one += share * largest * Number(re, im);
            }
        }
        std::string text = names + "\n" + units + "\n";
        for (size_t p = 0; p < points; ++p) {
            text += fmt::format("{:.17g}", frequencies[p]);
            for (const auto& column : columns) text += fmt::format(",{:.17g},{:.17g}", column[p].real(), column[p].imag());
            text += "\n";
        }
        return text;
    }
};

/// A CSV file of a run with noise: deviation as share of the largest value of all channels.
inline std::string with_noise(const std::string& history, double share, unsigned seed) {
    std::istringstream lines(history);
    std::string names, units, line;
    std::getline(lines, names);
    std::getline(lines, units);
    std::vector<std::vector<double>> rows;
    double largest = 0;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
        for (size_t c = 1; c < rows.back().size(); ++c) largest = std::max(largest, std::abs(rows.back()[c]));
    }
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal(0, share * largest);
    std::string text = names + "\n" + units + "\n";
    for (const auto& row : rows) {
        text += fmt::format("{:.17g}", row[0]);
        for (size_t c = 1; c < row.size(); ++c) text += fmt::format(",{:.17g}", row[c] + (share > 0 ? normal(engine) : 0));
        text += "\n";
    }
    return text;
}

}  // namespace dttmm::host
