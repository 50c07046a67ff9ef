// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "loader/plugins.h"
#include "record/column.h"
#include "study/study_folder.h"

namespace dttmm::host {

/// Figures of a model as a function of some of its parameters.
class FigureFunction {
public:
    /// parameters: names. figures: as `dttmm study --figures` has them; the command that finds them is the request's, else
    /// it shows in their form: "bolt1.force.z:peak" is of a run, "mode1.frequency" of modes, the others of a response.
    /// plugins must outlive it. Throws Error(usage) for a parameter that does not exist or is the result of an expression,
    /// and as the command does.
    FigureFunction(const Request& request, const Model& model, const Plugins& plugins,
                   const std::vector<std::string>& parameters, const std::vector<std::string>& figures);

    const std::vector<Column>& figures() const { return plan_.columns; }
    const std::vector<Column>& parameters() const { return plan_.cases.parameters; }
    const std::string& command() const { return plan_.command; }
    const Plugins& plugins() const { return plugins_; }
    /// What is asked of the model with one parameter times a factor.
    Request request_with(Eigen::Index parameter, double factor) const {
        return request_at(nominal_.cwiseProduct(Eigen::VectorXd::Ones(nominal_.size()) +
                                                (factor - 1) * Eigen::VectorXd::Unit(nominal_.size(), parameter)));
    }
    /// The same with these values [SI].
    Request request_at(const Eigen::VectorXd& values) const;
    /// As a study of them would have it, without cases.
    const StudyPlan& plan() const { return plan_; }
    /// The file's values [SI].
    const Eigen::VectorXd& nominal() const { return nominal_; }

    /// rows: values of the parameters [SI], a row per case. Returns figures, a row per case. A case that fails has NaN
    /// everywhere; `first_failure` is then why.
    Eigen::MatrixXd evaluate(const Eigen::MatrixXd& rows, int jobs, std::string& first_failure) const;

private:
    const Plugins& plugins_;
    StudyPlan plan_;
    Eigen::VectorXd nominal_;
};

}  // namespace dttmm::host
