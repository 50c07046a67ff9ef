// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "modal/inverse_iteration.h"
#include "modal/shape.h"

namespace dttmm::plugin {

/// Motions that nothing holds beside those that are held by little. D has rounding of the largest stiffness, and counts of
/// natural frequencies so slow say nothing. The strain of a shape is known better: it follows from how its ends move against
/// each other.
class SlowMotions {
public:
    explicit SlowMotions(DynamicStiffness& stiffness) : stiffness_(stiffness), inverse_(stiffness) {}

    /// What rounding makes of λ = 0 [1/s²]; after quiet() also of motions that turn what is stiff against turning.
    double rounding() const;
    /// What forces at rest leave of it, where they balance to some digits only [1/s²].
    double most_hidden() const;
    /// Where counts begin to hold [rad/s]. [after cut()]
    double quiet();
    /// They may not do so there. [after quiet()]
    bool is_noisy() const { return is_noisy_; }
    /// Motions that certainly grow, where they are too many to be looked at. [after quiet()]
    std::optional<int> grow_fast() const { return grow_fast_; }

    /// Of shapes of unit modal mass: the size of λ by their strain, beyond rounding of it, and with that.
    struct Strained {
        double surely, most;
        bool grows;  ///< one of them, surely
    };
    /// The shapes of so many motions that are strained least. Throws Error(DTTMM_ERROR_NUMERIC).
    Strained find_free(size_t count, double shift, std::vector<FrameVector>& shapes);

private:
    void find_rounding();
    int count(double omega);
    std::optional<double> look_for_noise(double base, double far);
    std::vector<Strained> look_at_slow(size_t count, double shift);
    std::optional<Strained> find_least(size_t count, size_t among, double shift, std::vector<FrameVector>& shapes);
    std::vector<Strained> iterate_slow(std::vector<FrameVector>& shapes, double shift, bool parts);
    std::vector<Strained> strain_of(const std::vector<FrameVector>& shapes) const;
    Eigen::MatrixXd masses_of(const std::vector<FrameVector>& shapes) const;
    bool part_by_strain(std::vector<FrameVector>& shapes) const;

    DynamicStiffness& stiffness_;
    InverseIteration inverse_;
    std::optional<double> quiet_;  ///< nothing: not looked at yet
    double of_turning_ = 0;        ///< rounding of springs against turning
    bool is_noisy_ = false;
    std::optional<int> grow_fast_;
    /// So many motions next to a shift were looked at to find it.
    struct {
        size_t count = 0;
        double shift = 0;
    } looked_at_;
};

}  // namespace dttmm::plugin
