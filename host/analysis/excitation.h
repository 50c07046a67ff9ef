// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/modal_machine.h"

namespace dttmm::host {

/// A frequency at which a machine vibrates, and how the loads come to it.
struct OperatingPoint {
    double frequency = 0;         ///< [Hz]
    std::optional<double> speed;  ///< of a row over speed: loads of `order` act [rad/s]
    double order = 0;
    bool has_own = false;  ///< loads that have this very frequency of their own act too
};

/// What drives a machine in steady vibration: unit forces, moments and motions of supports one at a time, or the loads and
/// supports of its model.
class Excitation {
public:
    /// A place and a direction.
    struct Input {
        std::string text;  ///< as asked for, "plate.corner1.z"
        const ModalPlace* place;
        int direction;
        bool turns() const { return direction >= 3; }
        /// A node that is fixed in this direction moves by 1 m or 1 rad.
        bool is_motion() const { return place->is_held(direction); }
    };

    /// Unit inputs. The machine must outlive it.
    explicit Excitation(std::vector<Input> inputs) : inputs_(std::move(inputs)) {}
    /// The harmonic and random loads of the model. Model and machine must outlive it. Throws Error(model_invalid), with
    /// place and cure, for loads of which no response is known.
    Excitation(const Model& model, const ModalMachine& machine);

    const std::vector<Input>& inputs() const { return inputs_; }
    bool is_by_inputs() const { return !inputs_.empty(); }
    /// Whether a load acts at every frequency that is asked for.
    bool acts_everywhere() const;
    bool has_others_than_orders() const;
    /// The own frequencies of loads, ascending [Hz]. Throws Error(model_invalid) for an order without speed.
    std::vector<double> own_frequencies() const;
    /// The orders of loads, ascending.
    std::vector<double> orders() const;
    bool has_harmonics() const { return !harmonics_.empty(); }
    size_t random_count() const { return randoms_.size(); }
    /// Density of a random load [N²/Hz, (N m)²/Hz] or motion [m²/Hz, rad²/Hz] on the side where the frequency `inside` lies.
    double density(size_t random, double frequency, double inside) const;
    /// Frequencies at which densities begin, bend or end.
    std::vector<double> random_corners() const;
    /// Where random loads act: the lowest and the highest frequency.
    std::pair<double, double> random_range() const;

    /// Each input; or what of the harmonic loads acts, together, where there are any, then each random load of unit
    /// amplitude. Throws Error(numerical_failure) for an amplitude that is not finite.
    std::vector<ModalInstance::Loads> cases(const OperatingPoint& at) const;

private:
    /// A load or a support of the model; its wrench or motion per unit of its signal.
    struct Placed {
        const Signal* signal;
        dttmm_harmonic unit;
        std::string name;  ///< "model.toml:7:1: load"
    };
    static double speed_of(const Placed& placed);
    void add(const Signal& signal, const dttmm_harmonic& unit, const std::string& name);
    std::vector<Input> inputs_;
    std::vector<Placed> harmonics_, randoms_;
};

}  // namespace dttmm::host
