// SPDX-License-Identifier: BSD-3-Clause
#include "identify/figure_function.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "study/case_runner.h"
#include "study/plan.h"

namespace dttmm::host {

namespace {

std::string command_of(const Request& request, const std::vector<std::string>& figures) {
    if (!request.study.work.empty()) return request.study.work;
    const auto is_all = [&](const auto& is) { return !figures.empty() && std::ranges::all_of(figures, is); };
    if (is_all([](const std::string& text) { return text.starts_with("mode") || text.starts_with("damped"); }))
        return "modes";
    if (is_all([](const std::string& text) { return text.find(':') == text.npos; })) return "response";
    return "run";
}

}  // namespace

FigureFunction::FigureFunction(const Request& request, const Model& model, const Plugins& plugins,
                               const std::vector<std::string>& parameters, const std::vector<std::string>& figures)
    : plugins_(plugins) {
    plan_.command = command_of(request, figures);
    refuse_options_beside(request, plan_.command, "gives these figures");
    plan_.request = request;
    plan_.request.study.variations.clear();
    plan_.request.modes.is_damped =
        std::ranges::any_of(figures, [](const std::string& text) { return text.starts_with("damped"); });
    plan_.request.quiet = true;
    plan_.figures = figures;
    nominal_.resize(as_row(parameters.size()));
    for (size_t i = 0; i < parameters.size(); ++i) {
        const auto own = std::ranges::find(model.parameters, parameters[i], &Parameter::name);
        if (own->unit.empty())
            throw Error(ExitCode::usage,
                        fmt::format("--by {}: it is the result of an expression; name what it rests on", quote(own->name)));
        plan_.cases.parameters.push_back({own->name, own->unit});
        nominal_(as_row(i)) = own->value;
    }
    plan_.columns = find_figures(plan_, plugins);
    if (plan_.columns.empty()) throw Error(ExitCode::usage, "the model has no such figures");
}

Request FigureFunction::request_at(const Eigen::VectorXd& values) const {
    StudyPlan plan = plan_;
    plan.cases.values = values.transpose();
    return request_of(plan, 0);
}

Eigen::MatrixXd FigureFunction::evaluate(const Eigen::MatrixXd& rows, int jobs, std::string& first_failure) const {
    StudyPlan plan = plan_;
    plan.cases.values = rows;
    const std::filesystem::path scratch =
        std::filesystem::temp_directory_path() / fmt::format("dttmm-{}", Journal::make_name());
    const std::vector<TaskResult> results = map_in_processes(as_size(rows.rows()), jobs, [&](size_t row) {
        const CaseOutcome outcome = run_case(plan, row, plugins_, scratch);
        if (outcome.status != "completed") throw Error(ExitCode::numerical_failure, outcome.reason);
        return outcome.figures;
    });
    std::error_code fault;
    std::filesystem::remove_all(scratch, fault);
    Eigen::MatrixXd figures =
        Eigen::MatrixXd::Constant(rows.rows(), as_row(plan.columns.size()), std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {
        const TaskResult& result = results[as_size(r)];
        if (!result.reason.empty() && first_failure.empty()) first_failure = result.reason;
        if (result.reason.empty())
            figures.row(r) = Eigen::Map<const Eigen::RowVectorXd>(result.numbers.data(), figures.cols());
    }
    return figures;
}

}  // namespace dttmm::host
