// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "modal/shape.h"

namespace dttmm::plugin {

/// A natural frequency and its shape.
struct Mode {
    double omega = 0;  ///< [rad/s]; 0: a rigid-body mode
    /// Relative: the count changes by the multiplicity between ω (1 − bracket) and ω (1 + bracket), and the strain energy of
    /// the shape makes no more of ω² than that much more or less.
    double bracket = 0;
    int multiplicity = 1;
    double residual = 0;  ///< |uᵀ D(ω²) u| over ω² × modal mass, twice the kinetic energy
    /// Modal, of the shape as scaled: largest displacement 1 m [kg]; of one that only turns, rotation 1 rad [kg m²].
    double mass = 0;
    FrameVector shape;                        ///< of the frames
    Vector6 participation = Vector6::Zero();  ///< share of the mass or inertia moved as a whole in each direction
    double cut = 0;                           ///< [rad/s] for which the lines were cut when the shape was found
};

/// Finds natural frequencies in order and proves that none is missing: the count separates them, inverse iteration on the
/// shapes of a group (so that multiple ones come whole) refines them, and the count on both sides of each confirms it.
/// Source: Wittrick and Williams (1971), Q. J. Mech. Appl. Math. 24; inverse iteration with the derivative of the dynamic
/// stiffness: Yuan, Ye, Williams and Kennedy (2003), Int. J. Numer. Meth. Eng. 56.
///
/// Shapes of equal frequencies are a basis of what vibrates at that frequency, and any mixture would do. The one listed does
/// not depend on how it was found: the first shape moves one point in one direction as far as a unit of modal mass can, that
/// point and direction where this is farthest; the next does the same among the motions at right angles to the first by
/// mass, and so on. Rigid-body modes begin with the translations in x, y, z and the turns about them. Where points tie, x
/// comes before y before z, then the smaller coordinate. The sign is that of a positive displacement there.
///
/// Short pieces of a line are stiff, and their rounding stands beside ω²: every frequency is found with the lines cut for it
/// alone. Where the machine itself is a long chain of short elements rounding keeps the bracket wide, which is then told.
class ModeFinder {
public:
    explicit ModeFinder(DynamicStiffness& stiffness) : stiffness_(stiffness) {}

    /// All up to `below` [rad/s]. Throws Error(DTTMM_ERROR_NUMERIC) where the count cannot be made out or rounding hides
    /// frequencies that low, and what DynamicStiffness::cut() throws.
    std::vector<Mode> find_below(double below);
    /// The first `count`, and what is equal to the last of them; all if there are fewer.
    std::vector<Mode> find_first(int count);
    /// The number of rigid-body modes.
    int count_rigid();

private:
    struct Interval {
        double low, high;   ///< [rad/s]
        int before, until;  ///< counts at its ends
    };
    /// Approximations of equal or nearly equal frequencies.
    struct Cluster {
        std::vector<double> lambdas;
        std::vector<FrameVector> shapes;
        int cuts = 0;  ///< of the model when the shapes were found
    };

    void cut_for(double omega);
    double rounding() const;
    double lowest_for(double below) const;
    int count_at(double& omega);
    void find_rigid(int count);
    void separate(Interval interval);
    bool refine(const Interval& interval);
    bool converge(Cluster& cluster, double tolerance);
    bool settle(Cluster& cluster);
    bool confirm(const Cluster& cluster, int before, double& bracket);
    double lost_in_rounding(const Cluster& cluster) const;
    std::vector<double> iterate(std::vector<FrameVector>& shapes, double lambda, int rounds);
    void add(Cluster cluster, double bracket);
    void fix_basis(std::vector<FrameVector>& shapes, bool is_rigid) const;
    FrameVector random_motion();
    std::vector<Mode> finish();

    DynamicStiffness& stiffness_;
    std::vector<Mode> modes_;
    double lowest_ = 0;  ///< below lie rigid-body modes only [rad/s]
    double cut_ = 0;     ///< [rad/s] for which the lines are cut
    uint64_t seed_ = 1;
};

}  // namespace dttmm::plugin
