// SPDX-License-Identifier: BSD-3-Clause
#include "report/show.h"

#include <fmt/format.h>

#include "analysis/machine_geometry.h"
#include "record/atomic_file.h"
#include "record/results_folder.h"
#include "report/three_views.h"

namespace dttmm::host {

namespace fs = std::filesystem;

ExitCode show_model(const Request& request) {
    fs::path path = default_results_path(request.model);
    path += "-views.svg";
    if (request.output) path = *request.output;
    if (path != "-" && path.extension() != ".svg")
        throw Error(ExitCode::usage, fmt::format("{}: the picture is SVG; give a name that ends with .svg", path.string()));
    const StandingMachine machine(request);
    const std::string picture = draw_three_views(machine.model, machine.plugins.catalogue());
    if (path == "-") {
        fmt::print("{}", picture);
        return ExitCode::ok;
    }
    std::error_code fault;  // writing the file reports it
    if (!request.output) fs::create_directories(from_start(path).parent_path(), fault);
    write_atomically(from_start(path), picture);
    if (!request.quiet) fmt::print("{}\n", path.string());
    return ExitCode::ok;
}

}  // namespace dttmm::host
