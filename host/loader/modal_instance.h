// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loader/guarded_array.h"
#include "loader/network_instance.h"

namespace dttmm::host {

/// The small vibrations of a machine inside a plugin: the C interface as a C++ object. Arguments and units are those of
/// dttmm_modal.h; failures become NetworkError as with NetworkInstance.
class ModalInstance {
public:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Complex6 = Eigen::Matrix<std::complex<double>, 6, 1>;
    struct Mode {
        dttmm_mode numbers{};
        std::vector<Vector6> bodies, nodes;  ///< shape
        std::vector<double> shares;          ///< of the strain energy, of every element
    };
    /// Of one case of loads. Arguments and units are those of dttmm_response.h.
    struct Response {
        std::vector<Complex6> bodies, nodes;
        std::vector<Complex6> forces, deflections;  ///< of the elements, and
        std::vector<Complex6> constraints;          ///< these: where they are asked for
    };
    using Loads = std::vector<dttmm_harmonic>;

    /// Throws Error(plugin_failure) if the plugin knows no modes.
    ModalInstance(const PluginLibrary& plugin, const dttmm_modal_model& model);
    ModalInstance(ModalInstance&&) noexcept = default;
    ~ModalInstance();

    /// All up to `below` [Hz], or if that is 0 the first `count`; how many there are.
    uint32_t find_modes(uint32_t count, double below);
    Mode mode(uint32_t index);
    /// See dttmm_response.h. False for all where the plugin knows no response.
    bool is_axial(uint32_t element) const;

    /// With damping, x e^(st).
    struct Damped {
        std::complex<double> s;               ///< [1/s]
        double correction = 0;                ///< what another step of Newton's method changes, as share of |s|
        std::vector<Complex6> bodies, nodes;  ///< shape
    };
    /// All whose |s| is at most 2π `below` [Hz]. is_proved: see dttmm_response.h. Throws Error(plugin_failure) if the plugin
    /// knows none.
    /// See dttmm_response.h.
    void set_damping(double mass_rate, const std::vector<double>& ratios, double below);
    std::vector<Damped> find_damped(double below, int32_t& is_proved);
    /// Shares of its strain energy by direction of the axes of every element; none: the plugin does not tell.
    std::vector<Vector6> strain_directions(uint32_t index);
    /// See dttmm_derivative.h: of the mode `first` and those equal to it. Throws Error(plugin_failure) if the plugin does
    /// not tell.
    std::vector<double> frequency_changes(uint32_t first, uint32_t multiplicity, ModalInstance& above, ModalInstance& below);
    /// Displacements at `count` stations of an element, ends included; none if it is no line. length: of it [m].
    std::vector<Vector6> along(uint32_t index, uint32_t element, uint32_t count, double& length);
    /// How the overall transfer equation is laid out, and what it is at a frequency.
    std::string layout();
    dttmm_overall overall(double frequency);
    /// Its matrix, what is known struck out, and what its rows and columns are: names and units. Throws
    /// Error(plugin_failure) if the plugin does not write it out.
    struct OverallMatrix {
        using Names = std::vector<std::pair<std::string, std::string>>;
        Eigen::MatrixXd U;
        Names rows, columns;
    };
    OverallMatrix overall_matrix(double frequency);
    /// Under several cases of loads, each alone. Throws Error(plugin_failure) if the plugin knows no response.
    std::vector<Response> respond(double frequency, const std::vector<Loads>& cases, bool with_forces = false);
    /// From now on respond() is linear about another, which must live on: see dttmm_derivative.h. Throws
    /// Error(plugin_failure) if the plugin cannot do that.
    void respond_beside(ModalInstance& middle);

    /// Of an element at the start, where its stiffness counts [N]; 0: none.
    double force_at_start(uint32_t element) const;
    /// Motions that grow; slack as in dttmm_modal.h. Throws Error(plugin_failure) if the plugin does not count them.
    uint32_t count_growing(int slack);
    /// Motions that nothing holds; nothing: the plugin does not count them.
    std::optional<uint32_t> count_free();
    /// See dttmm_modal.h.
    double bent_at_rest(uint32_t element, bool& is_lumped) const;

private:
    /// Calls the plugin. Throws what it says of a failure, or what it throws, or that it changed the arithmetic.
    template <class Action>
    void ask(Action&& action) const;
    void check(dttmm_status status, const dttmm_error& error) const;
    void check(const GuardedArray& array, const char* name) const;
    [[noreturn]] void blame(const std::string& text) const;

    PluginLibrary plugin_;
    const dttmm_modal_table* table_;
    std::unique_ptr<dttmm_modal, void (*)(dttmm_modal*)> modal_;
    std::vector<std::string> element_names_;
    /// The element that the plugin works on: it writes here in calls that change nothing else, so mutable.
    mutable volatile int32_t at_work_ = -1;
    size_t body_count_, node_count_, constraint_count_;
    ModalInstance* middle_ = nullptr;  ///< that responses are linear about; null: none
};

}  // namespace dttmm::host
