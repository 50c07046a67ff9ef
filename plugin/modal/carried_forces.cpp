// SPDX-License-Identifier: BSD-3-Clause
#include "modal/carried_forces.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/rotation.h"

namespace dttmm::plugin {

Response Response::mixed(double factor, double other_factor, const Response& other) const {
    Response sum = *this;
    for (size_t f = 0; f < motion.size(); ++f) sum.motion[f] = factor * motion[f] + other_factor * other.motion[f];
    for (size_t r = 0; r < reactions.size(); ++r)
        sum.reactions[r] = factor * reactions[r] + other_factor * other.reactions[r];
    return sum;
}

ComplexBlock stiffness_at_rest(const Bond& bond, Complex s) {
    return Complex(1, bond.loss_factor) * complex(bond.stiffness) + s * complex(bond.damping);
}

ComplexBlock stiffness_of(const Bond& bond, double omega) {
    ComplexBlock K = stiffness_at_rest(bond, {0, omega});
    for (const auto& [direction, law] : bond.materials) {
        const Vector6 axis = bond.axes.col(direction);
        K += (law->stiffness_at(omega) - law->series().spring) * complex(axis * axis.transpose());
    }
    return K;
}

Complex6 ground_at(const FrequencyModel& model, const Joined& joined, int held_node, bool is_to, const Response& response) {
    if (response.supports.empty()) return Complex6::Zero();
    int node = held_node;
    if (node < 0 && joined.element >= 0) {
        const auto [from, to] = model.ends[as_size(joined.element)];
        node = is_to ? to : from;
    }
    if (node < 0) return Complex6::Zero();
    return complex(FrequencyModel::at_point(Vector3::Zero(), model.nodes[as_size(node)].position)) *
           response.supports[as_size(node)];
}

ElementParts::ElementParts(const DynamicStiffness& D) : of(D.model().element_count) {
    const FrequencyModel& model = D.model();
    size_t row = 0;
    for (size_t b = 0; b < model.bonds.size(); ++b) {
        const Bond& bond = model.bonds[b];
        first_row.push_back(row);
        row += bond.rigid.size();
        if (bond.element < 0 || bond.held_node >= 0) continue;
        Of& own = of[as_size(bond.element)];
        if (own.bonds++ == 0) own.bond = as_int(b);
    }
    for (size_t k = 0; k < D.pieces().size(); ++k) {
        Of& own = of[as_size(D.pieces()[k].element)];
        if (own.piece < 0) {
            own.piece = as_int(k);
            own.row = row;
        }
        row += D.pieces()[k].rigid.size();
    }
}

/// Displacement of its end at `to` against that at `from`.
Complex6 CarriedForces::relative(const Bond& bond) const {
    const auto end = [&](int frame, bool is_to) {
        return frame < 0 ? ground_at(bond, bond.held_node, is_to) : motion_of(frame);
    };
    return complex(bond.by_to) * end(bond.to, true) - complex(bond.by_from) * end(bond.from, false);
}

/// With which it holds its `to` end back, its own point, world axes.
Complex6 CarriedForces::wrench_of(const Bond& bond) const {
    Complex6 wrench = stiffness_of(bond, omega_) * relative(bond);
    size_t row = parts_.first_row[as_size(as_int(&bond - model_.bonds.data()))];
    Complex6 on_frame = Complex6::Zero();
    for (const Rigid& rigid : bond.rigid)
        on_frame += response_.reactions[row++] * (bond.to >= 0 ? rigid.by_to : Vector6(-rigid.by_from)).cast<Complex>();
    const int end = bond.to >= 0 ? 1 : 0;
    const Matrix6 by = FrequencyModel::at_point(bond.points[end], model_.origin(end == 1 ? bond.to : bond.from));
    return wrench + complex(by.transpose().inverse()) * on_frame;
}

/// The same in its own axes, which turn with its `from` end as a run has them.
Complex6 CarriedForces::own_wrench_of(const Bond& bond) const {
    const ComplexBlock to_own = complex(bond.axes.transpose());
    return to_own * wrench_of(bond) + complex(bond.spread) * (to_own * relative(bond));
}

Carried CarriedForces::of_element(size_t element) const {
    const ElementParts::Of& parts = parts_.of[element];
    if (parts.piece >= 0) return by_line(element);
    if (parts.bond < 0) return {};
    if (parts.bonds > 1) return by_chain(element);
    const Bond& bond = model_.bonds[as_size(parts.bond)];
    Carried carried{own_wrench_of(bond), complex(bond.axes.transpose()) * relative(bond)};
    carried.deflection.tail<3>() = (rotation_vector_rate(bond.turned).cast<Complex>() * carried.deflection.tail<3>()).eval();
    return carried;
}

/// Motion of an end of what is joined, in its axes.
Complex6 CarriedForces::motion_at(const Joined& joined, bool is_to) const {
    const int frame = is_to ? joined.to : joined.from;
    return complex(is_to ? joined.by_to : joined.by_from) * (frame < 0 ? ground_at(joined, -1, is_to) : motion_of(frame));
}

/// Force and moment at the `from` end.
Carried CarriedForces::by_line(size_t element) const {
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_.of[element].piece)];
    const LineModel& line = D_.line(piece);
    Eigen::Matrix<Complex, 12, 1> ends;
    ends << motion_at(piece, false), motion_at(piece, true);
    Complex6 force = held_by_line(element) - waves_[D_.slot(piece)]->topRows<6>() * ends;
    if (line.waves->pinned().any())
        for (const Pin& pin : model_.pins)
            if (pin.element == as_int(element))
                force += omega_ * omega_ / 6 * complex(pin.mass) * (2 * motion_at(pin, false) + motion_at(pin, true));
    Carried carried = between_ends(element, model_.is_at_rest ? model_.resting[element].axes : line.axes);
    carried.force = model_.is_at_rest ? turned_with_line(element, force) : force;
    return carried;
}

/// On the `from` end of a line by its first piece, local axes: in rigid directions, and of a bar by the mass that goes with
/// that end.
Complex6 CarriedForces::held_by_line(size_t element) const {
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_.of[element].piece)];
    const LineModel& line = D_.line(piece);
    Complex6 on_frame = Complex6::Zero();
    size_t row = parts_.of[element].row;
    for (const Rigid& rigid : piece.rigid)
        on_frame -= response_.reactions[row++] * (piece.from < 0 ? rigid.by_ground : rigid.by_from).cast<Complex>();
    if (model_.is_bar(line) && piece.from >= 0) {
        const double length = D_.piece_length(line);
        const Vector3 middle = line.start + 0.5 * length * line.axes.col(0);
        const Matrix6 by = both(line.axes.transpose()) * model_.masked_at(middle, model_.origin(piece.from));
        on_frame +=
            omega_ * omega_ * complex(by.transpose() * bar_mass(line.line.section, length) * by) * motion_of(piece.from);
        for (const FrequencyModel::Lever& lever : model_.levers)
            if (lever.is_bar && lever.element == as_int(element))
                on_frame -= complex(lever.stiffness) * motion_of(piece.from);
    }
    if (on_frame.isZero(0)) return on_frame;
    const Matrix6 by_from = both(line.axes.transpose()) * FrequencyModel::at_point(line.start, model_.origin(piece.from));
    return complex(by_from.transpose().inverse()) * on_frame;
}

/// The force of the waves on the `from` end of a line at rest, local axes, with what its other forces there add; in the axes
/// of that end, which turn with it. The moment of the equations does work on a rotation vector: half its turn is in it.
Complex6 CarriedForces::turned_with_line(size_t element, const Complex6& force) const {
    const FrequencyModel::RestingLine& resting = model_.resting[element];
    const DynamicStiffness::Piece& piece = D_.pieces()[as_size(parts_.of[element].piece)];
    const LineModel& line = D_.line(piece);
    Complex6 all = force;
    if (line.deviation >= 0) {
        const Bond& bond = model_.bonds[as_size(line.deviation)];
        const auto motion = [&](int frame, bool is_to) { return frame < 0 ? ground_at(bond, -1, is_to) : motion_of(frame); };
        const Complex6 on_frame = complex(bond.turning->at[0][0]) * motion(bond.from, false) +
                                  complex(bond.turning->at[0][1]) * motion(bond.to, true);
        all -= complex(bond.axes.transpose() * bond.by_from.transpose().inverse()) * on_frame;
    }
    const ComplexBlock to_end = complex(both(resting.axes.transpose() * line.axes));
    const Complex6 end = to_end * motion_at(piece, false);
    all = (to_end * all).eval();
    const Eigen::Vector3cd turn = end.tail<3>();
    all.head<3>() += skew(resting.at_from.head<3>()).cast<Complex>() * turn;
    all.tail<3>() += 0.5 * skew(resting.at_from.tail<3>()).cast<Complex>() * turn;
    return all;
}

/// Of lumps: its first joint lies a quarter of a segment behind the `from` end, and moves against it.
Carried CarriedForces::by_chain(size_t element) const {
    const Bond& first = model_.bonds[as_size(parts_.of[element].bond)];
    const Matrix3 axes = first.axes.topLeftCorner<3, 3>();
    Carried carried = between_ends(element, axes);
    carried.force = own_wrench_of(first);
    const Vector3 lever = axes.transpose() * (first.points[0] - model_.nodes[as_size(model_.ends[element].from)].position);
    const Eigen::Vector3cd force = carried.force.head<3>();
    carried.force.tail<3>() += skew(lever).cast<Complex>() * force;  // cross() of Eigen conjugates
    if (model_.is_at_rest) {
        const Complex6 way = complex(first.axes.transpose()) * relative(first);
        carried.force.tail<3>() -= skew(model_.resting[element].at_from.head<3>()).cast<Complex>() * way.head<3>();
    }
    return carried;
}

/// The motion of the `to` end as seen from the `from` end.
Carried CarriedForces::between_ends(size_t element, const Matrix3& axes) const {
    const auto [from, to] = model_.ends[element];
    const auto motion = [&](int node) {
        const int frame = model_.nodes[as_size(node)].frame;
        return frame < 0 ? (response_.supports.empty() ? Complex6(Complex6::Zero()) : response_.supports[as_size(node)])
                         : Complex6(complex(model_.by_node(as_size(node))) * response_.motion[as_size(frame)]);
    };
    const Vector3 way = model_.nodes[as_size(to)].position - model_.nodes[as_size(from)].position;
    const Complex6 seen = complex(FrequencyModel::at_point(way, Vector3::Zero())) * motion(from);
    Carried carried;
    carried.deflection = complex(both(axes.transpose())) * (motion(to) - seen);
    if (model_.is_at_rest)
        carried.deflection.tail<3>() =
            (rotation_vector_rate(model_.resting[element].turned).cast<Complex>() * carried.deflection.tail<3>()).eval();
    return carried;
}

Complex6 CarriedForces::on_first(size_t constraint) const {
    const int bond = model_.constraints[constraint];
    return bond < 0 ? Complex6(Complex6::Zero()) : wrench_of(model_.bonds[as_size(bond)]);
}

}  // namespace dttmm::plugin
