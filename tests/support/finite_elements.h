// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "support/oracle.h"

namespace dttmm::test {

/// Small vibrations of frames, masses and joints by dense finite elements: an oracle for natural frequencies that shares no
/// formula with the transfer matrices. Displacements and rotations [x y z rx ry rz] of the nodes in world axes, SI units.
///
/// Beams: interdependent cubics (Friedman and Kosmatka 1993, Computers & Structures 47(3), 473–481), which are the Hermite
/// cubics without shear and give Przemieniecki's stiffness with it; linear axial displacement and twist; mass consistent.
/// Errors of a frequency: even powers of the element length, h² of bars and twist, h⁴ of bending; extrapolate() takes them
/// out.
///
/// Invalid arguments throw std::invalid_argument, a system without a solution std::runtime_error from frequencies().
class DTTMM_ORACLE FiniteElements {
public:
    using Vector2 = Eigen::Vector2d;
    using Vector3 = Eigen::Vector3d;
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Matrix3 = Eigen::Matrix3d;
    using Dofs = std::bitset<6>;  ///< bit 0 to 5: x y z rx ry rz, world axes

    static constexpr int kGround = -1;
    static constexpr double kRigid = std::numeric_limits<double>::infinity();

    /// Of a uniform beam, in its own axes: x along it, y and z principal axes of bending, through the elastic axis.
    struct Section {
        double EA = 0;                      ///< [N]
        double EIy = 0, EIz = 0;            ///< bending about y (in the plane xz) and about z (in xy) [N m²]
        double GJ = 0;                      ///< [N m²]
        double mass = 0;                    ///< per length [kg/m]
        double inertia = 0;                 ///< polar, about the elastic axis, per length [kg m]
        Vector2 mass_offset{0, 0};          ///< y, z of the mass axis [m]
        double shear_y = kRigid;            ///< κGA along y [N]; infinite: Euler-Bernoulli
        double shear_z = kRigid;            ///< κGA along z [N]
        double rotary_y = 0, rotary_z = 0;  ///< ρI about y and z through the mass axis, per length [kg m]
    };

    /// What a rod does across its axis. Both keep the rotations of its ends equal, without inertia.
    enum class Across {
        rigid_bar,  ///< its ends move as a rigid bar's, lever arm included, and its mass goes along
        unchanged,  ///< equal displacements of the ends, no lever arm, no mass: the hydroplane paper's matrix (29)
    };

    /// Every node keeps only these directions; the others are zero, and a relation of joints, links or rods in one of them
    /// is dropped. Of a beam, a rotation that belongs to a bending plane outside of them passes from end to end unchanged,
    /// without inertia. A mass keeps the velocity that the rotations give its centre. To be called before any member.
    void restrict(Dofs dofs);

    int node(const Vector3& position);

    void fix(int node, Dofs dofs);

    /// A straight beam of `count` elements. Its z axis is as near as possible to `up`: to world z unless given, to world x
    /// of a vertical beam.
    void beam(int from, int to, const Section& section, int count) { beam(from, to, section, count, default_up(from, to)); }
    void beam(int from, int to, const Section& section, int count, const Vector3& up);

    /// Axial waves only, by `count` linear elements. EA [N], mass per length [kg/m].
    void rod(int from, int to, double EA, double mass, int count, Across across = Across::rigid_bar);

    /// A rigid body on a node: its mass [kg], the vector from the node to its centre [m], the inertia tensor about the
    /// centre [kg m²], world axes.
    void mass(int node, double mass, const Vector3& center, const Matrix3& inertia);

    /// An elastic joint at the point of `to`, its stiffness [N/m, N m/rad] along and about the columns of `axes`: kRigid
    /// joins rigidly, 0 not at all. Either end may be kGround. Ends that stand apart: u_to − u_from − θ_from × (x_to −
    /// x_from).
    void joint(int from, int to, const Vector6& stiffness, const Matrix3& axes = Matrix3::Identity());

    void rigid_link(int from, int to) { joint(from, to, Vector6::Constant(kRigid)); }

    /// All natural frequencies [Hz], lowest first; those of rigid-body motion are zero but for rounding. A direction without
    /// mass has none. `near` [Hz]: where the eigenvalues are wanted most exactly.
    std::vector<double> frequencies(double near = 1) const;

private:
    using Indices = std::array<int, 6>;

    struct Element {
        std::vector<int> indices;  ///< of the coordinates, −1: held
        Eigen::MatrixXd K, M;
    };
    struct Constraint {
        std::vector<std::pair<int, double>> terms;  ///< sum of factor * coordinate = 0
    };
    struct Reduced;

    const Vector3& position(int node) const { return positions_.at(static_cast<std::size_t>(node)); }
    Vector3 default_up(int from, int to) const;
    /// Axes as columns, and the length.
    std::pair<Matrix3, double> axes(int from, int to, const Vector3& up) const;
    /// Whether a direction is one of the kept ones (first 0: translations, 3: rotations); neither nor is an error.
    bool spans(const Vector3& direction, std::size_t first) const;
    bool bends(const Vector3& deflection, const Vector3& rotation) const;

    int coordinate_count() const { return static_cast<int>(names_.size()); }
    int new_coordinate(std::string name, bool is_fixed);
    Indices coordinates(int node) const;
    void add(std::vector<int> indices, const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);
    void constrain(const std::vector<std::pair<int, Vector6>>& rows);

    /// Stiffness and mass of what fixing and the constraints leave: q = Z p, Z an orthonormal basis of what they allow.
    Reduced reduced() const;

    Dofs kept_ = Dofs().set();
    std::vector<Vector3> positions_;
    std::vector<int> node_coordinates_;  ///< first of six
    std::vector<std::string> names_;     ///< of the coordinates
    std::vector<bool> fixed_;
    std::vector<Element> elements_;
    std::vector<Constraint> constraints_;
};

/// Of the frequencies f1, f2, f4 of three meshes with n, 2n and 4n elements, the limit without the errors h² and h⁴, mode by
/// mode as sorted; what is left is O(h⁶).
DTTMM_ORACLE std::vector<double> extrapolate(const std::vector<double>& f1, const std::vector<double>& f2,
                                             const std::vector<double>& f4);

/// Of two meshes with n and 2n elements, without the error h^order.
DTTMM_ORACLE std::vector<double> extrapolate(const std::vector<double>& f1, const std::vector<double>& f2, int order);

/// frequencies(n) of meshes n, 2n and 4n, extrapolated.
DTTMM_ORACLE std::vector<double> extrapolate(const std::function<std::vector<double>(int)>& frequencies, int n);

}  // namespace dttmm::test
