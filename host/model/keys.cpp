// SPDX-License-Identifier: BSD-3-Clause
#include "model/keys.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/error.h"

namespace dttmm::host {

namespace {

using Kind = Key::Kind;

constexpr Bounds kRatio = {0, 1};                    // of damping
constexpr Bounds kOnBody = {-kFarthest, kFarthest};  // coordinates in the body's axes [m]

// Columns: name, kind, what it is, default, unit, count, bounds, words, table.
constexpr Key kFile[] = {
    {"format", Kind::word, "version of the form of the file", kRequired, "", 0, {}, "dttmm/1"},
    {"title", Kind::text, "printed above the results"},
    {"parameters", Kind::named,
     "numbers by name, for expressions: k = \"500 N/mm\", then stiffness = \"=2*k\"; --set and "
     "--sweep change them"},
    {"stations", Kind::named,
     "places by name, front = [0.12, 0, \"=h\"], for expressions: \"=front.x + 0.02\", and for positions: \"=front\"; "
     "--set front.x=... moves them",
     "", "m"},
    {"simulation", Kind::table, "duration, step and method of a run", "", "", 0, {}, "", "simulation"},
    {"output", Kind::table, "which rows and channels a run records", "", "", 0, {}, "", "output"},
    {"modes", Kind::table, "which natural frequencies `dttmm modes` finds", "", "", 0, {}, "", "modes"},
    {"damping",
     Kind::table,
     "damping beside that of elements, of `modes --damped`, `frf` and `response`",
     "",
     "",
     0,
     {},
     "",
     "damping"},
    {"study", Kind::table, "cases of `dttmm study`", "", "", 0, {}, "", "study"},
    {"measured", Kind::table, "measured data, of `identify` and `diagnose`", "", "", 0, {}, "", "measured"},
    {"dofs", Kind::directions, "of `dttmm modes` and `dttmm frf`: directions in which bodies and nodes move", "all"},
    {"nodes", Kind::named, "points inside networks, by name", "", "m", 3, {}, "", "node"},
    {"body", Kind::tables, "a rigid body", "", "", 0, {}, "", "body"},
    {"joint", Kind::tables, "an ideal joint between two bodies, or a body and the ground", "", "", 0, {}, "", "joint"},
    {"element", Kind::tables, "what stands between bodies, nodes and the ground", "", "", 0, {}, "", "element"},
    {"load",
     Kind::tables,
     "a force or moment on a body, a marker or a node, or along an element",
     "",
     "",
     0,
     {},
     "",
     "load"},
    {"case", Kind::tables, "loads that act together, for `dttmm static` and --case", "", "", 0, {}, "", "case"},
    {"defaults",
     Kind::table,
     "keys of all elements of a type, or of all bodies, joints, loads",
     "none",
     "",
     0,
     {},
     "",
     "defaults"},
    {"repeat", Kind::tables, "tables that are written once and stand for several", "", "", 0, {}, "", "repeat"},
    {"bolt_circle", Kind::tables, "equal elements on a circle between two bodies", "", "", 0, {}, "", "bolt_circle"},
    {"probe", Kind::tables, "a place on a beam, rod or body whose motion is recorded", "", "", 0, {}, "", "probe"},
};

constexpr Key kProbe[] = {
    {"name", Kind::text, "of its channels", kRequired},
    {"on", Kind::text, "a beam or rod, which gets a node there; or a body, which gets a marker", kRequired},
    {"at", Kind::number, "on a beam or rod: the distance from its `from` end", "", "m", 1, kPositive},
    {"position", Kind::numbers, "on a body: the point in its axes, from its origin", "", "m", 3, kOnBody},
};

constexpr Key kSection[] = {
    {"length", Kind::number, "along the line; together as far as its ends are apart", kRequired, "m", 1, kPositive},
};

constexpr Key kDefaults[] = {
    {"body", Kind::table, "keys of every [[body]] that has not these keys itself", "none", "", 0, {}, "", "body"},
    {"joint", Kind::table, "the same of every [[joint]]", "none", "", 0, {}, "", "joint"},
    {"load", Kind::table, "the same of every [[load]]", "none", "", 0, {}, "", "load"},
};

constexpr Key kIndexName = {"index", Kind::text,
                            "its name: \"{i}\" in names and other texts, i in expressions, is its value in each copy",
                            kRequired};
constexpr Key kCount = {"count", Kind::number, "the index is 1, 2, ... count; or values", "", "1", 1, {1, kMostCopies}};
constexpr Key kValues = {"values", Kind::numbers, "instead: the values of the index, numbers or texts", "", "1", 0};

// What a model may have several of, as in the file
constexpr Key kRepeat[] = {
    kIndexName,
    kCount,
    kValues,
    {"parameters", Kind::named, "parameters, as \"k{i}\" = \"500 N/mm\"; count and values then use no parameter"},
    {"nodes", Kind::named, "nodes, as \"low{i}\" = [\"=R*cos(pi*i/4)\", \"=R*sin(pi*i/4)\", 0]", "", "m", 3, {}, "", "node"},
    {"body", Kind::tables, "a rigid body", "", "", 0, {}, "", "body"},
    {"joint", Kind::tables, "an ideal joint", "", "", 0, {}, "", "joint"},
    {"element", Kind::tables, "an element", "", "", 0, {}, "", "element"},
    {"load", Kind::tables, "a load", "", "", 0, {}, "", "load"},
    {"case", Kind::tables, "a load case", "", "", 0, {}, "", "case"},
    {"probe", Kind::tables, "a probe", "", "", 0, {}, "", "probe"},
    {"bolt_circle", Kind::tables, "a bolt circle", "", "", 0, {}, "", "bolt_circle"},
    {"repeat", Kind::tables, "a pattern within the pattern, with an index of its own", "", "", 0, {}, "", "repeat"},
};

constexpr Key kBodyRepeat[] = {
    kIndexName,
    kCount,
    kValues,
    {"markers", Kind::named, "markers, as \"b{i}\" = [\"=R*cos(pi*i/4)\", \"=R*sin(pi*i/4)\", 0]", "", "m", 3, kOnBody, "",
     "marker"},
    {"repeat", Kind::tables, "a pattern within the pattern, with an index of its own", "", "", 0, {}, "", "body.repeat"},
};

constexpr Key kBoltCircle[] = {
    {"name", Kind::text, "its elements, and their markers on the bodies, are called name1, name2, ...", kRequired},
    {"count", Kind::number, "of bolts", kRequired, "1", 1, {1, kMostCopies}},
    {"radius", Kind::number, "of the circle", kRequired, "m", 1, kPositive},
    {"from", Kind::place, "body or marker in the centre of the circle, whose axes count; or \"ground\"", kRequired},
    {"to", Kind::place, "the same of the other end", kRequired},
    {"axis", Kind::numbers, "of the circle, in the axes of from and of to", "[0, 0, 1]", "1", 3},
    {"zero", Kind::numbers, "where angles about it begin", "the next of x, y, z behind that which axis is nearest to", "1",
     3},
    {"start_angle", Kind::number, "of the first bolt, about axis from zero", "0", "rad"},
    {"index", Kind::text, "a name for the number of the bolt in the texts of element", "none"},
    {"element",
     Kind::table,
     "what every bolt is; its local x points outwards, y along the circle, z along axis, where it has no axes of its own",
     kRequired,
     "",
     0,
     {},
     "",
     "bolt"},
};

constexpr Key kBolt[] = {
    {"type", Kind::text, "an element type with two ends; the keys of `dttmm help TYPE` but name, from and to", kRequired},
};

constexpr Key kSimulation[] = {
    {"duration", Kind::number, "of the run; `run` wants it", "", "s", 1, kPositive},
    {"step",
     Kind::number,
     "fixed time step; without it the step is chosen and halved until the tolerance holds",
     "",
     "s",
     1,
     {kShortestStep, kLongestStep}},
    {"tolerance",
     Kind::number,
     "largest error of every channel, as share of the largest value of its kind",
     "\"1 %\" without a step",
     "1",
     1,
     {kLeastTolerance, kMostTolerance}},
    {"coupling", Kind::word, "of bodies and elements", "implicit", "", 0, {}, "implicit|explicit"},
    {"scheme", Kind::word, "of the explicit coupling", "fox-euler", "", 0, {}, "fox-euler|bdf1|bdf2|houbolt|park"},
    {"spectral_radius",
     Kind::number,
     "of the implicit coupling: 1 is without numerical damping, 0 has most",
     "1",
     "1",
     1,
     {0, 1}},
    {"gravity", Kind::numbers, "acceleration in world axes", "[0, 0, 0]", "m/s^2", 3},
    {"start",
     Kind::word,
     "where bodies and nodes are at first: as the file places them, or in equilibrium",
     "assembled",
     "",
     0,
     {},
     "assembled|equilibrium"},
};

constexpr Key kOutput[] = {
    {"step", Kind::number, "time between rows", "every step", "s", 1, kPositive},
    {"channels", Kind::texts, "patterns of the channels to record; `dttmm channels` lists them", "[\"*\"] but those marked"},
};

constexpr Key kModes[] = {
    {"count", Kind::number, "how many frequencies, from the lowest; excludes below", "10", "1", 1, {1, kMostModes}},
    {"below", Kind::number, "all frequencies up to this one; excludes count", "", "Hz", 1, kPositive},
    {"beams", Kind::word, "exact waves, or the lumps of a run", "exact", "", 0, {}, "exact|lumped"},
    {"about",
     Kind::word,
     "the machine as the file places it, or its equilibrium under gravity and loads",
     "equilibrium where there are any",
     "",
     0,
     {},
     "start|equilibrium"},
};

constexpr Key kDamping[] = {
    {"modal", Kind::numbers, "damping ratio of all modes, \"2 %\"; or a list, of the first vibrations by frequency", "0",
     "1", 0, kRatio},
    {"mass_rate", Kind::number, "proportional to mass: force on every mass per momentum, against the world", "0", "1/s", 1,
     kNotNegative},
};

constexpr Key kStudy[] = {
    {"vary", Kind::texts, "parameters and how they scatter, \"k1..k4 ~ normal(500 N/mm, 10 %)\"", "[]"},
    {"correlate", Kind::texts, "parameters whose ranks are correlated, \"k1..k4 = 0.5\"", "[]"},
    {"sweep", Kind::texts, "axes of a grid, \"k1=300N/mm..500N/mm:9\"", "[]"},
    {"table", Kind::text, "a CSV file of cases, seen from the model's folder", "none"},
    {"cases", Kind::number, "how many; whole", "none", "1", 1, {1, 1e7}},
    {"seed", Kind::number, "of the random numbers; whole", "1", "1", 1, {0, 2147483647}},
    {"design",
     Kind::word,
     "how cases are spread",
     "latin",
     "",
     0,
     {},
     "latin|sobol|random|one-at-a-time|morris|sobol-indices"},
    {"command", Kind::word, "what each case does", "run", "", 0, {}, "run|modes|response"},
    {"figures", Kind::texts, "numbers of each case, \"bolt*.force.z:peak,final\"", "peak and final forces of elements"},
    {"limit", Kind::number, "a case that takes longer has failed", "none", "s", 1, {1e-3, 1e8}},
};

constexpr Key kMeasured[] = {
    {"file", Kind::text, "CSV, universal or MAT file, seen from the model's folder; --measured goes before it", "none"},
    {"input", Kind::text, "what drove measured responses, where the file does not say it: \"plate.corner1.z\"", "none"},
    {"noise", Kind::text, "standard deviation: \"1 %\" of a channel's largest value, or of each natural frequency",
     "from the data"},
    {"averages", Kind::number, "behind responses with a coherence; whole", "1", "1", 1, {1, 1e6}},
    {"clock", Kind::number, "true time per time of the file", "1", "1", 1, {0.5, 2}},
    {"hum",
     Kind::number,
     "of the mains in measured histories, \"50 Hz\": it tells the clock, and is taken off",
     "none",
     "Hz",
     1,
     {1, 1e4}},
    {"channel", Kind::tables, "what a column of the file is", "", "", 0, {}, "", "measured.channel"},
};

constexpr Key kMeasuredChannel[] = {
    {"column", Kind::text, "its name in the file", kRequired},
    {"is", Kind::text, "the channel of the model, \"plate.corner1.acceleration.z\"; with - before it: the reverse of it",
     kRequired},
    {"unit", Kind::text, "of the numbers, \"g\"", "the file's"},
    {"gain", Kind::number, "measured value per true one", "1", "1", 1, {1e-12, 1e12}},
    {"delay", Kind::number, "by which it comes too late", "0", "s", 1, {-10, 10}},
    {"noise", Kind::text, "standard deviation of this channel, \"0.05 m/s^2\" or \"1 %\" of its largest value",
     "that of all"},
};

constexpr Key kRotationOf = {"rotation", Kind::table, "of its axes against those outside, about an axis", "none", "", 0, {},
                             "",         "rotation"};
constexpr Key kQuaternion = {"quaternion", Kind::numbers, "the same as [w, x, y, z] of norm 1", "", "1", 4};

constexpr Key kNode[] = {
    {"position", Kind::numbers, "in the world; a node may be written as its position alone", kRequired, "m", 3},
    {"fixed", Kind::directions, "directions of the world in which the ground holds it", "[]"},
    {"motion", Kind::table, "how a support moves it in fixed directions", "none", "", 0, {}, "", "node.motion"},
    kRotationOf,
    kQuaternion,
    {"velocity", Kind::numbers, "at the start", "as its elements strain least", "m/s", 3},
    {"angular_velocity", Kind::numbers, "at the start", "as its elements strain least", "rad/s", 3},
};

constexpr Key kNodeMotion[] = {
    {"x", Kind::signal, "displacement over time", "0", "m", 0, {}, "", "signal"},
    {"y", Kind::signal, "displacement over time", "0", "m", 0, {}, "", "signal"},
    {"z", Kind::signal, "displacement over time", "0", "m", 0, {}, "", "signal"},
    {"rx", Kind::signal, "x of the rotation vector over time", "0", "rad", 0, {}, "", "signal"},
    {"ry", Kind::signal, "y of the rotation vector over time", "0", "rad", 0, {}, "", "signal"},
    {"rz", Kind::signal, "z of the rotation vector over time", "0", "rad", 0, {}, "", "signal"},
};

constexpr Key kBody[] = {
    {"name", Kind::text, "of its channels; no two alike", kRequired},
    {"mass", Kind::number, "with a shape instead of density, without one beside inertia", "", "kg"},
    {"inertia",
     Kind::numbers,
     "[xx, yy, zz] about the centre of mass in the body's axes, or a table of the tensor's entries",
     "",
     "kg*m^2",
     3,
     {},
     "",
     "inertia"},
    {"density", Kind::number, "of a shape", "", "kg/m^3", 1, kPositive},
    {"box", Kind::numbers, "shape: lengths along x, y, z", "", "m", 3, kPositive},
    {"cylinder", Kind::numbers, "shape: [diameter, length]", "", "m", 2, kPositive},
    {"tube", Kind::numbers, "shape: [outer diameter, inner diameter, length]", "", "m", 3, kPositive},
    {"sphere", Kind::numbers, "shape: its diameter", "", "m", 1, kPositive},
    {"axis", Kind::word, "of a cylinder or tube", "z", "", 0, {}, "x|y|z"},
    {"center_of_mass", Kind::numbers, "from the body's origin, its axes", "[0, 0, 0]", "m", 3, kOnBody},
    {"position", Kind::numbers, "of its origin at the start, world", "[0, 0, 0]", "m", 3},
    kRotationOf,
    kQuaternion,
    {"velocity", Kind::numbers, "of its origin at the start, world axes", "[0, 0, 0]", "m/s", 3},
    {"angular_velocity", Kind::numbers, "at the start, world axes", "[0, 0, 0]", "rad/s", 3},
    {"markers", Kind::named, "points of the body by name: [x, y, z] from its origin, or a table with axes", "", "m", 3,
     kOnBody, "", "marker"},
    {"repeat", Kind::tables, "markers that are written once and stand for several", "", "", 0, {}, "", "body.repeat"},
};

constexpr Key kInertia[] = {
    {"xx", Kind::number, "moment of inertia", kRequired, "kg*m^2"},
    {"yy", Kind::number, "moment of inertia", kRequired, "kg*m^2"},
    {"zz", Kind::number, "moment of inertia", kRequired, "kg*m^2"},
    {"xy", Kind::number, "entry of the tensor, minus the product of inertia", "0", "kg*m^2"},
    {"xz", Kind::number, "entry of the tensor, minus the product of inertia", "0", "kg*m^2"},
    {"yz", Kind::number, "entry of the tensor, minus the product of inertia", "0", "kg*m^2"},
};

constexpr Key kMarker[] = {
    {"position", Kind::numbers, "from the body's origin, its axes", "[0, 0, 0]", "m", 3, kOnBody},
    kRotationOf,
    kQuaternion,
};

constexpr Key kRotation[] = {
    {"axis", Kind::numbers, "of any length but zero", kRequired, "1", 3},
    {"angle", Kind::number, "right-handed about it, within a turn", kRequired, "rad"},
};

constexpr Key kJoint[] = {
    {"name", Kind::text, "of its channels; no two alike", kRequired},
    {"type", Kind::word, "what it leaves free", kRequired, "", 0, {}, "ball|hinge|slider|universal|fixed"},
    {"between", Kind::places, "two bodies or markers, or one and \"ground\"", kRequired, "", 2},
    {"anchor", Kind::point, "its point at the start, world, or the name of a marker", "the markers in between", "m", 3,
     kOnBody},
    {"axis", Kind::numbers, "of a hinge, slider or universal joint, world", "", "1", 3},
    {"axis2", Kind::numbers, "second axis of a universal joint, at right angles", "", "1", 3},
    {"limits", Kind::numbers, "stops [low, high] of a hinge's angle or a slider's travel", "none", "rad or m", 2},
    {"angle",
     Kind::signal,
     "of a hinge: a motor keeps its angle over time, 0 at the start",
     "free",
     "rad",
     0,
     {},
     "",
     "signal"},
    {"travel",
     Kind::signal,
     "of a slider: a motor keeps its travel over time, 0 at the start",
     "free",
     "m",
     0,
     {},
     "",
     "signal"},
};

constexpr Key kCase[] = {
    {"name", Kind::text, "of the case, for --case and the results; no two alike", kRequired},
    {"loads", Kind::texts, "names of loads, or of nodes that a support moves, that act once", "none"},
    {"factors", Kind::named, "factors of others by name: { snow = 1.5 }", "none"},
    {"cases", Kind::named, "factors of other cases by name, whose loads and gravity are added: { dead = 1.35 }", "none"},
    {"gravity", Kind::number, "factor of gravity", "that of `cases`, 1 without", "1"},
};

constexpr Key kLoad[] = {
    {"name", Kind::text, "for load cases; several loads may share one", "none"},
    {"on", Kind::place, "what a force or moment acts on; on a body at its origin"},
    {"element", Kind::text, "instead of on: the beam or rod along which a force_per_length acts"},
    {"direction", Kind::numbers, "in the axes; its length does not count", kRequired, "1", 3},
    {"force", Kind::signal, "its size over time; or moment", "", "N", 0, {}, "", "signal"},
    {"moment", Kind::signal, "its size over time; or force", "", "N*m", 0, {}, "", "signal"},
    {"harmonic",
     Kind::table,
     "instead: a force or moment, by the unit of its amplitude, that vibrates; a number or expression is a force [N]",
     "",
     "",
     0,
     {},
     "",
     "harmonic"},
    {"psd", Kind::table, "instead: a random force, or a moment, by the unit of its values", "", "", 0, {}, "", "psd"},
    {"unbalance", Kind::number,
     "instead: mass times eccentricity u of a rotor: a force u Omega^2 that turns about direction with the speed Omega", "",
     "kg*m"},
    {"phase", Kind::number, "of an unbalance: where it stands at t = 0, about direction from `zero`", "0", "rad"},
    {"zero", Kind::numbers, "of an unbalance: where its phase is 0",
     "the next of x, y, z behind that which direction is nearest to", "1", 3},
    {"force_per_length",
     Kind::signals,
     "all along the element's axis; or [at from, at to], linear in between",
     "",
     "N/m",
     2,
     {},
     "",
     "signal"},
    {"axes",
     Kind::word,
     "of direction; element: of a force_per_length, x from `from` to `to`; body: those of the body. Both turn with their "
     "parts (a follower load)",
     "world",
     "",
     0,
     {},
     "world|element|body"},
};

constexpr Key kElement[] = {
    {"name", Kind::text, "of its channels; no two alike", kRequired},
    {"type", Kind::text, "an element type; `dttmm elements` lists them", kRequired},
    {"from", Kind::place, "one end", kRequired},
    {"to", Kind::place, "the other end", kRequired},
    {"axes",
     Kind::word,
     "\"from\", \"to\" or { axis, angle } from the world's axes at the start",
     "those of from",
     "",
     0,
     {},
     "from|to",
     "rotation"},
    {"sections",
     Kind::tables,
     "of a beam or rod: several behind each other, from the `from` end",
     "one",
     "",
     0,
     {},
     "",
     "section"},
    {"motion", Kind::table, "of an end on the ground: how a support moves it, world", "still", "", 0, {}, "", "node.motion"},
};

constexpr Key kElementAt[] = {
    kElement[0],
    kElement[1],
    {"at", Kind::places, "a node, or a list of them", kRequired, "", 0},
};

constexpr Key type_of_signal(const char* word) { return {"type", Kind::word, "of the signal", kRequired, "", 0, {}, word}; }
constexpr Key kStart = {"start", Kind::number, "when it begins", "0", "s"};
constexpr Key kConstant[] = {type_of_signal("constant"), {"value", Kind::number, "at all times", kRequired, ""}};
constexpr Key kStep[] = {
    type_of_signal("step"),
    {"from", Kind::number, "before start", "0", ""},
    {"to", Kind::number, "after end; between them 3 s^2 - 2 s^3", kRequired, ""},
    kStart,
    {"end", Kind::number, "when it is there", kRequired, "s"},
};
constexpr Key kHaversine[] = {
    type_of_signal("haversine"),
    {"peak", Kind::number, "of peak/2 (1 - cos), zero elsewhere", kRequired, ""},
    kStart,
    {"width", Kind::number, "of the pulse", kRequired, "s", 1, kPositive},
};
constexpr Key kPulse[] = {
    type_of_signal("pulse"),
    {"peak", Kind::number, "of each pulse peak/2 (1 - cos)", kRequired, ""},
    kStart,
    {"width", Kind::number, "of each pulse", kRequired, "s", 1, kPositive},
    {"period", Kind::number, "from pulse to pulse", "needed for two and more", "s", 1, kPositive},
    {"count", Kind::number, "of pulses", "1", "1", 1, {1, 1e9}},
};
constexpr Key kSine[] = {
    type_of_signal("sine"),
    {"amplitude", Kind::number, "of offset + amplitude sin(2 pi f (t - start) + phase)", kRequired, ""},
    {"frequency", Kind::number, "f", kRequired, "Hz", 1, kNotNegative},
    {"phase", Kind::number, "at start", "0", "rad"},
    {"offset", Kind::number, "also before start", "0", ""},
    kStart,
};
constexpr Key kTable[] = {
    type_of_signal("table"),
    {"times", Kind::numbers, "increasing; linear between them, constant outside", "", "s", 0},
    {"values", Kind::numbers, "as many", "", "", 0},
    {"file", Kind::text,
     "instead: a CSV file in the model's folder, time and value; a heading and a line of units may come "
     "first"},
    {"of",
     Kind::word,
     "of a motion: what the values are of; a velocity or acceleration is zero outside and begins at rest",
     "displacement",
     "",
     0,
     {},
     "displacement|velocity|acceleration"},
};
constexpr Key kExpression[] = {type_of_signal("expression"),
                               {"value", Kind::text, "\"=...\", of t and the parameters", kRequired}};

constexpr Key kAmplitude = {"amplitude", Kind::number, "of amplitude cos(2 pi f t + phase); may be an expression of Omega",
                            kRequired, ""};
constexpr Key kPhase = {"phase", Kind::number, "at t = 0", "0", "rad"};
constexpr Key kFrequency = {"frequency", Kind::number, "f; or order", "that of `dttmm response`", "Hz", 1, kNotNegative};
constexpr Key kOrder = {"order", Kind::number, "f by the speed: order Omega/(2 pi)", "none", "1", 1, kPositive};
constexpr Key kOf = {"of",
                     Kind::word,
                     "of a motion: what the amplitude or the density is of",
                     "displacement",
                     "",
                     0,
                     {},
                     "displacement|velocity|acceleration"};
constexpr Key kHarmonic[] = {type_of_signal("harmonic"), kAmplitude, kPhase, kFrequency, kOrder, kOf};
constexpr Key kLoadHarmonic[] = {kAmplitude, kPhase, kFrequency, kOrder};
constexpr Key kFrequencies = {"frequencies", Kind::numbers, "increasing; the density is zero outside", kRequired, "Hz", 0,
                              kNotNegative};
constexpr Key kDensities = {"values", Kind::numbers, "one-sided densities, as many: its unit squared per Hz", kRequired, "",
                            0,        kNotNegative};
constexpr Key kInterpolation = {
    "interpolation", Kind::word, "log: straight between the points on double logarithmic paper", "linear", "", 0, {},
    "linear|log"};
constexpr Key kPsd[] = {type_of_signal("psd"), kFrequencies, kDensities, kInterpolation, kOf};
constexpr Key kLoadPsd[] = {kFrequencies, kDensities, kInterpolation};

constexpr KeyTable kTables[] = {
    {"file", "", "the model file, TOML", "spring_damper", kFile},
    {"simulation", "[simulation]", "how a run goes", "spring_damper", kSimulation},
    {"output", "[output]", "what a run records", "joint", kOutput},
    {"modes", "[modes]", "natural frequencies", "beam", kModes},
    {"damping", "[damping]", "damping beside that of elements, in vibration at one frequency", "beam", kDamping},
    {"study", "[study]", "cases of `dttmm study`; options of the command count instead of keys", "study", kStudy},
    {"measured", "[measured]", "measured data, and what they are in the model, for `dttmm identify` and `dttmm diagnose`",
     "measured", kMeasured},
    {"measured.channel", "[[measured.channel]]", "what a column of the measured file is", "measured", kMeasuredChannel},
    {"node", "[nodes]", "a node, name = { ... }, or name = [x, y, z]", "point_mass", kNode},
    {"node.motion", "motion = { }",
     "how a support moves a node or the ground end of an element, from its place at the start, world", "point_mass",
     kNodeMotion},
    {"body", "[[body]]", "a rigid body: a shape with density or mass, or mass and inertia", "spring_damper", kBody},
    {"inertia", "inertia = { }", "the tensor of inertia of a body", "joint", kInertia},
    {"marker", "markers = { }", "a point of a body", "spring_damper", kMarker},
    {"rotation", "rotation = { }", "a turn about an axis", "joint", kRotation},
    {"joint", "[[joint]]", "an ideal joint; its force acts on the first body", "joint", kJoint},
    {"load", "[[load]]", "a force, a moment or a force per length", "spring_damper", kLoad},
    {"case", "[[case]]", "a load case: the loads that act, and how often", "beam", kCase},
    {"defaults", "[defaults]",
     "keys that are written once for all: [defaults.beam] of every beam, so of each element type; own keys count whole",
     "repeat", kDefaults},
    {"repeat", "[[repeat]]", "tables that are written once and stand for several: one for each value of the index", "repeat",
     kRepeat},
    {"body.repeat", "[[body.repeat]]", "the same of the markers of a body", "repeat", kBodyRepeat},
    {"bolt_circle", "[[bolt_circle]]", "equal elements on a circle between two bodies, or a body and the ground",
     "bolt_circle", kBoltCircle},
    {"probe", "[[probe]]",
     "a place whose motion is recorded; on a beam or rod its section too: force and moment of the element behind it, "
     "BEAM_NAME",
     "probe", kProbe},
    {"section", "sections = [{ }]",
     "one of the sections of a beam or rod, with any keys of its type, which count before those of the element", "probe",
     kSection},
    {"bolt", "element = { }", "the element that each bolt of a circle is", "bolt_circle", kBolt},
    {"element", "[[element]]", "an element between two ends; `dttmm help TYPE` has the keys of its type", "spring_damper",
     kElement},
    {"element.at", "[[element]]", "an element at nodes", "rigid_body", kElementAt},
    {"signal.constant", "force = { }", "a constant", "spring_damper", kConstant},
    {"signal.step", "force = { }", "a smooth step", "spring_damper", kStep},
    {"signal.haversine", "force = { }", "one pulse", "spring_damper", kHaversine},
    {"signal.pulse", "force = { }", "a train of pulses", "spring_damper", kPulse},
    {"signal.sine", "force = { }", "a sine", "spring_damper", kSine},
    {"signal.harmonic", "force = { }", "a vibration of one frequency or of an order of the speed, for `dttmm response` too",
     "spring_damper", kHarmonic},
    {"signal.psd", "force = { }", "a random vibration, for `dttmm response`", "spring_damper", kPsd},
    {"harmonic", "harmonic = { }", "a harmonic force or moment", "spring_damper", kLoadHarmonic},
    {"psd", "psd = { }", "a random force or moment", "spring_damper", kLoadPsd},
    {"signal.table", "force = { }", "points", "spring_damper", kTable},
    {"signal.expression", "force = { }", "an expression of t", "spring_damper", kExpression},
};

}  // namespace

std::span<const KeyTable> key_tables() { return kTables; }

const KeyTable& key_table(std::string_view name) {
    const auto found = std::ranges::find_if(kTables, [&](const KeyTable& table) { return table.name == name; });
    if (found == std::end(kTables))
        throw Error(ExitCode::internal_error, fmt::format("there is no table of keys \"{}\"", name));
    return *found;
}

const Key* find_key(const KeyTable& table, std::string_view name) {
    const auto found = std::ranges::find_if(table.keys, [&](const Key& key) { return key.name == name; });
    return found == table.keys.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(const KeyTable& table) {
    std::vector<std::string> names;
    for (const Key& key : table.keys) names.emplace_back(key.name);
    return names;
}

std::vector<std::string> words_of(const Key& key) {
    std::vector<std::string> words;
    std::string_view rest = key.words;
    while (!rest.empty()) {
        const size_t bar = std::min(rest.find('|'), rest.size());
        words.emplace_back(rest.substr(0, bar));
        rest.remove_prefix(std::min(bar + 1, rest.size()));
    }
    return words;
}

}  // namespace dttmm::host
