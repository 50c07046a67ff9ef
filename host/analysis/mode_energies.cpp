// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/mode_energies.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/index.h"
#include "record/csv_table.h"

namespace dttmm::host {

ModeEnergies energies_of(const Model& model, ModalMachine& machine, const ModalInstance::Mode& mode, uint32_t index) {
    using Vector6 = ModeEnergies::Vector6;
    ModeEnergies energies;
    energies.others = 1;
    for (size_t b = 0; b < model.bodies.size(); ++b) {
        const Body& body = model.bodies[b];
        const Eigen::Matrix3d R = machine.axes_of_body(b), J = R * body.inertia * R.transpose();
        Vector6 q = mode.bodies[b];
        for (int d = 0; d < 6; ++d)
            if (!model.modes.directions[as_size(d)]) q(d) = 0;
        ModeEnergies::OfBody own;
        own.world.head<3>() = body.mass * q.head<3>().cwiseAbs2();
        own.world.tail<3>() = q.tail<3>().cwiseProduct(J * q.tail<3>());
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(J);
        own.principal =
            principal.eigenvalues().cwiseProduct((principal.eigenvectors().transpose() * q.tail<3>()).cwiseAbs2());
        if (mode.numbers.mass > 0) {
            own.world /= mode.numbers.mass;
            own.principal /= mode.numbers.mass;
        }
        own.total = own.world.sum();
        energies.others -= own.total;
        energies.bodies.push_back(own);
    }
    if (std::abs(energies.others) < 1e-9) energies.others = 0;  // rounding
    energies.directions = machine.strain_directions(index);
    return energies;
}

std::string kind_of(const Model& model, const ModeEnergies& energies) {
    constexpr double kWorthAWord = 0.1, kMost = 0.5;
    const auto most = std::ranges::max_element(energies.bodies, {}, &ModeEnergies::OfBody::total);
    if (most == energies.bodies.end() || most->total < kMost) return "";
    std::vector<int> order(6);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](int d) { return std::round(1e6 * most->world(d)); });
    std::string text;
    for (const int d : order)
        if (most->world(d) >= kWorthAWord)
            text +=
                fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", direction_names()[as_size(d)], 100 * most->world(d));
    if (model.bodies.size() < 2) return text;
    return fmt::format("{}: {}", model.bodies[as_size(most - energies.bodies.begin())].name, text);
}

namespace {

/// The place and direction that move most; of a mode in which nothing is displaced, that turn most.
std::string where_most(const ModalMachine& machine, const ModalInstance::Mode& mode) {
    std::string where = "inside";
    for (const int first : {0, 3}) {
        double largest = 1e-6;
        for (const ModalPlace& place : machine.places()) {
            const ModalMachine::Vector6 u = machine.motion(place, mode);
            for (int d = first; d < first + 3; ++d) {
                if (std::abs(u(d)) <= largest * (1 + 1e-6)) continue;
                largest = std::abs(u(d));
                where = fmt::format("{}.{}", place.name, direction_names()[as_size(d)]);
            }
        }
        if (largest > 1e-6) break;
    }
    return where;
}

}  // namespace

std::string motion_in_words(const Model& model, const ModalMachine& machine, const ModalInstance::Mode& mode,
                            const ModeEnergies& energies) {
    const std::string kind = kind_of(model, energies);
    return kind.empty() ? where_most(machine, mode) : kind;
}

std::string energies_table(const Model& model, const std::vector<ModalInstance::Mode>& modes,
                           const std::vector<ModeEnergies>& energies) {
    std::vector<Column> columns = {{"mode", "1"}, {"frequency", "Hz"}, {"energy", ""}, {"of", ""}, {"share", "1"}};
    for (const char* direction : {"x", "y", "z", "rx", "ry", "rz", "r1", "r2", "r3"}) columns.push_back({direction, "1"});
    CsvTable table(columns);
    for (size_t m = 0; m < modes.size(); ++m) {
        const auto begin = [&](const char* energy, const std::string& of, double share) -> CsvTable& {
            return table.add(static_cast<double>(m + 1)).add(modes[m].numbers.frequency).add(energy).add(of).add(share);
        };
        for (size_t b = 0; b < model.bodies.size(); ++b) {
            const ModeEnergies::OfBody& own = energies[m].bodies[b];
            begin("kinetic", model.bodies[b].name, own.total).add_all(own.world).add_all(own.principal).end_row();
        }
        if (model.bodies.empty() || energies[m].others != 0) begin("kinetic", "others", energies[m].others).end_row();
        for (size_t e = 0; e < model.elements.size(); ++e) {
            begin("strain", model.elements[e].name, modes[m].shares[e]);
            if (!energies[m].directions.empty() && !energies[m].directions[e].isZero(0))
                table.add_all(energies[m].directions[e]);
            table.end_row();
        }
    }
    return table.text();
}

}  // namespace dttmm::host
