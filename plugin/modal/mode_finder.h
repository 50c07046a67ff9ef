// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "modal/inverse_iteration.h"
#include "modal/shape.h"
#include "modal/slow_motions.h"

namespace dttmm::plugin {

/// A natural frequency and its shape.
struct Mode {
    double omega = 0;  ///< [rad/s]; 0: a rigid-body mode; negative: it grows as exp(|ω| t)
    /// Relative: the count changes by the multiplicity between ω (1 − bracket) and ω (1 + bracket), and the strain energy of
    /// the shape makes no more of ω² than that much more or less. Of ω = 0: how fast it may vibrate or grow [Hz].
    double bracket = 0;
    int multiplicity = 1;
    double residual = 0;  ///< |uᵀ D(ω²) u| over ω² × modal mass, twice the kinetic energy
    /// Modal, of the shape as scaled: largest displacement 1 m [kg]; of one that only turns, rotation 1 rad [kg m²].
    double mass = 0;
    FrameVector shape;                        ///< of the frames
    std::vector<double> shares;               ///< of its strain energy, by element; zero of a rigid-body mode
    Vector6 participation = Vector6::Zero();  ///< share of the mass or inertia moved as a whole in each direction
    double cut = 0;                           ///< [rad/s] for which the lines were cut when the shape was found
};

/// Finds natural frequencies in order and proves that none is missing: the count separates them, inverse iteration on the
/// shapes of a group (so that multiple ones come whole) refines them, and the count on both sides of each confirms it.
/// Source: Wittrick and Williams (1971), Q. J. Mech. Appl. Math. 24; inverse iteration with the derivative of the dynamic
/// stiffness: Yuan, Ye, Williams and Kennedy (2003), Int. J. Numer. Meth. Eng. 56. Shapes of equal frequencies are those of
/// fix_basis().
///
/// Short pieces of a line are stiff, and their rounding stands beside ω²: every frequency is found with the lines cut for it
/// alone. Where the machine itself is a long chain of short elements rounding keeps the bracket wide, which is then told.
class ModeFinder {
public:
    explicit ModeFinder(DynamicStiffness& stiffness) : stiffness_(stiffness), inverse_(stiffness), slow_(stiffness) {}

    /// All up to `below` [rad/s]. Throws Error(DTTMM_ERROR_NUMERIC) where the count cannot be made out or rounding hides
    /// frequencies that low, and what DynamicStiffness::cut() throws.
    std::vector<Mode> find_below(double below);
    /// The first `count`, and what is equal to the last of them; all if there are fewer.
    std::vector<Mode> find_first(int count);
    /// The number of motions that grow; slack as in dttmm_modal.h.
    int count_growing(int slack);
    /// Throws Error(DTTMM_ERROR_MODEL) where motions grow.
    void refuse_growing();
    /// The number of motions that nothing holds, or so little that rounding hides it.
    int count_free();
    /// The same with the motions that grow.
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
        int cuts;  ///< of the lines when the shapes were found
    };

    void refuse(int growing) const;
    int count_growth(int slack);
    void refuse_noise(const char* what, int growing) const;
    std::string of_load() const;
    double lowest_for(double below);
    double first_trial() const;
    double fastest_mass() const;
    int count_at(double omega);
    void find_until(double below, size_t wanted);
    void find_rigid(int count, double lowest);
    void find_growing(double lowest);
    void find_between(size_t wanted);
    std::optional<int> count_beside(double lambda);
    std::vector<double> approach(std::vector<FrameVector>& shapes, double lambda);
    bool refine(const Interval& interval);
    std::vector<Cluster> approximate(const Interval& interval);
    bool prove(Cluster& near, int& before);
    bool converge(Cluster& cluster);
    Cluster take_equal(Cluster& near) const;
    double confirm(const Cluster& cluster, int before);
    void split(const Interval& interval);
    void add(Cluster cluster, double bracket);
    Mode describe(FrameVector shape, double lambda) const;
    bool part_from_others(Cluster& equal) const;
    void find_participation(std::span<Mode> modes);

    DynamicStiffness& stiffness_;
    InverseIteration inverse_;
    SlowMotions slow_;
    std::vector<Mode> modes_;       ///< found so far, in order
    std::map<double, int> counts_;  ///< of natural frequencies below ω [rad/s], as far as they are known
    int growing_ = 0;               ///< motions that grow
    /// Of λ: −1 while those that grow are looked for, ω² being −λ and all counts those of smaller ω.
    double sign_ = 1;
};

}  // namespace dttmm::plugin
