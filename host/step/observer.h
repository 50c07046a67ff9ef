// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "coupling/instant.h"
#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/step_equations.h"
#include "model/model.h"
#include "record/channels.h"
#include "world/world.h"

namespace dttmm::host {

/// How near an element came to the limit of its law.
struct Limit {
    size_t channel;       ///< that says it
    std::string element;  ///< its name
    double most = 0;      ///< largest of the rows so far; beyond 1 the law does not hold
    double time = 0;      ///< of that row [s]
};

/// Turns what stands at an instant t_n into one row of numbers. A joint's force and moment (about its anchor) act on its
/// first body in the axes of that body: as an element's, they are positive in tension. A body's position, velocity and
/// acceleration are those of its origin. Keeps the energy ledger  kinetic + strain + dissipated − work = initial + residual,
/// gravity counted as work; the networks' parts in each are their plugins'. Loads work by their mean over a step, so that
/// under Newmark's rule the ledger of a linear machine closes to rounding.
class Observer {
public:
    /// Points of a beam whose positions are recorded where the model asks for lines, ends included.
    static constexpr uint32_t kStations = 11;

    /// The model must outlive it. networks: watches lines where the model asks for them.
    Observer(const Model& model, Networks& networks, const JointSystem& joints);

    /// One per number of a row; the first is "time".
    const std::vector<Channel>& channels() const { return channels_; }
    const std::vector<Limit>& limits() const { return limits_; }

    /// Before the first row: takes the memory of rows.
    void make_room() { row_.resize(room_); }

    /// Only these channels of the rows count from now on; others may be 0, energies and limits too.
    void want(std::span<const int> channels);

    /// Adds the work of loads over the step from t_n, which counts from the row at its end on, and that of stops; every
    /// step. `before`: poses at t_n, velocities over the step before; `after`: one step later.
    void advance(const Loads& loads, const StepEquations& step, const std::vector<BodyState>& before,
                 const std::vector<BodyState>& after, double h);

    /// The row at t_n, after the step from t_n was committed, advance() was called and the networks stand there. Valid until
    /// the next call.
    std::span<const double> row(double time, const Networks& networks, const Instant& instant);

private:
    struct Ledger {
        double load_work = 0, last_work = 0;  ///< up to t_n, and over the step from there [J]
        double stop_loss = 0,
               stop_loss_now = 0;   ///< what the joints' stops have taken up to, and take around, the last instant
        double drive_work_now = 0;  ///< of motors around the last instant
        double initial = 0;         ///< kinetic + strain − work of the first row [J]
        bool opened = false;        ///< the first row has been written
    };

    /// [J]
    struct Energies {
        double kinetic = 0, strain = 0, dissipated = 0, work = 0;
    };

    void add_vector(Channel::Of of, const std::string& owner, const char* quantity, const char* unit,
                    bool by_default = true);
    void declare_networks(const Model& model, const Networks& networks);
    void declare_joints(const Model& model);
    void declare_bodies(const Model& model);
    void declare_energies();
    void declare_lines(const Networks& networks);
    double* write_networks(double* out, const Networks& networks, Energies& energies);
    double* write_joints(double* out, const Instant& instant) const;
    double* write_bodies(double* out, const Instant& instant) const;
    double kinetic_energy(const std::vector<BodyState>& at) const;
    double gravity_work(const std::vector<BodyState>& at) const;

    std::vector<Channel> channels_;
    const std::vector<Body>& bodies_;
    std::vector<JointEquations> joints_;
    Eigen::Vector3d gravity_;
    std::vector<double> row_;
    size_t room_;  ///< for all outputs of the networks behind the time

    std::vector<Limit> limits_;
    bool shows_lines_ = false;
    bool wants_networks_ = true;  ///< a channel of theirs, or an energy
    size_t network_channels_ = 0;
    Ledger ledger_;
};

}  // namespace dttmm::host
