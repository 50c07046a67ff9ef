// SPDX-License-Identifier: BSD-3-Clause
#include "modal/shape.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Stations of a piece that is half a wave at most.
constexpr int kStations = 8;

/// The strain energy V of a piece by the motion of its ends, local axes: uᵀ D u = 2 (V − λ T') and uᵀ (−∂D/∂λ) u = 2 T'.
/// A short piece's ends move almost as one rigid body, which strains it by what rounding makes of D and, of order λ², by
/// its own mass: that motion is taken out where it makes no more than rounding would.
Strain strain_of(const Matrix12& D, const Matrix12& lambda_M, const Vector12& ends, double length) {
    Vector12 deformed;
    deformed << Vector6::Zero(), ends.segment<3>(6) - ends.head<3>() - length * Vector3(0, ends(5), -ends(4)),
        ends.tail<3>() - ends.segment<3>(3);
    const Matrix12 B = D + lambda_M;
    const double of_ends = 0.5 * ends.dot(B * ends), of_deformed = 0.5 * deformed.dot(B * deformed);
    const double rounding = kStrainRounding * ends.cwiseAbs().dot(D.cwiseAbs() * ends.cwiseAbs());
    const double difference = std::abs(of_ends - of_deformed);
    return difference <= rounding ? Strain{of_deformed, difference} : Strain{of_ends, rounding};
}

/// [d; n] at the start of a piece, local axes.
Vector12 state_at_start(const DynamicStiffness& D, const DynamicStiffness::Piece& piece, const FrameVector& u) {
    const Vector12 ends = piece.ends(u);
    Vector12 state;
    state << ends.head<6>(), -(D.waves(piece).stiffness.topRows<6>() * ends);
    return state;
}

}  // namespace

Vector6 motion_along(const DynamicStiffness& D, const LineModel& line, const FrameVector& u, double s) {
    const auto first = D.first_piece(line);
    const double piece_length = D.piece_length(line);
    const int i = std::min(D.count(line) - 1, static_cast<int>(s / piece_length));
    const double from_start = s - i * piece_length;
    const Vector12 start = state_at_start(D, *(first + i), u);
    Vector6 local = line.waves->carry(start, D.lambda(), from_start, i * piece_length).head<6>();
    if (D.model().is_bar(line)) local.segment<3>(1) += from_start * Vector3(start(5), -start(4), 0);
    const double share = s / line.length();
    for (Eigen::Index d : {1, 2})  // straight between pins
        if (line.waves->pinned()[as_size(d)])
            local(d) = (1 - share) * first->ends(u)(d) + share * (first + D.count(line) - 1)->ends(u)(6 + d);
    return both(line.axes) * local;
}

std::vector<Vector6> strain_by_direction(const FrequencyModel& model, const FrameVector& u) {
    std::vector<Vector6> energies(model.element_count, Vector6::Zero());
    for (const Bond& bond : model.bonds) {
        if (bond.element < 0 || bond.held_node >= 0) continue;
        const Vector12 ends = bond.ends(u);
        const Vector6 d = bond.axes.transpose() * (ends.tail<6>() - ends.head<6>());
        energies[as_size(bond.element)] += 0.5 * d.cwiseProduct(bond.springs.cwiseProduct(d));
    }
    return energies;
}

/// Of what forces do as they turn, which cancels where nothing holds: share of the sum of its terms, and of the largest such
/// stiffness in the machine, for a force may be zero but for rounding of others.
/// Range 1 (at 1/20 PreloadedModes.ABodyOnABall...) to 5e5 epsilons (at 5e7 ModesAtRest.ALineUnderItsOwnWeight).
constexpr double kTurningRounding = 16 * std::numeric_limits<double>::epsilon();

std::vector<Strain> strain_energies(const DynamicStiffness& D, const FrameVector& u) {
    const FrequencyModel& model = D.model();
    std::vector<Strain> energies(model.element_count + 1);
    const auto add = [&](int element, const Strain& strain) {
        if (element < 0) element = as_int(model.element_count);
        energies[as_size(element)].energy += strain.energy;
        energies[as_size(element)].unsure += strain.unsure;
    };
    double most_turning = 0;  // [N m/rad]
    for (const Bond& bond : model.bonds)
        if (bond.turning)
            for (int end : {0, 1})
                most_turning =
                    std::max(most_turning, bond.turning->at[end][end].bottomRightCorner<3, 3>().cwiseAbs().maxCoeff());
    for (const Bond& bond : model.bonds) {
        const Vector12 ends = bond.ends(u);
        const Vector6 d = bond.axes.transpose() * (ends.tail<6>() - ends.head<6>());
        if (bond.turning) {
            const Vector6 world = ends.tail<6>() - ends.head<6>();
            double turn = 0;
            for (const int frame : {bond.from, bond.to})
                if (frame >= 0) turn += u[as_size(frame)].tail<3>().squaredNorm();
            add(bond.element, {0.5 * (world.dot(bond.stiffness * world) + bond.turning_energy(u)),
                               0.5 * kTurningRounding * (bond.turning_size(u) + most_turning * turn)});
            continue;
        }
        // In its own axes: where nothing holds there is no strain, not rounding of it
        add(bond.element, {0.5 * d.dot(bond.springs.cwiseProduct(d)), 0});
    }
    for (const FrequencyModel::Lever& lever : model.levers) {
        const Vector6& own = u[as_size(lever.frame)];
        add(lever.element, {0.5 * own.dot(lever.stiffness * own),
                            0.5 * kTurningRounding * own.cwiseAbs().dot(lever.stiffness.cwiseAbs() * own.cwiseAbs())});
    }
    for (const DynamicStiffness::Piece& piece : D.pieces()) {
        const auto& [stiffness, mass] = D.waves(piece);
        add(piece.element, strain_of(stiffness, D.lambda() * mass, piece.ends(u), D.piece_length(D.line(piece))));
    }
    return energies;
}

Eigen::MatrixXd strain_between(const DynamicStiffness& D, const std::vector<FrameVector>& shapes) {
    const auto n = as_row(shapes.size());
    Eigen::MatrixXd work = Eigen::MatrixXd::Zero(n, n);  // of the forces of one shape on the motion of another
    using Motions = Eigen::Matrix<double, 6, Eigen::Dynamic>;
    Motions at[2] = {Motions::Zero(6, n), Motions::Zero(6, n)}, deformed(6, n), forces(6, n);
    const auto gather = [&](int frame, Motions& motions) {
        for (Eigen::Index k = 0; k < n; ++k)
            motions.col(k) = frame < 0 ? Vector6(Vector6::Zero()) : shapes[as_size(k)][as_size(frame)];
    };
    const auto add = [&](const Motions& motions) { work.noalias() += motions.transpose().lazyProduct(forces); };
    for (const Bond& bond : D.model().bonds) {
        gather(bond.from, at[0]);
        gather(bond.to, at[1]);
        deformed.noalias() = bond.by_to.lazyProduct(at[1]);
        deformed.noalias() -= bond.by_from.lazyProduct(at[0]);
        if (!bond.turning) deformed = (bond.axes.transpose().lazyProduct(deformed)).eval();
        if (bond.turning)
            forces.noalias() = bond.stiffness.lazyProduct(deformed);
        else
            forces.noalias() = bond.springs.asDiagonal() * deformed;
        add(deformed);
        for (const int end : {0, 1}) {
            if (!bond.turning || (end == 0 ? bond.from : bond.to) < 0) continue;
            forces.noalias() = bond.turning->at[end][0].lazyProduct(at[0]);
            forces.noalias() += bond.turning->at[end][1].lazyProduct(at[1]);
            add(at[end]);
        }
    }
    for (const FrequencyModel::Lever& lever : D.model().levers) {
        gather(lever.frame, at[0]);
        forces.noalias() = lever.stiffness.lazyProduct(at[0]);
        add(at[0]);
    }
    Eigen::MatrixXd energy = 0.25 * (work + work.transpose());
    std::vector<Vector12> ends(shapes.size());
    for (const DynamicStiffness::Piece& piece : D.pieces()) {
        const auto& [stiffness, mass] = D.waves(piece);
        const auto energy_of = [&](const Vector12& motion) {
            return strain_of(stiffness, D.lambda() * mass, motion, D.piece_length(D.line(piece))).energy;
        };
        std::vector<double> own;
        for (size_t k = 0; k < shapes.size(); ++k) {
            ends[k] = piece.ends(shapes[k]);
            own.push_back(energy_of(ends[k]));
            energy(as_row(k), as_row(k)) += own.back();
            for (size_t i = 0; i < k; ++i) {
                const double shared = 0.5 * (energy_of(ends[k] + ends[i]) - own[k] - own[i]);
                energy(as_row(k), as_row(i)) += shared;
                energy(as_row(i), as_row(k)) += shared;
            }
        }
    }
    return energy;
}

Strain sum(const std::vector<Strain>& strains) {
    Strain all;
    for (const Strain& strain : strains) all = {all.energy + strain.energy, all.unsure + strain.unsure};
    return all;
}

double along(const DynamicStiffness& D, size_t element, const FrameVector& u, size_t count, double* shape) {
    const FrequencyModel& model = D.model();
    const auto own = [&](const LineModel& line) { return line.element == as_int(element); };
    const auto begin = std::ranges::find_if(model.lines, own), end = std::find_if_not(begin, model.lines.end(), own);
    if (begin == end) return 0;
    const auto segments = static_cast<double>(end - begin);
    for (size_t k = 0; shape && k < count; ++k) {
        const double at = count > 1 ? segments * static_cast<double>(k) / static_cast<double>(count - 1) : 0;
        const double segment = std::min(std::floor(at), segments - 1);
        const LineModel& line = *(begin + static_cast<std::ptrdiff_t>(segment));
        Eigen::Map<Vector6>{shape + 6 * k} = motion_along(D, line, u, (at - segment) * line.length());
    }
    return segments * begin->length();
}

std::vector<Station> stations(const DynamicStiffness& D, const FrameVector& u) {
    const FrequencyModel& model = D.model();
    std::vector<Station> list;
    for (size_t b = 0; b < model.centres.size(); ++b) list.push_back({model.centres[b], model.by_centre(as_int(b)) * u[b]});
    for (size_t n = 0; n < model.nodes.size(); ++n) list.push_back({model.nodes[n].position, model.node_motion(n, u)});
    std::vector<std::optional<Matrix12>> transfers(D.slot_count());  // from station to station, of equal pieces
    for (const DynamicStiffness::Piece& piece : D.pieces()) {
        const LineModel& line = D.line(piece);
        const LineWaves& waves = *line.waves;
        const double length = D.piece_length(line);
        // Pieces that an axial force makes short need fewer
        const int count =
            waves.is_graded()
                ? std::clamp(static_cast<int>(kStations * length / waves.longest_held(D.lambda())) + 1, 1, kStations)
                : kStations;
        const double step = length / count;
        std::optional<Matrix12>& to = transfers[D.slot(piece)];
        if (!waves.is_graded() && !to) to = waves.transfer(D.lambda(), step);
        Vector12 state = state_at_start(D, piece, u);
        for (int k = 1; k <= count; ++k) {
            if (waves.is_graded())
                state = waves.carry(state, D.lambda(), step, piece.index * length + (k - 1) * step);
            else
                state = (*to * state).eval();
            const double s = (piece.index * count + k) * step;
            list.push_back({line.start + s * line.axes.col(0), both(line.axes) * state.head<6>()});
        }
    }
    return list;
}

std::pair<double, double> largest(const DynamicStiffness& D, const FrameVector& u) {
    double displacement = 0, rotation = 0;
    const auto add = [&](const Vector6& motion) {
        displacement = std::max(displacement, motion.head<3>().norm());
        rotation = std::max(rotation, motion.tail<3>().norm());
    };
    for (const Vector6& motion : u) add(motion);
    for (const Station& station : stations(D, u)) add(station.motion);
    return {displacement, rotation};
}

}  // namespace dttmm::plugin
