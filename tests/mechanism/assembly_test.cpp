// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/assembly.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "core/error.h"
#include "core/rotation.h"
#include "element/registry.h"
#include "support/element_values.h"

namespace dttmm::plugin {
namespace {

using test::Given;
using testing::HasSubstr;
using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kRigidWord = std::numeric_limits<double>::infinity();
const Given kSpring = {{"stiffness", {5e5, 7.3e6, 1.2e4}}, {"rotational_stiffness", {2e3, 8.1e4, 300}}};
const Given kBeam = {{"segments", {3}},        {"section.EA", {3.1e8}},  {"section.EIy", {5.2e4}},
                     {"section.EIz", {7.7e3}}, {"section.GJ", {1.9e4}},  {"section.GAy", {6e6}},
                     {"section.GAz", {8.5e7}}, {"section.mass", {13.7}}, {"section.inertia", {0.2}}};
const Given kBody = {{"mass", {3.7}},        {"center_of_mass", {0.02, -0.05, 0.31}},
                     {"inertia.xx", {0.11}}, {"inertia.yy", {0.17}},
                     {"inertia.zz", {0.19}}, {"inertia.xy", {0.013}},
                     {"inertia.xz", {-0.02}}};

/// A description in the making; keeps what it points at.
class Description {
public:
    /// Its place and axes follow from its number: no two alike, all turned.
    uint32_t node(const char* name, uint32_t kind, uint32_t fixed = 0) {
        const double n = static_cast<double>(nodes.size());
        dttmm_node node{name, kind, static_cast<uint32_t>(bodies.size()), {}, {}, fixed, 0, {}, {}};
        Eigen::Map<Vector3>{node.position} = Vector3(0.3 * n, 0.1 - 0.05 * n * n, 0.2 + 0.07 * n);
        Eigen::Map<RowMajor>{node.rotation} = rotation_from_vector(Vector3(0.4 + n, -0.8, 1.3 - 0.5 * n));
        nodes.push_back(node);
        if (kind == DTTMM_NODE_ON_BODY) {
            dttmm_body body{name, {}, {}, 1, {}};
            Eigen::Map<Vector3>{body.position} = Vector3(0.2 - n, 0.4, 0.1 * n);
            Eigen::Map<RowMajor>{body.rotation} = rotation_from_vector(Vector3(-0.3, 0.7 - n, 0.2));
            bodies.push_back(body);
        }
        return static_cast<uint32_t>(nodes.size() - 1);
    }

    void element(const char* name, const std::string& type, std::vector<uint32_t> ends, const Given& given) {
        uint32_t index = 0;
        while (element_types()[index].name != type) ++index;
        ends_.push_back(std::move(ends));
        values_.push_back(test::values_of(element_types()[index], given));
        elements.push_back(
            {name, index, static_cast<uint32_t>(ends_.back().size()), ends_.back().data(), values_.back().data()});
    }

    dttmm_network network() const {
        return {static_cast<uint32_t>(bodies.size()),
                bodies.data(),
                static_cast<uint32_t>(nodes.size()),
                nodes.data(),
                static_cast<uint32_t>(elements.size()),
                elements.data(),
                DTTMM_SCHEME_CENTRED,
                0.25,
                0.5,
                {},
                0,
                nullptr,
                0,
                nullptr,
                nullptr,
                0};
    }
    Assembly assembled() const { return assemble(network()); }

    Vector3 position(uint32_t n) const { return Eigen::Map<const Vector3>(nodes[n].position); }
    Matrix3 rotation(uint32_t n) const { return Eigen::Map<const RowMajor>(nodes[n].rotation); }

    std::vector<dttmm_body> bodies;
    std::vector<dttmm_node> nodes;
    std::vector<dttmm_element> elements;

private:
    std::deque<std::vector<uint32_t>> ends_;
    std::deque<std::vector<double>> values_;
};

/// Every node where the description has it, as a point of its frame.
void expect_nodes_in_place(const Description& description, const Assembly& assembly) {
    ASSERT_EQ(assembly.nodes.size(), description.nodes.size());
    for (uint32_t n = 0; n < assembly.nodes.size(); ++n) {
        const NodeSpec& spec = assembly.nodes[n];
        ASSERT_TRUE(spec.frame >= 0 && spec.frame < static_cast<int>(assembly.frames.size())) << n;
        const Pose& frame = assembly.frames[static_cast<size_t>(spec.frame)].pose;
        EXPECT_LT((frame.position + frame.rotation * spec.offset - description.position(n)).norm(), 3e-15) << n;
        EXPECT_LT((frame.rotation * spec.rotation - description.rotation(n)).norm(), 1e-14) << n;
    }
}

// ---- Order --------------------------------------------------------------------------------------------------------------

// The bodies first, in their order, then the ground, then what is inside; joints element by element from `from` to `to`.
TEST(Assembly, PortsComeFirstThenTheGroundThenTheInside) {
    Description d;
    const auto inner = d.node("i", DTTMM_NODE_INNER), right = d.node("r", DTTMM_NODE_ON_BODY),
               wall = d.node("w", DTTMM_NODE_GROUND), left = d.node("l", DTTMM_NODE_ON_BODY),
               held = d.node("h", DTTMM_NODE_INNER, 0x3f);
    d.element("spring", "spring_damper", {inner, held}, kSpring);
    d.element("mass", "point_mass", {inner}, {{"mass", {2.5}}});
    d.element("beam", "beam", {right, inner}, kBeam);
    d.element("other", "spring_damper", {wall, left}, kSpring);
    const Assembly a = d.assembled();
    EXPECT_EQ(a.port_count, 2);
    EXPECT_EQ(a.driven_count, 4);
    EXPECT_EQ(a.inner_count(), 4) << "a node and three segments";
    std::vector<std::string> names;
    for (const FrameSpec& frame : a.frames) names.push_back(frame.name());
    EXPECT_EQ(names, (std::vector<std::string>{"body \"r\"", "body \"l\"", "node \"w\"", "node \"h\"", "node \"i\"",
                                               "segment 1 of element \"beam\"", "segment 2 of element \"beam\"",
                                               "segment 3 of element \"beam\""}));
    const int elements[] = {2, 3, 3, 0, 0, 2, 2, 2};
    for (size_t f = 0; f < a.frames.size(); ++f) {
        EXPECT_EQ(a.frames[f].element, elements[f]) << names[f];
        EXPECT_EQ(a.frames[f].kind, f < 2   ? FrameSpec::Kind::port
                                    : f < 4 ? FrameSpec::Kind::ground
                                            : FrameSpec::Kind::inner)
            << names[f];
    }
    EXPECT_EQ(a.first_joint, (std::vector<int>{0, 1, 1, 5, 6}));
    const int ends[][3] = {{0, 4, 3}, {2, 0, 5}, {2, 5, 6}, {2, 6, 7}, {2, 7, 4}, {3, 2, 1}};  // element, from, to
    ASSERT_EQ(a.joints.size(), 6u);
    for (size_t j = 0; j < 6; ++j) {
        EXPECT_EQ(a.joints[j].element, ends[j][0]) << j;
        EXPECT_EQ(a.joints[j].from, ends[j][1]) << j;
        EXPECT_EQ(a.joints[j].to, ends[j][2]) << j;
    }
    EXPECT_EQ(a.joints[0].pose.position, d.position(held)) << "a spring's joint stands at its `to` end";
    EXPECT_EQ(a.joints[0].pose.rotation, d.rotation(inner)) << "in the axes of its `from` end";
    expect_nodes_in_place(d, a);
}

// ---- Welding ------------------------------------------------------------------------------------------------------------

// Oracle: mass, centre of mass and Steiner's tensor of a point and a body at one node, by hand in the axes of the node; a
// second node of the body is a point of the same frame, and a third mass joins there.
TEST(Assembly, MassesAtANodeBecomeOne) {
    Description d;
    const auto wall = d.node("wall", DTTMM_NODE_GROUND), first = d.node("first", DTTMM_NODE_INNER),
               second = d.node("second", DTTMM_NODE_INNER);
    d.element("spring", "spring_damper", {wall, second}, kSpring);
    d.element("point", "point_mass", {first}, {{"mass", {2.5}}});
    d.element("body", "rigid_body", {first, second}, kBody);
    d.element("more", "point_mass", {second}, {{"mass", {0.6}}});
    const Assembly a = d.assembled();
    ASSERT_EQ(a.inner_count(), 1);
    const FrameSpec& frame = a.frames[1];

    const Matrix3 R = d.rotation(first);
    const Vector3 points[] = {d.position(first), d.position(first) + R * Vector3(0.02, -0.05, 0.31), d.position(second)};
    const double masses[] = {2.5, 3.7, 0.6};
    const Vector3 centre = (2.5 * points[0] + 3.7 * points[1] + 0.6 * points[2]) / 6.8;
    Matrix3 tensor;
    tensor << 0.11, 0.013, -0.02, 0.013, 0.17, 0, -0.02, 0, 0.19;
    for (int i = 0; i < 3; ++i) {
        const Vector3 r = R.transpose() * (points[i] - centre);
        tensor += masses[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
    }
    EXPECT_DOUBLE_EQ(frame.mass, 6.8);
    EXPECT_LT((frame.pose.position - centre).norm(), 1e-15);
    EXPECT_EQ(frame.pose.rotation, R);
    EXPECT_LT((frame.inertia - tensor).norm(), 1e-14 * tensor.norm());
    EXPECT_EQ(frame.name(), "node \"first\"");
    EXPECT_EQ(frame.kind, FrameSpec::Kind::inner);
    EXPECT_EQ(a.joints[0].to, 1);
    EXPECT_EQ(a.joints[0].pose.position, d.position(second)) << "where it is, not at the centre of mass";
    expect_nodes_in_place(d, a);
}

// Oracle: masses at a point stand there, to the last bit: a lever of rounding made a hinge with rigid directions singular.
TEST(Assembly, MassesAtOnePointStayThere) {
    for (int i = 0; i < 40; ++i) {
        Description model;
        const uint32_t ground = model.node("ground", DTTMM_NODE_GROUND), n = model.node("n", DTTMM_NODE_INNER);
        Eigen::Map<Vector3>{model.nodes[n].position} =
            Vector3(0.9496340890022226, -0.2692146190387181 - 0.01 * i, 0.16 / (i + 3));
        model.element("spring", "spring_damper", {ground, n}, kSpring);
        model.element("light", "point_mass", {n}, {{"mass", {0.83 - 0.013 * i}}});
        model.element("heavy", "point_mass", {n}, {{"mass", {1.7}}});
        const Assembly assembly = assemble(model.network());
        const FrameSpec& frame = assembly.frames[static_cast<size_t>(assembly.nodes[n].frame)];
        EXPECT_EQ(frame.pose.position, Vector3(Eigen::Map<const Vector3>(model.nodes[n].position))) << i;
        EXPECT_EQ(frame.inertia, Matrix3(Matrix3::Zero())) << i;
    }
}

// Oracle: two masses of 1.3 kg that lie 2 d apart have the moment 2 · 1.3 d² across, and none within a nanometre of their
// centre: what a rounding of their places makes is no inertia.
TEST(Assembly, PointsWithinANanometreAreOne) {
    for (const double d : {0.8e-9, 1.25e-9}) {
        Description model;
        const uint32_t n = model.node("n", DTTMM_NODE_INNER);
        Eigen::Map<Vector3>{model.nodes[n].position} = Vector3::Zero();
        constexpr double kOwn = 1e-19;
        model.element("one", "point_mass", {n}, {{"mass", {1.3}}});
        model.element("other", "rigid_body", {n},
                      {{"mass", {1.3}},
                       {"center_of_mass", {2 * d, 0, 0}},
                       {"inertia.xx", {kOwn}},
                       {"inertia.yy", {kOwn}},
                       {"inertia.zz", {kOwn}}});
        const Assembly assembly = model.assembled();
        const FrameSpec& frame = assembly.frames[static_cast<size_t>(assembly.nodes[n].frame)];
        const double moment = d < 1e-9 ? 0 : 2 * 1.3 * d * d;
        EXPECT_NEAR(frame.inertia.trace(), 3 * kOwn + 2 * moment, 1e-6 * kOwn) << d;
    }
}

// Oracle: a body whose axes are not those of the frame it is welded to: its tensor is turned.
TEST(Assembly, ABodyInOtherAxesIsTurned) {
    Description d;
    const auto wall = d.node("wall", DTTMM_NODE_GROUND), first = d.node("first", DTTMM_NODE_INNER),
               second = d.node("second", DTTMM_NODE_INNER);
    d.element("spring", "spring_damper", {wall, first}, kSpring);
    d.element("bar", "point_mass", {first, second}, {{"mass", {1.1}}});
    d.element("body", "rigid_body", {second}, kBody);
    const Assembly a = d.assembled();
    ASSERT_EQ(a.inner_count(), 1);
    const Matrix3 R = d.rotation(first).transpose() * d.rotation(second);
    Matrix3 own;
    own << 0.11, 0.013, -0.02, 0.013, 0.17, 0, -0.02, 0, 0.19;
    const Vector3 body = d.position(second) + d.rotation(second) * Vector3(0.02, -0.05, 0.31);
    const Vector3 r = d.rotation(first).transpose() * (body - d.position(first));  // from the point mass at the first node
    const double reduced = 1.1 * 3.7 / 4.8;
    const Matrix3 tensor = R * own * R.transpose() + reduced * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
    EXPECT_LT((a.frames[1].inertia - tensor).norm(), 1e-14 * tensor.norm());
    expect_nodes_in_place(d, a);
}

// ---- Fixed nodes --------------------------------------------------------------------------------------------------------

// Held in all directions it is ground, in some it hangs on a frame of the ground of its own by a rigid joint, world axes.
TEST(Assembly, AFixedNodeHangsOnTheGround) {
    Description d;
    const auto port = d.node("p", DTTMM_NODE_ON_BODY, 0x15), all = d.node("all", DTTMM_NODE_INNER, 0x3f),
               some = d.node("some", DTTMM_NODE_INNER, 0x26), mass = d.node("mass", DTTMM_NODE_INNER, 0x01);
    d.element("a", "spring_damper", {port, some}, kSpring);
    d.element("b", "spring_damper", {mass, all}, kSpring);
    d.element("c", "spring_damper", {some, mass}, kSpring);
    d.element("body", "rigid_body", {mass}, kBody);
    const Assembly a = d.assembled();
    EXPECT_EQ(a.port_count, 1);
    EXPECT_EQ(a.driven_count, 4) << "a port, the node held in all, two points of the ground";
    EXPECT_EQ(a.inner_count(), 2);
    for (size_t f = 1; f < 4; ++f) EXPECT_EQ(a.frames[f].kind, FrameSpec::Kind::ground);
    EXPECT_EQ(a.first_joint, (std::vector<int>{0, 1, 2, 3, 3})) << "joints of the elements only";
    ASSERT_EQ(a.joints.size(), 5u);
    const int ends[][3] = {{0, 0, 4}, {1, 5, 1}, {2, 4, 5}, {0, 2, 4}, {1, 3, 5}};
    for (size_t j = 0; j < 5; ++j) {
        EXPECT_EQ(a.joints[j].element, ends[j][0]) << j;
        EXPECT_EQ(a.joints[j].from, ends[j][1]) << j;
        EXPECT_EQ(a.joints[j].to, ends[j][2]) << j;
    }
    for (const auto& [joint, node, directions] : {std::tuple(3, some, 0x26u), std::tuple(4, mass, 0x01u)}) {
        const JointSpec& held = a.joints[static_cast<size_t>(joint)];
        EXPECT_EQ(held.law->rigid, Directions(directions));
        EXPECT_TRUE(held.law->elastic().none());
        EXPECT_EQ(held.pose.position, d.position(node));
        EXPECT_EQ(held.pose.rotation, Matrix3::Identity());
        EXPECT_EQ(a.frames[static_cast<size_t>(held.from)].pose.position, d.position(node));
        EXPECT_EQ(a.frames[static_cast<size_t>(held.from)].pose.rotation, Matrix3::Identity());
    }
    EXPECT_EQ(a.nodes[port].frame, 0);
    EXPECT_EQ(a.nodes[all].frame, 1);
    EXPECT_EQ(a.nodes[some].frame, 4);
    EXPECT_EQ(a.nodes[mass].frame, 5);
    expect_nodes_in_place(d, a);
}

// ---- What is refused ----------------------------------------------------------------------------------------------------

/// A good network of three elements on four nodes, for a test to spoil: port, ground, two inner.
Description good() {
    Description d;
    d.node("p", DTTMM_NODE_ON_BODY);
    d.node("w", DTTMM_NODE_GROUND);
    d.node("m", DTTMM_NODE_INNER);
    d.node("n", DTTMM_NODE_INNER);
    d.element("a", "spring_damper", {0, 2}, kSpring);
    d.element("b", "point_mass", {2}, {{"mass", {1.5}}});
    d.element("c", "spring_damper", {3, 1}, kSpring);
    return d;
}

void expect_refusal(const Description& description, dttmm_status status, int element, const std::string& text) {
    try {
        description.assembled();
        ADD_FAILURE() << "not refused: " << text;
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), status) << text;
        EXPECT_EQ(error.element(), element) << text;
        EXPECT_THAT(error.what(), HasSubstr(text));
    }
}

TEST(Assembly, WrongNodesAreNamed) {
    EXPECT_NO_THROW(good().assembled());
    Description d = good();
    d.nodes[3].kind = 3;
    expect_refusal(d, DTTMM_ERROR_MODEL, -1, "node \"n\": there is no node kind 3");
    for (double bad : {std::nan(""), kRigidWord}) {
        d = good();
        d.nodes[2].position[1] = bad;
        expect_refusal(d, DTTMM_ERROR_ARGUMENT, -1, "node \"m\": its position must be finite and its axes orthonormal");
        d = good();
        d.nodes[1].rotation[5] = bad;
        expect_refusal(d, DTTMM_ERROR_ARGUMENT, -1, "node \"w\": its position");
    }
    d = good();
    d.nodes[0].rotation[0] += 1e-8;
    expect_refusal(d, DTTMM_ERROR_ARGUMENT, -1, "node \"p\"");
    d = good();
    for (int i = 0; i < 3; ++i) std::swap(d.nodes[0].rotation[3 * i], d.nodes[0].rotation[3 * i + 1]);
    expect_refusal(d, DTTMM_ERROR_ARGUMENT, -1, "node \"p\"");  // left-handed
}

TEST(Assembly, WrongEndsAreNamed) {
    const auto more = [](const char* type, std::vector<uint32_t> ends, const Given& given) {
        Description d = good();
        d.element("d", type, std::move(ends), given);
        return d;
    };
    const Given mass = {{"mass", {2}}};
    expect_refusal(more("spring_damper", {0, 4}, kSpring), DTTMM_ERROR_MODEL, 3, "an end is no node of the network");
    expect_refusal(more("point_mass", {4}, mass), DTTMM_ERROR_MODEL, 3, "an end is no node of the network");
    expect_refusal(more("spring_damper", {2}, kSpring), DTTMM_ERROR_MODEL, 3, "has two ends");
    expect_refusal(more("beam", {0, 2, 3}, kBeam), DTTMM_ERROR_MODEL, 3, "has two ends");
    expect_refusal(more("spring_damper", {2, 2}, kSpring), DTTMM_ERROR_MODEL, 3, "both ends are the same node");
    expect_refusal(more("point_mass", {}, mass), DTTMM_ERROR_ARGUMENT, 3, "an element without an end");
    expect_refusal(more("point_mass", {0}, mass), DTTMM_ERROR_MODEL, 3, "node \"p\": a mass there would have no effect");
    expect_refusal(more("rigid_body", {2, 1}, kBody), DTTMM_ERROR_MODEL, 3, "node \"w\": a mass there");
}

TEST(Assembly, JointsThatCannotWorkAreNamed) {
    const auto more = [](const char* type, std::vector<uint32_t> ends, const Given& given, uint32_t fixed = 0) {
        Description d = good();
        d.nodes[3].fixed = fixed;
        d.element("body", "rigid_body", {2}, kBody);
        d.element("d", type, std::move(ends), given);
        return d;
    };
    Description d = good();
    d.element("body", "rigid_body", {2, 3}, kBody);
    EXPECT_NO_THROW(d.assembled());
    d.element("d", "spring_damper", {3, 2}, kSpring);
    expect_refusal(d, DTTMM_ERROR_MODEL, 4, "both ends are on the same rigid body: nothing can deform");
    for (const char* type : {"beam", "rod"}) {
        d = good();
        d.element("body", "rigid_body", {2, 3}, kBody);
        d.element("d", type, {3, 2}, kBeam);
        const dttmm_network network = d.network();
        if (std::string_view(type) == "beam") {
            EXPECT_NO_THROW(assemble(network, Waves::exact)) << "its own mass bends it";
            EXPECT_NO_THROW(d.assembled());
            continue;
        }
        EXPECT_THROW(assemble(network, Waves::exact), Error);
        expect_refusal(d, DTTMM_ERROR_MODEL, 4, "only its own mass would stretch it");
    }

    expect_refusal(more("spring_damper", {1, 3}, kSpring, 0x3f), DTTMM_ERROR_MODEL, 2, "both ends are on the ground");
    d = good();
    d.node("v", DTTMM_NODE_GROUND);
    d.element("d", "beam", {1, 4}, kBeam);
    EXPECT_NO_THROW(d.assembled()) << "its segments are in between";
    d.element("e", "elastic_hinge", {1, 4}, {{"stiffness.x", {3e5}}});
    expect_refusal(d, DTTMM_ERROR_MODEL, 4, "both ends are on the ground");

    const Given hinge = {{"stiffness.y", {3e5}}, {"stiffness.rx", {0}}, {"stiffness.rz", {12}}};
    EXPECT_NO_THROW(more("elastic_hinge", {0, 2}, hinge).assembled());
    for (const std::vector<uint32_t>& ends : {std::vector<uint32_t>{0, 1}, {1, 0}})
        expect_refusal(more("elastic_hinge", ends, hinge), DTTMM_ERROR_MODEL, 4,
                       "it is rigid in x, z, ry and both its ends are driven");
}

// What an element itself refuses comes with its index.
TEST(Assembly, WrongValuesAreNamed) {
    Description d = good();
    d.element("d", "spring_damper", {0, 3}, {{"stiffness", {1, -2, 3}}});
    expect_refusal(d, DTTMM_ERROR_ARGUMENT, 3, "stiffness must be finite");
    d = good();
    d.elements[2].type = 99;
    expect_refusal(d, DTTMM_ERROR_ARGUMENT, 2, "there is no element type 99");
    d = good();
    d.elements[2].values = nullptr;
    expect_refusal(d, DTTMM_ERROR_ARGUMENT, 2, "no values");
    d = good();
    d.element("d", "beam", {0, 3}, test::with(kBeam, {{"section.GJ", {std::nan("")}}}));
    expect_refusal(d, DTTMM_ERROR_MODEL, 3, "section.GJ is needed in runs and at rest");
    d = good();
    std::copy_n(d.nodes[0].position, 3, d.nodes[3].position);
    d.element("d", "beam", {0, 3}, kBeam);
    expect_refusal(d, DTTMM_ERROR_MODEL, 3, "its ends are 0 m apart");
    d = good();
    d.element("d", "rigid_body", {3}, {{"mass", {1}}, {"inertia.xx", {5}}});
    expect_refusal(d, DTTMM_ERROR_MODEL, 3, "no mass has such a tensor");
    d = good();
    d.element("d", "elastic_hinge", {2, 3}, {{"damping.z", {0.1}}});
    expect_refusal(d, DTTMM_ERROR_MODEL, 3, "damping.z");
}

}  // namespace
}  // namespace dttmm::plugin
