// SPDX-License-Identifier: BSD-3-Clause
#include "support/hydroplane_finite_elements.h"

#include <array>

namespace dttmm::test {

FiniteElements hydroplane(double kh, int count, FiniteElements::Across rod) {
    using Vector6 = FiniteElements::Vector6;
    using Vector3 = FiniteElements::Vector3;
    static constexpr double rigid = FiniteElements::kRigid;
    FiniteElements model;
    model.restrict(FiniteElements::Dofs("101011"));  // rz, rx, y, x from the left
    const auto joint = [](double x, double y, double rx, double rz) { return Vector6(x, y, rigid, rx, rigid, rz); };

    struct Blade {
        double EA, EIz, GJ, mass, inertia, offset;
    };
    const std::array<Blade, 7> blade{{{3e8, 2e5, 1.2e5, 60, 3, 0.08},
                                      {4e8, 3.5e5, 2e5, 70, 3.8, 0.08},
                                      {5e8, 5.5e5, 3e5, 80, 4.6, 0.09},
                                      {6e8, 8e5, 4.5e5, 90, 5.5, 0.09},
                                      {7e8, 1.1e6, 6e5, 100, 6.4, 0.1},
                                      {8e8, 1.5e6, 8e5, 110, 7.4, 0.1},
                                      {9e8, 2e6, 1e6, 120, 8.5, 0.1}}};  // from tip to hub
    const auto section = [](const Blade& b) {
        return FiniteElements::Section{
            .EA = b.EA, .EIz = b.EIz, .GJ = b.GJ, .mass = b.mass, .inertia = b.inertia, .mass_offset = {0, b.offset}};
    };
    int last = model.node({-1.4, 0, 0});
    for (int i = 0; i < 7; ++i) {
        const int next = model.node({-1.2 + 0.2 * i, 0, 0});
        model.beam(last, next, section(blade[static_cast<std::size_t>(i)]), count);
        last = next;
    }
    const int hub_left = last, hub_right = model.node({0.9, 0, 0});
    last = hub_right;
    for (int i = 0; i < 7; ++i) {
        const int next = model.node({1.1 + 0.2 * i, 0, 0});
        model.beam(last, next, section(blade[static_cast<std::size_t>(6 - i)]), count);
        last = next;
    }

    // The tiller is a body on its left marker
    const int left = model.node({0.3, 0, 0}), right = model.node({0.6, 0, 0}), arm = model.node({0.45, 0, 0.35}),
              guide = model.node({0.45, 0, -0.2});
    for (const int marker : {right, arm, guide}) model.rigid_link(left, marker);
    Eigen::Matrix3d inertia = Vector3(8, 12, 10).asDiagonal();
    inertia(0, 2) = inertia(2, 0) = 0.5;
    model.mass(left, 150, {0.15, 0, 0.1}, inertia);
    const FiniteElements::Section shaft{.EA = 2e9, .EIz = 3e6, .GJ = 2.3e6, .mass = 78, .inertia = 0.12};
    model.beam(hub_left, left, shaft, count);
    model.beam(right, hub_right, shaft, count);

    for (const int hub : {hub_left, hub_right}) {
        const int bearing = model.node({hub == hub_left ? 0.0 : 0.9, 0, 0});
        model.joint(FiniteElements::kGround, bearing, joint(rigid, 5e8, 0, rigid));
        model.joint(bearing, hub, joint(1e8, 5e8, rigid, rigid));
    }
    const int slider = model.node({0.45, 0, -0.2});
    model.joint(FiniteElements::kGround, slider, joint(0, 2e8, 0, 0));
    model.joint(slider, guide, joint(rigid, 2e8, rigid, rigid));

    const int foot = model.node({0.45, -1.1, 0.35}), rod_bottom = model.node({0.45, -1.1, 0.35}),
              rod_top = model.node({0.45, -0.6, 0.35}), link_bottom = model.node({0.45, -0.6, 0.35}),
              link_top = model.node({0.45, 0, 0.35});
    model.joint(FiniteElements::kGround, foot, joint(1e8, 5e8, rigid, rigid));
    model.joint(foot, rod_bottom, joint(1e8, kh, rigid, rigid));
    model.rod(rod_bottom, rod_top, 1e9, 30, count, rod);
    model.joint(rod_top, link_bottom, joint(1e8, 8e8, 2e4, 2e4));
    model.beam(link_bottom, link_top, {.EA = 1.5e9, .EIz = 2e5, .mass = 40}, count);
    model.joint(link_top, arm, joint(rigid, 8e8, 5e4, rigid));
    return model;
}

}  // namespace dttmm::test
