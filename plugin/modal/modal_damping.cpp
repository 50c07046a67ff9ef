// SPDX-License-Identifier: BSD-3-Clause
#include "modal/modal_damping.h"

#include <algorithm>
#include <cmath>

#include "core/index.h"
#include "modal/mode_finder.h"

namespace dttmm::plugin {

namespace {

/// The frames between pieces, in the order in which DynamicStiffness::cut() makes them.
struct Between {
    size_t line;
    double share;  ///< of the line's length
};

std::vector<Between> frames_between(const DynamicStiffness& D) {
    std::vector<Between> frames;
    for (size_t l = 0; l < D.model().lines.size(); ++l) {
        const int count = D.count(D.model().lines[l]);
        for (int i = 1; i < count; ++i) frames.push_back({l, static_cast<double>(i) / count});
    }
    return frames;
}

/// The modes that are damped, in order of frequency.
std::vector<Mode> find_vibrations(DynamicStiffness& D, const DampingRatios& given) {
    ModeFinder finder(D);
    std::vector<Mode> modes;
    if (given.is_of_all) {
        modes = finder.find_below(given.below);
    } else {
        const int rigid = finder.count_rigid();
        modes = ModeFinder(D).find_first(rigid + as_int(given.ratios.size()));
    }
    std::erase_if(modes, [](const Mode& mode) { return mode.omega <= 0; });
    return modes;
}

}  // namespace

ModalDamping find_modal_damping(DynamicStiffness& D, const DampingRatios& given, double least) {
    // Pieces of lines for a frequency so far above that of the last mode. With fewer its momentum is not at right angles to
    // the shapes of others: with 1 and 2 ratios of a mast on a body are off by 1e-3 of themselves, with 4 by 1e-4
    constexpr double kFiner = 4;
    std::vector<Mode> modes = find_vibrations(D, given);
    if (!given.is_of_all && modes.size() > given.ratios.size()) modes.resize(given.ratios.size());
    ModalDamping damping;
    damping.cut = modes.empty() ? least : std::max(least, kFiner * modes.back().omega);
    D.cut(damping.cut);
    const std::vector<Between> between = frames_between(D);
    for (Mode& mode : modes) {
        D.cut(mode.cut);
        D.set(mode.omega * mode.omega);
        FrameVector shape(mode.shape.begin(), mode.shape.begin() + as_row(D.model().frames.size()));
        for (const Between& frame : between) {
            const LineModel& line = D.model().lines[frame.line];
            shape.push_back(motion_along(D, line, mode.shape, frame.share * line.length()));
        }
        mode.shape = std::move(shape);
    }
    D.cut(damping.cut);
    for (size_t m = 0; m < modes.size(); ++m) {
        const Mode& mode = modes[m];
        const double ratio = given.ratios[given.is_of_all ? 0 : m];
        if (ratio == 0) continue;
        D.set(mode.omega * mode.omega);
        FrameVector momentum = D.mass_times(mode.shape);
        const double unit = 1 / std::sqrt(dot(mode.shape, momentum));
        for (Vector6& p : momentum) p *= unit;
        damping.momenta.push_back(std::move(momentum));
        damping.rates.push_back(2 * ratio * mode.omega);
    }
    return damping;
}

}  // namespace dttmm::plugin
