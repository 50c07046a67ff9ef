// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// What the measurement is, beside the model: a sensor shows gains · gain times the true value, `delay` too late, by a clock
/// of which one second takes `clock` true seconds.
struct MeasurementFactors {
    double gain = 1, delay = 0, clock = 1;
    std::vector<double> gains;  ///< by the channels of the measurement; empty: 1
};

/// A number that is sought.
struct Unknown {
    enum class Of : unsigned char { parameter, stiffness, damping, gain, channel_gain, delay, clock };
    Of of = Of::parameter;
    std::string name;                      ///< "k1", "bolt1.stiffness", "gain", "gain(plate.corner1.acceleration.z)"
    std::string unit = "1";                ///< SI; "1" for a factor
    double start = 1;                      ///< [unit]
    double low = 0, high = 0;              ///< [unit]
    std::string element = {};              ///< of stiffness and damping: its name
    std::vector<std::string> shared = {};  ///< elements with this factor in common; empty: `element` alone
    size_t channel = 0;                    ///< of channel_gain

    /// Its logarithm counts; else its distance from the start.
    bool is_logarithmic() const { return low > 0; }
    /// Of a value, without unit: its logarithm, or its distance from the start per half of the range.
    double coordinate(double value) const;
    double value(double coordinate) const;
    /// d value/d coordinate.
    double slope(double coordinate) const { return is_logarithmic() ? value(coordinate) : 0.5 * (high - low); }
};

/// All numbers that are sought; their vectors hold coordinates.
class Unknowns {
public:
    Unknowns() = default;
    /// As --free, --bounds and --nuisance say. channels: of the measurement, for gains. Throws Error(usage) for a name that
    /// is none, a name that is there twice, bounds that are equal, reversed, or leave out the file's value.
    Unknowns(const Request& request, const Model& model, const ElementCatalogue& catalogue,
             const std::vector<std::string>& channels);

    size_t size() const { return all_.size(); }
    const Unknown& operator[](size_t i) const { return all_[i]; }
    const std::vector<Unknown>& all() const { return all_; }
    void add(Unknown unknown) { all_.push_back(std::move(unknown)); }

    Eigen::VectorXd start() const;
    Eigen::VectorXd low() const;
    Eigen::VectorXd high() const;
    /// Puts the values into what a model is read with.
    void apply(const Eigen::VectorXd& x, ModelOverrides& overrides) const;
    MeasurementFactors factors(const Eigen::VectorXd& x) const;
    /// "k1 = 412.3 N/mm" is not said: SI, "k1 = 412300 N/m".
    std::string describe(size_t i, double coordinate) const;

private:
    void add_free(const std::string& text, const Model& model, const ElementCatalogue& catalogue);
    void add_parameter(const Parameter& parameter);
    void add_element(const std::string& pattern, Unknown::Of of, const Model& model, const ElementCatalogue& catalogue);
    void add_nuisance(const std::string& text, const std::vector<std::string>& channels);
    void set_bounds(const std::string& text, const std::vector<Parameter>& parameters);
    void add_once(Unknown unknown);

    std::vector<Unknown> all_;
};

/// A range of --bounds, "0.1..10" or "100 N/mm..900 N/mm": the two texts. Throws Error(usage), with `option` before it.
std::pair<std::string, std::string> split_range(const std::string& text, const std::string& option);

}  // namespace dttmm::host
