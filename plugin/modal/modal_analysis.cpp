// SPDX-License-Identifier: BSD-3-Clause
#include "modal/modal_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "modal/geometric_stiffness.h"

namespace dttmm::plugin {

ModalAnalysis::ModalAnalysis(const dttmm_modal_model& model, const AtRest* rest)
    : model_(model, rest), stiffness_(model_), topology_(model_) {
    if (!rest) add_geometric_stiffness(model_);
}

double ModalAnalysis::bent_at_rest(size_t element, bool& is_lumped) const {
    is_lumped = element < model_.resting.size() && model_.resting[element].is_lumped;
    return element < model_.resting.size() ? model_.resting[element].share : 0;
}

size_t ModalAnalysis::find_modes(uint32_t count, double below) {
    if (!model_.is_elastic())
        throw Error(DTTMM_ERROR_MODEL, "nothing is elastic: no element stores energy, nothing vibrates");
    if (!(below >= 0) || !std::isfinite(below) || (below == 0 && count == 0))
        throw Error(DTTMM_ERROR_ARGUMENT, "find_modes wants a frequency or a count");
    ModeFinder finder(stiffness_);
    modes_ = below > 0 ? finder.find_below(2 * M_PI * below) : finder.find_first(as_int(count));
    at_ = -1;
    return modes_.size();
}

/// The smallest singular value of the overall transfer matrix at a frequency as share of what it is a little beside.
double ModalAnalysis::overall_residual(const Mode& mode) const {
    constexpr double kBeside = 1e-3;
    const double omega = mode.omega, beside = omega > 0 ? omega * (1 + kBeside) : kBeside * std::max(mode.cut, 1.0);
    return topology_.residual(omega * omega, beside * beside);
}

const Mode& ModalAnalysis::mode_at(uint32_t index) const {
    if (index >= modes_.size()) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no mode {}", index));
    return modes_[index];
}

void ModalAnalysis::mode(uint32_t index, dttmm_mode* out, double* bodies, double* nodes, double* shares) {
    const Mode& mode = mode_at(index);
    if (out) {
        *out = {mode.omega / (2 * M_PI), mode.bracket, static_cast<uint32_t>(mode.multiplicity),
                mode.residual,           mode.mass,    {}};
        Eigen::Map<Vector6>{out->participation} = mode.participation;
        if (has_overall()) out->residual = overall_residual(mode);
    }
    for (int b = 0; bodies && b < as_int(model_.centres.size()); ++b)
        Eigen::Map<Vector6>{bodies + 6 * b} = model_.by_centre(b) * mode.shape[as_size(b)];
    for (size_t n = 0; nodes && n < model_.nodes.size(); ++n)
        Eigen::Map<Vector6>{nodes + 6 * n} = model_.node_motion(n, mode.shape);
    if (shares) std::ranges::copy(mode.shares, shares);
}

OverallTransfer::Check ModalAnalysis::overall(double frequency) {
    if (!has_overall())
        throw Error(DTTMM_ERROR_NUMERIC,
                    "the paths are too long for products of transfer matrices: they would have no digits left");
    const double omega = 2 * M_PI * frequency;
    return topology_.check(omega * omega, 1.002 * omega * omega);
}

double ModalAnalysis::along(uint32_t index, uint32_t element, uint32_t count, double* shape) {
    const Mode& mode = mode_at(index);
    if (at_ != static_cast<long>(index)) {
        stiffness_.cut(mode.cut);
        stiffness_.set(mode.omega * std::abs(mode.omega));
        at_ = static_cast<long>(index);
    }
    return dttmm::plugin::along(stiffness_, element, mode.shape, count, shape);
}

/// A place and direction that a rigid-body mode moves, as the model file calls it.
std::string ModalAnalysis::describe_motion(const Mode& mode) const {
    constexpr const char* kNames[] = {"x", "y", "z", "rx", "ry", "rz"};
    for (const Eigen::Index first : {0, 3})
        for (int f = 0; f < as_int(model_.frames.size()); ++f) {
            Eigen::Index d = 0;
            if (mode.shape[as_size(f)].segment<3>(first).cwiseAbs().maxCoeff(&d) > 0.1)
                return fmt::format("{} in {}", model_.name(f), kNames[first + d]);
        }
    return "inside";
}

/// At 0 Hz of a machine with `free` rigid-body modes. Low frequencies ω have the same response but for (ω/ω₁)² of it, ω₁ the
/// first that is not zero; two of them leave (ω/ω₁)⁴ (Richardson). What rounding moves as a whole is taken out.
Response ModalAnalysis::respond_at_rest(int free, int frame, const Vector3& point, const Vector6& force) {
    constexpr double kNoWork = 1e-7;    // of the force times the largest displacement: rounding of a shape is below 1e-8
    constexpr double kLowShare = 1e-3;  // ω/ω₁: leaves 1e-12, and rounding grows as its inverse square
    const std::vector<Mode> modes = ModeFinder(stiffness_).find_first(free + 1);
    const auto count = as_size(free);
    for (size_t m = 0; m < count && frame >= 0; ++m) {
        const Vector6 moved = FrequencyModel::at_point(point, model_.origin(frame)) * modes[m].shape[as_size(frame)];
        if (std::abs(moved.dot(force)) > kNoWork * force.norm())
            throw Error(DTTMM_ERROR_SINGULAR,
                        fmt::format("0 Hz: the machine is free to move in {} direction{}, and the force moves it ({}): it "
                                    "accelerates for ever; hold that direction by a joint, an element or fixed = [..], or "
                                    "begin above 0 Hz",
                                    free, free == 1 ? "" : "s", describe_motion(modes[m])));
    }
    stiffness_.cut(modes.front().cut);
    const double first = modes.size() > count ? modes[count].omega : 1;
    stiffness_.set(-kLowShare * kLowShare * first * first);  // for the masses alone
    std::vector<FrameVector> momenta;
    for (size_t m = 0; m < count; ++m) momenta.push_back(stiffness_.mass_times(modes[m].shape));
    Response motion = dttmm::plugin::respond(stiffness_, kLowShare * first, frame, point, force);
    const Response at_half = dttmm::plugin::respond(stiffness_, 0.5 * kLowShare * first, frame, point, force);
    for (size_t f = 0; f < motion.size(); ++f) motion[f] = (4 * at_half[f] - motion[f]) / 3;
    for (size_t m = 0; m < count; ++m) {
        std::complex<double> share = 0;
        for (size_t f = 0; f < motion.size(); ++f) share += motion[f].dot(momenta[m][f].cast<std::complex<double>>());
        share = std::conj(share) / modes[m].mass;
        for (size_t f = 0; f < motion.size(); ++f) motion[f] -= share * modes[m].shape[f].cast<std::complex<double>>();
    }
    for (auto& u : motion) u = u.real().cast<std::complex<double>>();
    return motion;
}

void ModalAnalysis::respond(double frequency, int on_body, int on_node, const Vector3& given, const Vector6& force,
                            double* bodies, double* nodes) {
    if (!(frequency >= 0) || !std::isfinite(frequency)) throw Error(DTTMM_ERROR_ARGUMENT, "a frequency must be finite");
    if ((on_body < 0) == (on_node < 0)) throw Error(DTTMM_ERROR_ARGUMENT, "respond wants a body or a node");
    const double omega = 2 * M_PI * frequency;
    const int frame = on_body >= 0 ? on_body : model_.nodes[as_size(on_node)].frame;
    const Vector3 point = on_body >= 0 ? given : model_.nodes[as_size(on_node)].position;
    const int free = frequency == 0 ? ModeFinder(stiffness_).count_rigid() : 0;
    stiffness_.cut(omega);  // here pieces only keep numbers small
    at_ = -1;
    if ((!model_.levers.empty() || model_.is_at_rest) && !is_stable_)
        stiffness_.refuse_growing(-1e-11 * stiffness_.stiffest());
    is_stable_ = true;
    const Response motion = free > 0 ? respond_at_rest(free, frame, point, force)
                                     : dttmm::plugin::respond(stiffness_, omega, frame, point, force);
    const auto write = [](const Eigen::Matrix<std::complex<double>, 6, 1>& u, double* out) {
        for (Eigen::Index d = 0; d < 6; ++d) {
            out[2 * d] = u(d).real();
            out[2 * d + 1] = u(d).imag();
        }
    };
    for (int b = 0; bodies && b < as_int(model_.centres.size()); ++b)
        write(model_.by_centre(b).cast<std::complex<double>>() * motion[as_size(b)], bodies + 12 * b);
    for (size_t n = 0; nodes && n < model_.nodes.size(); ++n) {
        const int f = model_.nodes[n].frame;
        write(f < 0 ? Eigen::Matrix<std::complex<double>, 6, 1>::Zero()
                    : Eigen::Matrix<std::complex<double>, 6, 1>(model_.by_node(n).cast<std::complex<double>>() *
                                                                motion[as_size(f)]),
              nodes + 12 * n);
    }
}

}  // namespace dttmm::plugin
