// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "dttmm_law.h"
#include "law/law.h"

namespace dttmm::plugin {

/// A law behind the C interface.
class ForeignLaw final : public Law {
public:
    /// values: of its parameters. at_work: takes the law while it is asked, so that a crash can be laid at its door.
    ForeignLaw(const dttmm_law& law, const dttmm_law* volatile* at_work, const double* values)
        : law_(law), at_work_(at_work), values_(values, values + law.parameter_count) {}
    /// Throws Error(DTTMM_ERROR_INTERNAL) naming the law where its answer is not finite, its force is beyond 1e100 N or N m,
    /// it writes beyond its memory, it changes how the processor computes, or it throws.
    LawOnPath along(const LawPath& path) const override;
    size_t memory_size() const override { return law_.memory_count; }

private:
    const dttmm_law& law_;
    const dttmm_law* volatile* at_work_;
    std::vector<double> values_;
};

}  // namespace dttmm::plugin
