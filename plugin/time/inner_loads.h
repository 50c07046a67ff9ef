// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "time/inside.h"

namespace dttmm::plugin {

/// The loads on what is inside a network, and what its massless frames leave over: both with their memory in Inside.
///
/// What a massless frame leaves unbalanced over a step by its own rule (MasslessFrames) its receiver takes over, a frame
/// nearby with a mass, so that no momentum is lost: force and moment about where the frame is at t_n, in the equations of
/// the motion and in the momentum alike.
class InnerLoads {
public:
    /// Keeps the inside.
    explicit InnerLoads(Inside& inside);

    /// Values of the loads at the end of the open step; none where `loads` is null.
    void read(const double* loads);
    /// Loads and elastic forces before the start, where the frames are: as they are then.
    void start_loads();
    void start_elastic();

    /// Adds the loads over the step to the wrenches on the inner frames where the step is tried to end.
    void add_over_step();
    /// Adds to those on massless frames at the end of the step, and half way; null where the frame is none of these.
    void forget_wrenches();
    double* end_wrench(int frame) { return on_massless(end_wrench_, frame); }
    double* damping_wrench(int frame) { return on_massless(damping_wrench_, frame); }
    /// Puts in place of what massless frames lack over the step (frames' axes) what they lack by their own rule; the
    /// difference goes to their receivers.
    void balance_massless(std::span<Vector6> lack);
    /// What a massless frame leaves over the step that ends with it at `end`, as its receiver takes it, world.
    Vector6 left_over(size_t inner, FrameView end) const;
    /// What of a wrench is on the massless halves of a frame.
    Vector6 massless_part(size_t inner, Vector6 wrench) const;
    /// A wrench at a massless frame as its receiver takes it, the frames being where they are given.
    Vector6 passed_on(const std::vector<Frame>& frames, size_t inner, const Vector6& left) const;

    /// Adds to the receivers' momenta what massless frames leave over the step that ends at the trial.
    void pass_momenta_on();
    /// After the step: elastic forces on massless frames where the joints' memory is; then the work of the loads, and their
    /// memory.
    void take_elastic();
    void take_step();

private:
    double* on_massless(std::vector<Vector6>& wrenches, int frame) const {
        const int m = inside_.is_inner(frame) ? inside_.massless.index_of(inside_.at(frame)) : -1;
        return m < 0 ? nullptr : wrenches[as_size(m)].data();
    }
    Vector6 load_at_end(size_t loaded, FrameView frame) const;
    Vector6 load_over_step(size_t loaded, FrameView frame) const;
    Vector6 settled(size_t massless, const Vector6& load) const;

    Inside& inside_;
    std::vector<double> values_;                        ///< at the end of the step
    std::vector<Vector6> end_wrench_, damping_wrench_;  ///< on the massless frames at the end, and half way
    std::vector<MasslessFrames::Residual> residuals_;
};

}  // namespace dttmm::plugin
