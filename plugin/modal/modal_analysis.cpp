// SPDX-License-Identifier: BSD-3-Clause
#include "modal/modal_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/index.h"
#include "modal/frequency_slope.h"
#include "modal/geometric_stiffness.h"

namespace dttmm::plugin {

ModalAnalysis::ModalAnalysis(const dttmm_modal_model& model, const AtRest* rest)
    : model_(model, rest), stiffness_(model_), harmonic_(stiffness_) {
    if (rest) return;
    topology_.emplace(model_);
    add_geometric_stiffness(model_);
}

const OverallTransfer& ModalAnalysis::topology() {
    if (!topology_) topology_.emplace(model_);
    return *topology_;
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

/// The last pivot of the overall transfer matrix at a frequency as share of what it is a little beside.
double ModalAnalysis::overall_residual(const Mode& mode) const {
    constexpr double kBeside = 1e-3;
    const double omega = mode.omega, beside = omega > 0 ? omega * (1 + kBeside) : kBeside * std::max(mode.cut, 1.0);
    return topology_->residual(omega * omega, beside * beside);
}

const Mode& ModalAnalysis::mode_at(uint32_t index) const {
    if (index >= modes_.size()) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no mode {}", index));
    return modes_[index];
}

void ModalAnalysis::mode(uint32_t index, dttmm_mode* out, double* bodies, double* nodes, double* shares) {
    const Mode& mode = mode_at(index);
    if (out) {
        *out = {mode.omega / (2 * M_PI), mode.bracket, as_whole<uint32_t>(mode.multiplicity), mode.residual, mode.mass, {}};
        Eigen::Map<Vector6>{out->participation} = mode.participation;
        if (has_overall()) out->residual = overall_residual(mode);
    }
    for (int b = 0; bodies && b < as_int(model_.centres.size()); ++b)
        Eigen::Map<Vector6>{bodies + 6 * b} = model_.by_centre(b) * mode.shape[as_size(b)];
    for (size_t n = 0; nodes && n < model_.nodes.size(); ++n)
        Eigen::Map<Vector6>{nodes + 6 * n} = model_.node_motion(n, mode.shape);
    if (shares) std::ranges::copy(mode.shares, shares);
}

void ModalAnalysis::set_damping(double mass_rate, std::span<const double> ratios, double below) {
    const auto wrong = [](double number) { return !(number >= 0) || !std::isfinite(number); };
    if (wrong(mass_rate) || wrong(below) || std::ranges::any_of(ratios, wrong))
        throw Error(DTTMM_ERROR_ARGUMENT, "damping must be finite and not negative");
    mass_rate_ = mass_rate;
    ratios_ = {{ratios.begin(), ratios.end()}, below > 0, 2 * M_PI * below};
    damping_.reset();
}

/// Cuts the lines, finer where modes are damped, and tells the solver what damps beside the elements.
void ModalAnalysis::cut_and_damp(double cut, double modes_below) {
    if (ratios_.ratios.empty()) {
        stiffness_.cut(cut);
        harmonic_.set_damping(mass_rate_, nullptr);
        return;
    }
    if (!damping_ || damped_below_ != modes_below || damping_->cut < cut) {
        DampingRatios given = ratios_;
        given.below = modes_below;
        damping_ =
            find_modal_damping(stiffness_, given, std::exp2(std::ceil(std::log2(cut))));  // not for every frequency anew
        damped_below_ = modes_below;
    }
    stiffness_.cut(damping_->cut);
    harmonic_.set_damping(mass_rate_, &*damping_);
}

DampedModes::Count ModalAnalysis::find_damped(double below) {
    if (!(below > 0) || !std::isfinite(below)) throw Error(DTTMM_ERROR_ARGUMENT, "a frequency must be finite and positive");
    at_ = -1;
    constexpr double kBeyond = 1.1;  // all that may be taken for a mode within the bound
    cut_and_damp(DampedModes::kFiner * 2 * M_PI * below, kBeyond * 2 * M_PI * below);
    const DampedModes found(stiffness_, harmonic_, 2 * M_PI * below);
    damped_ = found.modes();
    return {damped_.size(), found.is_proved(), found.has_left_out()};
}

void ModalAnalysis::damped_mode(uint32_t index, dttmm_damped_mode* mode, double* bodies, double* nodes) const {
    if (index >= damped_.size()) throw Error(DTTMM_ERROR_ARGUMENT, "there is no such damped mode");
    const DampedMode& own = damped_[index];
    if (mode) *mode = {{own.s.real(), own.s.imag()}, own.correction};
    const auto write = [](const Complex6& u, double* out) {
        for (Eigen::Index d = 0; d < 6; ++d) {
            out[2 * d] = u(d).real();
            out[2 * d + 1] = u(d).imag();
        }
    };
    for (size_t b = 0; bodies && b < model_.centres.size(); ++b)
        write(model_.by_centre(as_int(b)).cast<Complex>() * own.motion[b], bodies + 12 * b);
    for (size_t n = 0; nodes && n < model_.nodes.size(); ++n) {
        const int f = model_.nodes[n].frame;
        write(f < 0 ? Complex6(Complex6::Zero()) : Complex6(model_.by_node(n).cast<Complex>() * own.motion[as_size(f)]),
              nodes + 12 * n);
    }
}

void ModalAnalysis::strain_directions(uint32_t index, double* shares) {
    const Mode& mode = mode_at(index);
    const std::vector<Vector6> energies = strain_by_direction(model_, mode.shape);
    for (size_t e = 0; e < energies.size(); ++e) {
        const double sum = energies[e].sum();
        Eigen::Map<Vector6>{shares + 6 * e} = sum > 0 ? Vector6(mode.shares[e] * (energies[e] / sum)) : Vector6::Zero();
    }
}

void ModalAnalysis::require_overall() const {
    if (!has_overall())
        throw Error(DTTMM_ERROR_NUMERIC,
                    "the paths are too long for products of transfer matrices: they would have no digits left");
}

OverallTransfer::Written ModalAnalysis::overall_matrix(double frequency) const {
    require_overall();
    const double omega = 2 * M_PI * frequency;
    return topology_->written(omega * omega);
}

OverallTransfer::Check ModalAnalysis::overall(double frequency) {
    require_overall();
    const double omega = 2 * M_PI * frequency;
    return topology_->check(omega * omega, 1.002 * omega * omega);
}

double ModalAnalysis::along(uint32_t index, uint32_t element, uint32_t count, double* shape) {
    const Mode& mode = mode_at(index);
    if (at_ != as_whole<long>(index)) {
        stiffness_.cut(mode.cut);
        stiffness_.set(mode.omega * std::abs(mode.omega));
        at_ = as_whole<long>(index);
    }
    return dttmm::plugin::along(stiffness_, element, mode.shape, count, shape);
}

void ModalAnalysis::frequency_changes(uint32_t index, ModalAnalysis& above, ModalAnalysis& below, double* changes) {
    const Mode& mode = mode_at(index);
    const auto equal = std::span<const Mode>(modes_).subspan(index);
    uint32_t first = 0;
    while (first < index) first += as_whole<uint32_t>(modes_[first].multiplicity);
    if (first != index || equal.size() < as_size(mode.multiplicity))
        throw Error(DTTMM_ERROR_ARGUMENT,
                    fmt::format("mode {} is not the first of its frequency, or others of that were not asked for", index));
    for (ModalAnalysis* one : {this, &above, &below}) one->at_ = -1;
    std::vector<double> found(as_size(mode.multiplicity), 0.0);
    if (mode.omega != 0)
        found = dttmm::plugin::frequency_changes(stiffness_, equal.first(found.size()), above.stiffness_, below.stiffness_);
    for (double& one : found) *changes++ = one / (2 * M_PI);
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
std::vector<Response> ModalAnalysis::respond_at_rest(int free, const std::vector<Drive>& cases) {
    constexpr double kNoWork = 1e-7;    // of the force times the largest displacement: rounding of a shape is below 1e-8
    constexpr double kLowShare = 1e-3;  // ω/ω₁: leaves 1e-12, and rounding grows as its inverse square
    const std::vector<Mode> modes = ModeFinder(stiffness_).find_first(free + 1);
    const auto count = as_size(free);
    for (const Drive& drive : cases) {
        if (!drive.supports.empty())
            throw Error(
                DTTMM_ERROR_SINGULAR,
                fmt::format("0 Hz: the machine is free to move in {} direction{}: where it goes with its supports is "
                            "not determined; begin above 0 Hz",
                            free, free == 1 ? "" : "s"));
        for (size_t m = 0; m < count; ++m) {
            Complex work = 0;
            double size = 0;
            for (const PointWrench& load : drive.loads) {
                if (load.frame < 0) continue;
                const Vector6 moved =
                    FrequencyModel::at_point(load.point, model_.origin(load.frame)) * modes[m].shape[as_size(load.frame)];
                work += moved.cast<Complex>().conjugate().dot(load.wrench);
                size += load.wrench.norm();
            }
            if (std::abs(work) > kNoWork * size)
                throw Error(DTTMM_ERROR_SINGULAR,
                            fmt::format("0 Hz: the machine is free to move in {} direction{}, and the force moves it ({}): "
                                        "it accelerates for ever; hold that direction by a joint, an element or fixed = "
                                        "[..], or begin above 0 Hz",
                                        free, free == 1 ? "" : "s", describe_motion(modes[m])));
        }
    }
    stiffness_.cut(modes.front().cut);
    harmonic_.set_damping(0, nullptr);
    const double first = modes.size() > count ? modes[count].omega : 1;
    stiffness_.set(-kLowShare * kLowShare * first * first);  // for the masses alone
    std::vector<FrameVector> momenta;
    for (size_t m = 0; m < count; ++m) momenta.push_back(stiffness_.mass_times(modes[m].shape));
    std::vector<Response> responses;
    harmonic_.factor(0.5 * kLowShare * first);
    for (const Drive& drive : cases) responses.push_back(harmonic_.solve(drive));
    harmonic_.factor(kLowShare * first);
    for (size_t c = 0; c < cases.size(); ++c) {
        Response& response = responses[c] = responses[c].mixed(4.0 / 3, -1.0 / 3, harmonic_.solve(cases[c]));
        for (size_t m = 0; m < count; ++m) {
            Complex share = 0;
            for (size_t f = 0; f < response.motion.size(); ++f)
                share += momenta[m][f].cast<Complex>().dot(response.motion[f]);
            share /= modes[m].mass;
            for (size_t f = 0; f < response.motion.size(); ++f)
                response.motion[f] -= share * modes[m].shape[f].cast<Complex>();
        }
    }
    return responses;
}

/// Where the machine can move freely at rest, no place belongs to those of its supports.
void ModalAnalysis::follow_supports() {
    if (ModeFinder(stiffness_).count_rigid() > 0)
        throw Error(DTTMM_ERROR_MODEL,
                    "damping of modes is not defined where supports move a machine that they do not hold in all directions: "
                    "give the elements a damping or a loss_factor");
    stiffness_.cut(damping_->cut);
    harmonic_.follow_supports(*damping_);
}

PointWrench ModalAnalysis::placed(const dttmm_harmonic& load) const {
    if ((load.on_body < 0) == (load.on_node < 0)) throw Error(DTTMM_ERROR_ARGUMENT, "respond wants a body or a node");
    PointWrench placed;
    placed.frame = load.on_body >= 0 ? load.on_body : model_.nodes[as_size(load.on_node)].frame;
    placed.point =
        load.on_body >= 0 ? Vector3(Eigen::Map<const Vector3>(load.point)) : model_.nodes[as_size(load.on_node)].position;
    for (size_t d = 0; d < 6; ++d) placed.wrench(as_row(d)) = {load.wrench[2 * d], load.wrench[2 * d + 1]};
    return placed;
}

SupportMotion ModalAnalysis::moved(const dttmm_harmonic& load) const {
    if (load.on_node < 0) throw Error(DTTMM_ERROR_ARGUMENT, "a support is a node");
    SupportMotion support{load.on_node, Complex6::Zero()};
    const uint32_t fixed = model_.fixed[as_size(load.on_node)];
    for (size_t d = 0; d < 6; ++d)
        if ((fixed >> d & 1) != 0) support.motion(as_row(d)) = {load.wrench[2 * d], load.wrench[2 * d + 1]};
    return support;
}

std::vector<Drive> ModalAnalysis::drives(std::span<const std::span<const dttmm_harmonic>> cases) const {
    std::vector<Drive> loads(cases.size());
    for (size_t c = 0; c < cases.size(); ++c)
        for (const dttmm_harmonic& load : cases[c])
            if (load.is_motion)
                loads[c].supports.push_back(moved(load));
            else
                loads[c].loads.push_back(placed(load));
    return loads;
}

void ModalAnalysis::respond_beside(ModalAnalysis& middle, double frequency,
                                   std::span<const std::span<const dttmm_harmonic>> cases,
                                   const dttmm_harmonic_result& result) {
    if (!(frequency >= 0) || !std::isfinite(frequency)) throw Error(DTTMM_ERROR_ARGUMENT, "a frequency must be finite");
    if (!ratios_.ratios.empty() || !middle.ratios_.ratios.empty())
        throw Error(DTTMM_ERROR_ARGUMENT, "with damping of modes it is not known how a response changes");
    if (frequency == 0 && ModeFinder(middle.stiffness_).count_rigid() > 0)
        throw Error(DTTMM_ERROR_ARGUMENT,
                    "0 Hz: of a machine that is free to move it is not known how its response changes");
    middle.cut_and_damp(2 * M_PI * frequency, 0);
    middle.harmonic_.factor(2 * M_PI * frequency);
    stiffness_.cut_like(middle.stiffness_);
    harmonic_.set_damping(mass_rate_, nullptr);
    harmonic_.lean_on(middle.harmonic_);
    at_ = middle.at_ = -1;
    const std::vector<Drive> loads = drives(cases);
    for (size_t c = 0; c < cases.size(); ++c) write(harmonic_.solve(loads[c]), c, result);
}

void ModalAnalysis::respond(double frequency, std::span<const std::span<const dttmm_harmonic>> cases,
                            const dttmm_harmonic_result& result) {
    if (!(frequency >= 0) || !std::isfinite(frequency)) throw Error(DTTMM_ERROR_ARGUMENT, "a frequency must be finite");
    const std::vector<Drive> loads = drives(cases);
    const double omega = 2 * M_PI * frequency;
    const int free = frequency == 0 ? ModeFinder(stiffness_).count_rigid() : 0;
    if ((!model_.levers.empty() || model_.is_at_rest) && !is_stable_) ModeFinder(stiffness_).refuse_growing();
    is_stable_ = true;
    const bool moves_supports = std::ranges::any_of(loads, [](const Drive& drive) { return !drive.supports.empty(); });
    cut_and_damp(omega, ratios_.below);  // but for damping, here pieces only keep numbers small
    if (moves_supports && damping_ && damping_->followed.empty()) follow_supports();
    at_ = -1;
    if (free > 0) {
        const std::vector<Response> responses = respond_at_rest(free, loads);
        for (size_t c = 0; c < cases.size(); ++c) write(responses[c], c, result);
        return;
    }
    harmonic_.factor(omega);
    for (size_t c = 0; c < cases.size(); ++c) write(harmonic_.solve(loads[c]), c, result);
}

void ModalAnalysis::write(const Response& response, size_t index, const dttmm_harmonic_result& result) const {
    // One place of a list of `count`, of this case
    const auto write = [&](const Complex6& u, double* list, size_t count, size_t place, size_t half = 0, size_t halves = 1) {
        double* const out = list + 12 * (halves * (index * count + place) + half);
        for (Eigen::Index d = 0; d < 6; ++d) {
            out[2 * d] = u(d).real();
            out[2 * d + 1] = u(d).imag();
        }
    };
    for (size_t b = 0; result.bodies && b < model_.centres.size(); ++b)
        write(model_.by_centre(as_int(b)).cast<Complex>() * response.motion[b], result.bodies, model_.centres.size(), b);
    for (size_t n = 0; result.nodes && n < model_.nodes.size(); ++n) {
        const int f = model_.nodes[n].frame;
        const Complex6 held = response.supports.empty() ? Complex6(Complex6::Zero()) : response.supports[n];
        write(f < 0 ? held : Complex6(model_.by_node(n).cast<Complex>() * response.motion[as_size(f)]), result.nodes,
              model_.nodes.size(), n);
    }
    const CarriedForces forces = harmonic_.forces(response);
    for (size_t e = 0; result.elements && e < model_.element_count; ++e) {
        const Carried carried = forces.of_element(e);
        write(carried.force, result.elements, model_.element_count, e, 0, 2);
        write(carried.deflection, result.elements, model_.element_count, e, 1, 2);
    }
    for (size_t c = 0; result.constraints && c < model_.constraints.size(); ++c)
        write(forces.on_first(c), result.constraints, model_.constraints.size(), c);
}

}  // namespace dttmm::plugin
