// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/figure_function.h"
#include "model/index.h"
#include "support/paths.h"

namespace dttmm::host {

inline std::filesystem::path example(const std::string& name) {
    return std::filesystem::path(test::paths::source_dir()) / "examples" / name / "model.toml";
}

/// Figures of a model by some of its parameters, as `dttmm sensitivity` with options has them.
class FiguresOf {
public:
    FiguresOf(const std::filesystem::path& file, const std::vector<std::string>& parameters,
              const std::vector<std::string>& figures,
              const std::vector<std::pair<std::string, std::string>>& options = {}) {
        request_.model = file;
        for (const auto& [name, value] : options) give(request_, option(name, kSensitivity), value);
        plugins_.emplace(request_.plugins);
        ModelOverrides overrides = request_.overrides;
        overrides.purpose = Purpose::modes;
        const Model model = read_model(request_.model, plugins_->catalogue(), overrides);
        function_.emplace(request_, model, *plugins_, parameters, figures);
    }
    const FigureFunction& function() const { return *function_; }
    const std::vector<Column>& figures() const { return function_->figures(); }

    /// Slopes by ln p from cases at parameters changed by d and 2 d, extrapolated to none: a row per figure.
    Eigen::MatrixXd differences(double d) const {
        const Eigen::VectorXd& nominal = function_->nominal();
        Eigen::MatrixXd slopes(as_row(figures().size()), nominal.size());
        for (Eigen::Index p = 0; p < nominal.size(); ++p) {
            Eigen::MatrixXd points = nominal.transpose().replicate(4, 1);
            const double changes[] = {d, -d, 2 * d, -2 * d};
            for (Eigen::Index i = 0; i < 4; ++i) points(i, p) *= 1 + changes[i];
            std::string failure;
            const Eigen::MatrixXd at = function_->evaluate(points, 2, failure);
            EXPECT_EQ(failure, "");
            slopes.col(p) = (8 * (at.row(0) - at.row(1)) - (at.row(2) - at.row(3))).transpose() / (12 * d);
        }
        return slopes;
    }

private:
    Request request_;
    std::optional<Plugins> plugins_;
    std::optional<FigureFunction> function_;
};

}  // namespace dttmm::host
