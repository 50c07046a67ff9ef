// SPDX-License-Identifier: BSD-3-Clause
#include "element/rubber_mount.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/parameters.h"
#include "law/viscoelastic.h"

namespace dttmm::plugin {

namespace {

constexpr uint32_t kColumns = 3;
constexpr uint32_t kNumbers = kColumns * RubberMount::kMostRows;

constexpr dttmm_parameter rows(const char* name, bool is_rotation) {
    return {name,
            is_rotation ? "frequency [Hz]; stiffness [N*m/rad]; loss angle [rad]"
                        : "frequency [Hz]; stiffness [N/m]; loss angle [rad]",
            kNumbers,
            DTTMM_PARAMETER_TABLE,
            kNotGiven,
            0,
            kLargest,
            nullptr,
            0,
            "magnitude of the dynamic stiffness in that direction of the from end, and the angle by which the force leads"};
}

constexpr dttmm_parameter kParameters[] = {rows("x", false), rows("y", false), rows("z", false),
                                           rows("rx", true), rows("ry", true), rows("rz", true)};

}  // namespace

const dttmm_element_type RubberMount::kType = {
    "rubber_mount", DTTMM_ENDS_FROM_TO, std::size(kParameters), kParameters,
    "a mount whose stiffness and loss angle depend on the frequency; a direction without rows is free"};

RubberMount::RubberMount(std::span<const double> values) {
    for (int d = 0; d < 6; ++d) {
        std::vector<DynamicStiffnessRow> rows;
        for (std::span<const double> own = values.subspan(as_size(d) * kNumbers, kNumbers);
             own.size() >= kColumns && is_given(own[0]); own = own.subspan(kColumns)) {
            const auto fail = [&](const char* fault) {
                throw Error(DTTMM_ERROR_MODEL,
                            fmt::format("{}: row {}: {}", kDirectionNames[as_size(d)], rows.size() + 1, fault));
            };
            if (!(own[0] > 0)) fail("the frequency must be more than zero");
            if (!rows.empty() && !(2 * M_PI * own[0] > rows.back().omega)) fail("the frequencies must increase");
            if (!(own[1] > 0)) fail("the stiffness must be more than zero");
            if (!(own[2] < M_PI / 2)) fail("the loss angle must be less than 90 degrees");
            rows.push_back({2 * M_PI * own[0], own[1], own[2]});
        }
        if (rows.size() == 1)
            throw Error(DTTMM_ERROR_MODEL, fmt::format("{}: one row: two or more are needed", kDirectionNames[as_size(d)]));
        if (!rows.empty()) law_.set(d, std::make_shared<const Viscoelastic>(std::move(rows)));
    }
}

}  // namespace dttmm::plugin
