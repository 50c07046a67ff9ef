// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/step_stops.h"

#include "model/index.h"

namespace dttmm::host {

void StepStops::begin_step() {
    before_ = now_;
    may_leave_ = true;
    lets_go_struck_ = false;
}

void StepStops::find(const JointSystem& joints, const std::vector<BodyState>& now) {
    joints.find_stops(now, before_, reached_);
    now_ = reached_;
    for (size_t j = 0; j < now_.size(); ++j)
        if (before_[j].is_foreseen) now_[j].let_go();
}

bool StepStops::let_go() {
    if (std::ranges::none_of(now_, &Stop::acts)) return false;
    for (Stop& stop : reached_) stop.let_go();
    now_ = reached_;
    return true;
}

bool StepStops::change(const StepEquations& equations, const std::vector<BodyState>& end) {
    return release_pulling(equations) || leave(equations, end) || equations.add_first_stop(end, reached_, before_, now_);
}

bool StepStops::release_pulling(const StepEquations& equations) {
    const long before = struck();
    if (!equations.release_pulling_stops(now_)) return false;
    lets_go_struck_ = lets_go_struck_ || struck() < before;
    return true;
}

/// Once in a step: where another stop ends it, it does not begin again.
bool StepStops::leave(const StepEquations& equations, const std::vector<BodyState>& end) {
    if (!may_leave_ || !equations.leave_stops(end, before_, now_)) return false;
    may_leave_ = false;
    return true;
}

void StepStops::count(double time) {
    const auto first = std::ranges::find_if(now_, &Stop::is_struck);
    if (first == now_.end()) return;
    if (struck() + std::ranges::count_if(before_, &Stop::is_struck) > 1 || lets_go_struck_) ++close_impacts_;
    bool is_lost = lets_go_struck_;
    for (size_t j = 0; j < now_.size(); ++j) is_lost = is_lost || (before_[j].is_struck() && !now_[j].acts);
    if (is_lost && lost_.steps++ == 0) {
        lost_.time = time;
        lost_.joint = as_size(first - now_.begin());
    }
}

}  // namespace dttmm::host
