// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// Codes of the universal file format.
enum class UniversalFunction : int {
    general = 0,
    time_response = 1,
    frequency_response = 4,
    transmissibility = 5,
    power_spectral_density = 9,
    spectrum = 12
};
enum class UniversalQuantity : int {
    unknown = 0,
    general = 1,
    stress = 2,
    displacement = 8,
    velocity = 11,
    acceleration = 12,
    force = 13,
    time = 17,
    frequency = 18,
    rpm = 19,
    order = 20
};

/// What stands along an axis of a function. Exponents: of length, force and temperature in its unit.
struct UniversalAxis {
    UniversalQuantity quantity = UniversalQuantity::unknown;
    std::array<int, 3> exponents = {0, 0, 0};
    std::string label, unit;
};

/// A place and a direction: +-1..3 along x, y, z, +-4..6 about them, 0 none. Node 0: no place is known.
struct UniversalDegree {
    std::string name;  ///< of the part; at most 10 bytes are written
    int node = 0, direction = 0;
};

/// Dataset 58: a function at discrete abscissae.
struct UniversalCurve {
    std::array<std::string, 5> lines;  ///< texts of 80 bytes; by custom the third is the date
    UniversalFunction function = UniversalFunction::general;
    int number = 1;
    UniversalDegree response, reference;
    UniversalAxis abscissa, numerator, denominator;
    std::vector<double> places;  ///< ascending, in the unit of the abscissa
    /// One per place: real or complex. The other is empty.
    std::span<const double> real;
    std::span<const std::complex<double>> complex;
};

struct UniversalNode {
    int label;
    Eigen::Vector3d position;  ///< [m], world axes
};

/// Dataset 55: displacements (three) and rotations (three) of nodes in a mode.
struct UniversalMode {
    std::array<std::string, 5> lines;
    int number = 1;
    /// Without damping: natural frequency [Hz], modal mass [kg], shares of viscous and hysteretic damping.
    double frequency = 0, modal_mass = 0, viscous_damping = 0;
    std::vector<int> labels;                                   ///< of the nodes
    std::vector<std::array<double, 6>> real;                   ///< one per node; empty for a complex mode
    std::complex<double> eigenvalue;                           ///< [1/s] of a complex mode
    std::vector<std::array<std::complex<double>, 6>> complex;  ///< one per node; empty for a real mode
};

/// Writes datasets of the universal file format as text: fields of fixed width, lines of at most 80 bytes ended by a line
/// feed, SI units. Numbers never touch: a magnitude below 1e-99, whose exponent has three digits, is written as zero.
/// Texts: control characters become blanks, blanks in front are left out, an empty one is NONE, and a long one is cut
/// between characters. They are UTF-8; columns count bytes.
/// Source: SDRC, Universal File Formats, datasets 15, 55, 58, 151, 164, 2411.
class UniversalFile {
public:
    explicit UniversalFile(std::ostream& out) : out_(out) {}

    /// Dataset 151. date: "25-Nov-26"; time: "08:03:00".
    void write_header(std::string_view title, std::string_view description, std::string_view program, std::string_view date,
                      std::string_view time);
    /// Dataset 164: SI, absolute temperatures.
    void write_units();
    /// Dataset 15, in single precision, and 2411, in double precision: two forms of the same.
    void write_nodes_15(std::span<const UniversalNode> nodes);
    void write_nodes_2411(std::span<const UniversalNode> nodes);
    /// Double precision. Abscissae at equal distances are written as first and distance. Others stand beside their values.
    /// The format has 13 columns for an abscissa: eleven digits of most, seven of those below 1e-3 and from 1e9 on.
    void write(const UniversalCurve& curve);
    /// The format has 13 columns for the numbers of a mode, too.
    void write(const UniversalMode& mode);

private:
    void begin(int dataset);
    void end();
    void write_line(std::string_view text) { out_ << text << '\n'; }

    std::ostream& out_;
};

/// Whether abscissae are at equal distances, to a millionth of the distance.
bool are_even(std::span<const double> places);

/// Different abscissae that 13 columns cannot tell apart from the one before: how many.
std::size_t count_merged(std::span<const double> places);

}  // namespace dttmm::host
