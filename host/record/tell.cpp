// SPDX-License-Identifier: BSD-3-Clause
#include "record/tell.h"

#include <cstdio>

namespace dttmm::host {

void tell(const std::string& line) noexcept {
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fputc('\n', stderr);
}

}  // namespace dttmm::host
