// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "modal/dynamic_stiffness.h"
#include "modal/modal_damping.h"

namespace dttmm::plugin {

/// Complex amplitudes under harmonic loads.
struct Response {
    std::vector<Complex6> motion;    ///< of all frames [m, rad]
    std::vector<Complex> reactions;  ///< in the rigid directions of bonds, then of pieces
    std::vector<Complex6> supports;  ///< motion of every node of the network in its fixed directions; empty: none moves

    /// factor * this + other_factor * other.
    Response mixed(double factor, double other_factor, const Response& other) const;
};

/// What an element carries, in its axes: see dttmm_response.h.
struct Carried {
    Complex6 force = Complex6::Zero(), deflection = Complex6::Zero();
};

using ComplexBlock = Eigen::Matrix<Complex, 6, 6>;
inline ComplexBlock complex(const Matrix6& block) { return block.cast<Complex>(); }

/// K (1 + iη) + s C of a bond, materials as at rest; and in a vibration, materials by their rows.
ComplexBlock stiffness_at_rest(const Bond& bond, Complex s);
ComplexBlock stiffness_of(const Bond& bond, double omega);

/// Motion of the ground at an end of what is joined to it, about the world's origin. held_node: of a bond that holds one.
Complex6 ground_at(const FrequencyModel& model, const Joined& joined, int held_node, bool is_to, const Response& response);

/// Where bonds and pieces of the elements stand.
struct ElementParts {
    explicit ElementParts(const DynamicStiffness& D);

    std::vector<size_t> first_row;  ///< of every bond, among the reactions
    /// Of an element: where its bonds begin and how many they are, or its first piece and where that begins among the
    /// reactions; −1: it has none.
    struct Of {
        int bond = -1, bonds = 0, piece = -1;
        size_t row = 0;
    };
    std::vector<Of> of;
};

/// What the elements of a machine carry in a harmonic response.
class CarriedForces {
public:
    /// Of every kind of lines: forces on the ends of a piece by their displacements, local axes.
    using Waves = std::vector<std::optional<LineWaves::Square<Complex>>>;
    /// Keeps all.
    CarriedForces(const DynamicStiffness& D, double omega, const Waves& waves, const ElementParts& parts,
                  const Response& response)
        : D_(D), model_(D.model()), omega_(omega), waves_(waves), parts_(parts), response_(response) {}

    Carried of_element(size_t element) const;
    /// Force and moment on the first body of a constraint at its point, world axes.
    Complex6 on_first(size_t constraint) const;

private:
    Complex6 relative(const Bond& bond) const;
    Complex6 wrench_of(const Bond& bond) const;
    Complex6 own_wrench_of(const Bond& bond) const;
    Complex6 held_by_line(size_t element) const;
    Complex6 turned_with_line(size_t element, const Complex6& end) const;
    Carried by_line(size_t element) const;
    Carried by_chain(size_t element) const;
    Carried between_ends(size_t element, const Matrix3& axes) const;
    Complex6 motion_at(const Joined& joined, bool is_to) const;
    Complex6 motion_of(int frame) const { return frame < 0 ? Complex6(Complex6::Zero()) : response_.motion[as_size(frame)]; }
    Complex6 ground_at(const Joined& joined, int held_node, bool is_to) const {
        return plugin::ground_at(model_, joined, held_node, is_to, response_);
    }

    const DynamicStiffness& D_;
    const FrequencyModel& model_;
    double omega_;
    const Waves& waves_;
    const ElementParts& parts_;
    const Response& response_;
};

}  // namespace dttmm::plugin
