// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "coupling/network_description.h"
#include "loader/guarded_array.h"
#include "loader/network_instance.h"
#include "model/error.h"
#include "model/index.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// The instances of all plugins of a model, what goes to them and what comes from them: arrays with guards, checked numbers,
/// and errors with the place in the model file or the time.
class NetworkExchange {
public:
    static constexpr size_t kBlock = 36;  ///< numbers of a block of a matrix
    /// A wrench on a body that is not finite or too large.
    struct Large {
        size_t instance, body;
        double wrench[6];
    };

    /// The model must outlive it.
    explicit NetworkExchange(const Model& model);

    /// Creates the instance of a plugin. Throws Error with the place in the model file when it refuses an element.
    void add(const Model& model, const NetworkDescription& description, const std::vector<size_t>& elements);
    std::vector<NetworkInstance>& instances() { return instances_; }
    const std::vector<NetworkInstance>& instances() const { return instances_; }

    /// In messages, until the next one [s].
    void set_time(double time) { time_ = time; }
    double time() const { return time_; }
    /// Puts the place of the element that a plugin blames before what it says.
    template <class Action>
    void tell_place(size_t instance, Action&& action) const {
        try {
            action();
        } catch (const NetworkError& error) {
            const std::vector<size_t>& own = slots_[instance].elements;
            const bool is_one = error.element() >= 0 || own.size() == 1;
            const std::string& place = is_one ? elements_[own[as_size(std::max(error.element(), 0))]].place : path_;
            throw Error(error.code(), fmt::format("{}: {}", place, error.what()));
        }
    }
    /// Puts the time before what a plugin says while a step is open. A model that could be started is not invalid any more.
    template <class Action>
    static void tell_time(double time, Action&& action) {
        try {
            action();
        } catch (const NetworkError& error) {
            const ExitCode code = error.code() == ExitCode::model_invalid ? ExitCode::plugin_failure : error.code();
            throw Error(code, fmt::format("t = {:.9g} s: {}", time, error.what()));
        }
    }

    /// Copies the motion of the bodies.
    void gather(const std::vector<BodyState>& motion);
    /// The motions last copied.
    const dttmm_motion* motions() const { return motions_.data(); }
    /// Loads on one instance, out of those on all networks; null if there are none.
    const double* gather_loads(size_t instance, const double* loads);
    /// Hands the motions of its supports to one instance.
    void move_supports(size_t instance, const double* loads);

    /// Where a plugin writes the wrenches on all bodies; then scatter() adds them to those given. Throws
    /// Error(numerical_failure) naming element and body for one that is not finite or too large.
    double* wrenches() { return wrenches_.data(); }
    void scatter(size_t instance, double* wrenches) const { add_wrenches(instance, World::kLargestWrench, wrenches); }
    /// Adds the wrenches of a trial. Up to 1e100 N it only keeps the first one that is too large.
    void scatter_trial(size_t instance, double* wrenches);
    /// Forgets those kept; throws for what was kept since.
    void forget_large() { large_.reset(); }
    void refuse_large() const;
    /// Room for the blocks of an instance, to be written by its plugin.
    double* make_room(size_t instance, GuardedArray& matrix) const;
    void check_guards(size_t instance, const GuardedArray& array, const char* name) const;
    void check_matrix(size_t instance, const GuardedArray& matrix, const char* name, const char* when = "") const;

private:
    /// What the host keeps of an instance.
    struct Slot {
        std::vector<size_t> elements;    ///< of the model
        std::vector<size_t> loaded;      ///< its inner nodes, then its forces per length, among the loads on all networks
        bool is_loaded = false;          ///< a load acts on one of these
        std::vector<size_t> supported;   ///< its nodes that supports move, as where their numbers begin in the same array
        std::vector<int> first_on_body;  ///< its first element on each body; −1: none
    };

    void add_wrenches(size_t instance, double most, double* wrenches) const;
    [[noreturn]] void refuse_wrench(const Large& large) const;

    std::vector<NetworkInstance> instances_;
    std::vector<Slot> slots_;
    const std::vector<Element>& elements_;
    std::string path_;  ///< of the model file
    std::vector<std::string> body_names_;
    double time_ = 0;
    std::vector<dttmm_motion> motions_;  ///< of every body
    GuardedArray wrenches_;              ///< of every body, written by plugins
    std::optional<Large> large_;         ///< at a trial
    std::vector<double> loads_;
    std::vector<dttmm_support_motion> supports_;
};

}  // namespace dttmm::host
