// SPDX-License-Identifier: BSD-3-Clause
#include "element/section.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "element/parameters.h"

namespace dttmm::plugin {

double cowper_tube(double nu, double m) {
    const double outer = (1 + m * m) * (1 + m * m);
    return 6 * (1 + nu) * outer / ((7 + 6 * nu) * outer + (20 + 12 * nu) * m * m);
}

double cowper_rectangle(double nu) { return 10 * (1 + nu) / (12 + 11 * nu); }

namespace {

/// The values by name.
struct Given {
    double outer, inner, diameter, width, height, kappa;
    double EA, EIy, EIz, GJ, GAy, GAz, mass, inertia, offset_y, offset_z;
    double E, G, poisson, density, stiffness_damping, loss_factor;

    explicit Given(std::span<const double, kSectionValueCount> v)
        : outer(v[0]),
          inner(v[1]),
          diameter(v[2]),
          width(v[3]),
          height(v[4]),
          kappa(v[5]),
          EA(v[6]),
          EIy(v[7]),
          EIz(v[8]),
          GJ(v[9]),
          GAy(v[10]),
          GAz(v[11]),
          mass(v[12]),
          inertia(v[13]),
          offset_y(v[14]),
          offset_z(v[15]),
          E(v[16]),
          G(v[17]),
          poisson(v[18]),
          density(v[19]),
          stiffness_damping(v[20]),
          loss_factor(v[21]) {}

    int shapes() const { return is_given(outer) + is_given(diameter) + is_given(width); }
};

[[noreturn]] void refuse(const std::string& text) { throw Error(DTTMM_ERROR_MODEL, text); }

/// A shape: area [m²], second moments about y and z, torsion constant [m⁴], shear coefficient; its extent along y and z [m].
struct Shape {
    double A, Iy, Iz, J, kappa, width, height;
    bool is_round;
};

/// Saint-Venant's torsion constant of a rectangle, a ≥ b: a b³ (1/3 − (64/π⁵)(b/a) Σ tanh(nπa/2b)/n⁵), n odd.
double torsion_of_rectangle(double a, double b) {
    double sum = 0;
    for (int n = 1; n < 40; n += 2) sum += std::tanh(0.5 * n * M_PI * a / b) / std::pow(n, 5);
    return a * b * b * b * (1.0 / 3 - 64 / std::pow(M_PI, 5) * (b / a) * sum);
}

Shape tube(double outer, double inner, double poisson) {
    if (!(outer > 0)) refuse("section.tube: the outer diameter must be more than zero");
    if (inner >= outer)
        refuse(fmt::format("section.tube: the inner diameter, {:g} m, must be less than the outer, {:g} m", inner, outer));
    const double Di2 = inner * inner, Do2 = outer * outer, I = M_PI / 64 * (Do2 * Do2 - Di2 * Di2);
    return {M_PI / 4 * (Do2 - Di2), I, I, 2 * I, cowper_tube(poisson, inner / outer), outer, outer, true};
}

Shape make_shape(const Given& given, double poisson) {
    if (is_given(given.outer)) return tube(given.outer, given.inner, poisson);
    if (is_given(given.diameter)) return tube(given.diameter, 0, poisson);
    const double b = given.width, h = given.height;  // along y and z
    return {b * h,
            b * h * h * h / 12,
            h * b * b * b / 12,
            torsion_of_rectangle(std::max(b, h), std::min(b, h)),
            cowper_rectangle(poisson),
            b,
            h,
            false};
}

Section from_shape(const Given& given) {
    for (const auto& [value, key] : {std::pair(given.E, "material.E"), std::pair(given.density, "material.density")})
        if (!is_given(value)) refuse(fmt::format("{} is needed with a section given by its shape", key));
    const double values[] = {given.EA, given.EIy, given.EIz, given.GJ, given.GAy, given.GAz, given.mass, given.inertia};
    const char* keys[] = {"EA", "EIy", "EIz", "GJ", "GAy", "GAz", "mass", "inertia"};
    for (size_t i = 0; i < std::size(values); ++i)
        if (is_given(values[i]))
            refuse(fmt::format("section.{} contradicts the shape of the section: give one or the other", keys[i]));
    if (!is_given(given.G) && !is_given(given.poisson)) refuse("material.poisson or material.G is needed");
    const double poisson = is_given(given.poisson) ? given.poisson : given.E / (2 * given.G) - 1;
    if (!(poisson > -1 && poisson < 0.5))
        refuse(fmt::format("material.G: with E it makes Poisson's ratio {:.4g}, which must be between -1 and 0.5", poisson));
    const double G = is_given(given.G) ? given.G : given.E / (2 * (1 + poisson));
    const Shape shape = make_shape(given, poisson);
    const double kappa = is_given(given.kappa) ? given.kappa : shape.kappa;
    Section section;
    section.EA = given.E * shape.A;
    section.EIy = given.E * shape.Iy;
    section.EIz = given.E * shape.Iz;
    section.GJ = G * shape.J;
    section.GAy = section.GAz = kappa * G * shape.A;
    section.mass = given.density * shape.A;
    section.rotary_y = given.density * shape.Iy;
    section.rotary_z = given.density * shape.Iz;
    section.inertia = section.rotary_y + section.rotary_z;
    section.moduli = {shape.A, 2 * shape.Iy / shape.height, 2 * shape.Iz / shape.width, shape.is_round};
    return section;
}

Section from_stiffness(const Given& given) {
    if (!is_given(given.EA)) refuse("section: give its shape (tube, circle or rectangle) or at least EA and mass");
    for (const auto& [value, key] : {std::pair(given.E, "E"), std::pair(given.G, "G"), std::pair(given.poisson, "poisson"),
                                     std::pair(given.density, "density")})
        if (is_given(value))
            refuse(
                fmt::format("material.{} is not looked at where the section is given by its stiffness: remove it, or give "
                            "its shape",
                            key));
    if (is_given(given.kappa)) refuse("section.shear_coefficient belongs to a shape: here give GAy and GAz");
    if (!is_given(given.mass)) refuse("section.mass is needed beside section.EA");
    Section section;
    section.EA = given.EA;
    section.EIy = given.EIy;
    section.EIz = given.EIz;
    section.GJ = given.GJ;
    section.GAy = given.GAy;
    section.GAz = given.GAz;
    section.mass = given.mass;
    // Of one material throughout, I/A = EI/EA
    section.rotary_y = given.mass * given.EIy / given.EA;
    section.rotary_z = given.mass * given.EIz / given.EA;
    section.inertia = is_given(given.inertia) ? given.inertia : section.rotary_y + section.rotary_z;
    return section;
}

/// Beyond any material and size [SI]; further out numbers overflow on their way.
constexpr double kWeakest = 1e-30, kStrongest = 1e30;

void check_size(const Section& s) {
    for (const auto& [value, name] :
         {std::pair(s.EA, "EA"), std::pair(s.EIy, "EIy"), std::pair(s.EIz, "EIz"), std::pair(s.GJ, "GJ"),
          std::pair(s.GAy, "GAy"), std::pair(s.GAz, "GAz"), std::pair(s.mass, "mass")})
        if (is_given(value) && !(value >= kWeakest && value <= kStrongest))
            refuse(
                fmt::format("section: its {} comes to {:.3g} in SI units, which must be in [{:g}, {:g}]: look at the "
                            "numbers and units of section and material",
                            name, value, kWeakest, kStrongest));
}

}  // namespace

double SectionModuli::extreme_stress(double axial, double moment_y, double moment_z) const {
    const double bending =
        is_round ? std::hypot(moment_y, moment_z) / about_y : std::abs(moment_y) / about_y + std::abs(moment_z) / about_z;
    return axial / area + std::copysign(bending, axial);
}

Section make_section(std::span<const double, kSectionValueCount> values, BeamTheory theory) {
    const Given given(values);
    if (given.shapes() > 1) refuse("section: give one of tube, circle and rectangle");
    Section section = given.shapes() == 1 ? from_shape(given) : from_stiffness(given);
    check_size(section);
    if (theory == BeamTheory::euler_bernoulli) {
        section.GAy = section.GAz = std::numeric_limits<double>::infinity();
        section.rotary_y = section.rotary_z = 0;
    }
    section.stiffness_damping = given.stiffness_damping;
    section.loss_factor = given.loss_factor;
    if (!is_given(given.offset_y)) return section;
    section.offset_y = given.offset_y;
    section.offset_z = given.offset_z;
    const double shifted = section.mass * (given.offset_y * given.offset_y + given.offset_z * given.offset_z);
    // Units, squares, sum and product round the bound by an eps each at most
    constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
    if (!is_given(given.inertia))
        section.inertia += shifted;  // that of a shape, or of EI/EA, is about its own centre
    else if (section.inertia < shifted * (1 - kRounding))
        refuse(
            fmt::format("section.inertia is that about the elastic axis: with this mass_offset it is at least mass times "
                        "offset squared, {:.4g} kg m",
                        shifted));
    else
        section.inertia = std::max(section.inertia, shifted);
    return section;
}

}  // namespace dttmm::plugin
