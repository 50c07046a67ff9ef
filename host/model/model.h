// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <bitset>
#include <compare>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/shared_numbers.h"
#include "model/signal.h"
#include "model/warning.h"

namespace dttmm::host {

/// The model as read, checked and converted: SI units, world axes unless said otherwise, every name resolved to an index.
/// Nothing below this layer reads text.

struct Marker {
    std::string name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in the body's axes, from the body's origin [m]
    std::shared_ptr<const Eigen::Matrix3d> rotation;     ///< the marker's axes in the body's; null: they are the body's
    bool is_probe = false;                               ///< its motion is recorded by default
    Eigen::Matrix3d axes() const { return rotation ? *rotation : Eigen::Matrix3d(Eigen::Matrix3d::Identity()); }
};

struct Body {
    std::string name;
    double mass = 0;                                             ///< [kg]
    Eigen::Vector3d center_of_mass = Eigen::Vector3d::Zero();    ///< in the body's axes [m]
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();           ///< about the centre of mass, body axes [kg m²]
    Eigen::Vector3d position = Eigen::Vector3d::Zero();          ///< of the body's origin [m]
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();      ///< the body's axes in the world
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the body's origin [m/s]
    Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< world axes [rad/s]
    std::vector<Marker> markers;
};

/// A point of the elastic network that is no body: it moves as the elements on it have it.
struct Node {
    std::string name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< at the start [m]
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< its axes in the world at the start
    std::bitset<6> fixed;  ///< directions x y z rx ry rz (world axes) in which it stays where it is at the start
    /// How far a support moves it in fixed directions, by direction: displacement [m] and rotation vector [rad], world axes.
    std::array<std::optional<Signal>, 6> motion = {};
    /// Of `motion` what vibrates, where frequencies and not a run are asked for; `motion` is zero there.
    std::array<std::optional<Signal>, 6> vibrations = {};
    double vibration_factor = 1;    ///< of a load case
    std::string motion_place = {};  ///< "file:line:column", for errors found later
    bool moves = false;             ///< it starts with the velocities below; otherwise as straining the network least
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< [m/s]
    Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< world axes [rad/s]

    bool is_support() const {
        for (const auto& signal : motion)
            if (signal) return true;
        return false;
    }
};

/// A place on a body: one of its markers, or the body itself (its origin; for a load, its centre of mass); or a node; or,
/// without either, the ground.
struct Attachment {
    int body = -1;    ///< index into Model::bodies
    int marker = -1;  ///< index into Body::markers; -1 is the body itself
    int node = -1;    ///< index into Model::nodes

    bool is_ground() const { return body < 0 && node < 0; }
    auto operator<=>(const Attachment&) const = default;
};

/// A force or a moment at a point; or a force per length on an element, linear between the element's ends.
struct Load {
    Attachment on;                                        ///< of a force per length unused
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit vector, world axes unless it turns
    bool is_moment = false;                               ///< a moment [N m] instead of a force [N]
    Signal signal;                                        ///< magnitude along `direction` against time; at the `from` end
    std::string place;                                    ///< "file:line:column", for errors found later
    int element = -1;                                     ///< index into Model::elements of a force per length [N/m]
    std::optional<Signal> signal_at_to = {};              ///< its magnitude at the `to` end; none: the same all along
    std::string name = {};                                ///< of load cases, maybe of several loads; empty: none
    bool turns = false;  ///< `direction` is in the axes of its element or body and turns with it: a follower load

    /// What it is of a harmonic or random load where frequencies and not a run are asked for; `signal` is zero there.
    std::optional<Signal> vibration = {}, vibration_at_to = {};
    double vibration_factor = 1;  ///< of a load case

    bool is_per_length() const { return element >= 0; }
    const Signal& at_to() const { return signal_at_to ? *signal_at_to : signal; }
    const char* unit() const { return is_per_length() ? "N/m" : is_moment ? "N m" : "N"; }
    const char* quantity() const { return is_per_length() ? "force_per_length" : is_moment ? "moment" : "force"; }
};

struct Element {
    std::string name;
    int type = -1;                                ///< index into the catalogue the model was read with
    std::vector<Attachment> ends;                 ///< from and to, or those of `at`, as the type declares
    SharedNumbers values;                         ///< numbers of all parameters of the type, in the order declared
    std::string place;                            ///< "file:line:column", for errors found later
    std::shared_ptr<const Eigen::Matrix3d> axes;  ///< in the world at the start; null: those of the `from` end, of the other
                                                  ///< end where that is the ground
};

enum class JointType { ball, hinge, slider, universal, fixed };

/// An ideal joint between two bodies, kept by ODE. Between them nothing gives; what they leave free is the joint's motion.
struct Joint {
    std::string name;
    JointType type = JointType::ball;
    int first = -1, second = -1;                       ///< indices into Model::bodies; -1 is the ground, at one of them
    Eigen::Vector3d anchor = Eigen::Vector3d::Zero();  ///< point of both bodies at the start, world axes [m]
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();   ///< of hinge, slider, universal (on `first`) at the start, world axes
    Eigen::Vector3d axis2 = Eigen::Vector3d::UnitY();  ///< of universal, on `second`, at right angles to `axis`
    std::optional<std::array<double, 2>> limits;       ///< stops of a hinge [rad] or slider [m], 0 at the start
    std::string place;                                 ///< "file:line:column", for errors found later
    std::optional<Signal> drive = {};  ///< a motor: angle of a hinge [rad] or travel of a slider [m] over time
    std::string drive_place = {};      ///< "file:line:column"
};

enum class Coupling { implicit, explicit_ };

/// Velocity formula of the explicit coupling; ignored by the implicit one.
enum class ExplicitScheme { fox_euler, bdf1, bdf2, houbolt, park };

struct SimulationSettings {
    double duration = 0;  ///< [s]
    double step = 0;      ///< [s]; 0: not given, the run chooses the first step of its tolerance
    Coupling coupling = Coupling::implicit;
    ExplicitScheme scheme = ExplicitScheme::fox_euler;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< [m/s²]
    double spectral_radius = 1;   ///< of the implicit scheme at infinite frequency: 1 no numerical damping, 0 the most
    bool starts_at_rest = false;  ///< in the equilibrium under weight and the loads at the start, not as the file places it
    std::optional<double> tolerance;  ///< of the results, relative; `step` is then the first tried. None: one run at `step`
};

struct OutputSettings {
    double step = 0;                    ///< [s]; 0: not given
    int every = 1;                      ///< one row per so many steps; without a time step not known yet
    std::vector<std::string> channels;  ///< glob patterns; empty: the default channels
    std::string channels_place;         ///< "file:line:column" of the list
    bool has_lines = false;             ///< where points along beams are may be recorded too, for pictures
};

/// The state that small vibrations are about.
enum class About { automatic, start, equilibrium };

/// What `dttmm modes` is to find.
struct ModesSettings {
    About about = About::automatic;    ///< automatic: the equilibrium, where there is gravity or a load at the start
    int count = 10;                    ///< the first so many frequencies
    std::optional<double> below;       ///< or all up to here [Hz]
    std::string below_place;           ///< "file:line:column", for errors found later
    bool are_beams_lumped = false;     ///< as the time solver has them
    std::bitset<6> directions = 0x3f;  ///< x y z rx ry rz (world axes) in which nodes and bodies move
};

/// Damping beside that of the elements, in steady vibration and damped modes.
struct DampingSettings {
    std::vector<double> ratios;  ///< damping ratios of the first vibrations, or one
    bool is_of_all = false;      ///< one number: of all vibrations
    double mass_rate = 0;        ///< force on every mass per momentum, against the world [1/s]
    std::string place;           ///< "file:line:column"; empty: there is none
};

/// Loads and motions of supports that act together.
struct LoadCase {
    std::string name;
    std::string place;                   ///< "file:line:column"
    double gravity = 1;                  ///< factor of gravity
    std::vector<double> load_factors;    ///< by Model::loads; 0: it does not act
    std::vector<double> motion_factors;  ///< by Model::nodes
};

/// What a column of a measured file is.
struct MeasuredChannel {
    std::string column;
    std::string channel;       ///< of the model
    bool is_reversed = false;  ///< it counts against the direction of the channel
    std::string unit;          ///< empty: as the file says
    double gain = 1;           ///< measured value per true one
    double delay = 0;          ///< by which it comes too late [s]
    std::string noise;         ///< a text as [measured] has it; empty: that of all
    std::string place;         ///< "file:line:column", for errors found later
};

/// [measured]: data that others took.
struct MeasuredSettings {
    std::filesystem::path file;  ///< empty: none
    std::string input;           ///< what drove responses; empty: the file says it
    std::string noise;           ///< "1 %", "0.5 m/s^2"; empty: from the data
    int averages = 1;            ///< behind responses with a coherence
    double clock = 1;            ///< true time per time of the file
    double hum = 0;              ///< of the mains, which tells the clock [Hz]; 0: none is sought
    std::vector<MeasuredChannel> channels = {};
};

struct Parameter {
    std::string name;
    double value = 0;  ///< SI
    std::string unit;  ///< the SI unit of `value` as text, "1" for a pure number; empty for the result of an expression
    std::string text;  ///< as written in the file or by --set
};

struct Model {
    std::string path;    ///< of the model file
    std::string source;  ///< the text of the model file
    std::string title;
    std::vector<Parameter> parameters;
    SimulationSettings simulation;
    OutputSettings output;
    ModesSettings modes;
    DampingSettings damping;
    std::vector<Body> bodies;
    std::vector<Node> nodes;
    std::vector<Joint> joints;
    std::vector<Load> loads;
    std::vector<LoadCase> cases;
    std::string load_case;  ///< the one that was asked for, whose factors the loads have; empty: none
    std::vector<Element> elements;
    bool machine_rests_on_speed = false;  ///< other numbers than amplitudes of orders rest on the parameter Omega
    std::vector<std::pair<std::string, std::string>> study;  ///< options of `dttmm study` by [study], "--vary", as texts
    MeasuredSettings measured;
    std::vector<std::filesystem::path> files;  ///< beside the model file that were read: tables of loads
    std::vector<Warning> warnings;             ///< of the model file, each text with its place
};

}  // namespace dttmm::host
