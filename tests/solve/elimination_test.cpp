// SPDX-License-Identifier: BSD-3-Clause
#include "solve/elimination.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "core/rotation.h"
#include "core/state_vector.h"
#include "support/count_allocations.h"
#include "support/linear_algebra.h"

namespace dttmm::plugin {
namespace {

using Real = long double;
using MatrixR = test::MatrixL;
using VectorR = test::VectorL;

/// A joint between two frames or a frame and what is known (−1): its Jacobians, its stiffness, its first `rigid` directions
/// rigid instead.
struct Coupling {
    int from, to, rigid;
    Matrix6 by_from, by_to;
    Vector6 stiffness;
};

/// Masses and joints: what a network hands to the elimination, and the same as one dense saddle-point system.
struct System {
    std::vector<Matrix6> masses;
    std::vector<Coupling> joints;

    int unknowns() const { return 6 * static_cast<int>(masses.size()); }

    Elimination eliminate() const {
        std::vector<Link> links;
        for (const Coupling& joint : joints) links.push_back({joint.from, joint.to, joint.rigid});
        Elimination elimination(static_cast<int>(masses.size()), links);
        fill(elimination);
        return elimination;
    }

    void fill(Elimination& elimination) const {
        elimination.set_zero();
        for (size_t f = 0; f < masses.size(); ++f) elimination.add_diagonal(static_cast<int>(f), masses[f]);
        for (size_t l = 0; l < joints.size(); ++l) {
            const auto& [from, to, rigid, by_from, by_to, stiffness] = joints[l];
            const Matrix6 k = elastic(joints[l]).asDiagonal();
            if (from >= 0) elimination.add_diagonal(from, by_from.transpose() * k * by_from);
            if (to >= 0) elimination.add_diagonal(to, by_to.transpose() * k * by_to);
            if (from >= 0 && to >= 0) elimination.add_coupling(static_cast<int>(l), by_from.transpose() * k * by_to);
            for (int i = 0; i < rigid; ++i)
                elimination.set_rigid(static_cast<int>(l), i, by_from.row(i).transpose(), by_to.row(i).transpose());
        }
    }

    /// [K Jᵀ; J 0], rows of J in the order of the joints.
    MatrixR dense() const {
        int rows = unknowns();
        for (const Coupling& joint : joints) rows += joint.rigid;
        MatrixR A = MatrixR::Zero(rows, rows);
        for (size_t f = 0; f < masses.size(); ++f)
            A.block(6 * static_cast<int>(f), 6 * static_cast<int>(f), 6, 6) += masses[f].cast<Real>();
        int row = unknowns();
        for (const Coupling& joint : joints) {
            MatrixR G = MatrixR::Zero(6, unknowns());
            if (joint.from >= 0) G.middleCols(6 * joint.from, 6) = joint.by_from.cast<Real>();
            if (joint.to >= 0) G.middleCols(6 * joint.to, 6) = joint.by_to.cast<Real>();
            A.topLeftCorner(unknowns(), unknowns()) += test::stiffness_of(G, elastic(joint).cast<Real>());
            for (int i = 0; i < joint.rigid; ++i, ++row) {
                A.row(row).head(unknowns()) = G.row(i);
                A.col(row).head(unknowns()) = G.row(i).transpose();
            }
        }
        return A;
    }

    static Vector6 elastic(const Coupling& joint) {
        Vector6 k = joint.stiffness;
        k.head(joint.rigid).setZero();
        return k;
    }
};

/// Numbers of a seed.
class Dice {
public:
    explicit Dice(unsigned seed) : generator_(seed) {}
    double between(double low, double high) { return std::uniform_real_distribution<>(low, high)(generator_); }
    int below(int count) { return std::uniform_int_distribution<>(0, count - 1)(generator_); }
    double scale() { return std::pow(10, between(low_, high_)); }
    /// From now on scales lie between 10^low and 100 times that.
    void set_range(double low) {
        low_ = low;
        high_ = low + 2;
    }
    Vector3 vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

    /// Of a body of that mass about a point beside its centre.
    Matrix6 mass(double mass) {
        const Vector3 c = vector(0.3);
        const Matrix3 R = rotation_from_vector(vector(2));
        Matrix6 M = Matrix6::Zero();
        M.topLeftCorner<3, 3>() = mass * Matrix3::Identity();
        M.topRightCorner<3, 3>() = -mass * skew(c);
        M.bottomLeftCorner<3, 3>() = mass * skew(c);
        M.bottomRightCorner<3, 3>() =
            R * (mass * Vector3(0.05, 0.09, 0.12)).asDiagonal() * R.transpose() - mass * skew(c) * skew(c);
        return M;
    }

    /// Between the two, at a point of its own, in axes of its own.
    Coupling joint(int from, int to, int rigid) {
        Coupling joint{from, to, rigid, lever(), lever(), Vector6::Zero()};
        joint.by_from = -joint.by_from;
        for (int d = 0; d < 6; ++d) joint.stiffness(d) = scale();
        return joint;
    }

private:
    Matrix6 lever() {
        const Matrix3 R = rotation_from_vector(vector(2)).transpose();
        Matrix6 G = Matrix6::Zero();
        G.topLeftCorner<3, 3>() = G.bottomRightCorner<3, 3>() = R;
        G.topRightCorner<3, 3>() = -R * skew(vector(0.7));
        return G;
    }
    std::mt19937 generator_;
    double low_ = -3, high_ = 6;
};

/// What the elimination makes of loads and rigid offsets, u above q.
VectorR solve(const Elimination& elimination, const System& system, const VectorR& right) {
    std::vector<Vector6> r(system.masses.size());
    for (size_t f = 0; f < r.size(); ++f) r[f] = right.segment(6 * static_cast<int>(f), 6).cast<double>();
    std::vector<double> g(static_cast<size_t>(elimination.rigid_count()));
    for (size_t i = 0; i < g.size(); ++i) g[i] = static_cast<double>(right(system.unknowns() + static_cast<int>(i)));
    elimination.solve(r, g);
    VectorR x(right.size());
    for (size_t f = 0; f < r.size(); ++f) x.segment(6 * static_cast<int>(f), 6) = r[f].cast<Real>();
    for (size_t i = 0; i < g.size(); ++i) x(system.unknowns() + static_cast<int>(i)) = g[i];
    return x;
}

struct Errors {
    double elimination = 0, dense = 0;
};

/// Relative errors of the motions and of the forces in rigid directions, the worse, for a random right-hand side: those of
/// the elimination and those of full-pivot elimination of the whole, both in double precision, against the latter in
/// extended.
Errors relative_errors(const System& system, Dice& dice) {
    Elimination elimination = system.eliminate();
    if (const auto fault = elimination.factor()) {
        ADD_FAILURE() << "singular at frame " << fault->frame << ", direction " << fault->direction << ", joint "
                      << fault->link << ", rigid direction " << fault->rigid;
        return {};
    }
    const MatrixR A = system.dense();
    VectorR right(A.rows());
    for (Eigen::Index i = 0; i < right.size(); ++i) right(i) = dice.between(-1, 1);
    const VectorR exact = test::solve(A, right);
    const Eigen::Index n = system.unknowns(), m = right.size() - n;
    const auto error = [&](const VectorR& found) {
        const VectorR difference = found - exact;
        const double of_u = static_cast<double>(difference.head(n).norm() / exact.head(n).norm());
        return m == 0 ? of_u : std::max(of_u, static_cast<double>(difference.tail(m).norm() / exact.tail(m).norm()));
    };
    const Eigen::VectorXd dense = test::solve(Eigen::MatrixXd(A.cast<double>()), Eigen::VectorXd(right.cast<double>()));
    return {error(solve(elimination, system, right)), error(dense.cast<Real>())};
}

enum class Shape { chain, tree, graph };

/// Bodies in a chain, a tree or a tree with loops; a few joints to what is known, the first of them at body `grounded`.
System random_system(Dice& dice, Shape shape, int count, int most_rigid) {
    System system;
    for (int f = 0; f < count; ++f) system.masses.push_back(dice.mass(dice.scale()));
    std::vector<int> name(static_cast<size_t>(count));
    for (int f = 0; f < count; ++f) name[static_cast<size_t>(f)] = f;
    for (int f = count - 1; f > 0; --f)
        std::swap(name[static_cast<size_t>(f)], name[static_cast<size_t>(dice.below(f + 1))]);
    const auto rigid = [&] { return most_rigid == 0 ? 0 : dice.below(most_rigid + 1); };
    for (int f = 1; f < count; ++f) {
        int a = name[static_cast<size_t>(shape == Shape::chain ? f - 1 : dice.below(f))], b = name[static_cast<size_t>(f)];
        if (dice.below(2)) std::swap(a, b);
        system.joints.push_back(dice.joint(a, b, rigid()));
    }
    system.joints.push_back(dice.joint(-1, dice.below(count), rigid()));
    if (shape == Shape::graph)
        for (int extra = 0; extra < count / 2; ++extra) {
            const int a = dice.below(count), b = dice.below(count);
            if (a != b) system.joints.push_back(dice.joint(a, b, 0));
        }
    return system;
}

// ---- Against a dense solution -------------------------------------------------------------------------------------------

const char* const kShapes[] = {"chain", "tree", "graph"};

// Oracle: the whole saddle-point system by full-pivot elimination in extended precision. Masses and stiffnesses of one
// network differ by a factor of 100, those of different networks by 1e9: rounding times a condition of up to 1e5.
TEST(Elimination, SolvesRandomNetworks) {
    for (Shape shape : {Shape::chain, Shape::tree, Shape::graph})
        for (int most_rigid : {0, 2, 5})
            for (unsigned seed = 1; seed <= 20; ++seed) {
                Dice dice(seed);
                dice.set_range(dice.between(-3, 4));
                const System system = random_system(dice, shape, 2 + dice.below(20), most_rigid);
                EXPECT_LT(relative_errors(system, dice).elimination, 1e-11)
                    << kShapes[static_cast<int>(shape)] << " " << seed << ", up to " << most_rigid << " rigid directions";
            }
}

// Oracle: as above. Within one network masses and stiffnesses are spread over 1e-3 … 1e6: the condition, up to 1e9 and more,
// takes its digits of any solution in double precision (1e-9 of the dense one); frames eliminated one by one may lose two
// more. Handing on what explicit inverses of their blocks make would leave errors of 1e-2.
TEST(Elimination, StiffAndSoftInOneNetworkCostLittleMoreThanADenseSolutionLoses) {
    for (Shape shape : {Shape::chain, Shape::tree, Shape::graph})
        for (int most_rigid : {0, 2, 5}) {
            Errors worst;
            for (unsigned seed = 1; seed <= 20; ++seed) {
                Dice dice(seed);
                const Errors errors = relative_errors(random_system(dice, shape, 2 + dice.below(20), most_rigid), dice);
                worst.elimination = std::max(worst.elimination, errors.elimination);
                worst.dense = std::max(worst.dense, errors.dense);
            }
            EXPECT_LT(worst.dense, 1e-8) << "the oracle of this tolerance";
            EXPECT_LT(worst.elimination, 1e-7) << kShapes[static_cast<int>(shape)] << ", " << most_rigid;
        }
}

/// Bodies of moderate size in a row, the joints between them and to what is known at the ends with the given numbers of
/// rigid directions.
System row_of(Dice& dice, const std::vector<int>& rigid) {
    System system;
    dice.set_range(0);
    const int count = static_cast<int>(rigid.size()) - 1;
    for (int f = 0; f < count; ++f) system.masses.push_back(dice.mass(dice.scale()));
    for (int j = 0; j <= count; ++j)
        system.joints.push_back(dice.joint(j - 1, j < count ? j : -1, rigid[static_cast<size_t>(j)]));
    return system;
}

// Pendulums on pendulums, and chains between two things known: each body has more rigid directions at its two joints than
// motions, and only all of them together say whether the whole can move. Oracle as above.
TEST(Elimination, RigidDirectionsMayHoldABodyFromBothSides) {
    const std::vector<int> rows[] = {{5, 5, 0},    {5, 5, 5, 5, 0}, {0, 5, 5},       {6, 4, 0},
                                     {5, 3, 3},    {3, 5, 3},       {5, 5, 4, 3, 0}, {6, 6, 6, 5, 0},
                                     {4, 3, 5, 5}, {6, 5, 5, 1},    {2, 5, 5, 5, 5}, {5, 1, 5, 5, 2}};
    for (const std::vector<int>& rigid : rows)
        for (unsigned seed = 1; seed <= 10; ++seed) {
            Dice dice(seed);
            const System system = row_of(dice, rigid);
            EXPECT_LT(relative_errors(system, dice).elimination, 1e-9) << testing::PrintToString(rigid) << ", seed " << seed;
        }
}

// A ring of bodies closed by joints with rigid directions, every row of J needed.
TEST(Elimination, RigidDirectionsMayCloseALoop) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        Dice dice(seed);
        dice.set_range(2);
        System system;
        for (int f = 0; f < 7; ++f) system.masses.push_back(dice.mass(dice.scale()));
        for (int f = 0; f < 7; ++f) system.joints.push_back(dice.joint(f, (f + 1) % 7, f == 3 ? 3 : 5));
        EXPECT_LT(relative_errors(system, dice).elimination, 1e-9) << seed;
    }
}

// Frames without a mass or a stiffness of their own follow those with one by their rigid directions.
TEST(Elimination, AFrameWithoutMassFollowsWhatItIsRigidlyTiedTo) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        Dice dice(seed);
        System system = row_of(dice, {0, 6, 2, 6, 5});
        system.masses[1].setZero();
        system.masses[3].setZero();
        for (int d = 0; d < 6; ++d) system.joints[1].stiffness(d) = system.joints[3].stiffness(d) = 0;
        EXPECT_LT(relative_errors(system, dice).elimination, 1e-9) << seed;
    }
}

// A frame without mass that one rigid direction alone holds, and that one leans on another to a thousandth. Oracle as above,
// the condition 1e6.
TEST(Elimination, RigidDirectionsThatLeanOnEachOtherHoldAFrameToo) {
    Dice dice(7);
    dice.set_range(0);
    System system;
    system.masses = {Matrix6::Zero(), dice.mass(dice.scale())};
    system.joints = {dice.joint(1, 0, 5), dice.joint(1, 0, 1), dice.joint(-1, 1, 0)};
    system.joints[0].stiffness.setZero();
    system.joints[1].stiffness.setZero();
    system.joints[0].by_to = Matrix6::Identity();
    system.joints[1].by_to.row(0) << 1, 0, 0, 0, 0, 1e-3;
    EXPECT_LT(relative_errors(system, dice).elimination, 1e-9);
}

// A second factor of other numbers owes nothing to the first.
TEST(Elimination, IsFactoredAnew) {
    Dice first(3), second(4);
    const System before = row_of(first, {5, 5, 2, 5}), after = row_of(second, {5, 5, 2, 5});
    Elimination used = before.eliminate(), fresh = after.eliminate();
    ASSERT_FALSE(used.factor() || fresh.factor());
    after.fill(used);
    ASSERT_FALSE(used.factor());
    const VectorR right = VectorR::LinSpaced(after.dense().rows(), -1, 2);
    EXPECT_EQ(solve(used, after, right), solve(fresh, after, right));
}

// ---- Singular systems ---------------------------------------------------------------------------------------------------

TEST(Elimination, AFreeDirectionOfAMasslessFrameIsNamed) {
    for (int free = 0; free < 6; ++free)
        for (int neighbours : {1, 2}) {
            System system;
            Dice dice(11);
            dice.set_range(1);
            for (int f = 0; f < 3; ++f) system.masses.push_back(dice.mass(dice.scale()));
            system.masses[1].setZero();
            // At the frame's own origin, in its own axes: only there it is one direction that is free
            for (int side = 0; side < neighbours; ++side) {
                Coupling joint = dice.joint(2 * side, 1, 0);
                joint.by_to = Matrix6::Identity();
                joint.stiffness(free) = 0;
                system.joints.push_back(joint);
            }
            Elimination elimination = system.eliminate();
            const auto fault = elimination.factor();
            ASSERT_TRUE(fault) << free;
            EXPECT_EQ(fault->frame, 1);
            EXPECT_EQ(fault->direction, free);
            EXPECT_EQ(fault->link, -1);
        }
}

TEST(Elimination, RigidDirectionsDrivenFromBothEndsAreNamed) {
    struct Case {
        std::vector<int> rigid;
        const char* what;
    };
    const Case cases[] = {{{6, 1}, "one body, seven rigid directions"},
                          {{6, 6, 6}, "a row of bodies fixed at both ends"},
                          {{5, 5, 5}, "fifteen rigid directions, twelve motions"},
                          {{6, 6, 6, 6, 6}, "a longer one"},
                          {{3, 6, 6, 4}, "all but one fixed at both ends"}};
    for (const auto& [rigid, what] : cases)
        for (unsigned seed = 1; seed <= 5; ++seed) {
            Dice dice(seed);
            Elimination elimination = row_of(dice, rigid).eliminate();
            const auto fault = elimination.factor();
            ASSERT_TRUE(fault) << what;
            EXPECT_EQ(fault->direction, -1) << what;
            ASSERT_GE(fault->link, 0) << what;
            ASSERT_LT(fault->link, static_cast<int>(rigid.size())) << what;
            EXPECT_GE(fault->rigid, 0) << what;
            EXPECT_LT(fault->rigid, rigid[static_cast<size_t>(fault->link)]) << what;
        }
}

// The same rigid joint twice between two bodies, the ends of the chain elastic; the bodies of any size beside each other, so
// that what rounding leaves of the second joint is measured against what it was made of.
TEST(Elimination, ARigidJointBesideItsLikeIsNamed) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Dice dice(seed);
        System system = row_of(dice, {0, 6, 0, 0});
        system.masses[0] *= std::pow(10, dice.between(-9, 9));
        system.masses[1] *= std::pow(10, dice.between(-9, 9));
        system.joints.push_back(system.joints[1]);
        Elimination elimination = system.eliminate();
        const auto fault = elimination.factor();
        ASSERT_TRUE(fault) << seed;
        EXPECT_EQ(fault->direction, -1);
        EXPECT_TRUE(fault->link == 1 || fault->link == 4) << fault->link;
    }
}

// ---- Storage ------------------------------------------------------------------------------------------------------------

#ifndef __SANITIZE_ADDRESS__
TEST(Elimination, NothingIsAllocatedAfterTheFirstFactor) {
    for (Shape shape : {Shape::chain, Shape::tree, Shape::graph})
        for (int most_rigid : {0, 5}) {
            Dice dice(17);
            dice.set_range(0);
            const System system = random_system(dice, shape, 23, most_rigid);
            Elimination elimination = system.eliminate();
            ASSERT_FALSE(elimination.factor());
            std::vector<Vector6> r(23, Vector6::Ones());
            std::vector<double> g(static_cast<size_t>(elimination.rigid_count()), 0.3);
            const long before = allocations;
            ASSERT_GT(before, 0) << "malloc is not counted";
            for (int pass = 0; pass < 3; ++pass) {
                system.fill(elimination);
                ASSERT_FALSE(elimination.factor());
                elimination.solve(r, g);
            }
            EXPECT_EQ(allocations - before, 0) << kShapes[static_cast<int>(shape)] << ", " << most_rigid;
        }
}
#endif

// ---- Why not the product of transfer matrices ---------------------------------------------------------------------------

/// Equal cells, each a spring and a mass behind it, the first spring on a wall, the end free; a force on the first mass. One
/// step by Fox-Euler's rule from rest: mass A x, A = 2/h², against the springs.
struct Chain {
    int count;
    double w_c_h;
    double k = 3.7e4, mass = 0.9, force = 12;
    double inertia() const { return 2 * k / (w_c_h * w_c_h); }  ///< mass A, with w_c² = k/mass

    VectorR exact() const {
        const Real A = inertia();
        MatrixR K = MatrixR::Zero(count, count);
        for (int i = 0; i < count; ++i) {
            K(i, i) += A + static_cast<Real>(k);
            if (i == 0) continue;
            K(i - 1, i - 1) += static_cast<Real>(k);
            K(i, i - 1) = K(i - 1, i) = -static_cast<Real>(k);
        }
        VectorR f = VectorR::Zero(count);
        f(0) = force;
        return test::solve(K, f);
    }

    /// z = [x q 1]: x_O = x_I − q/k, q_O = q_I − mass A x + f, signs of core/state_vector.h; from the wall x = 0 to q = 0.
    VectorR by_product() const {
        const auto cell = [&](int i) {
            Matrix3 spring = Matrix3::Identity(), body = Matrix3::Identity();
            spring(0, 1) = -1 / k;
            body(1, 0) = -inertia();
            body(1, 2) = i == 0 ? force : 0;
            return Matrix3(body * spring);
        };
        Matrix3 U = Matrix3::Identity();
        for (int i = 0; i < count; ++i) U = cell(i) * U;
        Vector3 z(0, -U(1, 2) / U(1, 1), 1);
        VectorR x(count);
        for (int i = 0; i < count; ++i) {
            z = cell(i) * z;
            x(i) = z(0);
        }
        return x;
    }

    VectorR by_elimination() const {
        System system;
        for (int i = 0; i < count; ++i) {
            system.masses.push_back(inertia() * Matrix6::Identity());
            Coupling spring{i - 1, i, 0, -Matrix6::Identity(), Matrix6::Identity(), Vector6::Zero()};
            spring.stiffness(0) = k;
            system.joints.push_back(spring);
        }
        Elimination elimination = system.eliminate();
        EXPECT_FALSE(elimination.factor());
        VectorR right = VectorR::Zero(6 * count);
        right(0) = force;
        const VectorR all = solve(elimination, system, right);
        VectorR x(count);
        for (int i = 0; i < count; ++i) x(i) = all(6 * i);
        return x;
    }

    double error(const VectorR& x) const { return static_cast<double>((x - exact()).norm() / exact().norm()); }
};

// Oracle: a dense Cholesky factor in extended precision. The plain product grows by g = 1 + s + √((1 + s)² − 1), s = 1/(w_c
// h)², of cell to cell: (N − 1) log₁₀ g of 16 digits are lost, give or take 1.5. The elimination, which is the
// Riccati form, keeps all.
TEST(Elimination, KeepsTheDigitsThatAProductOfTransferMatricesLoses) {
    for (double w_c_h : {0.707, 0.0707, 0.00707})
        for (int count : {4, 8, 16, 32}) {
            const Chain chain{count, w_c_h};
            EXPECT_LT(chain.error(chain.by_elimination()), 1e-15) << count << " cells, w_c h " << w_c_h;
            const double s = 1 / (w_c_h * w_c_h), g = 1 + s + std::sqrt((1 + s) * (1 + s) - 1);
            const double lost = (count - 1) * std::log10(g) - 16;
            EXPECT_NEAR(std::log10(chain.error(chain.by_product())), lost, 1.5) << count << " cells, w_c h " << w_c_h;
        }
    const Chain worst{16, 0.0707};
    EXPECT_GT(worst.error(worst.by_product()), 1e20) << "nothing left";
}

}  // namespace
}  // namespace dttmm::plugin
