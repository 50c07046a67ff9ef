// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace dttmm::host {

/// A valid model that runs in no time: a body on two springs. Tests change one thing in it; the line numbers are theirs.
inline constexpr const char* kSmallModel = R"(format = "dttmm/1"
title = "small"

[parameters]
mass = "2 kg"

[simulation]
duration = "50 ms"
step = "1 ms"

[output]
step = "5 ms"

[[body]]
name = "plate"
mass = "=mass"
inertia = [0.2, 0.3, 0.4]
markers.left = [-0.1, 0, 0]
markers.right = [0.1, 0, 0]

[[load]]
on = "plate"
direction = [0, 0, 1]
force = "100 N"

[[element]]
name = "one"
type = "spring_damper"
from = "ground"
to = "plate.left"
stiffness = "5e4 N/m"

[[element]]
name = "two"
type = "spring_damper"
from = "ground"
to = "plate.right"
stiffness = "6e4 N/m"
)";

/// The small model with the first `what` replaced.
inline std::string small_model_with(const std::string& what, const std::string& instead) {
    std::string text = kSmallModel;
    return text.replace(text.find(what), what.size(), instead);
}

/// The small model on two elements of the plugins of tests/loader/faulty, for two seconds.
inline std::string faulty_model() {
    std::string text = small_model_with("50 ms", "2 s");
    for (const auto& [what, instead] :
         {std::pair("spring_damper", "faulty"), std::pair("stiffness = \"5e4 N/m\"", "number = -3"),
          std::pair("spring_damper", "faulty"), std::pair("stiffness = \"6e4 N/m\"", "number = -3")})
        text.replace(text.find(what), std::string(what).size(), instead);
    return text;
}

}  // namespace dttmm::host
