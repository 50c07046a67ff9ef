// SPDX-License-Identifier: BSD-3-Clause
//
// Equilibrium: the whole command `dttmm static` of a bent beam of 1000 lumps and of a frame of 190 beams, and what gravity
// adds to `dttmm modes` of the frame. Processor time of the process, the median of several.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "benchmark/median.h"
#include "support/paths.h"

extern char** environ;

namespace dttmm::host {
namespace {

constexpr int kRuns = 11;

/// Processor time of one command [s]; −1: it failed.
double seconds_of(std::vector<std::string> words) {
    std::vector<char*> arguments = {const_cast<char*>("dttmm")};
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t id = 0;
    if (posix_spawn(&id, test::paths::command().c_str(), nullptr, nullptr, arguments.data(), environ) != 0) return -1;
    int status = 0;
    rusage used{};
    if (::wait4(id, &status, 0, &used) != id || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return -1;
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

void measure(const char* what, const std::vector<std::string>& words) {
    std::vector<double> all;
    for (int i = 0; i < kRuns; ++i) all.push_back(seconds_of(words));
    fmt::print("{:<60} {:8.1f} ms\n", what, 1e3 * median(all));
}

/// A clamped beam with a weight at its end that bends it down by a third of its length.
std::string bent_beam(int segments) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "load"
mass = 0.12
inertia = [1e-4, 2e-4, 3e-4]
position = [1, 0, 0]
[[element]]
name = "strip"
type = "beam"
from = "root"
to = "load"
segments = {}
section = {{ EA = 1e6, EIy = 1, EIz = 1.7, GJ = 1, GAy = 3e5, GAz = 3e5, mass = 0.1, inertia = 1e-6 }}
)",
                       segments);
}

/// A frame of ten storeys and nine bays under its weight: 100 columns, 90 girders.
std::string frame(bool is_heavy) {
    constexpr int kBays = 9, kStoreys = 10;
    std::string nodes, elements;
    const auto beam = [&](const std::string& from, const std::string& to) {
        elements += fmt::format(
            "[[element]]\nname = \"{0}_{1}\"\ntype = \"beam\"\nfrom = \"{0}\"\nto = \"{1}\"\n"
            "section = {{ tube = [\"200 mm\", \"180 mm\"] }}\nmaterial = {{ E = \"210 GPa\", poisson = 0.3, density = 7850 "
            "}}\n",
            from, to);
    };
    const auto name = [](int bay, int storey) { return fmt::format("n{}_{}", bay, storey); };
    for (int bay = 0; bay <= kBays; ++bay)
        for (int storey = 0; storey <= kStoreys; ++storey) {
            nodes += fmt::format("{} = {{ position = [{}, 0, {}]{} }}\n", name(bay, storey), 5 * bay, 3.2 * storey,
                                 storey == 0 ? ", fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]" : "");
            if (storey > 0) beam(name(bay, storey - 1), name(bay, storey));
            if (storey > 0 && bay > 0) beam(name(bay - 1, storey), name(bay, storey));
        }
    return fmt::format("format = \"dttmm/1\"\n[simulation]\ngravity = [0, 0, {}]\n[nodes]\n{}{}", is_heavy ? -9.81 : 0.0,
                       nodes, elements);
}

int measure_all() {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("dttmm-statics-{}", ::getpid());
    std::filesystem::create_directory(folder);
    const auto file = [&](const char* name, const std::string& text) {
        std::ofstream(folder / name) << text;
        return (folder / name).string();
    };
    const std::string out = (folder / "out").string();
    measure("static, beam of 1000 lumps", {"static", file("beam.toml", bent_beam(1000)), "-q", "-o", out});
    measure("static, frame of 190 beams", {"static", file("frame.toml", frame(true)), "-q", "-o", out});
    measure("modes, the same frame about its equilibrium", {"modes", file("frame.toml", frame(true)), "-q", "-o", out});
    measure("modes, the same frame without weight", {"modes", file("bare.toml", frame(false)), "-q", "-o", out});
    std::filesystem::remove_all(folder);
    return 0;
}

}  // namespace
}  // namespace dttmm::host

int main() { return dttmm::host::measure_all(); }
