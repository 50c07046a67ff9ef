// SPDX-License-Identifier: BSD-3-Clause
//
// Machines of many parts: time and memory grow in proportion to the parts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cli/process.h"

namespace dttmm::host {
namespace {

constexpr const char* kScalingHead = "format = \"dttmm/1\"\n[simulation]\nduration = \"3 ms\"\nstep = \"1 ms\"\n";
constexpr const char* kScalingBody = "[[body]]\nname = \"plate\"\nmass = 10\ninertia = [1, 1.1, 1.2]\n";

/// One plate on n springs from the ground, each of its own stiffness.
std::string springs(int n) {
    std::string text = std::string(kScalingHead) + "[output]\nchannels = [\"plate.position\"]\n" + kScalingBody;
    for (int i = 0; i < n; ++i)
        text += fmt::format(
            "[[element]]\nname = \"s{}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate\"\nstiffness = {}\n", i,
            100 + i);
    return text;
}

std::string free_bodies(int n) {
    std::string text = std::string(kScalingHead) + "gravity = [0, 0, -9.81]\n";
    for (int i = 0; i < n; ++i)
        text +=
            fmt::format("[[body]]\nname = \"b{}\"\nmass = 1\ninertia = [1, 1.1, 1.2]\nposition = [{}, 0, 0]\n", i, 3 * i);
    return text;
}

std::string many_parameters(int n) {
    std::string text = std::string(kScalingHead) + "[parameters]\n";
    for (int i = 0; i < n; ++i) text += fmt::format("p{} = {}\n", i, i);
    return text + kScalingBody;
}

Ended run_text(const std::string& model) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", model);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"});
    EXPECT_EQ(ended.code, 0) << ended.err.substr(0, 500);
    EXPECT_EQ(read_json(folder / "out/summary.json")["rows"], 4);
    return ended;
}

// Oracle: four times the parts take four times the processor's time; 16 times if something looks at all pairs. 8 lies
// between. The smaller run is long enough that what every run takes, some 10 ms, counts little.
void expect_linear_time(std::string (*model)(int), int n) {
    const double few = run_text(model(n)).processor_seconds, many = run_text(model(4 * n)).processor_seconds;
    EXPECT_LT(many, 8 * (few + 0.01)) << few << " s for " << n;
}

TEST(Scaling, TimeInProportionToElements) { expect_linear_time(springs, 4000); }
TEST(Scaling, TimeInProportionToParameters) { expect_linear_time(many_parameters, 20000); }
TEST(Scaling, TimeInProportionToBodies) { expect_linear_time(free_bodies, 500); }

/// What a part more takes of the memory [bytes].
double memory_per_part(std::string (*model)(int)) {
    return (run_text(model(3000)).memory - run_text(model(1000)).memory) / 2000;
}

// Oracle: 10^5 springs shall take less than 1 GB, and 20 000 bodies likewise. A spring's 12 channels, its plugin's memory
// and the model take 8.5 kB; with the summary as one piece 13 kB. A body's 16 channels take 15 kB, with datasets that all
// stay open 300 kB.
TEST(Scaling, APartTakesLittleMemory) {
    EXPECT_LT(memory_per_part(springs), 10e3);
    EXPECT_LT(memory_per_part(free_bodies), 50e3);
}

}  // namespace
}  // namespace dttmm::host
