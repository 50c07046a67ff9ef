// SPDX-License-Identifier: BSD-3-Clause
//
// Time to a given error on the four-bolt plate, soft and stiff, of ours and of what one would use instead: a hand-written
// Runge-Kutta loop (the best that engines with explicit integrators offer), and ODE alone with soft ball joints. Error: the
// largest of the bolt forces over bolts and a 1 ms grid, over the static 250 N, against the exact solution of the linear
// equations. Steps: 1, 1/2, 1/5, 1/10, … ms; of those the largest from which on every shorter one tried keeps the target.
// Times: of stepping alone, nothing recorded, median of rounds that all methods take in turn; of the run to a tolerance, of
// everything (all its runs from 1 ms on, set-up and histories). Takes ten seconds.
#include <fmt/format.h>
#include <ode/ode.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "analysis/convergence.h"
#include "analysis/halving.h"
#include "benchmark/median.h"
#include "support/exact_plate.h"

namespace dttmm::host {
namespace {

using Forces = test::PlateForces;
using test::kCorners;
using test::PlateOnBolts;

constexpr int kMilliseconds = 200;
constexpr double kLoad = 1000;  // N
constexpr long kStepsPerMillisecond[] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};
constexpr double kTargets[] = {1e-2, 1e-4, 1e-6};
constexpr int kRounds = 15;
constexpr double kLongestRounds = 1.5;  // s, of one method on one target

double step_size(long per_millisecond) { return 1e-3 / static_cast<double>(per_millisecond); }

double seconds_of(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double load_at(const PlateOnBolts& plate, double time) {
    const double s = std::clamp(time / plate.rise_time, 0.0, 1.0);
    return kLoad * s * s * (3 - 2 * s);
}

// ---- What one would write without dttmm ---------------------------------------------------------------------------------

/// The classical Runge-Kutta method of fourth order on the rigid plate with its full rotation:
///     p' = v,  m v' = F,  q' = q (0, w)/2,  J w' = M − w × J w      w and M in body axes
class RungeKutta {
public:
    RungeKutta(const PlateOnBolts& plate, double h) : plate_(plate), h_(h) {
        J_ = test::kPlateMass / 12 *
             Eigen::Vector3d(test::kPlateSize.y() * test::kPlateSize.y() + test::kPlateSize.z() * test::kPlateSize.z(),
                             test::kPlateSize.x() * test::kPlateSize.x() + test::kPlateSize.z() * test::kPlateSize.z(),
                             test::kPlateSize.x() * test::kPlateSize.x() + test::kPlateSize.y() * test::kPlateSize.y());
        inverse_J_ = J_.cwiseInverse();
        y_.setZero();
        y_(kQ + 3) = 1;
    }

    void step() {
        const double t = static_cast<double>(index_++) * h_;
        const State k1 = rate(y_, load_at(plate_, t));
        const double load_half_way = load_at(plate_, t + 0.5 * h_);
        const State k2 = rate(y_ + 0.5 * h_ * k1, load_half_way);
        const State k3 = rate(y_ + 0.5 * h_ * k2, load_half_way);
        const State k4 = rate(y_ + h_ * k3, load_at(plate_, t + h_));
        y_ += h_ / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        y_.segment<4>(kQ).normalize();
    }

    double force(size_t bolt) const { return -pull(y_, rotation(y_), bolt).z(); }

private:
    using State = Eigen::Matrix<double, 13, 1>;
    enum { kP = 0, kV = 3, kW = 6, kQ = 9 };  ///< q as Eigen keeps it: x, y, z, w

    static Eigen::Matrix3d rotation(const State& y) {
        return Eigen::Quaterniond(y(kQ + 3), y(kQ), y(kQ + 1), y(kQ + 2)).toRotationMatrix();
    }
    Eigen::Vector3d pull(const State& y, const Eigen::Matrix3d& R, size_t bolt) const {
        const Eigen::Vector3d& r = kCorners[bolt];
        const Eigen::Vector3d x = y.segment<3>(kP) + R * r - r;
        const Eigen::Vector3d v = y.segment<3>(kV) + R * y.segment<3>(kW).cross(r);
        return -plate_.k[bolt] * x - plate_.c * v;
    }
    State rate(const State& y, double load) const {
        const Eigen::Matrix3d R = rotation(y);
        const Eigen::Vector3d w = y.segment<3>(kW), vector = y.segment<3>(kQ);
        Eigen::Vector3d F(0, 0, load), M = Eigen::Vector3d::Zero();
        for (size_t i = 0; i < 4; ++i) {
            const Eigen::Vector3d f = pull(y, R, i);
            F += f;
            M += kCorners[i].cross(R.transpose() * f);
        }
        State rate;
        rate.segment<3>(kP) = y.segment<3>(kV);
        rate.segment<3>(kV) = (1 / test::kPlateMass) * F;
        rate.segment<3>(kW) = inverse_J_.cwiseProduct(M - w.cross(J_.cwiseProduct(w)));
        rate.segment<3>(kQ) = 0.5 * (y(kQ + 3) * w + vector.cross(w));
        rate(kQ + 3) = -0.5 * vector.dot(w);
        return rate;
    }

    PlateOnBolts plate_;
    double h_;
    Eigen::Vector3d J_, inverse_J_;
    State y_;
    long index_ = 0;
};

/// ODE alone, each bolt a ball joint to the ground made soft: ERP = h k/(h k + c), CFM = 1/(h k + c). Over a step it pulls
/// with −(k x + c v) of the end of that step, so forces are taken from positions and velocities: they are what
/// dJointFeedback says, at the instant they hold for, and ODE is spared the feedback.
class SoftBallJoints {
public:
    SoftBallJoints(const PlateOnBolts& plate, double h)
        : plate_(plate), h_(h), world_(dWorldCreate()), body_(dBodyCreate(world_)) {
        dMass mass;
        dMassSetBoxTotal(&mass, test::kPlateMass, test::kPlateSize.x(), test::kPlateSize.y(), test::kPlateSize.z());
        dBodySetMass(body_, &mass);
        dWorldSetAutoDisableFlag(world_, 0);
        for (size_t i = 0; i < 4; ++i) {
            const Eigen::Vector3d& r = kCorners[i];
            const dJointID joint = dJointCreateBall(world_, nullptr);
            dJointAttach(joint, body_, nullptr);
            dJointSetBallAnchor(joint, r.x(), r.y(), r.z());
            dJointSetBallParam(joint, dParamERP, h * plate.k[i] / (h * plate.k[i] + plate.c));
            dJointSetBallParam(joint, dParamCFM, 1 / (h * plate.k[i] + plate.c));
        }
    }
    ~SoftBallJoints() { dWorldDestroy(world_); }
    SoftBallJoints(const SoftBallJoints&) = delete;
    SoftBallJoints& operator=(const SoftBallJoints&) = delete;

    void step() {
        // the load at the end of the step, as the joints' forces
        dBodyAddForce(body_, 0, 0, load_at(plate_, static_cast<double>(++index_) * h_));
        dWorldStep(world_, h_);
    }

    double force(size_t bolt) const {
        const Eigen::Vector3d& r = kCorners[bolt];
        dVector3 p, v;
        dBodyGetRelPointPos(body_, r.x(), r.y(), r.z(), p);
        dBodyGetRelPointVel(body_, r.x(), r.y(), r.z(), v);
        return plate_.k[bolt] * (p[2] - r.z()) + plate_.c * v[2];
    }

private:
    PlateOnBolts plate_;
    double h_;
    dWorldID world_;
    dBodyID body_;
    long index_ = 0;
};

// ---- Ours ---------------------------------------------------------------------------------------------------------------

Model make_model(const PlateOnBolts& plate, const Plugins& plugins, Coupling coupling, long per_millisecond) {
    Model model = test::plate_stack(plugins, 1, 0, plate.c, step_size(per_millisecond), coupling);
    for (size_t i = 0; i < 4; ++i) std::fill_n(model.elements[i].values.change().begin(), 3, plate.k[i]);
    model.loads[0].signal = test::smooth_rise(kLoad, plate.rise_time);
    model.simulation.duration = 1e-3 * kMilliseconds;
    model.output.every = static_cast<int>(per_millisecond);
    return model;
}

Forces simulated_forces(const PlateOnBolts& plate, Coupling coupling, long per_millisecond) {
    const Plugins plugins;
    const Model model = make_model(plate, plugins, coupling, per_millisecond);
    Simulation simulation(model, plugins);
    std::array<size_t, 4> column{};
    for (size_t c = 0; c < simulation.channels().size(); ++c)
        for (size_t i = 0; i < 4; ++i)
            if (simulation.channels()[c].name() == fmt::format("bolt1_{}.force.z", i + 1)) column[i] = c;
    Forces forces;
    simulation.record_to([&](std::span<const double> row) {
        forces.push_back({row[column[0]], row[column[1]], row[column[2]], row[column[3]]});
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return forces;
}

double simulation_time(const PlateOnBolts& plate, Coupling coupling, long per_millisecond) {
    const Plugins plugins;
    const Model model = make_model(plate, plugins, coupling, per_millisecond);
    Simulation simulation(model, plugins);
    return seconds_of([&] {
        while (simulation.index() < simulation.step_count()) simulation.step();
    });
}

/// What a run to a tolerance makes of the histories at these steps (see Convergence).
Forces extrapolated_forces(const PlateOnBolts& plate, const std::vector<long>& steps_per_millisecond) {
    Convergence convergence(4);
    for (const long per_millisecond : steps_per_millisecond) {
        std::vector<double> history;
        for (const auto& row : simulated_forces(plate, Coupling::implicit, per_millisecond))
            history.insert(history.end(), row.begin(), row.end());
        convergence.add(history);
    }
    Forces forces(convergence.rows());
    std::array<double, 4> estimates{};
    for (size_t n = 0; n < forces.size(); ++n) convergence.evaluate_row(n, forces[n], estimates);
    return forces;
}

/// A run from 1 ms on to a tolerance of the bolt forces.
class ToleranceRun {
public:
    ToleranceRun(const PlateOnBolts& plate, double tolerance) : model_(make_model(plate, plugins_, Coupling::implicit, 1)) {
        model_.simulation.tolerance = tolerance;
    }
    double time() {
        return seconds_of([this] {
            const std::vector<Channel> channels = Simulation(model_, plugins_).channels();
            Halving halving(model_, plugins_, channels, select_channels(channels, {"bolt*.force"}));
            reached_ = halving.run(true).code == ExitCode::ok;
            steps_per_millisecond_.clear();
            for (const Level& level : halving.levels()) steps_per_millisecond_.push_back(std::lround(1e-3 / level.step));
        });
    }
    bool reached() const { return reached_; }
    const std::vector<long>& steps_per_millisecond() const { return steps_per_millisecond_; }

private:
    Plugins plugins_;
    Model model_;
    bool reached_ = false;
    std::vector<long> steps_per_millisecond_;
};

// ---- The contest --------------------------------------------------------------------------------------------------------

/// A way to move the plate for kMilliseconds with so many steps per millisecond.
struct Method {
    std::string name;
    std::function<Forces(const PlateOnBolts&, long)> forces;  ///< may throw Error when it flies apart
    std::function<double(const PlateOnBolts&, long)> time;    ///< [s]
};

template <class Loop>
Method hand_written(const std::string& name) {
    return {name,
            [](const PlateOnBolts& plate, long per_millisecond) {
                Loop loop(plate, step_size(per_millisecond));
                Forces forces;
                for (int ms = 0; ms <= kMilliseconds; ++ms) {
                    forces.push_back({loop.force(0), loop.force(1), loop.force(2), loop.force(3)});
                    for (long n = 0; n < per_millisecond; ++n) loop.step();
                }
                return forces;
            },
            [](const PlateOnBolts& plate, long per_millisecond) {
                Loop loop(plate, step_size(per_millisecond));
                return seconds_of([&] {
                    for (long n = 0; n < kMilliseconds * per_millisecond; ++n) loop.step();
                });
            }};
}

Method ours(const std::string& name, Coupling coupling) {
    return {
        name,
        [=](const PlateOnBolts& plate, long per_millisecond) { return simulated_forces(plate, coupling, per_millisecond); },
        [=](const PlateOnBolts& plate, long per_millisecond) { return simulation_time(plate, coupling, per_millisecond); }};
}

Method ours_extrapolated(const std::string& name) {
    return {name,
            [](const PlateOnBolts& plate, long per_millisecond) {
                return extrapolated_forces(plate, {per_millisecond, 2 * per_millisecond});
            },
            [](const PlateOnBolts& plate, long per_millisecond) {
                return simulation_time(plate, Coupling::implicit, per_millisecond) +
                       simulation_time(plate, Coupling::implicit, 2 * per_millisecond);
            }};
}

/// Error at one step of the ladder; infinite: it flew apart.
struct Trial {
    long per_millisecond;
    double error;
};

/// Down the ladder until the last target is reached.
std::vector<Trial> try_steps(const Method& method, const PlateOnBolts& plate, const Forces& exact) {
    std::vector<Trial> trials;
    for (const long per_millisecond : kStepsPerMillisecond) {
        double error;
        try {
            error = test::plate_error(method.forces(plate, per_millisecond), exact);
        } catch (const Error&) {
            error = INFINITY;
        }
        trials.push_back({per_millisecond, error <= 1 ? error : INFINITY});
        if (error <= kTargets[2]) break;
    }
    return trials;
}

std::optional<Trial> largest_step(const std::vector<Trial>& trials, double target) {
    std::optional<Trial> found;
    for (auto trial = trials.rbegin(); trial != trials.rend() && trial->error <= target; ++trial) found = *trial;
    return found;
}

/// One line of the table in the making.
struct Entry {
    std::string name, step, remark;
    double error = NAN;
    std::function<double()> time;  ///< none: the target is not reached
    std::vector<double> times = {};
};

std::string step_text(long per_millisecond) { return fmt::format("{:g} us", 1e3 / static_cast<double>(per_millisecond)); }

Entry ladder_entry(const Method& method, const std::vector<Trial>& trials, const PlateOnBolts& plate, double target) {
    Entry entry{method.name, "", "", NAN, nullptr};
    for (const Trial& trial : trials)
        if (trial.error == INFINITY) entry.remark = fmt::format("unstable at {}", step_text(trial.per_millisecond));
    if (const auto found = largest_step(trials, target)) {
        entry.step = step_text(found->per_millisecond);
        entry.error = found->error;
        entry.time = [&method, &plate, per_millisecond = found->per_millisecond] {
            return method.time(plate, per_millisecond);
        };
    } else {
        const Trial best = *std::ranges::min_element(trials, {}, &Trial::error);
        entry.remark = fmt::format("not reached: {:.1e} at {}", best.error, step_text(best.per_millisecond));
    }
    return entry;
}

Entry tolerance_entry(ToleranceRun& run, const PlateOnBolts& plate, const Forces& exact, double target) {
    Entry entry{"implicit, tolerance", "", "", NAN, nullptr};
    run.time();
    const auto& steps = run.steps_per_millisecond();
    entry.step = step_text(steps.back());
    entry.error = test::plate_error(extrapolated_forces(plate, steps), exact);
    entry.remark = fmt::format("asked for {:g}, {} runs{}", target, steps.size(), run.reached() ? "" : ", not reached");
    entry.time = [&run] { return run.time(); };
    return entry;
}

void measure(std::vector<Entry>& entries) {
    for (int round = 0; round < kRounds; ++round)
        for (Entry& entry : entries)
            if (entry.time && (round < 3 || static_cast<double>(round) * entry.times[0] < kLongestRounds))
                entry.times.push_back(entry.time());
}

void compare(const std::string& title, const PlateOnBolts& plate) {
    const std::vector<Method> methods = {
        hand_written<RungeKutta>("Runge-Kutta 4"),
        ours("explicit", Coupling::explicit_),
        ours("implicit", Coupling::implicit),
        ours_extrapolated("implicit, h and h/2"),
        hand_written<SoftBallJoints>("ODE's soft joints"),
    };
    const Forces exact = test::exact_plate_forces(plate, kMilliseconds);
    std::vector<std::vector<Trial>> trials;
    for (const Method& method : methods) trials.push_back(try_steps(method, plate, exact));

    fmt::print("\n{}, {} ms simulated\n{:<20} {:>7} {:>10} {:>9} {:>10} {:>9}\n", title, kMilliseconds, "method", "target",
               "step", "error", "time ms", "over RK4");
    for (const double target : kTargets) {
        ToleranceRun tolerance_run(plate, target);
        std::vector<Entry> entries;
        for (size_t m = 0; m < methods.size(); ++m) entries.push_back(ladder_entry(methods[m], trials[m], plate, target));
        entries.insert(entries.end() - 1, tolerance_entry(tolerance_run, plate, exact, target));
        measure(entries);
        for (const Entry& entry : entries) {
            fmt::print("{:<20} {:>7.0e} ", entry.name, target);
            if (entry.time) {
                const double time = median(entry.times);
                fmt::print("{:>10} {:>9.1e} {:>10.3f} ", entry.step, entry.error, 1e3 * time);
                if (entries[0].time)
                    fmt::print("{:>9.2f}", time / median(entries[0].times));
                else
                    fmt::print("{:>9}", "");
            } else {
                fmt::print("{:>10} {:>9} {:>10} {:>9}", "-", "-", "-", "-");
            }
            fmt::print("  {}\n", entry.remark);
        }
    }
}

}  // namespace
}  // namespace dttmm::host

int main() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    dttmm::host::compare("Soft bolts (examples/four_bolt_plate, bolt 1 softer by a fifth)", dttmm::test::kSoftBolts);
    dttmm::host::compare("Stiff bolts (examples/stiff_bolts)", dttmm::test::kStiffBolts);
    dCloseODE();
    return 0;
}
