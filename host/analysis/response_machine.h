// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/excitation.h"
#include "analysis/modal_session.h"
#include "analysis/request.h"
#include "analysis/response_channels.h"
#include "analysis/response_curves.h"
#include "loader/plugins.h"
#include "record/warnings.h"

namespace dttmm::host {

/// A machine in steady vibration as a request has it: its model, what drives it and its curves.
class ResponseMachine {
public:
    /// All must outlive it. Throws Error for a model in which nothing vibrates, and for inputs and channels that it has not.
    ResponseMachine(const Request& request, const Plugins& plugins, Warnings& warnings);
    ResponseMachine(const ResponseMachine&) = delete;
    ResponseMachine& operator=(const ResponseMachine&) = delete;

    ModalSession session;
    const ResponseChannels channels;
    const Excitation excitation;
    ResponseCurves curves;
};

}  // namespace dttmm::host
