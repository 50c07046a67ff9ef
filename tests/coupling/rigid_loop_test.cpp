// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/rigid_loop.h"

#include <gtest/gtest.h>

#include <string>

#include "loader/plugins.h"
#include "model/read_model.h"

namespace dttmm::host {
namespace {

// Oracle: the drawings. A chain of rigid hinges has no loop; back to the ground it has one, unless a spring closes it.
TEST(RigidLoop, ChainsAndLoops) {
    const Plugins plugins;
    const auto loop = [&](const std::string& end, const std::string& closing) {
        const std::string text =
            "format = \"dttmm/1\"\n[simulation]\nstep = 1e-3\nduration = 1\n[nodes]\na = [0, 0, 0]\nb = "
            "[1, 0, 0]\nc = { position = [1, 1, 0]" +
            end +
            " }\n[[element]]\nname = \"foot\"\ntype = \"elastic_hinge\"\nfrom = \"ground\"\nto = "
            "\"a\"\n[[element]]\nname = \"bar\"\ntype = \"rigid_body\"\nat = [\"a\", \"b\"]\nmass = "
            "1\ninertia = { xx = 1, yy = 1, zz = 1 }\n[[element]]\nname = \"end\"\ntype = "
            "\"point_mass\"\nat = \"c\"\nmass = 1\n" +
            closing;
        return form_rigid_loop(parse_model(text, "model.toml", plugins.catalogue()), plugins.catalogue());
    };
    const std::string spring =
        "[[element]]\nname = \"s\"\ntype = \"spring_damper\"\nfrom = \"b\"\nto = \"c\"\nstiffness = 1e3\n";
    const std::string rod = "[[element]]\nname = \"r\"\ntype = \"elastic_hinge\"\nfrom = \"b\"\nto = \"c\"\n";
    EXPECT_FALSE(loop("", spring));
    EXPECT_FALSE(loop("", rod));
    EXPECT_FALSE(loop(", fixed = [\"x\"]", spring));
    EXPECT_TRUE(loop(", fixed = [\"x\"]", rod));
}

}  // namespace
}  // namespace dttmm::host
