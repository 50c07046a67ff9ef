// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dttmm_response.h"
#include "modal/damped_modes.h"
#include "modal/mode_finder.h"
#include "modal/overall_transfer.h"
#include "modal/response.h"

namespace dttmm::plugin {

/// Small vibrations of a machine, as the C interface asks for them.
class ModalAnalysis {
public:
    /// rest: of the elements of model.rest, if it has one.
    explicit ModalAnalysis(const dttmm_modal_model& model, const AtRest* rest = nullptr);

    /// See dttmm_plugin.find_modes. Throws Error(DTTMM_ERROR_MODEL) where nothing is elastic.
    size_t find_modes(uint32_t count, double below);
    /// See dttmm_plugin.mode and mode_along. Throw Error(DTTMM_ERROR_ARGUMENT) for an index that is no mode.
    void mode(uint32_t index, dttmm_mode* mode, double* bodies, double* nodes, double* shares);
    bool is_axial(uint32_t element) const { return element < model_.are_axial.size() && model_.are_axial[element]; }
    /// See dttmm_response.h; below [Hz]. Throws Error(DTTMM_ERROR_ARGUMENT) for numbers that are negative or not finite.
    void set_damping(double mass_rate, std::span<const double> ratios, double below);
    /// See dttmm_response.h. Throw what DampedModes does, and Error(DTTMM_ERROR_ARGUMENT) for an index that is no mode.
    DampedModes::Count find_damped(double below);
    void damped_mode(uint32_t index, dttmm_damped_mode* mode, double* bodies, double* nodes) const;
    /// Throws the same.
    void strain_directions(uint32_t index, double* shares);
    /// See dttmm_derivative.h.
    void frequency_changes(uint32_t index, ModalAnalysis& above, ModalAnalysis& below, double* changes);
    double along(uint32_t index, uint32_t element, uint32_t count, double* shape);
    /// See dttmm_plugin.overall. Throws Error(DTTMM_ERROR_NUMERIC) where the paths are too long for it.
    OverallTransfer::Check overall(double frequency);
    /// Throws the same.
    OverallTransfer::Written overall_matrix(double frequency) const;
    const OverallTransfer& topology();
    /// See dttmm_response.h; frequency [Hz]. Throws Error(DTTMM_ERROR_SINGULAR) where nothing bounds the response: at 0 Hz
    /// where a machine that is free to move is moved as a whole. Of one that is not moved, the response is the limit of low
    /// frequencies, to 1e-9 of itself.
    void respond(double frequency, std::span<const std::span<const dttmm_harmonic>> cases,
                 const dttmm_harmonic_result& result);
    /// See dttmm_derivative.h. Throws Error(DTTMM_ERROR_ARGUMENT) for damping of modes, and at 0 Hz where a machine is free.
    void respond_beside(ModalAnalysis& middle, double frequency, std::span<const std::span<const dttmm_harmonic>> cases,
                        const dttmm_harmonic_result& result);

    /// See dttmm_modal.h.
    int count_growing(int slack) { return counter_.count_growing(slack); }
    int count_free() { return counter_.count_free(); }
    double bent_at_rest(size_t element, bool& is_lumped) const;
    double force_at_start(size_t element) const { return model_.force_at_start(element); }

private:
    /// Where paths are short enough for products of transfer matrices; these know no forces at rest.
    void require_overall() const;
    bool has_overall() const { return !model_.is_at_rest && model_.pins.empty() && topology_->is_short(); }
    void cut_and_damp(double cut, double modes_below);
    std::vector<Response> respond_at_rest(int free, const std::vector<Drive>& cases);
    std::vector<Drive> drives(std::span<const std::span<const dttmm_harmonic>> cases) const;
    PointWrench placed(const dttmm_harmonic& load) const;
    SupportMotion moved(const dttmm_harmonic& load) const;
    void follow_supports();
    void write(const Response& response, size_t index, const dttmm_harmonic_result& result) const;
    std::string describe_motion(const Mode& mode) const;
    const Mode& mode_at(uint32_t index) const;
    double overall_residual(const Mode& mode) const;

    FrequencyModel model_;
    DynamicStiffness stiffness_;
    ModeFinder counter_{stiffness_};  ///< kept: what it finds out about slow motions serves both counts
    HarmonicSolver harmonic_;
    double mass_rate_ = 0;
    DampingRatios ratios_;                 ///< of modes, below: as asked for
    std::optional<ModalDamping> damping_;  ///< of the modes below damped_below_
    double damped_below_ = 0;
    std::vector<DampedMode> damped_;
    std::optional<OverallTransfer> topology_;  ///< set from the start, but of a machine at rest by topology()
    std::vector<Mode> modes_;
    bool is_stable_ = false;  ///< it was found that nothing grows
    long at_ = -1;            ///< mode that the model stands at; −1: none
};

}  // namespace dttmm::plugin
