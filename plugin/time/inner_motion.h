// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "time/inside.h"
#include "time/interior_matrix.h"

namespace dttmm::plugin {

/// The motion of what is inside a network over the open step, as the last iteration leaves it: u at which the forces were
/// worked out for one motion of the ports, the correction to which they lead, and the linear answer to where the ports have
/// gone since.
class InnerMotion {
public:
    /// Keeps both.
    InnerMotion(Inside& inside, const InteriorMatrix& matrix);
    /// Room for the steps to come: nothing is allocated later.
    void make_room_for_steps();

    /// Where the ports and the inside end if they go on as they have.
    void predict();
    /// Puts into Inside::trial where the forces are to be worked out.
    void move_to_trial();
    /// What is known before the first iteration of a step.
    void open();
    bool is_begun() const { return is_begun_; }
    void set_begun() { is_begun_ = true; }

    /// From where the ports were at the last iteration to where they are to go. Returns the largest speed of a point of
    /// their bodies for that over a step [m/s], NaN if a port's motion is.
    double take_port_change(Ports ports);
    /// Whether such a speed is rounding.
    bool is_rounding(double speed) const;
    void forget_port_change() { port_change_.setZero(); }
    /// Takes the motion to which the last iteration leads, with the ports as given.
    void go_on(Ports ports);

    // Where it ends, with the answer to the ports:
    /// Puts the forces of rigid directions into Inside::trial_q.
    void find_rigid_forces();
    /// Of all inner frames, of one.
    void find_motion(std::span<Vector6> motion) const;
    Vector6 motion_of(size_t inner) const;
    /// The force over the step of Inside::near_joints[near]; after find_rigid_forces(). It goes on linearly from where it
    /// was worked out. The ports need a smooth answer, not the rounding of positions times the stiffness.
    JointForce near_force(size_t near) const;

    std::vector<Vector6> u;        ///< of the inner frames, at which the forces were worked out [m/s, rad/s]
    std::vector<Vector6> change;   ///< correction of it; before it is solved for what the equations lack
    std::vector<double> q;         ///< forces of the rigid directions, before the correction [N, N m]
    std::vector<double> q_change;  ///< correction of them, times h
    std::vector<double> laws;      ///< ψ of the correction, see LawRows
    std::vector<JointForce> near;  ///< forces of Inside::near_joints over the step, before the correction
    double scale = 0;              ///< of the motion from which passes start [m/s]
    double correction = 0;         ///< size of the last one [m/s]; 0: there was none
    double rate = 0;               ///< of the last two
    double impulse = 0;            ///< of a joint over the step [N s]
    double floor = 0;              ///< corrections below are rounding [m/s]
    double size = 0;               ///< of the network and its way from the world's origin, at t_n [m]

private:
    Vector6 change_of_inner(size_t inner) const { return change[inner] + matrix_.response(inner) * port_change_; }
    Vector6 change_of(int frame) const;
    Vector3 mean_velocity() const;
    void take_measures();

    Inside& inside_;
    const InteriorMatrix& matrix_;
    std::vector<Frame> ports_;      ///< at the end of the step
    Eigen::VectorXd port_change_;   ///< from there to the end of the step asked for, 6 per port, local
    Eigen::VectorXd rigid_change_;  ///< what it changes in the forces of rigid directions, times h
    bool is_begun_ = false;         ///< there was an iteration
};

}  // namespace dttmm::plugin
