// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "report/recorded_motion.h"
#include "report/results.h"
#include "report/structure.h"

namespace dttmm::host {

/// How far a body or node is from its start: displacement [m] and rotation vector [rad], world axes. Of a mode in the unit
/// of its shape.
struct Moved {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), theta = Eigen::Vector3d::Zero();
};

/// Points along a beam, from end to end: at the start, and how far they are from there.
struct BentLine {
    std::vector<Eigen::Vector3d> start, shift;
};

/// All parts at an instant.
struct Instant {
    std::vector<Moved> owners;    ///< of Structure
    std::vector<BentLine> lines;  ///< by element; empty where only its ends are known
    std::vector<double> forces;   ///< by element [N]; NaN where it is not known
};

/// What is drawn of them, world axes [m].
struct Placement {
    struct Pose {
        Eigen::Vector3d position;
        Eigen::Quaterniond turn;
    };
    std::vector<Pose> owners;
    std::vector<std::vector<Eigen::Vector3d>> lines;  ///< by element: its points; the same number at every instant
};

/// One motion of the machine.
struct Film {
    enum class Kind : unsigned char { run, mode, equilibrium };
    Kind kind;
    std::string name;           ///< "run", "mode 2: 12.5 Hz", "equilibrium", "equilibrium snow"
    std::vector<double> times;  ///< [s] of a run; of a mode one period, of an equilibrium its share, from 0 to 1
    double frequency = 0;       ///< of a mode [Hz]
    std::function<Instant(std::size_t)> at;  ///< by the number of a time
    std::size_t fullest = 0;                 ///< number of the time at which a mode or equilibrium is whole
};

/// What an animation of results shows: the structure and its motions. The motion of a run is that of history.csv; a mode
/// is a period of its shape times a sine; an equilibrium is approached in proportion. Beams bend as a mode has them, or as a
/// run has recorded their stations; else as a cubic through their ends. Ideal joints are not drawn.
class Scene {
public:
    /// Throws Error(usage) for results without a motion, Error(input_output) for damaged ones.
    Scene(const Results& results, const MotionBounds& bounds);
    Scene(const Scene&) = delete;  // its films refer to it
    Scene& operator=(const Scene&) = delete;

    const Structure& structure() const { return structure_; }
    const std::string& title() const { return title_; }
    const std::vector<Film>& films() const { return films_; }
    /// What the motions leave out, a sentence each.
    const std::vector<std::string>& notes() const { return notes_; }

    /// With displacements and rotations enlarged by a factor.
    Placement place(const Instant& instant, double factor = 1) const;
    Eigen::Vector3d place(const OwnedPoint& point, const Instant& instant, double factor = 1) const;
    /// The largest displacement of any corner, place or point of a line [m, or the unit of the shape], to first order in the
    /// rotations; and the largest rotation.
    struct Largest {
        double shift = 0, angle = 0;
    };
    Largest largest(const Instant& instant) const;
    /// u + theta × r of a point: its displacement to first order in the rotation.
    Eigen::Vector3d linear_shift(const OwnedPoint& point, const Instant& instant) const;

private:
    void add_run(const Results& results, const MotionBounds& bounds);
    void add_modes(const Results& results);
    void add_equilibria(const Results& results);
    Instant rest() const;
    Instant recorded(const RecordedMotion& motion, std::size_t row) const;
    void note_still(const RecordedMotion& motion);

    std::string title_;
    Structure structure_;
    std::vector<Film> films_;
    std::vector<std::string> notes_;
};

}  // namespace dttmm::host
