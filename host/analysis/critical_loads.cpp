// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/critical_loads.h"

#include <algorithm>
#include <utility>

#include "loader/modal_instance.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// A machine at rest under a multiple of its forces.
class Buckling {
public:
    static constexpr double kLargest = 1e9;  // of the forces at rest; the results name it

    explicit Buckling(ModalDescription description) : description_(std::move(description)) {}

    CriticalLoads find_factors(int wanted) {
        description_.scale_forces(0);
        is_held_ = is_held();
        slack_ = is_held_ ? 1 : kSlack;
        double high = 1, below = 0;
        int there = count(high, slack_);
        for (double step = kLargestStep; there < wanted && high < kLargest && step > kLeastStep;) {
            const double next = std::min(step * high, kLargest);
            if (const std::optional<int> found = try_count(next)) {
                there = *found;
                high = next;
            } else {
                step = std::sqrt(step);
            }
        }
        std::vector<CriticalLoad> factors;
        for (int k = 1; k <= std::min(wanted, there); ++k) {
            const double found = find_crossing(k, below, high);
            factors.push_back(found <= kSmallest && !is_held_ ? CriticalLoad{0, 0} : judge(found, k));
            below = found * (1 - 1e-9);
        }
        return {factors, high, high < kLargest ? why_not_ : ""};
    }

private:
    /// Of dttmm_modal.h: growth that rounding could make is not counted; nor is that of the second look.
    static constexpr int kSlack = 4, kMoreSlack = 16;

    /// Not known: as if something were free.
    bool is_held() {
        try {
            return ModalInstance(description_.plugin(), description_.model()).count_free().value_or(1) == 0;
        } catch (const Error& error) {
            if (error.code() != ExitCode::numerical_failure) throw;
            return false;
        }
    }
    int count(double factor, int slack) {
        description_.scale_forces(factor);
        return as_int(ModalInstance(description_.plugin(), description_.model()).count_growing(slack));
    }
    /// None: they cannot be counted under so large forces.
    std::optional<int> try_count(double factor) {
        try {
            return count(factor, slack_);
        } catch (const Error& error) {
            if (error.code() == ExitCode::plugin_failure || error.code() == ExitCode::internal_error) throw;
            why_not_ = error.what();
            return std::nullopt;
        }
    }
    /// The factor from which on so many motions grow.
    double find_crossing(int number, double below, double above) {
        constexpr double kEnclosed = 1e-12;
        while (above - below > kEnclosed * above && above > kSmallest) {
            const double middle = below > above / 4 ? 0.5 * (below + above) : std::max(0.25 * above, below + 1e-3 * above);
            (count(middle, slack_) >= number ? above : below) = middle;
        }
        return above;
    }
    /// By what share beyond a factor so many motions grow in spite of a larger slack; to 1e-6 of that share.
    std::optional<double> share_beyond(double factor, int number, int slack) {
        double above = kLeastShare;
        for (; count(factor * (1 + above), slack) < number; above *= 4)
            if (above > 1e9) return std::nullopt;
        double below = above > kLeastShare ? above / 4 : above;
        while (above - below > 1e-6 * above) {
            const double middle = 0.5 * (below + above);
            (count(factor * (1 + middle), slack) >= number ? above : below) = middle;
        }
        return above;
    }
    /// The squared rate of growth is linear in the factor where it begins.
    CriticalLoad judge(double found, int number) {
        if (is_held_) return {found, share_beyond(found, number, kSlack)};
        const std::optional<double> share = share_beyond(found, number, kMoreSlack);
        if (!share) return {found, std::nullopt};
        const double late = found * *share * kSlack / (kMoreSlack - kSlack), factor = found - late;
        if (factor < kNothing * found) return {0, std::nullopt};
        return {factor, std::max(late / factor, kLeastShare)};
    }

    /// From one factor to the next: 4, and its roots as long as they are larger than the least. The last is 1.022.
    static constexpr double kLargestStep = 4, kLeastStep = 1.02;
    static constexpr double kLeastShare = 1e-9;  // of a factor: a thousand times what a bisection leaves
    static constexpr double kSmallest = 1e-9;    // factor
    static constexpr double kNothing = 1e-4;     // of a factor that rounding makes: share_beyond() is known to 1e-6
    ModalDescription description_;
    bool is_held_ = false;
    int slack_ = kSlack;
    std::string why_not_;
};

}  // namespace

CriticalLoads find_critical_loads(ModalDescription resting, int wanted) {
    return Buckling(std::move(resting)).find_factors(wanted);
}

}  // namespace dttmm::host
