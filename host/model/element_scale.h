// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// An element that is softer, stiffer or otherwise damped than the file has it.
struct ElementScale {
    std::string element;
    double stiffness = 1;  ///< factor of all its stiffnesses and moduli
    double damping = 1;    ///< factor of all its viscous dampings
};

/// What of an element a factor acts on.
enum class ScaledPart : unsigned char { stiffness, damping };

/// Whether an element has numbers other than zero of this kind: stiffnesses [N/m, N m/rad, N/m^3, Pa], dampings [N s/m,
/// N m s/rad].
bool has_part(const Element& element, const ElementCatalogue& catalogue, ScaledPart part);

/// Multiplies them. Throws Error(model_invalid) where there is no such element, or nothing to multiply.
void scale_element(Model& model, const ElementCatalogue& catalogue, const ElementScale& scale);

}  // namespace dttmm::host
