// SPDX-License-Identifier: BSD-3-Clause
#include "model/tree_places.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

// Oracle: by hand, a quarter turn about z: x becomes y. The reader of the model finds the same.
TEST(TreePlaces, AreThoseOfTheModel) {
    const std::string text = R"toml([parameters]
a = "30 mm"
[nodes]
bare = [1, "=2*a", 3]
full = { position = [4, 5, 6], rotation = { axis = [1, 0, 0], angle = 1 } }
[[body]]
name = "arm"
position = [1, 2, 3]
rotation = { axis = [0, 0, 1], angle = "90 deg" }
markers = { end = ["=a", 0, 1], mount = { position = [0, "=a", 0] } }
faulty = 3
)toml";
    Diagnostics diagnostics("m.toml");
    const auto document = parse_toml(text, diagnostics);
    ASSERT_TRUE(document);
    const Parameters parameters(&document->find("parameters")->value, nullptr, {}, diagnostics);
    InputFiles inputs;
    const ReadContext context{parameters, diagnostics, inputs};
    const auto place = [&](const char* name) { return find_tree_place(context, *document, name); };
    EXPECT_EQ(*place("bare"), Eigen::Vector3d(1, 0.06, 3));
    EXPECT_EQ(*place("full"), Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(*place("arm"), Eigen::Vector3d(1, 2, 3));
    EXPECT_LT((*place("arm.end") - Eigen::Vector3d(1, 2.03, 4)).norm(), 1e-15);
    EXPECT_LT((*place("arm.mount") - Eigen::Vector3d(0.97, 2, 3)).norm(), 1e-15);
    for (const char* name : {"ground", "arm.none", "none", "bare.end"}) EXPECT_FALSE(place(name)) << name;
    EXPECT_FALSE(diagnostics.has_errors());  // the key that is no key is reported by the reader of bodies
}

}  // namespace
}  // namespace dttmm::host
