// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_model.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/error.h"
#include "element/parameters.h"
#include "modal/frequency_assembly.h"

namespace dttmm::plugin {

namespace {

/// Size of a direction that is round-off.
constexpr double kNothing = 1e-9;

}  // namespace

double dot(const FrameVector& a, const FrameVector& b) {
    double sum = 0;
    for (size_t f = 0; f < a.size(); ++f) sum += a[f].dot(b[f]);
    return sum;
}

Matrix6 both(const Matrix3& R) {
    Matrix6 twice = Matrix6::Zero();
    twice.topLeftCorner<3, 3>() = twice.bottomRightCorner<3, 3>() = R;
    return twice;
}

// ---- Joined frames ------------------------------------------------------------------------------------------------------

Vector12 Joined::ends(const FrameVector& u, const Vector6& ground) const {
    Vector12 ends;
    ends << by_from * (from < 0 ? ground : u[as_size(from)]), by_to * (to < 0 ? ground : u[as_size(to)]);
    return ends;
}

Vector6 Joined::add(const Vector12& forces, FrameVector& on_frames) const {
    Vector6 on_ground = Vector6::Zero();
    (from < 0 ? on_ground : on_frames[as_size(from)]) += by_from.transpose() * forces.head<6>();
    (to < 0 ? on_ground : on_frames[as_size(to)]) += by_to.transpose() * forces.tail<6>();
    return on_ground;
}

void Joined::hold(Vector6 row_from, Vector6 row_to) {
    const Vector6 row_ground = from < 0 ? row_from : to < 0 ? row_to : Vector6(Vector6::Zero());
    if (from < 0) row_from.setZero();
    if (to < 0) row_to.setZero();
    Vector12 rest;
    rest << row_from, row_to;
    const double size = rest.norm();
    if (!(size > kNothing)) return;
    std::vector<Vector12> basis;
    for (const Rigid& other : rigid) {
        Vector12 next;
        next << other.by_from, other.by_to;
        for (const Vector12& b : basis) next -= b.dot(next) * b;
        basis.push_back(next.normalized());
    }
    for (const Vector12& b : basis) rest -= b.dot(rest) * b;
    if (rest.norm() > kNothing * size) rigid.push_back({row_from, row_to, row_ground, as_int(rigid.size())});
}

void Bond::add_turning(const FrameVector& u, FrameVector& on_frames) const {
    const int ends[2] = {from, to};
    for (int i : {0, 1})
        for (int k : {0, 1})
            if (ends[i] >= 0 && ends[k] >= 0) on_frames[as_size(ends[i])] += turning->at[i][k] * u[as_size(ends[k])];
}

double Bond::turning_energy(const FrameVector& u) const {
    const int ends[2] = {from, to};
    double energy = 0;
    for (int i : {0, 1})
        for (int k : {0, 1})
            if (ends[i] >= 0 && ends[k] >= 0) energy += u[as_size(ends[i])].dot(turning->at[i][k] * u[as_size(ends[k])]);
    return energy;
}

double Bond::turning_size(const FrameVector& u) const {
    const int ends[2] = {from, to};
    double size = 0;
    for (int i : {0, 1})
        for (int k : {0, 1})
            if (ends[i] >= 0 && ends[k] >= 0)
                size += u[as_size(ends[i])].cwiseAbs().dot(turning->at[i][k].cwiseAbs() * u[as_size(ends[k])].cwiseAbs());
    return size;
}

// ---- The machine --------------------------------------------------------------------------------------------------------

FrequencyModel::FrequencyModel(const dttmm_modal_model& model, const AtRest* rest)
    : directions(model.directions), element_count(model.network->element_count), is_at_rest(rest) {
    if (rest && !directions.all())
        throw Error(DTTMM_ERROR_ARGUMENT, "about a machine at rest all directions are there, none is left out");
    mask.setZero();
    for (size_t d = 0; d < 6; ++d)
        if (directions[d]) mask(as_row(d), as_row(d)) = 1;
    FrequencyAssembly(*this, model, rest).run();
}

bool FrequencyModel::is_elastic() const {
    return !lines.empty() || std::ranges::any_of(bonds, [&](const Bond& bond) {
        return (mask * bond.stiffness * mask).diagonal().maxCoeff() > 0;
    }) || stiffest_turning() > 0;
}

double FrequencyModel::stiffest_turning() const {
    struct Turned {
        double stiffness = 0, mass = 0, inertia = 0, arm = 0;
    };
    std::vector<Turned> turned(frames.size());
    const auto add = [&](int frame, const Matrix6& K) {
        if (frame >= 0) turned[as_size(frame)].stiffness += K.bottomRightCorner<3, 3>().norm();
    };
    const auto hang = [&](int frame, const Vector6& row) {
        if (frame < 0 || row.head<3>().isZero(0)) return;
        double& arm = turned[as_size(frame)].arm;
        arm = std::max(arm, row.tail<3>().norm() / row.head<3>().norm());
    };
    for (const Lever& lever : levers) add(lever.frame, lever.stiffness);
    for (const Mass& mass : masses) {
        turned[as_size(mass.frame)].mass += mass.block.topLeftCorner<3, 3>().trace() / 3;
        turned[as_size(mass.frame)].inertia += mass.block.bottomRightCorner<3, 3>().trace() / 3;
    }
    for (const Bond& bond : bonds) {
        if (bond.turning) add(bond.from, bond.turning->at[0][0]);
        if (bond.turning) add(bond.to, bond.turning->at[1][1]);
        for (const Rigid& rigid : bond.rigid) {
            hang(bond.from, rigid.by_from);
            hang(bond.to, rigid.by_to);
        }
    }
    double largest = 0;
    for (const Turned& frame : turned) {
        const double inertia = frame.inertia + frame.mass * frame.arm * frame.arm;
        if (inertia > 0) largest = std::max(largest, frame.stiffness / inertia);
    }
    return largest;
}

double FrequencyModel::stiffest_hinge() const {
    double largest = 0, inertia = 0;
    for (const Bond& bond : bonds) largest = std::max(largest, turning_stiffness(bond));
    for (const Mass& mass : masses) {
        const double lever = (origin(mass.frame) - origin(masses.front().frame)).squaredNorm();
        inertia += mass.block.bottomRightCorner<3, 3>().trace() / 2 + mass.block.topLeftCorner<3, 3>().trace() / 3 * lever;
    }
    return inertia > 0 ? largest / inertia : 0;
}

double FrequencyModel::stiffest_rotor() const {
    std::vector<double> inertia(frames.size()), stiffness(frames.size());
    for (const Mass& mass : masses) inertia[as_size(mass.frame)] += mass.block.bottomRightCorner<3, 3>().trace() / 2;
    for (const Bond& bond : bonds)
        for (const int frame : {bond.from, bond.to})
            if (frame >= 0) stiffness[as_size(frame)] += turning_stiffness(bond);
    double largest = 0;
    for (size_t f = 0; f < frames.size(); ++f)
        if (inertia[f] > 0) largest = std::max(largest, stiffness[f] / inertia[f]);
    return largest;
}

double FrequencyModel::turning_of_springs(const FrameVector& u) const {
    double sum = 0;
    for (const Bond& bond : bonds)
        for (const int frame : {bond.from, bond.to}) {
            if (frame < 0) continue;
            const Vector3 turn = bond.axes.bottomRightCorner<3, 3>().transpose() * u[as_size(frame)].tail<3>();
            sum += turn.cwiseAbs2().dot(bond.springs.tail<3>());
        }
    return sum;
}

double FrequencyModel::turning_stiffness(const Bond& bond) const {
    return mask.diagonal().tail<3>().cwiseProduct(bond.stiffness.diagonal().tail<3>()).maxCoeff();
}

double FrequencyModel::force_at_start(size_t element) const {
    const auto own =
        std::ranges::find_if(bonds, [&](const Bond& bond) { return bond.element == as_int(element) && bond.tension != 0; });
    return own == bonds.end() ? 0 : own->tension;
}

Matrix6 FrequencyModel::at_point(const Vector3& point, const Vector3& origin) {
    Matrix6 by = Matrix6::Identity();
    by.topRightCorner<3, 3>() = -skew(point - origin);
    return by;
}

Matrix6 FrequencyModel::by_centre(int body) const { return at_point(centres[as_size(body)], origin(body)); }

Matrix6 FrequencyModel::by_node(size_t node) const { return masked_at(nodes[node].position, origin(nodes[node].frame)); }

Vector6 FrequencyModel::node_motion(size_t node, const FrameVector& u) const {
    const int frame = nodes[node].frame;
    return frame < 0 ? Vector6(Vector6::Zero()) : Vector6(by_node(node) * u[as_size(frame)]);
}

Matrix6 bar_mass(const Section& section, double length) {
    const double m = section.mass * length, J = m * length * length / 12;
    const double polar = is_given(section.inertia) ? section.inertia : 0;
    Matrix6 bar = Matrix6::Zero();
    bar.diagonal() << 0, m, m, polar * length, J, J;
    return bar;
}

}  // namespace dttmm::plugin
