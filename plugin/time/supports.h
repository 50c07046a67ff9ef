// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/index.h"
#include "dttmm_plugin.h"
#include "dttmm_support.h"
#include "mechanism/frame.h"

namespace dttmm::plugin {

/// The fixed nodes of a description that the host moves. Each becomes a body of its own behind those of the host: a node
/// with all directions fixed is a point of it, another hangs on it by its fixed directions. Networks then see no more than
/// bodies whose motion is given. The body turns with the rotation vector of the support: of a node with some directions
/// fixed, these turn with it.
class Supports {
public:
    explicit Supports(const dttmm_network& description);

    bool empty() const { return nodes_.empty(); }
    size_t count() const { return nodes_.size(); }
    /// The description with these bodies; valid as long as the one given and this object.
    const dttmm_network& description() const { return description_; }
    /// Of a node: the body of its support; −1: it has none.
    int body_of(uint32_t node) const;

    void move_to(const dttmm_support_motion* motions);

    // In time. `out`: one per support
    void start();          ///< where they are to be, as they move there
    void start_at_rest();  ///< where the statics have led
    void begin_step(double h);
    void commit_step();
    void write_start(std::span<dttmm_motion> out) const;  ///< velocities of the instant
    void write_end(std::span<dttmm_motion> out) const;    ///< of the open step; velocities over it
    /// At the start of the step last committed. Velocities: the means of those over the two steps around it.
    void write_instant(std::span<dttmm_motion> out) const;
    /// At the start, 6 each.
    void write_accelerations(double* out) const;
    /// Adds their work by the mean wrenches on them over the step last committed, 6 each; and what of these are forces of
    /// rigid directions, which stand at its start: their mean over a step is known one step later.
    void add_work(const double* wrenches, const double* rigid);
    /// Up to the start of the step last committed [J].
    double work() const { return record_.work; }

    // At rest: one iteration takes them to where they are to be. Their rotation vectors go there straight, so that full
    // turns count.
    void begin_statics();
    void keep_statics() { rest_kept_ = rest_at_; }
    void recall_statics() { rest_at_ = rest_kept_; }
    void form_statics() { rest_base_ = rest_at_; }
    /// The small motion from where the equations were formed, 6 each; the largest turn of it, or none if nothing moves.
    std::optional<double> write_change(double* out) const;
    void move_statics(double share);
    void write_at_rest(std::span<dttmm_motion> out) const;

    /// Shows the memory of what changes from step to step, as spans.
    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit) {
        if (self.empty()) return;
        visit(std::span(self.at_));
        visit(std::span(self.before_));
        visit(std::span(self.over_));
        visit(std::span(self.over_before_));
        visit(std::span(self.first_));
        visit(std::span(self.rigid_));
        visit(std::span(&self.record_, 1));
    }

private:
    /// From the place described: displacement, and rotation vector of any size.
    struct Way {
        Vector3 shift = Vector3::Zero(), turn = Vector3::Zero();
    };
    Way wanted(size_t support) const;
    Frame at_end(size_t support, const Way& way) const;
    Frame target(size_t support) const { return at_end(support, wanted(support)); }

    std::vector<uint32_t> nodes_;
    std::vector<dttmm_body> bodies_;
    std::vector<dttmm_node> all_nodes_;
    dttmm_network description_;

    std::vector<dttmm_support_motion> wanted_;
    std::vector<Frame> rest_;                           ///< as described
    std::vector<Frame> at_, before_;                    ///< at t_n, t_{n−1}
    std::vector<Frame> end_;                            ///< of the open step
    std::vector<Way> rest_at_, rest_base_, rest_kept_;  ///< in statics: now, where the equations were formed, kept
    std::vector<Twist> over_, over_before_;             ///< velocities over the last step, and over the one before
    std::vector<Twist> open_;                           ///< over the open step
    std::vector<dttmm_support_motion> first_;           ///< as they move at the start
    std::vector<Vector6> rigid_;                        ///< wrenches of rigid directions at the start of the last step
    struct Record {
        static constexpr bool kStaysOwn = true;  ///< see centring.h
        double work = 0, last_work = 0;          ///< up to the start of the last step, and over it [J]
        double step_size = 0;                    ///< [s]
        double steps = 0;
    };
    Record record_;
};

}  // namespace dttmm::plugin
