// SPDX-License-Identifier: BSD-3-Clause
//
// Runs random machines with two programs and tells how far their histories are apart. What rounding makes of a machine is
// measured too: the other program runs it where it stands and 0.6 m beside. Stiff parts without damping ring by rounding.
// With --hard parts are stiffer, and the programs may differ by what the first one errs: it runs at half the step, too.
#include <fmt/format.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "support/random_machine.h"

namespace {

namespace fs = std::filesystem;

struct History {
    std::vector<std::string> units;  ///< of the columns
    std::vector<std::vector<double>> rows;
};

History read(const fs::path& file) {
    History history;
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);  // names
    std::getline(in, line);
    std::stringstream units(line);
    for (std::string unit; std::getline(units, unit, ',');) history.units.push_back(unit);
    while (std::getline(in, line)) {
        std::stringstream numbers(line);
        history.rows.emplace_back();
        for (std::string number; std::getline(numbers, number, ',');) history.rows.back().push_back(std::stod(number));
    }
    return history;
}

/// Largest difference of a value from a row on, as share of the largest value of its unit; of positions by the way from the
/// start.
double difference(const History& a, const History& b, size_t first_row) {
    if (a.units != b.units || a.rows.size() != b.rows.size()) return HUGE_VAL;
    std::map<std::string, double> scale, apart;
    for (size_t n = first_row; n < a.rows.size(); ++n)
        for (size_t c = 0; c < a.units.size(); ++c) {
            const bool is_place = a.units[c] == "m";
            const double x = a.rows[n][c] - (is_place ? a.rows[0][c] : 0), y = b.rows[n][c] - (is_place ? b.rows[0][c] : 0);
            scale[a.units[c]] = std::max({scale[a.units[c]], std::abs(x), std::abs(y)});
            apart[a.units[c]] = std::max(apart[a.units[c]], std::abs(x - y));
        }
    double worst = 0;
    for (const auto& [unit, size] : scale)
        if (size > 0) worst = std::max(worst, apart[unit] / size);
    return worst;
}

/// So many times what another place of the machine makes is a change.
constexpr double kSpread = 10;

/// Exit code of a run.
int run(const std::string& program, const fs::path& model, const fs::path& out, const std::string& options = "") {
    fs::remove_all(out);
    const std::string command = fmt::format("'{}' run '{}' {} -q -o '{}' > '{}.log' 2>&1", program, model.string(), options,
                                            out.string(), out.string());
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

int main(int argc, char** argv) {
    const bool is_hard = argc > 1 && std::string_view(argv[1]) == "--hard";
    if (is_hard) ++argv, --argc;
    if (argc < 5) {
        fmt::print(stderr, "compare_machines [--hard] PROGRAM OTHER FIRST_SEED COUNT [TOLERANCE [FIRST_ROW]]\n");
        return 2;
    }
    const uint64_t first = std::strtoull(argv[3], nullptr, 10), count = std::strtoull(argv[4], nullptr, 10);
    const double tolerance = argc > 5 ? std::atof(argv[5]) : 1e-9;
    const size_t first_row = argc > 6 ? std::strtoull(argv[6], nullptr, 10) : 0;
    const fs::path folder = fs::temp_directory_path() / fmt::format("compare_machines_{}", first);
    fs::create_directories(folder);
    size_t both = 0, neither = 0, changed = 0, within_error = 0;
    const dttmm::test::Stiffest stiffest = is_hard ? dttmm::test::kHard : dttmm::test::Stiffest{};
    std::map<int, size_t> decades, of_place;
    const auto decade_of = [](double apart) { return apart > 0 ? static_cast<int>(std::floor(std::log10(apart))) : -99; };
    for (uint64_t seed = first; seed < first + count; ++seed) {
        const fs::path model = folder / "model.toml", beside = folder / "beside.toml";
        const dttmm::test::Placement moved{Eigen::Matrix3d::Identity(), {0.37, -0.21, 0.45}};
        const dttmm::test::RandomMachine machine(seed, 40, {}, {}, stiffest);
        std::ofstream(model) << "format = \"dttmm/1\"\n" << machine.text();
        std::ofstream(beside) << "format = \"dttmm/1\"\n"
                              << dttmm::test::RandomMachine(seed, 40, moved, {}, stiffest).text();
        const int code = run(argv[1], model, folder / "one"), other = run(argv[2], model, folder / "other");
        if (code != other) {
            fmt::print("{}: ends with code {}, the other with {}\n", seed, code, other);
            ++changed;
        } else if (code != 0) {
            ++neither;
        } else {
            ++both;
            const History history = read(folder / "other/history.csv");
            const History own = read(folder / "one/history.csv");
            const double apart = difference(own, history, first_row);
            const bool runs_beside = run(argv[2], beside, folder / "beside") == 0;
            const double rounding = runs_beside ? difference(read(folder / "beside/history.csv"), history, first_row) : 0;
            ++decades[decade_of(apart)];
            ++of_place[decade_of(rounding)];
            if (apart <= std::max(tolerance, kSpread * rounding)) continue;
            const std::string half = fmt::format("--step {} --output-step {}", 0.5 * machine.step(), machine.step());
            // Of second order: 4/3 of what half the step changes. The first program knows the options
            const double error = is_hard && run(argv[1], model, folder / "half", half) == 0
                                     ? 4.0 / 3 * difference(read(folder / "half/history.csv"), own, first_row)
                                     : 0;
            if (apart <= error) {
                ++within_error;
            } else {
                fmt::print("{}: {:.1e} apart; {:.1e} by its place\n", seed, apart, rounding);
                ++changed;
            }
        }
    }
    fmt::print("{} machines: {} run by both, {} refused by both, {} differ\n", count, both, neither, changed);
    if (is_hard) fmt::print("{} more differ by less than the error of a step\n", within_error);
    const auto print = [](const char* what, const std::map<int, size_t>& list) {
        fmt::print("{} by decade:", what);
        for (const auto& [decade, number] : list)
            fmt::print("{}: {}", decade == -99 ? " same" : fmt::format(" 1e{}", decade), number);
        fmt::print("\n");
    };
    print("largest difference", decades);
    print("of the other program by the place of the machine", of_place);
    fs::remove_all(folder);
    return changed > 0;
}
