// SPDX-License-Identifier: BSD-3-Clause
//
// Natural frequencies of random trees against dense finite elements: none missed, none invented.
#include <gtest/gtest.h>

#include "modal/random_tree.h"

namespace dttmm::plugin {
namespace {

using test::FiniteElements;
using test::RandomTree;

constexpr int kTrees = 200;
constexpr uint32_t kModes = 8;
constexpr double kTolerance = 1e-5;
/// Rounding of the finite elements, as share of their largest eigenvalue.
constexpr double kNoise = 2e-15;

std::vector<double> found_of(RandomTree& tree, std::vector<dttmm_mode>& modes) {
    ModalAnalysis analysis(tree.model());
    const size_t count = analysis.find_modes(kModes, 0);
    std::vector<double> hertz;
    modes.resize(count);
    for (uint32_t m = 0; m < count; ++m) {
        analysis.mode(m, &modes[m], nullptr, nullptr, nullptr);
        hertz.push_back(modes[m].frequency);
    }
    return hertz;
}

/// What is wrong with the first frequencies beside finite elements of n, 2n and 4n per member; nothing: they agree.
std::string compare(const RandomTree& tree, const std::vector<double>& found, int n) {
    const std::vector<double> fine = tree.finite_elements(4 * n).frequencies();
    const std::vector<double> limit =
        test::extrapolate(tree.finite_elements(n).frequencies(), tree.finite_elements(2 * n).frequencies(), fine);
    // Rigid modes need no limit, and what was not a rigid mode to rounding is none
    const double noise = kNoise * fine.back() * fine.back();
    for (size_t i = 0; i < found.size(); ++i) {
        if (i >= limit.size()) return fmt::format("{} frequencies, {} expected", found.size(), limit.size());
        const double square = found[i] * found[i];
        const double expected = fine[i] * fine[i] < 100 * noise ? fine[i] : limit[i];
        if (std::abs(square - expected * expected) > 2 * kTolerance * square + 100 * noise)
            return fmt::format("frequency {}: {:.9g} Hz, expected {:.9g} Hz (noise {:.2g} Hz)", i + 1, found[i], expected,
                               std::sqrt(noise));
    }
    return {};
}

// Oracle: dense finite elements (support/finite_elements.h), extrapolated. Where a mesh is too coarse for a frequency the
// next one decides.
TEST(RandomTrees, HaveTheFrequenciesOfFiniteElements) {
    for (unsigned seed = 1; seed <= kTrees; ++seed) {
        RandomTree tree(seed);
        std::vector<dttmm_mode> modes;
        std::vector<double> found;
        try {
            found = found_of(tree, modes);
        } catch (const std::exception& error) {
            ADD_FAILURE() << "seed " << seed << ": " << error.what() << "\n" << tree.story();
            continue;
        }
        EXPECT_GE(found.size(), kModes) << "seed " << seed;
        std::string fault;
        for (const int n : {2, 4, 8, 16}) {
            fault = compare(tree, found, n);
            if (fault.empty()) break;
        }
        EXPECT_EQ(fault, "") << "seed " << seed << ": " << tree.story();
    }
}

}  // namespace
}  // namespace dttmm::plugin
