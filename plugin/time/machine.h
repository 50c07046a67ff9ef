// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "dttmm_plugin.h"
#include "dttmm_static.h"
#include "time/joined_numbers.h"
#include "time/network.h"
#include "time/supports.h"

namespace dttmm::plugin {

/// All elements of a model in time, as dttmm_plugin.h has them: the springs between bodies as one network of joints, and
/// every set of elements that inner nodes join, or that has masses of its own, as one. Bodies and the ground do not join:
/// what happens on one side of them is felt on the other through the host. Fixed nodes that the host moves are to the
/// networks bodies behind those of the host, whose motion is given (Supports).
///
/// Errors are thrown as Error with the element's index in the description; where a network blames none, its first.
class Machine {
public:
    explicit Machine(const dttmm_network& description);
    Machine(const Machine&) = delete;  // its parts keep each other
    Machine& operator=(const Machine&) = delete;

    bool is_implicit() const { return is_implicit_; }
    void load_weights(double weights[3]) const { networks_.front().network.load_weights(weights); }
    std::span<const dttmm_block> blocks() const { return std::span(blocks_).first(seen_blocks_); }
    void move_supports(const dttmm_support_motion* motions) { supports_.move_to(motions); }

    void linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const;
    void take_up(const double* motion, double* elastic, double* damped) const;
    void start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads);
    void begin_step(const dttmm_step& step, const double* loads);
    /// Networks that iterate.
    uint32_t part_count() const;
    void iterate(const dttmm_motion* trial, dttmm_progress* progress);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();
    void mean_wrench(double* wrench) const;
    void stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const;

    // At rest, see dttmm_static.h
    void begin_statics();
    void keep_statics();
    void recall_statics();
    void set_static_loads(const double* gravity, const double* loads);
    void form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness);
    void correct_static(const double* change, dttmm_static_measure* measure);
    void move_static(const dttmm_motion* bodies, double share, double* wrench, dttmm_static_measure* measure);
    AtRest at_rest() const;
    void start_at_rest(const dttmm_step& step, const dttmm_motion* bodies, const double* loads);

    size_t state_size() const;
    void save_state(void* buffer, size_t size) const;
    void restore_state(const void* buffer, size_t size);
    static void centre(Machine& above, Machine& below, const Machine& middle);

    size_t channel_count() const { return channel_count_; }
    /// Empty once it has started: a long beam has 10^5.
    const std::vector<dttmm_channel>& channels() const { return channels_; }
    void outputs(double* values) const;
    /// Elements that bend; where points of them are: see dttmm_shape.h.
    const std::vector<uint32_t>& lines() const { return lines_; }
    void positions(uint32_t stations, double* positions) const;

private:
    struct Part {
        Part(const dttmm_network& description, const Places& places) : network(description, places) {}
        Network network;
        std::vector<uint32_t> loaded;  ///< its inner nodes, then its line loads, among both of the whole
        std::vector<double> loads;     ///< on them, working memory
    };
    template <class Self, class Action>
    static void for_each(Self& self, const Action& action);
    template <class Find>
    dttmm_static_measure measure_static(const Find& find);
    void place_blocks();
    void place_channels(std::span<const std::vector<uint32_t>> units);
    void forget_channels();
    const double* gather_loads(Part& part, const double* loads) const;

    uint32_t body_count_, element_count_;
    size_t load_count_ = 0;  ///< on inner nodes, and line loads
    bool is_implicit_ = false;
    std::deque<Part> networks_;  ///< they stay where they are
    std::vector<dttmm_block> blocks_;
    size_t seen_blocks_ = 0;  ///< by the host; those of supports stand behind
    std::vector<dttmm_channel> channels_;
    size_t channel_count_ = 0;
    std::vector<uint32_t> lines_;
    Supports supports_;
    mutable std::optional<JoinedNumbers> joined_;  ///< working memory, so mutable
};

}  // namespace dttmm::plugin
